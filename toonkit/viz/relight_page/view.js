// The relight view: a drawing beside its relit picture, each with a light that is set by dragging.
//
// c' = M(L'·N) + w d,  d = c - M(L·N),  w = (1 - t²)⁴ for t² < 1,  t = (L'·N - L·N) (1 + |d|² / size²) / (2 range);
// w = 0 without detail. A flat material of color b: c' = c + s (M(L'·N) - b), from b instead of c without detail. Mixed
// pixels change by their shares of what their two sources do (toonkit/relighting.py). With a palette, c' is rounded to the
// ramp of its material (toonkit/illustration/palette.py). Colored and ambient light come on top of it: c'' = e -
// (1 - color) max(e - shadow, 0), e = c' + ambient max(lit tone - c', 0), in linear light (toonkit/illustration/light_color.py).
//
// x points right, y up, z toward the viewer; row 0 of every array is the top. Import-free, so that the
// same module serves Panel and a notebook without a network.

const VERTEX = `#version 300 es
void main() {  // one triangle that covers the canvas: no buffers
  gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2.0 - 1.0, 0.0, 1.0);
}`

const fragment = (several) => `#version 300 es
#define SEVERAL ${several ? 1 : 0}
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
uniform sampler2D u_color, u_normals, u_maps, u_materials, u_ramps;
uniform usampler2D u_parts, u_mixtures;  // see textures.py
uniform vec3 u_original, u_light;
uniform float u_range, u_size, u_flat, u_highlight, u_ambient;
uniform vec3 u_light_color;
uniform bool u_detail;
out vec4 painted;

const uint MIXED = 0x80000000u, HIGHLIT = 0xffffu;

vec3 M(int material, vec4 about, float illumination) {
  float t = clamp((illumination - about.x) / (about.y - about.x), 0.0, 1.0) * about.z;
  int last = int(about.z);
  int start = max(min(int(t), last - 1), 0);
  // Mixed here, not by the sampler, whose weights have 8 bits on many cards.
  return mix(texelFetch(u_maps, ivec2(start, material), 0).rgb,
             texelFetch(u_maps, ivec2(min(start + 1, last), material), 0).rgb, t - float(start));
}

// A pixel of one material, of color and projected normal p.
vec3 relit(vec3 color, vec2 p, int material) {
  float q = dot(p, p);
  vec3 N = vec3(2.0 * sqrt(1.0 - q) * p, 1.0 - 2.0 * q);
  vec4 about = texelFetch(u_materials, ivec2(0, material), 0);  // domain, last sample, flat
  float after = dot(u_light, N);
  vec3 changed = M(material, about, after);
  if (about.w > 0.0) {
    vec3 base = texelFetch(u_materials, ivec2(1, material), 0).rgb;
    changed = (u_detail ? color : base) + u_flat * (changed - base);
  } else if (u_detail) {
    float before = dot(u_original, N);
    vec3 detail = color - M(material, about, before);
    float turn = (after - before) * (1.0 + dot(detail, detail) / (u_size * u_size)) / (2.0 * u_range);
    float left = max(1.0 - turn * turn, 0.0);
    changed += left * left * left * left * detail;
  }
  return clamp(changed, 0.0, 1.0);
}

vec3 toLinear(vec3 color) {
  return mix(pow((max(color, 0.04045) + 0.055) / 1.055, vec3(2.4)), color / 12.92, vec3(lessThanEqual(color, vec3(0.04045))));
}

vec3 toSrgb(vec3 light) {
  return clamp(mix(1.055 * pow(max(light, 0.0031308), vec3(1.0 / 2.4)) - 0.055, light * 12.92,
                   vec3(lessThanEqual(light, vec3(0.0031308)))), 0.0, 1.0);
}

vec3 filled(vec3 color, int material) {
  if (u_ambient == 0.0) { return color; }
  vec3 light = toLinear(color);
  return toSrgb(light + u_ambient * max(texelFetch(u_ramps, ivec2(1, material), 0).rgb - light, 0.0));
}

vec3 tinted(vec3 color, int material) {
  if (u_light_color == vec3(1.0)) { return color; }
  vec3 light = toLinear(color);
  return toSrgb(light - (1.0 - u_light_color) * max(light - texelFetch(u_ramps, ivec2(0, material), 0).rgb, 0.0));
}

// The nearest color of a material's ramp, if it has one; what is drawn in another color stays so, or counts as one of it.
vec3 rounded(vec3 wanted, vec3 drawn, int material, bool own) {
  int count = int(texelFetch(u_materials, ivec2(1, material), 0).w);
  if (count == 0) { return wanted; }
  vec3 nearest = drawn;
  float least = own ? dot(wanted - drawn, wanted - drawn) : 1e9;
  bool listed = own;
  for (int k = 0; k < count; k++) {
    vec3 tone = texelFetch(u_ramps, ivec2(k + 2, material), 0).rgb;
    vec3 off = abs(tone - drawn);
    listed = listed || max(max(off.r, off.g), off.b) < 0.5 / 255.0;
    float away = dot(wanted - tone, wanted - tone);
    if (away < least) { least = away; nearest = tone; }
  }
  return listed ? nearest : drawn;
}

void main() {
  ivec2 pixel = ivec2(int(gl_FragCoord.x), textureSize(u_color, 0).y - 1 - int(gl_FragCoord.y));
  vec4 own = texelFetch(u_color, pixel, 0);
  if (own.a == 0.0) { painted = vec4(0.0); return; }
  vec3 color = own.rgb;
  vec2 p = texelFetch(u_normals, pixel, 0).rg;  // equal-area projection: as exact at the rim as in the middle
  bool fringe = dot(p, p) > 0.75;  // longer than any projection: the way, in pixels, to the nearest object pixel
  if (fringe) {
    pixel += ivec2(p);
    color = texelFetch(u_color, pixel, 0).rgb;
    p = texelFetch(u_normals, pixel, 0).rg;
  }
#if SEVERAL
  uint part = texelFetch(u_parts, pixel, 0).r;
  bool mixed = part >= MIXED;
  int number = mixed ? int(part - MIXED) : 0, wide = textureSize(u_mixtures, 0).x;
  uvec4 words = texelFetch(u_mixtures, ivec2(number % wide, number / wide), 0);
  if (!mixed) { words = uvec4(uint(pixel.x) | uint(pixel.y) << 16u, 0u, part, 0xffffu); }
  vec2 shares = unpackUnorm2x16(words.w);
  vec3 changed = color, mixture = color;  // without the light's color, and with it
  // A loop, not branches: renderers without a graphics card go through both sides of a branch.
  for (int k = 0; k < (shares.y > 0.0 ? 2 : 1); k++) {
    uint place = k == 0 ? words.x : words.y;
    ivec2 source = ivec2(place & 0xffffu, place >> 16u);
    vec3 paint = texelFetch(u_color, source, 0).rgb;
    vec2 normal = texelFetch(u_normals, source, 0).rg;
    int own_material = int(words.z >> uint(16 * k) & 0xffffu);
    vec3 after = filled(relit(paint, normal, own_material), own_material);
    float share = k == 0 ? shares.x : shares.y;
    changed += share * (after - paint);
    mixture += share * (tinted(after, own_material) - paint);
  }
  int material = int(words.z & 0xffffu);
  bool highlit = words.z >> 16u == HIGHLIT;
  if (highlit) {  // what a highlight adds to its paint fades
    vec3 paint = texelFetch(u_color, ivec2(words.x & 0xffffu, words.x >> 16u), 0).rgb;
    float q = dot(p, p);
    float turn = dot(u_light - u_original, vec3(2.0 * sqrt(1.0 - q) * p, 1.0 - 2.0 * q)) / (2.0 * u_highlight);
    float left = max(1.0 - turn * turn, 0.0);
    changed -= (1.0 - left * left * left * left) * (color - paint);
  }
  changed = rounded(clamp(changed, 0.0, 1.0), color, material, highlit);
  vec3 shown = mixed && !highlit ? clamp(mixture, 0.0, 1.0) : tinted(changed, material);
#else
  int material = 0;
  vec3 changed = rounded(filled(relit(color, p, 0), 0), color, 0, false);
  vec3 shown = tinted(changed, 0);
#endif
  if (fringe && u_detail) {
    shown -= changed;
    changed = rounded(clamp(own.rgb + changed - color, 0.0, 1.0), own.rgb, material, true);
    shown = clamp(shown + changed, 0.0, 1.0);
  }
  painted = vec4(shown, own.a);
}`

