// A list of cards to choose one from: a picture, a title, a line of text, or any of them.

const STYLE = `
.cards { --ink: var(--panel-on-surface-color, #1c1c1e); --accent: var(--panel-primary-color, #d9772b);
  display: grid; gap: 8px; width: 100%; color: var(--ink); font-size: 13px; line-height: 1.3; }
.cards button { font: inherit; color: inherit; text-align: left; display: flex; flex-direction: column; gap: 1px;
  padding: 8px 12px; border-radius: 8px; border: 1px solid color-mix(in srgb, var(--ink) 16%, transparent);
  background: transparent; cursor: pointer; min-width: 0; transition: border-color .12s, background .12s; }
.cards button:hover { background: color-mix(in srgb, var(--ink) 6%, transparent); }
.cards button:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; }
.cards button[aria-checked=true] { border-color: var(--accent); box-shadow: inset 0 0 0 1px var(--accent);
  background: color-mix(in srgb, var(--accent) 10%, transparent); }
.cards b { font-weight: 600; }
.cards small { font-size: 12px; color: color-mix(in srgb, var(--ink) 65%, transparent); }
.cards.ramps button { flex-direction: row; align-items: center; gap: 10px; padding: 6px 8px; flex-wrap: wrap; }
.cards.ramps img { flex: 1 1 60px; width: 0; height: 20px; object-fit: fill; border-radius: 4px; }
.cards.ramps b { width: 3.6em; text-align: right; font-variant-numeric: tabular-nums; }
.cards.ramps small { width: 2em; }
.cards.pictures button { padding: 4px; aspect-ratio: 1; }
.cards img { display: block; }
.cards.pictures img { width: 100%; height: 100%; min-height: 0; object-fit: contain; border-radius: 5px; }
`

function render({model}) {
  const root = document.createElement("div")
  root.innerHTML = `<style>${STYLE}</style><div class="cards" role="radiogroup"></div>`
  const list = root.querySelector(".cards")
  list.setAttribute("aria-label", model.label)

  function fill() {
    list.style.gridTemplateColumns = `repeat(${model.columns}, minmax(0, 1fr))`
    const [first] = model.choices
    list.classList.toggle("pictures", first?.picture !== undefined && first.text === undefined)
    list.classList.toggle("ramps", first?.picture !== undefined && first.text !== undefined)
    list.replaceChildren(...model.choices.map((choice) => {
      const card = document.createElement("button")
      card.type = "button"
      card.setAttribute("role", "radio")
      card.dataset.value = choice.value
      if (choice.picture) {
        const image = document.createElement("img")
        ;[image.src, image.draggable] = [choice.picture, false]
        if (choice.text === undefined) { card.title = image.alt = choice.title } else { image.alt = "" }
        card.append(image)
      }
      if (choice.text !== undefined) {
        for (const [tag, text] of [["b", choice.title], ["small", choice.text]]) {
          const line = document.createElement(tag)
          line.textContent = text
          card.append(line)
        }
      }
      card.addEventListener("click", () => { model.value = choice.value })
      return card
    }))
    mark()
  }
  // As in any radio group, Tab reaches the chosen card, and the arrow keys go on from there.
  function mark() {
    const cards = [...list.children]
    const chosen = cards.find((card) => card.dataset.value === model.value)
    for (const card of cards) {
      card.setAttribute("aria-checked", card === chosen)
      card.tabIndex = card === (chosen ?? cards[0]) ? 0 : -1
    }
  }
  const steps = {ArrowRight: () => 1, ArrowLeft: () => -1, ArrowDown: () => model.columns, ArrowUp: () => -model.columns}
  list.addEventListener("keydown", (event) => {
    const cards = [...list.children]
    const here = cards.indexOf(event.target.closest("button"))
    if (here < 0 || !(event.key in steps)) { return }
    event.preventDefault()
    const next = cards[here + steps[event.key]()]
    if (next) {
      next.focus()
      model.value = next.dataset.value
    }
  })
  model.on("change:value", mark)
  model.on(["change:choices", "change:columns"], fill)
  fill()
  return root
}

export default {render}
