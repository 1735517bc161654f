// The label map: the number of each pixel's material, and its picture over the drawing.

const OUTSIDE = 0xffff, INKED = 0x8000  // as in view.py
const MARK = 4096  // as in corrections.py: marks are its multiples, added to the number of the material
const MARKS = [
  {code: MARK, name: "Ink", tip: "Lines, which stay as drawn", color: [24, 20, 30]},
  {code: 2 * MARK, name: "Highlight", tip: "Light on the paint, which fades as the light moves", color: [255, 255, 240]},
  {code: 3 * MARK, name: "Cast shadow", tip: "A shadow thrown by another part, which fades as the light moves", color: [72, 84, 150]},
  {code: 4 * MARK, name: "Plain paint", tip: "Neither ink nor highlight", color: [150, 150, 156]},
]
const INK_SHADE = [28, 22, 34, 225]
const BESIDE_PIXELS = 3  // of the map beyond the edges of its stage, where its own edge is not seen
const GOLDEN_ANGLE = 180 * (3 - Math.sqrt(5))
const VEIL = [24, 24, 28, 190], BORDER = [255, 255, 255, 235], TINT_ALPHA = 205

// The color of a number, as in toonkit/model/label_colors.py.
const tint = (number) => `oklch(${0.62 + 0.12 * (number % 3)} 0.13 ${number * GOLDEN_ANGLE % 360}deg)`

// What a pixel of the map belongs to: a mark, or the number of a material; -1 beside the object.
function targetOf(raw) {
  if (raw === OUTSIDE) { return -1 }
  const code = raw & ~INKED
  return code < MARK ? code : code - code % MARK
}

// A pixel given to a material, or marked.
const given = (raw, target) => target < MARK ? raw & INKED | target : (raw & ~INKED) % MARK + target

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

