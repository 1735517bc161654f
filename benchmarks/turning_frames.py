"""How much the normals of an object change from frame to frame while it turns.

    python -m benchmarks.turning_frames -o benchmarks/results/turning_frames.csv

Paints shapes of the study that turn about their upright axis, by some degrees a frame, in flat tones with an outline, and
analyzes the frames together: as `analyze_frames` does, and without what couples them. The normals of neighboring frames are
compared at the same points of the object, after both are turned back: the normals of a rigid object would not change at
all. Writes one row for each shape and turn.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

import toonkit
from benchmarks.shape_rows import Row
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.frames.analysis import FrameAnalysis
from toonkit.frames.montage import montage
from toonkit.metrics import angular_error
from toonkit.model.image import eight_bit
from toonkit.model.loading import image_of
from toonkit.model.normals import NormalField
from toonkit.study.registry import View
from toonkit.study.rendering import RenderedShape, render_turns
from toonkit.study.shapes import SHAPES

SHAPE_NAMES = ("cat", "duck", "head", "mushroom", "rabbit", "snowman", "teapot")
TURNS = {30.0: 12, 45.0: 8, 10.0: 4, 5.0: 4, 1.0: 4}
"""Frames for each number of degrees between them: 30 and 45 go once around."""

SIZE = 128
LIGHT = (130.0, 45.0)
STEP = 0.2
"""Illumination at which the tone of each part changes."""

TONES = np.array(
    [
        [[208, 150, 120], [250, 206, 172]],
        [[40, 84, 130], [84, 150, 206]],
        [[104, 30, 44], [176, 62, 70]],
        [[60, 110, 60], [110, 180, 96]],
        [[150, 120, 40], [230, 200, 90]],
    ]
)
INK, OUTLINE = (24, 18, 28), 2.0
NEIGHBORS = 4
"""Pixels of the next frame between whose points normals are interpolated."""


@dataclass(frozen=True, eq=False)
class PaintedFrame:
    """
    A frame of a turning object, and what is known of it.

    Attributes
    ----------
    picture : ndarray of uint8, shape (n, n, 4)
        RGBA.
    points : ndarray, shape (n, n, 3)
        Where on the object each pixel is, in its own axes; NaN outside.
    normals : ndarray, shape (n, n, 3)
        Normals as the viewer sees them; NaN outside.
    turn : ndarray, shape (3, 3)
        From the object's axes to the viewer's.
    """

    picture: NDArray[np.uint8]
    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    turn: NDArray[np.float64]


def painted(shape: RenderedShape, yaw: float) -> PaintedFrame:
    """Paint one view of a turning shape."""
    normals, mask = shape.normals.vectors, shape.mask
    lit = (np.nan_to_num(normals) @ toonkit.light_direction(*LIGHT) > STEP).astype(np.intp)
    colors = TONES[shape.part % len(TONES), lit]
    colors[mask & (distance_transform_edt(mask) < OUTLINE)] = INK
    nearest = distance_transform_edt(~mask, return_distances=False, return_indices=True)
    picture = np.dstack([colors[tuple(nearest)].astype(np.uint8), eight_bit(shape.coverage)])
    turn, middle = View(yaw=yaw).matrix(), (len(mask) - 1) / 2
    row, column = np.indices(mask.shape)
    seen = np.stack([column - middle, middle - row, shape.depth], axis=-1)
    return PaintedFrame(picture, seen @ turn, normals, turn)


def change_at_points(frames: Sequence[PaintedFrame], normals: Sequence[NDArray[np.float64]]) -> float:
    """
    Return how much normals change from frame to frame where they show the same points of an object, beside its turn.

    Parameters
    ----------
    frames : sequence of PaintedFrame
        The frames.
    normals : sequence of ndarray, shape (n, n, 3)
        Normals of each frame, as the viewer sees them; NaN outside.

    Returns
    -------
    float
        Mean angle in degrees, of the normals turned back.
    """
    changes = []
    for (frame, own), (after, next_normals) in pairwise(zip(frames, normals, strict=True)):
        here = np.isfinite(own[..., 0]) & np.isfinite(frame.points[..., 0])
        there = np.isfinite(next_normals[..., 0]) & np.isfinite(after.points[..., 0])
        spacing = np.nanmedian(np.linalg.norm(np.diff(after.points, axis=1), axis=-1))
        distances, nearest = cKDTree(after.points[there]).query(frame.points[here], k=NEIGHBORS)
        common = distances[:, 0] < spacing
        near = distances[common] < 2 * spacing
        weights = near / (distances[common] ** 2 + (1e-4 * spacing) ** 2)
        around = (next_normals[there] @ after.turn)[nearest[common]]
        changes.append(
            _angles((weights[..., None] * around).sum(axis=1), own[here][common] @ frame.turn).mean()
        )
    return float(np.mean(changes))


def error(frames: Sequence[PaintedFrame], normals: Sequence[NDArray[np.float64]]) -> float:
    """Return the mean error of normals (n, n, 3) of frames, degrees."""
    errors = []
    for frame, own in zip(frames, normals, strict=True):
        mask = np.isfinite(own[..., 0]) & np.isfinite(frame.normals[..., 0])
        found, true = (
            NormalField(np.where(mask[..., None], field, np.nan), mask) for field in (own, frame.normals)
        )
        errors.append(angular_error(found, true).mean)
    return float(np.mean(errors))


def _angles(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    across = np.linalg.norm(np.cross(first, second), axis=-1)
    return np.degrees(np.arctan2(across, (first * second).sum(axis=-1)))


def analyzed_alone(pictures: Sequence[NDArray[np.uint8]]) -> list[NDArray[np.float64]]:
    """Return the normals of frames with one light and the same materials that do not agree on a shape."""
    pixels, places = montage(pictures)
    drawing = PreparedDrawing(image_of(pixels, None), views=len(pictures))
    return FrameAnalysis(toonkit.analyze(drawing, LIGHT), places).normals()


def measured(name: str, degrees: float, count: int, size: int) -> Row:
    """Measure one shape."""
    yaws = [degrees * number for number in range(count)]
    shapes = render_turns(SHAPES[name], size, yaws)
    frames = [painted(shape, yaw) for shape, yaw in zip(shapes, yaws, strict=True)]
    pictures = [frame.picture for frame in frames]
    alone, together = analyzed_alone(pictures), toonkit.analyze_frames(pictures, LIGHT).normals()
    return {
        "shape": name,
        "degrees": degrees,
        "frames": count,
        "true_change": change_at_points(frames, [frame.normals for frame in frames]),
        "change_alone": change_at_points(frames, alone),
        "change": change_at_points(frames, together),
        "error_alone": error(frames, alone),
        "error": error(frames, together),
    }


def table(rows: Sequence[Row]) -> str:
    """Return the means over shapes as a Markdown table, a line for each turn."""
    lines = [
        "| degrees between frames | change, by itself | change, together | error, by itself | error, together |"
    ]
    lines.append("|---|---|---|---|---|")
    columns = ["change_alone", "change", "error_alone", "error"]
    for degrees, means in pd.DataFrame(rows).groupby("degrees")[columns].mean().iterrows():
        lines.append(f"| {degrees:.0f}° | {' | '.join(f'{means[column]:.1f}°' for column in columns)} |")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="How much normals change from frame to frame.")
    parser.add_argument("-o", "--output", type=Path, metavar="CSV", help="write one row per shape and turn")
    parser.add_argument(
        "--shapes", nargs="+", default=list(SHAPE_NAMES), choices=list(SHAPES), metavar="SHAPE"
    )
    parser.add_argument("--turns", nargs="+", type=float, default=list(TURNS), choices=list(TURNS))
    parser.add_argument("--size", type=int, default=SIZE, help=f"pixels (default: {SIZE})")
    given = parser.parse_args(arguments)
    rows = pd.DataFrame(
        measured(name, degrees, TURNS[degrees], given.size)
        for degrees in given.turns
        for name in given.shapes
    )
    print(rows.to_string(index=False, float_format="{:.2f}".format))
    print(table(rows.to_dict("records")))
    if given.output is not None:
        rows.round(3).to_csv(given.output, index=False)


if __name__ == "__main__":
    main()
