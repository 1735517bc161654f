"""Colors as files declare them (ICC profile, transfer and primaries) brought to sRGB."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import ImageCms

from toonkit._validation import FloatArray, warn
from toonkit.model.luminance import linear_to_srgb, srgb_to_linear

Chromaticities = tuple[float, float, float, float, float, float, float, float]
"""CIE x and y of white, red, green and blue."""

SRGB = (0.3127, 0.3290, 0.64, 0.33, 0.30, 0.60, 0.15, 0.06)
DISPLAY_P3 = (0.3127, 0.3290, 0.680, 0.320, 0.265, 0.690, 0.150, 0.060)
REC2020 = (0.3127, 0.3290, 0.708, 0.292, 0.170, 0.797, 0.131, 0.046)

_BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
_ALIKE = 1.5 / 255  # colors that differ by less are the same 8-bit color but for rounding
_SAME_MATRIX = 0.01  # primaries written with two decimals differ by as much
_STEPS = np.linspace(0.0, 1.0, 5)


@dataclass(frozen=True)
class ColorSpace:
    """
    What a file says its samples mean.

    Attributes
    ----------
    profile : bytes or None
        ICC profile. If there is one, exponent and primaries do not count.
    exponent : float or None
        Linear light is the sample to this power; None is the sRGB curve.
    primaries : tuple of float
        Chromaticities of white, red, green and blue.
    remark : str
        What a warning should say about them: what the file says that toonkit cannot apply, or leaves open.
    """

    profile: bytes | None = None
    exponent: float | None = None
    primaries: Chromaticities = SRGB
    remark: str = ""


def to_srgb(argument: str, samples: NDArray[Any], space: ColorSpace) -> NDArray[Any]:
    """
    Convert samples (H, W, 1..4), of uint8, uint16 or floats in [0, 1], to sRGB; two and four channels end in alpha.

    They are returned as they are if they are sRGB, or if what the file says cannot be applied, which a warning tells.
    """
    if space.remark:
        warn(argument, space.remark)
    if space.profile:
        return _by_profile(argument, samples, space.profile)
    try:
        matrix = _to_srgb_primaries(space.primaries)
    except ValueError:
        warn(argument, "its primaries span no colors and are ignored")
        matrix = np.eye(3)
    others = samples.shape[-1] >= 3 and bool(np.abs(matrix - np.eye(3)).max() >= _SAME_MATRIX)
    if space.exponent is None and not others:
        return samples
    return _by_formula(samples, space.exponent, matrix if others else None)


def _by_formula(samples: NDArray[Any], exponent: float | None, matrix: FloatArray | None) -> FloatArray:
    scale = 1.0 if samples.dtype.kind in "fb" else float(np.iinfo(samples.dtype).max)
    result = samples.astype(np.float64)
    result /= scale
    color = result[..., : 1 if samples.shape[-1] < 3 else 3]
    light = srgb_to_linear(color) if exponent is None else np.power(color, exponent)
    if matrix is not None:
        light = np.einsum("ij,hwj->hwi", matrix, light)
    color[...] = np.clip(linear_to_srgb(light), 0.0, 1.0)
    return result


def _to_srgb_primaries(primaries: Chromaticities) -> FloatArray:
    """Matrix (3, 3) from linear light in some primaries to linear sRGB, white to white."""
    source, target = _to_xyz(primaries), _to_xyz(SRGB)
    white, wanted = _BRADFORD @ source.sum(axis=1), _BRADFORD @ target.sum(axis=1)
    if not white.min() > 0:
        raise ValueError("white is no light")
    adapted = np.linalg.solve(_BRADFORD, (wanted / white)[:, None] * _BRADFORD)
    return np.asarray(np.linalg.solve(target, adapted @ source), dtype=np.float64)


def _to_xyz(primaries: Chromaticities) -> FloatArray:
    """Matrix (3, 3) from linear light in some primaries to CIE XYZ, where white has Y = 1."""
    x, y = np.array(primaries[::2]), np.array(primaries[1::2])
    corners = np.stack([x, y, 1 - x - y])
    area = abs(float(np.linalg.det(corners[:, 1:])))
    if not (area > 1e-3 and y[0] > 1e-3):
        raise ValueError("the primaries lie on a line")
    scale = np.linalg.solve(corners[:, 1:], corners[:, 0] / y[0])
    return corners[:, 1:] * scale


def _by_profile(argument: str, samples: NDArray[Any], profile: bytes) -> NDArray[Any]:
    colors = 1 if samples.shape[-1] < 3 else 3
    try:
        known = ImageCms.ImageCmsProfile(io.BytesIO(profile)).profile.xcolor_space.strip()
        if known == "RGB" and colors == 1:  # common, although no standard allows it
            samples, colors = np.repeat(samples, (3, 1)[: samples.shape[-1]], axis=-1), 3
        if known != ("GRAY" if colors == 1 else "RGB"):
            warn(argument, f"its {known} profile does not fit the picture and is ignored")
            return samples
        probe = np.stack(np.meshgrid(*[_STEPS] * colors, indexing="ij"), axis=-1).reshape(1, -1, colors)
        if np.abs(_transform(probe, profile) - probe).max() < _ALIKE:
            return samples
        converted = _transform(samples[..., :colors], profile)
    except (ImageCms.PyCMSError, OSError, RuntimeError, ValueError):
        warn(argument, "its color profile is damaged and is ignored, the colors are read as sRGB")
        return samples
    return np.concatenate([converted, samples[..., colors:]], axis=-1)


def _transform(color: NDArray[Any], profile: bytes) -> NDArray[Any]:
    """Convert (H, W, 1 or 3) samples to sRGB (H, W, 3) without leaving their precision."""
    import imagecodecs  # noqa: PLC0415  # its compiled codecs load slowly; it converts 16 bits, Pillow does not

    floats = color.dtype.kind == "f"
    given = np.round(color * 65535).astype(np.uint16) if floats else np.ascontiguousarray(color)
    converted: NDArray[Any] = imagecodecs.cms_transform(
        given[..., 0] if color.shape[-1] == 1 else given,
        profile,
        ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes(),
        colorspace="gray" if color.shape[-1] == 1 else "rgb",
        outcolorspace="rgb",
        outdtype=given.dtype,
    )
    return converted / np.float64(65535) if floats else converted
