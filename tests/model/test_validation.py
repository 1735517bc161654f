"""The door: arguments are coerced to float64 and bool, or refused by name, rule and value."""

import numpy as np
import pytest

from toonkit import ToonkitError
from toonkit._validation import MIN_OBJECT_PIXELS, as_array, as_light, as_mask, is_number, refuse, same_shape


def test_a_refusal_names_argument_rule_and_value():
    error = refuse("elevation", "must be positive", -3)
    assert isinstance(error, ToonkitError)
    assert isinstance(error, ValueError)
    assert str(error) == "elevation must be positive; got -3"


@pytest.mark.parametrize("dtype", [bool, np.uint8, np.int64, np.float16, np.float32, np.float64])
def test_any_real_dtype_becomes_float64(dtype):
    array = as_array("values", np.ones((2, 3), dtype=dtype), (None, 3))
    assert array.dtype == np.float64
    assert (array == 1).all()


def test_the_array_returned_shares_no_memory_with_the_one_given():
    given = np.ones(3)
    as_array("values", given, (3,))[:] = 7
    assert given.tolist() == [1, 1, 1]


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        ([1, 2], r"must have shape \(3\); got \(2,\)"),
        (5, r"must have shape \(3\)"),
        ([[1, 2, 3]], r"must have shape \(3\)"),
        (["a", "b", "c"], "must hold real numbers"),
        ([1j, 0, 0], "must hold real numbers"),
        ([None, 0, 0], "must hold real numbers"),
        ([[1], [1, 2]], "rectangular array"),
    ],
)
def test_what_is_no_real_array_of_the_shape_is_refused(value, reason):
    with pytest.raises(ToonkitError, match=f"values {reason}|values must be a {reason}"):
        as_array("values", value, (3,))


@pytest.mark.parametrize("dtype", [bool, np.uint8, float])
def test_a_mask_is_true_where_it_is_not_zero(dtype):
    given = np.zeros((5, 5), dtype=dtype)
    given[1:4, 1:4] = 1
    mask = as_mask("mask", given)
    assert mask.dtype == bool
    assert mask.sum() == 9


def test_the_smallest_mask_has_an_interior():
    assert MIN_OBJECT_PIXELS == 9
    with pytest.raises(ToonkitError, match="at least 9 pixels to have a shape; got 8"):
        as_mask("mask", np.ones((2, 4)))


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        (np.zeros((4, 4)), "must contain the object"),
        (np.ones(16), r"must be a \(H, W\) array"),
        (np.ones((4, 4, 3)), r"must be a \(H, W\) array"),
        (np.full((4, 4), np.nan), "must be finite; got 16 NaN"),
        ([["a"]], r"must be a \(H, W\) array"),
        (None, r"must be a \(H, W\) array"),
    ],
)
def test_what_is_no_mask_is_refused(value, reason):
    with pytest.raises(ToonkitError, match=f"mask {reason}"):
        as_mask("mask", value)


def test_a_mask_of_another_size_than_its_picture_is_refused():
    with pytest.raises(ToonkitError, match=r"mask must have the picture's size \(4, 5\); got \(4, 4\)"):
        as_mask("mask", np.ones((4, 4)), (4, 5))


def test_a_light_becomes_a_unit_vector():
    assert as_light("light", (0, 3, 4)).tolist() == [0, 0.6, 0.8]


@pytest.mark.parametrize("value", [0, 1.5, np.float32(2), np.int8(3), True])
def test_finite_reals_are_numbers(value):
    assert is_number(value)


@pytest.mark.parametrize("value", [np.nan, np.inf, "1", None, [1], 1j])
def test_other_things_are_no_numbers(value):
    assert not is_number(value)


def test_arguments_of_different_sizes_are_refused():
    same_shape("mask", (2, 3), (2, 3), "color")
    with pytest.raises(ToonkitError, match=r"mask must have the size of color \(2, 3\); got \(3, 2\)"):
        same_shape("mask", (3, 2), (2, 3), "color")


@pytest.mark.parametrize("light", [[1e200, 0, 1e200], [1e-200, 0, 1e-200], [1, 0, 1]])
def test_a_light_of_any_length_is_a_direction(light):
    assert np.allclose(as_light("light", light), [np.sqrt(0.5), 0, np.sqrt(0.5)])


def test_a_light_in_the_image_plane_may_be_rounded_to_just_behind_it():
    assert as_light("light", [1, 0, np.sin(2 * np.pi)])[2] == 0.0


@pytest.mark.parametrize("mask", [np.linspace(0, 1, 100).reshape(10, 10), -np.ones((10, 10))])
def test_a_mask_says_yes_or_no(mask):
    with pytest.raises(ToonkitError, match="mask must be True or False everywhere"):
        as_mask("mask", mask)


def test_a_ragged_mask_is_refused():
    with pytest.raises(ToonkitError, match="rows of different lengths"):
        as_mask("mask", [[1, 0], [1]])
