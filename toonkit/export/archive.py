"""Archives: an analysis as one .npz file, free of pickle: colors exact to the last bit, normals to 0.01 degrees."""

from __future__ import annotations

import zipfile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import (
    BoolArray,
    FloatArray,
    ToonkitError,
    as_mask,
    as_path,
    expand_home,
    of_type,
    refuse,
)
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.light_fit import LightEstimate
from toonkit.estimation.packing import pack_levels, pack_normals, unpack_levels, unpack_normals
from toonkit.estimation.preparation import prepare
from toonkit.estimation.prepared_drawing import MOST_PIXELS, PreparedDrawing
from toonkit.export.atomic import PathLike, atomic_write, suffix_of
from toonkit.export.npz import Arrays
from toonkit.export.shape_arrays import pack_shape, read_shape
from toonkit.model.color_map import ColorMap
from toonkit.model.decoding import MAX_PIXELS
from toonkit.model.image import ToonImage
from toonkit.model.materials import Materials
from toonkit.model.normals import NormalField
from toonkit.numerics.report import SolverReport

FORMAT_VERSION = 4
"""Raised whenever an older toonkit could misread a newer archive."""

PACKED_VERSION = 3
"""The first version of archives with packed numbers."""

UNPACKED_VERSION = 2
"""Archives of 64-bit numbers, which are still read."""

ONE_MATERIAL_VERSION = 1
"""Archives with one color map for the whole drawing, which are still read."""

MOST_COLORS = 1 << 22
"""Tones, or samples of color maps, of all materials together at most, where they are not four for each pixel."""

MOST_ENERGIES, MOST_CHARACTERS = 1_000_000, 10_000
"""Energies in a report, and characters in a text, at most."""

GIVEN = ("ink", "highlights")
"""What somebody may have told of the drawing, as arrays of bools, one for each pixel of the object."""

DRAWN = "drawn_"
"""What the names of arrays begin with that describe the materials as drawn, where they are recolored."""

MOST_NAMES = 8
"""How many arrays a message names."""

# At higher levels of zlib, packed numbers take several times as long and hardly get smaller.
_COMPRESSION = 1


def save_analysis(analysis: ToonAnalysis, path: PathLike) -> None:
    """
    Write an analysis to one file.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    path : path
        Ends in .npz. An older file is replaced once the new one is complete.

    Raises
    ------
    ToonkitError
        If the analysis is none, the suffix is another or the file cannot be written.
    """
    of_type("analysis", analysis, ToonAnalysis)
    suffix_of(path, (".npz",))
    image, report, estimate = analysis.image, analysis.report, analysis.light_estimate
    soft = np.flatnonzero(image.alpha != image.mask)
    known, initial = analysis.drawing.initial_normals.compact, analysis.initial_normals.compact
    fields: dict[str, NDArray[Any]] = {
        "format_version": np.array(FORMAT_VERSION),
        "method": np.array(analysis.method),
        "light": analysis.light,
        "mask": image.mask,
        "soft_places": soft.astype(np.int32),
        "soft_alpha": pack_levels(image.alpha.ravel()[soft]),
        # Nothing outside the mask is a number: only what is inside is stored, row by row.
        "color": pack_levels(image.pixels),
        "fringe": pack_levels(image.fringe_colors),
        "normals": pack_normals(analysis.normals.compact),
        "material_labels": analysis.materials.labels[image.mask].astype(
            np.min_scalar_type(-analysis.materials.count)
        ),
        **_material_fields(analysis.materials, ""),
        "light_confidence": np.array(np.nan if estimate is None else estimate.confidence),
        "report_iterations": np.array(report.iterations),
        "report_energies": np.asarray(report.energies),
        "report_reason": np.array(report.reason),
        "report_converged": np.array(report.converged),
    }
    if analysis.drawing.views > 1:
        fields["views"] = np.array(analysis.drawing.views)
    for name in GIVEN:
        given = getattr(analysis.drawing, f"given_{name}")
        if given is not None:
            fields[name] = given[image.mask]
    fields |= pack_shape(analysis.drawing.given_shape, image.mask)
    if analysis.drawn_materials is not None:
        fields |= _material_fields(analysis.drawn_materials, DRAWN)
    if not np.array_equal(initial, known):  # which follow from mask, alpha and the corrections of the shape
        fields["initial_normals"] = pack_normals(initial)
    with (
        atomic_write(path) as file,
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=_COMPRESSION) as archive,
    ):
        for name, values in fields.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, np.asarray(values, order="C"), allow_pickle=False)


