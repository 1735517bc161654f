// A card of the relight view: a picture, a ball and two sliders, all moving the same light.

const BALL_PIXELS = 192
const SEND_EVERY_MS = 100
const ORBIT_DEGREES_PER_SECOND = 50
const ORBIT_HIGHEST = 65  // degrees: a light straight ahead would circle without anything moving

// Properties of a model that describe a picture, and how it is shown.
const TEXTURES = ["color", "normals", "parts", "mixtures", "color_maps", "materials", "ramps", "picture_size", "analyzed_light"]
const LOOKS = [
  "keep_detail", "flat_shading", "detail_range", "detail_size", "highlight_range", "full_turn", "light_color", "ambient",
]

const KEY_MS = 400  // pause after an arrow key from which on the light is let go
const PLAY = `<svg viewBox="0 0 24 24"><path d="M8 5.5v13l11-6.5z"/></svg>`
const PAUSE = `<svg viewBox="0 0 24 24"><path d="M7 5h3.5v14H7zM13.5 5H17v14h-3.5z"/></svg>`
const SUN = `<svg viewBox="0 0 24 24"><circle cx="12" cy="12" r="4.5"/><path d="M12 1.5v3M12 19.5v3M1.5 12h3M19.5 12h3
M4.6 4.6l2.1 2.1M17.3 17.3l2.1 2.1M4.6 19.4l2.1-2.1M17.3 6.7l2.1-2.1"/></svg>`

const clamp = (value, low, high) => Math.min(Math.max(value, low), high)
const radians = (degrees) => degrees * Math.PI / 180

// What the sliders show of a light, whole degrees: an azimuth counts once around from the right, as on the command line.
const shown = ([azimuth, elevation]) => [(Math.round(azimuth) + 360) % 360, Math.round(elevation)]

// Beyond 180 degrees an azimuth goes on at -180, as in Python.
const wrapped = (azimuth) => azimuth > 180 ? azimuth - 360 : azimuth

function direction([azimuth, elevation]) {
  const [a, e] = [radians(azimuth), radians(elevation)]
  return [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)]
}

// The light whose reflection direction on a sphere lies under (x, y) of the unit disc; outside it, at the rim.
function anglesUnder(x, y, previousAzimuth) {
  const radius = Math.hypot(x, y)
  const azimuth = radius > 1e-3 ? Math.atan2(y, x) * 180 / Math.PI : previousAzimuth
  return [azimuth, Math.acos(Math.min(radius, 1)) * 180 / Math.PI]
}

// The color map that a ball shows, samples and domain: that of the largest material whose shading was painted, or its edited
// ramp. `recolored` holds that of each material as u_recolored does, if it is known in this form.
function shownMap(maps, materials, edited, recolored = []) {
  const count = materials.length / 8
  const row = Math.max([...Array(count).keys()].findIndex((number) => materials[8 * number + 3] === 0), 0)
  if (edited[row]) { return [writeRamp(edited[row], RAMP_SAMPLES, new Float32Array(4 * RAMP_SAMPLES)), [-1, 1]] }
  const wide = 4 * (RAMP_SAMPLES + RAMP_HEAD)
  if (recolored[row * wide] > 0) { return [recolored.subarray(row * wide + 4 * RAMP_HEAD, (row + 1) * wide), [-1, 1]] }
  const start = row * maps.length / count
  return [maps.subarray(start, start + 4 * (materials[8 * row + 2] + 1)), materials.subarray(8 * row, 8 * row + 2)]
}

// The light ball: M(L · N) on a hemisphere. Few pixels, so without a second graphics context, which costs more.
function ballPainter(canvas) {
  const [size, radius, steps] = [BALL_PIXELS, BALL_PIXELS / 2 - 1, 1024]
  canvas.width = canvas.height = size
  const context = canvas.getContext("2d")
  const image = new ImageData(size, size)
  const vectors = new Float32Array(size * size * 3)
  const table = new Uint8ClampedArray(steps * 3)  // M over illumination -1 to 1
  let loaded = false
  for (let pixel = 0; pixel < size * size; pixel++) {
    const x = (pixel % size + 0.5 - size / 2) / radius
    const y = (size / 2 - Math.floor(pixel / size) - 0.5) / radius
    const r = Math.hypot(x, y)
    vectors.set([x / Math.max(r, 1), y / Math.max(r, 1), Math.sqrt(Math.max(0, 1 - r * r))], 3 * pixel)
    image.data[4 * pixel + 3] = 255 * clamp((1 - r) * radius + 0.5, 0, 1)
  }
  return {
    load(map, [low, high]) {
      const last = map.length / 4 - 1
      for (let step = 0; step < steps; step++) {
        const t = clamp(((2 * step / (steps - 1) - 1) - low) / (high - low), 0, 1) * last
        const start = Math.max(Math.min(Math.floor(t), last - 1), 0)
        const [a, b] = [4 * start, 4 * Math.min(start + 1, last)]
        for (let k = 0; k < 3; k++) { table[3 * step + k] = 255 * (map[a + k] + (t - start) * (map[b + k] - map[a + k])) }
      }
      loaded = true
    },
    draw([lx, ly, lz]) {
      if (!loaded) { return }
      const half = (steps - 1) / 2
      for (let pixel = 0, v = 0, c = 0; pixel < size * size; pixel++, v += 3, c += 4) {
        const t = 3 * Math.round((lx * vectors[v] + ly * vectors[v + 1] + lz * vectors[v + 2] + 1) * half)
        image.data[c] = table[t]
        image.data[c + 1] = table[t + 1]
        image.data[c + 2] = table[t + 2]
      }
      context.putImageData(image, 0, 0)
    },
  }
}

