"""Whether frames show an object that turns once around before the viewer, and what they say together about its shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from toonkit._validation import BoolArray, FloatArray
from toonkit.frames.visual_hull import VisualHull, turned, turned_vectors

LEAST_FRAMES = 6
"""Least number of frames of a whole turn: fewer silhouettes leave too much of the shape open."""

FILLED = 0.985
"""Least share of each silhouette that the hull of all of them fills if the frames show one object from all around."""

CLEAR = 0.005
"""Share of the pixels by which materials must fit a turn one way better than the other way, to tell which it is."""

CLOSER = 0.93
"""Largest ratio of the angles between normals for one way and for the other that tells which, where materials do not."""

MOVED = 0.97
"""Overlap of neighboring silhouettes below which an object turns even if its materials do not show it."""

HIDDEN = 0.03
"""Distance behind the hull's front beyond which a point is hidden, as a share of the picture's longer side."""

MOST_VIEWS = 16
"""Largest number of frames that contribute to the mean; the others only receive it."""

AT_THE_RIM = 0.1
"""Weight added to 1 - z of each normal: a normal counts most at the rim, where the silhouette determines it."""

SMOOTHED = 0.01
"""Standard deviation, as a share of the picture's longer side, over which normals are smoothed from row to row: each row is
looked up separately. Smoothing along the rows as well removed more detail than noise."""

HULL_SHARE = 0.4
"""Weight of the hull's own normals, relative to 1 for the mean of the frames' normals."""


@dataclass(frozen=True, eq=False)
class Views:
    """
    Frames of one size, all of which show something.

    Attributes
    ----------
    masks : ndarray of bool, shape (n, h, w)
        True on the object.
    labels : ndarray of int, shape (n, h, w)
        Its materials, -1 outside.
    normals : ndarray, shape (n, h, w, 3)
        Its unit normals, zero outside.
    """

    masks: BoolArray
    labels: NDArray[np.integer]
    normals: FloatArray


@dataclass(frozen=True, eq=False)
class Turntable:
    """
    Frames that show one object from all around.

    Attributes
    ----------
    views : Views
        The frames.
    angles : ndarray, shape (n,)
        By how much the object is turned in each frame, in radians; as they rise, its front turns to the right.
    hull : VisualHull
        The visual hull of the silhouettes.
    depth : ndarray, shape (n, h, w)
        z of the hull's front in each frame, in pixels; 0 outside the object.
    """

    views: Views
    angles: FloatArray
    hull: VisualHull
    depth: FloatArray

    @classmethod
    def of(cls, views: Views, angles: FloatArray, hull: VisualHull) -> Turntable:
        """Measure the front of the hull in each frame, turned by these angles."""
        depth = np.array([hull.depth(*view) for view in zip(views.masks, angles, strict=True)])
        return cls(views, angles, hull, depth)

    def fused_normals(self, frame: int) -> FloatArray:
        """
        Return the unit normals (P, 3) of a frame on which all frames agree.

        Notes
        -----
        This is the weighted mean of the normals that the frames have at the same point of the hull, where they show it in
        the same material, and of those of the hull itself. A single drawing determines normals best at its rim. What faces
        the viewer in one frame is at the rim of others, a quarter turn away. So the more a normal faces the viewer, the
        less it counts.
        """
        mask = self.views.masks[frame]
        size = int(np.count_nonzero(mask))
        mean, weights = np.zeros((size, 3)), np.full(size, 1e-9)
        for other in range(0, len(self.angles), -(-len(self.angles) // MOST_VIEWS)):
            normals, alike = self._seen_in(other, frame)
            weight = (1 + AT_THE_RIM - normals[:, 2]) * alike
            back = self.angles[frame] - self.angles[other]
            mean += weight[:, None] * turned_vectors(back, normals)
            weights += weight
        mean /= weights[:, None]
        mean += HULL_SHARE * self.hull.normals(mask, self.depth[frame], float(self.angles[frame]))
        mean[:, 2] = np.maximum(mean[:, 2], 0.0)
        return _smoothed(_unit(mean), mask)

    def agreement(self) -> tuple[float, float]:
        """Return the share of points of one material in neighboring frames, and the mean angle of their normals, radians."""
        same, apart = [], []
        for frame in range(len(self.angles)):
            other = (frame + 1) % len(self.angles)
            normals, alike = self._seen_in(other, frame)
            seen = np.linalg.norm(normals, axis=-1) > 0
            own = self.views.normals[frame][self.views.masks[frame]][alike]
            back = turned_vectors(self.angles[frame] - self.angles[other], normals[alike])
            same.append(_share(alike, seen))
            apart.append(np.arccos(np.clip((own * back).sum(axis=-1), -1, 1)).mean() if alike.any() else 0.0)
        return float(np.mean(same)), float(np.mean(apart))

    def _seen_in(self, other: int, frame: int) -> tuple[FloatArray, BoolArray]:
        """
        Look for the pixels of a frame in another.

        Returns their normals there as the viewer sees them (P, 3), zero if they are hidden, and whether they are seen there
        in the same material (P,).
        """
        masks, axis = self.views.masks, self.hull.axis
        rows, columns = np.nonzero(masks[frame])
        depth = self.depth[frame][rows, columns]
        x, z = turned(float(self.angles[other] - self.angles[frame]), columns - axis, depth)
        column = np.clip(x + axis, 0, masks.shape[2] - 1)
        nearest = np.rint(column).astype(np.intp)
        slack = HIDDEN * max(masks.shape[1:])
        seen = masks[other][rows, nearest] & (z > self.depth[other][rows, nearest] - slack)
        left = np.minimum(column.astype(np.intp), masks.shape[2] - 2)
        share = (column - left)[:, None]
        field = self.views.normals[other]
        normals = _unit((1 - share) * field[rows, left] + share * field[rows, left + 1])
        normals[~seen] = 0.0
        labels = self.views.labels
        return normals, seen & (labels[other][rows, nearest] == labels[frame][rows, columns])


def find_turntable(views: Views) -> Turntable | None:
    """
    Find out whether frames show an object that turns once around, by equal angles, about an upright axis.

    Parameters
    ----------
    views : Views
        The frames.

    Returns
    -------
    Turntable or None
        None if the frames do not show such an object, or the direction in which it turns cannot be found.

    Notes
    -----
    Silhouettes of other motions contradict each other: their hull does not fill them. Silhouettes do not show which way the
    object turns: its materials tell, which are where the turn takes them, or else its normals.
    """
    count = len(views.masks)
    if count < LEAST_FRAMES:
        return None
    angles = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    hull = VisualHull.carved(list(views.masks), angles.tolist())
    if any(hull.shows(mask, float(angle)) < FILLED for mask, angle in zip(views.masks, angles, strict=True)):
        return None
    ways = [
        Turntable.of(views, angles, hull),
        Turntable.of(views, -angles, VisualHull.carved(list(views.masks), (-angles).tolist())),
    ]
    (same, apart), (same_back, apart_back) = (way.agreement() for way in ways)
    if abs(same - same_back) >= CLEAR:
        likelier = 0 if same > same_back else 1
        return ways[likelier] if max(same, same_back) > _still(views) else None
    likelier = 0 if apart < apart_back else 1
    clear = min(apart, apart_back) < CLOSER * max(apart, apart_back)
    return ways[likelier] if clear and _overlap(views.masks) < MOVED else None


def _still(views: Views) -> float:
    """Return the share of their common pixels at which neighboring frames have the same material."""
    both = views.masks & np.roll(views.masks, -1, axis=0)
    return _share((views.labels == np.roll(views.labels, -1, axis=0)) & both, both)


def _overlap(masks: BoolArray) -> float:
    """Return the share of the pixels of neighboring silhouettes that are in both."""
    after = np.roll(masks, -1, axis=0)
    return _share(masks & after, masks | after)


def _smoothed(vectors: FloatArray, mask: BoolArray) -> FloatArray:
    """Smooth unit vectors (P, 3) at the pixels of a mask (h, w) from row to row."""
    field = np.zeros((*mask.shape, 3))
    field[mask] = vectors
    return _unit(gaussian_filter1d(field, SMOOTHED * max(mask.shape), axis=0)[mask])


def _share(some: BoolArray, many: BoolArray) -> float:
    return int(np.count_nonzero(some)) / max(int(np.count_nonzero(many)), 1)


def _unit(vectors: FloatArray) -> FloatArray:
    """Scale vectors (P, 3) to unit length, but for those that have none."""
    unit: FloatArray = vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)
    return unit
