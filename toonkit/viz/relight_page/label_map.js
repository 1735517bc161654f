// The label map: the number of each pixel's material, and its picture over the drawing.

const OUTSIDE = 0xffff
const PICTURE_INSET = 12  // pixels around a picture on its stage
const GOLDEN_ANGLE = 180 * (3 - Math.sqrt(5))
const VEIL = [24, 24, 28, 190], BORDER = [255, 255, 255, 235], TINT_ALPHA = 205

// The color of a number, as in toonkit/model/label_colors.py.
const tint = (number) => `oklch(${0.62 + 0.12 * (number % 3)} 0.13 ${number * GOLDEN_ANGLE % 360}deg)`

// Colors as the four bytes of a pixel, as one number.
const packed = ([red, green, blue, alpha]) => (alpha << 24 | blue << 16 | green << 8 | red) >>> 0

const readColor = (() => {
  const context = new OffscreenCanvas(1, 1).getContext("2d", {willReadFrequently: true})
  return (color, alpha) => {
    context.fillStyle = color
    context.fillRect(0, 0, 1, 1)
    return [...context.getImageData(0, 0, 1, 1).data.slice(0, 3), alpha]
  }
})()

async function inflated(deflated) {
  const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate"))
  return new Uint16Array(await new Response(stream).arrayBuffer())
}

function labelMap(stage) {
  const canvas = element(stage, "canvas", "label-map")
  const context = canvas.getContext("2d")
  let width = 0, height = 0, labels = new Uint16Array(0)
  let scale = 1, left = 0, top = 0  // pixels on screen for one of the picture, and where that begins
  let places = null, stale = true, accent = 0, thick = 2
  const [colors, group] = [new Uint32Array(OUTSIDE + 1), new Uint16Array(OUTSIDE + 1).fill(OUTSIDE)]
  const tints = new Map()

  function tintOf(number) {
    if (!tints.has(number)) { tints.set(number, packed(readColor(tint(number), TINT_ALPHA))) }
    return tints.get(number)
  }

  // Looks up each pixel on screen, so that lines are sharp and cost the same however large the picture is.
  function place() {
    stale = false
    const [wide, high] = [stage.clientWidth - 2 * PICTURE_INSET, stage.clientHeight - 2 * PICTURE_INSET]
    if (wide <= 0 || high <= 0 || labels.length === 0) { places = null; return }
    scale = Math.min(wide / width, high / height)
    ;[left, top] = [(wide - scale * width) / 2, (high - scale * height) / 2]
    const dense = window.devicePixelRatio || 1
    const [columns, rows] = [Math.round(scale * width * dense), Math.round(scale * height * dense)]
    if (canvas.width !== columns || canvas.height !== rows) { [canvas.width, canvas.height] = [columns, rows] }
    Object.assign(canvas.style, {
      left: `${PICTURE_INSET + left}px`, top: `${PICTURE_INSET + top}px`,
      width: `${scale * width}px`, height: `${scale * height}px`,
    })
    const source = new Int32Array(columns)
    for (let column = 0; column < columns; column++) { source[column] = Math.floor((column + 0.5) * width / columns) }
    places = new Uint16Array(columns * rows)
    for (let row = 0, i = 0; row < rows; row++) {
      const start = Math.floor((row + 0.5) * height / rows) * width
      for (let column = 0; column < columns; column++, i++) { places[i] = labels[start + source[column]] }
    }
    thick = Math.round(2 * dense)
    accent = packed(readColor(getComputedStyle(stage).getPropertyValue("--accent"), 255))
  }

  // Shows some materials as they are drawn and veils the rest; with none, each in its tint.
  function draw(focus) {
    if (stale) { place() }
    if (!places) { return }
    const [columns, tinted] = [canvas.width, focus.size === 0]
    const image = context.createImageData(columns, canvas.height)
    const data = new Uint32Array(image.data.buffer)
    for (const number of numbers()) {
      colors[number] = tinted ? tintOf(number) : focus.has(number) ? 0 : packed(VEIL)
      group[number] = focus.has(number) ? OUTSIDE - 1 : number  // no line between two that are shown
    }
    const line = tinted ? packed(BORDER) : accent
    const [along, across] = tinted ? [1, columns] : [thick, thick * columns]
    for (let i = 0; i < data.length; i++) {
      const number = places[i]
      const own = group[number]
      const lined = number !== OUTSIDE && (tinted || own === OUTSIDE - 1) && (
        group[places[i + along]] !== own || group[places[i + across]] !== own
        || (!tinted && (group[places[i - along]] !== own || group[places[i - across]] !== own)))
      data[i] = lined ? line : colors[number]
    }
    context.putImageData(image, 0, 0)
  }

  let known = null
  function numbers() {
    known ??= [...areas().keys()].sort((one, other) => one - other)
    return known
  }

  // How many pixels each material has.
  function areas() {
    const counts = new Uint32Array(OUTSIDE)
    for (const number of labels) { counts[number] += 1 }
    const found = new Map()
    counts.forEach((count, number) => { if (count > 0) { found.set(number, count) } })
    return found
  }

  // Where on the picture a pointer is, in its pixels.
  function under(event) {
    const box = stage.getBoundingClientRect()
    return [
      (event.clientX - box.left - PICTURE_INSET - left) / scale, (event.clientY - box.top - PICTURE_INSET - top) / scale,
    ]
  }
  return {
    draw, numbers, areas, under,
    measure() { stale = true },
    get scale() { return scale },
    get longest() { return Math.max(width, height) },
    load(nextWidth, nextHeight, next) {
      ;[width, height, labels, known, stale] = [nextWidth, nextHeight, next, null, true]
    },
    // The number under a pointer; -1 beside the object.
    at(event) {
      const [x, y] = under(event).map(Math.floor)
      const number = x >= 0 && y >= 0 && x < width && y < height ? labels[y * width + x] : OUTSIDE
      return number === OUTSIDE ? -1 : number
    },
    merge(material, into) {
      for (let i = 0; i < labels.length; i++) { if (labels[i] === material) { labels[i] = into } }
      ;[known, stale] = [null, true]
    },
    // Gives what a brush covers on its way from one place to the next to a material, as corrections.py does.
    paint([x, y], [toX, toY], radius, material) {
      const [dx, dy] = [toX - x, toY - y]
      const square = Math.max(dx * dx + dy * dy, 1e-12)
      const bottom = Math.min(Math.floor(Math.max(y, toY) + radius), height - 1)
      const right = Math.min(Math.floor(Math.max(x, toX) + radius), width - 1)
      for (let row = Math.max(Math.floor(Math.min(y, toY) - radius), 0); row <= bottom; row++) {
        for (let column = Math.max(Math.floor(Math.min(x, toX) - radius), 0); column <= right; column++) {
          const [px, py] = [column + 0.5 - x, row + 0.5 - y]
          const along = clamp((px * dx + py * dy) / square, 0, 1)
          const near = (px - along * dx) ** 2 + (py - along * dy) ** 2 <= radius ** 2
          if (near && labels[row * width + column] !== OUTSIDE) { labels[row * width + column] = material }
        }
      }
      ;[known, stale] = [[...new Set([...numbers(), material])], true]  // counting them again would take too long here
    },
    count() { known = null },
  }
}
