// A path for the new light, through key lights, with the same time between any two. `toonkit.model.light_path` computes the
// same path when the animation is written.

const MOST_KEY_LIGHTS = 12
const CHIP_PIXELS = 68  // twice a chip's size on screen
const PLAYHEAD_STEPS = 1000
const SAME_LIGHT = 0.5  // degrees

const ADD = `<svg viewBox="0 0 24 24"><path d="M11 5h2v6h6v2h-6v6h-2v-6H5v-2h6z"/></svg>`
const LOOP = `<svg viewBox="0 0 24 24"><path d="M17 2l4 4-4 4M3 12v-2a4 4 0 0 1 4-4h14M7 22l-4-4 4-4M21 12v2a4 4 0 0 1-4 4H3"/></svg>`
const EARLIER = `<svg viewBox="0 0 24 24"><path d="M15 5l-7 7 7 7"/></svg>`
const LATER = `<svg viewBox="0 0 24 24"><path d="M9 5l7 7-7 7"/></svg>`
const REMOVE = `<svg viewBox="0 0 24 24"><path d="M6 6l12 12M18 6L6 18"/></svg>`

const PATH_STYLE = `
.light-path { grid-column: 1 / -1; }
.light-path .actions { display: flex; gap: 6px; align-items: center; margin-left: auto; flex-wrap: wrap; }
.light-path .actions button, .light-path .seconds { height: 28px; padding: 2px 9px; }
.light-path .actions .icon { padding: 4px; min-width: 28px; justify-content: center; }
.light-path svg { fill: none; stroke: currentColor; stroke-width: 2; stroke-linecap: round; stroke-linejoin: round; margin: 0; }
.light-path .play svg { fill: currentColor; stroke: none; }
.light-path button[aria-pressed=true].loop { background: var(--accent); border-color: var(--accent); color: #1c1206; }
.light-path .seconds { display: flex; align-items: center; gap: 6px; color: var(--soft); padding: 0; margin-left: 6px; }
.light-path .seconds input { width: 58px; height: 28px; font: inherit; color: var(--ink); background: transparent; border-radius: 7px;
  border: 1px solid color-mix(in srgb, var(--ink) 26%, transparent); padding: 2px 4px 2px 8px; }
.light-path .along { display: flex; gap: 8px; align-items: center; padding: 4px 16px 12px; }
.light-path .play { width: 76px; justify-content: center; }
.light-path .track-box { position: relative; flex: 1; min-width: 0; height: 64px; }
.light-path .keys { position: absolute; left: 22px; right: 22px; top: 2px; height: 40px; }
.light-path .key { position: absolute; top: 0; width: 40px; height: 40px; margin-left: -20px; padding: 0; border: 3px solid transparent;
  border-radius: 50%; background: none; touch-action: none; justify-content: center; }
.light-path .key canvas { width: 34px; height: 34px; border-radius: 50%; box-shadow: 0 0 0 1px var(--line), 0 1px 4px rgba(0, 0, 0, .4); }
.light-path .key[aria-pressed=true] { border-color: var(--accent); }
.light-path .key.carried { z-index: 1; opacity: .8; cursor: grabbing; }
.light-path input[type=range] { position: absolute; left: 15px; bottom: 0; width: calc(100% - 30px); }
.light-path input:disabled { opacity: .4; cursor: default; }
@container (max-width: 850px) {
  .light-path { order: -1; }
  .light-path header p { display: none; }
}
@container (max-width: 600px) {
  .light-path .actions { margin-left: 0; }
  .light-path .along { gap: 0; }
  .light-path .play { width: 40px; font-size: 0; gap: 0; }
}
`

// The light at a share, 0 to 1, of the shortest way between two, all as unit vectors.
function lightBetween(start, end, share) {
  const dot = (one, other) => one[0] * other[0] + one[1] * other[1] + one[2] * other[2]
  const less = (vector, part) => vector.map((value, k) => value - part * start[k])
  const cosine = dot(start, end)
  let ahead = less(end, cosine)
  const sine = Math.hypot(...ahead)
  if (sine < 1e-9) {  // opposite lights: toward the viewer; from a light at the viewer's eye, over the top
    const upward = Math.abs(start[2]) < 1 - 1e-9 ? [0, 0, 1] : [0, 1, 0]
    ahead = less(upward, dot(upward, start))
  }
  const turn = share * Math.atan2(sine, cosine), length = Math.hypot(...ahead)
  return start.map((value, k) => Math.cos(turn) * value + Math.sin(turn) * ahead[k] / length)
}

