"""A digest changes with what a trial is made of, and with nothing else."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest
import trimesh

from toonkit import METHODS, ColorMap, ToonImage, light_direction
from toonkit.estimation import shape_prior, weights
from toonkit.estimation.preparation import prepare
from toonkit.study.color_maps import load_color_maps
from toonkit.study.digests import (
    NETWORKS_USED,
    color_map_digest,
    file_digest,
    scene_digest,
    weights_digests,
)
from toonkit.study.estimators import list_estimators
from toonkit.study.registry import View
from toonkit.study.scenes import MeshShape
from toonkit.study.shapes import SHAPES

BALL = trimesh.creation.icosphere(subdivisions=1)


def test_shapes_meshes_and_views_are_told_apart():
    seen = [SHAPES["cat"], SHAPES["duck"], MeshShape("a", BALL), MeshShape("a", BALL, View(yaw=5))]
    assert len({scene_digest(scene) for scene in seen}) == len(seen)
    assert scene_digest(MeshShape("a", BALL)) == scene_digest(MeshShape("b", BALL.copy()))


def test_color_maps_are_told_apart_but_for_their_last_bits():
    maps = list(load_color_maps().values())
    assert len({color_map_digest(color_map) for color_map in maps}) == len(maps)
    assert color_map_digest(ColorMap(maps[0].colors, (-0.5, 0.5))) != color_map_digest(maps[0])
    rounded_otherwise = np.nextafter(maps[0].colors, 0.5)
    assert color_map_digest(ColorMap(rounded_otherwise, maps[0].domain)) == color_map_digest(maps[0])


def test_a_file_is_known_by_its_content(tmp_path):
    first, second, other = (tmp_path / name for name in "abc")
    for file, text in ((first, "x = 1\n"), (second, "x = 1\n"), (other, "x = 2\n")):
        file.write_text(text)
    assert file_digest(first) == file_digest(second) == hashlib.sha256(b"x = 1\n").hexdigest()
    assert file_digest(other) != file_digest(first)


def test_each_network_has_a_digest_of_its_weights():
    digests = weights_digests()
    assert set(digests) == {"shape_prior", "colored_shape_prior", "light_prior"}
    assert len(set(digests.values())) == len(digests)


@pytest.mark.parametrize("method", list(list_estimators()))
def test_a_method_reads_the_weights_that_it_is_said_to_use(method, monkeypatch):
    read = set()

    def recorded(name):
        read.add(name)
        return weights.read_weights(name)

    monkeypatch.setattr(shape_prior, "read_weights", recorded)
    y, x = np.mgrid[:48, :48] - 23.5
    mask = x**2 + y**2 < 400
    disc = ToonImage(np.where((x > 0)[..., None], 0.9, 0.2) * np.ones(3), mask)
    list_estimators()[method].analyze(prepare(disc), light_direction(135, 45))
    assert read == set(NETWORKS_USED[method])


def test_it_is_known_of_every_method_of_toonkit_which_networks_it_uses():
    assert set(NETWORKS_USED) == {*METHODS, "flat"}
