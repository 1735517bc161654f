"""Mesh files are further shapes, seen from where they are told to be."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from pyvista import examples

import toonkit
from toonkit import ToonkitError
from toonkit.study.registry import View
from toonkit.study.scenes import load_mesh, render
from toonkit.study.shapes import SHAPES


@pytest.fixture
def ball_file(tmp_path):
    path = tmp_path / "my ball (1).ply"
    trimesh.creation.icosphere(subdivisions=4).export(path)
    return path


def test_a_mesh_file_is_a_shape_with_a_name_that_files_can_bear(ball_file):
    ball = load_mesh(ball_file)
    assert (ball.name, ball.kind) == ("my_ball_1", "mesh")
    ours, true = render(ball, 64), render(SHAPES["sphere"], 64)
    assert (ours.mask != true.mask).mean() < 0.01
    both = ours.mask & true.mask
    ours_there, true_there = (
        toonkit.NormalField(np.where(both[..., None], shape.normals.vectors, np.nan), both)
        for shape in (ours, true)
    )
    # The ball has 2562 vertices, a few degrees apart; interpolated normals are a tenth of that off.
    assert toonkit.angular_error(ours_there, true_there).mean < 0.5


def test_the_view_turns_the_mesh(tmp_path):
    path = tmp_path / "bar.stl"
    trimesh.creation.box(extents=(2.0, 0.5, 0.5)).export(path)
    lying, standing = render(load_mesh(path), 48), render(load_mesh(path, View(roll=90)), 48)
    assert np.array_equal(np.rot90(lying.mask), standing.mask)


@pytest.mark.parametrize(
    ("content", "says"), [(None, "must be a file"), ("nonsense", "mesh must"), ("v 0 0 0\n", "mesh must")]
)
def test_what_is_no_mesh_is_refused(tmp_path, content, says):
    path = tmp_path / "thing.obj"
    if content is not None:
        path.write_text(content)
    with pytest.raises(ToonkitError, match=says):
        load_mesh(path)


def test_an_example_that_pyvista_does_not_have_is_refused():
    with pytest.raises(ToonkitError, match="example of PyVista"):
        load_mesh("pyvista:no_such_thing")


def test_an_example_comes_from_pyvista_and_says_so_where_there_is_no_network(monkeypatch):
    def offline():
        raise OSError("no network")

    monkeypatch.setattr(examples, "download_bunny", examples.load_sphere)
    assert load_mesh("pyvista:bunny").name == "bunny"
    monkeypatch.setattr(examples, "download_bunny", offline)
    with pytest.raises(ToonkitError, match="no network"):
        load_mesh("pyvista:bunny")
