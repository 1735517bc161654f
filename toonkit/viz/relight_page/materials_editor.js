// The materials of the drawing: shown over it, one swatch each, merged into each other and painted.

const DRAG_PIXELS = 6  // from which on a press on a swatch drags it
const ICONS = Object.fromEntries(Object.entries({
  fill: "M10 3 3.5 9.5a2 2 0 0 0 0 2.8l5.2 5.2a2 2 0 0 0 2.8 0L18 11zM7 6l8 8M20.5 15.5s1.5 2.2 1.5 3.5a1.5 1.5 0 0 1-3 0c0-1.3 1.5-3.5 1.5-3.5z",
  split: "M4 12c0-4 3.5-7 8.5-7S21 7.5 21 11s-4 6-8.5 6c-2 0-3.5-.5-4.5-1M8 16c-1.5-1-4 0-4 1.700S6 21 7.5 20 9 17.5 8 16z",
  brush: "M20 4 11.5 12.5M9 12.5a3.5 3.5 0 0 1 2.5 5C10 20.5 6.5 21 3 19.5c2-1 1.5-3 2.2-4.8C5.8 13.2 7.5 12.3 9 12.5z",
  merge: "M5 4l7 7 7-7M12 11v9M8 16.5l4 3.5 4-3.5",
}).map(([name, path]) => [name, `<svg viewBox="0 0 24 24"><path d="${path}"/></svg>`]))
const HINTS = {
  none: "Click a part that is wrong", chosen: "Merge it, or paint more of it", merge: "Now click what it belongs to",
  brush: "Paint what belongs to it", fresh: "Paint the new material", fill: "Click a region that belongs to it",
  split: "Draw around what is another material",
}

