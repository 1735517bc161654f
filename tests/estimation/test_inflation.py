import numpy as np
import pytest

from tests.analytic import ellipse
from toonkit import ToonkitError, angular_error, inflate


@pytest.mark.parametrize("antialiased", [True, False])
def test_a_disc_inflates_to_a_hemisphere_with_an_error_that_falls_as_one_over_the_radius(antialiased):
    errors = {}
    for radius in (16, 32, 64, 128):
        disc = ellipse(radius, radius)
        alpha = disc.coverage if antialiased else None
        errors[radius] = angular_error(inflate(disc.mask, alpha=alpha), disc.normals).mean
    assert errors[16] < 0.6
    for radius in (32, 64, 128):
        assert errors[radius] * radius <= errors[16] * 16


def test_the_error_on_a_disc_is_everywhere_small_also_at_the_rim():
    disc = ellipse(64, 64)
    error = angular_error(inflate(disc.mask, alpha=disc.coverage), disc.normals)
    assert error.percentile_95 < 0.2
    assert np.nanmax(error.map) < 2.5  # the outermost pixels, where one degree is a hundredth of a pixel


def test_every_component_and_hole_is_inflated_by_itself():
    small, large = ellipse(12, 12), ellipse(30, 30)
    height = max(small.mask.shape[0], large.mask.shape[0])
    parts = [np.pad(part.mask, ((0, height - part.mask.shape[0]), (2, 2))) for part in (small, large)]
    together = inflate(np.hstack(parts))
    alone = inflate(parts[1])
    assert np.allclose(together.vectors[:, parts[0].shape[1] :][parts[1]], alone.vectors[parts[1]], atol=1e-3)


def test_a_one_pixel_wide_line_has_normals():
    mask = np.zeros((9, 40), dtype=bool)
    mask[4, 3:37] = True
    vectors = inflate(mask).vectors[mask]
    assert np.isfinite(vectors).all()
    assert (np.abs(vectors[5:-5, 1]) < 0.1).all()


def test_a_mirrored_mask_has_mirrored_normals():
    mask = ellipse(20, 12).mask
    mask[:8] = False
    straight, mirrored = inflate(mask).vectors, inflate(mask[:, ::-1]).vectors[:, ::-1]
    inside = mask
    # The membrane is solved to 1e-5.
    assert np.allclose(straight[inside], (mirrored * [-1, 1, 1])[inside], atol=1e-3)


@pytest.mark.parametrize(
    ("mask", "words"),
    [
        (np.zeros((8, 8), bool), "empty"),
        (np.eye(8, dtype=bool) & (np.arange(8) == 3), "at least 9 pixels"),
        (np.ones((8, 8, 3)), "must be a"),
    ],
)
def test_a_mask_without_a_shape_is_refused(mask, words):
    with pytest.raises(ToonkitError, match=words):
        inflate(mask)


def test_alpha_must_have_the_masks_size_and_range():
    mask = ellipse(10, 10).mask
    with pytest.raises(ToonkitError, match="alpha must have the size"):
        inflate(mask, alpha=np.ones((3, 3)))
    with pytest.raises(ToonkitError, match="alpha must lie in"):
        inflate(mask, alpha=2.0 * mask)
