// A height surface in its colors, with arrows along its normals, turned by dragging (WebGL2, import-free).
//
// x points right, y up, z toward the viewer, in samples of the grid; row 0 of every array is the top.

const VERTEX = `#version 300 es
in vec3 position, normal, color, foot, toward;
uniform mat4 u_view;
uniform mat3 u_turn;
uniform vec3 u_center;
uniform float u_length;  // of an arrow; 0 draws the surface
out vec3 v_color, v_normal;

void main() {
  vec3 place = position, up = normal;
  v_color = color;
  if (u_length > 0.0) {  // an arrow is modeled along z: turn z toward the normal
    vec3 side = normalize(abs(toward.z) < 0.9 ? cross(vec3(0.0, 0.0, 1.0), toward) : cross(vec3(0.0, 1.0, 0.0), toward));
    mat3 turn = mat3(side, cross(toward, side), toward);
    place = foot + turn * (u_length * position);
    up = turn * normal;
    v_color = vec3(0.91, 0.525, 0.18);
  }
  v_normal = u_turn * up;
  gl_Position = u_view * vec4(place - u_center, 1.0);
}`

const FRAGMENT = `#version 300 es
precision highp float;
in vec3 v_color, v_normal;
out vec4 painted;
void main() {
  vec3 N = normalize(v_normal);
  float light = abs(dot(N, normalize(vec3(-0.3, 0.4, 0.85))));
  painted = vec4(v_color * (0.35 + 0.65 * light), 1.0);
}`

const START = {yaw: -22, pitch: 17, zoom: 1}  // seen from slightly above and aside
const VIEW_ANGLE = 30
const STEEPEST = 89
const KEY_STEP = 10

const radians = (degrees) => degrees * Math.PI / 180
const clamp = (value, low, high) => Math.min(Math.max(value, low), high)

function bytes(value) {
  if (!value) { return new Uint8Array(0) }
  return value instanceof ArrayBuffer ? new Uint8Array(value) : new Uint8Array(value.buffer, value.byteOffset, value.byteLength)
}
const floats = (value) => new Float32Array(bytes(value).slice().buffer)

// Rows of the rotation that brings the scene before the viewer.
function rotation(yaw, pitch) {
  const [sy, cy, sp, cp] = [Math.sin(yaw), Math.cos(yaw), Math.sin(pitch), Math.cos(pitch)]
  return [[cy, 0, sy], [sp * sy, cp, -sp * cy], [-cp * sy, sp, cp * cy]]
}

// A column-major perspective view from `distance` in front of the turned scene.
function perspective(rows, distance, radius, aspect) {
  const f = 1 / Math.tan(radians(VIEW_ANGLE) / 2)
  const [near, far] = [Math.max(distance - 2 * radius, distance / 50), distance + 2 * radius]
  const [a, b] = [(far + near) / (near - far), 2 * far * near / (near - far)]
  const [fx, fy] = aspect < 1 ? [f, f * aspect] : [f / aspect, f]
  const columns = [0, 1, 2].map((k) => [fx * rows[0][k], fy * rows[1][k], a * rows[2][k], -rows[2][k]])
  return new Float32Array([...columns.flat(), 0, 0, b - a * distance, distance])
}

