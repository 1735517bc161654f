import numpy as np
import pytest

from tests.analytic import LIGHT, TWO_TONE, ellipse, painted
from toonkit import (
    IlluminationInterval,
    NormalField,
    RefinementOptions,
    ToonkitError,
    fit_color_map,
    illumination,
    illumination_interval,
)
from toonkit.estimation.energy import LIMITS, printed_energy
from toonkit.estimation.refinement import refine, refine_as_printed
from toonkit.numerics.masked_grid import MaskedGrid

SHAPE = ellipse(24, 16)
MASK = SHAPE.mask


def everywhere(value: float) -> IlluminationInterval:
    bound = np.where(MASK, value, np.nan)
    return IlluminationInterval(bound, bound)


def true_interval() -> IlluminationInterval:
    image = painted(SHAPE.normals, TWO_TONE)
    return illumination_interval(image, fit_color_map(image, illumination(SHAPE.normals, LIGHT)))


def test_normals_whose_illumination_fits_hardly_move():
    refined = refine(SHAPE.normals, LIGHT, true_interval(), options=RefinementOptions(margin=0.0)).normals
    # True normals fit their own intervals but for the sample on either side of the step.
    assert np.abs(refined.vectors - SHAPE.normals.vectors)[MASK].max() < 0.02


def test_with_a_margin_no_pixel_that_was_moved_ends_on_a_bound():
    interval = true_interval()
    start = NormalField(SHAPE.normals.vectors * np.array([-1.0, 1.0, 1.0]), MASK)  # lit from the wrong side
    options = RefinementOptions(margin=0.05, change_length=1e-3, integrability_length=0.0, rim_hold=0.0)
    light = illumination(refine(start, LIGHT, interval, options=options).normals, LIGHT)
    moved = (interval.lower == -1) & (illumination(start, LIGHT) > interval.upper + 0.1)
    assert moved.sum() > 50
    # What had to become dark goes past the step by most of the margin.
    assert np.median((interval.upper - light)[moved]) > 0.04


def test_without_smoothness_the_printed_energy_is_the_shading_alone():
    grid, half = MaskedGrid(MASK), np.full(MASK.sum(), 0.5)
    energy = printed_energy(
        grid, SHAPE.normals.compact, LIGHT, IlluminationInterval(half, half), rho=20.0, smoothness=0.0
    )
    refined = refine_as_printed(energy, MASK, relaxation=1.0)
    assert np.nanmedian(np.abs(illumination(refined.normals, LIGHT) - 0.5)) < 0.01


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"alpha": np.ones((3, 3))}, "alpha must have the size"),
        ({"alpha": 2.0 * MASK}, r"alpha must lie in \[0, 1\]"),
        ({"interval": everywhere(np.inf)}, "interval.lower must be known and finite"),
        ({"interval": everywhere(1e300)}, r"interval.lower must lie in \[-2, 2\]"),
        ({"options": {"margin": 3}}, "options must be a RefinementOptions"),
        ({"light": [0, 0, 0]}, "zero vector"),
    ],
)
def test_what_cannot_be_refined_is_refused(arguments, words):
    given = {"light": LIGHT, "interval": everywhere(0.5), **arguments}
    with pytest.raises(ToonkitError, match=words):
        refine(SHAPE.normals, given.pop("light"), given.pop("interval"), **given)


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("margin", -1),
        ("change_length", np.nan),
        ("rim_hold", "much"),
        ("tolerance", 0),
        *((option, value) for option in LIMITS for value in (1e300, np.inf, -1e-300, 10**400)),
        *((option, 1e-300) for option in ("change_reach", "crease_turn", "color_jump", "tolerance")),
    ],
)
def test_an_option_without_meaning_is_refused(option, value):
    with pytest.raises(ToonkitError, match=option):
        RefinementOptions(**{option: value})


@pytest.mark.parametrize("end", [0, 1])
@pytest.mark.parametrize("option", LIMITS)
def test_an_option_at_its_limit_leaves_energies_finite_and_normals_of_unit_length(option, end):
    options = RefinementOptions(**{option: LIMITS[option][end]})
    refined = refine(SHAPE.normals, LIGHT, true_interval(), options=options)
    assert np.isfinite(refined.report.energies).all()
    assert np.linalg.norm(refined.normals.compact, axis=1) == pytest.approx(1, abs=1e-9)


def test_all_options_at_their_limits_leave_energies_finite():
    for end in (0, 1):
        options = RefinementOptions(**{option: limits[end] for option, limits in LIMITS.items()})
        assert np.isfinite(
            refine(SHAPE.normals, LIGHT, true_interval(), options=options).report.energies
        ).all()


def test_an_interval_whose_bounds_are_swapped_is_refused():
    with pytest.raises(ToonkitError, match="lower must not lie above upper"):
        IlluminationInterval(np.ones(3), np.zeros(3))


def test_a_guess_on_another_mask_is_refused():
    with pytest.raises(ToonkitError, match="guess must"):
        refine(SHAPE.normals, LIGHT, everywhere(0.5), guess=ellipse(16, 24).normals)


def test_from_its_own_answer_a_refinement_stands_still():
    interval = true_interval()
    once = refine(SHAPE.normals, LIGHT, interval, options=RefinementOptions(tolerance=1e-7))
    again = refine(
        SHAPE.normals, LIGHT, interval, options=RefinementOptions(tolerance=1e-7), guess=once.normals
    )
    # A ten-millionth of the energy is some thousandths of a normal.
    assert np.nanmax(np.abs(again.normals.vectors - once.normals.vectors)) < 5e-3


def test_a_change_dies_out_over_its_reach():
    interval = IlluminationInterval(np.where(MASK, -1.0, np.nan), np.where(MASK, 1.0, np.nan))
    middle = SHAPE.normals.vectors @ LIGHT > 0.97
    darker = IlluminationInterval(interval.lower, np.where(middle, 0.8, interval.upper))
    moved = []
    for reach in (0.02, 0.5):
        options = RefinementOptions(change_reach=reach, integrability_length=0.0)
        refined = refine(SHAPE.normals, LIGHT, darker, options=options).normals
        change = np.linalg.norm(refined.vectors - SHAPE.normals.vectors, axis=-1)
        moved.append(change[MASK & ~middle].mean())
    assert moved[0] < 0.5 * moved[1]
