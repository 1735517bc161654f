// The ramp of the chosen material: its tones, where each begins, how softly, and whether it stays flat.

const RESET_ICON = `<svg viewBox="0 0 24 24"><path d="M4 4v6h6M4.5 10A8 8 0 1 1 4 14"/></svg>`
const NARROWEST_TONE = 0.01
const [FINE_STEP, COARSE_STEP] = [0.01, 0.1]

// `shown` is called with a ramp while it is being changed, and `changed` once it is; null stands for the one that was found.
function rampEditor(parent, {shown, changed}) {
  const root = element(parent, "div", "ramp-editor")
  const strip = element(root, "div", "strip")
  const row = element(root, "div", "ramp-row")
  const tones = element(row, "div", "tones")
  const add = element(row, "button", "add", "+")
  const softness = element(row, "label", "softness", `<span>Softness</span><input type="range" min="0" max="1" step="0.01" aria-label="Softness of the step">`)
  const flat = element(row, "label", "stays", `<input type="checkbox"><span>Stays flat</span>`)
  const reset = element(row, "button", "reset-ramp", RESET_ICON)
  const soft = softness.querySelector("input"), stays = flat.querySelector("input")
  const none = element(root, "p", "no-ramp", "Choose a material to edit its ramp")
  root.setAttribute("role", "group")
  root.setAttribute("aria-label", "Ramp of the chosen material")
  Object.assign(add, {type: "button", title: "Add a tone"})
  add.setAttribute("aria-label", "Add a tone")
  Object.assign(reset, {type: "button", title: "Reset ramp: back to what was found"})
  reset.setAttribute("aria-label", "Reset ramp")
  flat.title = "Looks the same under any light"
  let ramp = null, active = 0, dragging = false

  function put(next) {
    ramp = next
    update()
    shown(ramp)
  }
  function commit(next = ramp) {
    put(next)
    changed(ramp)
  }

  // ---- thresholds
  function limits(step) {
    return [(ramp.thresholds[step - 1] ?? -1) + NARROWEST_TONE, (ramp.thresholds[step + 1] ?? 1) - NARROWEST_TONE]
  }
  function moveThreshold(step, illumination) {
    const [low, high] = limits(step)
    const thresholds = [...ramp.thresholds]
    thresholds[step] = Number(clamp(illumination, low, Math.max(low, high)).toFixed(4))
    put({...ramp, thresholds})
  }
  function threshold(step) {
    const node = document.createElement("button")
    Object.assign(node, {type: "button", className: "threshold", title: "Drag to where the brighter tone begins. Delete removes it"})
    node.setAttribute("role", "slider")
    node.setAttribute("aria-valuemin", -1)
    node.setAttribute("aria-valuemax", 1)
    node.addEventListener("focus", () => { active = step; update() })
    node.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) { return }
      node.setPointerCapture(event.pointerId)
      dragging = true
      active = step
      update()
    })
    node.addEventListener("pointermove", (event) => {
      if (!dragging || !node.hasPointerCapture(event.pointerId)) { return }
      const box = strip.getBoundingClientRect()
      moveThreshold(step, 2 * (event.clientX - box.left) / box.width - 1)
    })
    for (const end of ["pointerup", "pointercancel"]) {
      node.addEventListener(end, () => { if (dragging) { dragging = false; changed(ramp) } })
    }
    node.addEventListener("keydown", (event) => {
      const way = {ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1}[event.key]
      if (way) {
        event.preventDefault()
        moveThreshold(step, ramp.thresholds[step] + way * (event.shiftKey ? COARSE_STEP : FINE_STEP))
        changed(ramp)
      } else if (event.key === "Delete" || event.key === "Backspace") {
        event.preventDefault()
        commit(withoutStep(ramp, step))
        ;(strip.children[Math.min(step, strip.children.length - 1)] ?? add).focus()
      }
    })
    return node
  }

  // ---- tones
  function well(place) {
    const node = document.createElement("input")
    node.type = "color"
    const pick = () => {
      const colors = [...ramp.tones]
      colors[place] = between(node.value, colors[place - 1], colors[place + 1])
      put({...ramp, tones: colors})
    }
    node.addEventListener("input", pick)
    node.addEventListener("change", () => { pick(); changed(ramp) })
    return node
  }

  function fit(parent, count, make) {
    while (parent.children.length > count) { parent.lastChild.remove() }
    while (parent.children.length < count) { parent.append(make(parent.children.length)) }
  }
  function update() {
    root.classList.toggle("none", ramp === null)
    if (ramp === null) { return }
    const steps = ramp.thresholds.length
    active = clamp(active, 0, Math.max(steps - 1, 0))
    strip.style.background = rampBackground(ramp)
    fit(strip, steps, threshold)
    ramp.thresholds.forEach((illumination, step) => {
      const node = strip.children[step]
      node.style.left = `${50 * (illumination + 1)}%`
      node.classList.toggle("active", step === active)
      node.setAttribute("aria-label", `Step ${step + 1} of ${steps}: illumination`)
      node.setAttribute("aria-valuenow", illumination.toFixed(2))
    })
    fit(tones, ramp.tones.length, well)
    ramp.tones.forEach((tone, place) => {
      const node = tones.children[place]
      const words = `Tone ${place + 1} of ${ramp.tones.length}${place === 0 ? ", the darkest" : ""}`
      if (node.value !== tone) { node.value = tone }
      node.title = words
      node.setAttribute("aria-label", words)
    })
    add.disabled = ramp.tones.length >= MOST_TONES
    soft.disabled = steps === 0
    if (steps > 0) { soft.value = ramp.softness[active] }
    stays.checked = ramp.stays_flat
  }

  add.addEventListener("click", () => commit(withTone(ramp)))
  soft.addEventListener("input", () => put({...ramp, softness: ramp.softness.with(active, Number(soft.value))}))
  soft.addEventListener("change", () => changed(ramp))
  stays.addEventListener("change", () => commit({...ramp, stays_flat: stays.checked}))
  reset.addEventListener("click", () => changed(null))

  return {
    get busy() { return dragging },
    // The ramp of a material, and whether it was edited; null where none is chosen.
    load(next, edited) {
      if (dragging) { return }
      ramp = next
      reset.disabled = !edited
      update()
    },
  }
}