function labelMap(stage, frame) {
  const canvas = element(stage, "canvas", "label-map")
  const context = canvas.getContext("2d")
  let width = 0, height = 0, labels = new Uint16Array(0)
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
    const {scale, wide, high, left, top} = frame.place(stage)
    if (!(scale > 0) || labels.length === 0) { places = null; return }
    // The part of a side that is on screen: where it begins there, its length, and the pixel of the picture in each of its own.
    const along = (begin, side, room) => {
      const [from, to] = [Math.max(begin, -BESIDE_PIXELS), Math.min(begin + scale * side, room + BESIDE_PIXELS)]
      const count = Math.round((to - from) * (window.devicePixelRatio || 1))
      const source = Int32Array.from({length: count}, (_, k) => {
        return clamp(Math.floor((from - begin + (k + 0.5) * (to - from) / count) / scale), 0, side - 1)
      })
      return [from, to - from, source]
    }
    const [[x, shownWide, columns], [y, shownHigh, rows]] = [along(left, width, wide), along(top, height, high)]
    if (canvas.width !== columns.length || canvas.height !== rows.length) { [canvas.width, canvas.height] = [columns.length, rows.length] }
    Object.assign(canvas.style, {left: `${x}px`, top: `${y}px`, width: `${shownWide}px`, height: `${shownHigh}px`})
    places = new Uint16Array(columns.length * rows.length)
    let i = 0
    for (const row of rows) {
      for (const column of columns) { places[i++] = labels[row * width + column] }
    }
    const dense = window.devicePixelRatio || 1
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
    for (const raw of values()) {
      const target = targetOf(raw)
      colors[raw] = !tinted ? focus.has(target) ? 0 : packed(VEIL) : raw & INKED && target < MARK ? packed(INK_SHADE)
        : target < MARK ? tintOf(target) : packed([...MARKS[target / MARK - 1].color, TINT_ALPHA])
      group[raw] = focus.has(target) ? OUTSIDE - 1 : target  // no line between two that are shown
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

  // What occurs in the map.
  let known = null
  function values() {
    known ??= new Set(counted().keys())
    return known
  }
  function counted() {
    const counts = new Uint32Array(OUTSIDE)
    for (const raw of labels) { counts[raw] += 1 }
    const found = new Map()
    counts.forEach((count, raw) => { if (count > 0) { found.set(raw, count) } })
    return found
  }

  // How many pixels each material has that are not marked.
  function areas() {
    const found = new Map()
    for (const [raw, count] of counted()) {
      const target = targetOf(raw)
      if (target < MARK) { found.set(target, (found.get(target) ?? 0) + count) }
    }
    return found
  }
  const numbers = () => [...new Set([...values()].map(targetOf).filter((target) => target < MARK))]

  function give(place, target) {
    if (labels[place] === OUTSIDE) { return }
    labels[place] = given(labels[place], target)
    known.add(labels[place])
  }

  const under = (event) => frame.under(stage, event)
  return {
    draw, numbers, areas, under,
    // The number of a new material, as in corrections.py.
    get fresh() { return Math.max(-1, ...[...values()].map((raw) => (raw & ~INKED) % MARK)) + 1 },
    // Where on the stage a place of the picture is.
    onStage([x, y]) {
      const {scale, left, top} = frame.place(stage)
      return [left + x * scale, top + y * scale].map((value) => value.toFixed(1))
    },
    measure() { stale = true },
    get scale() { return frame.place(stage).scale },
    load(nextWidth, nextHeight, next) {
      ;[width, height, labels, known, stale] = [nextWidth, nextHeight, next, null, true]
    },
    // The material or mark under a pointer; -1 beside the object.
    at(event) {
      const [x, y] = under(event).map(Math.floor)
      return x >= 0 && y >= 0 && x < width && y < height ? targetOf(labels[y * width + x]) : -1
    },
    merge(material, into) {
      for (let i = 0; i < labels.length; i++) {
        if (labels[i] !== OUTSIDE && (labels[i] & ~INKED) % MARK === material) { labels[i] += into - material }
      }
      ;[known, stale] = [null, true]
    },
    // Gives what a brush covers on its way from one place to the next to a material or mark, as regions.py does.
    paint([x, y], [toX, toY], radius, material) {
      values()  // counting them anew would take too long while a stroke is drawn
      const [dx, dy] = [toX - x, toY - y]
      const square = Math.max(dx * dx + dy * dy, 1e-12)
      const bottom = Math.min(Math.floor(Math.max(y, toY) + radius), height - 1)
      const right = Math.min(Math.floor(Math.max(x, toX) + radius), width - 1)
      for (let row = Math.max(Math.floor(Math.min(y, toY) - radius), 0); row <= bottom; row++) {
        for (let column = Math.max(Math.floor(Math.min(x, toX) - radius), 0); column <= right; column++) {
          const [px, py] = [column + 0.5 - x, row + 0.5 - y]
          const along = clamp((px * dx + py * dy) / square, 0, 1)
          const near = (px - along * dx) ** 2 + (py - along * dy) ** 2 <= radius ** 2
          if (near) { give(row * width + column, material) }
        }
      }
      stale = true
    },
    // Gives what is connected to the place under a pointer, and of the same material or mark, to another one.
    fill(event, material) {
      const [column, row] = under(event).map(Math.floor)
      values()
      const code = labels[row * width + column] & ~INKED
      const same = (place) => labels[place] !== OUTSIDE && (labels[place] & ~INKED) === code
      const waiting = [row * width + column], seen = new Uint8Array(labels.length)
      seen[waiting[0]] = 1
      while (waiting.length > 0) {
        const place = waiting.pop(), x = place % width
        const beside = [place - width, place + width, x > 0 ? place - 1 : -1, x + 1 < width ? place + 1 : -1]
        for (const next of beside) {
          if (next >= 0 && next < labels.length && !seen[next] && same(next)) { seen[next] = 1; waiting.push(next) }
        }
        give(place, material)
      }
      stale = true
      return [column + 0.5, row + 0.5]
    },
    // Gives what a loop encloses of one material, or of all with -1, to a new one; whether there is anything.
    split(path, material, fresh) {
      let any = false
      values()
      for (let row = 0; row < height; row++) {
        const crossings = path.flatMap(([x, y], k) => {
          const [toX, toY] = path[(k + 1) % path.length]
          return (y <= row + 0.5) !== (toY <= row + 0.5) ? [x + (row + 0.5 - y) / (toY - y) * (toX - x)] : []
        }).sort((one, other) => one - other).map((x) => clamp(Math.ceil(x - 0.5), 0, width))
        for (let k = 0; k + 1 < crossings.length; k += 2) {
          for (let place = row * width + crossings[k]; place < row * width + crossings[k + 1]; place++) {
            const raw = labels[place]
            if (raw !== OUTSIDE && (material < 0 || (raw & ~INKED) === material)) { any = true; give(place, fresh) }
          }
        }
      }
      stale = true
      return any
    },
    count() { known = null },
  }
}
