// The relit picture and its light alone: for notebooks, and for files that need neither Python nor a network.

function render({model}) {
  const root = document.createElement("div")
  root.className = "relight alone"
  element(root, "style", "").textContent = STYLE
  let light = [...model.new_light], scheduled = false, timer = null
  const frame = pictureFrame()

  function send() {
    clearTimeout(timer)
    timer = null
    model.new_light = [...light]
  }
  function move(next) {
    light = next
    schedule()
    timer ??= setTimeout(send, SEND_EVERY_MS)
  }
  const card = lightCard(root, {
    name: "relit", title: model.heading, hint: "Drag the picture or the ball to move the light", angles: light, frame,
    onMove: (next) => { circle.stop(); move(next) }, onRelease: send,
  })
  const circle = orbit(card, () => light, move, send)
  card.button("Reset to original", "Put the light back where the artist had it", () => { circle.stop(); move([...model.analyzed_light]); send() })

  const split = splitSlider(card, element(card.card.querySelector("header"), "div", "icons"))
  // Its keys work where the picture or one of its controls has the focus: the rest of a notebook has keys of its own.
  const keys = {c: split.toggle, ...frame.keys}
  card.stage.tabIndex = -1
  card.stage.addEventListener("pointerdown", (event) => {
    if (event.composedPath()[0] === card.stage) { card.stage.focus({preventScroll: true}) }
  })
  root.addEventListener("keydown", (event) => {
    const action = !event.ctrlKey && !event.metaKey && !event.altKey && keys[event.key.toLowerCase()]
    if (action) {
      event.preventDefault()
      action()
    }
  })

  const shader = painter(card.picture), ball = ballPainter(card.ball)
  if (!shader) { card.card.querySelector("header p").textContent = "This browser cannot relight it: WebGL2 is missing" }
  function draw() {
    scheduled = false
    card.show(light)
    ball.draw(direction(light))
    shader?.draw(uniforms(model, light))
  }
  function schedule() {
    if (!scheduled) { scheduled = true; requestAnimationFrame(draw) }
  }
  let loading = false
  function load() {
    loading = false
    const textures = texturesOf(model)
    root.classList.toggle("empty", textures === null)
    if (!textures) { return }
    const recolored = floats(model.recolored)
    frame.load(textures)
    split.load(textures)
    shader?.load(textures)
    shader?.recolor(recolored.length > 0 ? recolored : null)
    ball.load(...shownMap(textures.maps, textures.materials, [], recolored))
    schedule()
  }
  for (const name of [...TEXTURES, "recolored"]) {
    model.on(`change:${name}`, () => { if (!loading) { loading = true; setTimeout(load) } })
  }
  for (const name of LOOKS) { model.on(`change:${name}`, schedule) }
  model.on("change:new_light", () => { if (timer === null && !circle.on) { light = [...model.new_light]; schedule() } })
  const resized = new ResizeObserver(() => {
    for (const shown of [frame, card, split]) { shown.measure() }
    schedule()
  })
  resized.observe(root)
  shader?.onRestored(schedule)
  model.on("remove", () => { circle.stop(); clearTimeout(timer); resized.disconnect(); shader?.release() })
  load()
  return root
}

export default {render}
