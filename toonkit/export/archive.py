"""Archives: an analysis as one .npz file, free of pickle: colors exact to the last bit, normals to 0.01 degrees."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, FloatArray, ToonkitError, refuse
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.light_fit import LightEstimate
from toonkit.estimation.preparation import PreparedDrawing, prepare
from toonkit.export.atomic import PathLike, atomic_write, suffix_of
from toonkit.export.packing import pack_levels, pack_normals, unpack_levels, unpack_normals
from toonkit.model.color_map import ColorMap
from toonkit.model.image import ToonImage
from toonkit.model.materials import Materials
from toonkit.model.normals import NormalField
from toonkit.numerics.report import SolverReport

FORMAT_VERSION = 3
"""Raised whenever an older toonkit could misread a newer archive."""

UNPACKED_VERSION = 2
"""Archives of 64-bit numbers, which are still read."""

ONE_MATERIAL_VERSION = 1
"""Archives with one color map for the whole drawing, which are still read."""

# At higher levels of zlib, packed numbers take several times as long and hardly get smaller.
_COMPRESSION = 1

# What numpy raises for a file that is cut off, altered, a bare .npy array (no context manager) or pickled.
_DAMAGED = (OSError, ValueError, EOFError, TypeError, AttributeError, zipfile.BadZipFile, zlib.error)


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
        If the suffix is another or the file cannot be written.
    """
    suffix_of(path, (".npz",))
    image, report, estimate = analysis.image, analysis.report, analysis.light_estimate
    soft = np.flatnonzero(image.alpha != image.mask)
    inflated, initial = analysis.drawing.initial_normals.compact, analysis.initial_normals.compact
    fields: dict[str, NDArray[Any]] = {
        "format_version": np.array(FORMAT_VERSION),
        "method": np.array(analysis.method),
        "light": analysis.light,
        "mask": image.mask,
        "soft_places": soft.astype(np.int32),
        "soft_alpha": pack_levels(image.alpha.ravel()[soft]),
        # Nothing outside the mask is a number: only what is inside is stored, row by row.
        "color": pack_levels(image.color[image.mask]),
        "fringe": pack_levels(image.fringe_colors),
        "normals": pack_normals(analysis.normals.compact),
        **_material_fields(analysis),
        "light_confidence": np.array(np.nan if estimate is None else estimate.confidence),
        "report_iterations": np.array(report.iterations),
        "report_energies": np.asarray(report.energies),
        "report_reason": np.array(report.reason),
        "report_converged": np.array(report.converged),
    }
    if not np.array_equal(initial, inflated):  # which follow from mask and alpha
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
    file = Path(path).expanduser()
    if not file.is_file():
        raise refuse("path", "must be an archive of an analysis", f"{path}, which is not a file")
    if not zipfile.is_zipfile(file):  # else numpy takes it for a pickle, and advises to load that unsafely
        raise refuse(
            "path", "must be an undamaged archive of an analysis", f"{path}, which is damaged or none"
        )
    try:
        # Opened here, because numpy leaves a damaged file open.
        with file.open("rb") as opened, np.load(opened, allow_pickle=False) as archive:
            fields = dict(archive.items())
    except _DAMAGED as error:
        raise refuse("path", "must be an undamaged archive of an analysis", f"{path} ({error})") from error
    if "format_version" not in fields:
        raise refuse("path", "must be an archive of an analysis", f"{path}, which holds {sorted(fields)}")
    version = fields["format_version"]
    if version.shape != () or version not in (ONE_MATERIAL_VERSION, UNPACKED_VERSION, FORMAT_VERSION):
        rule = f"must be of version {FORMAT_VERSION} (written by this toonkit) or older"
        raise refuse("path", rule, f"{path} of version {version}")
    try:
        return _assemble(fields)
    except (KeyError, IndexError, TypeError, ToonkitError, ValueError) as error:
        raise refuse("path", "must be a complete archive of an analysis", f"{path} ({error})") from error


