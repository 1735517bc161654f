"""Frames as files of the layout that they came in: sheets with a copy of their atlas, animations with their timing."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import FloatArray, as_path, expand_home, of_type, one_of, refuse
from toonkit.export.animation import write_animation
from toonkit.export.archive import load_analysis, save_analysis
from toonkit.export.atomic import PathLike, atomic_write, suffix_of
from toonkit.export.engines import ENGINES, SUFFIX, Engine
from toonkit.export.folder import ARCHIVE_NAME, LAYOUT_NAME, make_folder
from toonkit.export.normal_map import write_normal_map
from toonkit.export.picture import write_picture
from toonkit.frames.analysis import FrameAnalysis
from toonkit.frames.montage import Place
from toonkit.model.frame_files import Frames, Timing
from toonkit.model.label_colors import label_picture
from toonkit.model.normals import NormalField, encode_normal_map
from toonkit.model.sheet_layout import FrameBox, SheetLayout

BLEED = 2.0
"""Pixels by which the normals of a sheet go on outside each frame's object: as many as a tight atlas leaves free."""

_VERSION = 1
_PLAIN = Engine("opengl", 8, "")


def write_frames(pictures: Sequence[NDArray[np.uint8]], frames: Frames, path: PathLike) -> list[Path]:
    """
    Write pictures of frames in the layout of the file that the frames were read from.

    Parameters
    ----------
    pictures : sequence of ndarray of uint8, shape (h, w, 4)
        One for each frame, of its size.
    frames : Frames
        As `read_frames` returned them.
    path : path
        For a sheet, .png or .webp; for an animation, .gif, .webp, .apng or .png. Where the sheet came with an atlas, a copy
        of it is written beside the file, with the suffix .json.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    ToonkitError
        If the pictures are not those of the frames, or a file cannot be written.
    """
    of_type("frames", frames, Frames)
    sizes = [
        (box.width, box.height) if box.rotated else (box.height, box.width) for box in frames.layout.boxes
    ]
    if [picture.shape for picture in pictures] != [(*size, 4) for size in sizes]:
        raise refuse("pictures", "must be one for each frame, of its size", f"{len(pictures)} pictures")
    target = expand_home(path)
    if frames.timing is not None:
        write_animation(pictures, frames.timing, target)
        return [target]
    suffix_of(path, (".png", ".webp"))
    write_picture(frames.layout.put_together(pictures), target)
    return [target, *_write_atlas(frames, target)]


def write_frame_folder(
    result: FrameAnalysis,
    frames: Frames,
    folder: PathLike,
    *,
    suffix: str = ".png",
    engine: str | None = None,
) -> dict[Path, str]:
    """
    Write the analysis of frames into a folder.

    Parameters
    ----------
    result : FrameAnalysis
        Of these frames.
    frames : Frames
        As `read_frames` returned them.
    folder : path
        Created if need be; files of the same names in it are replaced.
    suffix : str, optional
        That of the base color's file; normals and materials are written without loss, as .png.
    engine : str, optional
        A key of `toonkit.export.engines.ENGINES`: the folder then has a normal map for it, base_color_n.png.

    Returns
    -------
    dict
        The files written, each with what it is.

    Raises
    ------
    ToonkitError
        If the folder cannot be written to, or there is no such engine.
    """
    of_type("result", result, FrameAnalysis)
    if engine is not None:
        one_of("engine", engine, ENGINES)
    target = make_folder(folder)
    save_analysis(result.analysis, target / ARCHIVE_NAME)
    with atomic_write(target / LAYOUT_NAME) as file:
        file.write((json.dumps(_described(result, frames), ensure_ascii=False) + "\n").encode())
    written = {
        target / ARCHIVE_NAME: "the whole analysis, to be relit",
        target / LAYOUT_NAME: "how the frames lie in their file",
    }
    base = result.base_colors()
    for path in write_frames(base, frames, target / f"base_color{suffix}"):
        written[path] = (
            "the atlas of it" if path.suffix == ".json" else "the frames without their painted shading"
        )
    materials = target / "materials.png"
    for path in write_frames([label_picture(labels) for labels in result.labels()], frames, materials):
        written[path] = "the atlas of it" if path.suffix == ".json" else "their materials, a color each"
    maps = {"normals.png": ("normal map, green up (OpenGL)", _PLAIN)}
    if engine is not None:
        maps[f"base_color{SUFFIX}.png"] = f"normal map for {engine.capitalize()}", ENGINES[engine]
    for name, (what, preset) in maps.items():
        _write_normals(result.normals(), [picture[..., 3] for picture in base], frames, target / name, preset)
        written[target / name] = what
        written.update(dict.fromkeys(_write_atlas(frames, target / name), "the atlas of it"))
    return written


