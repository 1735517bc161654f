"""What a person says about a shape: parts that bulge, are flat or in front, and normals at points."""

from dataclasses import replace

import numpy as np
import pytest

from tests.analytic import LIGHT, SOFT, TWO_TONE, ellipse, painted
from tests.reference_energies import energy_value
from toonkit import (
    METHODS,
    NormalField,
    NormalHint,
    RefinementOptions,
    ShapeCorrections,
    ToonImage,
    ToonkitError,
    analyze,
    angular_error,
    illumination_interval,
    inflate,
    load_analysis,
    relight,
)
from toonkit.estimation.energy import change_energy
from toonkit.estimation.islands import islands_of

BALL = ellipse(60, 60)
MIDDLE = 64
SPOT = np.hypot(BALL.x - 8, BALL.y + 6) < 26
HINT = NormalHint(MIDDLE, MIDDLE + 4, (0.6, -0.3, 0.7), radius=20)


def angle(one, other):
    return float(np.degrees(np.arccos(np.clip(np.dot(one, other), -1, 1))))


def dented_ball() -> ToonImage:
    """A ball with a dent in the middle of `SPOT`, softly shaded."""
    x, y = (BALL.x - 8) / 22, (BALL.y + 6) / 22
    slope = 4 * np.maximum(1 - x**2 - y**2, 0)
    vectors = np.nan_to_num(BALL.normals.vectors) - np.stack([slope * x, slope * y, 0 * x], axis=-1)
    vectors /= np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)
    return painted(NormalField(vectors, BALL.mask), SOFT)


@pytest.fixture(scope="module")
def plain():
    return analyze(painted(BALL.normals, TWO_TONE, alpha=BALL.coverage), LIGHT)


def corrected(analysis, **said):
    return analyze(analysis.drawing, analysis.light, shape=ShapeCorrections(**said))


def spread(normals, region):
    """Mean angle between the normals of a region and their mean, degrees."""
    vectors = normals.vectors[region]
    mean = vectors.mean(axis=0)
    return float(np.degrees(np.arccos(np.clip(vectors @ (mean / np.linalg.norm(mean)), -1, 1))).mean())


def test_a_dent_that_is_said_to_be_flat_is_flat():
    found = analyze(dented_ball(), LIGHT)
    told = corrected(found, flat=SPOT)
    inner = np.hypot(BALL.x - 8, BALL.y + 6) < 16
    assert spread(found.normals, inner) > 10
    assert spread(told.normals, inner) < 0.4 * spread(found.normals, inner)


def test_a_bulge_turns_away_from_its_middle_on_all_sides(plain):
    told = corrected(plain, bulge=SPOT)
    row, column = MIDDLE + 6, MIDDLE + 8
    for down, along in ((0, 15), (0, -15), (15, 0), (-15, 0)):
        change = (told.normals.vectors - plain.normals.vectors)[row + down, column + along]
        assert change @ (along, -down, 0) / 15 > 0.15
    assert angular_error(told.normals, plain.normals).map[~SPOT & BALL.mask].mean() < 3


def test_a_part_in_front_turns_away_along_its_border(plain):
    told = corrected(plain, in_front=SPOT)
    away = np.stack([BALL.x - 8, BALL.y + 6], axis=-1) / np.hypot(BALL.x - 8, BALL.y + 6)[..., None]
    rim = SPOT & (np.hypot(BALL.x - 8, BALL.y + 6) > 24)
    outward = (told.normals.vectors[..., :2] * away).sum(axis=-1)[rim]
    assert outward.mean() > 0.7
    assert outward.mean() > (plain.normals.vectors[..., :2] * away).sum(axis=-1)[rim].mean() + 0.3
    core = np.hypot(BALL.x - 8, BALL.y + 6) < 8
    assert angular_error(told.normals, plain.normals).map[core].mean() < 5


