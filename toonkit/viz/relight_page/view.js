// The relight view: a drawing beside its relit picture, each with a light that is set by dragging.
//
// Import-free, so that the same module serves Panel and a notebook without a network: view.py puts the other files first.

const NARROW_PIXELS = 600  // width of a window up to which the sidebar of the page lies over it
const SEND_EVERY_MS = 100
const ORBIT_DEGREES_PER_SECOND = 50
const ORBIT_HIGHEST = 65  // degrees: a light straight ahead would circle without anything moving

const PLAY = `<svg viewBox="0 0 24 24"><path d="M8 5.5v13l11-6.5z"/></svg>`
const PAUSE = `<svg viewBox="0 0 24 24"><path d="M7 5h3.5v14H7zM13.5 5H17v14h-3.5z"/></svg>`

// How far one light is from another, as a share of the full turn (radians), rising smoothly from 0 to 1.
function turnShare(light, other, fullTurn) {
  const [[a, b, c], [x, y, z]] = [light, other]
  const angle = Math.atan2(Math.hypot(b * z - c * y, c * x - a * z, a * y - b * x), a * x + b * y + c * z)
  const share = Math.min(angle / fullTurn, 1)
  return share * share * (3 - 2 * share)
}

// Linear light of a color #rrggbb, or #rgb for short.
function linearColor(text) {
  const digits = text.replace("#", "")
  const full = digits.length === 3 ? digits.replace(/./g, "$&$&") : digits
  return [0, 2, 4].map((at) => {
    const value = parseInt(full.slice(at, at + 2), 16) / 255
    return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4
  })
}

function bytes(value) {
  if (!value) { return new Uint8Array(0) }
  return value instanceof ArrayBuffer ? new Uint8Array(value) : new Uint8Array(value.buffer, value.byteOffset, value.byteLength)
}

const floats = (value) => new Float32Array(bytes(value).slice().buffer)
const words = (value) => new Uint32Array(bytes(value).slice().buffer)

function showImage(image, data) {
  if (image.src) { URL.revokeObjectURL(image.src) }
  image.src = data.length ? URL.createObjectURL(new Blob([data], {type: "image/png"})) : ""
}