// An arrow of length 1 along z: a thin shaft and a cone, as triangles with normals.
function arrowModel(sides = 10) {
  const [shaft, cone, tip] = [0.04, 0.11, 0.65]
  const positions = [], normals = []
  const slope = cone / Math.hypot(cone, 1 - tip)
  const add = (...corners) => corners.forEach(([place, normal]) => { positions.push(...place); normals.push(...normal) })
  for (let k = 0; k < sides; k++) {
    const [[c, s], [d, t]] = [k, k + 1].map((i) => [Math.cos(2 * Math.PI * i / sides), Math.sin(2 * Math.PI * i / sides)])
    const at = (x, y, r, z) => [r * x, r * y, z]
    const [n, m] = [[c, s, 0], [d, t, 0]]
    add([at(c, s, shaft, 0), n], [at(d, t, shaft, 0), m], [at(d, t, shaft, tip), m])
    add([at(c, s, shaft, 0), n], [at(d, t, shaft, tip), m], [at(c, s, shaft, tip), n])
    const [u, v] = [[c, s, slope], [d, t, slope]]
    add([at(c, s, cone, tip), u], [at(d, t, cone, tip), v], [[0, 0, 1], u])
    add([at(c, s, cone, tip), [0, 0, -1]], [[0, 0, tip], [0, 0, -1]], [at(d, t, cone, tip), [0, 0, -1]])
  }
  return {positions: new Float32Array(positions), normals: new Float32Array(normals)}
}

// The surface as arrays: quads over every four object samples that form a square.
function surfaceOf({width, height, heights, normals, colors, feet}) {
  const count = width * height
  const positions = new Float32Array(3 * count)
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity]
  for (let i = 0; i < count; i++) {
    if (Number.isNaN(heights[i])) { continue }
    const place = [i % width, height - 1 - Math.floor(i / width), heights[i]]
    positions.set(place, 3 * i)
    for (let k = 0; k < 3; k++) {
      low[k] = Math.min(low[k], place[k])
      high[k] = Math.max(high[k], place[k])
    }
  }
  const triangles = []
  for (let row = 0; row + 1 < height; row++) {
    for (let column = 0; column + 1 < width; column++) {
      const [a, d] = [row * width + column, row * width + column + 1]
      const [b, c] = [a + width, d + width]
      if ([a, b, c, d].some((i) => Number.isNaN(heights[i]))) { continue }
      triangles.push(a, b, c, a, c, d)
    }
  }
  const pick = (source, n) => Float32Array.from([...feet].flatMap((i) => [...source.subarray(n * i, n * i + 3)]))
  return {
    positions, normals, colors, triangles: new Uint32Array(triangles),
    feet: pick(positions, 3), towards: pick(normals, 3),
    center: low.map((value, k) => (value + high[k]) / 2),
    radius: Math.hypot(...low.map((value, k) => high[k] - value)) / 2,
  }
}

