"""Pictures of materials, a color for each as in `toonkit.model.label_colors`, read back from any paint program."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import refuse
from toonkit.export.atomic import PathLike, suffix_of
from toonkit.model.decoding import read_palette_indices, read_pixels
from toonkit.model.loading import HALF_COVERED

MOST_LABELS = 256
"""Materials that a picture may name; one of more colors is a drawing, or the borders of its colors are soft."""


def read_labels(path: PathLike) -> NDArray[np.intp]:
    """
    Read which pixels of a picture have the same color.

    Parameters
    ----------
    path : path
        A .png or .webp file with hard borders between its colors. Entries of a palette are told apart even if they have
        the same color.

    Returns
    -------
    ndarray of int, shape (H, W)
        Numbers from 0 on, in the order of their areas, the largest first; -1 where the picture is transparent.

    Raises
    ------
    ToonkitError
        If the suffix is another, the file is no such picture, transparent everywhere, or of more than `MOST_LABELS` colors.
    """
    suffix_of(path, (".png", ".webp"), "materials")
    pixels = read_pixels("materials", path, colors=False)
    index: NDArray[np.integer] | None = read_palette_indices("materials", path)
    if index is None:
        red, green, blue = np.moveaxis(np.round(pixels.color * 65535).astype(np.int64), -1, 0)
        index = (red << 32) | (green << 16) | blue
    known = np.full(index.shape, True) if pixels.alpha is None else pixels.alpha >= HALF_COVERED
    if not known.any():
        raise refuse(
            "materials", "must be opaque where a material is known", f"{path}, transparent everywhere"
        )
    _, number, area = np.unique(index[known], return_inverse=True, return_counts=True)
    if len(area) > MOST_LABELS:
        rule = f"must have at most {MOST_LABELS} colors, one a material, with hard borders between them"
        raise refuse("materials", rule, f"{path} with {len(area):,} colors")
    rank = np.argsort(np.argsort(-area, kind="stable"))
    labels = np.full(index.shape, -1, np.intp)
    labels[known] = rank[number]
    return labels
