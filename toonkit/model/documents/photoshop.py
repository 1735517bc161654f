"""Photoshop documents (.psd and .psb), read by psd-tools."""

from __future__ import annotations

import io
import struct
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import ToonkitError, refuse
from toonkit.model.color_space import ColorSpace, to_srgb
from toonkit.model.decoding import MAX_PIXELS, Pixels, check_size, unit_range
from toonkit.model.documents.document import Document, Layer, LayerPixels, on_canvas

SIGNATURE = b"8BPS"

MOST_BYTES = 96 * MAX_PIXELS
"""Memory that psd-tools may use to decode one picture, at most."""

_HEADER = struct.Struct(">4sH6xHIIHH")
_MODES = {1: "grayscale", 3: "RGB"}
_ADVICE = "(Photoshop: Image > Mode)"


def open_photoshop(argument: str, data: bytes, name: str) -> Document:
    """
    Open a Photoshop document: its layers of pixels, without adjustments and the like.

    Raises `ToonkitError` if it is damaged, too large, neither RGB nor grayscale of 8 or 16 bits, or if psd-tools is
    missing.
    """
    if len(data) < _HEADER.size:
        raise refuse(argument, "must be a complete Photoshop document", name)
    _, _, _, height, width, bits, mode = _HEADER.unpack_from(data)
    check_size(argument, width, height)
    if mode not in _MODES or bits not in (8, 16):
        rule = f"must be RGB or grayscale of 8 or 16 bits, if it is a Photoshop document {_ADVICE}"
        raise refuse(argument, rule, f"{name} of {bits} bits, mode {mode}")
    try:
        from psd_tools import PSDImage  # noqa: PLC0415  # slow to load, and needed for this alone
    except ImportError as error:
        rule = "may be a Photoshop document only where psd-tools is installed: pip install psd-tools"
        raise refuse(argument, rule, f"{error}") from error
    with _told(argument, name):
        document = PSDImage.open(io.BytesIO(data), max_alloc_bytes=MOST_BYTES)
        layers = tuple(_layers(document, (), (argument, name), (height, width)))
    return Document(name, layers, partial(_read_merged, document, argument, name))


def _read_merged(document: Any, argument: str, name: str) -> Pixels:
    from psd_tools.api.utils import get_transparency_index, has_transparency  # noqa: PLC0415
    from psd_tools.constants import Resource  # noqa: PLC0415

    if not document.has_preview():
        rule = (
            "must hold its merged picture (Photoshop: Preferences > File Handling > Maximize Compatibility)"
        )
        raise refuse(argument, rule, f"{name} without it")
    with _told(argument, name):
        planes = document.numpy()
        colors = 3 if document.pil_mode.startswith("RGB") else 1
        alpha = planes[..., get_transparency_index(document)] if has_transparency(document) else None
        profile = document.image_resources.get_data(Resource.ICC_PROFILE)
    levels = 255 if document.depth == 8 else 65535
    samples = np.rint(np.clip(planes[..., :colors], 0, 1) * levels)
    samples = samples.astype(np.uint8 if levels == 255 else np.uint16)
    color = unit_range(argument, to_srgb(argument, samples, ColorSpace(profile)))
    if color.shape[-1] == 1:
        color = np.repeat(color, 3, axis=-1)
    return Pixels(color, None if alpha is None else np.rint(alpha * np.float64(levels)) / levels)


def _layers(
    layers: Iterable[Any],
    groups: tuple[str, ...],
    told: tuple[str, str],
    shape: tuple[int, int],
    opacity: float = 1.0,
) -> Iterator[Layer]:
    """Yield the layers of pixels, from the bottom to the top."""
    blends: dict[bytes, Any] = {b"norm": "normal", b"mul ": "multiply"}
    for layer in layers:
        own = opacity * layer.opacity / 255
        if layer.is_group():
            yield from _layers(layer, (layer.name, *groups), told, shape, own)
        elif layer.has_pixels() and layer.width and layer.height:
            yield Layer(
                layer.name,
                groups,
                layer.width * layer.height,
                _reader(layer, told, shape),
                blends.get(layer.blend_mode.value, "other"),
                layer.is_visible(),
                own,
                bool(layer.clipping),
            )


def _reader(layer: Any, told: tuple[str, str], shape: tuple[int, int]) -> Callable[[], LayerPixels]:
    def read() -> LayerPixels:
        check_size(told[0], layer.width, layer.height, min_side=1)
        with _told(*told):
            bands = [_band(layer, number) for number in range(3)]
            gray = bands[0] if bands[0] is not None else np.zeros((layer.height, layer.width), np.uint8)
            alpha = _band(layer, -1)
            pixels = np.dstack(
                [
                    *(gray if band is None else band for band in bands),
                    np.full_like(gray, 255) if alpha is None else alpha,
                ]
            )
            canvas = on_canvas(pixels, layer.top, layer.left, shape)
            if layer.has_mask() and not layer.mask.disabled:
                canvas[..., 3] = np.rint(canvas[..., 3] * (_mask(layer, shape) / 255))
        return canvas

    return read


def _band(layer: Any, number: int) -> NDArray[np.uint8] | None:
    """Return one channel of a layer, None if it has none of that number; -1 is its alpha."""
    if number not in [info.id for info in layer._record.channel_info]:
        return None
    band = layer.topil(number)
    return None if band is None else np.array(band.convert("L"))


def _mask(layer: Any, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Return the mask of a layer on the canvas, 0 to 255."""
    mask = layer.mask
    whole = np.full(shape, float(mask.background_color))
    band = mask.topil()
    if band is not None:
        values = np.asarray(band.convert("L"))
        placed = on_canvas(
            np.dstack([values, values, values, np.full_like(values, 255)]), mask.top, mask.left, shape
        )
        whole = np.where(placed[..., 3] > 0, placed[..., 0], whole)
    return whole


@contextmanager
def _told(argument: str, name: str) -> Iterator[None]:
    """Refuse a document that psd-tools cannot read, and what it would replace by black."""
    from psd_tools.compression import PSDDecompressionWarning  # noqa: PLC0415

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", PSDDecompressionWarning)
            yield
    except (MemoryError, ToonkitError):
        raise
    except Exception as error:  # psd-tools raises nearly every type there is for a damaged document
        shown = " ".join(f"{error}".split())
        raise refuse(argument, "must be an undamaged Photoshop document", f"{name} ({shown})") from error
