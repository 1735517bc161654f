"""A stroke over one material gives its colors, dark to bright."""

from __future__ import annotations

import numpy as np
import pytest

from toonkit import ColorMap, ToonImage, ToonkitError, extract_color_map
from toonkit.export.color_map import read_color_map, write_color_map
from toonkit.model.luminance import luminance

ROUNDING = 1e-12  # a plateau is computed from the same numbers at each of its samples, up to rounding


def graded_picture(size: int = 40) -> ToonImage:
    """A drawing that goes from violet at the left to cream at the right, empty in its top quarter."""
    ramp = ColorMap([[0.25, 0.1, 0.35], [0.8, 0.4, 0.4], [1.0, 0.9, 0.7]])
    mask = np.ones((size, size), dtype=bool)
    mask[: size // 4] = False
    return ToonImage(np.repeat(ramp(np.linspace(-1, 1, size))[None], size, axis=0), mask)


def row_stroke(size: int, row: int) -> np.ndarray:
    stroke = np.zeros((size, size), dtype=bool)
    stroke[row] = True
    return stroke


def test_a_stroke_along_the_gradient_gives_its_colors_back_in_order() -> None:
    picture = graded_picture()
    found = extract_color_map(picture, row_stroke(40, 20))
    assert found.domain == (-1.0, 1.0)
    # To linear light and back.
    assert np.abs(found.colors - picture.color[20]).max() < 1e-9


def test_the_order_of_pixels_under_a_stroke_does_not_matter() -> None:
    picture = graded_picture()
    mirrored = ToonImage(picture.color[:, ::-1], picture.mask)
    found = extract_color_map(mirrored, row_stroke(40, 30))
    assert np.array_equal(found.colors, extract_color_map(picture, row_stroke(40, 30)).colors)


def test_a_large_stroke_gives_at_most_1024_samples_that_never_get_darker() -> None:
    noise = np.random.default_rng(5).uniform(size=(64, 64, 3))
    found = extract_color_map(ToonImage(noise, np.ones((64, 64), dtype=bool)), np.ones((64, 64), dtype=bool))
    assert found.colors.shape == (1024, 3)
    assert np.diff(luminance(found.colors)).min() >= -ROUNDING


def test_two_pixels_are_enough_for_a_color_map() -> None:
    stroke = np.zeros((40, 40), dtype=bool)
    stroke[20, [39, 0]] = True
    picture = graded_picture()
    assert np.abs(extract_color_map(picture, stroke).colors - picture.color[20, [0, 39]]).max() < 1e-9


def test_what_a_stroke_touches_outside_the_object_is_ignored() -> None:
    picture = graded_picture()
    stroke = row_stroke(40, 20)
    along = extract_color_map(picture, stroke)
    stroke[:10] = True
    assert np.array_equal(extract_color_map(picture, stroke).colors, along.colors)


def test_pixels_that_the_object_covers_in_part_stay_out_of_the_color_map() -> None:
    picture = graded_picture()
    alpha = picture.mask.astype(float)
    alpha[20, :8] = 0.6
    found = extract_color_map(ToonImage(picture.color, picture.mask, alpha=alpha), row_stroke(40, 20))
    assert len(found.colors) == 32


@pytest.mark.parametrize(
    ("stroke", "complaint"),
    [
        (
            np.ones((40, 41), dtype=bool),
            r"stroke must have the size of the picture \(40, 40\); got \(40, 41\)",
        ),
        (np.ones((40, 40, 3), dtype=bool), r"stroke must be a \(H, W\) bool array"),
        (
            np.ones((40, 40)),
            r"stroke must be a \(H, W\) bool array, such as array > 0; got an array of shape \(40, 40\)",
        ),
        (row_stroke(40, 3), "stroke must pass over the object; got 40 pixels, none of them on it"),
        (np.zeros((40, 40), dtype=bool), "stroke must pass over the object"),
        (np.arange(1600).reshape(40, 40) == 800, "stroke must pass over at least 2 object pixels; got 1"),
    ],
)
def test_a_stroke_that_takes_no_color_map_is_refused(stroke: np.ndarray, complaint: str) -> None:
    with pytest.raises(ToonkitError, match=complaint):
        extract_color_map(graded_picture(), stroke)


def test_an_extracted_color_map_survives_as_a_strip(tmp_path) -> None:
    found = extract_color_map(graded_picture(), row_stroke(40, 20))
    write_color_map(found, tmp_path / "ramp.png")
    again = read_color_map(tmp_path / "ramp.png")
    where = np.linspace(-0.99, 0.99, 100)
    assert np.abs(again(where) - found(where)).max() < 0.01  # 8 bits, and 512 columns