@pytest.mark.parametrize("method", ["toonkit", "classical", "lumo"])
def test_a_normal_at_a_point_is_reached(plain, method):
    told = analyze(plain.drawing, LIGHT, method=method, shape=ShapeCorrections(normals=[HINT]))
    assert angle(told.normals.vectors[HINT.row, HINT.column], HINT.normal) < 5
    beyond = BALL.mask & (np.hypot(BALL.x, BALL.y) > 40)
    without = analyze(plain.drawing, LIGHT, method=method)
    assert angular_error(told.normals, without.normals).map[beyond].mean() < 1


def test_a_hint_does_not_reach_across_a_gap():
    mask = np.ones((40, 60), bool)
    mask[:, 29:32] = False
    color = np.where((np.arange(60) % 30 < 15)[None, :, None], [0.9, 0.8, 0.6], [0.4, 0.2, 0.5])
    drawing = ToonImage(np.broadcast_to(color, (40, 60, 3)), mask)
    found = analyze(drawing, LIGHT, method="lumo")
    told = analyze(
        found.drawing, LIGHT, method="lumo",
        shape=ShapeCorrections(normals=[NormalHint(20, 26, (1, 0, 0.5), radius=15)]),
    )  # fmt: skip
    assert np.array_equal(told.normals.vectors[:, 32:], found.normals.vectors[:, 32:])
    assert angular_error(told.normals, found.normals).map[20, 22] > 5


def test_the_painted_tones_still_count(plain):
    """Turned into the light, a pixel of the dark tone would be bright."""
    row, column = 95, 95  # on the dark side
    against = NormalHint(row, column, tuple(LIGHT), radius=12)
    told = corrected(plain, normals=[against])
    missed = angle(told.normals.vectors[row, column], against.normal)
    assert 3 < missed < angle(plain.normals.vectors[row, column], against.normal) / 2


@pytest.mark.parametrize("method", METHODS)
def test_without_corrections_nothing_changes(method):
    egg = ellipse(24, 18)
    drawing = painted(egg.normals, TWO_TONE)
    found = analyze(drawing, LIGHT, method=method)
    region = np.hypot(egg.x, egg.y) < 10
    told = analyze(found.drawing, LIGHT, method=method, shape=ShapeCorrections(bulge=region))
    assert told.drawing.materials is found.drawing.materials
    assert told.drawing.ink is found.drawing.ink
    for taken_back in (
        analyze(told.drawing, LIGHT, method=method, shape=ShapeCorrections()),
        analyze(drawing, LIGHT, method=method, shape=ShapeCorrections(flat=np.zeros(egg.mask.shape, bool))),
    ):
        assert np.array_equal(taken_back.normals.compact, found.normals.compact)
        assert taken_back.drawing.given_shape is None


def test_corrections_are_mirrored_with_the_drawing(plain):
    width = BALL.mask.shape[1]
    mirrored = ToonImage(plain.image.color[:, ::-1], BALL.mask[:, ::-1], alpha=plain.image.alpha[:, ::-1])
    hint = replace(HINT, column=width - 1 - HINT.column, normal=(-HINT.normal[0], *HINT.normal[1:]))
    shape = ShapeCorrections(bulge=SPOT[:, ::-1], normals=[hint])
    there = analyze(mirrored, LIGHT * (-1, 1, 1), shape=shape)
    back = NormalField(there.normals.vectors[:, ::-1] * (-1, 1, 1), BALL.mask)
    assert angular_error(back, corrected(plain, bulge=SPOT, normals=[HINT]).normals).mean < 0.1


def test_corrections_are_padded_with_the_drawing(plain):
    pad = ((5, 9), (12, 3))
    drawing = ToonImage(
        np.pad(plain.image.color, (*pad, (0, 0)), constant_values=0.5),
        np.pad(BALL.mask, pad),
        alpha=np.pad(plain.image.alpha, pad),
    )
    hint = replace(HINT, row=HINT.row + 5, column=HINT.column + 12)
    said = {"in_front": SPOT, "normals": [HINT]}
    padded = analyze(drawing, LIGHT, shape=ShapeCorrections(in_front=np.pad(SPOT, pad), normals=[hint]))
    assert np.array_equal(padded.normals.compact, corrected(plain, **said).normals.compact)


