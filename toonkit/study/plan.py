"""StudyPlan: which shapes, color maps and methods a study compares, and under which lights."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

from toonkit._validation import expand_home, refuse
from toonkit.export.atomic import PathLike
from toonkit.model.color_map import ColorMap
from toonkit.study.color_maps import load_color_maps
from toonkit.study.digests import color_map_digest, file_digest, scene_digest, weights_digests
from toonkit.study.estimators import Estimator, list_estimators
from toonkit.study.painting import StudySettings
from toonkit.study.records import LIGHT_TRACKS, LightTrack, Trial
from toonkit.study.scenes import MeshShape, Scene
from toonkit.study.shapes import SHAPES

Named = TypeVar("Named")

_NAME = re.compile(r"[A-Za-z0-9]+([_.-]?[A-Za-z0-9]+)*")


@dataclass(frozen=True, eq=False)
class StudyPlan:
    """
    The trials of a study.

    Attributes
    ----------
    scenes : dict
        Shapes and meshes by name.
    color_maps : dict
        Color maps by name.
    methods : dict
        Estimators by name.
    light_tracks : tuple of str
        Of "given" and "estimated".
    settings : StudySettings
        Size and lights.
    method_files : dict
        Files of the user's own that define some of the methods, by method.
    """

    scenes: dict[str, Scene]
    color_maps: dict[str, ColorMap]
    methods: dict[str, Estimator]
    light_tracks: tuple[LightTrack, ...] = ("given",)
    settings: StudySettings = field(default_factory=StudySettings)
    method_files: dict[str, Path] = field(default_factory=dict)

    def batches(self) -> list[list[Trial]]:
        """Return the trials, those of one shape and one color map together: they share a painting."""
        return [
            [Trial(shape, color_map, method, track) for track in self.light_tracks for method in self.methods]
            for shape in self.scenes
            for color_map in self.color_maps
        ]

    def digests(self) -> dict[str, dict[str, str | None]]:
        """Return digests of the trials' inputs and of the network weights; toonkit's own code is not among them."""
        return {
            "shape": {name: scene_digest(scene) for name, scene in self.scenes.items()},
            "color_map": {name: color_map_digest(value) for name, value in self.color_maps.items()},
            "method_file": {
                name: file_digest(self.method_files[name]) if name in self.method_files else None
                for name in self.methods
            },
            "weights": {**weights_digests()},
        }


def plan_study(
    *,
    shapes: Iterable[str] | None = None,
    meshes: Sequence[MeshShape] = (),
    color_maps: Iterable[str] | Mapping[str, ColorMap] | None = None,
    methods: Iterable[str] | None = None,
    light_tracks: Sequence[LightTrack] = ("given",),
    settings: StudySettings | None = None,
    method_files: Mapping[str, PathLike] | None = None,
) -> StudyPlan:
    """
    Choose what a study compares; everything by default.

    Parameters
    ----------
    shapes : iterable of str, optional
        Names in `SHAPES`; all of them by default, or none if there are meshes.
    meshes : sequence of MeshShape, optional
        Further shapes. One with the name of a shape of the study gets `_mesh` behind it.
    color_maps : iterable of str or mapping, optional
        Names among the study's color maps, or further ones by name.
    methods : iterable of str, optional
        Names in `toonkit.METHODS`, or "flat".
    light_tracks : sequence of str, optional
        Of "given" and "estimated".
    settings : StudySettings, optional
        Size and lights.
    method_files : mapping, optional
        Files that define methods, by method; when one has changed, its trials are run again. Other names are ignored.

    Returns
    -------
    StudyPlan
        The argument of `run_study`.

    Raises
    ------
    ToonkitError
        If a name is unknown, occurs twice or cannot name a file, a file is missing, or there is nothing to compare.

    Examples
    --------
    >>> plan = plan_study(shapes=["cat", "torus"], color_maps=["terracotta"], methods=["todo", "flat"])
    >>> len(plan.batches()), len(plan.batches()[0])
    (2, 2)
    """
    chosen = _choose("methods", methods, list_estimators())
    tracks: dict[str, LightTrack] = _choose(
        "light_tracks", light_tracks, {track: track for track in LIGHT_TRACKS}
    )
    plan = StudyPlan(
        _choose_scenes(shapes, meshes),
        _choose_color_maps(color_maps),
        chosen,
        tuple(tracks.values()),
        settings or StudySettings(),
        _find_files({name: file for name, file in (method_files or {}).items() if name in chosen}),
    )
    _refuse_bad_names(plan)
    return plan


def _choose_scenes(shapes: Iterable[str] | None, meshes: Sequence[MeshShape]) -> dict[str, Scene]:
    if shapes is None:
        shapes = () if meshes else SHAPES
    scenes: dict[str, Scene] = dict(_choose("shapes", shapes, SHAPES))
    for mesh in meshes:
        # A hand.obj is not the study's hand: their records must not replace each other.
        name = f"{mesh.name}_mesh" if mesh.name in SHAPES else mesh.name
        if name in scenes:
            raise refuse("meshes", "must have names of their own", f"{name!r} twice")
        scenes[name] = replace(mesh, name=name)
    return scenes


def _choose_color_maps(color_maps: Iterable[str] | Mapping[str, ColorMap] | None) -> dict[str, ColorMap]:
    known = load_color_maps()
    if not isinstance(color_maps, Mapping):
        return _choose("color_maps", color_maps, known)
    for name, value in color_maps.items():
        if known.get(name, value) is not value:
            raise refuse(
                "color_maps", "must have names of their own", f"{name!r}, which is one of the study's"
            )
    return dict(color_maps)


def _find_files(files: Mapping[str, PathLike]) -> dict[str, Path]:
    found = {name: expand_home(file) for name, file in files.items()}
    for file in found.values():
        if not file.is_file():
            raise refuse("method_files", "must be files", f"{file}")
    return found


def _choose(argument: str, names: Iterable[str] | None, known: Mapping[str, Named]) -> dict[str, Named]:
    if names is None:
        return dict(known)
    wanted = [names] if isinstance(names, str) else list(names)
    for name in wanted:
        if name not in known:
            raise refuse(argument, f"must be among {', '.join(known)}", repr(name))
    if len(set(wanted)) < len(wanted):
        raise refuse(argument, "must be named once", ", ".join(wanted))
    return {name: known[name] for name in wanted}


def _refuse_bad_names(plan: StudyPlan) -> None:
    groups = {"shapes": [*plan.scenes], "color_maps": [*plan.color_maps], "methods": [*plan.methods]}
    for argument, names in groups.items():
        if not names:
            raise refuse(argument, "must hold at least one name", "none")
        for name in names:
            if not _NAME.fullmatch(name):
                raise refuse(argument, "must be named with letters, digits and single _ . or -", repr(name))
    if not plan.light_tracks:
        raise refuse("light_tracks", "must hold at least one name", "none")
