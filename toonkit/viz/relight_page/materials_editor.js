// The materials of the drawing: shown over it, one swatch each, merged into each other and painted.

const DRAG_PIXELS = 6  // from which on a press on a swatch drags it
const ICONS = Object.fromEntries(Object.entries({
  brush: "M20 4 11.5 12.5M9 12.5a3.5 3.5 0 0 1 2.5 5C10 20.5 6.5 21 3 19.5c2-1 1.5-3 2.2-4.8C5.8 13.2 7.5 12.3 9 12.5z",
  merge: "M5 4l7 7 7-7M12 11v9M8 16.5l4 3.5 4-3.5",
  undo: "M8 4 3 9l5 5M3 9h11a5.5 5.5 0 0 1 0 11h-4",
  redo: "M16 4l5 5-5 5M21 9H10a5.5 5.5 0 0 0 0 11h4",
}).map(([name, path]) => [name, `<svg viewBox="0 0 24 24"><path d="${path}"/></svg>`]))
const HINTS = {
  none: "Click a part that is wrong", chosen: "Merge it, or paint more of it", merge: "Now click what it belongs to",
  brush: "Paint what belongs to it", fresh: "Paint the new material",
}

// `told` is called with what the user does: select, merge, paint, recolor, undo, redo, reset; `shown` with the edited ramps, by
// number, while one of them is being changed.
function materialsEditor({root, card, stage}, told, shown) {
  const map = labelMap(stage)
  const ring = element(stage, "div", "ring")
  const panel = element(card, "div", "materials")
  const tools = element(panel, "div", "tools")
  const swatches = element(panel, "div", "swatches")
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
  hint.setAttribute("aria-live", "polite")
  let open = false, selected = -1, hovered = -1, merging = false, brushing = false
  let dragged = null, moved = false, stroke = null
  let found = new Map(), edited = new Map()  // ramps as drawn and whether they are flat; and those that are edited

  const tool = (name, text, tip, onClick) => {
    const node = element(tools, "button", name, `${ICONS[name] ?? ""}${text}`)
    ;[node.type, node.title] = ["button", tip]
    if (!text) { node.setAttribute("aria-label", tip) }
    node.addEventListener("click", onClick)
    return node
  }
  const brush = tool("brush", "Brush", "Paint with the chosen material", () => { setBrushing(!brushing) })
  const merge = tool("merge", "Merge into…", "Give all of the chosen material to another one", () => {
    ;[merging, brushing] = [!merging, false]
    update()
  })
  const size = element(tools, "input", "size")
  Object.assign(size, {type: "range", min: 1, max: 100, value: 45, title: "Size of the brush: [ and ]"})
  size.setAttribute("aria-label", "Brush size")
  element(tools, "span", "space")
  const [undo, redo] = [tool("undo", "", "Undo (Ctrl+Z)", () => told("undo")), tool("redo", "", "Redo (Ctrl+Shift+Z)", () => told("redo"))]
  const reset = tool("reset", "Reset", "Back to the materials that were found", () => told("reset"))

  const fresh = () => Math.max(-1, ...map.numbers()) + 1  // the number of a new material, as in corrections.py
  const radius = () => Math.max(0.7, (size.value / 100) ** 2 * 0.15 * map.longest)
  function setBrushing(on) {
    ;[brushing, merging, hovered] = [on, false, -1]
    if (!on && selected === fresh()) { select(-1) }
    update()
  }
  function select(number) {
    if (number === selected) { return }
    selected = number
    told("select", {material: number === fresh() ? -1 : number})
  }

  // What is shown as it is drawn, while the rest is veiled.
  function focus() {
    if (dragged) { return new Set([dragged.number, hovered].filter((number) => number >= 0)) }
    if (merging) { return new Set([selected, hovered].filter((number) => number >= 0)) }
    const one = brushing || hovered < 0 ? selected : hovered
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
    const state = merging ? "merge" : brushing ? selected === fresh() ? "fresh" : "brush" : selected >= 0 ? "chosen" : "none"
    if (hint.textContent !== HINTS[state]) { hint.textContent = HINTS[state] }
    stage.dataset.tool = brushing ? "brush" : "pick"
    size.hidden = !brushing
    merge.hidden = brushing
    brush.disabled = selected < 0
    merge.disabled = selected < 0 || map.numbers().length < 2
    brush.setAttribute("aria-pressed", brushing)
    merge.setAttribute("aria-pressed", merging)
    for (const node of swatches.children) {
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
      if (node.classList.contains("new")) { select(number); setBrushing(true) } else { choose(number) }
    })
    node.addEventListener("pointerenter", () => hover(number))
    node.addEventListener("pointerleave", () => hover(-1))
    node.addEventListener("focus", () => { rove(node); if (node.matches(":focus-visible")) { hover(number) } })
    node.addEventListener("blur", () => hover(-1))
    return node
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
    if (!merging) { select(number === selected && !brushing ? -1 : number) }
    else if (number >= 0 && number !== selected) { mergeInto(selected, number) }
    merging = false
    if (selected < 0) { brushing = false }
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
        ;[dragged, merging, brushing] = [{number: Number(node.dataset.number)}, false, false]
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
      if (into >= 0 && into !== material) { mergeInto(material, into) }
      update()
    }
    for (const [name, listener] of [["pointermove", move], ["pointerup", end], ["pointercancel", end]]) {
      window.addEventListener(name, listener)
    }
  })

  // ---- the picture: choose a material, or paint
  function follow(event) {
    const box = stage.getBoundingClientRect()
    ring.style.transform = `translate(${event.clientX - box.left}px, ${event.clientY - box.top}px) translate(-50%, -50%)`
  }
  function begin(event) {
    stage.setPointerCapture(event.pointerId)
    stroke = {path: [map.under(event)], radius: radius()}
    map.paint(stroke.path[0], stroke.path[0], stroke.radius, selected)
    update()
  }
  function go(event) {
    const [last, next] = [stroke.path.at(-1), map.under(event)]
    if (Math.hypot(next[0] - last[0], next[1] - last[1]) < Math.max(0.5, stroke.radius / 6)) { return }
    stroke.path.push(next)
    map.paint(last, next, stroke.radius, selected)
    update()
  }
  function finish() {
    const {path, radius} = stroke
    stroke = null
    map.count()
    told("paint", {path, radius, material: selected})
    told("select", {material: selected})
    fill()
    update()
  }
  stage.addEventListener("pointerdown", (event) => {
    if (!open || event.button !== 0) { return }
    event.preventDefault()
    follow(event)
    if (brushing && selected >= 0) { begin(event) } else { choose(map.at(event)) }
  })
  stage.addEventListener("pointermove", (event) => {
    if (!open) { return }
    follow(event)
    if (stroke) { go(event) } else if (!brushing) { hover(map.at(event)) }
  })
  stage.addEventListener("pointerleave", () => hover(-1))
  for (const end of ["pointerup", "pointercancel"]) { stage.addEventListener(end, () => { if (stroke) { finish() } }) }
  size.addEventListener("input", update)

  function key(event) {
    if (!open) { return }
    const letter = event.key.toLowerCase()
    const control = event.ctrlKey || event.metaKey
    if (control && (letter === "z" || letter === "y")) {
      event.preventDefault()
      if (!stroke) { (event.shiftKey || letter === "y" ? redo : undo).click() }
    } else if (letter === "escape") {
      if (merging) { merging = false } else if (brushing) { setBrushing(false) } else { select(-1) }
      update()
    } else if (brushing && (letter === "[" || letter === "]")) {
      size.value = Number(size.value) + (letter === "]" ? 5 : -5)
      update()
    }
  }
  document.addEventListener("keydown", key)

  return {
    get open() { return open },
    setOpen(on) {
      ;[open, merging, brushing, hovered] = [on, false, false, -1]
      card.classList.toggle("editing", on)
      hint.textContent = lightHint
      map.measure()
      update()
    },
    measure() {
      map.measure()
      update()
    },
    showBusy(busy) { panel.setAttribute("aria-busy", busy) },
    allow(possible) { [undo.disabled, redo.disabled, reset.disabled] = possible.map((one) => !one) },
    setSelected(number) {
      if (number >= 0 || selected !== fresh()) { selected = number }
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
      if (stroke) { stroke.path.forEach((to, k) => map.paint(stroke.path[Math.max(k - 1, 0)], to, stroke.radius, selected)) }
      if (selected >= 0 && !found.has(selected) && !(brushing && selected === fresh())) { [selected, brushing] = [-1, false] }
      fill()
      update()
    },
    remove() { document.removeEventListener("keydown", key) },
  }
}
