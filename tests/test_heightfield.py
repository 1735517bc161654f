import numpy as np
import pytest
from scipy import ndimage

from tests.analytic import SOFT, ellipse, painted
from toonkit import HeightField, NormalField, ToonkitError, height_map, height_mesh
from toonkit.heightfield import level_rim
from toonkit.numerics.report import NOT_REFINED


@pytest.mark.parametrize("radius", [24, 64])
def test_a_ball_has_the_height_of_a_ball(radius):
    ball = ellipse(radius, radius)
    height = height_map(ball.normals).height
    inner = ball.mask & (np.hypot(ball.x, ball.y) < 0.9 * radius)
    truth = np.sqrt(np.maximum(radius**2 - ball.x**2 - ball.y**2, 0))
    difference = (height - truth)[inner]
    # Up to a constant, within two hundredths of the radius: the slopes at the outermost pixels are clamped.
    assert np.ptp(difference) < 0.02 * radius


def test_a_slope_has_its_own_gradient():
    mask = np.ones((20, 30), dtype=bool)
    normal = np.array([-0.3, 0.2, 1.0])
    normals = NormalField(np.broadcast_to(normal / np.linalg.norm(normal), (20, 30, 3)), mask)
    height = height_map(normals).height
    assert np.allclose(np.diff(height, axis=1), 0.3, atol=1e-4)
    assert np.allclose(np.diff(height, axis=0), 0.2, atol=1e-4)  # down a row is down in y


def test_every_component_starts_at_zero():
    mask = np.zeros((20, 40), dtype=bool)
    mask[3:17, 3:17] = mask[3:17, 23:37] = True
    vectors = np.broadcast_to([0.0, 0.0, 1.0], (20, 40, 3))
    height = height_map(NormalField(vectors, mask)).height
    assert np.nanmin(height[:, :20]) == np.nanmin(height[:, 20:]) == 0.0
    assert np.isnan(height[~mask]).all()


def test_a_part_in_front_does_not_bend_the_one_behind():
    """A cap sits before a plane: its silhouette drops, the plane beside it stays a plane."""
    cap = ellipse(16, 16)
    vectors = np.where(cap.mask[..., None], cap.normals.vectors, [0.0, 0.0, 1.0])
    scene = np.pad(vectors, ((12, 12), (12, 12), (0, 0)), mode="edge")
    plane = np.pad(~cap.mask, 12, constant_values=True)
    height = height_map(NormalField(scene, np.ones(plane.shape, bool))).height
    cap_height = np.ptp(height[~plane])
    assert np.ptp(height[plane]) < 0.1 * cap_height


def test_the_mesh_looks_at_the_viewer_and_carries_colors():
    ball = ellipse(16, 16)
    image = painted(ball.normals, SOFT)
    mesh = height_mesh(height_map(ball.normals), color=image)
    assert len(mesh.vertices) == ball.mask.sum()
    assert (mesh.face_normals[:, 2] > 0).all()
    assert np.array_equal(mesh.visual.vertex_colors[:, :3], image.to_rgba()[ball.mask][:, :3])
    top = mesh.vertices[np.argmax(mesh.vertices[:, 2])]
    assert top[:2] == pytest.approx([ball.mask.shape[1] / 2, ball.mask.shape[0] / 2], abs=1.5)


def test_colors_of_another_size_are_refused():
    ball = ellipse(16, 16)
    with pytest.raises(ToonkitError, match="size of the height field"):
        height_mesh(height_map(ball.normals), color=painted(ellipse(12, 12).normals, SOFT))


def test_a_level_rim_keeps_what_was_level_and_levels_a_slope():
    row, column = np.indices((40, 60))
    mask = ((row - 20) / 18) ** 2 + ((column - 30) / 28) ** 2 < 1
    dome = 10 * (1 - ((row - 20) / 18) ** 2 - ((column - 30) / 28) ** 2)
    slope = 0.3 * column + 0.1 * row
    found = level_rim(HeightField(np.where(mask, dome + slope, np.nan), mask, NOT_REFINED)).height
    rim = mask & ~ndimage.binary_erosion(mask)
    assert np.nanmax(found[rim]) < 0.01
    assert np.abs(found - dome)[mask].max() < 1.5  # the dome is not quite 0 at the rim's pixels