// Paints a scene on a canvas. Null where WebGL2 is missing.
function painter(canvas) {
  const gl = canvas.getContext("webgl2", {antialias: true, premultipliedAlpha: false})
  if (!gl) { return null }
  let program, at, surface, arrows, shown = null
  const names = ["position", "normal", "color", "foot", "toward"]

  function prepare() {
    program = gl.createProgram()
    for (const [type, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(type)
      gl.shaderSource(shader, source)
      gl.compileShader(shader)
      gl.attachShader(program, shader)
    }
    names.forEach((name, location) => gl.bindAttribLocation(program, location, name))
    gl.linkProgram(program)
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      if (gl.isContextLost()) { return }
      throw new Error(`toonkit: the height view's shader does not link: ${gl.getProgramInfoLog(program)}`)
    }
    at = (name) => gl.getUniformLocation(program, name)
    gl.useProgram(program)
    gl.enable(gl.DEPTH_TEST)
    gl.clearColor(0, 0, 0, 0)
    ;[surface, arrows] = [0, 1].map(() => ({vertices: gl.createVertexArray(), buffers: {}, index: gl.createBuffer()}))
    const model = arrowModel()
    fill(arrows, "position", model.positions)
    fill(arrows, "normal", model.normals)
    arrows.corners = model.positions.length / 3
  }

  function fill(part, name, data, {type = gl.FLOAT, count = 3, stride = 0, divisor = 0} = {}) {
    const location = names.indexOf(name)
    part.buffers[name] ??= gl.createBuffer()
    gl.bindVertexArray(part.vertices)
    gl.bindBuffer(gl.ARRAY_BUFFER, part.buffers[name])
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW)
    gl.enableVertexAttribArray(location)
    gl.vertexAttribPointer(location, count, type, type === gl.UNSIGNED_BYTE, stride, 0)
    gl.vertexAttribDivisor(location, divisor)
  }

  function load(next) {
    shown = next
    fill(surface, "position", shown.positions)
    fill(surface, "normal", shown.normals)
    fill(surface, "color", shown.colors, {type: gl.UNSIGNED_BYTE, stride: 4})
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, surface.index)
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, shown.triangles, gl.STATIC_DRAW)
    fill(arrows, "foot", shown.feet, {divisor: 1})
    fill(arrows, "toward", shown.towards, {divisor: 1})
  }

  function draw({yaw, pitch, zoom}, arrowLength) {
    if (!shown || gl.isContextLost()) { return }
    gl.viewport(0, 0, canvas.width, canvas.height)
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT)
    const rows = rotation(radians(yaw), radians(pitch))
    const distance = zoom * shown.radius / Math.sin(radians(VIEW_ANGLE) / 2)
    gl.uniformMatrix4fv(at("u_view"), false, perspective(rows, distance, shown.radius, canvas.width / canvas.height))
    gl.uniformMatrix3fv(at("u_turn"), false, [0, 1, 2].flatMap((k) => rows.map((row) => row[k])))
    gl.uniform3fv(at("u_center"), shown.center)
    gl.uniform1f(at("u_length"), 0)
    gl.bindVertexArray(surface.vertices)
    gl.drawElements(gl.TRIANGLES, shown.triangles.length, gl.UNSIGNED_INT, 0)
    if (arrowLength > 0) {
      gl.uniform1f(at("u_length"), arrowLength)
      gl.bindVertexArray(arrows.vertices)
      gl.drawArraysInstanced(gl.TRIANGLES, 0, arrows.corners, shown.feet.length / 3)
    }
  }

  prepare()
  return {
    load, draw,
    onRestored(redraw) {  // a graphics driver may take the context away, for instance after sleep
      canvas.addEventListener("webglcontextlost", (event) => event.preventDefault())
      canvas.addEventListener("webglcontextrestored", () => { prepare(); if (shown) { load(shown) } redraw() })
    },
    release() { gl.getExtension("WEBGL_lose_context")?.loseContext() },
  }
}

