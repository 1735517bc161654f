"""Folders of results: what is printed of them, and the analysis that is read from one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from toonkit._validation import expand_home, refuse

if TYPE_CHECKING:
    from toonkit.analysis import ToonAnalysis


def print_files(files: dict[Path, str]) -> None:
    """Print the files written to a folder, each with what it is."""
    print(f"written to {next(iter(files)).parent}:")
    width = max(len(path.name) for path in files)
    for path, what in files.items():
        print(f"  {path.name:<{width}}  {what}")


def holds_frames(source: str) -> bool:
    """Tell whether a folder is one that `toonkit frames` wrote."""
    from toonkit.export.folder import LAYOUT_NAME  # noqa: PLC0415 - starting must not load what pictures need

    return (expand_home(source) / LAYOUT_NAME).is_file()


def read_analysis(source: str) -> ToonAnalysis:
    """
    Read an analysis from the folder that `toonkit analyze` wrote, or from its archive.

    Raises
    ------
    ToonkitError
        If there is none, it is damaged, or it is of frames.
    """
    from toonkit.export.archive import load_analysis  # noqa: PLC0415
    from toonkit.export.folder import ARCHIVE_NAME  # noqa: PLC0415

    if holds_frames(source):
        raise refuse("analysis", "must be of one drawing", f"{source}, which `toonkit frames` wrote")
    place = expand_home(source)
    return load_analysis(place / ARCHIVE_NAME if place.is_dir() else place)
