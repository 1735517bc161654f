"""What the shape prior sees, what it does with an answer, and that the weights that ship know no direction or size."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.resolutions import apart, reduced
from tests.analytic import SOFT, TWO_TONE, Ellipse, ellipse, painted
from toonkit import NormalField, ToonImage, angular_error, inflate, light_direction
from toonkit.estimation import shape_prior
from toonkit.estimation.shape_prior import (
    CHANNELS,
    DAMPING,
    completed,
    correct_shape,
    features,
    material_borders,
    misfit,
)
from toonkit.estimation.working_square import SIZE

ELEVATION = np.deg2rad(38)
LIGHT = light_direction(118, 41)


def lit_drawing(bands: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Tones, mask and true normals, SIZE pixels wide, lit from the right and painted in some bands."""
    shape = ellipse((SIZE - 9) / 2, 30)
    normals = np.where(shape.mask[..., None], shape.normals.vectors, 0)
    band = np.floor((np.clip(illumination(normals), -1, 0.999) + 1) / 2 * bands)
    tones = np.where(shape.mask, (30 + 200 * band / bands) / 255, 0)
    return tones.astype(np.float32), shape.mask, normals


def uninked(tones: np.ndarray, mask: np.ndarray, *others: object) -> np.ndarray:
    """What is seen of a drawing in one material without ink."""
    return features(tones, mask, np.zeros_like(mask), None, *others)


def illumination(normals: np.ndarray) -> np.ndarray:
    return np.cos(ELEVATION) * normals[..., 0] + np.sin(ELEVATION) * normals[..., 2]


def flattened(normals: np.ndarray) -> np.ndarray:
    return completed(normals * [0.4, 1.3, 1.0])


def cut_ellipse(half_width: float, half_height: float) -> Ellipse:
    """An ellipse without its upper left quarter."""
    whole = ellipse(half_width, half_height)
    mask = whole.mask & ~((whole.x < 0.2 * half_width) & (whole.y > 0.1 * half_height))
    return Ellipse(mask, whole.coverage * mask, whole.x, whole.y, NormalField(whole.normals.vectors, mask))


def quarter_turned(vectors: np.ndarray, quarters: int) -> np.ndarray:
    cosine, sine = [(1, 0), (0, 1), (-1, 0), (0, -1)][quarters]
    return vectors @ np.array([[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1]])


def turned_picture(image: ToonImage, quarters: int) -> ToonImage:
    return ToonImage(np.rot90(image.color, quarters), np.rot90(image.mask, quarters))


def turned_normals(normals: NormalField, quarters: int) -> NormalField:
    turned = quarter_turned(np.rot90(normals.vectors, quarters), quarters)
    return NormalField(turned, np.rot90(normals.mask, quarters))


def random_weights(seed: int = 2, width: int = 4) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    shapes: dict[str, tuple[int, ...]] = {"stem": (width, 4 * CHANNELS, 3, 3), "out": (12, width, 3, 3)}
    for level in range(4):
        shapes |= {f"down.{level}.{part}": (width, width, 3, 3) for part in ("enter", "first", "second")}
        shapes |= {f"up.{level}.{part}": (width, width, 3, 3) for part in ("first", "second")}
        shapes[f"up.{level}.enter"] = (width, 2 * width, 1, 1)
    weights = {f"{name}.weight": rng.normal(0, 0.15, shape) for name, shape in shapes.items()}
    weights |= {f"{name}.bias": rng.normal(0, 0.1, shape[0]) for name, shape in shapes.items()}
    return {name: values.astype(np.float32) for name, values in weights.items()}


def answering(change: tuple[float, float, float]) -> object:
    """In the place of a network: the same change everywhere, in the square's axes."""
    return lambda weights, seen: np.broadcast_to(np.float32(change)[:, None, None], (3, SIZE, SIZE))


@pytest.mark.parametrize("bands", [2, 3, 8])
def test_on_the_true_normals_each_color_gets_the_illumination_it_was_painted_for(bands: int) -> None:
    tones, mask, normals = lit_drawing(bands)
    seen = uninked(tones, mask, normals, ELEVATION)
    truth = illumination(normals)
    assert np.abs(seen[4][mask] - truth[mask]).max() < 1e-6
    assert ((seen[5] - 1e-6 <= truth) & (truth <= seen[6] + 1e-6))[mask].all()
    for color in np.unique(tones[mask]):
        band = mask & (tones == color)
        assert seen[5][band] == pytest.approx(truth[band].min(), abs=1e-6)
        assert seen[6][band] == pytest.approx(truth[band].max(), abs=1e-6)