function render({model}) {
  const root = document.createElement("div")
  root.className = "relight"
  const style = element(root, "style", "")
  style.textContent = STYLE
  let original = [...model.original_light], light = [...model.new_light]
  let orbiting = false, scheduled = false, originalMoved = true, lastSent = 0, timer = null

  // ---- light: drawn at once, told to Python at most ten times a second
  function send() {
    clearTimeout(timer)
    timer = null
    lastSent = performance.now()
    model.new_light = [...light]
  }
  function move(next) {
    light = next
    schedule()
    if (timer === null) { timer = setTimeout(send, Math.max(0, lastSent + SEND_EVERY_MS - performance.now())) }
  }
  function orbit(on) {
    if (on === orbiting) { return }
    orbiting = on
    play.innerHTML = on ? `${PAUSE}Stop` : `${PLAY}Orbit`
    if (!on) { send(); return }
    let before = performance.now()
    const turn = (now) => {
      if (!orbiting || !root.isConnected) { orbiting = false; return }
      const azimuth = light[0] + (now - before) / 1000 * ORBIT_DEGREES_PER_SECOND
      before = now
      move([wrapped(azimuth), Math.min(light[1], ORBIT_HIGHEST)])
      requestAnimationFrame(turn)
    }
    requestAnimationFrame(turn)
  }

  const drawing = lightCard(root, {
    name: "original", title: "Your drawing", hint: "Drag the artist's light to its place", angles: original,
    onMove: (next) => { original = next; scheduleAll() },
    // A new original light means a new analysis: only asked for when the hand lets go.
    onRelease: () => { model.original_light = [...original] },
  })
  const relit = lightCard(root, {
    name: "relit", title: "Relit", hint: "Drag the picture or the ball to move the light", angles: light,
    onMove: (next) => { orbit(false); move(next) },
    onRelease: send,
  })
  drawing.button("Estimate", "Estimate the light from the drawing", () => model.send_msg({action: "estimate"}))
  const play = relit.button(`${PLAY}Orbit`, "Let the light circle", () => orbit(!orbiting))
  relit.button("Reset to original", "Put the light back where the artist had it", () => {
    orbit(false)
    move([...original])
    send()
  })

  // ---- materials
  let pending = 0, settled = model.settled
  const editor = materialsEditor({root, card: drawing.card, stage: drawing.stage}, (action, details = {}) => {
    if (action === "select") {
      if (model.selected !== details.material) { model.selected = details.material }
      return
    }
    pending += 1
    editor.showBusy(true)
    if (["merge", "paint", "fill", "split", "recolor"].includes(action)) { editor.allow([true, false, true]) }
    model.send_msg({action, ...details})
  }, recolor)
  const modes = element(drawing.card.querySelector("header"), "div", "modes")
  const modeButtons = [["Light", false], ["Materials", true]].map(([text, editing]) => {
    const button = element(modes, "button", "", text)
    button.type = "button"
    button.addEventListener("click", () => setEditing(editing))
    return [button, editing]
  })
  function setEditing(on) {
    for (const [button, editing] of modeButtons) { button.setAttribute("aria-pressed", editing === on) }
    editor.setOpen(on)
    showMaterials()
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
    scheduleAll()
  }
  const allow = () => editor.allow([model.can_undo, model.can_redo, model.corrected])

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
    if (originalMoved) {  // it stands still while the new light is dragged: not worth a redraw then
      drawing.show(original)
      originalBall.draw(direction(original))
      originalMoved = false
    }
    // The picture's details belong to the light it was analyzed under, not to one being dragged or on its way.
    const [analyzed, current] = [direction(model.analyzed_light), direction(light)]
    const turned = model.keep_detail ? turnShare(analyzed, current, model.full_turn) : 1
    shader?.draw({
      original: analyzed, light: current, flat: turned * model.flat_shading,
      detail: model.keep_detail, range: model.detail_range, size: model.detail_size, highlight: model.highlight_range,
      lightColor: linearColor(model.light_color), ambient: model.ambient,
    })
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
    const [[width, height], color, normals] = [model.picture_size, bytes(model.color), bytes(model.normals)]
    const [parts, mixtures] = [words(model.parts), words(model.mixtures)]
    const [maps, materials, ramps] = [model.color_maps, model.materials, model.ramps].map(floats)
    const complete = width * height > 0 && color.length === 4 * width * height && [1, 2].includes(normals.length / color.length)
      && (parts.length === 0 || parts.length === width * height) && maps.length > 0 && materials.length > 0
      && ramps.length > 0 && ramps.length % (materials.length / 2) === 0
    root.classList.toggle("empty", !complete)
    if (!complete) { return }
    const source = drawing.picture
    ;[source.width, source.height] = [width, height]
    source.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(color), width, height), 0, 0)
    for (const card of [drawing, relit]) { card.picture.classList.toggle("pixels", Math.max(width, height) <= 160) }
    shader?.load({width, height, color, normals, parts, mixtures, maps, materials, ramps})
    takeRamps()
    originalMoved = true
    draw()
    showMaterials()
  }
  // Several properties arrive one by one in one task: load them once, when all are there.
  function scheduleReload() {
    if (!reloading) { reloading = true; setTimeout(reload) }
  }

  // A light set in Python, for instance after "estimate"
  model.on("change:original_light", () => { original = [...model.original_light]; scheduleAll() })
  model.on("change:new_light", () => { if (timer === null && !orbiting) { light = [...model.new_light]; schedule() } })
  for (const name of ["keep_detail", "flat_shading", "detail_range", "detail_size", "highlight_range", "full_turn", "light_color", "ambient"]) { model.on(`change:${name}`, schedule) }
  for (const name of ["step", "fraction"]) { model.on(`change:${name}`, showProgress) }
  model.on("change:idle", () => busy.classList.remove("on"))
  for (const name of [
    "color", "normals", "parts", "mixtures", "color_maps", "materials", "ramps", "picture_size", "analyzed_light", "labels", "numbers",
  ]) {
    model.on(`change:${name}`, scheduleReload)
  }
  model.on("change:selected", () => editor.setSelected(model.selected))
  model.on("change:settled", () => {
    ;[pending, settled] = [Math.max(pending - (model.settled - settled), 0), model.settled]
    editor.showBusy(pending > 0)
    if (pending === 0) { allow(); takeRamps() }
    setTimeout(showMaterials)
  })
  model.on("change:edited_ramps", takeRamps)
  for (const name of ["can_undo", "can_redo", "corrected"]) { model.on(`change:${name}`, allow) }
  const showFallback = () => showImage(relit.pictureImage, bytes(model.fallback_picture))
  model.on("change:fallback_picture", showFallback)
  if (!drawn) { showFallback() }
  const resized = new ResizeObserver(() => { for (const card of [drawing, relit]) { card.measure() } editor.measure(); scheduleAll() })
  resized.observe(root)
  shader?.onRestored(schedule)
  model.on("remove", () => {
    orbiting = false
    clearTimeout(timer)
    resized.disconnect()
    editor.remove()
    shader?.release()
  })
  showProgress()
  allow()
  setEditing(false)
  reload()
  schedule()
  return root
}

export default {render}
