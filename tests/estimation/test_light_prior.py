"""What the light prior sees, how it is asked in eight ways, and what it makes of the answers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import vonmises_fisher

from tests.analytic import SOFT, ellipse, painted
from toonkit import NormalField, ToonImage, inflate, light_direction
from toonkit.estimation import light_prior
from toonkit.estimation.light_prior import (
    CHANNELS,
    LightBelief,
    believed_light,
    concentration,
    features,
    turned,
)
from toonkit.estimation.turn import TURNS, Turn
from toonkit.estimation.working_square import SIZE

LIGHT = light_direction(32, 41)


def uninked(tones: np.ndarray, mask: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """What is seen of a drawing without ink."""
    return features(tones, mask, np.zeros_like(mask), normals)


def drawing() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Tones, mask and normals, SIZE pixels wide, of a shape without symmetry."""
    whole = ellipse((SIZE - 9) / 2, 30)
    mask = whole.mask.copy()
    mask[:45, :30] = False
    normals = np.where(mask[..., None], whole.normals.vectors, 0)
    tones = np.rint(np.clip(normals @ LIGHT, 0, 1) * 60) / 255
    return tones.astype(np.float32), mask, normals.astype(np.float32)


def picture(quarters: int = 0) -> tuple[ToonImage, NormalField]:
    """A painting of it at another size, and initial normals, turned counter-clockwise."""
    whole = ellipse(60, 40)
    mask = whole.mask.copy()
    mask[:60, :45] = False
    image = painted(NormalField(whole.normals.vectors, mask), SOFT, light=LIGHT)
    image = ToonImage(np.rot90(image.color, quarters), np.rot90(mask, quarters))
    initial = np.rot90(inflate(mask).vectors, quarters)
    return image, NormalField(turned_vectors(initial, quarters), image.mask)


def turned_vectors(vectors: np.ndarray, quarters: int) -> np.ndarray:
    cosine, sine = [(1, 0), (0, 1), (-1, 0), (0, -1)][quarters]
    return vectors @ np.array([[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1]])


def random_weights(seed: int = 4) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    shapes = {"stem": (4, 4 * (CHANNELS - 1), 3, 3), "hidden": (9, 8), "out": (4, 9)}
    for level in range(4):
        shapes |= {f"down.{level}.{part}": (4, 4, 3, 3) for part in ("enter", "first", "second")}
    weights = {f"{name}.weight": rng.normal(0, 0.3, shape) for name, shape in shapes.items()}
    weights |= {f"{name}.bias": rng.normal(0, 0.1, shape[0]) for name, shape in shapes.items()}
    ink = np.random.default_rng(seed).normal(0, 0.3, (4, 4, 3, 3))
    weights["stem.weight"] = np.concatenate([weights["stem.weight"], ink], axis=1)
    return {name: values.astype(np.float32) for name, values in weights.items()}


def brightest_side(weights: object, seen: np.ndarray) -> np.ndarray:
    """In the place of a network: the sum of N0 weighted by tone turns as the picture does."""
    del weights
    return np.append((seen[1:4] * seen[4]).sum(axis=(1, 2)), 3.0)


def test_nothing_is_seen_beside_the_object() -> None:
    tones, mask, normals = drawing()
    seen = uninked(tones + ~mask, mask, normals + ~mask[..., None])
    assert seen.shape == (CHANNELS, SIZE, SIZE)
    assert seen.dtype == np.float32
    assert not seen[:, ~mask].any()
    assert np.array_equal(seen[0], mask)
    assert np.array_equal(seen[1:4], np.moveaxis(normals, -1, 0))


@pytest.mark.parametrize(("factor", "offset"), [(2, 0), (3, 0), (1, 100), (2, 51)])
def test_a_brighter_painting_looks_the_same(factor: int, offset: int) -> None:
    tones, mask, normals = drawing()
    seen, brighter = (
        uninked(t.astype(np.float32), mask, normals) for t in (tones, factor * tones + offset / 255)
    )
    assert np.ptp(seen[4]) == 1
    assert np.abs(seen - brighter).max() < 1e-5  # rounding


def test_the_rank_of_a_color_is_the_share_of_darker_pixels_and_half_of_its_own() -> None:
    tones, mask, normals = drawing()
    seen = uninked(tones, mask, normals)
    painting = tones[mask]
    expected = [(painting < t).mean() + (painting == t).mean() / 2 for t in painting]
    assert seen[5][mask] == pytest.approx(np.array(expected), abs=1e-6)
    assert seen[5][mask].mean() == pytest.approx(0.5, abs=1e-6)


def test_ink_is_seen_on_the_object_alone() -> None:
    tones, mask, normals = drawing()
    ink = np.zeros_like(mask)
    ink[40:60] = True
    seen = features(tones, mask, ink, normals)
    assert np.array_equal(seen[6], ink & mask)
    assert np.array_equal(seen[:6], uninked(tones, mask, normals)[:6])


def test_one_flat_tone_is_no_division_by_zero() -> None:
    _, mask, normals = drawing()
    seen = uninked(np.full(mask.shape, 0.4, np.float32), mask, normals)
    assert not seen[4].any()
    assert (seen[5][mask] == 0.5).all()