def test_on_wrong_normals_the_illumination_is_dealt_out_by_rank() -> None:
    tones, mask, normals = lit_drawing(3)
    wrong = flattened(normals)
    seen = uninked(tones, mask, wrong, ELEVATION)
    ordered = np.sort(illumination(wrong)[mask])
    dark = np.count_nonzero(tones[mask] == tones[mask].min())
    darkest, brightest = (mask & (tones == end(tones[mask])) for end in (np.min, np.max))
    assert seen[5][darkest] == pytest.approx(ordered[0], abs=1e-6)
    assert seen[6][darkest] == pytest.approx(ordered[dark - 1], abs=1e-6)
    assert seen[6][brightest] == pytest.approx(ordered[-1], abs=1e-6)
    assert (illumination(wrong) > seen[6] + 0.01)[mask].any()  # and it does contradict them


def test_nothing_is_seen_beside_the_object() -> None:
    tones, mask, normals = lit_drawing(3)
    noise = np.random.default_rng(1).random((SIZE, SIZE, 3)) * ~mask[..., None]
    seen = uninked(tones + noise[..., 0], mask, normals + noise, ELEVATION)
    assert seen.shape == (CHANNELS, SIZE, SIZE)
    assert seen.dtype == np.float32
    assert not seen[:, ~mask].any()
    assert np.array_equal(seen, uninked(tones, mask, normals, ELEVATION))


def test_the_object_sees_itself_its_normals_and_the_light() -> None:
    tones, mask, normals = lit_drawing(3)
    seen = uninked(tones, mask, normals, ELEVATION)
    assert np.array_equal(seen[0], mask)
    assert np.array_equal(seen[1:4, mask], normals[mask].T.astype(np.float32))
    assert seen[4][mask] == pytest.approx(illumination(normals)[mask], abs=1e-6)
    assert np.ptp(seen[7][mask]) == pytest.approx(1)
    assert seen[8][mask].mean() == pytest.approx(0.5, abs=1e-6)
    assert seen[9][mask] == pytest.approx(np.sin(ELEVATION))
    assert seen[10][mask] == pytest.approx(np.cos(ELEVATION))


def test_ink_and_borders_are_seen_on_the_object_alone() -> None:
    tones, mask, normals = lit_drawing(3)
    ink, borders = np.zeros((2, *mask.shape), np.bool_)
    ink[40:60], borders[:, 40:60] = True, True
    seen = features(tones, mask, ink, borders, normals, ELEVATION)
    assert np.array_equal(seen[11], ink & mask)
    assert np.array_equal(seen[12], borders & mask)
    assert np.array_equal(seen[:11], uninked(tones, mask, normals, ELEVATION)[:11])


def test_materials_meet_inside_the_object_and_not_at_its_outline() -> None:
    mask = np.zeros((SIZE, SIZE), np.bool_)
    mask[20:70, 10:80] = True
    labels = np.where(np.arange(SIZE) < 40, 0, 1) * np.ones((SIZE, 1))
    borders = material_borders(labels, mask)
    assert np.array_equal(np.flatnonzero(borders.any(axis=0)), [39])
    assert np.array_equal(borders[:, 39], mask[:, 39])
    assert not material_borders(np.where(mask, 0, -1), mask).any()


def test_the_same_drawing_is_always_seen_alike_and_left_as_it_was() -> None:
    arguments = lit_drawing(5)
    before = [argument.copy() for argument in arguments]
    first, second = uninked(*arguments, ELEVATION), uninked(*arguments, ELEVATION)
    assert np.array_equal(first, second)
    assert all(np.array_equal(now, then) for now, then in zip(arguments, before, strict=True))


def test_one_flat_tone_says_nothing_about_the_illumination() -> None:
    _, mask, normals = lit_drawing(3)
    seen = uninked(np.full(mask.shape, 0.4, np.float32), mask, normals, ELEVATION)
    shining = illumination(normals)[mask]
    assert seen[5][mask] == pytest.approx(shining.min(), abs=1e-6)
    assert seen[6][mask] == pytest.approx(shining.max(), abs=1e-6)
    assert not seen[7].any()


