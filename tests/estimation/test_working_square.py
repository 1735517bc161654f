"""The square that the learned parts look at: what it shows of a picture, and where it puts an answer back."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from tests.analytic import blob_mask, ellipse
from toonkit import light_direction
from toonkit.estimation.working_square import FILL, SIZE, WorkingSquare
from toonkit.numerics.masked_grid import OUTSIDE, MaskedGrid

AZIMUTHS = (0, 37, 90, 143, 180, 251, 270, 318)


def lopsided(size: int = 150) -> np.ndarray:
    """A mask without symmetry, off the picture's center."""
    mask = np.zeros((size, size + 37), bool)
    mask[20:60, 15:140] = True
    mask[60:131, 30:55] = True
    return mask


def numbered(mask: np.ndarray) -> np.ndarray:
    """A picture each of whose pixels has a value of its own."""
    return np.arange(1.0, mask.size + 1).reshape(mask.shape)


def around(mask: np.ndarray, azimuth: float = 0) -> WorkingSquare:
    return WorkingSquare.around(MaskedGrid(mask), light_direction(azimuth, 40)[:2])


def straight(width: float) -> WorkingSquare:
    middle = (width - 1) / 2
    return WorkingSquare(row=middle, column=middle, width=width, cosine=1.0, sine=0.0)


def test_a_square_as_fine_as_the_picture_shows_its_pixels() -> None:
    picture = np.random.default_rng(1).normal(size=(SIZE, SIZE, 3)).astype(np.float32)
    assert np.array_equal(straight(SIZE).sampled(picture), picture)


def test_a_coarser_square_shows_every_third_pixel() -> None:
    picture = numbered(np.ones((3 * SIZE, 3 * SIZE)))
    assert np.array_equal(straight(3 * SIZE).sampled(picture), picture[1::3, 1::3])


def test_a_sampled_mask_is_a_mask_and_a_sampled_field_is_float32() -> None:
    mask = lopsided()
    assert around(mask).sampled(mask).dtype == np.bool_
    assert around(mask).sampled(np.zeros((*mask.shape, 3))).dtype == np.float32


@pytest.mark.parametrize("azimuth", AZIMUTHS)
@pytest.mark.parametrize(
    "mask", [lopsided(), ellipse(100, 31).mask, ellipse(17, 24).mask], ids=["lopsided", "wide", "small"]
)
def test_the_object_fills_its_share_of_the_square_and_stands_in_the_middle(
    mask: np.ndarray, azimuth: float
) -> None:
    rows, columns = np.nonzero(around(mask, azimuth).sampled(mask))
    longer = max(np.ptp(rows), np.ptp(columns)) + 1
    # A turned pixel is up to the square root of two wide, and a pixel of the small one is two of the square.
    pixel = SIZE * FILL / (np.ptp(np.argwhere(mask), axis=0).max() + 1)
    assert abs(longer - FILL * SIZE) < 1.5 + pixel
    for place in (rows, columns):
        assert abs(place.min() + place.max() - (SIZE - 1)) <= 2 + pixel


