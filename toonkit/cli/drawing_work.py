"""From a drawing's file to the folder of its analysis: what `toonkit analyze` does once and `toonkit batch` many times."""

from __future__ import annotations

import argparse
import hashlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from toonkit._validation import expand_home, is_number, refuse
from toonkit.cli.lights import parse_angles, parse_light

if TYPE_CHECKING:
    from toonkit.analysis import ToonAnalysis
    from toonkit.model.layer_loading import LayeredDrawing

ESTIMATED = "auto"
"""What is typed in place of a light that is to be estimated."""

METHOD_NAMES = ("toonkit", "classical", "todo", "lumo", "lambert")
"""The keys of `toonkit.METHODS`, repeated so that the help does not have to import them."""

ENGINE_NAMES = ("godot", "unity", "unreal", "blender", "cocos", "defold")
"""The keys of `toonkit.export.engines.ENGINES`, repeated for the same reason."""

BLEED = 16.0
"""`toonkit.export.engines.BLEED`, repeated for the same reason."""


@dataclass(frozen=True)
class DrawingWork:
    """
    A drawing to be analyzed, and how.

    Attributes
    ----------
    drawing : str
        What the report calls it.
    file : Path
        The picture file, or a folder of layers.
    light : str
        AZIMUTH,ELEVATION, or `ESTIMATED`.
    method : str
        Name in `toonkit.METHODS`.
    engine : str or None
        Name in `toonkit.export.engines.ENGINES`: for what program to write a normal map, too.
    bleed : float
        Pixels by which that normal map goes on outside the object.
    mask, materials : Path or None
        Picture files that say where the object and its materials are.
    ink_layers, flats_layers : tuple of str
        Names of the layers that hold the line art and the flat colors; found if there are none.
    merged : bool
        Whether only the merged picture of a layered file counts.

    Raises
    ------
    ToonkitError
        If the light or the bleed is none, or layers are named that do not count.
    """

    drawing: str
    file: Path
    light: str = ESTIMATED
    method: str = "toonkit"
    engine: str | None = None
    bleed: float = BLEED
    mask: Path | None = None
    materials: Path | None = None
    ink_layers: tuple[str, ...] = ()
    flats_layers: tuple[str, ...] = ()
    merged: bool = False

    def __post_init__(self) -> None:
        if self.light != ESTIMATED:
            parse_light(self.light)
        if not is_number(self.bleed) or self.bleed < 0:
            raise refuse("--bleed", "must be a number of pixels >= 0", self.bleed)
        if self.merged and (self.ink_layers or self.flats_layers):
            raise refuse("--merged", "must stand without --ink-layer and --flats-layer", "both")

    def inputs(self) -> dict[str, Any]:
        """Return, as JSON, what the analysis depends on besides toonkit: digests of the files, and the options."""
        files = {"drawing": self.file, "mask": self.mask, "materials": self.materials}
        return {
            **{name: None if path is None else _digest(path) for name, path in files.items()},
            "light": None if self.light == ESTIMATED else list(parse_angles(self.light)),
            "method": self.method,
            "engine": self.engine,
            "bleed": None if self.engine is None else self.bleed,
            "layers": None if self.merged else [list(self.ink_layers), list(self.flats_layers)],
        }


@dataclass(frozen=True, eq=False)
class AnalyzedDrawing:
    """A drawing as it was read, its analysis, and the files written, each with what it is."""

    drawing: LayeredDrawing
    analysis: ToonAnalysis
    files: dict[Path, str]


def add_work_options(command: argparse.ArgumentParser) -> None:
    """Add to a command the options of a `DrawingWork` that are told in the same words everywhere."""
    command.add_argument(
        "--method", choices=METHOD_NAMES, default="toonkit", help="estimator (default: toonkit)"
    )
    command.add_argument(
        "--engine",
        choices=ENGINE_NAMES,
        help="write a normal map for this engine, too, beside base_color.png: with alpha, and its green axis and suffix",
    )
    command.add_argument(
        "--ink-layer",
        action="append",
        default=[],
        metavar="NAME",
        help="layer or group that holds the line art of a layered file, once or more often (default: it is found)",
    )
    command.add_argument(
        "--flats-layer",
        action="append",
        default=[],
        metavar="NAME",
        help="layer or group that holds its flat colors, each of which is a material (default: it is found)",
    )
    command.add_argument(
        "--merged", action="store_true", help="take the merged picture of a layered file alone"
    )
    command.add_argument(
        "--bleed",
        type=float,
        default=BLEED,
        metavar="PIXELS",
        help=f"how far the engine's normal map goes on outside the drawing, for filtering and mipmaps (default: {BLEED:g})",
    )