def test_completed_vectors_are_unit_and_face_the_viewer() -> None:
    vectors = np.random.default_rng(6).normal(size=(400, 3)) * [[1, 1, 0.5]]
    before, whole = vectors.copy(), completed(vectors)
    assert np.linalg.norm(whole, axis=1) == pytest.approx(1)
    assert (whole[:, 2] >= 0).all()
    facing = vectors[:, 2] > 0
    assert np.allclose(np.cross(whole, vectors)[facing], 0, atol=1e-12)
    assert not whole[~facing, 2].any()
    assert np.array_equal(vectors, before)
    assert not completed(np.zeros((2, 3))).any()


def test_a_network_that_answers_nothing_leaves_the_normals_as_they_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(shape_prior, "read_weights", lambda name: {})
    monkeypatch.setattr(shape_prior, "field", answering((0, 0, 0)))
    shape = cut_ellipse(60, 41)
    initial = inflate(shape.mask)
    corrected = correct_shape(painted(shape.normals, SOFT), LIGHT, initial)
    assert np.array_equal(corrected.mask, initial.mask)
    assert angular_error(corrected, initial).map[shape.mask].max() < 0.01


def test_normals_that_explain_the_picture_are_left_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shape_prior, "read_weights", lambda name: {})
    monkeypatch.setattr(shape_prior, "field", answering((0.3, 0.4, 0)))
    shape = cut_ellipse(60, 41)
    image = painted(shape.normals, TWO_TONE, light=LIGHT)
    right, wrong = shape.normals, inflate(shape.mask)
    moved = [angular_error(correct_shape(image, LIGHT, normals), normals).mean for normals in (right, wrong)]
    assert moved[0] < 0.05 * moved[1]
    assert moved[1] > 10


@pytest.mark.parametrize("azimuth", [0, 90, 143, 251])
def test_an_answer_along_the_squares_rows_leans_normals_toward_the_light(
    azimuth: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shape_prior, "read_weights", lambda name: {})
    monkeypatch.setattr(shape_prior, "field", answering((0.3, 0, 0)))
    shape = cut_ellipse(60, 41)
    light, initial = light_direction(azimuth, 40), inflate(shape.mask)
    corrected = correct_shape(painted(shape.normals, SOFT, light=light), light, initial)
    toward = light_direction(azimuth, 0)
    lean = ((corrected.vectors - initial.vectors) @ toward)[shape.mask]
    aside = ((corrected.vectors - initial.vectors) @ light_direction(azimuth + 90, 0))[shape.mask]
    assert (lean > -0.02).all()  # at the rim, the change of a neighboring pixel is taken
    assert lean.mean() > 0.15
    assert abs(aside.mean()) < 0.05


