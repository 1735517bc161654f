"""Fit the weights `toonkit.illustration.contact_cues.CUE_WEIGHTS`: what tells that two touching tones are one material.

    python -m benchmarks.tone_pairs --drawings 150

Generated drawings, of seeds that no other benchmark draws, say of every pair of their tones that touch whether it is one
material. A logistic regression on the cues of those pairs gives the weights.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize
from tqdm import tqdm

from benchmarks.materials import TOUCHED, drawn
from toonkit._validation import BoolArray, FloatArray
from toonkit.estimation.preparation import prepare
from toonkit.illustration.contact_cues import CUE_WEIGHTS, measure_contact_cues
from toonkit.illustration.materials import read_tones
from toonkit.illustration.ramps import SMALL
from toonkit.illustration.shades import shade_cost
from toonkit.synthetic.drawing import DrawnScene

FIRST_SEED = 30_000
"""Seed of the first drawing; the others follow."""

PURE = 0.85
"""Share of a tone's pixels that are of one material, for it to say anything."""

RIDGE = 1e-3
"""Weight of the squared weights, in units of the cues' standard deviations."""


def pairs_of(scene: DrawnScene) -> tuple[FloatArray, BoolArray, FloatArray]:
    """Return of a drawing's touching tones the cues (k, c), whether they are one material (k,), and their weight (k,)."""
    drawing = prepare(scene.image)
    _, tones, facing = read_tones(drawing.frame, drawing.ink.coverage, drawing.framed_normals)
    truth = np.where(scene.image.mask & (scene.ink < TOUCHED), scene.labels, -1)[drawing.box]
    labels = drawing.frame.inner(tones.labels)
    counted = (labels >= 0) & (truth >= 0)
    table = np.zeros((len(tones.area), truth.max() + 1))
    np.add.at(table, (labels[counted], truth[counted]), 1.0)
    pure = table.max(axis=1) > PURE * np.maximum(table.sum(axis=1), 1.0)
    told = pure & (tones.area > SMALL * tones.area.sum())
    first, second = np.nonzero(np.triu(tones.contact > 0, 1) & told[:, None] & told)
    cues = measure_contact_cues(tones, shade_cost(tones.lab), facing)
    share = np.minimum(tones.area[first], tones.area[second]) / tones.area.sum()
    same = table.argmax(axis=1)[first] == table.argmax(axis=1)[second]
    return (
        np.column_stack([cues[name][first, second] for name in CUE_WEIGHTS]),
        same,
        np.sqrt(share) + 0.02,
    )


def fitted(cues: FloatArray, same: BoolArray, weight: FloatArray) -> FloatArray:
    """Return the weights (c,) of the cues (k, c) in the log-odds of being one material, by ridge logistic regression."""
    spread = np.where(np.ptp(cues, axis=0) > 0, cues.std(axis=0), 1.0)
    scaled, weight = cues / spread, weight / weight.sum()

    def loss(weights: FloatArray) -> tuple[float, FloatArray]:
        odds = scaled @ weights
        value = weight @ (np.logaddexp(0.0, odds) - same * odds) + RIDGE * weights @ weights
        slope = scaled.T @ (weight * (1.0 / (1.0 + np.exp(-odds)) - same)) + 2 * RIDGE * weights
        return float(value), slope

    return np.asarray(minimize(loss, np.zeros(cues.shape[1]), jac=True, method="L-BFGS-B").x / spread)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="Fit the weights that join tones to materials.")
    parser.add_argument("--drawings", type=int, default=150, metavar="N", help="drawings (default: 150)")
    parser.add_argument("--size", type=int, default=256, help="side of the drawings (default: 256)")
    given = parser.parse_args(arguments)
    found = [pairs_of(drawn(FIRST_SEED + step, given.size)) for step in tqdm(range(given.drawings))]
    cues, same, weight = (np.concatenate(parts) for parts in zip(*found, strict=True))
    print(f"{len(same)} pairs in {given.drawings} drawings")
    for name, value in zip(CUE_WEIGHTS, fitted(cues, same, weight), strict=True):
        print(f"{name:<16} {value:8.2f}   used: {CUE_WEIGHTS[name]:6.2f}")


if __name__ == "__main__":
    main()