def _assemble(fields: dict[str, NDArray[Any]]) -> ToonAnalysis:
    if fields["format_version"] == FORMAT_VERSION:
        fields = _unpacked(fields)
    mask, alpha = fields["mask"], fields["alpha"]
    confidence = float(fields.get("light_confidence", np.array(np.nan)))
    image = ToonImage(
        _spread(fields["color"], mask),
        mask,
        alpha=alpha,
        fringe=_spread(fields["fringe"], (alpha > 0) & ~mask),
    )
    if fields["format_version"] == ONE_MATERIAL_VERSION:
        domain = tuple(fields["color_map_domain"].tolist())
        materials = Materials.single(mask, ColorMap(fields["color_map_colors"], domain))
    else:
        materials = _materials(fields, mask)
    drawing = _drawing(image, materials)
    initial = fields.get("initial_normals")
    return ToonAnalysis(
        image=image,
        method=str(fields["method"]),
        light=fields["light"],
        normals=NormalField(_spread(fields["normals"], mask), mask),
        initial_normals=(
            drawing.initial_normals if initial is None else NormalField(_spread(initial, mask), mask)
        ),
        materials=materials,
        report=SolverReport(
            iterations=int(fields["report_iterations"]),
            energies=fields["report_energies"],
            reason=str(fields["report_reason"]),
            converged=bool(fields["report_converged"]),
        ),
        light_estimate=None if np.isnan(confidence) else LightEstimate(fields["light"], confidence),
        drawing=drawing,
    )


def _unpacked(fields: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return the fields of an archive with the numbers of older ones; N0 may be missing."""
    alpha = fields["mask"].astype(np.float64)
    alpha.ravel()[fields["soft_places"]] = unpack_levels(fields["soft_alpha"])
    unpacked = {name: unpack_levels(fields[name]) for name in ("color", "fringe")}
    for name in {"normals", "initial_normals"} & fields.keys():
        unpacked[name] = unpack_normals(fields[name])
    return {**fields, **unpacked, "alpha": alpha}


def _drawing(image: ToonImage, materials: Materials) -> PreparedDrawing:
    """Prepare a drawing again. Materials that toonkit finds are not given, or it would unmix what is beside ink anew."""
    drawing = prepare(image)
    found = np.array_equal(drawing.materials.labels, materials.labels)
    return drawing if found else prepare(image, materials=materials.labels)


def _material_fields(analysis: ToonAnalysis) -> dict[str, NDArray[Any]]:
    materials = analysis.materials
    return {
        "material_labels": materials.labels[analysis.image.mask].astype(np.min_scalar_type(-materials.count)),
        "material_flat": materials.flat,
        "material_tones": np.concatenate(materials.tones),
        "material_tone_counts": np.array([len(tones) for tones in materials.tones]),
        "color_map_colors": np.concatenate([color_map.colors for color_map in materials.color_maps]),
        "color_map_counts": np.array([len(color_map.colors) for color_map in materials.color_maps]),
        "color_map_domains": np.array([color_map.domain for color_map in materials.color_maps]),
    }


def _materials(fields: dict[str, NDArray[Any]], mask: BoolArray) -> Materials:
    inside, flat = fields["material_labels"], fields["material_flat"]
    if inside.shape != (int(mask.sum()),) or inside.dtype.kind != "i":
        raise ValueError("its material labels are not one integer for each pixel of the object")
    if flat.ndim != 1 or flat.dtype != np.bool_:
        raise ValueError("it does not say which materials are flat")
    if inside.min() < 0 or inside.max() >= len(flat):
        raise ValueError(f"its material labels are not numbers from 0 to {len(flat) - 1}")
    labels = np.full(mask.shape, -1, np.intp)
    labels[mask] = inside
    tones = _split(fields["material_tones"], fields["material_tone_counts"], len(flat))
    colors = _split(fields["color_map_colors"], fields["color_map_counts"], len(flat))
    domains = fields["color_map_domains"].tolist()
    return Materials(
        labels,
        tuple(tones),
        flat,
        tuple(ColorMap(samples, tuple(domain)) for samples, domain in zip(colors, domains, strict=True)),
    )


def _split(colors: NDArray[Any], counts: NDArray[Any], materials: int) -> list[NDArray[Any]]:
    """Cut colors (n, 3) into those of each material."""
    fits = counts.shape == (materials,) and counts.dtype.kind == "i" and (counts > 0).all()
    if not fits or colors.shape != (counts.sum(), 3):
        raise ValueError("its colors are not those of its materials")
    return np.split(colors, np.cumsum(counts)[:-1])


def _spread(values: FloatArray, where: BoolArray) -> FloatArray:
    """Put (P, 3) values back into a (H, W, 3) field, NaN elsewhere."""
    field = np.full((*where.shape, 3), np.nan)
    field[where] = values
    return field
