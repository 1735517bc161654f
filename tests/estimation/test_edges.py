"""Links hold the change together on smooth ground, and let go across an edge; at any resolution alike."""

from __future__ import annotations

import numpy as np
import pytest

from tests.analytic import LIGHT, ellipse
from toonkit import METHODS, NormalField, RefinementOptions, ToonImage, ToonkitError, refine
from toonkit.estimation.color_map_fit import allowed_interval, painted_interval
from toonkit.estimation.edges import edge_links
from toonkit.estimation.preparation import prepare
from toonkit.estimation.refinement import build_energies
from toonkit.methods import steps
from toonkit.model.color_map import ColorMap, IlluminationInterval
from toonkit.numerics.masked_grid import OUTSIDE, RIGHT, MaskedGrid


def anything(grid: MaskedGrid) -> IlluminationInterval:
    """Colors that allow every illumination."""
    return IlluminationInterval(np.full(grid.size, -1.0), np.full(grid.size, 1.0))


def crease_links(grid: MaskedGrid, normals: np.ndarray, turn: float) -> np.ndarray:
    return edge_links(grid, normals, anything(grid), turn=turn, jump=0.02)


def roof(size: int) -> NormalField:
    """Two planes that meet in the middle column, under 90 degrees."""
    vectors = np.zeros((size, size, 3))
    side = np.where(np.arange(size) < size // 2, -1.0, 1.0) * np.sqrt(0.5)
    vectors[..., 0], vectors[..., 2] = side, np.sqrt(0.5)
    return NormalField(vectors, np.ones((size, size), bool))


@pytest.mark.parametrize("radius", [20, 40, 80])
def test_a_ball_is_held_together_alike_at_any_resolution(radius):
    ball = ellipse(radius, radius)
    grid = MaskedGrid(ball.mask)
    links = crease_links(grid, ball.normals.vectors[ball.mask], 10.0)
    middle = np.linalg.norm(ball.normals.vectors[ball.mask][:, :2], axis=1) < 0.5
    # In the middle a step of one pixel turns x by 1 / radius: sqrt(pi) radians per sqrt(area), and z by a little more.
    expected = 1 / (1 + np.pi / 10.0**2)
    assert links[middle].mean() == pytest.approx(expected, rel=0.01)


def test_the_links_across_a_crease_let_go_and_the_others_do_not():
    field = roof(32)
    grid = MaskedGrid(field.mask)
    links = crease_links(grid, field.vectors[field.mask], 10.0)
    across = np.zeros((32, 32), bool)
    across[:, 15] = True
    crease = across[field.mask]
    assert links[crease, RIGHT].max() < 0.06
    there = grid.neighbors != OUTSIDE
    there[crease, RIGHT] = False
    there[grid.neighbors[crease, RIGHT], 2] = False
    assert (links[there] == 1.0).all()


def test_a_link_is_the_same_from_both_ends():
    ball = ellipse(12, 9)
    grid = MaskedGrid(ball.mask)
    lower = np.random.default_rng(5).uniform(-1, 0.9, grid.size)
    painted = IlluminationInterval(lower, lower + 0.1)
    links = edge_links(grid, ball.normals.vectors[ball.mask], painted, turn=2.0, jump=0.3)
    assert np.ptp(links[grid.neighbors != OUTSIDE]) > 0.5
    here = np.flatnonzero(grid.neighbors[:, RIGHT] != OUTSIDE)
    assert np.array_equal(links[here, RIGHT], links[grid.neighbors[here, RIGHT], 2])


def test_one_side_of_a_roof_may_change_without_the_other():
    """The left half is told that it is darker than its normals say: the right half is to stay as it is."""
    field = roof(48)
    shining = field.vectors @ LIGHT
    wide = np.where(np.arange(48) < 24, shining - 0.25, -1.0)
    interval = IlluminationInterval(wide, np.where(np.arange(48) < 24, shining - 0.15, 1.0))

    def moved(turn: float) -> float:
        options = RefinementOptions(
            change_length=0.05, crease_turn=turn, rim_hold=0.0, integrability_length=0.0
        )
        change = refine(field, LIGHT, interval, options=options).normals.vectors - field.vectors
        return float(
            np.linalg.norm(change[:, 24:], axis=2).mean() / np.linalg.norm(change[:, :24], axis=2).mean()
        )

    assert moved(10.0) < 0.5 * moved(1e6)


def banded(*tones: float) -> ColorMap:
    """As many hard bands, of equal width."""
    return ColorMap(np.repeat(tones, 100)[:, None].repeat(3, axis=1))


THREE_TONES = banded(0.2, 0.5, 0.9)


def striped(columns: list[float], rows: int = 6) -> ToonImage:
    """Vertical stripes of gray on a square object."""
    return ToonImage(
        np.tile(np.array(columns)[None, :, None], (rows, 1, 3)), np.ones((rows, len(columns)), bool)
    )


def links_of(image: ToonImage, color_map: ColorMap = THREE_TONES) -> tuple[MaskedGrid, np.ndarray]:
    """Links of a flat surface that is painted so."""
    read = prepare(image)
    painted = painted_interval(read.tones, color_map, allowed_interval(read.tones, color_map))
    facing = np.tile([0.0, 0.0, 1.0], (read.grid.size, 1))
    return read.grid, edge_links(read.grid, facing, painted, turn=10.0, jump=0.02)


def to_the_right(image: ToonImage) -> np.ndarray:
    """Stiffness between columns, each row the same."""
    _, links = links_of(image)
    rows = links[:, RIGHT].reshape(image.shape)
    assert (rows == rows[0]).all()
    return rows[0, :-1]


def test_bands_that_follow_each_other_are_held_together():
    assert to_the_right(striped([0.2] * 4 + [0.5] * 4 + [0.9] * 4)).min() > 0.9


def test_the_link_between_colors_that_skip_a_band_lets_go_alone():
    stiff = to_the_right(striped([0.2] * 4 + [0.9] * 4))
    assert stiff[3] < 0.002  # a third of all illumination apart
    assert np.delete(stiff, 3).min() > 0.9


def test_a_mixed_pixel_between_such_colors_does_not_join_them():
    stiff = to_the_right(striped([0.2] * 4 + [0.62] + [0.9] * 4))
    assert stiff[3] < 0.002  # it counts for the brighter band
    assert np.delete(stiff, 3).min() > 0.9


def test_an_analysis_tells_edges_by_colors_without_their_mixtures(monkeypatch):
    image = striped([0.2] * 6 + [0.62] + [0.9] * 6 + [0.5] * 6, rows=12)
    seen = []

    def watched(*arguments, painted, **others):
        seen.append((arguments[3], painted))
        return build_energies(*arguments, painted=painted, **others)

    monkeypatch.setattr(steps, "build_energies", watched)
    METHODS["classical"](image, LIGHT)
    ((allowed, painted),) = seen
    tones = prepare(image).tones
    mixed = tones.plain != tones.tone
    assert mixed.sum() == 12
    assert (
        painted.lower[mixed] > allowed.lower[mixed] + 0.1
    ).all()  # it spans both bands, and belongs to the brighter one
    assert np.array_equal(painted.lower[~mixed], allowed.lower[~mixed])
    assert np.array_equal(painted.upper, allowed.upper)


def test_the_sides_of_a_drawn_line_are_neighbors_of_each_other():
    """A line with the darkest band on one side and the brightest on the other, and an outline."""
    size = 96
    y, x = np.mgrid[:size, :size] - (size - 1) / 2
    away = np.hypot(x, y)
    paint = np.where(x < 0, 0.3, 0.9)
    ink = (away > 40) | (np.abs(x) < 1.5)
    image = ToonImage(np.where(ink, 0.0, paint)[..., None].repeat(3, 2), away < 43)
    assert prepare(image).ink.coverage.any()
    grid, links = links_of(image, banded(0.3, 0.5, 0.9))
    rows, columns = prepare(image).box
    middle = grid.rows + rows.start == size // 2
    loose = grid.columns[middle & (links[:, RIGHT] < 0.01) & (grid.neighbors[:, RIGHT] != OUTSIDE)]
    assert len(loose) == 1  # one link of those beneath the line
    assert abs(loose[0] + columns.start - (size - 1) / 2) < 2


def test_what_one_side_of_a_contour_is_asked_does_not_move_the_other():
    """Left and right of it the colors skip a band; the left half is told that it is darker than its normals say."""
    vectors = np.tile([0.0, 0.0, 1.0], (48, 48, 1))
    flat = NormalField(vectors, np.ones((48, 48), bool))
    shining = vectors @ LIGHT
    left = np.arange(48) < 24
    interval = IlluminationInterval(
        np.where(left, shining - 0.5, shining - 0.05), np.where(left, shining - 0.4, 1.0)
    )

    def moved(jump: float) -> float:
        options = RefinementOptions(
            change_length=0.05, color_jump=jump, rim_hold=0.0, integrability_length=0.0
        )
        change = refine(flat, LIGHT, interval, options=options).normals.vectors - vectors
        return float(
            np.linalg.norm(change[:, 24:], axis=2).mean() / np.linalg.norm(change[:, :24], axis=2).mean()
        )

    assert moved(0.02) < 0.2 * moved(1e6)


@pytest.mark.parametrize("name", ["crease_turn", "color_jump"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan])
def test_an_edge_that_means_nothing_is_refused(name, value):
    with pytest.raises(ToonkitError, match=f"{name} must be a number from 1e-06 to 1e\\+12"):
        RefinementOptions(**{name: value})