def layer_options(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return what was typed about layers as arguments of a `DrawingWork`."""
    return {
        "ink_layers": tuple(arguments.ink_layer),
        "flats_layers": tuple(arguments.flats_layer),
        "merged": arguments.merged,
    }


def analyze_drawing(
    work: DrawingWork,
    folder: str | Path,
    *,
    progress: Callable[[str, float], None] | None = None,
    seconds: Callable[[], dict[str, float]] | None = None,
) -> AnalyzedDrawing:
    """
    Analyze a drawing into a folder.

    Parameters
    ----------
    work : DrawingWork
        The drawing, the options, and which files to write.
    folder : str or Path
        Where to write; created if need be, once the drawing is read.
    progress : callable, optional
        Called with the name of the current step and the fraction done, 0 to 1.
    seconds : callable, optional
        Returns the seconds spent so far, by step name, for the report.

    Returns
    -------
    AnalyzedDrawing
        What was read, found and written.

    Raises
    ------
    ToonkitError
        If the drawing cannot be read or analyzed, or the folder cannot be written.
    """
    import toonkit  # noqa: PLC0415
    from toonkit._validation import as_labels  # noqa: PLC0415
    from toonkit.export.folder import INPUTS, make_folder, write_analysis_folder  # noqa: PLC0415
    from toonkit.export.label_picture import read_labels  # noqa: PLC0415
    from toonkit.metrics import color_rmse  # noqa: PLC0415
    from toonkit.numerics.parallel import single_threaded_blas  # noqa: PLC0415

    step = progress or (lambda _step, _fraction: None)
    given = None if work.light == ESTIMATED else parse_light(work.light)
    step("reading the drawing", 0.0)
    drawing = _read(work)
    if work.materials is not None:
        labels = as_labels("materials", read_labels(work.materials), drawing.image.mask)
        drawing = replace(drawing, materials=labels, flats_layers=())
    inputs = work.inputs()
    make_folder(folder)  # before the long work, so that a bad name costs no time
    analysis = toonkit.analyze(
        drawing.image,
        given,
        method=work.method,
        materials=drawing.materials,
        ink=drawing.ink,
        progress=step,
    )
    analysis.drawing.release()  # writing needs memory, too
    step("writing", 1.0)
    with single_threaded_blas():
        rmse = float(color_rmse(analysis.picture, drawing.image))
    notes: dict[str, Any] = {"drawing": work.drawing, INPUTS: inputs, "input_fit_rmse": rmse}
    if drawing.ink_layers or drawing.flats_layers:
        notes["layers"] = {"ink": list(drawing.ink_layers), "flats": list(drawing.flats_layers)}
    if seconds is not None:
        notes["seconds"] = seconds()
    written = write_analysis_folder(analysis, folder, notes=notes, engine=work.engine, bleed=work.bleed)
    return AnalyzedDrawing(drawing, analysis, written)


def _read(work: DrawingWork) -> LayeredDrawing:
    import toonkit  # noqa: PLC0415

    if work.merged:
        return toonkit.LayeredDrawing(toonkit.load_image(work.file, mask=work.mask))
    return toonkit.load_layers(
        work.file,
        mask=work.mask,
        ink_layer=work.ink_layers or None,
        flats_layer=work.flats_layers or None,
    )


def _digest(path: Path) -> str:
    """Return a digest of a file, or of the files in a folder and their names."""
    place = expand_home(path)
    if place.is_dir():
        files = sorted(file for file in place.iterdir() if file.is_file())
        parts = "".join(f"{file.name}\n{_digest(file)}\n" for file in files)
        return hashlib.sha256(parts.encode()).hexdigest()
    with place.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