// Azimuth and elevation of the light at a place, 0 to 1, of a path through key lights.
function lightOnPath(keys, loops, place) {
  const ends = (loops ? [...keys, keys[0]] : keys).map(direction)
  const way = place * (ends.length - 1), start = Math.min(Math.floor(way), ends.length - 2)
  const [x, y, z] = lightBetween(ends[start], ends[start + 1], way - start)
  return [Math.atan2(y, x) * 180 / Math.PI, Math.asin(clamp(z, -1, 1)) * 180 / Math.PI]
}

function isSameLight(one, other) {
  const [a, b] = [direction(one), direction(other)]
  return Math.hypot(...a.map((value, k) => value - b[k])) < radians(SAME_LIGHT)
}

// Puts the strip below the cards, and the button that adds a key light on the card `relit`. `host` has the light, moves it, shows
// it without telling Python (preview), and lets go of it; `changed` is called with the path whenever it changes.
function lightPath(root, relit, host, changed) {
  const strip = element(root, "section", "card light-path", `<style>${PATH_STYLE}</style>
    <header><h2>Light path</h2><p></p><div class="actions"></div></header><div class="along"></div>`)
  strip.setAttribute("aria-label", "Light path")
  const [hint, actions, along] = ["p", ".actions", ".along"].map((name) => strip.querySelector(name))
  let keys = [], seconds = 3, loops = true
  let selected = -1, place = 0, on = false

  function button(parent, className, content, tip, onClick) {
    const node = element(parent, "button", className, content)
    Object.assign(node, {type: "button", title: tip})
    node.setAttribute("aria-label", tip)
    node.addEventListener("click", onClick)
    return node
  }
  const adder = relit.button("", "Add this light to the light path", add)
  adder.innerHTML = `${ADD}Key light`
  const replacer = button(actions, "", "Replace", "Replace the chosen key light with the current light", () => put(keys.with(selected, [...host.light()])))
  const earlier = button(actions, "icon", EARLIER, "Move the chosen key light ahead of the previous one", () => carry(selected, selected - 1))
  const later = button(actions, "icon", LATER, "Move the chosen key light behind the next one", () => carry(selected, selected + 1))
  const remover = button(actions, "icon", REMOVE, "Remove the chosen key light", () => remove(selected))
  const duration = element(actions, "label", "seconds", `<input type="number" min="0.5" max="10" step="0.5" aria-label="Seconds that the path takes">s`).firstElementChild
  const loop = button(actions, "icon loop", LOOP, "Return to the first key light, and start again", () => { loops = !loops; tell() })
  const player = button(along, "play", "", "Let the light travel along the path", () => { if (on) { stop() } else { start() } })
  const box = element(along, "div", "track-box")
  const row = element(box, "div", "keys")
  const playhead = element(box, "input", "")
  Object.assign(playhead, {type: "range", min: 0, max: PLAYHEAD_STEPS, step: 1})
  playhead.setAttribute("aria-label", "Place of the light on the path")

  const placeOf = (index) => keys.length < 2 ? 0 : index / (loops ? keys.length : keys.length - 1)

  function add() {
    stop()
    if (keys.length >= MOST_KEY_LIGHTS) { return }
    const at = selected < 0 ? keys.length : selected + 1
    selected = at
    put(keys.toSpliced(at, 0, [...host.light()]))
  }
  function remove(index) {
    stop()
    const focused = row.contains(root.getRootNode().activeElement)
    selected = Math.min(index, keys.length - 2)
    put(keys.toSpliced(index, 1))
    if (focused) { (row.children[selected] ?? adder).focus() }
  }
  function carry(from, to) {
    const key = keys[from]
    selected = clamp(to, 0, keys.length - 1)
    put(keys.toSpliced(from, 1).toSpliced(selected, 0, key))
  }
  function put(next) {
    keys = next
    place = placeOf(Math.max(selected, 0))
    tell()
  }
  function tell() {
    fill()
    changed({keys, seconds, loops})
  }
  function go(index) {
    stop()
    selected = index
    place = placeOf(index)
    host.move([...keys[index]])
    host.letGo()
    show()
  }

  function start() {
    if (keys.length < 2) { return }
    host.begin()
    on = true
    if (!loops && place >= 1) { place = 0 }
    let before = performance.now()
    const travel = (now) => {
      if (!on || !strip.isConnected) { on = false; return }
      place += Math.max(now - before, 0) / 1000 / seconds
      before = now
      if (loops) { place %= 1 }
      place = Math.min(place, 1)
      host.preview(lightOnPath(keys, loops, place))
      playhead.value = Math.round(place * PLAYHEAD_STEPS)
      if (place >= 1) { stop() } else { requestAnimationFrame(travel) }
    }
    requestAnimationFrame(travel)
    show()
  }
  function stop() {
    if (!on) { return }
    on = false
    host.letGo()
    show()
  }

  function chip(key, index) {
    const node = document.createElement("button")
    node.type = "button"
    node.className = "key"
    node.style.left = `${100 * placeOf(index)}%`
    const [azimuth, elevation] = shown(key)
    node.title = `Key light ${index + 1} of ${keys.length}: azimuth ${azimuth}°, elevation ${elevation}°`
    node.setAttribute("aria-label", node.title)
    const canvas = element(node, "canvas", "")
    canvas.width = canvas.height = CHIP_PIXELS
    node.addEventListener("keydown", (event) => {
      if (["Delete", "Backspace"].includes(event.key)) { event.preventDefault(); event.stopPropagation(); remove(index) }
    })
    dragged(node, index)
    return node
  }
  // A chip that is dragged sideways is dropped where it belongs in the order; one that is pressed takes the light there.
  function dragged(node, index) {
    let from = null, carried = false
    const share = (event) => (event.clientX - row.getBoundingClientRect().left) / row.clientWidth
    node.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) { return }
      node.setPointerCapture(event.pointerId)
      from = event.clientX
    })
    node.addEventListener("pointermove", (event) => {
      if (from === null || (!carried && Math.abs(event.clientX - from) < TAP_PIXELS)) { return }
      carried = true
      node.classList.add("carried")
      node.style.left = `${100 * clamp(share(event), 0, 1)}%`
    })
    node.addEventListener("lostpointercapture", () => { from = null })
    node.addEventListener("pointerup", (event) => {
      if (carried) { carry(index, Math.round(share(event) * (loops ? keys.length : keys.length - 1))) }
    })
    node.addEventListener("click", (event) => { if (!carried || event.detail === 0) { go(index) } })
  }

  function fill() {
    selected = Math.min(selected, keys.length - 1)
    row.replaceChildren(...keys.map(chip))
    duration.value = seconds
    paint()
    show()
  }
  // Each chip is the ball on the card, under its own light.
  function paint() {
    const canvases = row.querySelectorAll("canvas")
    keys.forEach((key, index) => {
      const context = canvases[index].getContext("2d")
      context.clearRect(0, 0, CHIP_PIXELS, CHIP_PIXELS)
      context.drawImage(host.ballUnder(key), 0, 0, CHIP_PIXELS, CHIP_PIXELS)
    })
    if (keys.length > 0) { host.redraw() }
  }
  function show() {
    const travels = keys.length > 1
    strip.hidden = keys.length === 0
    adder.disabled = keys.length >= MOST_KEY_LIGHTS
    hint.textContent = travels ? "Press a key light to go there; drag one to change the order" : "Move the light, and add another key light"
    ;[...row.children].forEach((node, index) => node.setAttribute("aria-pressed", index === selected))
    player.innerHTML = on ? `${PAUSE}Pause` : `${PLAY}Play`
    player.setAttribute("aria-label", on ? "Let the light rest" : "Let the light travel along the path")
    player.disabled = playhead.disabled = !travels
    playhead.value = Math.round(place * PLAYHEAD_STEPS)
    loop.setAttribute("aria-pressed", loops)
    const chosen = selected >= 0
    remover.disabled = !chosen
    earlier.disabled = selected < 1
    later.disabled = !chosen || selected === keys.length - 1
    compare()
  }
  function compare() { replacer.disabled = selected < 0 || isSameLight(keys[selected], host.light()) }

  playhead.addEventListener("input", () => {
    stop()
    place = Number(playhead.value) / PLAYHEAD_STEPS
    host.move(lightOnPath(keys, loops, place))
    show()
  })
  playhead.addEventListener("change", host.letGo)
  duration.addEventListener("change", () => {
    seconds = clamp(Number(duration.value) || seconds, 0.5, 10)
    tell()
  })
  show()
  return {
    stop, paint, compare,
    get on() { return on },
    // Takes a path that was set in Python, for instance after "undo".
    load(next) {
      if (JSON.stringify([keys, seconds, loops]) === JSON.stringify([next.keys, next.seconds, next.loops])) { return }
      stop()
      ;({keys, seconds, loops} = next)
      fill()
    },
  }
}
