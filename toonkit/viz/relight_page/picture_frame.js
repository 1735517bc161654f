// Where a picture lies on its stages: fitted, or magnified and moved, alike on all of them.
//
// The one place that maps between the page and the picture: what is drawn on a stage asks it where, and what is pressed asks
// it for the pixel. The light and the split slider belong to the stage, not to the picture: they stay within reach.

const PICTURE_INSET = 12  // pixels on screen around a fitted picture
const MOST_MAGNIFIED = 32  // pixels on screen for one of the picture, or four times the fitted size of a tiny one
const SPRITE_SIDE = 160  // up to which a picture is shown pixel by pixel, however it is magnified
const CRISP_FROM = 2  // pixels of the screen for one of the picture: below, some would be shown wider than others
const KEY_ZOOM = Math.SQRT2

function pictureFrame() {
  const sizes = new Map(), followers = []
  let width = 0, height = 0, color = [], zoom = 1
  let middle = [0.5, 0.5]  // what is shown in the middle of the stages, as shares of the picture's sides

  // Pixels on screen for one of the picture, where on the stage that begins, and whether pixels are shown as squares.
  function place(stage) {
    const {wide, high} = sizes.get(stage)
    const fitted = Math.max(Math.min((wide - 2 * PICTURE_INSET) / width, (high - 2 * PICTURE_INSET) / height), 0)
    const scale = zoom * fitted
    const crisp = longest() <= SPRITE_SIDE || scale * (window.devicePixelRatio || 1) >= CRISP_FROM
    return {scale, fitted, crisp, wide, high, left: begin(wide, scale * width, middle[0]), top: begin(high, scale * height, middle[1])}
  }
  // No edge of a magnified picture comes further in than that of a fitted one; what is smaller than the stage is centered.
  function begin(room, length, share) {
    const least = Math.min(room - PICTURE_INSET - length, (room - length) / 2)
    return clamp(room / 2 - share * length, least, Math.max(PICTURE_INSET, (room - length) / 2))
  }
  const longest = () => Math.max(width, height)

  // Magnifies the picture and moves it to a place of a stage; whether that changed anything.
  function put(stage, nextZoom, left, top) {
    const before = place(stage)
    zoom = nextZoom
    middle = [(before.wide / 2 - left) / (zoom * before.fitted * width), (before.high / 2 - top) / (zoom * before.fitted * height)]
    const after = place(stage)
    middle = [  // within the edges, or a way beyond them would have to be gone back first
      (after.wide / 2 - after.left) / (after.scale * width), (after.high / 2 - after.top) / (after.scale * height),
    ]
    const changed = ["scale", "left", "top"].some((name) => Math.abs(after[name] - before[name]) > 1e-6)
    if (changed) { tell() }
    return changed
  }
  const tell = () => { for (const follower of followers) { follower() } }
  const ready = (stage) => width > 0 && place(stage).fitted > 0

  function onStage(stage, {clientX, clientY}) {
    const box = stage.getBoundingClientRect()
    return [clientX - box.left, clientY - box.top]
  }
  function zoomAt(stage, factor, [x, y]) {
    if (!ready(stage)) { return }
    const {scale, fitted, left, top} = place(stage)
    const next = clamp(zoom * factor, 1, Math.max(MOST_MAGNIFIED / fitted, 4))
    const grown = next * fitted / scale
    put(stage, next, x - (x - left) * grown, y - (y - top) * grown)
  }
  function zoomByKey(factor) {
    const [[stage, {wide, high}]] = sizes
    zoomAt(stage, factor, [wide / 2, high / 2])
  }
  function fit() {
    ;[zoom, middle] = [1, [0.5, 0.5]]
    tell()
  }

  return {
    place, fit, zoomAt, onStage,
    get zoomed() { return zoom > 1 },
    get longest() { return longest() },
    add(stage) { sizes.set(stage, {wide: 0, high: 0}) },
    // What is called when the picture has moved on its stages.
    follow(follower) { followers.push(follower) },
    measure() {
      for (const stage of sizes.keys()) { sizes.set(stage, {wide: stage.clientWidth, high: stage.clientHeight}) }
      tell()
    },
    // Takes a picture. Another analysis of the same drawing, which has the same outline, stays as it is looked at.
    load(next) {
      const same = next.width === width && next.height === height && haveSameAlpha(next.color, color)
      ;({width, height, color} = next)
      if (same) { tell() } else { fit() }
    },
    // Where on the picture a pointer is, in its pixels.
    under(stage, event) {
      const {scale, left, top} = place(stage)
      const [x, y] = onStage(stage, event)
      return [(x - left) / scale, (y - top) / scale]
    },
    pan(stage, dx, dy) {
      if (!ready(stage)) { return false }
      const {left, top} = place(stage)
      return put(stage, zoom, left + dx, top + dy)
    },
    keys: {"0": fit, "+": () => zoomByKey(KEY_ZOOM), "=": () => zoomByKey(KEY_ZOOM), "-": () => zoomByKey(1 / KEY_ZOOM)},
  }
}

function haveSameAlpha(one, other) {
  for (let at = 3; at < one.length; at += 4) { if (one[at] !== other[at]) { return false } }
  return true
}