def load_analysis(path: PathLike) -> ToonAnalysis:
    """
    Read an analysis written by `save_analysis`.

    Parameters
    ----------
    path : path
        The .npz file. Nothing in it is executed: a file from a stranger is safe to open.

    Returns
    -------
    ToonAnalysis
        Equal to the one saved, but for its normals, which may be turned by up to 0.01 degrees.

    Raises
    ------
    ToonkitError
        If the file is missing, damaged, no archive of an analysis, or of another version.
    """
    file = expand_home(as_path("path", path))
    if not file.is_file():
        raise refuse("path", "must be an archive of an analysis", f"{path}, which is not a file")
    try:
        with file.open("rb") as opened:
            arrays = Arrays(opened)
            version = _version(arrays, path)
            try:
                return _assemble(arrays, version)
            except ToonkitError as error:
                raise refuse(
                    "path", "must be a complete archive of an analysis", f"{path} ({error})"
                ) from error
    except (MemoryError, ToonkitError):
        raise
    except Exception as error:  # zipfile and zlib raise nearly every type there is for a damaged file
        raise refuse("path", "must be an undamaged archive of an analysis", f"{path} ({error})") from error


def _version(arrays: Arrays, path: PathLike) -> int:
    if "format_version" not in arrays.names:
        held = ", ".join(arrays.names[:MOST_NAMES]) or "nothing"
        raise refuse("path", "must be an archive of an analysis", f"{path}, which holds {held}")
    rule = f"must be of version {FORMAT_VERSION} (written by this toonkit) or older"
    try:
        version = int(arrays.read("format_version", "i"))
    except ToonkitError as error:
        raise refuse("path", rule, f"{path} ({error})") from error
    if version not in (ONE_MATERIAL_VERSION, UNPACKED_VERSION, PACKED_VERSION, FORMAT_VERSION):
        raise refuse("path", rule, f"{path} of version {version}")
    return version


def _assemble(arrays: Arrays, version: int) -> ToonAnalysis:
    """Read one array after the other: the mask says how large the others are."""
    mask = as_mask("mask", arrays.read("mask", "b", None, None, most=MAX_PIXELS))
    pixels = int(mask.sum())
    if pixels > MOST_PIXELS:
        raise refuse("mask", f"must have at most {MOST_PIXELS:,} object pixels", f"{pixels:,}")
    alpha = _soft_alpha(arrays, mask) if version >= PACKED_VERSION else arrays.read("alpha", "f", *mask.shape)
    touched = (alpha > 0) & ~mask
    image = ToonImage(
        _spread(_levels(arrays, "color", pixels, 3), mask),
        mask,
        alpha=alpha,
        fringe=_spread(_levels(arrays, "fringe", int(touched.sum()), 3), touched),
    )
    drawn = None
    if version == ONE_MATERIAL_VERSION:
        materials = Materials.single(mask, _only_color_map(arrays))
    else:
        labels = _labels(arrays, mask)
        materials = _materials(arrays, labels, "")
        if f"{DRAWN}material_flat" in arrays.names:
            drawn = _materials(arrays, labels, DRAWN)
    light = arrays.read("light", "f", 3)
    confidence = float(arrays.read("light_confidence", "f")) if "light_confidence" in arrays.names else np.nan
    method = str(arrays.read("method", "U", most=MOST_CHARACTERS))
    normals, report = _normals(arrays, "normals", mask, version), _report(arrays)
    initial = None
    if version < PACKED_VERSION or "initial_normals" in arrays.names:
        initial = _normals(arrays, "initial_normals", mask, version)
    views = int(arrays.read("views", "i")) if "views" in arrays.names else 1
    if not 1 <= views <= pixels:
        raise refuse("views", f"must be a number from 1 to {pixels:,}", views)
    known = prepare(image, views=views, **_given(arrays, mask), shape=read_shape(arrays, mask))
    drawing = _drawing(known, materials)
    return ToonAnalysis(
        image=image,
        method=method,
        light=light,
        normals=normals,
        initial_normals=drawing.initial_normals if initial is None else initial,
        materials=materials,
        report=report,
        light_estimate=None if np.isnan(confidence) else LightEstimate(light, confidence),
        drawing=drawing,
        drawn_materials=drawn,
    )


def _soft_alpha(arrays: Arrays, mask: BoolArray) -> FloatArray:
    """Read the coverage of the pixels that the object covers in part; the others are in it or not, as the mask says."""
    places = arrays.read("soft_places", "i", None, most=mask.size)
    if places.size and not (places[0] >= 0 and places[-1] < mask.size and (places[1:] > places[:-1]).all()):
        raise refuse("soft_places", f"must ascend from 0 to {mask.size - 1:,} at most", "others")
    alpha = mask.astype(np.float64)
    alpha.ravel()[places] = _levels(arrays, "soft_alpha", len(places))
    return alpha


def _levels(arrays: Arrays, name: str, *shape: int) -> FloatArray:
    """Read numbers from 0 to 1 that may be packed."""
    return unpack_levels(arrays.read(name, "uf", *shape))