@pytest.mark.parametrize("turn", TURNS)
def test_what_turns_with_the_drawing_comes_back(turn: Turn) -> None:
    seen = uninked(*drawing())
    straight = brightest_side(None, seen)
    answer = turn.vectors_back(brightest_side(None, turned(seen, turn))[:3])
    assert answer == pytest.approx(straight[:3], rel=1e-4)


@pytest.mark.parametrize("quarters", range(4))
@pytest.mark.parametrize("mirrored", [False, True])
def test_turned_features_are_those_of_a_turned_drawing(mirrored: bool, quarters: int) -> None:
    """Its N0 is inflated anew: no rotation of vectors is taken on trust."""
    tones, mask, _ = drawing()
    seen = uninked(tones, mask, np.nan_to_num(inflate(mask).vectors).astype(np.float32))
    tones, mask = (np.rot90(part[:, ::-1] if mirrored else part, quarters) for part in (tones, mask))
    expected = uninked(tones, mask, np.nan_to_num(inflate(mask).vectors).astype(np.float32))
    assert np.allclose(
        turned(seen, TURNS[quarters + 4 * mirrored]), expected, atol=2e-3
    )  # the membrane is solved to 1e-5


def test_the_eight_turns_are_eight_different_views_and_leave_the_features_alone() -> None:
    seen = uninked(*drawing())
    before = seen.copy()
    views = [turned(seen, turn) for turn in TURNS]
    assert np.array_equal(seen, before)
    assert len(views) == 8
    assert all(np.abs(views[i] - views[j]).max() > 0.1 for i in range(8) for j in range(i))


@pytest.mark.parametrize("raw", [-50.0, -4.0, 0.0, 3.0, 8.0, 1e6])
def test_concentration_is_finite_and_never_zero(raw: float) -> None:
    assert 0.05 < concentration(raw) < 3000
    assert concentration(raw) <= concentration(raw + 0.1)


@pytest.mark.parametrize("kappa", [0.051, 1.0, 30.0, 2900.0])
def test_probability_rises_from_none_at_the_mean_to_one_all_around(kappa: float) -> None:
    belief = LightBelief(LIGHT, kappa)
    probability = [belief.probability_within(degrees) for degrees in np.linspace(0, 180, 721)]
    assert (np.diff(probability) >= 0).all()
    assert probability[0] == 0
    assert probability[-1] == 1
    assert probability[1] > 0


@pytest.mark.parametrize("kappa", [0.051, 1.0, 30.0, 2900.0])
def test_probability_is_the_share_of_draws_of_a_von_mises_fisher_distribution(kappa: float) -> None:
    draws = vonmises_fisher(LIGHT, kappa).rvs(20_000, random_state=np.random.default_rng(3))
    away = np.rad2deg(np.arccos(np.clip(draws @ LIGHT, -1, 1)))
    for degrees in np.quantile(away, [0.05, 0.25, 0.5, 0.75, 0.95]):
        # Four standard deviations of a share among so many draws.
        assert LightBelief(LIGHT, kappa).probability_within(degrees) == pytest.approx(
            (away <= degrees).mean(), abs=0.015
        )


def test_answers_that_agree_are_as_sure_together_as_each_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(light_prior, "read_weights", lambda name: {})
    monkeypatch.setattr(light_prior, "summary", brightest_side)
    belief = believed_light(*picture())
    assert belief.concentration == pytest.approx(0.05 + np.exp(3), rel=1e-4)
    assert np.linalg.norm(belief.light) == pytest.approx(1)
    assert (
        np.rad2deg(
            np.arccos(belief.light[:2] @ LIGHT[:2] / np.linalg.norm(belief.light[:2]) / np.hypot(*LIGHT[:2]))
        )
        < 30
    )


def test_answers_that_do_not_turn_with_the_drawing_cancel_and_are_not_sure(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(light_prior, "read_weights", lambda name: {})
    monkeypatch.setattr(light_prior, "summary", lambda weights, seen: np.array([3.0, 0.0, 3.0, 8.0]))
    belief = believed_light(*picture())
    assert belief.light == pytest.approx([0, 0, 1], abs=1e-12)
    assert belief.concentration < 4  # each of them stands 45 degrees from the mean


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_the_light_turns_with_the_picture_whatever_the_network_is(
    quarters: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(light_prior, "read_weights", lambda name: random_weights())
    straight, turned_picture = believed_light(*picture()), believed_light(*picture(quarters))
    assert np.hypot(*straight.light[:2]) > 0.5  # there is something to turn
    assert turned_picture.light == pytest.approx(turned_vectors(straight.light, quarters), abs=1e-4)
    assert turned_picture.concentration == pytest.approx(straight.concentration, rel=1e-3)


def test_of_a_line_thinner_than_the_squares_pixels_something_is_believed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(light_prior, "read_weights", lambda name: random_weights())
    mask = np.zeros((31, 640), bool)
    mask[15, 10:630] = True
    initial = inflate(mask)
    belief = believed_light(painted(initial, SOFT, light=LIGHT), initial)
    assert np.linalg.norm(belief.light) == pytest.approx(1)
    assert 0 < belief.concentration < 3000
