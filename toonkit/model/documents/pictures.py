"""PNG and WebP files as layers."""

from __future__ import annotations

import io
import warnings

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from toonkit._validation import ToonkitError, refuse
from toonkit.model.decoding import check_size


def picture_size(argument: str, data: bytes, name: str) -> tuple[int, int]:
    """Return height and width of a picture file from its header."""
    with _opened(argument, data, name) as picture:
        return picture.height, picture.width


def read_layer_picture(argument: str, data: bytes, name: str) -> NDArray[np.uint8]:
    """Decode a picture file to 8-bit RGBA, shape (h, w, 4)."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with _opened(argument, data, name) as picture:
                if picture.mode.startswith("I"):  # 16-bit gray, which Pillow would clip
                    gray = (np.asarray(picture).astype(np.uint32) >> 8).astype(np.uint8)
                    return np.dstack([gray, gray, gray, np.full_like(gray, 255)])
                return np.asarray(picture.convert("RGBA"))
    except (MemoryError, ToonkitError):
        raise
    except Exception as error:  # decoders raise nearly every type there is for a damaged file
        raise refuse(argument, "must have undamaged layers", f"{name} ({error})") from error


def _opened(argument: str, data: bytes, name: str) -> Image.Image:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # sizes are checked here
            picture = Image.open(io.BytesIO(data), formats=("PNG", "WEBP"))
    except Image.DecompressionBombError as error:
        raise refuse(argument, "must have layers of reasonable size", f"{name} ({error})") from error
    except Exception as error:
        raise refuse(argument, "must have layers in PNG or WebP", f"{name} ({error})") from error
    check_size(argument, picture.width, picture.height, min_side=1)
    return picture
