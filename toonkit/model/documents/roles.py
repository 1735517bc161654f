"""
What layers are for: which hold the ink, which the flat colors, by their names or by what they look like.

A layer has the role that its name says, or else that of the innermost group whose name says one. Without any name that says
so, ink is what lies on top: visible layers of nothing but dark, thin lines.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from toonkit._validation import BoolArray, refuse
from toonkit.model.decoding import MAX_PIXELS
from toonkit.model.documents.document import Document, Layer, LayerPixels
from toonkit.model.luminance import REC709

Role = Literal["ink", "flats"]
Coverage = NDArray[np.float32]

INK_WORDS = frozenset(
    [
        "ink",
        "inks",
        "inked",
        "inking",
        "line",
        "lines",
        "lineart",
        "linework",
        "outline",
        "outlines",
        "contour",
        "contours",
    ]
)
FLATS_WORDS = frozenset(
    ["flat", "flats", "flatting", "flatcolor", "flatcolors", "base", "bases", "basecolor", "basecolors"]
)

MOST_PIXELS = 8 * MAX_PIXELS
"""Pixels of layers that are decoded for one drawing, at most."""

INKED = 0.4
"""Coverage from which a pixel is ink: where a thin line runs between two pixels, neither is covered by more than a half."""

DARK, DARK_SHARE = 0.35, 0.8
"""Luma that lines on top have at most, and the share of their pixels that have it."""

WIDEST, WIDE_SHARE = 0.035, 0.25
"""Width of lines in square roots of the drawing's area, and the share of their pixels that may lie in wider parts: filled
black."""

MOST_COVERED = 0.4
"""Share of the drawing that lines cover, at most."""

PAPER = 0.7
"""Share of the drawing that a layer covers if it shows lines on paper."""

TOPMOST = 4
"""Layers on top that are looked at, at most."""


def role_of(names: Sequence[str]) -> Role | None:
    """
    Tell what a layer is for by its name and those of its groups, the innermost first.

    Examples
    --------
    >>> role_of(["Hair", "LineArt"]), role_of(["02_flats"]), role_of(["Shadow"])
    ('ink', 'flats', None)
    """
    for name in names:
        words = {word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+", name)}
        if words & INK_WORDS:
            return "ink"
        if words & FLATS_WORDS:
            return "flats"
    return None


def layers_named(argument: str, document: Document, names: Sequence[str]) -> tuple[Layer, ...]:
    """Return the layers that somebody names, by their own names or those of their groups, whatever the case."""
    found: list[Layer] = []
    for name in names:
        wanted = name.strip().lower()
        own = [
            layer
            for layer in document.layers
            if wanted in (known.strip().lower() for known in (layer.name, *layer.groups))
        ]
        if not own:
            known = ", ".join(dict.fromkeys(layer.name for layer in document.layers)) or "none"
            rule = f"must be the name of a layer or group of pixels in {document.name}"
            raise refuse(argument, rule, f"{name!r}; it has {known[:300]}")
        found += own
    return tuple(layer for layer in document.layers if layer in found)


def find_ink_layers(document: Document, mask: BoolArray) -> tuple[Layer, ...]:
    """Return the visible layers that hold the ink of a drawing: those named so, or those that look so."""
    shown = [layer for layer in document.layers if layer.visible and layer.opacity > 0]
    named = tuple(layer for layer in shown if role_of((layer.name, *layer.groups)) == "ink")
    if named:
        return named
    found: list[Layer] = []
    for layer in shown[: -TOPMOST - 1 : -1] if len(shown) > 1 else []:
        check_area((layer,))
        if not _looks_inked(layer, mask):
            break
        found.insert(0, layer)
    return tuple(found)


def find_flats_layers(document: Document) -> tuple[Layer, ...]:
    """Return the layers named as flat colors: those that are visible, or else hidden ones."""
    named = tuple(layer for layer in document.layers if role_of((layer.name, *layer.groups)) == "flats")
    return tuple(layer for layer in named if layer.visible) or named


def check_area(layers: Sequence[Layer]) -> None:
    """Refuse to decode layers that are too large together."""
    area = sum(layer.area for layer in layers)
    if area > MOST_PIXELS:
        rule = f"must have layers of at most {MOST_PIXELS // 10**6} million pixels where they are read (merge some)"
        raise refuse("source", rule, f"{area // 10**6} million")


def ink_coverage(document: Document, inked: Sequence[Layer], mask: BoolArray) -> Coverage:
    """
    Return how much of each pixel ink covers that no other layer hides, shape (H, W).

    Ink of a layer that is multiplied with those below, or that shows lines on paper, covers a pixel as far as it is dark.
    """
    lowest = min(document.layers.index(layer) for layer in inked)
    hiding = [
        layer
        for layer in document.layers[lowest:]
        if layer in inked or (layer.visible and layer.blend == "normal" and not layer.clipped)
    ]
    check_area(hiding)
    coverage: Coverage = np.zeros(mask.shape, np.float32)
    for layer in hiding:
        pixels = layer.read()
        if layer in inked:
            own = _ink_of(layer, pixels, mask)
            coverage += own * (1 - coverage)
        else:
            coverage *= 1 - _share(layer, pixels)
    return coverage


def _share(layer: Layer, pixels: LayerPixels) -> Coverage:
    return pixels[..., 3] * np.float32((layer.opacity or 1.0) / 255)


def _ink_of(layer: Layer, pixels: LayerPixels, mask: BoolArray) -> Coverage:
    share = _share(layer, pixels)
    if layer.blend == "multiply" or np.count_nonzero(mask & (share > 0.9)) > PAPER * np.count_nonzero(mask):
        share = share * (1 - _luma(pixels))
    return share


def _luma(pixels: LayerPixels) -> Coverage:
    return np.asarray(pixels[..., :3] @ (REC709.astype(np.float32) / 255), np.float32)


def _looks_inked(layer: Layer, mask: BoolArray) -> bool:
    """Tell whether a layer holds nothing but dark, thin lines."""
    pixels = layer.read()
    inked = mask & (_ink_of(layer, pixels, mask) >= INKED)
    count, area = np.count_nonzero(inked), np.count_nonzero(mask)
    if not 0 < count <= MOST_COVERED * area:
        return False
    if np.mean(_luma(pixels)[inked] <= DARK) < DARK_SHARE:
        return False
    width = 2 * (max(3, int(WIDEST * np.sqrt(area))) // 2) + 1
    wide = ndimage.maximum_filter(ndimage.minimum_filter(inked, width), width)
    return bool(np.count_nonzero(wide) <= WIDE_SHARE * count)
