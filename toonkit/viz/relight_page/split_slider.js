// The relit picture beside the drawing: left of a divider as painted, right of it relit.
//
// Two parts of the stage are cut off at the divider, which costs nothing while the light is dragged. The divider stays where
// it is on the stage when the picture is magnified or moved: a detail that is looked at is brought to it.

const SPLIT_STEP = 0.01, SPLIT_STRIDE = 0.1  // shares of the stage that arrow keys go, alone and with Shift
const SPLIT = `<svg viewBox="0 0 24 24"><path d="M12 5h7a2 2 0 0 1 2 2v10a2 2 0 0 1-2 2h-7z" fill="currentColor"/>
<path d="M12 5H5a2 2 0 0 0-2 2v10a2 2 0 0 0 2 2h7M12 2v20"/></svg>`
const GRIP = `<svg viewBox="0 0 24 24"><path d="M9 7l-5 5 5 5M15 7l5 5-5 5"/></svg>`

// Puts a slider on the stage of a card, and the button that shows it among `icons`.
function splitSlider({stage, picture, pictureImage, handles}, icons) {
  const [before, after] = ["before", "after"].map((name) => element(stage, "div", `half ${name}`))
  const drawing = element(before, "canvas", "picture")
  const divider = element(stage, "div", "divider", `<i>${GRIP}</i>`)
  const button = element(icons, "button", "", SPLIT)
  stage.prepend(before, after, divider)
  after.append(picture, pictureImage)
  Object.assign(button, {type: "button", title: "Compare with the drawing (C)"})
  button.setAttribute("aria-label", "Compare with the drawing")
  divider.tabIndex = 0
  for (const [name, value] of [["role", "slider"], ["aria-label", "How much is shown as drawn"], ["aria-orientation", "horizontal"],
    ["aria-valuemin", 0], ["aria-valuemax", 100]]) { divider.setAttribute(name, value) }

  let on = false, share = 0.5, painted = null

  function show() {
    const percent = Math.round(100 * share)
    stage.style.setProperty("--split", `${on ? Math.round(share * stage.clientWidth) : 0}px`)
    before.hidden = divider.hidden = !on
    stage.classList.toggle("split", on)
    button.setAttribute("aria-pressed", on)
    divider.setAttribute("aria-valuenow", percent)
    divider.setAttribute("aria-valuetext", `${percent} % as drawn`)
    if (on && painted) {
      const {width, height, color} = painted
      ;[drawing.width, drawing.height, painted] = [width, height, null]
      drawing.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(color), width, height), 0, 0)
    }
  }
  function toggle() {
    on = !on
    show()
  }
  function move(next) {
    share = clamp(next, 0, 1)
    show()
  }

  button.addEventListener("click", toggle)
  let grabbed = 0  // how far from the divider it is held
  const at = (event) => (event.clientX - stage.getBoundingClientRect().left) / stage.clientWidth
  handles.set(divider, {
    press(event) {
      grabbed = at(event) - share
      divider.focus({preventScroll: true})
      stage.classList.add("splitting")
    },
    move(event) { move(at(event) - grabbed) },
    release() { stage.classList.remove("splitting") },
  })
  divider.addEventListener("keydown", (event) => {
    const step = event.shiftKey ? SPLIT_STRIDE : SPLIT_STEP
    const next = {
      ArrowLeft: share - step, ArrowDown: share - step, ArrowRight: share + step, ArrowUp: share + step,
      PageDown: share - SPLIT_STRIDE, PageUp: share + SPLIT_STRIDE, Home: 0, End: 1,
    }[event.key]
    if (next === undefined || event.ctrlKey || event.metaKey || event.altKey) { return }
    event.preventDefault()
    move(next)
  })
  show()
  return {
    toggle,
    measure: show,
    // Takes the drawing as painted: a canvas is filled only when it is looked at.
    load(textures) {
      painted = textures
      show()
    },
  }
}