function element(parent, tag, className, html = "") {
  const node = document.createElement(tag)
  node.className = className
  node.innerHTML = html
  parent.append(node)
  return node
}

// One card: a picture, a ball, two sliders, all moving the same light. `frame` is where the picture lies.
function lightCard(parent, {name, title, hint, angles, frame, onMove, onRelease}) {
  const card = element(parent, "section", `card ${name}`)
  element(card, "header", "", `<h2>${title}</h2><p>${hint}</p>`)
  const stage = element(card, "div", "stage")
  const picture = element(stage, "canvas", "picture")
  const pictureImage = element(stage, "img", "picture stand-in")
  const sun = element(stage, "div", "sun", SUN)
  const fit = element(stage, "button", "fit")
  const controls = element(card, "div", "controls")
  const ballBox = element(controls, "div", "ball-box")
  const ball = element(ballBox, "canvas", "ball")
  const dot = element(ballBox, "div", "dot")
  const right = element(controls, "div", "right")
  const sliders = [["Azimuth", 0, 359], ["Elevation", 0, 90]].map(([label, min, max]) => {
    const row = element(right, "label", "slider", `<span>${label}</span>
      <input type="range" min="${min}" max="${max}" step="1" aria-label="${title}: ${label.toLowerCase()} in degrees"><output></output>`)
    return {input: row.querySelector("input"), output: row.querySelector("output")}
  })
  const buttons = element(right, "div", "buttons")
  Object.assign(fit, {type: "button", title: "Fit the picture (0)"})
  fit.setAttribute("aria-label", "Fit the picture")
  fit.addEventListener("pointerdown", (event) => event.stopPropagation())
  fit.addEventListener("click", frame.fit)
  pictureImage.alt = ""
  pictureImage.draggable = false
  Object.assign(ballBox, {tabIndex: 0, title: "Drag the light, or move it with the arrow keys"})
  ballBox.setAttribute("role", "application")
  ballBox.setAttribute("aria-label", `${title}: the light; arrow keys move it`)

  let half = 0
  function measure() { half = Math.min(stage.clientWidth, stage.clientHeight) / 2 }

  function show(next) {
    angles = next
    const [x, y] = direction(angles)
    sun.style.transform = `translate(${x * (half - 16)}px, ${-y * (half - 16)}px)`
    dot.style.transform = `translate(${x * 46}%, ${-y * 46}%)`
    const values = shown(angles)
    sliders.forEach(({input, output}, index) => {
      const text = `${values[index]}°`
      if (output.textContent === text) { return }
      input.value = values[index]
      output.textContent = text
    })
  }

  // Arrow keys: a degree, or ten with Shift. The light is let go of after a pause, or when `settle` is called.
  let keyed = null
  function settle() {
    if (keyed === null) { return }
    clearTimeout(keyed)
    keyed = null
    onRelease()
  }
  ballBox.addEventListener("keydown", (event) => {
    const way = {ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[event.key]
    if (!way || event.ctrlKey || event.metaKey || event.altKey) { return }
    event.preventDefault()
    const step = event.shiftKey ? 10 : 1
    angles = [wrapped((angles[0] + step * way[0] + 540) % 360 - 180), clamp(angles[1] + step * way[1], 0, 90)]
    onMove(angles)  // the next key may come before this is drawn
    clearTimeout(keyed)
    keyed = setTimeout(settle, KEY_MS)
  })

  // Moves the light to where an area is pressed. On the stage it does so wherever the picture lies: a light has a direction,
  // not a place, and all of them are within reach however much of the picture is on screen.
  function lightTool(area, inset) {
    const move = (event) => {
      const box = area.getBoundingClientRect()
      const radius = Math.min(box.width, box.height) / 2 - inset
      const x = (event.clientX - box.left - box.width / 2) / radius
      const y = (box.top + box.height / 2 - event.clientY) / radius
      onMove(anglesUnder(x, y, angles[0]))
    }
    return {
      patient: true, doubles: true, move,
      press(event) { card.classList.add("dragging"); move(event) },
      release() { card.classList.remove("dragging"); onRelease() },
    }
  }
  const onStage = lightTool(stage, 16), onBall = lightTool(ballBox, 4)
  let tool = onStage
  const handles = new Map()  // what on the stage is a tool of its own
  gestures(stage, frame, ({target}) => [...handles].find(([node]) => node.contains(target))?.[1] ?? tool)
  ballBox.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) { return }
    event.preventDefault()
    ballBox.setPointerCapture(event.pointerId)
    onBall.press(event)
  })
  ballBox.addEventListener("pointermove", (event) => { if (ballBox.hasPointerCapture(event.pointerId)) { onBall.move(event) } })
  ballBox.addEventListener("lostpointercapture", onBall.release)
  frame.add(stage)
  frame.follow(() => {
    const {scale, crisp, left, top} = frame.place(stage)
    for (const node of stage.querySelectorAll(".picture")) {
      node.style.transform = `translate(${left}px, ${top}px) scale(${scale})`
      node.classList.toggle("pixels", crisp)
    }
    fit.hidden = !frame.zoomed
    fit.textContent = `${Math.round(100 * scale)} %`
  })
  sliders.forEach(({input}, index) => {
    input.addEventListener("input", () => {
      const value = Number(input.value)
      angles = index === 0 ? [wrapped(value), angles[1]] : [angles[0], value]
      onMove(angles)  // the other slider may be moved before this is drawn
    })
    input.addEventListener("change", onRelease)
  })

  function button(text, tip, onClick) {
    const node = element(buttons, "button", "", text)
    node.type = "button"
    node.title = tip
    node.addEventListener("click", onClick)
    return node
  }
  // What is used on the stage from now on: the light, if null.
  const take = (next) => { tool = next ?? onStage }
  return {card, stage, picture, pictureImage, ball, measure, show, settle, button, take, handles}
}

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