def test_corrections_are_saved_and_loaded(plain, tmp_path):
    told = corrected(plain, flat=SPOT, normals=[HINT])
    told.save(tmp_path / "told.npz")
    found = load_analysis(tmp_path / "told.npz")
    assert found.drawing.given_shape.normals == (HINT,)
    assert np.array_equal(found.drawing.given_shape.flat, SPOT)
    assert found.drawing.given_shape.bulge is None
    assert np.array_equal(found.initial_normals.compact, told.initial_normals.compact)
    again = analyze(found.drawing, LIGHT)
    assert angular_error(again.normals, told.normals).mean < 0.1


def test_a_correction_outlives_other_corrections_and_shows_in_the_relit_picture(plain):
    told = corrected(plain, bulge=SPOT)
    marked = analyze(told.drawing, LIGHT, highlights=np.zeros(BALL.mask.shape, bool))
    assert np.array_equal(marked.drawing.given_shape.bulge, SPOT)
    change = np.abs(relight(told, (-40, 20)).color - relight(plain, (-40, 20)).color).max(axis=-1)
    assert (change[SPOT] > 0.1).mean() > 0.05


def test_a_hold_costs_its_share_of_the_squared_change(plain):
    islands = islands_of(BALL.mask, BALL.coverage)
    initial = inflate(BALL.mask).compact
    bounds = illumination_interval(plain.image, plain.color_map)
    allowed = replace(bounds, lower=bounds.lower[BALL.mask], upper=bounds.upper[BALL.mask])
    hold = np.linspace(0, 2, len(initial))
    island, options = islands[0], RefinementOptions()
    free, held = (
        change_energy(island.grid, island.silhouette, initial, LIGHT, allowed, options, hold=firm)
        for firm in (None, hold)
    )
    change = plain.normals.compact - free.start
    cost = energy_value(held, plain.normals.compact) - energy_value(free, plain.normals.compact)
    assert cost == pytest.approx(np.sum(hold * np.sum(change**2, axis=1)), rel=1e-3)  # stored in 32 bits


@pytest.mark.parametrize(
    ("said", "reason"),
    [
        ({"bulge": np.zeros((3, 3), bool) | True}, r"shape.bulge must have the size of the picture"),
        ({"normals": [NormalHint(0, 0, (0, 0, 1), 5)]}, r"shape.normals must lie on the object; got row 0"),
        (
            {"normals": [NormalHint(500, 0, (0, 0, 1), 5)]},
            r"shape.normals must lie on the object; got row 500",
        ),
    ],
)
def test_what_does_not_fit_the_drawing_is_refused(plain, said, reason):
    with pytest.raises(ToonkitError, match=reason):
        corrected(plain, **said)


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (lambda: ShapeCorrections(flat=np.zeros((4, 4))), "flat must be an .H, W. array of bools"),
        (lambda: ShapeCorrections(normals=[(1, 2)]), "normals must be a NormalHint"),
        (lambda: ShapeCorrections(normals=3), "normals must be a list of NormalHint; got 3"),
        (lambda: NormalHint(1.5, 2, (0, 0, 1), 5), "row must be a whole number from 0 on; got 1.5"),
        (lambda: NormalHint(1, 2, (0, 0, 0), 5), "normal must point somewhere"),
        (lambda: NormalHint(1, 2, (0, 0, -1), 5), "normal must not come from behind the picture"),
        (lambda: NormalHint(1, 2, (0, 0, 1), 0), "radius must be a number of pixels above 0"),
        (lambda: analyze("sample:pear", LIGHT, shape=SPOT), "shape must be a ShapeCorrections"),
    ],
)
def test_what_is_no_correction_is_refused(make, reason):
    with pytest.raises(ToonkitError, match=reason):
        make()
