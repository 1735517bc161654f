// What the relight view looks like.

// A tile, not a gradient: a page without a graphics card would compute the gradient again for every picture.
const CHECKERS = "data:image/svg+xml," + encodeURIComponent(`<svg xmlns="http://www.w3.org/2000/svg" width="20" height="20">
<path fill="#7f8084" d="M0 0h20v20H0z"/><path fill="#747579" d="M0 0h10v10H0zM10 10h10v10H10z"/></svg>`)

// What moves has a layer of its own (will-change), and nothing that is drawn anew each time is clipped to a shape.
const STYLE = `
:host { container-type: inline-size; }
.relight {
  position: relative;
  --ink: var(--panel-on-surface-color, #1c1c1e); --paper: var(--panel-surface-color, #fff);
  --line: color-mix(in srgb, var(--ink) 14%, transparent); --soft: color-mix(in srgb, var(--ink) 62%, var(--paper));
  --accent: var(--panel-primary-color, #d9772b);
  display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: 16px; width: 100%; box-sizing: border-box;
  color: var(--ink); font-size: 13px; line-height: 1.35;
}
.relight * { box-sizing: border-box; }
.card { background: var(--paper); border: 1px solid var(--line); border-radius: 12px; display: flex;
  flex-direction: column; min-width: 0; }
.card header { display: flex; align-items: center; gap: 6px 10px; padding: 8px 16px; min-height: 45px; flex-wrap: wrap; }
.card h2 { margin: 0; font-size: 15px; font-weight: 600; letter-spacing: .01em; }
.card header p { flex: 1 1 110px; min-width: 0; margin: 0; color: var(--soft); font-size: 12px; }
.stage { position: relative; height: clamp(240px, calc(100vh - 432px), 720px); touch-action: none; cursor: grab;
  overflow: hidden; background: url("${CHECKERS}") 0 0 / 20px 20px; }
.dragging .stage, .dragging .ball-box { cursor: grabbing; }
.picture { position: absolute; left: 0; top: 0; max-width: none; transform-origin: 0 0; user-select: none; -webkit-user-drag: none; }
.picture.pixels { image-rendering: pixelated; }
.empty .picture, .empty .sun, .empty .dot, .stand-in { visibility: hidden; }
.no-webgl .stand-in { visibility: visible; }
.no-webgl .after canvas { visibility: hidden; }
.sun { position: absolute; left: calc(50% - 14px); top: calc(50% - 14px); width: 28px; height: 28px; border-radius: 50%;
  pointer-events: none; background: rgba(255, 255, 255, .92); box-shadow: 0 1px 5px rgba(0, 0, 0, .45); opacity: .78; will-change: transform;
  transition: opacity .15s; }
.stage:hover .sun, .dragging .sun { opacity: 1; }
.sun svg { width: 28px; height: 28px; padding: 5px; fill: #f2a11b; stroke: #d98407; stroke-width: 2; stroke-linecap: round; }
.half { position: absolute; top: 0; bottom: 0; overflow: hidden; pointer-events: none; }
.before { left: 0; width: var(--split); }
.after { left: var(--split); right: 0; }
.after .picture { left: calc(-1 * var(--split)); }
.split .half::after { position: absolute; top: 10px; padding: 2px 9px; border-radius: 999px; font-size: 12px; white-space: nowrap;
  color: #fff; background: rgba(20, 20, 22, .72); }
.split .before::after { content: "As drawn"; left: 10px; }
.split .after::after { content: "Relit"; right: 10px; }
.divider { position: absolute; top: 0; bottom: 0; left: calc(var(--split) - 16px); width: 32px; cursor: ew-resize; touch-action: none;
  outline: none; }
.divider::before { content: ""; position: absolute; top: 0; bottom: 0; left: 15px; width: 2px; background: #fff;
  box-shadow: 0 0 4px rgba(0, 0, 0, .6); }
.divider i { position: absolute; left: 0; top: calc(50% - 16px); width: 32px; height: 32px; border-radius: 50%; background: #fff;
  box-shadow: 0 1px 6px rgba(0, 0, 0, .5); }
.divider svg { width: 32px; height: 32px; padding: 5px; fill: none; stroke: #2a2a2e; stroke-width: 2; stroke-linecap: round;
  stroke-linejoin: round; }
.divider:focus-visible i { outline: 2px solid var(--accent); outline-offset: 2px; }
.stage:focus { outline: none; }
.fit { position: absolute; z-index: 1; right: 10px; bottom: 10px; padding: 3px 9px; font-size: 12px; font-variant-numeric: tabular-nums;
  border-radius: 999px; border-color: transparent; color: #fff; background: rgba(20, 20, 22, .72); }
.fit:hover { background: rgba(20, 20, 22, .9); }
.controls { display: flex; gap: 18px; align-items: center; padding: 14px 16px; border-top: 1px solid var(--line); }
.ball-box { position: relative; flex: none; width: 112px; height: 112px; cursor: grab; touch-action: none; border-radius: 50%;
  box-shadow: 0 0 0 1px var(--line), 0 4px 14px rgba(0, 0, 0, .22); }
.ball { position: absolute; inset: 0; width: 100%; height: 100%; user-select: none; }
.dot { position: absolute; inset: 0; pointer-events: none; will-change: transform; }
.dot::after { content: ""; position: absolute; left: calc(50% - 6px); top: calc(50% - 6px); width: 12px; height: 12px;
  border-radius: 50%; border: 2px solid #fff; background: #f2a11b; box-shadow: 0 0 3px rgba(0, 0, 0, .7); }
.right { flex: 1; min-width: 0; display: flex; flex-direction: column; gap: 8px; }
.slider { display: grid; grid-template-columns: 62px minmax(0, 1fr) 42px; align-items: center; gap: 8px; }
.slider span { color: var(--soft); }
.slider output { text-align: right; font-variant-numeric: tabular-nums; }
input[type=range] { width: 100%; margin: 0; height: 20px; appearance: none; background: none; cursor: pointer; }
input[type=range]::-webkit-slider-runnable-track { height: 4px; border-radius: 2px; background: color-mix(in srgb, var(--ink) 22%, transparent); }
input[type=range]::-moz-range-track { height: 4px; border-radius: 2px; background: color-mix(in srgb, var(--ink) 22%, transparent); }
input[type=range]::-webkit-slider-thumb { appearance: none; width: 14px; height: 14px; margin-top: -5px; border-radius: 50%;
  background: var(--accent); box-shadow: 0 1px 3px rgba(0, 0, 0, .4); }
input[type=range]::-moz-range-thumb { width: 14px; height: 14px; border: 0; border-radius: 50%; background: var(--accent); }
.buttons { display: flex; gap: 8px; flex-wrap: wrap; margin-top: 2px; }
button { display: inline-flex; align-items: center; gap: 5px; font: inherit; font-weight: 500; color: var(--ink);
  background: transparent; border: 1px solid color-mix(in srgb, var(--ink) 26%, transparent); border-radius: 7px;
  padding: 5px 12px; cursor: pointer; white-space: nowrap; }
button:hover { background: color-mix(in srgb, var(--ink) 8%, transparent); }
button:focus-visible, input:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; }
button svg { width: 15px; height: 15px; fill: currentColor; margin-left: -3px; }
.busy { position: absolute; left: 50%; bottom: 18px; width: min(320px, calc(100% - 32px)); padding: 10px 14px;
  transform: translateX(-50%); display: none; grid-template-columns: 1fr auto; gap: 6px 14px; align-items: center;
  background: var(--paper); border-radius: 10px; box-shadow: 0 4px 22px rgba(0, 0, 0, .35); cursor: default; }
.busy.on { display: grid; animation: appear .15s .25s backwards; }
@keyframes appear { from { opacity: 0; } }
.busy .step { overflow: hidden; text-overflow: ellipsis; white-space: nowrap; }
.busy .step::first-letter { text-transform: uppercase; }
.busy .track { grid-row: 2; height: 4px; border-radius: 2px; background: var(--line); overflow: hidden; }
.busy .track div { height: 100%; background: var(--accent); transition: width .15s; }
.busy button { grid-area: 1 / 2 / 3 / 3; }
[hidden] { display: none !important; }
.modes { display: flex; margin-left: auto; padding: 2px; border-radius: 8px; gap: 2px; background: var(--line); }
.modes button { border: 0; padding: 3px 10px; border-radius: 6px; font-size: 12px; }
.modes button[aria-pressed=true] { background: var(--paper); box-shadow: 0 1px 3px rgba(0, 0, 0, .3); }
.icons { display: flex; gap: 6px; margin-left: auto; }
.icons button { padding: 4px; min-width: 28px; height: 28px; justify-content: center; }
.icons svg { fill: none; stroke: currentColor; stroke-width: 2; stroke-linecap: round; stroke-linejoin: round; margin: 0; }
.shortcuts { border: 1px solid var(--line); border-radius: 12px; padding: 0; color: var(--ink); background: var(--paper);
  box-shadow: 0 8px 40px rgba(0, 0, 0, .5); max-width: min(480px, calc(100vw - 32px)); }
.shortcuts::backdrop { background: rgba(0, 0, 0, .45); }
.shortcuts form { padding: 18px 22px; display: grid; gap: 12px; justify-items: start; }
.shortcuts h2 { margin: 0; font-size: 16px; }
.shortcuts dl { display: grid; grid-template-columns: auto 1fr; gap: 7px 16px; margin: 0; }
.shortcuts dt { white-space: nowrap; } .shortcuts dd { margin: 0; }
kbd { font: inherit; font-size: 12px; padding: 1px 6px; border-radius: 5px; border: 1px solid color-mix(in srgb, var(--ink) 30%, transparent); }
.ball-box:focus-visible { outline: 2px solid var(--accent); outline-offset: 3px; }
.materials, .label-map, .ring, .lasso { display: none; }
.editing .materials { display: flex; }
.editing .label-map, .editing .lasso { display: block; }
.editing .controls, .editing .sun { display: none; }
.materials { flex-direction: column; gap: 10px; padding: 12px 16px; border-top: 1px solid var(--line); height: 262px; }
.tools { display: flex; gap: 8px; align-items: center; }
.tools button { padding: 4px 10px; min-height: 30px; }
.tools .brush, .tools .fill, .tools .split { padding: 4px 9px; }
.tools svg { fill: none; stroke: currentColor; stroke-width: 2; stroke-linecap: round; stroke-linejoin: round; margin: 0; }
.tools button[aria-pressed=true], .icons button[aria-pressed=true] { background: var(--accent); border-color: var(--accent); color: #1c1206; }
button:disabled { opacity: .4; cursor: default; background: transparent; }
.tools .size { flex: 1 1 60px; min-width: 50px; max-width: 180px; }
.tools .space { flex: 1; }
.swatches { display: grid; grid-template-columns: repeat(auto-fill, minmax(50px, 1fr)); gap: 8px 7px; overflow-y: auto; margin: -4px;
  padding: 4px; align-content: start; }
.swatch { position: relative; padding: 0; height: 30px; border: 0; border-radius: 7px; overflow: visible; touch-action: manipulation; }
.swatch i { position: absolute; inset: 0; border-radius: 7px; box-shadow: inset 0 0 0 1px rgba(0, 0, 0, .28); }
.swatch b { position: absolute; left: 6px; top: 9px; width: 12px; height: 12px; border-radius: 50%; border: 2px solid #fff;
  box-shadow: 0 0 2px rgba(0, 0, 0, .8); }
.swatch.hovered { box-shadow: 0 0 0 2px var(--paper), 0 0 0 4px var(--soft); }
.swatch[aria-pressed=true] { box-shadow: 0 0 0 2px var(--paper), 0 0 0 4px var(--accent); }
.swatch.new { border: 1.5px dashed color-mix(in srgb, var(--ink) 40%, transparent); justify-content: center; font-size: 18px; }
.swatch.ghost { position: absolute; left: -28px; top: -15px; width: 56px; z-index: 3; pointer-events: none; box-shadow: 0 4px 14px rgba(0, 0, 0, .5); }
.marks { display: flex; gap: 7px; flex-wrap: wrap; }
.swatch.mark { display: inline-flex; align-items: center; gap: 6px; padding: 0 10px 0 8px; height: 26px; font-size: 12px;
  border: 1px solid color-mix(in srgb, var(--ink) 26%, transparent); }
.swatch.mark b { position: static; }
.lasso { position: absolute; inset: 0; pointer-events: none; }
.lasso svg { width: 100%; height: 100%; }
.lasso polygon { fill: rgba(255, 255, 255, .15); stroke: #fff; stroke-width: 1.5; stroke-dasharray: 5 4; filter: drop-shadow(0 0 1px #000); }
.editing .stage[data-tool=split], .editing .stage[data-tool=fill] { cursor: crosshair; }
.swatches { flex: 1; min-height: 38px; }
.ramp-editor { position: relative; display: grid; gap: 8px; padding-top: 10px; border-top: 1px solid var(--line); }
.ramp-editor.none > :not(.no-ramp) { visibility: hidden; }
.no-ramp { position: absolute; inset: 0; margin: 0; display: grid; place-items: center; color: var(--soft); visibility: hidden; }
.ramp-editor.none .no-ramp { visibility: visible; }
.strip { position: relative; height: 24px; margin: 0 8px; border-radius: 6px; box-shadow: inset 0 0 0 1px rgba(0, 0, 0, .28); touch-action: none; }
.threshold { position: absolute; top: -3px; width: 12px; height: 30px; margin-left: -6px; padding: 0; border-radius: 4px; cursor: ew-resize;
  background: #fff; border: 2px solid #55555c; box-shadow: 0 1px 3px rgba(0, 0, 0, .5); touch-action: none; }
.threshold:hover { background: #fff; }
.threshold.active { border-color: var(--accent); }
.ramp-row { display: flex; align-items: center; gap: 6px 10px; flex-wrap: wrap; min-height: 28px; }
.tones { display: flex; gap: 4px; }
.tones input { width: 26px; height: 26px; padding: 0; border: 0; border-radius: 6px; background: none; cursor: pointer; overflow: hidden; }
.tones input::-webkit-color-swatch-wrapper { padding: 0; }
.tones input::-webkit-color-swatch { border: 1px solid rgba(0, 0, 0, .3); border-radius: 6px; }
.ramp-row .add { width: 26px; height: 26px; padding: 0; justify-content: center; border-style: dashed; margin-left: -6px; }
.softness { display: flex; align-items: center; gap: 8px; flex: 1 1 100px; max-width: 220px; color: var(--soft); }
.stays { display: flex; align-items: center; gap: 6px; cursor: pointer; white-space: nowrap; }
.stays input { accent-color: var(--accent); margin: 0; width: 15px; height: 15px; }
.reset-ramp { padding: 4px; }
.reset-ramp svg { fill: none; stroke: currentColor; stroke-width: 2; stroke-linecap: round; stroke-linejoin: round; margin: 0; }
.label-map { position: absolute; pointer-events: none; }
.editing .stage { cursor: pointer; }
.editing .stage[data-tool=brush] { cursor: none; }
.relight .stage.hand.hand { cursor: grab; }
.relight .stage.panning.panning { cursor: grabbing; }
.relight .stage.splitting.splitting { cursor: ew-resize; }
.ring { position: absolute; left: 0; top: 0; border-radius: 50%; border: 1.5px solid #fff; pointer-events: none;
  box-shadow: 0 0 0 1px rgba(0, 0, 0, .7), inset 0 0 0 1px rgba(0, 0, 0, .5); }
.editing .stage[data-tool=brush]:not(.hand, .panning):hover .ring { display: block; }
.alone { grid-template-columns: minmax(0, 720px); justify-content: center; }
.alone .stage { height: min(72vh, 620px); }
@container (max-width: 600px) {
  .relight { grid-template-columns: minmax(0, 1fr); }
  .card.relit { order: -1; }
  .stage { height: min(84cqw, 420px); }
  .ball-box { width: 92px; height: 92px; }
  .materials { height: auto; }
  .swatches { flex: none; max-height: 198px; }
}
@container (min-width: 601px) and (max-width: 850px) {
  .card header p { display: none; }
  .controls { gap: 12px; padding: 12px; }
  .ball-box { width: 84px; height: 84px; }
  .slider { grid-template-columns: 58px minmax(0, 1fr) 38px; gap: 4px; }
}
`