// The textures of a model, or null until all have arrived.
function texturesOf(model) {
  const [[width, height], color, normals] = [model.picture_size, bytes(model.color), bytes(model.normals)]
  const [parts, mixtures] = [words(model.parts), words(model.mixtures)]
  const [maps, materials, ramps] = [model.color_maps, model.materials, model.ramps].map(floats)
  const complete = width * height > 0 && color.length === 4 * width * height && [1, 2].includes(normals.length / color.length)
    && (parts.length === 0 || parts.length === width * height) && maps.length > 0 && materials.length > 0
    && ramps.length > 0 && ramps.length % (materials.length / 2) === 0
  return complete ? {width, height, color, normals, parts, mixtures, maps, materials, ramps} : null
}

// What the shader needs to know beside the textures.
function uniforms(model, light) {
  // The picture's details belong to the light it was analyzed under, not to one being dragged or on its way.
  const [analyzed, current] = [direction(model.analyzed_light), direction(light)]
  const turned = model.keep_detail ? turnShare(analyzed, current, model.full_turn) : 1
  return {
    original: analyzed, light: current, flat: turned * model.flat_shading,
    detail: model.keep_detail, range: model.detail_range, size: model.detail_size, highlight: model.highlight_range,
    lightColor: linearColor(model.light_color), ambient: model.ambient,
  }
}

// A button that lets a light circle until it is stopped.
function orbit(card, current, move, stopped) {
  let on = false
  const show = () => { play.innerHTML = on ? `${PAUSE}Stop` : `${PLAY}Orbit` }
  const play = card.button("", "Let the light circle", () => { if (on) { stop() } else { start() } })
  function stop() {
    if (!on) { return }
    on = false
    show()
    stopped()
  }
  function start() {
    on = true
    show()
    let before = performance.now()
    const turn = (now) => {
      if (!on || !card.card.isConnected) { on = false; return }
      const azimuth = current()[0] + (now - before) / 1000 * ORBIT_DEGREES_PER_SECOND
      before = now
      move([wrapped(azimuth), Math.min(current()[1], ORBIT_HIGHEST)])
      requestAnimationFrame(turn)
    }
    requestAnimationFrame(turn)
  }
  show()
  return {stop, get on() { return on }}
}
