"""
Sessions as files: an archive of the analysis on screen, with the visitor's corrections and settings beside it.

A session is an archive that `toonkit.load_analysis` reads as any other; what it has more are arrays whose names begin with
`session_`. A plain archive is read as a session without corrections.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

import toonkit
from toonkit import ToneRamp, ToonAnalysis
from toonkit._validation import BoolArray, refuse
from toonkit.export.npz import Arrays
from toonkit.viz.relight_page.codes import Numbers, materials_of, numbers_in
from toonkit.viz.relight_page.corrections import MaterialCorrections
from toonkit.viz.relight_page.settings import RelightSettings
from toonkit.viz.relight_page.shape_marks import ShapeMarks

SUFFIX = ".toonkit"

SESSION_VERSION = 1
"""Raised whenever an older toonkit could misread a newer session."""

MOST_CHARACTERS = 1_000_000
"""Of the settings and ramps, at most."""

VERSION, SETTINGS, CODES, FOUND = (f"session_{name}" for name in ("version", "settings", "codes", "found"))
FOUND_MARKS = {name: f"session_found_{name}" for name in ("ink", "highlights")}
GIVEN = {name: f"session_given_{name}" for name in ("materials", "ink", "highlights")}
"""Names of the arrays that a session has beside those of its analysis."""

_ZIP, _MIMETYPE = b"PK\x03\x04", b"mimetype"
_NAME_AT = 30
"""Where the name of the first file in a zip archive stands; in OpenRaster and Krita files that tells the type."""


@dataclass(frozen=True, eq=False)
class Given:
    """What is known of a drawing before it is analyzed: as of `toonkit.analyze`, shape (H, W) each, or None."""

    materials: NDArray[np.integer] | None = None
    ink: BoolArray | None = None
    highlights: BoolArray | None = None


@dataclass(frozen=True, eq=False)
class SavedWork:
    """
    What a session holds.

    Attributes
    ----------
    analysis : ToonAnalysis
        The drawing as analyzed with the corrected materials, with the color maps that it is drawn with.
    corrections : MaterialCorrections
        Its materials as found and as corrected, and the edited ramps.
    given : Given
        What was known of the drawing before.
    settings : dict
        Values of `RelightSettings` by name; not all need be there.
    ramps : dict of int to ToneRamp
        The edited ramps at that time, by the number of their material; `corrections` go on.
    selected : int
        Number of the material that is being looked at, -1 for none.
    """

    analysis: ToonAnalysis
    corrections: MaterialCorrections
    given: Given
    settings: Mapping[str, Any]
    ramps: Mapping[int, ToneRamp]
    selected: int = -1


def is_saved_work(content: bytes) -> bool:
    """Tell whether the content of a file can be a session or an archive of an analysis, and no layered document."""
    return content.startswith(_ZIP) and not content.startswith(_MIMETYPE, _NAME_AT)


def write_session(work: SavedWork, recolored: ToonAnalysis) -> bytes:
    """
    Return the content of a session's file.

    Parameters
    ----------
    work : SavedWork
        What it is to hold.
    recolored : ToonAnalysis
        The same analysis with the edited ramps, for whoever reads the file as an archive.
    """
    mask, corrections, given = recolored.image.mask, work.corrections, work.given
    described = {
        "settings": dict(work.settings),
        "selected": work.selected,
        "ramps": {str(number): asdict(ramp) for number, ramp in work.ramps.items()},
    }
    fields: dict[str, NDArray[Any]] = {
        VERSION: np.array(SESSION_VERSION),
        SETTINGS: np.array(json.dumps(described)),
        CODES: corrections.codes[mask],
        FOUND: corrections.codes_of(None)[mask],
        FOUND_MARKS["ink"]: corrections.found_ink[mask],
        FOUND_MARKS["highlights"]: corrections.found_highlights[mask],
    }
    for name, array in GIVEN.items():
        values = getattr(given, name)
        if values is not None:
            fields[array] = values[mask]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "analysis.npz"
        recolored.save(path)
        with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            for name, values in fields.items():
                with archive.open(f"{name}.npy", "w") as entry:
                    np.lib.format.write_array(entry, np.asarray(values, order="C"), allow_pickle=False)
        return path.read_bytes()


def read_saved_work(content: bytes, name: str) -> SavedWork:
    """
    Read a session, or an archive of an analysis.

    Parameters
    ----------
    content : bytes
        Content of the file. Nothing in it is executed.
    name : str
        Name of the file, for messages.

    Raises
    ------
    ToonkitError
        If it is damaged, something else, or from a newer toonkit.
    """
    with TemporaryDirectory() as folder:
        path = Path(folder) / "saved"
        path.write_bytes(content)
        try:
            analysis = toonkit.load_analysis(path)
            arrays = Arrays(BytesIO(content))
            return _session(arrays, analysis) if VERSION in arrays.names else _plain(analysis)
        except MemoryError:
            raise
        # For a damaged file, zipfile, zlib, json and param raise nearly every type there is.
        except Exception as error:
            reason = str(error).replace(str(path), name)
            raise refuse(
                "source",
                "must be a session or an analysis as toonkit has saved it: save it again, or open the drawing itself",
                f"{name} ({reason})",
            ) from error


def _plain(analysis: ToonAnalysis) -> SavedWork:
    drawing, drawn = analysis.drawing, analysis.recolored({})
    labels = analysis.materials.labels
    corrections = MaterialCorrections.of(analysis)
    for number in np.flatnonzero(analysis.is_recolored):
        ramp = ToneRamp.of(analysis.materials.color_maps[number])
        corrections.recolor(int(number), ramp)
    corrections.change_shape(ShapeMarks.of(drawing.given_shape))
    given = Given(labels, drawing.given_ink, drawing.given_highlights)
    return SavedWork(drawn, corrections, given, {}, corrections.ramps)


def _session(arrays: Arrays, analysis: ToonAnalysis) -> SavedWork:
    version = int(arrays.read(VERSION, "i"))
    if version != SESSION_VERSION:
        raise refuse(
            "it", f"must be of version {SESSION_VERSION}; use the toonkit that has saved it", version
        )
    mask = analysis.image.mask
    pixels = int(mask.sum())

    def numbers(name: str, least: int = 0) -> Numbers:
        field, values = np.full(mask.shape, -1, np.int16), arrays.read(name, "i", pixels)
        if values.min() < least or values.max() > np.iinfo(np.int16).max:
            raise refuse(
                name, f"must be numbers from {least} on, of 16 bits", f"{values.min()} to {values.max()}"
            )
        field[mask] = values
        return field

    def marks(name: str) -> BoolArray:
        field = np.zeros(mask.shape, np.bool_)
        field[mask] = arrays.read(name, "b", pixels)
        return field

    given = Given(
        numbers(GIVEN["materials"], -1).astype(np.intp) if GIVEN["materials"] in arrays.names else None,
        *(marks(GIVEN[name]) if GIVEN[name] in arrays.names else None for name in ("ink", "highlights")),
    )
    described = json.loads(str(arrays.read(SETTINGS, "U", most=MOST_CHARACTERS)))
    ramps = {int(number): ToneRamp(**ramp) for number, ramp in described["ramps"].items()}
    corrections = MaterialCorrections(numbers(FOUND), *map(marks, FOUND_MARKS.values()))
    codes = numbers(CODES)
    corrections.resume(codes, ramps, ShapeMarks.of(analysis.drawing.given_shape))
    if len(numbers_in(materials_of(codes))) != analysis.materials.count:
        raise refuse(CODES, f"must be those of {analysis.materials.count} materials", "others")
    settings = described["settings"]
    RelightSettings(**settings)
    return SavedWork(analysis.recolored({}), corrections, given, settings, ramps, int(described["selected"]))