@pytest.mark.parametrize("azimuth", AZIMUTHS)
def test_a_linear_field_is_spread_exactly(azimuth: float) -> None:
    mask = lopsided()
    square = around(mask, azimuth)
    slopes, constant = np.array([[0.3, -0.1], [0.02, 0.5], [-0.2, -0.4]]), np.array([1.0, -2.0, 0.5])
    row, column = np.mgrid[:SIZE, :SIZE]
    middle, pixel = (SIZE - 1) / 2, square.width / SIZE
    field = np.stack([column - middle, middle - row], axis=-1) * pixel @ slopes.T + constant
    rows, columns = np.nonzero(mask)
    places = np.stack([columns - square.column, square.row - rows, np.zeros(len(rows))], axis=-1)
    expected = square.turned(places)[:, :2] @ slopes.T + constant
    assert np.allclose(square.spread(field, MaskedGrid(mask)), expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("azimuth", AZIMUTHS)
def test_what_was_sampled_spreads_back_to_where_it_was(azimuth: float) -> None:
    mask = lopsided()
    square = around(mask, azimuth)
    row, column = np.mgrid[: mask.shape[0], : mask.shape[1]]
    picture = np.stack([row, column, row - column], axis=-1).astype(float)
    back = square.spread(square.sampled(picture), MaskedGrid(mask))
    within = square.spread(square.sampled(np.ones((*mask.shape, 3))), MaskedGrid(mask))[:, 0] == 1
    # The nearest pixel is at most half a pixel away along each axis, and so is any mean of such.
    reach = np.array([0.5, 0.5, 1.0]) + 1e-5
    assert within.mean() > 0.9  # the rest is mixed with what lies beyond the picture's edge
    assert (np.abs(back - picture[mask]) <= reach)[within].all()


@pytest.mark.parametrize("azimuth", AZIMUTHS)
def test_turned_and_turned_back_undo_each_other(azimuth: float) -> None:
    square = around(lopsided(), azimuth)
    vectors = np.random.default_rng(4).normal(size=(5, 6, 3))
    assert np.allclose(square.turned_back(square.turned(vectors)), vectors, atol=1e-14)
    assert np.allclose(square.turned(square.turned_back(vectors)), vectors, atol=1e-14)


@pytest.mark.parametrize("azimuth", AZIMUTHS)
def test_in_the_square_the_light_comes_from_the_right(azimuth: float) -> None:
    square = around(lopsided(), azimuth)
    assert square.turned(light_direction(azimuth, 25)) == pytest.approx(light_direction(0, 25), abs=1e-14)


def test_a_light_from_straight_ahead_turns_nothing() -> None:
    square = WorkingSquare.around(MaskedGrid(lopsided()), np.array([0.0, 0.0]))
    assert (square.cosine, square.sine) == (1.0, 0.0)


@pytest.mark.parametrize("azimuth", [0, 37, 143])
@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_turned_picture_under_a_turned_light_looks_the_same(quarters: int, azimuth: float) -> None:
    mask = lopsided()
    picture = numbered(mask) * mask
    turned = np.rot90(picture, quarters)
    seen = around(mask, azimuth).sampled(picture)
    assert np.array_equal(around(turned > 0, azimuth + 90 * quarters).sampled(turned), seen)


@pytest.mark.parametrize("azimuth", [0, 37, 143])
def test_a_mirrored_picture_under_a_mirrored_light_looks_upside_down(azimuth: float) -> None:
    mask = lopsided()
    picture = numbered(mask) * mask
    seen = around(mask, azimuth).sampled(picture)
    assert np.array_equal(around(mask[:, ::-1], 180 - azimuth).sampled(picture[:, ::-1]), seen[::-1])


def test_under_a_light_from_above_the_top_of_the_picture_is_on_the_right() -> None:
    mask = np.ones((40, 40), bool)
    seen = around(mask, 90).sampled(np.repeat(np.arange(40.0)[:, None], 40, axis=1))
    assert (seen[48, 4:92][::-1][1:] >= seen[48, 4:92][::-1][:-1]).all()
    assert seen[48, 90] < 2
    assert seen[48, 5] > 37


@pytest.mark.parametrize("azimuth", AZIMUTHS)
@pytest.mark.parametrize("shape", [(40, 30), (211, 300)])
def test_an_object_that_touches_the_edge_ends_there(shape: tuple[int, int], azimuth: float) -> None:
    mask = np.ones(shape, bool)
    square = around(mask, azimuth)
    seen, values = square.sampled(mask), square.sampled(np.ones(shape))
    assert np.array_equal(values == 1, seen)
    assert not values[~seen].any()
    # Nothing beyond the edge comes in again on the other side: the area is right to a pixel along the outline.
    area = seen.sum() * (square.width / SIZE) ** 2
    assert area == pytest.approx(mask.size, rel=0.02)
    assert square.spread(np.ones((SIZE, SIZE, 3)), MaskedGrid(mask)) == pytest.approx(1)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_every_pixel_of_the_object_lies_in_the_square(seed: int) -> None:
    mask = blob_mask(seed, 60)
    square = around(mask, 29)
    rows, columns = np.nonzero(mask)
    places = np.stack([columns - square.column, square.row - rows, 0 * rows], axis=-1)
    assert np.abs(square.turned(places)[:, :2]).max() < square.width / 2 * FILL + 1e-9


def test_a_wider_square_sees_the_object_smaller_around_the_same_center() -> None:
    square = around(lopsided(), 30)
    wider = square.widened(1.25)
    assert (wider.row, wider.column, wider.cosine) == (square.row, square.column, square.cosine)
    share = wider.sampled(lopsided()).sum() / square.sampled(lopsided()).sum()
    assert share == pytest.approx(1 / 1.25**2, rel=0.03)


@pytest.mark.parametrize("azimuth", AZIMUTHS)
@pytest.mark.parametrize("size", [SIZE, 2 * SIZE])
def test_spreading_interpolates_as_scipy_does_beyond_the_edge_too(azimuth: float, size: int) -> None:
    """Compiled here because scipy's takes seven times as long."""
    mask = lopsided()
    square = around(mask, azimuth).widened(0.7)
    field = np.random.default_rng(3).normal(size=(size, size, 3))
    down, right = np.nonzero(mask) - np.array([[square.row], [square.column]])
    scale, middle = size / square.width, (size - 1) / 2
    places = [
        (right * square.sine + down * square.cosine) * scale + middle,
        (right * square.cosine - down * square.sine) * scale + middle,
    ]
    slow = [map_coordinates(part, places, order=1, mode="nearest") for part in np.moveaxis(field, -1, 0)]
    assert square.spread(field, MaskedGrid(mask)) == pytest.approx(np.stack(slow, axis=-1), abs=1e-9)


@pytest.mark.parametrize("azimuth", AZIMUTHS)
def test_the_pixels_that_are_sampled_are_those_of_the_picture(azimuth: float) -> None:
    mask = lopsided()
    grid, picture = MaskedGrid(mask), numbered(mask)
    square = around(mask, azimuth)
    pixels = square.sampled_pixels(grid)
    assert np.array_equal(pixels != OUTSIDE, square.sampled(mask))
    seen = pixels != OUTSIDE
    assert np.array_equal(picture[mask][pixels[seen]], square.sampled(picture)[seen])
