"""Pixels copied as wholes are those that NumPy's own masks copy."""

import numpy as np
import pytest

from toonkit.model.whole_pixels import opaque, pixels_at, put_pixels


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_pixels_are_taken_from_a_part_of_an_image_and_put_back(dtype: type, channels: int) -> None:
    rng = np.random.default_rng(3)
    image = (255 * rng.random((20, 30, channels))).astype(dtype)[3:17, 5:26]
    mask = rng.random(image.shape[:2]) < 0.4
    taken = pixels_at(image, mask)
    assert taken.dtype == dtype
    assert np.array_equal(taken, image[mask])
    expected = np.zeros_like(image)
    expected[mask] = image[mask] // 2
    target = np.zeros_like(image)
    put_pixels(target, mask, taken // 2)
    assert np.array_equal(target, expected)


def test_one_pixel_fills_a_mask_and_is_converted_to_the_type_of_the_image() -> None:
    image, mask = np.zeros((2, 2, 3), np.uint8), np.array([[True, False], [False, True]])
    put_pixels(image, mask, np.array([1.0, 2.0, 3.0]))
    assert image.tolist() == [[[1, 2, 3], [0, 0, 0]], [[0, 0, 0], [1, 2, 3]]]


def test_opaque_colors_have_full_alpha() -> None:
    assert opaque(np.array([[1, 2, 3]], np.uint8)).tolist() == [[1, 2, 3, 255]]
