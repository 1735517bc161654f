"""A digest changes with what a number depends on, and with nothing else."""

from __future__ import annotations

import functools
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest
import trimesh

from toonkit import METHODS, ColorMap
from toonkit.study.color_maps import load_color_maps
from toonkit.study.digests import (
    CODE,
    MEASURED_BY,
    PACKAGE,
    PART_DIGESTS,
    PARTS,
    code_digest,
    color_map_digest,
    light_track_digests,
    method_digest,
    part_digest,
    subject_digest,
)
from toonkit.study.registry import View
from toonkit.study.shapes import SHAPES
from toonkit.study.subjects import MeshShape
from toonkit.study.trials import LIGHT_TRACKS

BALL = trimesh.creation.icosphere(subdivisions=1)


def test_every_module_that_all_numbers_depend_on_is_there():
    assert [name for name in MEASURED_BY if not (PACKAGE / name).exists()] == []


def test_the_digest_of_the_code_follows_the_code_and_not_its_words(tmp_path):
    copy = tmp_path / "toonkit"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    original = code_digest(copy)
    assert original == code_digest()
    path = copy / "metrics.py"
    path.write_text(
        path.read_text().replace("Degrees.", "In degrees.").replace("\n\n\ndef", "\n\n\n# Word.\ndef")
    )
    assert code_digest(copy) == original
    (copy / "methods" / "mine.py").write_text("def mine(): ...\n")
    (copy / "study" / "shapes.py").write_text("")
    assert code_digest(copy) == original
    path.write_text(path.read_text().replace("percentile(inside, 95)", "percentile(inside, 94)"))
    assert code_digest(copy) != original


@pytest.mark.parametrize(
    ("file", "depending"),
    [
        ("estimation/weights/shape_prior.npz", {"shape", "light"}),
        ("estimation/weights/light_prior.npz", {"light"}),
        ("estimation/convolution.py", {"shape", "light"}),
        ("estimation/edges.py", {"refinement"}),
        ("numerics/change_kernels.py", {"refinement"}),
        ("numerics/smoothing.py", {"smoothing"}),
    ],
)
def test_what_some_methods_use_has_digests_of_its_own(file, depending, tmp_path):
    copy = tmp_path / "toonkit"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    before = {name: part_digest(name, copy) for name in PARTS}
    assert before == PART_DIGESTS
    (copy / file).write_bytes(
        (copy / file).read_bytes() + (b"\nSTEP = 1\n" if file.endswith(".py") else b" ")
    )
    assert {name for name in PARTS if part_digest(name, copy) != before[name]} == depending
    assert code_digest(copy) == CODE


def test_all_code_of_the_estimation_has_a_digest():
    known = set((PACKAGE / "estimation").glob("*.py"))
    parts = {PACKAGE / name for names in PARTS.values() for name in names}
    assert {path.name for path in parts if path.parent.name == "estimation"} == {
        "convolution.py",
        "edges.py",
        "light_fit.py",
        "light_prior.py",
        "overview.py",
        "shape_prior.py",
        "tone_ranks.py",
        "working_square.py",
    }
    assert all(path.exists() for path in parts)
    assert "estimation" in MEASURED_BY
    assert known - parts


@pytest.mark.parametrize(
    ("part", "using"), [("shape", {"toonkit"}), ("light", set()), ("refinement", {"toonkit", "classical"})]
)
def test_a_method_depends_on_the_parts_that_it_uses(part, using, monkeypatch):
    methods = {**METHODS, "mine": made(1)}
    before = {name: method_digest(method) for name, method in methods.items()}
    monkeypatch.setitem(PART_DIGESTS, part, "another")
    changed = {name for name, method in methods.items() if method_digest(method) != before[name]}
    assert changed == using | {"mine"}


def test_only_an_estimated_light_depends_on_what_was_learned_of_lights(monkeypatch):
    before = light_track_digests()
    monkeypatch.setitem(PART_DIGESTS, "light", "other weights")
    after = light_track_digests()
    assert set(before) == set(LIGHT_TRACKS)
    assert {track for track in LIGHT_TRACKS if before[track] != after[track]} == {"estimated"}


def test_shapes_meshes_views_and_color_maps_are_told_apart():
    seen = [SHAPES["cat"], SHAPES["duck"], MeshShape("a", BALL), MeshShape("a", BALL, View(yaw=5))]
    assert len({subject_digest(subject) for subject in seen}) == len(seen)
    assert subject_digest(MeshShape("a", BALL)) == subject_digest(MeshShape("b", BALL.copy()))
    maps = list(load_color_maps().values())
    assert len({color_map_digest(color_map) for color_map in maps}) == len(maps)
    assert color_map_digest(ColorMap(maps[0].colors, (-0.5, 0.5))) != color_map_digest(maps[0])
    rounded_otherwise = np.nextafter(maps[0].colors, 0.5)
    assert color_map_digest(ColorMap(rounded_otherwise, maps[0].domain)) == color_map_digest(maps[0])


def test_the_methods_of_toonkit_are_told_apart():
    assert len({method_digest(method) for method in METHODS.values()}) == len(METHODS)


def made(factor, table=None):
    def method(image, light, *, progress=None):
        return factor, table

    return method


class Tuned:
    def __init__(self, factor):
        self.factor = factor

    def __call__(self, image, light, *, progress=None):
        return self.factor

    def analyze(self, image, light, *, progress=None):
        return self.factor


def several(image, light, *, progress=None, factor=1):
    return factor


@pytest.mark.parametrize(
    "of",
    [
        made,
        Tuned,
        lambda factor: Tuned(factor).analyze,
        lambda factor: functools.partial(several, factor=factor),
        lambda factor: made(0, np.full(3, factor)),
        lambda factor: made(0, {"a": [factor, {factor}]}),
        lambda factor: made(made(factor)),
    ],
)
def test_what_a_method_was_made_with_belongs_to_it(of):
    assert method_digest(of(1)) == method_digest(of(1))
    assert method_digest(of(1)) != method_digest(of(2))


MODULE = """
import math
STEP = {step}
def helper(x):
    return x * {factor}
def method(image, light, *, progress=None):
    return math.sqrt(helper(STEP))
"""


def test_what_a_method_calls_in_its_own_module_belongs_to_it(tmp_path):
    def digest(**values):
        path = tmp_path / f"{len(list(tmp_path.iterdir()))}.py"
        path.write_text(MODULE.format(**values))
        names = {"__name__": "mine"}
        exec(compile(path.read_text(), str(path), "exec"), names)
        return method_digest(names["method"])

    first = digest(step=1, factor=2)
    assert digest(step=1, factor=2) == first
    assert first not in {digest(step=2, factor=2), digest(step=1, factor=3)}


def test_a_digest_is_the_same_in_every_process():
    code = f"from {__name__} import *; print(method_digest(made({{'a', 'b'}}, Tuned(2))), code_digest())"
    printed = {_printed(code) for _ in range(2)}
    assert printed == {f"{method_digest(made({'a', 'b'}, Tuned(2)))} {code_digest()}\n"}


def _printed(code: str) -> str:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    return subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    ).stdout
