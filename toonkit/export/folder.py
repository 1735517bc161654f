"""write_analysis_folder: everything other programs may want of an analysis, in one folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from toonkit._validation import refuse
from toonkit.analysis import ToonAnalysis
from toonkit.export.archive import save_analysis
from toonkit.export.atomic import PathLike
from toonkit.export.color_map import write_color_map
from toonkit.export.contact_sheet import contact_sheet
from toonkit.export.normal_map import write_normal_map
from toonkit.export.picture import write_picture
from toonkit.export.report import analysis_report, write_report

ARCHIVE_NAME = "analysis.npz"
"""Name of the file that `load_analysis` reads back."""


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
    if not str(path).strip():
        raise refuse("folder", "must have a name", "an empty one")
    folder = Path(path).expanduser()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise refuse(
            "folder", "must be a folder that can be written to", f"{path} ({error.strerror})"
        ) from error
    return folder


def write_analysis_folder(
    analysis: ToonAnalysis, folder: PathLike, *, notes: Mapping[str, Any] | None = None
) -> dict[Path, str]:
    """
    Write an analysis into a folder.

    Parameters
    ----------
    analysis : ToonAnalysis
        Any method's result.
    folder : path
        Created if need be; files of the same names in it are replaced, each once its successor is complete.
    notes : mapping, optional
        Added to report.json.

    Returns
    -------
    dict
        The files written, in order, each with what it is.

    Raises
    ------
    ToonkitError
        If the folder cannot be written to.
    """
    target = make_folder(folder)
    report = {**analysis_report(analysis), **(notes or {})}
    normals, color_map = analysis.normals, analysis.materials.color_maps[0]
    writers: dict[str, tuple[str, Callable[[Path], None]]] = {
        ARCHIVE_NAME: ("the whole analysis, to be relit", lambda path: save_analysis(analysis, path)),
        "input.png": ("the drawing as analyzed, cut out", lambda path: write_picture(analysis.image, path)),
        "normals.png": ("normal map, green up (OpenGL)", lambda path: write_normal_map(normals, path)),
        "normals_16.png": ("the same, 16 bits", lambda path: write_normal_map(normals, path, bits=16)),
        "normals_directx.png": (
            "normal map, green down (DirectX)",
            lambda path: write_normal_map(normals, path, green="directx"),
        ),
        "color_map.png": ("color map as a ramp texture", lambda path: write_color_map(color_map, path)),
        "color_map.json": ("color map, exact", lambda path: write_color_map(color_map, path)),
        "relit_contact_sheet.png": (
            "the drawing under new lights",
            lambda path: write_picture(contact_sheet(analysis), path),
        ),
        "report.json": ("how it went", lambda path: write_report(report, path)),
    }
    written = {}
    for name, (what, write) in writers.items():
        write(target / name)
        written[target / name] = what
    return written
