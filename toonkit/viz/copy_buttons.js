// Buttons that copy what Python answers, and a box that shows it, for browsers that refuse the clipboard.

const STYLE = `
.copy { --ink: var(--panel-on-surface-color, #1c1c1e); --accent: var(--panel-primary-color, #d9772b);
  display: grid; gap: 8px; width: 100%; color: var(--ink); font-size: 13px; line-height: 1.35; }
.copy * { box-sizing: border-box; }
.copy button { font: inherit; font-size: 14px; font-weight: 500; color: var(--accent); background: transparent; cursor: pointer; padding: 7px 14px;
  border: 1px solid color-mix(in srgb, var(--accent) 50%, transparent); border-radius: 4px; }
.copy button:hover { background: color-mix(in srgb, var(--accent) 8%, transparent); border-color: var(--accent); }
.copy button:disabled { opacity: .45; cursor: default; background: transparent; }
.copy button:focus-visible, .copy textarea:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; }
.copy textarea { width: 100%; resize: vertical; padding: 8px 10px; border-radius: 6px; color: inherit; white-space: pre; overflow: auto;
  font: 12px/1.5 ui-monospace, "DejaVu Sans Mono", monospace; tab-size: 4;
  background: color-mix(in srgb, var(--ink) 6%, transparent); border: 1px solid color-mix(in srgb, var(--ink) 18%, transparent); }
.copy p { margin: 0; color: color-mix(in srgb, var(--ink) 72%, transparent); overflow-wrap: anywhere; }
.copy [hidden] { display: none; }
`
const MOST_ROWS = 9

function render({model}) {
  const root = document.createElement("div")
  root.innerHTML = `<style>${STYLE}</style><div class="copy"><div hidden><textarea readonly spellcheck="false"></textarea><p role="status"></p></div></div>`
  const list = root.querySelector(".copy")
  const shown = list.querySelector("div")
  const box = shown.querySelector("textarea")
  const told = shown.querySelector("p")
  const buttons = model.choices.map(([action, label]) => {
    const button = document.createElement("button")
    button.type = "button"
    button.textContent = label
    button.addEventListener("click", () => model.send_msg({action}))
    list.insertBefore(button, shown)
    return button
  })

  // The clipboard is there on secure pages alone, and its owner may say no; the older command asks nobody, where it works.
  async function copied(text) {
    try {
      await navigator.clipboard.writeText(text)
      return true
    } catch {
      box.focus()
      box.select()
      try { return document.execCommand("copy") } catch { return false }
    }
  }
  model.on("msg:custom", async ({text, note, label}) => {
    shown.hidden = false
    box.value = text
    box.rows = Math.min(text.split("\n").length, MOST_ROWS)
    box.setAttribute("aria-label", label)
    told.textContent = ""
    const done = await copied(text)
    if (!done) { box.select() }
    told.textContent = `${done ? "Copied." : "Not copied: press Ctrl+C."} ${note}`
    shown.scrollIntoView({block: "nearest"})
  })
  const allow = () => { for (const button of buttons) { button.disabled = model.disabled } }
  model.on("change:disabled", allow)
  allow()
  return root
}

export default {render}
