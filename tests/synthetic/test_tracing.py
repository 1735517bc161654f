import numpy as np
import pytest
from scipy.ndimage import label

from toonkit.synthetic.primitives import (
    ball,
    both_sides,
    box,
    capsule,
    carved,
    ellipsoid,
    frustum,
    joined,
    placed,
    ring,
    rotation,
    scaled,
    tube,
)
from toonkit.synthetic.tracing import Frame, Tracer
from toonkit.synthetic.tracing_kernels import NOTHING

FRAME = Frame((0.0, 0.0), 2.4)
COUNT = 96
OFFSET = (np.arange(COUNT) + 0.5 - COUNT / 2) * FRAME.width / COUNT
UPRIGHT = np.eye(3)
X, Y = np.meshgrid(OFFSET, -OFFSET)


def seen(*parts, view=UPRIGHT):
    return Tracer(parts, view).trace(FRAME, COUNT)


def test_a_ball_shows_a_disc_with_the_normals_of_a_hemisphere():
    hits = seen(ball((0, 0, 0), 1.0))
    inside = np.hypot(X, Y) < 1.0
    edge = np.abs(np.hypot(X, Y) - 1) < 2e-3  # a ray that grazes it may miss or meet it
    assert np.array_equal((hits.part == 0)[~edge], inside[~edge])
    steep = np.hypot(X, Y) < 0.97
    truth = np.stack([X, Y, np.sqrt(np.maximum(1 - X**2 - Y**2, 0))], axis=-1)
    # Rays stop up to a twentieth of their spacing, 0.00125, away from a surface that is up to four times as steep.
    assert np.abs(hits.depth - truth[..., 2])[steep].max() < 0.006
    assert np.abs(hits.normals - truth)[steep].max() < 0.006


@pytest.mark.parametrize(
    ("solid", "area"),
    [
        (ellipsoid((0, 0, 0), (1.0, 0.5, 0.3)), np.pi * 0.5),
        (box((0, 0, 0), (0.8, 0.5, 0.3), 0.0), 1.6),
        (frustum((0, -0.6, 0), (0, 0.6, 0), 0.8, 0.2, 0.0), 1.2),
        (capsule((-0.5, 0, 0), (0.5, 0, 0), 0.3), 0.6 + np.pi * 0.09),
        (placed(ring((0, 0, 0), 0.7, 0.2), x=90), np.pi * (0.9**2 - 0.5**2)),
        (scaled(ball((0, 0, 0), 0.5), 2.0), np.pi),
        (both_sides(ball((0.6, 0, 0), 0.4)), 2 * np.pi * 0.16),
        (tube([(-0.8, 0, 0), (0, 0, 0), (0.8, 0, 0)], 0.1), 0.32 + np.pi * 0.01),
    ],
)
def test_silhouettes_have_the_area_that_geometry_gives_them(solid, area):
    hits = seen(solid)
    # A pixel is 0.025 wide: the area is exact to a fraction of that along the outline.
    assert (hits.part == 0).sum() * (FRAME.width / COUNT) ** 2 == pytest.approx(area, rel=0.02)


def test_the_nearer_part_hides_the_other():
    hits = seen(ball((0, 0, 0), 1.0), ball((0, 0, 0.8), 0.5))
    assert (hits.part[np.hypot(X, Y) < 0.45] == 1).all()
    assert (hits.part[(np.hypot(X, Y) > 0.55) & (np.hypot(X, Y) < 0.95)] == 0).all()
    assert (hits.part[np.hypot(X, Y) > 1.05] == NOTHING).all()


def test_what_is_cut_out_is_not_seen():
    hits = seen(carved(box((0, 0, 0), (1, 1, 0.2), 0.0), ball((0, 0, 0), 0.5), fillet=0.0))
    assert (hits.part[np.hypot(X, Y) < 0.4] == NOTHING).all()
    assert (hits.part[(np.hypot(X, Y) > 0.55) & (np.abs(X) < 0.95) & (np.abs(Y) < 0.95)] == 0).all()


def test_a_fillet_fills_the_crease_between_two_balls():
    pair = ball((-0.5, 0, 0), 0.5), ball((0.5, 0, 0), 0.5)
    creased, filleted = seen(pair[0] + pair[1]), seen(joined(0.3, *pair))
    waist = (np.abs(X) < 0.05) & (np.abs(Y) < 0.2)
    assert (filleted.part[waist] == 0).sum() > (creased.part[waist] == 0).sum()


def test_a_turned_view_shows_a_solid_from_its_side():
    hits = seen(box((0, 0, 0), (0.9, 0.5, 0.2), 0.0), view=rotation(y=90))
    rows, columns = np.nonzero(hits.part == 0)
    assert np.ptp(columns) * FRAME.width / COUNT == pytest.approx(0.4, abs=0.03)
    assert np.ptp(rows) * FRAME.width / COUNT == pytest.approx(1.0, abs=0.03)


def test_the_enclosing_frame_holds_the_whole_silhouette_and_little_more():
    frame = Tracer([ball((3.0, -1.0, 0), 0.5)], np.eye(3)).enclosing_frame()
    assert 1.0 <= frame.width < 1.06
    assert frame.center == pytest.approx((3.0, -1.0), abs=0.03)


def test_rays_that_graze_a_surface_meet_what_lies_behind_it():
    hits = Tracer([ellipsoid((0, 0.2, 0), (0.86, 0.62, 0.8)), ball((0, 0, -1.2), 1.1)], UPRIGHT).trace(
        FRAME, 800
    )
    _, count = label(hits.part == NOTHING)
    assert count == 1  # the background, without a pinhole
