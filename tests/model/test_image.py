"""ToonImage: what belongs to the object, and what does not."""

import numpy as np
import pytest

from toonkit import ToonImage, ToonkitError

MASK = np.zeros((6, 7), dtype=bool)
MASK[1:5, 2:6] = True
COLOR = np.broadcast_to([0.8, 0.4, 0.2], (6, 7, 3))


def test_nothing_outside_the_mask_is_a_color():
    image = ToonImage(COLOR, MASK)
    assert np.isnan(image.color[~MASK]).all()
    assert image.color[MASK] == pytest.approx(COLOR[MASK])
    assert image.shape == (6, 7)


def test_without_alpha_the_mask_is_opaque_and_the_rest_transparent():
    rgba = ToonImage(COLOR, MASK).to_rgba()
    assert ((rgba[..., 3] == 255) == MASK).all()
    assert (rgba[~MASK] == 0).all()
    assert rgba[2, 3].tolist() == [204, 102, 51, 255]


def test_an_outline_pixel_takes_the_nearest_object_color_unless_told():
    alpha = MASK.astype(float)
    alpha[0, 2] = 0.25
    assert ToonImage(COLOR, MASK, alpha=alpha).to_rgba()[0, 2].tolist() == [204, 102, 51, 64]
    fringe = np.zeros((6, 7, 3))
    assert ToonImage(COLOR, MASK, alpha=alpha, fringe=fringe).to_rgba()[0, 2].tolist() == [0, 0, 0, 64]


def test_fringe_is_kept_only_where_the_object_touches():
    alpha = MASK.astype(float)
    alpha[0, 2] = 0.25
    image = ToonImage(COLOR, MASK, alpha=alpha, fringe=np.zeros((6, 7, 3)))
    assert np.argwhere(np.isfinite(image.fringe).all(axis=-1)).tolist() == [[0, 2]]


def test_arguments_are_not_changed():
    color, mask = COLOR.copy(), MASK.copy()
    ToonImage(color, mask)
    assert (color == COLOR).all()
    assert (mask == MASK).all()


def _with(array, index, value):
    changed = np.array(array, dtype=float)
    changed[index] = value
    return changed


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ({"color": COLOR[..., 0]}, "color must have shape"),
        ({"mask": MASK[:, :-1]}, "mask must have the size of color"),
        ({"mask": np.zeros_like(MASK)}, "must contain the object"),
        ({"color": _with(COLOR, (2, 3), np.nan)}, "painted on every object pixel"),
        ({"color": _with(COLOR, (2, 3), 1.2)}, r"sRGB in \[0, 1\]"),
        ({"color": COLOR * 255}, r"sRGB in \[0, 1\]"),
        ({"alpha": _with(MASK, (0, 0), 1.5)}, r"alpha must lie in \[0, 1\]"),
        ({"alpha": _with(MASK, (0, 0), np.nan)}, r"alpha must lie in \[0, 1\]"),
        ({"alpha": np.ones((3, 3))}, "alpha must have the size of the picture"),
        ({"alpha": np.ones(MASK.shape), "fringe": _with(COLOR, (0, 0), np.nan)}, "fringe must be painted"),
    ],
)
def test_what_is_no_picture_is_refused(arguments, reason):
    given = {"color": COLOR, "mask": MASK, **arguments}
    color, mask = given.pop("color"), given.pop("mask")
    with pytest.raises(ToonkitError, match=reason):
        ToonImage(color, mask, **given)


def test_a_picture_like_another_one_shares_its_outline_and_has_a_fringe_when_asked():
    alpha = MASK.astype(float)
    alpha[0, 2] = alpha[5, 5] = 0.25
    image = ToonImage(COLOR, MASK, alpha=alpha, fringe=np.full((6, 7, 3), 0.5))
    other = ToonImage.like(image, np.full((MASK.sum(), 3), 0.1), np.array([[0.2] * 3, [0.3] * 3]))
    assert other.mask is image.mask
    assert other.alpha is image.alpha
    rgba = other.to_rgba()
    assert rgba[0, 2].tolist() == [51, 51, 51, 64]
    assert other.fringe[5, 5].tolist() == [0.3] * 3
    assert np.array_equal(other.color[MASK], other.pixels)
    assert np.isnan(other.color[~MASK]).all()
    assert np.isnan(other.fringe[MASK]).all()
    assert np.array_equal(ToonImage(other.color, MASK, alpha=alpha, fringe=other.fringe).to_rgba(), rgba)
    with pytest.raises(AttributeError, match="frnge"):
        _ = other.frnge
