"""Normal fields and their encoding as normal maps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from toonkit import NormalField, ToonkitError
from toonkit.model.normals import decode_normal_map, encode_normal_map

FULL = np.ones((4, 4), dtype=bool)


def flat(mask=FULL):
    return np.broadcast_to([0.0, 0.0, 1.0], (*mask.shape, 3)).copy()


@st.composite
def fields(draw):
    """Fields of 6 x 5 random normals in the half space that the viewer sees, with a hole in their mask."""
    raw = draw(arrays(float, (6, 5, 3), elements=st.floats(-1, 1)))
    raw[..., 2] = np.abs(raw[..., 2]) + 0.01  # never the zero vector
    mask = np.ones((6, 5), dtype=bool)
    mask[2, 3] = False
    return NormalField(raw / np.linalg.norm(raw, axis=-1, keepdims=True), mask)


def angles(one, other):
    """Angles in degrees between two fields, over the mask."""
    a, b = one.vectors[one.mask], other.vectors[one.mask]
    return np.rad2deg(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1)))


@given(fields())
def test_normals_are_unit_inside_the_mask_and_nan_outside(field):
    assert np.isnan(field.vectors[~field.mask]).all()
    assert np.linalg.norm(field.vectors[field.mask], axis=1) == pytest.approx(1, abs=1e-14)


@given(fields())
def test_a_field_made_of_a_fields_vectors_equals_it_to_the_last_bit(field):
    assert np.array_equal(NormalField(field.vectors, field.mask).vectors, field.vectors, equal_nan=True)


@given(fields())
def test_the_image_of_vectors_holds_the_compact_ones_in_row_major_order(field):
    again = NormalField.of_pixels(field.compact, field.mask)
    assert np.array_equal(again.vectors, field.vectors, equal_nan=True)
    assert np.array_equal(field.vectors[field.mask], field.compact)
    assert again.vectors is again.vectors  # made once


def test_rounded_unit_vectors_are_renormalized():
    field = NormalField(flat() * 1.0005, FULL)
    assert (field.vectors[..., 2] == 1).all()


def test_the_vectors_given_are_not_changed():
    vectors = flat() * 1.0005
    NormalField(vectors, FULL)
    assert (vectors[..., 2] == 1.0005).all()


def test_values_outside_the_mask_do_not_matter():
    mask = FULL.copy()
    mask[0, 0] = False
    vectors = flat()
    vectors[0, 0] = (np.inf, 7, -3)
    assert np.isnan(NormalField(vectors, mask).vectors[0, 0]).all()


@pytest.mark.parametrize(
    ("vector", "reason"),
    [
        ((0, 0, 1.01), "unit length"),
        ((0, 0, 0), "unit length"),
        ((0, 0.6, -0.8), "face the viewer"),
        ((np.nan, 0, 1), "finite"),
        ((np.inf, 0, 1), "finite"),
    ],
)
def test_what_is_no_visible_normal_is_refused(vector, reason):
    vectors = flat()
    vectors[1, 2] = vector
    with pytest.raises(ToonkitError, match=f"vectors must .*{reason}"):
        NormalField(vectors, FULL)


def test_a_mask_of_another_size_is_refused():
    with pytest.raises(ToonkitError, match="mask must have the size of vectors"):
        NormalField(flat(), np.ones((4, 5), dtype=bool))


# Rounding moves each channel by at most half a step of 2 / (2^bits - 1); over three channels that turns a
# unit vector by at most sqrt(3) half steps, and once more when a coordinate below zero is cut off at the rim.
@pytest.mark.parametrize(("bits", "degrees"), [(8, 0.39), (16, 0.0016)])
@pytest.mark.parametrize("green", ["opengl", "directx"])
@given(field=fields())
def test_a_normal_map_turns_no_normal_by_more_than_rounding(bits, degrees, green, field):
    colors = encode_normal_map(field, bits=bits, green=green)
    assert angles(decode_normal_map(colors, field.mask, green=green), field).max() <= degrees


@pytest.mark.parametrize(("bits", "dtype"), [(8, np.uint8), (16, np.uint16)])
def test_a_flat_surface_is_encoded_as_half_half_full(bits, dtype):
    colors = encode_normal_map(NormalField(flat(), FULL), bits=bits)
    top = 2**bits - 1
    assert colors.dtype == dtype
    assert colors[0, 0].tolist() == pytest.approx([top / 2, top / 2, top], abs=0.5)


@given(fields(), st.sampled_from([8, 16]))
def test_directx_is_opengl_with_green_flipped(field, bits):
    opengl = encode_normal_map(field, bits=bits).astype(int)
    directx = encode_normal_map(field, bits=bits, green="directx").astype(int)
    assert (opengl[..., ::2] == directx[..., ::2]).all()
    # A half rounds to even, so that the two add up to full scale give or take one step.
    assert np.abs(opengl[..., 1] + directx[..., 1] - (2**bits - 1)).max() <= 1


def test_a_surface_that_faces_up_is_green_in_opengl():
    vectors = np.broadcast_to([0.0, 0.6, 0.8], (4, 4, 3))
    field = NormalField(vectors, FULL)
    assert (encode_normal_map(field)[..., 1] == round(1.6 * 127.5)).all()
    assert (encode_normal_map(field, green="directx")[..., 1] == round(0.4 * 127.5)).all()


def test_outside_the_mask_a_normal_map_is_flat():
    mask = FULL.copy()
    mask[0, 0] = False
    vectors = np.broadcast_to([0.6, 0.0, 0.8], (4, 4, 3))
    assert encode_normal_map(NormalField(vectors, mask))[0, 0].tolist() == [128, 128, 255]


@pytest.mark.parametrize("bad", [{"bits": 12}, {"green": "up"}])
def test_other_encodings_are_refused(bad):
    with pytest.raises(ToonkitError, match=f"{next(iter(bad))} must be"):
        encode_normal_map(NormalField(flat(), FULL), **bad)


def test_a_map_with_depth_from_zero_to_one_is_told_from_ours():
    colors = np.full(
        (4, 4, 3), 128, dtype=np.uint8
    )  # blue 128 is z = 0 here, and 0.5 in the other convention
    with pytest.raises(ToonkitError, match="must encode unit vectors with z from -1"):
        decode_normal_map(colors, FULL)


def test_floats_are_no_normal_map():
    with pytest.raises(ToonkitError, match="uint8 or uint16"):
        decode_normal_map(np.full((4, 4, 3), 0.5), FULL)
