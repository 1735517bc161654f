"""A plan is everything there is, unless it is told otherwise, and refuses what it cannot name."""

from __future__ import annotations

import pytest
import trimesh

from toonkit import METHODS, ColorMap, ToonkitError
from toonkit.study.color_maps import load_color_maps
from toonkit.study.plan import plan_study
from toonkit.study.shapes import SHAPES
from toonkit.study.subjects import MeshShape

BALL = MeshShape("ball", trimesh.creation.icosphere(subdivisions=1))


def test_the_whole_study_is_every_shape_color_map_and_method():
    plan = plan_study()
    trials = [trial for cell in plan.cells() for trial in cell]
    assert len(trials) == len(set(trials)) == 20 * 24 * (len(METHODS) + 1)
    assert len({trial.key for trial in trials}) == len(trials)
    assert {len({(trial.shape, trial.color_map) for trial in cell}) for cell in plan.cells()} == {1}


def test_meshes_stand_alone_or_beside_named_shapes():
    assert list(plan_study(meshes=[BALL]).subjects) == ["ball"]
    assert list(plan_study(meshes=[BALL], shapes=["cat"]).subjects) == ["cat", "ball"]


@pytest.mark.parametrize("shapes", [None, ["torus"]])
def test_a_mesh_does_not_take_the_name_of_a_shape(shapes):
    plan = plan_study(meshes=[MeshShape("torus", BALL.mesh)], shapes=shapes)
    assert list(plan.subjects)[-1] == plan.subjects["torus_mesh"].name == "torus_mesh"


def test_color_maps_may_be_brought_along():
    mine = ColorMap([[0.1, 0.1, 0.1], [0.9, 0.9, 0.9]])
    assert plan_study(color_maps={"mine": mine}).color_maps == {"mine": mine}


def test_both_light_tracks_double_the_trials():
    plan = plan_study(shapes=["cat"], color_maps=["terracotta"], light_tracks=["given", "estimated"])
    assert len(plan.cells()[0]) == 2 * (len(METHODS) + 1)


@pytest.mark.parametrize(
    ("wrong", "argument"),
    [
        ({"shapes": ["no such"]}, "shapes"),
        ({"shapes": ["cat", "cat"]}, "shapes"),
        ({"shapes": []}, "shapes"),
        ({"color_maps": ["no such"]}, "color_maps"),
        ({"color_maps": {"a/b": next(iter(load_color_maps().values()))}}, "color_maps"),
        ({"color_maps": {"a--b": next(iter(load_color_maps().values()))}}, "color_maps"),
        ({"methods": ["no such"]}, "methods"),
        ({"light_tracks": ["guessed"]}, "light_tracks"),
        ({"light_tracks": []}, "light_tracks"),
        ({"meshes": [BALL, BALL]}, "meshes"),
        ({"color_maps": {"terracotta": ColorMap([[0, 0, 0], [1, 1, 1]])}}, "color_maps"),
    ],
)
def test_what_cannot_be_planned_is_refused(wrong, argument):
    with pytest.raises(ToonkitError, match=f"^{argument} must"):
        plan_study(**wrong)


def test_a_digest_follows_what_it_stands_for(monkeypatch):
    def mine(image, light, *, progress=None):
        return METHODS["lumo"](image, light)

    before = plan_study(shapes=["cat"]).digests()
    monkeypatch.setitem(METHODS, "lumo", mine)
    after = plan_study(shapes=["cat"]).digests()
    assert before["shape"] == after["shape"]
    assert before["color_map"] == after["color_map"]
    assert {name for name in METHODS if before["method"][name] != after["method"][name]} == {"lumo"}
    assert len(set(before["color_map"].values())) == len(load_color_maps())
    assert SHAPES.keys() >= before["shape"].keys()
