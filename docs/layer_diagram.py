"""Draw the layers of toonkit as `pyproject.toml` states them: `python -m docs.layer_diagram -o docs/figures/layers.svg`."""

from __future__ import annotations

import argparse
import re
import tomllib
from pathlib import Path
from xml.sax.saxutils import escape

ROOT = Path(__file__).parent.parent
WIDTH, MARGIN, GAP = 640, 12, 8
BOX_HEIGHT, STEP = 34, 46
"""Pixels: height of a box, and from one layer to the next."""

FILL, FRAME, TEXT = "#e8f0f7", "#0072b2", "#1f1f21"


def layers() -> list[list[str]]:
    """Return the modules of each layer, the highest first."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    (stated,) = (contract["layers"] for contract in contracts if contract["type"] == "layers")
    return [re.findall(r"\w+", layer) for layer in stated]


def draw_layers(rows: list[list[str]]) -> str:
    """Return an SVG picture with a row of boxes for each layer."""
    height = STEP * len(rows) - (STEP - BOX_HEIGHT) + 2 * MARGIN
    font = 'font-family="DejaVu Sans Mono, monospace" font-size="14"'
    size = f'viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}"'
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} {font}>',
        f'<rect width="{WIDTH}" height="{height}" fill="#ffffff"/>',
    ]
    for number, names in enumerate(rows):
        width = (WIDTH - 2 * MARGIN - GAP * (len(names) - 1)) / len(names)
        top = MARGIN + number * STEP
        for place, name in enumerate(names):
            left = MARGIN + place * (width + GAP)
            box = f'x="{left:.1f}" y="{top}" width="{width:.1f}" height="{BOX_HEIGHT}" rx="4"'
            text = f'x="{left + width / 2:.1f}" y="{top + 22}" text-anchor="middle"'
            lines += [
                f'<rect {box} fill="{FILL}" stroke="{FRAME}"/>',
                f'<text {text} fill="{TEXT}">{escape(name)}</text>',
            ]
    return "\n".join([*lines, "</svg>", ""])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--out", type=Path, required=True, help="file to write")
    parser.parse_args().out.write_text(draw_layers(layers()))
