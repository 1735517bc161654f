// What a hand does on a stage: use its tool, or zoom and pan the picture.

const TAP_PIXELS = 4  // up to which a press that moves is still a tap
const HOLD_MS = 200  // from which on a press that rests is no tap any more
const DOUBLE_MS = 300, DOUBLE_PIXELS = 24  // between the taps of a double tap
const WHEEL_MOST = 24, WHEEL_ZOOM = 0.01  // a notch of a mouse counts as little as a short pinch of a trackpad
const LINE_PIXELS = 16  // of wheels that count lines

// Whether a key is typed into something that needs it.
function isTyped(event) {
  const node = event.composedPath()[0]
  return node.isContentEditable || node.tagName === "TEXTAREA" || (node.tagName === "INPUT" && !["range", "checkbox", "color"].includes(node.type))
}

// `toolAt` returns what a single pointer uses where it is pressed: press, move and release take its events. A `patient` tool gets
// a tap on a magnified picture only once no second tap has followed; where `doubles` is set, a second tap fits the picture.
function gestures(stage, frame, toolAt) {
  const pressed = new Map()  // where on the stage each pressed pointer is
  let doing = null  // wait, use, pan, pinch, or rest until all pointers are up
  let first = null, using = null, timer = null
  let lastTap = {time: -Infinity}, tapTimer = null, waitingTap = null

  const away = ([x, y], [fromX, fromY]) => Math.hypot(x - fromX, y - fromY)

  function use(event) {
    clearTimeout(timer)
    doing = "use"
    using.press(event)
  }
  function letGo() {
    clearTimeout(timer)
    if (doing === "use") { using.release() }
    doing = "rest"
  }
  const isDouble = (event) => frame.zoomed && using.doubles && event.timeStamp - lastTap.time < DOUBLE_MS
    && away(frame.onStage(stage, event), lastTap.at) < DOUBLE_PIXELS

  stage.addEventListener("pointerdown", (event) => {
    const panning = event.button === 1 || (event.button === 0 && stage.classList.contains("hand"))
    if (event.button !== 0 && !panning) { return }
    event.preventDefault()
    stage.setPointerCapture(event.pointerId)
    pressed.set(event.pointerId, frame.onStage(stage, event))
    if (pressed.size > 1) {
      letGo()
      if (pressed.size === 2) { doing = "pinch" }
      return
    }
    ;[first, using] = [event, toolAt(event)]
    const double = !panning && isDouble(event)
    endTap(!double)
    if (panning) {
      doing = "pan"
      stage.classList.add("panning")
    } else if (double) {
      doing = "rest"
      frame.fit()
    } else if (event.pointerType === "touch" || (using.patient && frame.zoomed)) {  // a second finger or tap may follow
      doing = "wait"
      timer = setTimeout(() => use(event), HOLD_MS)
    } else { use(event) }
  })

  stage.addEventListener("pointermove", (event) => {
    if (!pressed.has(event.pointerId)) { return }
    const [from, to] = [pressed.get(event.pointerId), frame.onStage(stage, event)]
    if (doing === "wait") {
      if (away(to, from) < TAP_PIXELS) { return }
      use(first)
    }
    const others = [...pressed].filter(([pointer]) => pointer !== event.pointerId).map(([, at]) => at)
    pressed.set(event.pointerId, to)
    if (doing === "use") { using.move(event) }
    if (doing === "pan") { frame.pan(stage, to[0] - from[0], to[1] - from[1]) }
    if (doing === "pinch") {
      const between = (at) => [(at[0] + others[0][0]) / 2, (at[1] + others[0][1]) / 2]
      const [before, after] = [between(from), between(to)]
      frame.zoomAt(stage, Math.max(away(to, others[0]), 1) / Math.max(away(from, others[0]), 1), before)
      frame.pan(stage, after[0] - before[0], after[1] - before[1])
    }
  })

  function tap(event) {
    const used = using
    waitingTap = () => { used.press(event); used.release() }
    if (frame.zoomed && used.patient) { tapTimer = setTimeout(endTap, DOUBLE_MS, true) } else { endTap(true) }
  }
  // Ends the wait for a second tap: the first one counts, or is forgotten.
  function endTap(counts) {
    clearTimeout(tapTimer)
    if (counts) { waitingTap?.() }
    waitingTap = null
  }
  function end(event) {
    if (!pressed.delete(event.pointerId)) { return }
    const at = frame.onStage(stage, event)
    const tapped = event.type === "pointerup" && ["wait", "use"].includes(doing)
      && event.timeStamp - first.timeStamp < HOLD_MS && away(at, frame.onStage(stage, first)) < TAP_PIXELS
    const waited = doing === "wait"
    letGo()
    if (waited && event.type === "pointerup") { tap(first) }
    if (tapped) { lastTap = {time: event.timeStamp, at} }
    if (pressed.size === 0) {
      doing = null
      stage.classList.remove("panning")
    }
  }
  for (const name of ["pointerup", "pointercancel"]) { stage.addEventListener(name, end) }
  stage.addEventListener("mousedown", (event) => { if (event.button === 1) { event.preventDefault() } })  // no scrolling by itself

  // With Ctrl or Cmd the wheel zooms, as in Figma, Photopea and maps within pages; a pinch on a trackpad arrives as just that.
  // Alone it scrolls, since on a laptop two fingers pan everywhere else: a magnified picture first, up to its edge, and then
  // the page, which is how everything that scrolls within a page behaves. So the page can always be scrolled past a picture.
  stage.addEventListener("wheel", (event) => {
    const unit = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? LINE_PIXELS : event.deltaMode === WheelEvent.DOM_DELTA_PAGE ? stage.clientHeight : 1
    const [dx, dy] = [unit * event.deltaX, unit * event.deltaY]
    if (event.ctrlKey || event.metaKey) {
      event.preventDefault()  // the browser would zoom the page
      frame.zoomAt(stage, Math.exp(-WHEEL_ZOOM * clamp(dy, -WHEEL_MOST, WHEEL_MOST)), frame.onStage(stage, event))
    } else if (frame.zoomed && event.cancelable && frame.pan(stage, -dx, -dy)) { event.preventDefault() }
  }, {passive: false})

  // ---- Space takes hold of the picture under the pointer, unless a button was reached with Tab since, which it presses.
  let pointed = false
  const hold = (on) => stage.classList.toggle("hand", on)
  const listeners = {
    keydown(event) {
      pointed &&= event.key !== "Tab"
      if (event.key !== " " || !pointed || !frame.zoomed || isTyped(event)) { return }
      event.preventDefault()
      hold(true)
    },
    keyup(event) {
      if (event.key !== " " || !stage.classList.contains("hand")) { return }
      event.preventDefault()
      hold(false)
    },
  }
  stage.addEventListener("pointerenter", () => {
    for (const [name, listener] of Object.entries(listeners)) { document.addEventListener(name, listener) }
  })
  stage.addEventListener("pointermove", ({movementX, movementY}) => {  // browsers send one, too, when the page moves below it
    pointed ||= movementX !== 0 || movementY !== 0
  })
  stage.addEventListener("pointerleave", () => {
    for (const [name, listener] of Object.entries(listeners)) { document.removeEventListener(name, listener) }
    pointed = false
    hold(false)
  })
}