function render({model}) {
  const root = document.createElement("div")
  root.className = "surface"
  root.innerHTML = `<style>${STYLE}</style>
    <canvas tabindex="0" role="img" aria-label="The recovered surface in 3-D: drag, or use the arrow keys, to turn it"></canvas>
    <div class="buttons"><button type="button" class="arrows" aria-pressed="true">Normals</button>
    <button type="button" class="home">Reset view</button></div><p>This view needs WebGL2, which this browser lacks.</p>`
  const canvas = root.querySelector("canvas")
  const arrows = root.querySelector(".arrows")
  const scene = painter(canvas)
  root.classList.toggle("no-webgl", scene === null)
  let camera = {...START}, scheduled = false, reloading = false

  function draw() {
    scheduled = false
    const withArrows = arrows.getAttribute("aria-pressed") === "true"
    scene?.draw(camera, withArrows ? 0.9 * model.arrow_spacing : 0)
  }
  function schedule() {
    if (!scheduled) { scheduled = true; requestAnimationFrame(draw) }
  }
  function resize() {
    const box = canvas.getBoundingClientRect()  // empty while another tab is open
    if (box.width === 0 || box.height === 0) { return }
    const scale = window.devicePixelRatio || 1
    const [width, height] = [Math.round(box.width * scale), Math.round(box.height * scale)]
    if (canvas.width !== width || canvas.height !== height) { [canvas.width, canvas.height] = [width, height] }
    draw()
  }
  function reload() {
    reloading = false
    const [[width, height], heights, normals] = [model.grid_size, floats(model.heights), floats(model.normals)]
    const [colors, feet] = [bytes(model.colors), new Uint32Array(bytes(model.arrow_feet).slice().buffer)]
    const count = width * height
    if (count === 0 || heights.length !== count || normals.length !== 3 * count || colors.length !== 4 * count) { return }
    scene?.load(surfaceOf({width, height, heights, normals, colors, feet}))
    schedule()
  }
  function turn(yaw, pitch) {
    camera.yaw += yaw
    camera.pitch = clamp(camera.pitch + pitch, -STEEPEST, STEEPEST)
    schedule()
  }
  function zoom(factor) {
    camera.zoom = clamp(camera.zoom * factor, 0.25, 3)
    schedule()
  }

  canvas.addEventListener("pointerdown", (event) => {
    if (event.button === 0) { canvas.setPointerCapture(event.pointerId) }
  })
  canvas.addEventListener("pointermove", (event) => {
    if (canvas.hasPointerCapture(event.pointerId)) { turn(event.movementX / 2, event.movementY / 2) }
  })
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault()
    zoom(Math.exp(event.deltaY / 1000))
  }, {passive: false})
  const keys = {ArrowLeft: [-KEY_STEP, 0], ArrowRight: [KEY_STEP, 0], ArrowUp: [0, -KEY_STEP], ArrowDown: [0, KEY_STEP]}
  canvas.addEventListener("keydown", (event) => {
    if (event.key in keys) { turn(...keys[event.key]) }
    else if (event.key === "+" || event.key === "-") { zoom(event.key === "+" ? 0.9 : 1 / 0.9) }
    else { return }
    event.preventDefault()
  })
  arrows.addEventListener("click", () => {
    arrows.setAttribute("aria-pressed", arrows.getAttribute("aria-pressed") !== "true")
    schedule()
  })
  root.querySelector(".home").addEventListener("click", () => { camera = {...START}; schedule() })

  // Several properties arrive one by one in one task: load them once, when all are there.
  function scheduleReload() {
    if (!reloading) { reloading = true; setTimeout(reload) }
  }
  for (const name of ["grid_size", "heights", "normals", "colors", "arrow_feet", "arrow_spacing"]) {
    model.on(`change:${name}`, scheduleReload)
  }
  const resized = new ResizeObserver(resize)
  resized.observe(canvas)
  scene?.onRestored(schedule)
  model.on("remove", () => {
    resized.disconnect()
    scene?.release()
  })
  reload()
  return root
}

const STYLE = `
.surface { --ink: var(--panel-on-surface-color, #1c1c1e); --paper: var(--panel-surface-color, #fff);
  --accent: var(--panel-primary-color, #d9772b); position: relative; width: 100%; height: 100%; min-height: 240px;
  color: var(--ink); font-size: 13px; border-radius: 8px; overflow: hidden;
  background: color-mix(in srgb, var(--ink) 7%, var(--paper)); }
.surface canvas { position: absolute; inset: 0; width: 100%; height: 100%; cursor: grab; touch-action: none; display: block; }
.surface canvas:active { cursor: grabbing; }
.surface canvas:focus-visible { outline: 2px solid var(--accent); outline-offset: -2px; }
.surface .buttons { position: absolute; right: 10px; top: 10px; display: flex; gap: 8px; }
.surface button { font: inherit; font-weight: 500; color: var(--ink); cursor: pointer; padding: 5px 12px; border-radius: 7px;
  background: var(--paper); border: 1px solid color-mix(in srgb, var(--ink) 26%, transparent); }
.surface button[aria-pressed=true] { border-color: var(--accent); box-shadow: inset 0 0 0 1px var(--accent); }
.surface button:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; }
.surface p { display: none; position: absolute; inset: 0; place-content: center; margin: 0; text-align: center; }
.surface.no-webgl p { display: grid; }
.surface.no-webgl canvas, .surface.no-webgl .buttons { display: none; }
`

export default {render}
