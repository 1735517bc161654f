"""The shape of a drawing is a textured mesh that other programs open."""

import numpy as np
import pytest
import pyvista
import trimesh

from toonkit import ToonImage, ToonkitError, analyze, load_analysis
from toonkit.cli import main
from toonkit.cli import mesh as mesh_command
from toonkit.export.mesh import BACKS, MOST_VERTICES, textured_mesh, write_mesh

CLOSED = ["mirrored", "flat"]


def opened(analysis, path, **options):
    """The only mesh of a file that was just written."""
    write_mesh(analysis, path, **options)
    (found,) = trimesh.load(path).geometry.values()
    return found


def as_one_body(mesh):
    """The mesh with vertices joined that lie at one place."""
    joined = mesh.copy()
    joined.merge_vertices(merge_tex=True, merge_norm=True)
    return joined


@pytest.mark.parametrize("back", BACKS)
def test_a_file_has_what_the_mesh_has(several, tmp_path, back):
    expected, found = textured_mesh(several, back=back), opened(several, tmp_path / "ball.glb", back=back)
    assert np.allclose(found.vertices, expected.vertices, atol=1e-6)
    assert np.array_equal(found.faces, expected.faces)
    assert np.allclose(found.vertex_normals, expected.vertex_normals, atol=1e-5)
    assert np.allclose(found.visual.uv, expected.visual.uv, atol=1e-6)
    texture = np.asarray(found.visual.material.baseColorTexture.convert("RGB"))
    assert np.array_equal(texture, np.asarray(expected.visual.material.baseColorTexture))
    assert found.visual.material.metallicFactor == 0


@pytest.mark.parametrize("back", BACKS)
def test_pyvista_opens_the_file_with_normals_and_texture_coordinates(several, tmp_path, back):
    write_mesh(several, tmp_path / "ball.glb", back=back)
    blocks = pyvista.read(tmp_path / "ball.glb").combine(merge_points=False).extract_surface(algorithm=None)
    assert blocks.n_cells == len(textured_mesh(several, back=back).faces)
    assert {"Normal", "TEXCOORD_0"} <= {*blocks.point_data.keys()} or blocks.active_normals is not None


def test_each_vertex_shows_the_base_color_and_normal_of_its_pixel(several):
    mesh, image = textured_mesh(several), several.image
    texture = np.asarray(mesh.visual.material.baseColorTexture)
    height, width = texture.shape[:2]
    seen = texture[
        np.floor((1 - mesh.visual.uv[:, 1]) * height).astype(int),
        np.floor(mesh.visual.uv[:, 0] * width).astype(int),
    ]
    rows, columns = np.nonzero(image.mask)
    longest = max(np.ptp(rows), np.ptp(columns)) + 1
    place = np.round(
        mesh.vertices[:, :2] * longest + [(columns.min() + columns.max()) / 2, -(rows.min() + rows.max()) / 2]
    )
    row, column = (-place[:, 1]).astype(int), place[:, 0].astype(int)
    assert np.array_equal(seen, several.base_color.to_rgba()[row, column, :3])
    assert np.allclose(mesh.vertex_normals, several.normals.vectors[row, column], atol=1e-6)


def test_the_surface_faces_the_viewer_and_bulges_toward_it(analysis):
    mesh = textured_mesh(analysis, size=2.0)
    assert (mesh.face_normals[:, 2] > 0).all()
    assert np.ptp(mesh.vertices, axis=0).max() == pytest.approx(2.0, abs=0.06)
    assert 0.7 < mesh.vertices[:, 2].max() < 1.1
    assert mesh.vertices[:, 2].min() >= 0


@pytest.mark.parametrize("back", CLOSED)
def test_a_mesh_with_a_back_is_closed_and_faces_outward(several, back):
    body = as_one_body(textured_mesh(several, back=back))
    assert body.is_watertight
    assert body.is_winding_consistent
    assert body.volume > 0


def test_a_mirrored_back_doubles_the_surface(several):
    mesh = textured_mesh(several, back="mirrored")
    assert mesh.vertices[:, 2].min() == pytest.approx(-mesh.vertices[:, 2].max())
    assert mesh.visual.uv.min() >= 0
    assert mesh.visual.uv.max() <= 1


def test_parts_that_touch_at_a_corner_are_closed_each():
    mask = np.zeros((20, 20), bool)
    mask[2:10, 2:10] = mask[9:17, 9:17] = True  # one pixel in common, from the upper left to the lower right
    mask[11:18, 2:6] = mask[5:12, 5:6] = True
    mask[2:6, 13:17] = mask[5:9, 10:14] = True  # and from the upper right to the lower left
    color = np.where(np.indices(mask.shape)[0][..., None] > 9, 0.4, 0.8) * np.ones(3)
    analysis = analyze(ToonImage(color, mask), (90, 45), method="lumo")
    body = textured_mesh(analysis, back="mirrored")
    assert body.is_watertight
    assert body.is_winding_consistent


def test_a_large_drawing_gets_a_coarser_mesh(several):
    fine, coarse = textured_mesh(several), textured_mesh(several, vertices=20)
    assert 10 < len(fine.vertices) / len(coarse.vertices) < 30
    assert np.abs(coarse.bounds - fine.bounds).max() < 0.1


def test_the_command_writes_what_the_library_writes(several, tmp_path, capsys):
    several.save(tmp_path / "analysis.npz")
    options = ["--back", "mirrored", "--size", "3", "--vertices", "40"]
    assert main(["mesh", str(tmp_path), "-o", str(tmp_path / "a.glb"), *options]) == 0
    assert "written to" in capsys.readouterr().out
    write_mesh(
        load_analysis(tmp_path / "analysis.npz"), tmp_path / "b.glb", back="mirrored", size=3, vertices=40
    )
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


def test_options_of_the_help_are_those_of_the_library():
    assert (mesh_command.BACKS, mesh_command.VERTICES) == (BACKS, MOST_VERTICES)


@pytest.mark.parametrize(
    ("options", "rule"),
    [
        ({"back": "round"}, "back must be one of none, mirrored, flat"),
        ({"size": 0}, "size must be a number > 0"),
        ({"vertices": 1}, "vertices must be a whole number from 2"),
    ],
)
def test_nonsense_is_refused_and_nothing_written(several, tmp_path, options, rule):
    with pytest.raises(ToonkitError, match=rule):
        write_mesh(several, tmp_path / "ball.glb", **options)
    with pytest.raises(ToonkitError, match=r"path must end in \.glb"):
        write_mesh(several, tmp_path / "ball.obj")
    assert list(tmp_path.iterdir()) == []