def _normals(arrays: Arrays, name: str, mask: BoolArray, version: int) -> NormalField:
    pixels = int(mask.sum())
    if version < PACKED_VERSION:
        return NormalField(_spread(arrays.read(name, "f", pixels, 3), mask), mask)
    packed = arrays.read(name, "u", pixels, 2)
    if packed.dtype != np.uint16:
        raise refuse(name, "must have 16 bits a number", f"{packed.dtype}")
    return NormalField(_spread(unpack_normals(packed), mask), mask)


def _report(arrays: Arrays) -> SolverReport:
    iterations = int(arrays.read("report_iterations", "i"))
    energies = arrays.read("report_energies", "f", None, most=MOST_ENERGIES)
    if iterations < 0:
        raise refuse("report_iterations", "must be a number >= 0", iterations)
    if not np.isfinite(energies).all():
        raise refuse("report_energies", "must be finite", "NaN or infinite values")
    return SolverReport(
        iterations=iterations,
        energies=energies,
        reason=str(arrays.read("report_reason", "U", most=MOST_CHARACTERS)),
        converged=bool(arrays.read("report_converged", "b")),
    )


def _given(arrays: Arrays, mask: BoolArray) -> dict[str, BoolArray]:
    """Read the ink and the highlights that were given."""
    given = {}
    for name in set(GIVEN).intersection(arrays.names):
        given[name] = np.zeros(mask.shape, np.bool_)
        given[name][mask] = arrays.read(name, "b", int(mask.sum()))
    return given


def _drawing(drawing: PreparedDrawing, materials: Materials) -> PreparedDrawing:
    """Prepare a drawing again. Materials that toonkit finds are not given, or it would unmix what is beside ink anew."""
    if not np.array_equal(drawing.materials.labels, materials.labels):
        drawing = prepare(drawing, materials=materials.labels)
    if drawing.materials.count != materials.count:
        raise refuse(
            "material_labels", f"must be those of {materials.count} materials", drawing.materials.count
        )
    return drawing


def _material_fields(materials: Materials, prefix: str) -> dict[str, NDArray[Any]]:
    fields = {
        "material_flat": materials.flat,
        "material_tones": np.concatenate(materials.tones),
        "material_tone_counts": np.array([len(tones) for tones in materials.tones]),
        "color_map_colors": np.concatenate([color_map.colors for color_map in materials.color_maps]),
        "color_map_counts": np.array([len(color_map.colors) for color_map in materials.color_maps]),
        "color_map_domains": np.array([color_map.domain for color_map in materials.color_maps]),
    }
    return {prefix + name: values for name, values in fields.items()}


def _only_color_map(arrays: Arrays) -> ColorMap:
    low, high = arrays.read("color_map_domain", "f", 2).tolist()
    return ColorMap(arrays.read("color_map_colors", "f", None, 3, most=3 * MOST_COLORS), (low, high))


def _labels(arrays: Arrays, mask: BoolArray) -> NDArray[np.int32]:
    labels = np.full(mask.shape, -1, np.int32)
    labels[mask] = arrays.read("material_labels", "i", int(mask.sum()))
    if labels[mask].min() < 0:
        raise refuse("material_labels", "must be known on the object", "negative numbers")
    return labels


def _materials(arrays: Arrays, labels: NDArray[np.int32], prefix: str) -> Materials:
    pixels = int((labels >= 0).sum())
    flat = arrays.read(f"{prefix}material_flat", "b", None, most=pixels)
    count = len(flat)
    most = max(MOST_COLORS, 4 * pixels)
    tones, colors = (
        _split(arrays, prefix + name, arrays.read(f"{prefix}{counts}", "i", count), most)
        for name, counts in (
            ("material_tones", "material_tone_counts"),
            ("color_map_colors", "color_map_counts"),
        )
    )
    domains = arrays.read(f"{prefix}color_map_domains", "f", count, 2).tolist()
    return Materials(
        labels,
        tuple(tones),
        flat,
        tuple(ColorMap(samples, (low, high)) for samples, (low, high) in zip(colors, domains, strict=True)),
    )


def _split(arrays: Arrays, name: str, counts: NDArray[Any], most: int) -> list[NDArray[Any]]:
    """Read colors (n, 3), and cut them into those of each material."""
    if counts.size and (counts.min() < 1 or counts.max() > most):
        raise refuse(
            name, f"must be 1 to {most:,} for each material", f"{counts.min():,} to {counts.max():,}"
        )
    total = int(counts.sum(dtype=np.int64))
    if total > most:
        raise refuse(name, f"must be at most {most:,}", f"{total:,}")
    return np.split(arrays.read(name, "f", total, 3), np.cumsum(counts)[:-1])


def _spread(values: FloatArray, where: BoolArray) -> FloatArray:
    """Put (P, 3) values back into a (H, W, 3) field, NaN elsewhere."""
    field = np.full((*where.shape, 3), np.nan)
    field[where] = values
    return field