const MIXTURES_WIDE = 1024  // as in textures.py
const BALL_PIXELS = 192
const SEND_EVERY_MS = 100
const ORBIT_DEGREES_PER_SECOND = 50
const ORBIT_HIGHEST = 65  // degrees: a light straight ahead would circle without anything moving

const SUN = `<svg viewBox="0 0 24 24"><circle cx="12" cy="12" r="4.5"/><path d="M12 1.5v3M12 19.5v3M1.5 12h3M19.5 12h3
M4.6 4.6l2.1 2.1M17.3 17.3l2.1 2.1M4.6 19.4l2.1-2.1M17.3 6.7l2.1-2.1"/></svg>`
const PLAY = `<svg viewBox="0 0 24 24"><path d="M8 5.5v13l11-6.5z"/></svg>`
const PAUSE = `<svg viewBox="0 0 24 24"><path d="M7 5h3.5v14H7zM13.5 5H17v14h-3.5z"/></svg>`

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

// A shader that paints one picture on one canvas. Null where WebGL2 is missing.
function painter(canvas) {
  const gl = canvas.getContext("webgl2", {premultipliedAlpha: false, antialias: false, depth: false})
  if (!gl) { return null }
  let program, at, several = null, contents = null
  const textures = ["u_color", "u_normals", "u_maps", "u_materials", "u_parts", "u_mixtures", "u_ramps"]

  // What is in one material without ink has a shader of its own, which takes two thirds of the time.
  function link() {
    gl.deleteProgram(program)
    program = gl.createProgram()
    for (const [type, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, fragment(several)]]) {
      const shader = gl.createShader(type)
      gl.shaderSource(shader, source)
      gl.compileShader(shader)
      gl.attachShader(program, shader)
    }
    gl.linkProgram(program)
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      if (gl.isContextLost()) { return }
      throw new Error(`toonkit: the relight shader does not link: ${gl.getProgramInfoLog(program)}`)
    }
    gl.useProgram(program)
    at = (name) => gl.getUniformLocation(program, name)
    textures.forEach((name, unit) => gl.uniform1i(at(name), unit))
  }

  function prepare() {
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1)
    textures.forEach((_, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit)
      gl.bindTexture(gl.TEXTURE_2D, gl.createTexture())
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
        gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST)
      }
    })
  }

  function upload(unit, internal, width, height, format, type, data) {
    gl.activeTexture(gl.TEXTURE0 + unit)
    gl.texImage2D(gl.TEXTURE_2D, 0, internal, width, height, 0, format, type, data)
  }

  // contents: width, height, and the textures as textures.py describes them, as arrays of their own numbers
  function load(next) {
    contents = next
    const {width, height, color, normals, parts, mixtures, maps, materials, ramps} = contents
    if (canvas.width !== width || canvas.height !== height) { [canvas.width, canvas.height] = [width, height] }
    gl.viewport(0, 0, width, height)
    if (several !== parts.length > 0) {
      several = parts.length > 0
      link()
    }
    const count = materials.length / 8
    upload(0, gl.RGBA8, width, height, gl.RGBA, gl.UNSIGNED_BYTE, color)
    if (normals.length === 4 * width * height) {
      upload(1, gl.RG16F, width, height, gl.RG, gl.HALF_FLOAT, new Uint16Array(normals.slice().buffer))
    } else {
      upload(1, gl.RG32F, width, height, gl.RG, gl.FLOAT, floats(normals))
    }
    upload(2, gl.RGBA32F, maps.length / 4 / count, count, gl.RGBA, gl.FLOAT, maps)
    upload(3, gl.RGBA32F, 2, count, gl.RGBA, gl.FLOAT, materials)
    const none = new Uint32Array(4)
    const uploadWords = (unit, internal, format, data, wide, high) => data.length > 0
      ? upload(unit, internal, wide, high, format, gl.UNSIGNED_INT, data)
      : upload(unit, internal, 1, 1, format, gl.UNSIGNED_INT, none)
    uploadWords(4, gl.R32UI, gl.RED_INTEGER, parts, width, height)
    uploadWords(5, gl.RGBA32UI, gl.RGBA_INTEGER, mixtures, MIXTURES_WIDE, mixtures.length / 4 / MIXTURES_WIDE)
    upload(6, gl.RGBA32F, ramps.length / 4 / count, count, gl.RGBA, gl.FLOAT, ramps)
  }

  function draw({original, light, detail, flat, range, size, highlight, lightColor, ambient}) {
    if (!contents || gl.isContextLost()) { return }
    gl.uniform3fv(at("u_original"), original)
    gl.uniform3fv(at("u_light"), light)
    gl.uniform1i(at("u_detail"), detail ? 1 : 0)
    gl.uniform1f(at("u_flat"), flat)
    gl.uniform1f(at("u_range"), range)
    gl.uniform1f(at("u_size"), size)
    gl.uniform1f(at("u_highlight"), highlight)
    gl.uniform3fv(at("u_light_color"), lightColor)
    gl.uniform1f(at("u_ambient"), ambient)
    gl.drawArrays(gl.TRIANGLES, 0, 3)
  }

  prepare()
  return {
    load, draw,
    onRestored(redraw) {  // a graphics driver may take the context away, for instance after sleep
      canvas.addEventListener("webglcontextlost", (event) => event.preventDefault())
      canvas.addEventListener("webglcontextrestored", () => {
        several = null
        prepare()
        if (contents) { load(contents) }
        redraw()
      })
    },
    release() { gl.getExtension("WEBGL_lose_context")?.loseContext() },
  }
}