// `told` is called with what the user does: select, merge, paint, fill, split, recolor, reset; `shown` with the edited ramps, by
// number, while one of them is being changed.
function materialsEditor({root, drawing, frame}, told, shown) {
  const {card, stage} = drawing
  const map = labelMap(stage, frame)
  const ring = element(stage, "div", "ring")
  const panel = element(card, "div", "materials")
  const tools = element(panel, "div", "tools")
  const swatches = element(panel, "div", "swatches")
  const marks = element(panel, "div", "marks")
  const lasso = element(stage, "div", "lasso", `<svg><polygon/></svg>`)
  const rampOf = (number) => edited.get(number) ?? found.get(number)?.ramp ?? null
  const ramp = rampEditor(panel, {
    shown: (next) => { edited.set(selected, next); showRamps() },
    changed: (next) => {
      if (next === null) { edited.delete(selected) }
      showRamps()
      told("recolor", {material: selected, ramp: next})
    },
  })
  const hint = card.querySelector("header p")
  const lightHint = hint.textContent
  swatches.setAttribute("role", "group")
  swatches.setAttribute("aria-label", "Materials")
  marks.setAttribute("role", "group")
  marks.setAttribute("aria-label", "Mark as")
  hint.setAttribute("aria-live", "polite")
  let open = false, selected = -1, hovered = -1, using = "pick"  // or merge, brush, fill, split
  let dragged = null, moved = false, stroke = null
  let found = new Map(), edited = new Map()  // ramps as drawn and whether they are flat; and those that are edited

  const tool = (name, text, tip, onClick) => {
    const node = element(tools, "button", name, `${ICONS[name] ?? ""}${text}`)
    ;[node.type, node.title] = ["button", tip]
    node.setAttribute("aria-label", tip.split(":")[0])
    node.addEventListener("click", onClick)
    return node
  }
  const brush = tool("brush", "", "Brush: paint with the chosen material or mark", () => use(using === "brush" ? "pick" : "brush"))
  const bucket = tool("fill", "", "Fill: give a region to the chosen material or mark", () => use(using === "fill" ? "pick" : "fill"))
  const knife = tool("split", "", "Split: draw around what is another material", () => use(using === "split" ? "pick" : "split"))
  const merge = tool("merge", "Merge", "Merge into another material: all of the chosen one", () => use(using === "merge" ? "pick" : "merge"))
  const size = element(tools, "input", "size")
  Object.assign(size, {type: "range", min: 1, max: 100, value: 45, title: "Size of the brush: [ and ]"})
  size.setAttribute("aria-label", "Brush size")
  element(tools, "span", "space")
  const reset = tool("reset", "Reset", "Reset: back to what was found", () => told("reset"))

  const fresh = () => map.fresh
  const isMaterial = (number) => number >= 0 && number < MARK && number !== fresh()
  const radius = () => Math.max(0.7, (size.value / 100) ** 2 * 0.15 * frame.longest)
  function use(next) {
    ;[using, hovered] = [next, -1]
    if (next === "pick" && !isMaterial(selected)) { select(-1) }
    update()
  }
  function select(number) {
    if (number === selected) { return }
    selected = number
    told("select", {material: isMaterial(number) ? number : -1})
  }

  // What is shown as it is drawn, while the rest is veiled.
  function focus() {
    if (dragged) { return new Set([dragged.number, hovered].filter((number) => number >= 0)) }
    if (using === "merge") { return new Set([selected, hovered].filter((number) => number >= 0)) }
    const one = ["brush", "fill"].includes(using) || hovered < 0 ? selected : hovered
    return new Set(one < 0 ? [] : [one])
  }

  let scheduled = false
  function update() {
    if (!scheduled) { scheduled = true; requestAnimationFrame(show) }
  }
  function show() {
    scheduled = false
    if (!open) { return }
    map.draw(focus())
    ramp.load(rampOf(selected), edited.has(selected))
    const state = using !== "pick" ? using === "brush" && selected === fresh() ? "fresh" : using : selected >= 0 ? "chosen" : "none"
    if (hint.textContent !== HINTS[state]) { hint.textContent = HINTS[state] }
    stage.dataset.tool = using
    size.hidden = using !== "brush"
    merge.hidden = using === "brush"
    brush.disabled = bucket.disabled = selected < 0
    merge.disabled = !isMaterial(selected) || map.numbers().length < 2
    for (const [node, name] of [[brush, "brush"], [bucket, "fill"], [knife, "split"], [merge, "merge"]]) {
      node.setAttribute("aria-pressed", using === name)
    }
    for (const node of [...swatches.children, ...marks.children]) {
      const number = Number(node.dataset.number)
      node.setAttribute("aria-pressed", number === selected)
      node.classList.toggle("hovered", number === hovered)
    }
    ring.style.width = ring.style.height = `${2 * radius() * map.scale}px`
  }

  // ---- swatches: the largest first
  function fill() {
    const areas = map.areas()
    const total = [...areas.values()].reduce((sum, area) => sum + area, 0)
    const order = [...areas.keys()].sort((one, other) => areas.get(other) - areas.get(one) || one - other)
    const focused = swatches.querySelector(":focus")?.dataset.number
    swatches.replaceChildren(...order.map((number, place) => {
      const flat = found.get(number)?.flat || edited.get(number)?.stays_flat
      const share = 100 * areas.get(number) / total
      const words = `Material ${place + 1} of ${order.length}, ${share < 1 ? "below 1" : Math.round(share)} %${flat ? ", flat" : ""}`
      return swatch(number, words, `<i style="background: ${backgroundOf(number)}"></i><b style="background: ${tint(number)}"></b>`)
    }), swatch(fresh(), "New material", "+"))
    swatches.lastChild.classList.add("new")
    rove(swatches.children[0])
    if (focused !== undefined) { swatches.querySelector(`[data-number="${focused}"]`)?.focus() }
  }
  const backgroundOf = (number) => rampOf(number) ? rampBackground(rampOf(number)) : tint(number)
  function showRamps() {
    ramp.load(rampOf(selected), edited.has(selected))
    for (const node of swatches.querySelectorAll(".swatch:not(.new) i")) {
      node.style.background = backgroundOf(Number(node.parentNode.dataset.number))
    }
    shown(edited)
  }
  function swatch(number, words, content) {
    const node = document.createElement("button")
    Object.assign(node, {type: "button", className: "swatch", title: words, innerHTML: content})
    node.dataset.number = number
    node.setAttribute("aria-label", words)
    node.addEventListener("click", () => {
      if (moved) { moved = false; return }  // let go where it was taken
      if (number >= MARK || node.classList.contains("new")) {
        select(number === selected && number >= MARK ? -1 : number)
        use(selected < 0 ? "pick" : using === "fill" ? "fill" : "brush")
      } else { choose(number) }
    })
    node.addEventListener("pointerenter", () => hover(number))
    node.addEventListener("pointerleave", () => hover(-1))
    node.addEventListener("focus", () => { rove(node); if (node.matches(":focus-visible")) { hover(number) } })
    node.addEventListener("blur", () => hover(-1))
    return node
  }
  for (const {code, name, tip, color} of MARKS) {
    const node = swatch(code, `${name}: ${tip}`, `<b style="background: rgb(${color})"></b>${name}`)
    node.classList.add("mark")
    node.setAttribute("aria-label", name)
    marks.append(node)
  }
  // Tab reaches one swatch, and the arrow keys go on from there.
  function rove(node) {
    for (const other of swatches.children) { other.tabIndex = other === node ? 0 : -1 }
  }
  swatches.addEventListener("keydown", (event) => {
    const step = {ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1}[event.key]
    const next = step && swatches.children[[...swatches.children].indexOf(event.target) + step]
    if (next) { event.preventDefault(); next.focus() }
  })
  function hover(number) {
    if (dragged || stroke || number === hovered) { return }
    hovered = number === fresh() ? -1 : number
    update()
  }
  function choose(number) {
    if (using !== "merge") { select(number === selected && using === "pick" ? -1 : number) }
    else if (number >= 0 && number < MARK && number !== selected) { mergeInto(selected, number) }
    if (using === "merge" || (selected < 0 && using !== "split")) { using = "pick" }
    update()
  }
  function mergeInto(material, into) {
    map.merge(material, into)
    told("merge", {material, into})
    select(into)
    hovered = -1
    fill()
    update()
  }

  // ---- dragging a swatch onto another one, or onto the picture
  const pressed = (event) => event.target.closest(".swatch:not(.new)")
  function below({clientX, clientY}) {
    const within = (node) => {
      const box = node.getBoundingClientRect()
      return clientX >= box.left && clientX < box.right && clientY >= box.top && clientY < box.bottom
    }
    if (within(stage)) { return map.at({clientX, clientY}) }
    const node = [...swatches.querySelectorAll(".swatch:not(.new)")].find(within)
    return node ? Number(node.dataset.number) : -1
  }
  swatches.addEventListener("pointerdown", (event) => {
    const node = event.button === 0 && event.pointerType !== "touch" && pressed(event)
    if (!node) { return }
    const from = [event.clientX, event.clientY]
    let ghost = null
    moved = false
    const move = (next) => {
      if (!ghost && Math.hypot(next.clientX - from[0], next.clientY - from[1]) < DRAG_PIXELS) { return }
      if (!ghost) {
        ;[dragged, using] = [{number: Number(node.dataset.number)}, "pick"]
        moved = true
        ghost = root.appendChild(node.cloneNode(true))
        ghost.classList.add("ghost")
      }
      const box = root.getBoundingClientRect()
      ghost.style.transform = `translate(${next.clientX - box.left}px, ${next.clientY - box.top}px)`
      hovered = below(next)
      update()
    }
    const end = (last) => {
      for (const [name, listener] of [["pointermove", move], ["pointerup", end], ["pointercancel", end]]) {
        window.removeEventListener(name, listener)
      }
      if (!ghost) { return }
      ghost.remove()
      const [material, into] = [dragged.number, last.type === "pointerup" ? below(last) : -1]
      ;[dragged, hovered] = [null, -1]
      if (into >= 0 && into < MARK && into !== material) { mergeInto(material, into) }
      update()
    }
    for (const [name, listener] of [["pointermove", move], ["pointerup", end], ["pointercancel", end]]) {
      window.addEventListener(name, listener)
    }
  })

  // ---- the picture: choose a material, or paint
  function follow(event) {
    const [x, y] = frame.onStage(stage, event)
    ring.style.transform = `translate(${x}px, ${y}px) translate(-50%, -50%)`
  }
  function begin(event) {
    if (using === "split") {
      stroke = {path: [map.under(event)], loop: true}
      return
    }
    stroke = {path: [map.under(event)], radius: radius()}
    map.paint(stroke.path[0], stroke.path[0], stroke.radius, selected)
    update()
  }
  function go(event) {
    const [last, next] = [stroke.path.at(-1), map.under(event)]
    if (stroke.loop) {
      if (Math.hypot(next[0] - last[0], next[1] - last[1]) * map.scale < 2) { return }
      stroke.path.push(next)
      lasso.querySelector("polygon").setAttribute("points", stroke.path.map((place) => map.onStage(place).join(",")).join(" "))
      return
    }
    if (Math.hypot(next[0] - last[0], next[1] - last[1]) < Math.max(0.5, stroke.radius / 6)) { return }
    stroke.path.push(next)
    map.paint(last, next, stroke.radius, selected)
    update()
  }
  function finish() {
    const {path, radius, loop} = stroke
    stroke = null
    if (loop) { cut(path); return }
    map.count()
    told("paint", {path, radius, material: selected})
    told("select", {material: selected < MARK ? selected : -1})
    fill()
    update()
  }
  function cut(path) {
    lasso.querySelector("polygon").setAttribute("points", "")
    const [material, number] = [isMaterial(selected) ? selected : -1, fresh()]
    if (path.length < 3 || !map.split(path, material, number)) { return }
    told("split", {path, material})
    ;[selected, using] = [number, "pick"]
    told("select", {material: number})
    fill()
    update()
  }
  function pour(event) {
    if (map.at(event) < 0 || map.at(event) === selected) { return }
    told("fill", {place: map.fill(event, selected), material: selected})
    map.count()
    told("select", {material: selected < MARK ? selected : -1})
    fill()
    update()
  }
  const hand = {
    patient: false,
    get doubles() { return using === "pick" },  // quick dabs of a brush are no double taps
    press(event) {
      follow(event)
      if (using === "split" || (using === "brush" && selected >= 0)) { begin(event) }
      else if (using === "fill") { pour(event) } else { choose(map.at(event)) }
    },
    move(event) { if (stroke) { go(event) } },
    release() { if (stroke) { finish() } },
  }
  stage.addEventListener("pointermove", (event) => {
    if (!open) { return }
    follow(event)
    if (!stroke && ["pick", "merge"].includes(using)) { hover(map.at(event)) }
  })
  stage.addEventListener("pointerleave", () => hover(-1))
  size.addEventListener("input", update)
  frame.follow(() => {
    map.measure()
    update()
  })

  // What a key does, and whether it does anything.
  function toggle(button) {
    if (!open || button.disabled || button.hidden) { return false }
    button.click()
    return true
  }
  function resize(by) {
    if (!open || using !== "brush") { return false }
    size.value = Number(size.value) + by
    update()
    return true
  }
  function escape() {
    if (!open) { return false }
    if (using !== "pick") { use("pick") } else { select(-1) }
    update()
    return true
  }

  return {
    get open() { return open },
    get drawing() { return stroke !== null },
    keys: {
      b: () => toggle(brush), f: () => toggle(bucket), s: () => toggle(knife), escape, "[": () => resize(-5), "]": () => resize(5),
    },
    setOpen(on) {
      if (on === open) { return }
      ;[open, using, hovered] = [on, "pick", -1]
      drawing.take(on ? hand : null)
      card.classList.toggle("editing", on)
      hint.textContent = lightHint
      map.measure()
      update()
    },
    showBusy(busy) { panel.setAttribute("aria-busy", busy) },
    allowReset(possible) { reset.disabled = !possible },
    setSelected(number) {
      if (number >= 0 || isMaterial(selected)) { selected = number }
      update()
    },
    // Takes the edited ramps, by number, unless one is being changed.
    recolor(next) {
      if (ramp.busy) { return }
      edited = next
      showRamps()
    },
    // The label map of a drawing, and what is known of its materials: the ramp of each number, and whether it is flat.
    load(width, height, labels, next) {
      map.load(width, height, labels)
      found = next
      if (stroke && !stroke.loop) { stroke.path.forEach((to, k) => map.paint(stroke.path[Math.max(k - 1, 0)], to, stroke.radius, selected)) }
      const painting = ["brush", "fill"].includes(using) && selected === fresh()
      if (selected >= 0 && selected < MARK && !found.has(selected) && !painting) { [selected, using] = [-1, "pick"] }
      fill()
      update()
    },
  }
}
