// Tone ramps, as toonkit/model/tone_ramp.py describes them: {tones, thresholds, softness, stays_flat}.

const MOST_TONES = 8

const channels = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255)
const hexOf = (color) => "#" + color.map((value) => Math.round(255 * clamp(value, 0, 1)).toString(16).padStart(2, "0")).join("")
const mixed = (one, other, share) => one.map((value, k) => value + share * (other[k] - value))

// Brightness of a color as the eye sees it, as `tone` in toonkit/model/luminance.py.
function brightness(hex) {
  const [red, green, blue] = linearColor(hex)
  const light = 0.2126 * red + 0.7152 * green + 0.0722 * blue
  return light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055
}

// A color as it is, or as near to it as lets it stand between a darker and a brighter one in a ramp.
function between(hex, darker, brighter) {
  const [low, high] = [darker ? brightness(darker) : 0, brighter ? brightness(brighter) : 1]
  const value = brightness(hex)
  if (value >= low && value <= high) { return hex }
  const [aim, goal] = value < low ? [low, [1, 1, 1]] : [high, [0, 0, 0]]
  let [start, end] = [0, 1]  // shares of white, or black
  for (let k = 0; k < 20; k++) {
    const middle = (start + end) / 2
    const passed = (brightness(hexOf(mixed(channels(hex), goal, middle))) - aim) * (value - aim) <= 0
    if (passed) { end = middle } else { start = middle }
  }
  return hexOf(mixed(channels(hex), goal, end))
}

// Writes the color at an illumination into an array of four numbers a color, from a place on.
function writeColor(ramp, tones, illumination, target, at) {
  for (let c = 0; c < 3; c++) { target[at + c] = tones[0][c] }
  ramp.thresholds.forEach((threshold, k) => {
    const share = clamp((illumination - threshold) / Math.max(ramp.softness[k], 1e-6) + 0.5, 0, 1)
    for (let c = 0; c < 3; c++) { target[at + c] += share * (tones[k + 1][c] - tones[k][c]) }
  })
}

// The ramp as colors over illumination -1 to 1, four numbers each, from a place in an array on.
function writeRamp(ramp, count, target, at = 0) {
  const tones = ramp.tones.map(channels)
  for (let k = 0; k < count; k++) { writeColor(ramp, tones, 2 * k / (count - 1) - 1, target, at + 4 * k) }
  return target
}

function rampBackground(ramp) {
  const stops = []
  const add = (illumination, color) => stops.push(`${color} ${(50 * (illumination + 1)).toFixed(2)}%`)
  const tones = ramp.tones.map(channels), color = [0, 0, 0, 0]
  const corners = ramp.thresholds.flatMap((threshold, k) => [-0.5, 0.5].map((side) => threshold + side * ramp.softness[k]))
  const middles = ramp.thresholds.flatMap((threshold, k) => ramp.softness[k] < 0.004 ? [threshold - 0.002, threshold + 0.002] : [])
  for (const illumination of [-1, ...corners, ...middles, 1].filter((one) => one >= -1 && one <= 1).sort((a, b) => a - b)) {
    writeColor(ramp, tones, illumination, color, 0)
    add(illumination, hexOf(color.slice(0, 3)))
  }
  return `linear-gradient(to right, ${stops.join(", ")})`
}

// A tone more, in the middle of the widest one.
function withTone(ramp) {
  const ends = [-1, ...ramp.thresholds, 1]
  const widths = ramp.tones.map((_, k) => ends[k + 1] - ends[k])
  const widest = widths.indexOf(Math.max(...widths))
  const above = widest + 1 < ramp.tones.length
  const [tone, other] = [ramp.tones[widest], ramp.tones[above ? widest + 1 : Math.max(widest - 1, 0)]].map(channels)
  const fresh = hexOf(ramp.tones.length > 1 ? mixed(tone, other, 0.5) : mixed(tone, [0, 0, 0], 0.3))
  const place = above ? widest + 1 : widest
  const insert = (list, at, value) => [...list.slice(0, at), value, ...list.slice(at)]
  return {
    ...ramp, tones: insert(ramp.tones, place, fresh), thresholds: insert(ramp.thresholds, widest, (ends[widest] + ends[widest + 1]) / 2),
    softness: insert(ramp.softness, widest, 0.02),
  }
}

// A step less: the tone above it goes, or, at the brightest one, the tone below.
function withoutStep(ramp, step) {
  const tone = step + 2 < ramp.tones.length ? step + 1 : step
  const drop = (list, at) => list.filter((_, k) => k !== at)
  return {...ramp, tones: drop(ramp.tones, tone), thresholds: drop(ramp.thresholds, step), softness: drop(ramp.softness, step)}
}

// What the shader needs of edited ramps, one for each row of its textures, if there is one: see u_recolored.
function recoloredRows(ramps, materials) {
  const wide = 4 * (RAMP_SAMPLES + RAMP_HEAD)
  const rows = new Float32Array(wide * ramps.length)
  ramps.forEach((ramp, row) => {
    if (!ramp) { return }
    const tones = ramp.tones.map(channels), flat = materials[8 * row + 3] > 0
    const whole = flat ? tones.at(-1) : [0, 1, 2].map((c) => tones.reduce((sum, tone) => sum + tone[c], 0) / tones.length)
    rows.set([1, ramp.stays_flat ? 1 : 0, 0, 0, ...whole], wide * row)
    writeRamp(ramp, RAMP_SAMPLES, rows, wide * row + 4 * RAMP_HEAD)
  })
  return rows
}
