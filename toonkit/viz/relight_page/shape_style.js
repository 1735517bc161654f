// Styles of the shape tools.

const SHAPE_STYLE = `
.shape-panel, .shape-map, .points, .shape-ring, .tilt-ball { display: none; }
.shaping .shape-panel { display: flex; }
.shaping .shape-map, .shaping .points { display: block; }
.shaping .controls, .shaping .sun { display: none; }
.shape-panel { flex-direction: column; gap: 14px; padding: 12px 16px; border-top: 1px solid var(--line); }
.shape-panel .tilt { gap: 6px; }
.shape-panel .remark { margin: 0; color: var(--soft); }
.shape-map { position: absolute; pointer-events: none; }
.shaping .stage { cursor: default; }
.shaping .stage[data-tool=brush] { cursor: none; }
.shaping .stage[data-tool=fill], .shaping .stage[data-tool=tilt] { cursor: crosshair; }
.shape-ring { position: absolute; left: 0; top: 0; border-radius: 50%; border: 1.5px solid #fff; pointer-events: none;
  box-shadow: 0 0 0 1px rgba(0, 0, 0, .7), inset 0 0 0 1px rgba(0, 0, 0, .5); }
.shaping .stage[data-tool=tilt] .shape-ring { border-style: dashed; }
.shaping .stage:is([data-tool=brush], [data-tool=tilt]):not(.hand, .panning):hover .shape-ring { display: block; }
.points { position: absolute; inset: 0; pointer-events: none; }
.point { position: absolute; left: -8px; top: -8px; width: 16px; height: 16px; padding: 0; border-radius: 50%; background: #fff;
  border: 3px solid #1c1c1e; pointer-events: none; justify-content: flex-start; }
.point:hover { background: #fff; }
.point i { position: absolute; left: 5px; top: 3.5px; height: 3px; border-radius: 2px; transform-origin: 0 50%; background: #fff;
  box-shadow: 0 0 0 1.5px #1c1c1e; }
.tilt-ball { position: absolute; left: 0; top: 0; pointer-events: none; opacity: .9; filter: drop-shadow(0 3px 10px rgba(0, 0, 0, .5)); }
.tilt-ball.on { display: block; }
.tilt-ball svg { display: block; width: ${2 * TILT_BALL_PIXELS + 16}px; height: ${2 * TILT_BALL_PIXELS + 16}px; }
.tilt-ball .meridians { stroke: rgba(0, 0, 0, .25); fill: none; }
.tilt-ball .shaft { stroke: #1c1c1e; stroke-width: 3; }
.tilt-ball .tip { fill: #f2a11b; stroke: #fff; stroke-width: 2; }
.tilt-ball .words { position: absolute; left: 50%; top: calc(100% - 4px); transform: translateX(-50%); padding: 2px 9px; white-space: nowrap;
  border-radius: 999px; font-size: 12px; color: #fff; background: rgba(20, 20, 22, .8); }
`
