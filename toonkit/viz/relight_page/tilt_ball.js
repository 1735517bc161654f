// A ball beside the pointer that shows which way the surface faces while its normal is dragged.

const TILT_BALL_PIXELS = 54  // its radius
const STEEPEST_TILT = 0.996  // sine of the largest angle between a dragged normal and the direction to the viewer

// The unit normal, z >= 0, with these x and y.
function normalOf(x, y) {
  const length = Math.hypot(x, y)
  const scale = length > STEEPEST_TILT ? STEEPEST_TILT / length : 1
  return [x * scale, y * scale, Math.sqrt(1 - Math.min(length, STEEPEST_TILT) ** 2)]
}

// How far a normal leans, in words.
function spokenNormal([x, y]) {
  const degrees = Math.round(Math.asin(Math.min(Math.hypot(x, y), 1)) * 180 / Math.PI)
  const ways = ["right", "up right", "up", "up left", "left", "down left", "down", "down right"]
  return degrees === 0 ? "facing you" : `${degrees}° ${ways[(Math.round(Math.atan2(y, x) * 4 / Math.PI) + 8) % 8]}`
}

function tiltBall(stage) {
  const r = TILT_BALL_PIXELS
  const node = element(stage, "div", "tilt-ball", `<svg viewBox="${-r - 8} ${-r - 8} ${2 * r + 16} ${2 * r + 16}">
    <defs><radialGradient id="tilt-shade" cx="0.36" cy="0.32" r="0.75"><stop offset="0" stop-color="#fff"/>
    <stop offset="0.6" stop-color="#b9bcc4"/><stop offset="1" stop-color="#4a4d57"/></radialGradient></defs>
    <circle r="${r}" fill="url(#tilt-shade)"/><path class="meridians" d="M0 ${-r}V${r}M${-r} 0H${r}"/>
    <line class="shaft" x1="0" y1="0"/><circle class="tip" r="7"/></svg>`)
  const words = element(node, "div", "words")
  const [shaft, tip] = [node.querySelector(".shaft"), node.querySelector(".tip")]
  return {
    show([left, top], normal) {
      node.classList.add("on")
      node.style.transform = `translate(${left}px, ${top}px) translate(-50%, -50%)`
      const [x, y] = [r * normal[0], -r * normal[1]]
      for (const [name, value] of [["x2", x], ["y2", y]]) { shaft.setAttribute(name, value) }
      for (const [name, value] of [["cx", x], ["cy", y]]) { tip.setAttribute(name, value) }
      words.textContent = spokenNormal(normal)
    },
    hide() { node.classList.remove("on") },
  }
}