def test_the_network_is_asked_on_two_squares_of_which_one_is_mirrored(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = []

    def field(weights: object, seen: np.ndarray) -> np.ndarray:
        asked.append(seen.copy())
        return np.zeros((3, SIZE, SIZE), np.float32)

    monkeypatch.setattr(shape_prior, "read_weights", lambda name: {})
    monkeypatch.setattr(shape_prior, "field", field)
    shape = cut_ellipse(60, 41)
    light = light_direction(0, 41)
    correct_shape(painted(shape.normals, SOFT, light=light), light, inflate(shape.mask))
    assert len(asked) == 2
    assert len({np.ptp(np.flatnonzero(seen[0].any(axis=0))) for seen in asked}) == 2
    # The upper half is the one of which a quarter is cut off.
    halves = [seen[0].reshape(2, -1).sum(axis=1) for seen in asked]
    assert sorted(upper > lower for upper, lower in halves) == [False, True]


@pytest.mark.parametrize("wider", [1.0, 1.07])
def test_a_linear_field_is_resampled_exactly(wider: float) -> None:
    places = (np.arange(SIZE) - (SIZE - 1) / 2) / SIZE
    finer = (np.arange(2 * SIZE) - (2 * SIZE - 1) / 2) / (2 * SIZE) / wider
    field = np.stack([places[:, None] + 0 * places, 3 * places - places[:, None]], axis=-1)
    expected = np.stack([finer[:, None] + 0 * finer, 3 * finer - finer[:, None]], axis=-1)
    inside = np.abs(finer) < places.max()
    seen = shape_prior._resampled(field, wider, 2 * SIZE)
    assert np.allclose(seen[np.ix_(inside, inside)], expected[np.ix_(inside, inside)])


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_the_answer_turns_with_picture_and_light_whatever_the_network_is(
    quarters: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shape_prior, "read_weights", lambda name: random_weights())
    assert_turns_along(quarters, tolerance=0.01)


def assert_turns_along(quarters: int, *, tolerance: float) -> None:
    shape = cut_ellipse(60, 41)
    image, initial = painted(shape.normals, TWO_TONE, light=LIGHT), inflate(shape.mask)
    corrected = correct_shape(image, LIGHT, initial)
    assert angular_error(corrected, initial).mean > 1  # there is something to turn
    turned = correct_shape(
        turned_picture(image, quarters), quarter_turned(LIGHT, quarters), turned_normals(initial, quarters)
    )
    assert angular_error(turned, turned_normals(corrected, quarters)).map[turned.mask].max() < tolerance


@pytest.mark.parametrize("azimuth", [0, 25])
def test_a_line_thinner_than_the_squares_pixels_keeps_its_normals(
    azimuth: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shape_prior, "read_weights", lambda name: random_weights())
    mask = np.zeros((31, 640), bool)
    mask[15, 10:630] = True
    initial = inflate(mask)
    image = painted(initial, TWO_TONE, light=light_direction(azimuth, 40))
    corrected = correct_shape(image, light_direction(azimuth, 40), initial)
    assert np.isfinite(corrected.vectors[mask]).all()


# From here on with the weights that ship.


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_the_correction_turns_with_picture_and_light(quarters: int) -> None:
    assert_turns_along(quarters, tolerance=0.5)


def test_the_correction_is_the_same_at_twice_the_resolution() -> None:
    odd = painted(cut_ellipse(240, 168).normals, TWO_TONE, light=LIGHT)
    # Nothing was there; now the object begins at an even row and column, as that of an enlarged drawing does.
    large = ToonImage(odd.color[:-1, 1:], odd.mask[:-1, 1:], alpha=odd.alpha[:-1, 1:])
    corrected = [
        correct_shape(image, LIGHT, inflate(image.mask, alpha=image.alpha))
        for image in (reduced(large, 2), large)
    ]
    assert apart(*corrected, 2) < 0.5


@pytest.mark.parametrize("azimuth", [20, 250])  # the light falls along the cut, or onto what is left
def test_an_inflated_cut_ellipsoid_comes_nearer_to_the_truth(azimuth: float) -> None:
    """Inflation rounds the cut, where the ellipsoid goes on; its colors say so."""
    shape = cut_ellipse(110, 76)
    light, initial = light_direction(azimuth, 45), inflate(shape.mask)
    corrected = correct_shape(painted(shape.normals, SOFT, light=light), light, initial)
    before, after = (angular_error(normals, shape.normals).mean for normals in (initial, corrected))
    assert before > 10
    assert after < 0.8 * before


def test_a_light_in_doubt_is_told_by_less_of_its_sine_and_cosine() -> None:
    tones, mask, normals = lit_drawing(3)
    sure, doubted = (uninked(tones, mask, normals, ELEVATION, doubt) for doubt in (0.0, DAMPING))
    assert doubted[9:11][:, mask] == pytest.approx(np.exp(-1) * sure[9:11][:, mask])
    assert np.array_equal(np.delete(doubted, (9, 10), 0), np.delete(sure, (9, 10), 0))


def test_the_true_light_fits_better_than_others() -> None:
    shape = ellipse(60, 40)
    image = painted(shape.normals, SOFT, light=LIGHT, alpha=shape.coverage)
    azimuths = (118, 158, 78)
    lights = np.array([light_direction(azimuth, 41) for azimuth in azimuths])
    misfits = misfit(image, lights, inflate(shape.mask, alpha=shape.coverage))
    assert misfits.shape == (3,)
    assert 0 <= misfits[0] < 0.1 * misfits[1:].min()


def test_a_light_fits_a_picture_in_which_nothing_can_be_seen_no_better_than_any() -> None:
    mask = np.zeros((SIZE * 4, SIZE * 4), bool)
    mask[10, 10:-10] = True  # a line that the square's pixels miss
    image = ToonImage(np.full((*mask.shape, 3), 0.5), mask)
    vectors = np.where(mask[..., None], [0.0, 0.0, 1.0], np.nan)
    lights = np.array([light_direction(azimuth, 40) for azimuth in (0, 90)])
    misfits = misfit(image, lights, NormalField(vectors, mask))
    assert misfits[0] == misfits[1]
