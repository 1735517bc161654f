// What is said about the shape, over the drawing: its normals as colors, and the parts that bulge, are flat or in front.

// Bits as in shape_marks.py.
const SHAPE_PARTS = [
  {kind: "bulge", bit: 1, name: "Bulge", tip: "A part that bulges toward you", color: [255, 122, 40]},
  {kind: "flat", bit: 2, name: "Flat", tip: "A part that is flat", color: [20, 200, 210]},
  {kind: "in_front", bit: 4, name: "In front", tip: "A part that ends in front of what is around it: paint all of it", color: [236, 60, 200]},
  {kind: "", bit: 0, name: "Erase", tip: "Remove marks and arrows here", color: [150, 150, 156]},
]
const NORMALS_ALPHA = 185, MARK_SHARE = 0.4, FACING_AWAY = 0.75  // a projected normal is never longer than 0.71

// The values of all half-precision floats, by their bits.
const halves = (() => {
  let table = null
  return () => table ??= Float32Array.from({length: 1 << 16}, (_, bits) => {
    const [sign, exponent, fraction] = [bits & 0x8000 ? -1 : 1, bits >> 10 & 31, bits & 1023]
    return exponent === 0 ? sign * fraction * 2 ** -24 : sign * (1 + fraction / 1024) * 2 ** (exponent - 15)
  })
})()

// Normals (x, y, z) of each pixel from their texture, see RelightTextures in textures.py; NaN outside the object.
function readNormals(texture, count) {
  const full = texture.length === 8 * count
  const copy = texture.slice().buffer
  const [values, table] = full ? [new Float32Array(copy), null] : [new Uint16Array(copy), halves()]
  const normals = new Float32Array(3 * count).fill(NaN)
  for (let pixel = 0; pixel < count; pixel++) {
    const [u, v] = [values[2 * pixel], values[2 * pixel + 1]]
    const [x, y] = full ? [u, v] : [table[u], table[v]]
    const square = x * x + y * y
    if (square > FACING_AWAY * FACING_AWAY) { continue }
    const scale = 2 * Math.sqrt(1 - square)
    normals[3 * pixel] = x * scale
    normals[3 * pixel + 1] = y * scale
    normals[3 * pixel + 2] = 1 - 2 * square
  }
  return normals
}

async function inflatedBytes(deflated) {
  const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate"))
  return new Uint8Array(await new Response(stream).arrayBuffer())
}

function shapeMap(stage, frame) {
  const canvas = element(stage, "canvas", "shape-map")
  const context = canvas.getContext("2d")
  let width = 0, height = 0, image = null, shown = true
  let normals = new Float32Array(0), marks = new Uint8Array(0)
  const colors = Array.from({length: 8}, (_, bits) => {
    const own = SHAPE_PARTS.filter(({bit}) => bits & bit).map(({color}) => color)
    return own.length === 0 ? null : [0, 1, 2].map((k) => own.reduce((sum, color) => sum + color[k], 0) / own.length)
  })
  const isInside = (pixel) => !Number.isNaN(normals[3 * pixel])

  function lie() {
    const {scale, left, top} = frame.place(stage)
    Object.assign(canvas.style, {left: `${left}px`, top: `${top}px`, width: `${scale * width}px`, height: `${scale * height}px`})
  }
  // Whether the marks end at a pixel.
  function isBorder(pixel, column, row) {
    const own = marks[pixel]
    return (column > 0 && marks[pixel - 1] !== own) || (column + 1 < width && marks[pixel + 1] !== own)
      || (row > 0 && marks[pixel - width] !== own) || (row + 1 < height && marks[pixel + width] !== own)
  }
  // Redraws a part of the picture: a stroke changes little of a large one.
  function draw(left = 0, top = 0, right = width, bottom = height) {
    if (!image) { return }
    for (let row = top; row < bottom; row++) {
      for (let column = left; column < right; column++) {
        const pixel = row * width + column
        if (!isInside(pixel)) { continue }
        const tint = colors[marks[pixel]]
        const share = !tint ? 0 : isBorder(pixel, column, row) ? 1 : MARK_SHARE
        const alpha = shown ? NORMALS_ALPHA : 0
        for (let k = 0; k < 3; k++) {
          const normal = shown ? 127.5 * (normals[3 * pixel + k] + 1) : tint ? tint[k] : 0
          image.data[4 * pixel + k] = tint ? normal + share * (tint[k] - normal) : normal
        }
        image.data[4 * pixel + 3] = Math.max(alpha, 255 * share)
      }
    }
    context.putImageData(image, 0, 0, left, top, right - left, bottom - top)
  }
  return {
    get scale() { return frame.place(stage).scale },
    get hasMarks() { return marks.some((mark) => mark > 0) },
    lie, draw,
    under: (event) => frame.under(stage, event),
    onStage([x, y]) {
      const {scale, left, top} = frame.place(stage)
      return [left + x * scale, top + y * scale]
    },
    showNormals(on) { shown = on; draw() },
    // The normal at a place of the picture; null beside the object.
    normalAt([x, y]) {
      const [column, row] = [Math.floor(x), Math.floor(y)]
      const pixel = row * width + column
      if (!(column >= 0 && row >= 0 && column < width && row < height) || !isInside(pixel)) { return null }
      return [...normals.subarray(3 * pixel, 3 * pixel + 3)]
    },
    load(nextWidth, nextHeight, nextNormals, nextMarks) {
      if (nextWidth !== width || nextHeight !== height || !image) {
        ;[canvas.width, canvas.height] = [width, height] = [nextWidth, nextHeight]
      }
      image = context.createImageData(width, height)
      ;[normals, marks] = [nextNormals, nextMarks]
      lie()
      draw()
    },
    // Marks what a brush covers on its way from one place to the next, as regions.py does.
    paint([x, y], [toX, toY], radius, bit) {
      const [dx, dy] = [toX - x, toY - y]
      const square = Math.max(dx * dx + dy * dy, 1e-12)
      const [left, right] = [Math.max(Math.floor(Math.min(x, toX) - radius), 0), Math.min(Math.ceil(Math.max(x, toX) + radius), width)]
      const [top, bottom] = [Math.max(Math.floor(Math.min(y, toY) - radius), 0), Math.min(Math.ceil(Math.max(y, toY) + radius), height)]
      for (let row = top; row < bottom; row++) {
        for (let column = left; column < right; column++) {
          const [px, py] = [column + 0.5 - x, row + 0.5 - y]
          const along = clamp((px * dx + py * dy) / square, 0, 1)
          if ((px - along * dx) ** 2 + (py - along * dy) ** 2 <= radius ** 2) { marks[row * width + column] = bit }
        }
      }
      draw(Math.max(left - 1, 0), Math.max(top - 1, 0), Math.min(right + 1, width), Math.min(bottom + 1, height))
    },
  }
}