// The color map that a ball shows, samples and domain: that of the largest material whose shading was painted.
function shownMap(maps, materials) {
  const count = materials.length / 8
  const row = Math.max([...Array(count).keys()].findIndex((number) => materials[8 * number + 3] === 0), 0)
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

// One card: a picture, a ball, two sliders, all moving the same light.
function lightCard(parent, {name, title, hint, angles, onMove, onRelease}) {
  const card = element(parent, "section", `card ${name}`)
  element(card, "header", "", `<h2>${title}</h2><p>${hint}</p>`)
  const stage = element(card, "div", "stage")
  const picture = element(stage, "canvas", "picture")
  const pictureImage = element(stage, "img", "picture stand-in")
  const sun = element(stage, "div", "sun", SUN)
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
  pictureImage.alt = ""
  pictureImage.draggable = false
  ball.setAttribute("aria-label", `${title}: drag to move the light`)

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

  function draggable(area, inset) {
    const move = (event) => {
      const box = area.getBoundingClientRect()
      const radius = Math.min(box.width, box.height) / 2 - inset
      const x = (event.clientX - box.left - box.width / 2) / radius
      const y = (box.top + box.height / 2 - event.clientY) / radius
      onMove(anglesUnder(x, y, angles[0]))
    }
    area.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) { return }
      event.preventDefault()
      area.setPointerCapture(event.pointerId)
      card.classList.add("dragging")
      move(event)
    })
    area.addEventListener("pointermove", (event) => { if (area.hasPointerCapture(event.pointerId)) { move(event) } })
    for (const end of ["pointerup", "pointercancel"]) {
      area.addEventListener(end, (event) => {
        if (!area.hasPointerCapture(event.pointerId)) { return }
        area.releasePointerCapture(event.pointerId)
        card.classList.remove("dragging")
        onRelease()
      })
    }
  }
  draggable(stage, 16)
  draggable(ballBox, 4)
  sliders.forEach(({input}, index) => {
    input.addEventListener("input", () => {
      const value = Number(input.value)
      onMove(index === 0 ? [wrapped(value), angles[1]] : [angles[0], value])
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
  return {card, stage, picture, pictureImage, ball, measure, show, button}
}

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
    name: "original", title: "Your drawing", hint: "Drag to show where the artist's light is", angles: original,
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
    for (const ball of [lightBall, originalBall]) { ball.load(...shownMap(maps, materials)) }
    shader?.load({width, height, color, normals, parts, mixtures, maps, materials, ramps})
    originalMoved = true
    draw()
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
  for (const name of [
    "color", "normals", "parts", "mixtures", "color_maps", "materials", "ramps", "picture_size", "analyzed_light",
  ]) {
    model.on(`change:${name}`, scheduleReload)
  }
  const showFallback = () => showImage(relit.pictureImage, bytes(model.fallback_picture))
  model.on("change:fallback_picture", showFallback)
  if (!drawn) { showFallback() }
  const resized = new ResizeObserver(() => { for (const card of [drawing, relit]) { card.measure() } scheduleAll() })
  resized.observe(root)
  shader?.onRestored(schedule)
  model.on("remove", () => {
    orbiting = false
    clearTimeout(timer)
    resized.disconnect()
    shader?.release()
  })
  showProgress()
  reload()
  schedule()
  return root
}

// A tile, not a gradient: a page without a graphics card would compute the gradient again for every picture.
const CHECKERS = "data:image/svg+xml," + encodeURIComponent(`<svg xmlns="http://www.w3.org/2000/svg" width="20" height="20">
<path fill="#7f8084" d="M0 0h20v20H0z"/><path fill="#747579" d="M0 0h10v10H0zM10 10h10v10H10z"/></svg>`)

// What moves has a layer of its own (will-change), and nothing that is drawn anew each time is clipped to a shape.
const STYLE = `
:host { container-type: inline-size; }
.relight {
  --ink: var(--panel-on-surface-color, #1c1c1e); --paper: var(--panel-surface-color, #fff);
  --line: color-mix(in srgb, var(--ink) 14%, transparent); --soft: color-mix(in srgb, var(--ink) 62%, var(--paper));
  --accent: var(--panel-primary-color, #d9772b);
  display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: 16px; width: 100%; box-sizing: border-box;
  color: var(--ink); font-size: 13px; line-height: 1.35;
}
.relight * { box-sizing: border-box; }
.card { background: var(--paper); border: 1px solid var(--line); border-radius: 12px; display: flex;
  flex-direction: column; min-width: 0; }
.card header { display: flex; align-items: baseline; gap: 10px; padding: 10px 16px; flex-wrap: wrap; }
.card h2 { margin: 0; font-size: 15px; font-weight: 600; letter-spacing: .01em; }
.card header p { margin: 0; color: var(--soft); font-size: 12px; }
.stage { position: relative; height: clamp(240px, calc(100vh - 432px), 720px); touch-action: none; cursor: grab;
  overflow: hidden; background: url("${CHECKERS}") 0 0 / 20px 20px; }
.dragging .stage, .dragging .ball-box { cursor: grabbing; }
.picture { position: absolute; inset: 12px; width: calc(100% - 24px); height: calc(100% - 24px); object-fit: contain;
  user-select: none; -webkit-user-drag: none; }
.picture.pixels { image-rendering: pixelated; }
.empty .picture, .empty .sun, .empty .dot, .stand-in { visibility: hidden; }
.no-webgl .stand-in { visibility: visible; }
.no-webgl .relit canvas.picture { visibility: hidden; }
.sun { position: absolute; left: calc(50% - 14px); top: calc(50% - 14px); width: 28px; height: 28px; border-radius: 50%;
  pointer-events: none; background: rgba(255, 255, 255, .92); box-shadow: 0 1px 5px rgba(0, 0, 0, .45); opacity: .78; will-change: transform;
  transition: opacity .15s; }
.stage:hover .sun, .dragging .sun { opacity: 1; }
.sun svg { width: 28px; height: 28px; padding: 5px; fill: #f2a11b; stroke: #d98407; stroke-width: 2; stroke-linecap: round; }
.controls { display: flex; gap: 18px; align-items: center; padding: 14px 16px; border-top: 1px solid var(--line); }
.ball-box { position: relative; flex: none; width: 112px; height: 112px; cursor: grab; touch-action: none; border-radius: 50%;
  box-shadow: 0 0 0 1px var(--line), 0 4px 14px rgba(0, 0, 0, .22); }
.ball { position: absolute; inset: 0; width: 100%; height: 100%; user-select: none; }
.dot { position: absolute; inset: 0; pointer-events: none; will-change: transform; }
.dot::after { content: ""; position: absolute; left: calc(50% - 6px); top: calc(50% - 6px); width: 12px; height: 12px;
  border-radius: 50%; border: 2px solid #fff; background: #f2a11b; box-shadow: 0 0 3px rgba(0, 0, 0, .7); }
.right { flex: 1; min-width: 0; display: flex; flex-direction: column; gap: 8px; }
.slider { display: grid; grid-template-columns: 62px minmax(0, 1fr) 42px; align-items: center; gap: 8px; }
.slider span { color: var(--soft); }
.slider output { text-align: right; font-variant-numeric: tabular-nums; }
.slider input { width: 100%; margin: 0; height: 20px; appearance: none; background: none; cursor: pointer; }
.slider input::-webkit-slider-runnable-track { height: 4px; border-radius: 2px; background: color-mix(in srgb, var(--ink) 22%, transparent); }
.slider input::-moz-range-track { height: 4px; border-radius: 2px; background: color-mix(in srgb, var(--ink) 22%, transparent); }
.slider input::-webkit-slider-thumb { appearance: none; width: 14px; height: 14px; margin-top: -5px; border-radius: 50%;
  background: var(--accent); box-shadow: 0 1px 3px rgba(0, 0, 0, .4); }
.slider input::-moz-range-thumb { width: 14px; height: 14px; border: 0; border-radius: 50%; background: var(--accent); }
.buttons { display: flex; gap: 8px; flex-wrap: wrap; margin-top: 2px; }
button { display: inline-flex; align-items: center; gap: 5px; font: inherit; font-weight: 500; color: var(--ink);
  background: transparent; border: 1px solid color-mix(in srgb, var(--ink) 26%, transparent); border-radius: 7px;
  padding: 5px 12px; cursor: pointer; white-space: nowrap; }
button:hover { background: color-mix(in srgb, var(--ink) 8%, transparent); }
button:focus-visible, input:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; }
button svg { width: 15px; height: 15px; fill: currentColor; margin-left: -3px; }
.busy { position: absolute; left: 50%; bottom: 18px; width: min(320px, calc(100% - 32px)); padding: 10px 14px;
  transform: translateX(-50%); display: none; grid-template-columns: 1fr auto; gap: 6px 14px; align-items: center;
  background: var(--paper); border-radius: 10px; box-shadow: 0 4px 22px rgba(0, 0, 0, .35); cursor: default; }
.busy.on { display: grid; }
.busy .step { overflow: hidden; text-overflow: ellipsis; white-space: nowrap; }
.busy .step::first-letter { text-transform: uppercase; }
.busy .track { grid-row: 2; height: 4px; border-radius: 2px; background: var(--line); overflow: hidden; }
.busy .track div { height: 100%; background: var(--accent); transition: width .15s; }
.busy button { grid-area: 1 / 2 / 3 / 3; }
@container (max-width: 600px) {
  .relight { grid-template-columns: minmax(0, 1fr); }
  .card.relit { order: -1; }
  .stage { height: min(84cqw, 420px); }
  .ball-box { width: 92px; height: 92px; }
}
@container (min-width: 601px) and (max-width: 850px) {
  .card header p { display: none; }
  .controls { gap: 12px; padding: 12px; }
  .ball-box { width: 84px; height: 84px; }
  .slider { grid-template-columns: 58px minmax(0, 1fr) 38px; gap: 4px; }
}
`

export default {render}
