// Keys that work anywhere on the page, and the list of them.

const SHORTCUTS = [
  ["Ctrl Z", "Undo, the light included"], ["Ctrl Shift Z", "Redo"], ["?", "This list"],
  ["Arrow keys", "On a ball: move the light by 1°, with Shift by 10°"], ["M", "Light or materials"], ["N", "Light or shape"],
  ["B", "Brush"], ["F", "Fill a region"], ["S", "Split with a lasso"], ["D", "On the shape: drag a normal"],
  ["[ ]", "Size of the brush"],
  ["C", "Compare: as drawn left of a divider, relit right of it"],
  ["+ - 0", "Magnify both pictures, or fit them; so do Ctrl + wheel and a pinch"],
  ["Space", "Held: drag a magnified picture"],
  ["Esc", "Put the tool down, then the material"], ["Delete", "On a step of a ramp, or a key light: remove it"],
]

// `actions` has a function for each key; those of letters are not called while Ctrl is down.
function shortcuts(root, actions) {
  const dialog = element(root, "dialog", "shortcuts", `<form method="dialog"><h2>Keyboard shortcuts</h2><dl>${
    SHORTCUTS.map(([keys, words]) => `<dt>${keys.split(" ").map((key) => /keys/.test(keys) ? key : `<kbd>${key}</kbd>`).join(" ")}</dt><dd>${words}</dd>`).join("")
  }</dl><button>Close</button></form>`)
  dialog.setAttribute("aria-label", "Keyboard shortcuts")
  dialog.addEventListener("click", (event) => { if (event.target === dialog) { dialog.close() } })
  const show = () => { if (!dialog.open) { dialog.showModal() } }

  function key(event) {
    if (event.defaultPrevented || isTyped(event) || dialog.open || event.altKey) { return }
    const letter = event.key.toLowerCase()
    const control = event.ctrlKey || event.metaKey
    const action = !control ? letter === "?" ? show : actions[letter]
      : letter === "z" ? event.shiftKey ? actions.redo : actions.undo : letter === "y" ? actions.redo : undefined
    if (!action || (!control && event.shiftKey && !["?", "+"].includes(letter))) { return }
    if (action() !== false) { event.preventDefault() }
  }
  document.addEventListener("keydown", key)
  return {show, remove() { document.removeEventListener("keydown", key) }}
}
