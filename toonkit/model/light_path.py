"""A light that travels from one direction to the next along the sphere, by the shortest way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import FloatArray, is_count, refuse
from toonkit.model.light import direction_of

MOST_FRAMES = 720
"""Half a degree for each frame of a full turn. More frames would fill the memory without a visible difference."""

_SAME = 1e-9
"""Sine of the angle between two lights below which they are the same, or opposite."""


def light_path(lights: Sequence[ArrayLike] | ArrayLike, frames: int, *, loop: bool = True) -> FloatArray:
    """
    Return the light of each frame as it travels from one light to the next, in the same time between any two.

    Parameters
    ----------
    lights : sequence of array_like
        Two or more lights in the order of travel, each a direction (3,) or azimuth and elevation in degrees (2,), as in
        `toonkit.relight`.
    frames : int
        Number of frames, 2 to 720.
    loop : bool, optional
        Whether the light returns to the first one, for an animation without end; otherwise it ends at the last one.

    Returns
    -------
    ndarray, shape (frames, 3)
        Unit vectors from the surface to the light. The first is the first light; without `loop`, the last is the last light.

    Raises
    ------
    ToonkitError
        If there are fewer than two lights, one of them is not a valid light, or `frames` is out of range.

    Notes
    -----
    Between two lights the path is the shorter arc of the great circle through both, at an even speed. Between opposite
    lights, many ways are equally short: the one on the viewer's side is taken.

    Examples
    --------
    >>> light_path([(0, 0), (120, 0)], 3, loop=False).round(3).tolist()
    [[1.0, 0.0, 0.0], [0.5, 0.866, 0.0], [-0.5, 0.866, 0.0]]
    """
    try:
        given = list(lights)  # type: ignore[arg-type]  # what is no sequence is refused
    except TypeError:
        given = []
    if len(given) < 2:
        raise refuse("lights", "must be two or more lights, as a sequence", lights)
    if not is_count(frames, 2, MOST_FRAMES):
        raise refuse("frames", f"must be a whole number from 2 to {MOST_FRAMES}", frames)
    ends = [direction_of(f"lights[{place}]", light, behind=True) for place, light in enumerate(given)]
    if loop:
        ends.append(ends[0])
    ways = len(ends) - 1
    positions = np.arange(frames) * (ways / (frames if loop else frames - 1))
    return np.array([_on_the_way(ends, float(position)) for position in positions])


def _on_the_way(ends: list[FloatArray], position: float) -> FloatArray:
    """Return the light at a position: 0 at the first light, 1 at the second one, and so on."""
    start = min(int(position), len(ends) - 2)
    return _between(ends[start], ends[start + 1], position - start)


def _between(start: FloatArray, end: FloatArray, share: float) -> FloatArray:
    """Return the unit vector at a share, 0 to 1, of the shortest way between two unit vectors."""
    cosine = float(start @ end)
    ahead = end - cosine * start
    sine = float(np.linalg.norm(ahead))
    if sine < _SAME:
        # Toward the viewer; from a light at the viewer's eye, over the top.
        upward = np.array([0.0, 0.0, 1.0]) if abs(start[2]) < 1 - _SAME else np.array([0.0, 1.0, 0.0])
        ahead = upward - float(upward @ start) * start
    turn = share * np.arctan2(sine, cosine)
    light = np.cos(turn) * start + np.sin(turn) * ahead / np.linalg.norm(ahead)
    return np.asarray(light / np.linalg.norm(light))