def read_frame_folder(folder: PathLike) -> tuple[FrameAnalysis, Frames]:
    """
    Read what `write_frame_folder` wrote.

    Parameters
    ----------
    folder : path
        The folder.

    Returns
    -------
    FrameAnalysis
        The analysis.
    Frames
        The layout of the frames; the pictures of the file are not in the folder.

    Raises
    ------
    ToonkitError
        If a file is missing or damaged.
    """
    source = expand_home(as_path("folder", folder))
    try:
        described = json.loads((source / LAYOUT_NAME).read_text(encoding="utf-8"))
        if described["version"] != _VERSION:
            raise ValueError(f"version {described['version']}")
        shape, boxes = described["shape"], described["boxes"]
        layout = SheetLayout((int(shape[0]), int(shape[1])), tuple(FrameBox(**box) for box in boxes))
        places = tuple(Place(**{**place, "shape": tuple(place["shape"])}) for place in described["places"])
        timing = None
        if described["milliseconds"] is not None:
            timing = Timing(tuple(described["milliseconds"]), int(described["loops"]))
        frames = Frames((), layout, timing, described["atlas"])
    except (OSError, RecursionError, KeyError, TypeError, ValueError, IndexError) as error:
        raise refuse("folder", f"must hold an undamaged {LAYOUT_NAME}", f"{folder} ({error})") from error
    return FrameAnalysis(load_analysis(source / ARCHIVE_NAME), places), frames


def _described(result: FrameAnalysis, frames: Frames) -> dict[str, Any]:
    timing = frames.timing
    return {
        "version": _VERSION,
        "shape": frames.layout.shape,
        "boxes": [vars(box) for box in frames.layout.boxes],
        "places": [vars(place) for place in result.places],
        "milliseconds": None if timing is None else timing.milliseconds,
        "loops": 0 if timing is None else timing.loops,
        "atlas": frames.atlas,
    }


def _write_normals(
    normals: Sequence[FloatArray],
    alphas: Sequence[NDArray[np.uint8]],
    frames: Frames,
    path: Path,
    preset: Engine,
) -> None:
    """Write the normals of frames as a normal map; those of an animation have 8 bits a channel."""
    vectors = frames.layout.put_together(normals, np.nan)
    field = NormalField(vectors, np.isfinite(vectors[..., 2]))
    alpha = frames.layout.put_together(alphas) / 255.0
    if frames.timing is None:
        write_normal_map(field, path, bits=preset.bits, green=preset.green, alpha=alpha, bleed=BLEED)
        return
    encoded = encode_normal_map(field, green=preset.green)
    whole = np.dstack([encoded, np.where(field.mask, np.round(255 * alpha), 0).astype(np.uint8)])
    write_animation([np.ascontiguousarray(frame) for frame in frames.layout.cut(whole)], frames.timing, path)


def _write_atlas(frames: Frames, picture: Path) -> list[Path]:
    """Write a copy of the atlas beside a picture of its layout, if there is one."""
    if frames.atlas is None:
        return []
    path = picture.with_suffix(".json")
    meta = frames.atlas.get("meta")
    atlas = {**frames.atlas, "meta": {**(meta if isinstance(meta, dict) else {}), "image": picture.name}}
    with atomic_write(path) as file:
        file.write((json.dumps(atlas, indent=1, ensure_ascii=False) + "\n").encode())
    return [path]
