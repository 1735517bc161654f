"""A plan is everything there is, unless it is told otherwise, and refuses what it cannot name."""

from __future__ import annotations

import pytest
import trimesh

from toonkit import METHODS, ColorMap, ToonkitError
from toonkit.study.color_maps import load_color_maps
from toonkit.study.plan import plan_study
from toonkit.study.scenes import MeshShape

BALL = MeshShape("ball", trimesh.creation.icosphere(subdivisions=1))


def test_the_whole_study_is_every_shape_color_map_and_method():
    plan = plan_study()
    trials = [trial for batch in plan.batches() for trial in batch]
    assert len(trials) == len(set(trials)) == 20 * 24 * (len(METHODS) + 1)
    assert len({trial.key for trial in trials}) == len(trials)
    assert {len({(trial.shape, trial.color_map) for trial in batch}) for batch in plan.batches()} == {1}


def test_meshes_stand_alone_or_beside_named_shapes():
    assert list(plan_study(meshes=[BALL]).scenes) == ["ball"]
    assert list(plan_study(meshes=[BALL], shapes=["cat"]).scenes) == ["cat", "ball"]


@pytest.mark.parametrize("shapes", [None, ["torus"]])
def test_a_mesh_does_not_take_the_name_of_a_shape(shapes):
    plan = plan_study(meshes=[MeshShape("torus", BALL.mesh)], shapes=shapes)
    assert list(plan.scenes)[-1] == plan.scenes["torus_mesh"].name == "torus_mesh"


def test_color_maps_may_be_brought_along():
    mine = ColorMap([[0.1, 0.1, 0.1], [0.9, 0.9, 0.9]])
    assert plan_study(color_maps={"mine": mine}).color_maps == {"mine": mine}


def test_both_light_tracks_double_the_trials():
    plan = plan_study(shapes=["cat"], color_maps=["terracotta"], light_tracks=["given", "estimated"])
    assert len(plan.batches()[0]) == 2 * (len(METHODS) + 1)


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
        ({"method_files": {"lumo": "nowhere.py"}}, "method_files"),
        ({"color_maps": {"terracotta": ColorMap([[0, 0, 0], [1, 1, 1]])}}, "color_maps"),
    ],
)
def test_what_cannot_be_planned_is_refused(wrong, argument):
    with pytest.raises(ToonkitError, match=f"^{argument} must"):
        plan_study(**wrong)


def test_a_plan_has_a_digest_of_each_of_its_parts():
    digests = plan_study(shapes=["cat"], methods=["lumo", "flat"]).digests()
    assert set(digests["shape"]) == {"cat"}
    assert len(set(digests["color_map"].values())) == len(load_color_maps())
    assert digests["method_file"] == {"lumo": None, "flat": None}
    assert set(digests["weights"]) == {"shape_prior", "colored_shape_prior", "light_prior"}


def test_a_method_depends_on_the_file_that_is_named_for_it(tmp_path):
    file = tmp_path / "mine.py"

    def method_files(text):
        file.write_text(text)
        files = {"lumo": file, "not in this plan": tmp_path / "nowhere.py"}
        return plan_study(methods=["lumo", "flat"], method_files=files).digests()["method_file"]

    before, after = method_files("x = 1"), method_files("x = 2")
    assert before["lumo"] != after["lumo"]
    assert before["flat"] is after["flat"] is None


def test_other_code_of_a_method_is_not_noticed(monkeypatch):
    before = plan_study(shapes=["cat"]).digests()
    monkeypatch.setitem(METHODS, "lumo", METHODS["lambert"])
    assert plan_study(shapes=["cat"]).digests() == before
