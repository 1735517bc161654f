// The shape of the drawing: parts that bulge, are flat or in front are painted, and normals dragged at points.

const TILT_REACH = 4  // distance over which a dragged normal turns others, in radii of the brush
const GRAB_PIXELS = 14  // distance from an arrow's foot within which a press grabs it
const LEAST_DRAG = 3  // shortest drag that tilts a normal, in pixels on screen
const [KEY_TILT, KEY_TILT_FAR] = [5, 15].map((degrees) => Math.sin(degrees * Math.PI / 180))
const TILT_ICON = `<svg viewBox="0 0 24 24"><path d="M4 20a8.500 8.500 0 0 1 17 0M12.500 12 18 4M13.500 4.500 18 4l1 4.500"/></svg>`
const SHAPE_HINTS = {
  none: "Choose what a part is like", brush: "Paint the whole part", fill: "Click a region", erase: "Paint to remove marks and arrows",
  tilt: "Press a point and drag to tilt it",
}

// Calls `told` with the name and the details of what the user does: shape_paint, shape_fill, shape_tilt, shape_reset.
function shapeEditor({drawing, frame}, told) {
  const {card, stage} = drawing
  const map = shapeMap(stage, frame)
  const ring = element(stage, "div", "shape-ring")
  const points = element(stage, "div", "points")
  const ball = tiltBall(stage)
  const panel = element(card, "div", "shape-panel")
  const tools = element(panel, "div", "tools")
  const kinds = element(panel, "div", "marks")
  const hint = card.querySelector("header p")
  const lightHint = hint.textContent
  let open = false, kind = null, using = "none"  // or brush, fill, tilt
  let stroke = null, drag = null, hints = [], keyed = null

  const tool = (name, icon, tip, onClick) => {
    const node = element(tools, "button", name, icon)
    ;[node.type, node.title] = ["button", tip]
    node.setAttribute("aria-label", tip.split(":")[0])
    node.addEventListener("click", onClick)
    return node
  }
  const brush = tool("brush", ICONS.brush, "Brush: paint the chosen kind of part", () => use(using === "brush" ? "none" : "brush"))
  const bucket = tool("fill", ICONS.fill, "Fill: mark a region of one material", () => use(using === "fill" ? "none" : "fill"))
  const tilt = tool("tilt", `${TILT_ICON}Tilt`, "Tilt: drag the normal at a point", () => use(using === "tilt" ? "none" : "tilt"))
  const size = element(tools, "input", "size")
  Object.assign(size, {type: "range", min: 1, max: 100, value: 45, title: "Size of the brush, and how far a tilt reaches: [ and ]"})
  size.setAttribute("aria-label", "Brush size")
  element(tools, "span", "space")
  const reset = tool("reset", "Reset", "Reset: remove all corrections of the shape", () => told("shape_reset"))
  kinds.setAttribute("role", "group")
  kinds.setAttribute("aria-label", "The part is")
  const kindButtons = SHAPE_PARTS.map((part) => {
    const node = element(kinds, "button", "swatch mark", `<b style="background: rgb(${part.color})"></b>${part.name}`)
    ;[node.type, node.title] = ["button", `${part.name}: ${part.tip}`]
    node.setAttribute("aria-label", part.name)
    node.addEventListener("click", () => choose(part))
    return node
  })
  const shownBox = element(panel, "label", "stays", `<input type="checkbox" checked>Show the normals`).firstChild
  shownBox.addEventListener("change", () => map.showNormals(shownBox.checked))
  element(panel, "p", "remark", "The surface follows your corrections as far as the painted tones allow.")

  const radius = () => Math.max(0.7, (size.value / 100) ** 2 * 0.15 * frame.longest)
  const reach = () => TILT_REACH * radius()
  function use(next) {
    using = next
    if (next === "tilt" || next === "none") { kind = null }
    update()
  }
  function choose(part) {
    ;[kind, using] = kind === part ? [null, "none"] : [part, using === "fill" ? "fill" : "brush"]
    update()
  }

  let scheduled = false
  function update() {
    if (!scheduled) { scheduled = true; requestAnimationFrame(show) }
  }
  function show() {
    scheduled = false
    if (!open) { return }
    map.lie()
    const words = SHAPE_HINTS[using === "brush" && kind.bit === 0 ? "erase" : using]
    if (hint.textContent !== words) { hint.textContent = words }
    stage.dataset.tool = using
    brush.disabled = bucket.disabled = kind === null
    size.hidden = !["brush", "tilt"].includes(using)
    reset.disabled = hints.length === 0 && !map.hasMarks
    for (const [node, name] of [[brush, "brush"], [bucket, "fill"], [tilt, "tilt"]]) { node.setAttribute("aria-pressed", using === name) }
    kindButtons.forEach((node, place) => node.setAttribute("aria-pressed", SHAPE_PARTS[place] === kind))
    const wide = 2 * (using === "tilt" ? drag?.radius ?? reach() : radius()) * map.scale
    ring.style.width = ring.style.height = `${wide}px`
    hints.forEach(({row, column, normal}, place) => {
      const [left, top] = map.onStage([column + 0.5, row + 0.5])
      const node = points.children[place]
      node.style.transform = `translate(${left}px, ${top}px)`
      Object.assign(node.firstChild.style, {
        width: `${30 * Math.hypot(normal[0], normal[1])}px`, transform: `rotate(${Math.atan2(-normal[1], normal[0])}rad)`,
      })
      node.setAttribute("aria-label", `Normal ${place + 1} of ${hints.length}: ${spokenNormal(normal)}; arrow keys tilt it, Delete removes it`)
    })
  }

  // ---- normals at points
  function fillPoints() {
    const focused = [...points.children].indexOf(points.querySelector(":focus"))
    points.replaceChildren(...hints.map(() => {
      const node = document.createElement("button")
      Object.assign(node, {type: "button", className: "point", innerHTML: "<i></i>"})
      return node
    }))
    points.children[focused]?.focus()
  }
  points.addEventListener("keydown", (event) => {
    const which = [...points.children].indexOf(event.target)
    if (which < 0 || event.ctrlKey || event.metaKey || event.altKey) { return }
    const way = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[event.key]
    const own = hints[which]
    if (["Delete", "Backspace"].includes(event.key)) {
      clearTimeout(keyed)
      ask(own, null, which)
      hints.splice(which, 1)
      fillPoints()
    } else if (way) {
      const step = event.shiftKey ? KEY_TILT_FAR : KEY_TILT
      hints[which] = {...own, normal: normalOf(own.normal[0] + step * way[0], own.normal[1] + step * way[1])}
      clearTimeout(keyed)
      keyed = setTimeout(() => ask(hints[which], hints[which].normal, which), KEY_MS)
    } else { return }
    event.preventDefault()
    update()
  })
  const ask = ({row, column, radius: far}, normal, which) => {
    keyed = null
    told("shape_tilt", {place: [column + 0.5, row + 0.5], normal, radius: far, which})
  }
  function takeHold(event) {
    const at = frame.onStage(stage, event)
    const away = hints.map(({row, column}) => {
      const [x, y] = map.onStage([column + 0.5, row + 0.5])
      return Math.hypot(x - at[0], y - at[1])
    })
    const which = away.findIndex((far) => far < GRAB_PIXELS && far === Math.min(...away))
    const [x, y] = map.under(event)
    const found = which >= 0 ? hints[which] : {row: Math.floor(y), column: Math.floor(x), normal: map.normalAt([x, y]), radius: reach()}
    if (found.normal === null) { return }
    // The tip of the arrow on the ball lies under the pointer.
    const middle = [at[0] - TILT_BALL_PIXELS * found.normal[0], at[1] + TILT_BALL_PIXELS * found.normal[1]]
    drag = {...found, which, middle, from: at, moved: false}
    ball.show(middle, found.normal)
    update()
  }
  function turn(event) {
    const [x, y] = frame.onStage(stage, event)
    drag.moved ||= Math.hypot(x - drag.from[0], y - drag.from[1]) >= LEAST_DRAG
    drag.normal = normalOf((x - drag.middle[0]) / TILT_BALL_PIXELS, (drag.middle[1] - y) / TILT_BALL_PIXELS)
    ball.show(drag.middle, drag.normal)
  }
  function letGo() {
    const {which, moved, row, column, normal, radius: far} = drag
    drag = null
    ball.hide()
    if (!moved) { return }
    const own = {row, column, normal, radius: far}
    if (which >= 0) { hints[which] = own } else { hints.push(own) }
    fillPoints()
    ask(own, normal, which)
    update()
  }

  // ---- the picture
  function follow(event) {
    if (drag) { return }  // the ring stays around the point
    const [x, y] = frame.onStage(stage, event)
    ring.style.transform = `translate(${x}px, ${y}px) translate(-50%, -50%)`
  }
  function begin(event) {
    const place = map.under(event)
    stroke = {path: [place], radius: radius(), kind}
    map.paint(place, place, stroke.radius, kind.bit)
  }
  function go(event) {
    const [last, next] = [stroke.path.at(-1), map.under(event)]
    if (Math.hypot(next[0] - last[0], next[1] - last[1]) < Math.max(0.5, stroke.radius / 6)) { return }
    stroke.path.push(next)
    map.paint(last, next, stroke.radius, stroke.kind.bit)
  }
  function finish() {
    const {path, radius: wide, kind: {kind: name}} = stroke
    stroke = null
    told("shape_paint", {path, radius: wide, kind: name})
    update()
  }
  const hand = {
    patient: false,
    get doubles() { return using === "none" },
    press(event) {
      follow(event)
      if (using === "brush") { begin(event) }
      else if (using === "tilt") { takeHold(event) }
      else if (using === "fill" && map.normalAt(map.under(event))) { told("shape_fill", {place: map.under(event), kind: kind.kind}) }
    },
    move(event) { if (stroke) { go(event) } else if (drag) { turn(event) } },
    release() { if (stroke) { finish() } else if (drag) { letGo() } },
  }
  stage.addEventListener("pointermove", (event) => { if (open) { follow(event) } })
  size.addEventListener("input", update)
  frame.follow(update)

  function toggle(button) {
    if (!open || button.disabled || button.hidden) { return false }
    button.click()
    return true
  }
  function resize(by) {
    if (!open || size.hidden) { return false }
    size.value = Number(size.value) + by
    update()
    return true
  }
  function escape() {
    if (!open || using === "none") { return false }
    use("none")
    return true
  }

  return {
    get open() { return open },
    get drawing() { return stroke !== null || drag !== null },
    keys: {
      b: () => toggle(brush), f: () => toggle(bucket), d: () => toggle(tilt), escape, "[": () => resize(-5), "]": () => resize(5),
    },
    setOpen(on) {
      if (on === open) { return }
      ;[open, using, kind] = [on, "none", null]
      drawing.take(on ? hand : null)
      card.classList.toggle("shaping", on)
      hint.textContent = lightHint
      update()
    },
    showBusy(busy) { panel.setAttribute("aria-busy", busy) },
    // The normals of a drawing, and what is said about its shape: bits of each pixel, and normals at points.
    load(width, height, normals, marks, said) {
      hints = said.map(({row, column, normal, radius: far}) => ({row, column, normal: [...normal], radius: far}))
      map.load(width, height, normals, marks)
      if (stroke) { stroke.path.forEach((to, k) => map.paint(stroke.path[Math.max(k - 1, 0)], to, stroke.radius, stroke.kind.bit)) }
      fillPoints()
      update()
    },
  }
}
