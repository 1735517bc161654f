// The relight view: a drawing beside its relit picture, each with a light that is set by dragging.
//
// Import-free, so that the same module serves Panel and a notebook without a network: view.py puts the other files first.

const NARROW_PIXELS = 600  // width of a window up to which the sidebar of the page lies over it

const UNDO = `<svg viewBox="0 0 24 24"><path d="M8 4 3 9l5 5M3 9h11a5.5 5.5 0 0 1 0 11h-4"/></svg>`
const REDO = `<svg viewBox="0 0 24 24"><path d="M16 4l5 5-5 5M21 9H10a5.5 5.5 0 0 0 0 11h4"/></svg>`

function showImage(image, data) {
  if (image.src) { URL.revokeObjectURL(image.src) }
  image.src = data.length ? URL.createObjectURL(new Blob([data], {type: "image/png"})) : ""
}

function render({model}) {
  const root = document.createElement("div")
  root.className = "relight"
  const style = element(root, "style", "")
  style.textContent = STYLE + SHAPE_STYLE
  let original = [...model.original_light], light = [...model.new_light]
  let scheduled = false, originalMoved = true, lastSent = 0, timer = null
  const frame = pictureFrame()

  // ---- light: drawn at once, told to Python at most ten times a second
  function send() {
    clearTimeout(timer)
    timer = null
    lastSent = performance.now()
    ;[undo.disabled, redo.disabled] = [false, true]
    model.new_light = [...light]
  }
  function move(next) {
    light = next
    schedule()
    if (timer === null) { timer = setTimeout(send, Math.max(0, lastSent + SEND_EVERY_MS - performance.now())) }
  }
  const drawing = lightCard(root, {
    name: "original", title: "Your drawing", hint: "Drag the artist's light to its place", angles: original, frame,
    onMove: (next) => { original = next; scheduleAll() },
    // A new original light means a new analysis: only asked for when the hand lets go.
    onRelease: () => { model.original_light = [...original] },
  })
  const relit = lightCard(root, {
    name: "relit", title: "Relit", hint: "Drag the picture or the ball to move the light", angles: light, frame,
    onMove: (next) => { halt(); move(next) },
    onRelease: send,
  })
  drawing.button("Estimate", "Estimate the light from the drawing", () => model.send_msg({action: "estimate"}))
  const circle = orbit(relit, () => light, (next) => { path.stop(); move(next) }, send)
  relit.button("Reset to original", "Put the light back where the artist had it", () => {
    halt()
    move([...original])
    send()
  })
  function halt() {
    circle.stop()
    path.stop()
  }

  // ---- undo and redo, of the light as well
  function travel(button, action) {
    if (editor.drawing || shaper.drawing) { return false }
    halt()
    for (const card of [drawing, relit]) { card.settle() }  // a key that is let go of later would move the light again
    if (timer !== null) { send() }  // what was moved a moment ago can be undone, too
    if (button.disabled) { return false }
    ask(action)
    return true
  }
  const icons = element(relit.card.querySelector("header"), "div", "icons")
  const split = splitSlider(relit, icons)
  const [undo, redo] = [
    [UNDO, "Undo", "Undo (Ctrl+Z)", () => travel(undo, "undo")], [REDO, "Redo", "Redo (Ctrl+Shift+Z)", () => travel(redo, "redo")],
    ["?", "Keyboard shortcuts", "Keyboard shortcuts (?)", () => keys.show()],
  ].map(([content, words, tip, onClick]) => {
    const node = element(icons, "button", "", content)
    Object.assign(node, {type: "button", title: tip})
    node.setAttribute("aria-label", words)
    node.addEventListener("click", onClick)
    return node
  })

  // ---- materials
  let pending = 0, settled = model.settled
  function ask(action, details = {}) {
    pending += 1
    for (const part of [editor, shaper]) { part.showBusy(true) }
    if (!["undo", "redo"].includes(action)) {
      ;[undo.disabled, redo.disabled] = [false, true]
      if (!action.startsWith("shape_")) { editor.allowReset(action !== "reset") }
    }
    model.send_msg({action, ...details})
  }
  const editor = materialsEditor({root, drawing, frame}, (action, details = {}) => {
    if (action !== "select") { ask(action, details) }
    else if (model.selected !== details.material) { model.selected = details.material }
  }, recolor)
  const shaper = shapeEditor({drawing, frame}, ask)
  const modes = element(drawing.card.querySelector("header"), "div", "modes")
  const modeButtons = [["Light", null], ["Materials", editor], ["Shape", shaper]].map(([text, part]) => {
    const button = element(modes, "button", "", text)
    button.type = "button"
    button.addEventListener("click", () => edit(part))
    return [button, part]
  })
  // What is edited from now on: the materials, the shape, or the light alone.
  function edit(next) {
    for (const [button, part] of modeButtons) {
      button.setAttribute("aria-pressed", part === next)
      if (part !== next) { part?.setOpen(false) }
    }
    next?.setOpen(true)
    showMaterials()
    showShape()
  }
  // Shows what Python knows, once it has answered all that was changed here.
  async function showMaterials() {
    const [deflated, materials] = [bytes(model.labels).slice(), floats(model.materials)]
    const [width, height] = model.picture_size
    if (!editor.open || pending > 0 || deflated.length === 0) { return }
    const labels = await inflated(deflated)
    if (pending === 0 && width === model.picture_size[0] && labels.length === width * height) {
      editor.load(width, height, labels, new Map(model.numbers.map((number, row) => [
        number, {ramp: model.found_ramps[row], flat: materials[8 * row + 3] > 0},
      ])))
      takeRamps()
    }
  }
  async function showShape() {
    const [deflated, texture, [width, height]] = [bytes(model.shape_marks).slice(), bytes(model.normals), model.picture_size]
    if (!shaper.open || pending > 0 || texture.length === 0) { return }
    const marks = deflated.length > 0 ? await inflatedBytes(deflated) : new Uint8Array(width * height)
    if (pending === 0 && width === model.picture_size[0] && marks.length === width * height) {
      shaper.load(width, height, readNormals(texture, width * height), marks, model.shape_normals)
    }
  }
  const takeRamps = () => {
    if (pending === 0) { editor.recolor(new Map(Object.entries(model.edited_ramps).map(([number, ramp]) => [Number(number), ramp]))) }
  }
  // Paints the materials that have an edited ramp, by number, with it: nothing of this waits for Python.
  function recolor(ramps) {
    const materials = floats(model.materials)
    const rows = model.numbers.map((number) => ramps.get(number))
    if (materials.length !== 8 * rows.length) { return }
    shader?.recolor(rows.some((ramp) => ramp) ? recoloredRows(rows, materials) : null)
    for (const ball of [lightBall, originalBall]) { ball.load(...shownMap(floats(model.color_maps), materials, rows)) }
    path.paint()
    scheduleAll()
  }
  const allow = () => {
    ;[undo.disabled, redo.disabled] = [!model.can_undo, !model.can_redo]
    editor.allowReset(model.corrected)
  }

  const keys = shortcuts(root, {
    undo: () => travel(undo, "undo"), redo: () => travel(redo, "redo"), m: () => edit(editor.open ? null : editor), n: () => edit(shaper.open ? null : shaper), c: split.toggle, ...frame.keys,
    ...editor.keys, ...Object.fromEntries(Object.entries(shaper.keys).map(([key, act]) => [key, () => editor.keys[key]?.() || act()])),
  })

  // ---- the path of the light: played without a word to Python
  const path = lightPath(root, relit, {
    move, light: () => light, begin: circle.stop, redraw: schedule,
    letGo: () => send(),
    preview(next) { light = next; schedule() },
    ballUnder(angles) { lightBall.draw(direction(angles)); return relit.ball },
  }, ({keys, seconds, loops}) => {
    ;[undo.disabled, redo.disabled] = [false, true]
    Object.assign(model, {key_lights: keys, path_seconds: seconds, path_loops: loops})
  })
  const takePath = () => path.load({keys: model.key_lights, seconds: model.path_seconds, loops: model.path_loops})

  // ---- progress
  const busy = element(relit.stage, "div", "busy", `<div class="step"></div><div class="track"><div></div></div>`)
  const cancel = element(busy, "button", "", "Cancel")
  cancel.type = "button"
  busy.addEventListener("pointerdown", (event) => event.stopPropagation())
  cancel.addEventListener("click", () => model.send_msg({action: "cancel"}))
  function showProgress() {
    busy.classList.toggle("on", model.step !== "")
    busy.querySelector(".step").textContent = model.step
    busy.querySelector(".track div").style.width = `${100 * model.fraction}%`
  }

  // ---- pictures
  const shader = painter(relit.picture)
  const [lightBall, originalBall] = [ballPainter(relit.ball), ballPainter(drawing.ball)]
  const drawn = shader !== null
  root.classList.toggle("no-webgl", !drawn)
  if (model.webgl !== drawn) { model.webgl = drawn }

  const narrow = window.innerWidth < NARROW_PIXELS
  if (model.narrow !== narrow) { model.narrow = narrow }

  function draw() {
    scheduled = false
    relit.show(light)
    lightBall.draw(direction(light))
    path.compare()
    if (originalMoved) {  // it stands still while the new light is dragged: not worth a redraw then
      drawing.show(original)
      originalBall.draw(direction(original))
      originalMoved = false
    }
    // The picture's details belong to the light it was analyzed under, not to one being dragged or on its way.
    shader?.draw(uniforms(model, light))
  }
  function schedule() {
    if (!scheduled) { scheduled = true; requestAnimationFrame(draw) }
  }

  function scheduleAll() {
    originalMoved = true
    schedule()
  }

  let reloading = false
  function reload() {
    reloading = false
    const textures = texturesOf(model)
    root.classList.toggle("empty", textures === null)
    if (!textures) { return }
    const {width, height, color} = textures
    const source = drawing.picture
    ;[source.width, source.height] = [width, height]
    source.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(color), width, height), 0, 0)
    frame.load(textures)
    split.load(textures)
    shader?.load(textures)
    takeRamps()
    originalMoved = true
    draw()
    showMaterials()
    showShape()
  }
  // Several properties arrive one by one in one task: load them once, when all are there.
  function scheduleReload() {
    if (!reloading) { reloading = true; setTimeout(reload) }
  }

  // A light set in Python, for instance after "estimate"
  model.on("change:original_light", () => { original = [...model.original_light]; scheduleAll() })
  model.on("change:new_light", () => { if (timer === null && !circle.on && !path.on) { light = [...model.new_light]; schedule() } })
  for (const name of ["key_lights", "path_seconds", "path_loops"]) { model.on(`change:${name}`, () => setTimeout(takePath)) }
  for (const name of LOOKS) { model.on(`change:${name}`, schedule) }
  for (const name of ["step", "fraction"]) { model.on(`change:${name}`, showProgress) }
  model.on("change:idle", () => busy.classList.remove("on"))
  for (const name of [...TEXTURES, "labels", "numbers", "shape_marks", "shape_normals"]) { model.on(`change:${name}`, scheduleReload) }
  model.on("change:selected", () => editor.setSelected(model.selected))
  model.on("change:settled", () => {
    ;[pending, settled] = [Math.max(pending - (model.settled - settled), 0), model.settled]
    for (const part of [editor, shaper]) { part.showBusy(pending > 0) }
    if (pending === 0) { allow(); takeRamps() }
    setTimeout(showMaterials)
    setTimeout(showShape)
  })
  model.on("change:edited_ramps", takeRamps)
  for (const name of ["can_undo", "can_redo", "corrected"]) { model.on(`change:${name}`, allow) }
  const showFallback = () => showImage(relit.pictureImage, bytes(model.fallback_picture))
  model.on("change:fallback_picture", showFallback)
  if (!drawn) { showFallback() }
  const resized = new ResizeObserver(() => {
    frame.measure()
    for (const shown of [drawing, relit, split]) { shown.measure() }
    scheduleAll()
  })
  resized.observe(root)
  shader?.onRestored(schedule)
  model.on("remove", () => {
    halt()
    clearTimeout(timer)
    resized.disconnect()
    keys.remove()
    shader?.release()
  })
  showProgress()
  allow()
  takePath()
  edit(null)
  reload()
  schedule()
  return root
}

export default {render}
