"""report.json: what was done to a picture, by which versions, and how it went."""

from __future__ import annotations

import json
import platform
from typing import Any

import numpy as np

from toonkit._validation import of_type, refuse
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.preparation import prepare
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.export.atomic import PathLike, atomic_write, suffix_of
from toonkit.model.image import ToonImage
from toonkit.model.light import light_angles
from toonkit.model.luminance import hex_color


def analysis_report(analysis: ToonAnalysis) -> dict[str, Any]:
    """
    Describe an analysis in values that JSON can hold.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.

    Returns
    -------
    dict
        "versions", "method", "light" (unit vector, degrees, its source and the confidence of its estimate), "picture"
        (pixels; share of the object that is ink), "materials" (share of the object, tones, color map of each) and "solver"
        (iterations, energies, why it stopped).

    Raises
    ------
    ToonkitError
        If the analysis is none.
    """
    of_type("analysis", analysis, ToonAnalysis)
    import toonkit  # noqa: PLC0415  # at call time, because the package's own __init__ stands above this module

    azimuth, elevation = light_angles(analysis.light)
    estimate = analysis.light_estimate
    height, width = analysis.image.shape
    return {
        "versions": {
            "toonkit": toonkit.__version__,
            "python": platform.python_version(),
            "numpy": np.__version__,
        },
        "method": analysis.method,
        "light": {
            "vector": np.asarray(analysis.light).tolist(),
            "azimuth_degrees": azimuth,
            "elevation_degrees": elevation,
            "source": analysis.light_source,
            "confidence": None if estimate is None else float(estimate.confidence),
        },
        "picture": {
            "width": width,
            "height": height,
            "mask_pixels": int(analysis.image.mask.sum()),
            "ink_share": ink_share(analysis.drawing),
        },
        "materials": _materials(analysis),
        "solver": {
            "iterations": int(analysis.report.iterations),
            "converged": bool(analysis.report.converged),
            "reason": analysis.report.reason,
            "energies": [float(energy) for energy in analysis.report.energies],
        },
    }


def _materials(analysis: ToonAnalysis) -> list[dict[str, Any]]:
    """Describe each material, in the order of the labels."""
    materials = analysis.materials
    return [
        {
            "share": float(share),
            "flat": bool(flat),
            "tones": [hex_color(shade) for shade in tones],
            "samples": len(color_map.colors),
            "domain": list(color_map.domain),
        }
        for share, flat, tones, color_map in zip(
            materials.shares, materials.flat, materials.tones, materials.color_maps, strict=True
        )
    ]


def ink_share(drawing: ToonImage | PreparedDrawing) -> float:
    """
    Return how much of a drawing is ink.

    Parameters
    ----------
    drawing : ToonImage or PreparedDrawing
        The drawing.

    Returns
    -------
    float
        Share of the object's area, 0 to 1.
    """
    prepared = prepare(drawing)
    return float(prepared.ink.coverage.sum() / prepared.grid.size)


def write_report(report: dict[str, Any], path: PathLike) -> None:
    """
    Write a report as JSON.

    Parameters
    ----------
    report : dict
        Of `analysis_report`, with whatever the caller adds.
    path : path
        Ends in .json.

    Raises
    ------
    ToonkitError
        If the report holds what JSON cannot, the suffix is another, or the file cannot be written.
    """
    suffix_of(path, (".json",))
    try:
        text = json.dumps(report, indent=2)
    except (RecursionError, TypeError, ValueError) as error:
        raise refuse("report", "must hold what JSON can", f"{error}") from error
    with atomic_write(path) as file:
        file.write(text.encode() + b"\n")
