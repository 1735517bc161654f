"""A checkerboard of transparency that was painted into a picture, instead of transparency itself."""

from __future__ import annotations

import numpy as np

from toonkit._validation import FloatArray

_CORNER = 256  # pixels; an object seldom fills all four corners
_SMALLEST, _LARGEST = 3, 64  # pixels a square
_GRAY = 16 / 255  # largest difference between the channels of its two grays
_WAVER = 12 / 255  # how far lossy compression moves them
_APART = 6 / 255  # least difference of the two
_SHARE = 0.5  # least share of the frame that has one of them
_ALTERNATION = 0.7  # least agreement with the pattern, from -1 to 1


def has_checkerboard(color: FloatArray) -> bool:
    """Tell whether the corners of a picture, (H, W, 3) sRGB, alternate between two grays in both directions."""
    grays = _two_grays(np.concatenate([color[0], color[-1], color[1:-1, 0], color[1:-1, -1]]))
    if grays is None:
        return False
    height, width = min(_CORNER, color.shape[0]), min(_CORNER, color.shape[1])
    corners = [color[rows, columns] for rows in (slice(height), slice(-height, None))
               for columns in (slice(width), slice(-width, None))]  # fmt: skip
    signs = np.stack([_signs(corner, grays) for corner in corners])
    best = min(
        range(_SMALLEST, min(_LARGEST, min(height, width) // 2) + 1),
        key=lambda lag: _agreement(signs, lag, 0) + _agreement(signs, 0, lag),
        default=0,
    )
    if best == 0:
        return False
    along = max(_agreement(signs, best, 0), _agreement(signs, 0, best))
    if along > -_ALTERNATION or _agreement(signs, best, best) < _ALTERNATION:
        return False
    # Half a square down and across, half of the pixels differ; with slanted stripes all of them do.
    return abs(_agreement(signs, best // 2, best // 2)) < _ALTERNATION


def _two_grays(frame: FloatArray) -> tuple[float, float] | None:
    """Return the two grays that most of the frame has, the darker first."""
    gray = frame.mean(axis=1)[np.ptp(frame, axis=1) <= _GRAY]
    if len(gray) < _SHARE * len(frame):
        return None
    counts = np.bincount(np.round(gray * 255).astype(np.intp), minlength=256)
    first = int(counts.argmax()) / 255
    others = counts.copy()
    others[np.abs(np.arange(256) / 255 - first) <= _APART] = 0
    second = int(others.argmax()) / 255
    if not others.any():
        return None
    near = [np.abs(gray - tone) <= min(_WAVER, abs(first - second) / 2) for tone in (first, second)]
    enough = (near[0] | near[1]).sum() >= _SHARE * len(frame) and near[1].sum() >= _SHARE * len(frame) / 4
    return (min(first, second), max(first, second)) if enough else None


def _signs(corner: FloatArray, grays: tuple[float, float]) -> FloatArray:
    """Return -1 where a picture has the darker gray, 1 where it has the brighter one, 0 elsewhere."""
    gray = np.where(np.ptp(corner, axis=-1) <= _GRAY, corner.mean(axis=-1), np.inf)
    reach = min(_WAVER, (grays[1] - grays[0]) / 2.01)
    return np.where(
        np.abs(gray - grays[1]) <= reach, 1.0, np.where(np.abs(gray - grays[0]) <= reach, -1.0, 0.0)
    )


def _agreement(signs: FloatArray, down: int, right: int) -> float:
    """Correlate signs (n, H, W) with themselves so many pixels away: -1 if all differ, 1 if all are alike."""
    one, other = signs[:, down:, right:], signs[:, : signs.shape[1] - down, : signs.shape[2] - right]
    product = one * other
    known = np.abs(product).sum()
    return float(product.sum() / known) if known > 0 else 0.0
