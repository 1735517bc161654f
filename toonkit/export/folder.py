"""write_analysis_folder: everything other programs may want of an analysis, in one folder."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from toonkit._validation import as_path, expand_home, of_type, one_of, refuse
from toonkit.analysis import ToonAnalysis
from toonkit.export.archive import save_analysis
from toonkit.export.atomic import PathLike
from toonkit.export.color_map import write_color_map, write_color_maps
from toonkit.export.contact_sheet import contact_sheet
from toonkit.export.engines import BLEED, ENGINES, SUFFIX, write_engine_normal_map
from toonkit.export.line_art import line_art
from toonkit.export.normal_map import write_normal_map
from toonkit.export.picture import write_picture
from toonkit.export.report import analysis_report, write_report
from toonkit.model.label_colors import label_picture
from toonkit.numerics.parallel import run_each

ARCHIVE_NAME = "analysis.npz"
"""Name of the file that `load_analysis` reads back."""

LAYOUT_NAME = "frames.json"
"""Name of the file that makes a folder that of a sheet's or an animation's frames: an analysis of one drawing has none."""

REPORT_NAME = "report.json"
"""Name of the report, which lists the files of its folder."""

INPUTS = "inputs"
"""Key of the report under which stands what the files were made of, once all of them are there."""

_ENGINE_MAP_NAME = f"base_color{SUFFIX}.png"

_LONGEST = ("relit_contact_sheet.png", ARCHIVE_NAME, "base_color.png")  # to write: these are begun first
_ONLY_SOME_HAVE = (
    "line_art.png", "color_map.png", "color_map.json", "color_maps.png", "color_maps.json", _ENGINE_MAP_NAME
)  # fmt: skip


def make_folder(path: PathLike) -> Path:
    """
    Create a folder, and those above it, unless it is there.

    Parameters
    ----------
    path : path
        The folder.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    ToonkitError
        If it has no name, a file is in its place, or the disk refuses.
    """
    as_path("folder", path)
    if not str(path).strip():
        raise refuse("folder", "must have a name", "an empty one")
    folder = expand_home(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise refuse(
            "folder", "must be a folder that can be written to", f"{path} ({error.strerror})"
        ) from error
    return folder


def write_analysis_folder(
    analysis: ToonAnalysis,
    folder: PathLike,
    *,
    notes: Mapping[str, Any] | None = None,
    engine: str | None = None,
    bleed: float = BLEED,
) -> dict[Path, str]:
    """
    Write an analysis into a folder.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    folder : path
        Created if need be; files of the same names in it are replaced, each once its successor is complete. Files that an
        earlier analysis wrote into it and that this one has no need of are removed: those that its report lists.
    notes : mapping, optional
        Added to report.json.
    engine : str, optional
        A key of `ENGINES`: the folder then has a normal map for it, base_color_n.png.
    bleed : float, optional
        Pixels by which that normal map goes on outside the object.

    Returns
    -------
    dict
        The files written, in order, each with what it is.

    Raises
    ------
    ToonkitError
        If the folder cannot be written to, or there is no such engine.
    """
    of_type("analysis", analysis, ToonAnalysis)
    if engine is not None:
        one_of("engine", engine, ENGINES)
    target = make_folder(folder)
    writers = _writers(analysis)
    if engine is not None:
        writers[_ENGINE_MAP_NAME] = (
            f"normal map of base_color.png for {engine.capitalize()}",
            lambda path: write_engine_normal_map(analysis, path, engine, bleed=bleed),
        )
    report = {**analysis_report(analysis), **(notes or {}), "files": [*writers, REPORT_NAME]}
    writers[REPORT_NAME] = ("how it went", lambda path: write_report(report, path))
    fill_folder(target, {name: write for name, (_, write) in writers.items()})
    return {target / name: what for name, (what, _) in writers.items()}


def fill_folder(folder: Path, writers: Mapping[str, Callable[[Path], None]]) -> None:
    """
    Replace the files of an analysis in a folder, several at a time, and the report last.

    Parameters
    ----------
    folder : Path
        One that exists.
    writers : mapping
        For the name of each file what writes it to a path.

    Raises
    ------
    ToonkitError
        If the folder cannot be written to.
    """
    earlier = _read_report(folder / REPORT_NAME)
    if INPUTS in earlier:  # it vouches for files that are about to go
        write_report({key: value for key, value in earlier.items() if key != INPUTS}, folder / REPORT_NAME)
    names = sorted(writers.keys() - {REPORT_NAME}, key=lambda name: (name not in _LONGEST, name))
    run_each([partial(writers[name], folder / name) for name in names])
    for name in _ONLY_SOME_HAVE:
        if name in _files_of(earlier) and name not in writers:
            _remove(folder / name)
    _remove(folder / LAYOUT_NAME)
    writers[REPORT_NAME](folder / REPORT_NAME)


def holds_analysis(folder: Path, inputs: Mapping[str, Any]) -> bool:
    """
    Tell whether a folder holds all files of an analysis of some inputs by this version of toonkit.

    Parameters
    ----------
    folder : Path
        The folder.
    inputs : mapping
        What `write_analysis_folder` was given as `notes["inputs"]`.

    Returns
    -------
    bool
        False also while the files are being replaced.
    """
    import toonkit  # noqa: PLC0415  # at call time, because the package's own __init__ stands above this module

    report = _read_report(folder / REPORT_NAME)
    return (
        report.get(INPUTS) == inputs
        and report["versions"].get("toonkit") == toonkit.__version__
        and all((folder / name).is_file() for name in _files_of(report))
    )


def _writers(analysis: ToonAnalysis) -> dict[str, tuple[str, Callable[[Path], None]]]:
    """Return, for the name of each file but the report, what it is and how it is written."""
    normals, materials, base_color = analysis.normals, analysis.materials, analysis.base_color
    writers: dict[str, tuple[str, Callable[[Path], None]]] = {
        ARCHIVE_NAME: ("the whole analysis, to be relit", lambda path: save_analysis(analysis, path)),
        "input.png": ("the drawing as analyzed, cut out", lambda path: write_picture(analysis.image, path)),
        "base_color.png": (
            "the drawing without its painted shading",
            lambda path: write_picture(base_color, path),
        ),
        "materials.png": (
            "its materials, a color each",
            lambda path: write_picture(label_picture(materials.labels), path),
        ),
    }
    if analysis.drawing.ink.coverage.any():
        writers["line_art.png"] = (
            "its line art alone",
            lambda path: write_picture(line_art(analysis.drawing), path),
        )
    writers["normals.png"] = ("normal map, green up (OpenGL)", lambda path: write_normal_map(normals, path))
    writers["normals_16.png"] = ("the same, 16 bits", lambda path: write_normal_map(normals, path, bits=16))
    writers["normals_directx.png"] = (
        "normal map, green down (DirectX)",
        lambda path: write_normal_map(normals, path, green="directx"),
    )
    if materials.count == 1:
        color_map = materials.color_maps[0]
        writers["color_map.png"] = (
            "color map as a ramp texture",
            lambda path: write_color_map(color_map, path),
        )
        writers["color_map.json"] = ("color map, exact", lambda path: write_color_map(color_map, path))
    else:
        writers["color_maps.png"] = (
            "color map of each material as a ramp texture",
            lambda path: write_color_maps(materials, path),
        )
        writers["color_maps.json"] = ("color maps, exact", lambda path: write_color_maps(materials, path))
    writers["relit_contact_sheet.png"] = (
        "all of it at a glance, under new lights",
        lambda path: write_picture(contact_sheet(analysis, base_color=base_color), path),
    )
    return writers


def _read_report(path: Path) -> dict[str, Any]:
    """Return the report of an earlier analysis, empty if there is none."""
    try:
        report = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, RecursionError, ValueError):
        return {}
    known = isinstance(report, dict) and isinstance(report.get("versions"), dict)
    return report if known else {}


def _files_of(report: Mapping[str, Any]) -> list[str]:
    """Return the names that a report lists; toonkit 0.1 wrote one color map, and no list."""
    if not report:
        return []
    files = report.get("files", ["color_map.png", "color_map.json"])
    return [name for name in files if isinstance(name, str)] if isinstance(files, list) else []


def _remove(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise refuse(
            "folder", "must be a folder that can be written to", f"{path} ({error.strerror})"
        ) from error
