// The shader of the relight view: one picture painted under a new light.
//
// c' = M(L'·N) + w d,  d = c - M(L·N),  w = (1 - t²)⁴ for t² < 1,  t = (L'·N - L·N) (1 + |d|² / size²) / (2 range);
// w = 0 without detail. A flat material of color b: c' = c (1 + s (M(L'·N) - b) / b), from b instead of c without detail.
// Mixed pixels change by their shares of what their two sources do (toonkit/relighting.py). With a palette, c' is rounded to the
// ramp of its material (toonkit/illustration/palette.py). A recolored material with the map M' is first painted with it under
// the drawing's light: c := M'(L·N) + k d (toonkit/illustration/recoloring.py), then relit as any other. Colored and ambient light come on top of it: c'' = e -
// (1 - color) max(e - shadow, 0), e = c' + ambient max(lit tone - c', 0), in linear light (toonkit/illustration/light_color.py).
//
// x points right, y up, z toward the viewer; row 0 of every array is the top.

const MIXTURES_WIDE = 1024  // as in textures.py

const RAMP_SAMPLES = 1024  // of the map of a recolored material, as in toonkit/model/tone_ramp.py
const RAMP_HEAD = 2  // texels before them
const LEAST_BASE = 0.05  // as in toonkit/relighting.py
const TEXTURE = 0.15  // as in toonkit/illustration/recoloring.py

const VERTEX = `#version 300 es
void main() {  // one triangle that covers the canvas: no buffers
  gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2.0 - 1.0, 0.0, 1.0);
}`

const fragment = (several, recolors) => `#version 300 es
#define SEVERAL ${several ? 1 : 0}
#define RECOLORS ${recolors ? 1 : 0}
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
uniform sampler2D u_color, u_normals, u_maps, u_materials, u_ramps;
uniform sampler2D u_recolored;  // a row for each material: (recolored, stays flat), its color as a whole, and its map
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

#if RECOLORS
bool isRecolored(int material) { return texelFetch(u_recolored, ivec2(0, material), 0).x > 0.0; }

vec3 recoloredMap(int material, float illumination) {
  float t = clamp(0.5 * illumination + 0.5, 0.0, 1.0) * ${RAMP_SAMPLES - 1}.0;
  int start = min(int(t), ${RAMP_SAMPLES - 2});
  return mix(texelFetch(u_recolored, ivec2(start + ${RAMP_HEAD}, material), 0).rgb,
             texelFetch(u_recolored, ivec2(start + ${RAMP_HEAD + 1}, material), 0).rgb, t - float(start));
}
#endif

// A pixel of one material, of color and projected normal p.
vec3 relit(vec3 color, vec2 p, int material) {
  float q = dot(p, p);
  vec3 N = vec3(2.0 * sqrt(1.0 - q) * p, 1.0 - 2.0 * q);
  vec4 about = texelFetch(u_materials, ivec2(0, material), 0);  // domain, last sample, flat
  vec3 base = texelFetch(u_materials, ivec2(1, material), 0).rgb;
  bool isFlat = about.w > 0.0;
  float before = dot(u_original, N), after = dot(u_light, N);
  vec3 drawn = M(material, about, before), changed = M(material, about, after);
#if RECOLORS
  if (isRecolored(material)) {
    bool stays = texelFetch(u_recolored, ivec2(0, material), 0).y > 0.0;
    vec3 whole = texelFetch(u_recolored, ivec2(1, material), 0).rgb;
    vec3 now = stays ? drawn : recoloredMap(material, before);
    vec3 detail = color - drawn;
    float share = min(distance(now, drawn) / ${TEXTURE}, 1.0);
    float fine = max(1.0 - dot(detail, detail) / ${TEXTURE * TEXTURE}, 0.0);
    color = clamp(isFlat ? color + whole - base : now + (1.0 - share * (1.0 - fine)) * detail, 0.0, 1.0);
    changed = stays ? whole : recoloredMap(material, after);
    isFlat = isFlat || stays;
    drawn = now;
    base = whole;
  }
#endif
  if (isFlat) {
    changed = (u_detail ? color : base) * (1.0 + u_flat * (changed - base) / max(base, ${LEAST_BASE}));
  } else if (u_detail) {
    vec3 detail = color - drawn;
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

// The shadow (0) or the lit tone (1) of a material, in linear light.
vec3 endOf(int material, int end) {
#if RECOLORS
  if (isRecolored(material)) {
    bool stays = texelFetch(u_recolored, ivec2(0, material), 0).y > 0.0;
    int place = stays ? 1 : ${RAMP_HEAD} + end * ${RAMP_SAMPLES - 1};
    return toLinear(texelFetch(u_recolored, ivec2(place, material), 0).rgb);
  }
#endif
  return texelFetch(u_ramps, ivec2(end, material), 0).rgb;
}

vec3 filled(vec3 color, int material) {
  if (u_ambient == 0.0) { return color; }
  vec3 light = toLinear(color);
  return toSrgb(light + u_ambient * max(endOf(material, 1) - light, 0.0));
}

vec3 tinted(vec3 color, int material) {
  if (u_light_color == vec3(1.0)) { return color; }
  vec3 light = toLinear(color);
  return toSrgb(light - (1.0 - u_light_color) * max(light - endOf(material, 0), 0.0));
}

// The nearest color of a material's ramp, if it has one; what is drawn in another color stays so, or counts as one of it.
vec3 rounded(vec3 wanted, vec3 drawn, int material, bool own) {
  int count = int(texelFetch(u_materials, ivec2(1, material), 0).w);
  if (count == 0) { return wanted; }
#if RECOLORS
  if (isRecolored(material)) { return wanted; }
#endif
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

// A shader that paints one picture on one canvas. Null where WebGL2 is missing.
function painter(canvas) {
  const gl = canvas.getContext("webgl2", {premultipliedAlpha: false, antialias: false, depth: false})
  if (!gl) { return null }
  let program, at, several = null, contents = null, recolored = null
  const textures = ["u_color", "u_normals", "u_maps", "u_materials", "u_parts", "u_mixtures", "u_ramps", "u_recolored"]

  // What is in one material without ink has a shader of its own, which takes two thirds of the time; so has what is not
  // recolored: renderers without a graphics card go through both sides of a branch.
  function link() {
    gl.deleteProgram(program)
    program = gl.createProgram()
    for (const [type, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, fragment(several, recolored)]]) {
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

  // rows: what u_recolored holds, or null if no material is recolored
  function recolor(rows) {
    const known = recolored !== null
    recolored = rows
    if (several === null || gl.isContextLost()) { return }
    if (known !== (rows !== null)) { link() }
    const wide = RAMP_SAMPLES + RAMP_HEAD
    if (rows) { upload(7, gl.RGBA32F, wide, rows.length / 4 / wide, gl.RGBA, gl.FLOAT, rows) }
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
    load, draw, recolor,
    onRestored(redraw) {  // a graphics driver may take the context away, for instance after sleep
      canvas.addEventListener("webglcontextlost", (event) => event.preventDefault())
      canvas.addEventListener("webglcontextrestored", () => {
        const rows = recolored
        several = null
        prepare()
        if (contents) { load(contents) }
        recolor(rows)
        redraw()
      })
    },
    release() { gl.getExtension("WEBGL_lose_context")?.loseContext() },
  }
}
