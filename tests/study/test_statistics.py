"""Means say what they leave out, intervals know that trials share shapes and color maps, and verdicts follow the numbers."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tests.synthetic_study import (
    AS_THE_PAPER_SAYS,
    COLOR_MAPS,
    RESPONSES,
    SHAPES,
    failed,
    study_table,
    with_newcomers,
)
from toonkit import ToonkitError
from toonkit.study.measures import MEASURES
from toonkit.study.reporting.claim_tests import Check
from toonkit.study.reporting.claims import Claim, check_claims
from toonkit.study.reporting.comparisons import (
    PAIRS,
    compare,
    comparisons,
    has_pairs,
    holm,
    pairs_in,
    signed_rank,
)
from toonkit.study.reporting.measure_table import arrange, completeness, failures, statement
from toonkit.study.reporting.statistics import Interval, breakdown, center, contrast, method_means, resample


@pytest.fixture(scope="module")
def trials():
    return study_table()


def verdicts(table):
    return {claim.key: claim.verdict for claim in check_claims(table)}


def altered(table, method, **factors):
    """The table with a method's measures multiplied."""
    changed = table.copy()
    for name, factor in factors.items():
        for column in (name, f"{name}_without_rim"):
            changed.loc[changed["method"] == method, column] *= factor
    return changed


def mean_of(table, method, measure="angular_error"):
    means = method_means(table, (measure,))
    return means[means["method"] == method].iloc[0]


# Measure tables


def test_cells_come_in_the_order_of_the_study_whatever_the_order_of_the_rows(trials):
    shuffled = trials.sample(frac=1, random_state=0)
    table = arrange(shuffled, "angular_error")
    assert table.methods == ("toonkit", "todo", "lumo", "lambert", "flat")
    assert table.color_maps == COLOR_MAPS
    row = shuffled[
        (shuffled["shape"] == "cat") & (shuffled["color_map"] == "candy") & (shuffled["method"] == "lumo")
    ]
    place = table.shapes.index("cat"), table.color_maps.index("candy")
    assert table.of("lumo")[place] == row["angular_error"].item()


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda table: table.iloc[:0], "at least one trial"),
        (lambda table: pd.concat([table, table.iloc[:1]]), "each trial once"),
        (lambda table: table.assign(size=np.where(table["shape"] == "cat", 64, 128)), "one size"),
        (lambda table: pd.concat([table, table.assign(light_track="estimated")]), "one light track"),
        (lambda table: table.drop(columns="method"), "no column method"),
    ],
)
def test_a_table_that_cannot_be_averaged_is_refused(trials, spoil, says):
    with pytest.raises(ToonkitError, match=says):
        method_means(spoil(trials))


def test_an_unknown_measure_grouping_or_method_is_refused(trials):
    with pytest.raises(ToonkitError, match="measure must be one of"):
        arrange(trials, "beauty")
    with pytest.raises(ToonkitError, match="by must be one of"):
        breakdown(trials, "angular_error", "mood")
    with pytest.raises(ToonkitError, match="method must be one of"):
        compare(trials, "toonkit", "nobody", "angular_error")


# Failures


def test_a_failed_trial_takes_its_pair_from_every_mean_and_is_counted(trials):
    broken = failed(trials, shape="cat", color_map="candy", method="todo")
    means = method_means(broken, ("angular_error",)).set_index("method")
    assert set(means["trials"]) == {35}
    assert means["failed"].to_dict() == {"toonkit": 0, "todo": 1, "lumo": 0, "lambert": 0, "flat": 0}
    others = trials[~((trials["shape"] == "cat") & (trials["color_map"] == "candy"))]
    expected = others[others["method"] == "lumo"]["angular_error"].mean()
    assert means.loc["lumo", "center"] == pytest.approx(expected, rel=1e-12)
    assert "35 of 36" in statement(broken)
    assert "todo: 1 failed" in statement(broken)
    assert failures(broken)["error"].tolist() == ["ValueError: it | broke"]


def test_a_trial_that_is_not_in_the_table_is_missing_and_not_forgotten(trials):
    left_out = trials[~((trials["shape"] == "cat") & (trials["method"] == "lumo"))]
    counts = completeness(left_out)
    assert counts.loc["lumo", ["planned", "completed", "failed", "missing"]].tolist() == [36, 30, 0, 6]
    assert "lumo: 6 missing" in statement(left_out)
    assert mean_of(left_out, "toonkit")["trials"] == 30


def test_a_method_that_always_fails_has_no_mean_and_takes_none_from_the_others(trials):
    broken = failed(trials, method="lumo")
    assert np.isnan(mean_of(broken, "lumo")["center"])
    assert mean_of(broken, "lumo")["failed"] == 36
    assert mean_of(broken, "toonkit")["trials"] == 36
    assert "lumo completed none" in statement(broken)


def test_a_table_without_failures_says_that_means_are_over_everything(trials):
    assert statement(trials) == (
        "Every method completed all 36 pairs of shape and color map; every mean is over all of them."
    )


def test_an_error_read_back_from_an_empty_field_is_none(trials):
    assert failures(trials.assign(error=np.nan)).empty


def test_an_infinite_ratio_is_a_hole(trials):
    table = trials.copy()
    table.loc[0, "relight_response"] = np.inf
    assert mean_of(table, "toonkit", "relight_response")["trials"] == 35


# The bootstrap


def test_the_mean_of_all_resamples_is_the_mean(trials):
    table = arrange(trials, "angular_error")
    draws = resample(table)
    assert (draws.shapes.sum(axis=1) == len(SHAPES)).all()
    assert (draws.color_maps.sum(axis=1) == len(COLOR_MAPS)).all()
    ones = np.ones((len(SHAPES), len(COLOR_MAPS)))
    assert center(ones, draws) == Interval(1.0, pytest.approx(1.0), pytest.approx(1.0), 36)


def test_the_interval_covers_a_known_difference_as_often_as_it_says():
    generator = np.random.default_rng(1)
    covered = 0
    for _ in range(60):
        # Shapes and color maps of a population in which the one method is worse by 2 on average.
        table = arrange(study_table(noise=0.0), "angular_error")
        difference = (
            2 + generator.normal(size=(6, 1)) + generator.normal(size=(1, 6)) + generator.normal(size=(6, 6))
        )
        values = np.zeros_like(table.values)
        values[1] = difference
        found = contrast(cells_of(table, values), {"todo": 1.0, "toonkit": -1.0}, resample(table))
        covered += found.low <= 2 <= found.high
    assert covered >= 50  # with six of a kind, 93 % are covered in the long run: 56 of 60, give or take 2


def cells_of(table, values):
    return type(table)(table.measure, table.methods, table.shapes, table.color_maps, values)


def test_trials_that_share_a_shape_make_the_interval_wider_than_independent_ones_would(trials):
    table = arrange(trials, "angular_error")
    generator = np.random.default_rng(2)
    by_shape = np.repeat(generator.normal(size=(6, 1)), 6, axis=1)
    crossed = center(by_shape, resample(table))
    independent = 1.96 * by_shape.std() / np.sqrt(by_shape.size)
    assert (
        crossed.high - crossed.low > 3 * independent
    )  # by the root of 6, as there are six shapes and not 36


def test_the_same_seed_gives_the_same_interval_and_another_seed_another(trials):
    first, second = (method_means(trials, ("angular_error",)) for _ in range(2))
    pd.testing.assert_frame_equal(first, second)
    other = method_means(trials, ("angular_error",), generator=np.random.default_rng(99))
    assert (other["center"] == first["center"]).all()
    assert (other["low"] != first["low"]).all()


def test_the_center_of_a_ratio_is_a_median_that_one_wild_trial_does_not_move(trials):
    wild = trials.copy()
    row = (wild["shape"] == "cat") & (wild["color_map"] == "ocean") & (wild["method"] == "todo")
    wild.loc[row, "relight_response"] = 125.0
    found = mean_of(wild, "todo", "relight_response")
    assert found["center"] == pytest.approx(RESPONSES["todo"], abs=0.01)
    assert found["high"] < 1.1


def test_the_median_of_a_resample_is_that_of_its_values(trials):
    table = arrange(trials, "relight_response")
    draws = resample(table)
    one = type(draws)(draws.shapes[:1], draws.color_maps[:1])
    counts = np.outer(one.shapes[0], one.color_maps[0]).astype(int)
    drawn = np.repeat(table.of("todo").ravel(), counts.ravel())
    found = center(table.of("todo"), one, median=True)
    # Of an even number of values, the lower of the two in the middle.
    assert found.low == found.high == np.sort(drawn)[(len(drawn) - 1) // 2]


def test_nothing_to_average_gives_no_number(trials):
    found = center(np.full((6, 6), np.nan), resample(arrange(trials, "angular_error")))
    assert found.trials == 0
    assert found.shown(MEASURES["angular_error"]) == "not measured"


def test_an_interval_is_shown_with_its_unit_and_a_true_minus():
    assert Interval(-1.26, -2.0, 0.5, 9).shown(MEASURES["angular_error"], sign=True) == "−1.3° [−2.0, +0.5]"


# Groups


def test_a_breakdown_is_the_mean_over_the_rest(trials):
    table = breakdown(trials, "angular_error", "shape")
    rows = trials[(trials["shape"] == "cat") & (trials["method"] == "lambert")]
    assert table.loc["cat", "lambert"] == pytest.approx(rows["angular_error"].mean(), rel=1e-12)
    assert table["trials"].tolist() == [6] * 6


def test_a_breakdown_by_kind_counts_the_shapes_of_the_kind(trials):
    table = breakdown(failed(trials, shape="sphere", method="todo"), "angular_error", "shape_kind")
    assert table["trials"].to_dict() == {"complex": 24, "primitive": 6}


def test_a_group_in_which_everything_failed_stays_in_the_table(trials):
    table = breakdown(failed(trials, color_map="ocean", method="todo"), "angular_error", "color_map")
    assert table.loc["ocean", "trials"] == 0
    assert np.isnan(table.loc["ocean", "toonkit"])


# Pairs


def test_wins_losses_and_ties_are_shares_of_all_trials(trials):
    table = trials.sort_values(["method", "shape", "color_map"], ignore_index=True)
    todo, lumo = (table.index[table["method"] == name] for name in ("todo", "lumo"))
    table.loc[todo, "angular_error"] = 10.0
    table.loc[lumo, "angular_error"] = [9.0] * 6 + [10.0] * 3 + [11.0] * 27
    found = compare(table, "todo", "lumo", "angular_error")
    assert (found.won, found.lost, found.tied) == (27 / 36, 6 / 36, 3 / 36)
    assert found.difference.center == pytest.approx(-(27 - 6) / 36)


def test_a_failed_trial_is_lost_to_one_that_did_not_fail(trials):
    better = altered(trials, "todo", angular_error=0.1)
    broken = failed(better, shape="cat", method="todo")
    found = compare(broken, "todo", "lumo", "angular_error")
    assert (found.won, found.lost) == (30 / 36, 6 / 36)
    assert found.difference.trials == 30


def test_a_trial_in_which_both_fail_is_won_by_nobody(trials):
    broken = failed(failed(trials, shape="cat", method="todo"), shape="cat", method="lumo")
    found = compare(broken, "todo", "lumo", "angular_error")
    assert found.won + found.lost + found.tied == pytest.approx(1.0)
    assert found.difference.trials == 30


def test_a_response_is_compared_by_its_distance_from_one(trials):
    table = trials.copy()
    table.loc[table["method"] == "todo", "relight_response"] = 1.1
    table.loc[table["method"] == "lumo", "relight_response"] = 0.5
    found = compare(table, "todo", "lumo", "relight_response")
    assert found.difference.center == pytest.approx(0.1 - 0.5)
    assert found.won == 1.0


def test_equal_methods_differ_by_chance_only(trials):
    table = trials.copy()
    table.loc[table["method"] == "lumo", "angular_error"] = table.loc[
        table["method"] == "todo", "angular_error"
    ].to_numpy()
    found = compare(table, "todo", "lumo", "angular_error")
    assert (found.tied, found.p_shapes, found.p_color_maps, found.p) == (1.0, 1.0, 1.0, 1.0)


def test_the_test_over_shapes_is_that_of_their_means(trials):
    found = compare(trials, "todo", "lambert", "angular_error")
    # Of six shapes that all agree, each of the two unanimous outcomes has a chance of 1 in 64.
    assert found.p_shapes == pytest.approx(2 / 64)


def test_the_less_sure_of_the_tests_over_shapes_and_over_color_maps_counts(trials):
    table = trials.sort_values(["method", "color_map", "shape"], ignore_index=True)
    todo, lumo = (table.index[table["method"] == name] for name in ("todo", "lumo"))
    table.loc[todo, "angular_error"] = 20.0
    # Every shape gains, on average over color maps; of the color maps two lose.
    table.loc[lumo, "angular_error"] = 20.0 + np.repeat([5.0, 4.0, 3.0, 2.0, -1.0, -1.5], 6)
    found = compare(table, "todo", "lumo", "angular_error")
    assert found.p_shapes == pytest.approx(2 / 64)
    assert found.p_color_maps > 0.1
    assert found.p == found.p_color_maps


def test_a_difference_that_is_chance_is_seldom_called_significant():
    generator = np.random.default_rng(3)
    shapes, both = [], []
    for _ in range(200):
        # No difference in the long run; the study's numbers of shapes and color maps, the latter of strong effects.
        values = (
            0.3 * generator.normal(size=(20, 1))
            + generator.normal(size=(1, 24))
            + generator.normal(size=(20, 24))
        )
        shapes.append(signed_rank(values))
        both.append(max(shapes[-1], signed_rank(values.T)))
    assert np.mean(np.array(shapes) < 0.05) > 0.3  # what shapes alone would call significant
    assert np.mean(np.array(both) < 0.05) < 0.1


def test_holm_agrees_with_an_example_worked_by_hand():
    # Sorted: 0.01 x 4 = 0.04; 0.02 x 3 = 0.06; 0.03 x 2 = 0.06; 0.04 x 1 = 0.04, not below its predecessor: 0.06.
    np.testing.assert_allclose(
        holm([0.03, 0.01, np.nan, 0.04, 0.02]), [0.06, 0.04, np.nan, 0.06, 0.06], rtol=1e-12
    )


def test_holm_exceeds_no_probability():
    np.testing.assert_allclose(holm([0.9, 0.8]), [1.0, 1.0])


def test_p_values_are_corrected_over_all_comparisons_of_the_table(trials):
    table = comparisons(trials)
    np.testing.assert_allclose(table["p"], table[["p_shapes", "p_color_maps"]].max(axis=1))
    np.testing.assert_allclose(table["p_holm"], holm(table["p"]))
    assert (table["p_holm"] >= table["p"]).all()
    flat = table[table["versus"] == "flat"]
    assert not set(flat["measure"]) & {"input_rmse", "relight_response"}  # where flat has no choice


def test_a_table_of_one_method_has_nothing_to_compare(trials):
    with pytest.raises(ToonkitError, match="two methods"):
        comparisons(trials[trials["method"] == "todo"])


def test_a_newcomer_is_compared_with_everyone_once(trials):
    assert pairs_in(["toonkit", "classical", "todo", "lumo", "lambert", "flat"]) == PAIRS
    assert pairs_in(["lumo", "dome"]) == (("dome", "lumo"),)
    assert pairs_in(["todo", "dome", "bowl"]) == (("dome", "todo"), ("dome", "bowl"), ("bowl", "todo"))
    table = comparisons(with_newcomers(trials, "dome"))
    rows = table[table["method"] == "dome"]
    assert set(rows["versus"]) == set(AS_THE_PAPER_SAYS)
    assert rows.loc[rows["measure"] == "angular_error", "won"].notna().all()
    known = {pair for pair in PAIRS if set(pair) <= set(AS_THE_PAPER_SAYS)}
    assert set(table[["method", "versus"]].itertuples(index=False, name=None)) >= known
    assert len(known) == 6


def test_a_newcomer_and_one_other_method_are_a_pair(trials):
    two = with_newcomers(trials[trials["method"] == "lumo"], "dome")
    assert has_pairs(two)
    assert set(comparisons(two)["method"]) == {"dome"}
    assert not has_pairs(two[two["method"] == "dome"])


# Too few


def few(trials, *, shapes=6, color_maps=6):
    return trials[trials["shape"].isin(SHAPES[:shapes]) & trials["color_map"].isin(COLOR_MAPS[:color_maps])]


POOR = [{"shapes": 1, "color_maps": 1}, {"shapes": 1}, {"color_maps": 1}, {"shapes": 4}, {"color_maps": 4}]


@pytest.mark.parametrize("kept", POOR, ids=str)
def test_too_few_shapes_or_color_maps_have_a_center_and_no_interval(trials, kept):
    part = few(trials, **kept)
    found = mean_of(part, "todo")
    own = part[part["method"] == "todo"]["angular_error"]
    assert found["center"] == pytest.approx(own.mean())
    assert np.isnan([found["low"], found["high"]]).all()
    table = comparisons(part)
    assert table[["low", "high", "p", "p_holm"]].isna().all(axis=None)
    assert table["difference"].notna().all()


@pytest.mark.parametrize("kept", POOR, ids=str)
def test_too_few_shapes_or_color_maps_decide_nothing(trials, kept):
    found = check_claims(few(trials, **kept))
    assert {check.outcome for claim in found for check in claim.checks} == {"undecided"}
    assert "too few for an interval" in found[0].checks[0].numbers


def test_five_shapes_and_five_color_maps_are_enough(trials):
    part = few(trials, shapes=5, color_maps=5)
    assert np.isfinite(mean_of(part, "todo")["low"])
    assert verdicts(part)["f"] == "agrees"


def test_shapes_that_all_failed_do_not_count_as_enough(trials):
    broken = failed(failed(trials, shape="cat", method="todo"), shape="duck", method="todo")
    assert np.isnan(mean_of(broken, "todo")["low"])  # four shapes remain of six
    assert verdicts(broken)["f"] == "undecided"


def test_a_correlation_over_four_hard_color_maps_is_undecided(trials):
    (claim,) = (claim for claim in check_claims(trials[trials["color_map"] != "candy"]) if claim.key == "c")
    assert [check.outcome for check in claim.checks[2:]][1] == "undecided"
    assert "needs 5 shapes and 5 color maps" in claim.checks[3].numbers


def test_a_center_without_an_interval_says_so():
    shown = Interval(-1.26, np.nan, np.nan, 1).shown(MEASURES["angular_error"])
    assert shown == "−1.3° (too few for an interval)"


# Claims


def test_numbers_made_as_the_paper_says_agree_with_it(trials):
    found = verdicts(trials)
    assert {key: verdict for key, verdict in found.items() if key != "c"} == dict.fromkeys("abdef", "agrees")
    assert found["c"] in {"agrees", "partly"}  # six color maps are few for a rank correlation


@pytest.mark.parametrize(
    ("key", "method", "factors"),
    [
        ("a", "lumo", {"illumination_error": 0.2, "input_rmse": 0.1}),
        ("f", "todo", {"relight_rmse": 3.0}),
        ("d", "todo", {"input_rmse": 10.0, "angular_error": 3.0}),
    ],
)
def test_a_verdict_turns_when_the_numbers_do(trials, key, method, factors):
    turned = altered(trials, method, **factors)
    assert verdicts(trials)[key] == "agrees"
    assert verdicts(turned)[key] == "disagrees"


def test_a_lambert_that_answers_best_contradicts_the_paper():
    turned = study_table(responses={**RESPONSES, "lambert": 1.0, "todo": 0.5, "lumo": 0.5})
    assert verdicts(turned)["e"] == "disagrees"


def test_a_lambert_that_fits_worst_contradicts_the_paper():
    methods = {**AS_THE_PAPER_SAYS, "lambert": {**AS_THE_PAPER_SAYS["lambert"], "input_rmse": 0.5}}
    assert verdicts(study_table(methods))["b"] == "disagrees"


def test_an_excess_of_error_on_soft_maps_is_no_overfitting_to_tones():
    backwards = study_table(color_maps=COLOR_MAPS)
    backwards.loc[backwards["method"] == "lambert", "angular_error"] = 50.0 + 5.0 * backwards.loc[
        backwards["method"] == "lambert", "color_map"
    ].map(dict(zip(COLOR_MAPS, range(6), strict=True)))
    (claim,) = (claim for claim in check_claims(backwards) if claim.key == "c")
    assert claim.verdict == "partly"
    assert [check.outcome for check in claim.checks[2:]] == ["does not hold"] * 2


def test_half_of_a_claim_is_agreed_to_partly(trials):
    (claim,) = (
        claim for claim in check_claims(altered(trials, "todo", relight_rmse=1.4)) if claim.key == "f"
    )
    assert claim.verdict == "partly"  # now between lumo and lambert


def test_a_claim_about_a_method_that_was_not_run_is_undecided(trials):
    found = verdicts(trials[trials["method"] != "lambert"])
    assert found["b"] == "undecided"
    assert found["a"] == "agrees"


@pytest.mark.parametrize(
    ("outcomes", "verdict"),
    [
        (["holds", "holds"], "agrees"),
        (["holds", "undecided"], "partly"),
        (["holds", "does not hold"], "partly"),
        (["undecided", "does not hold"], "disagrees"),
        (["undecided", "undecided"], "undecided"),
    ],
)
def test_the_verdict_follows_from_the_checks(outcomes, verdict):
    checks = tuple(Check("so", "1 of 1", outcome) for outcome in outcomes)
    assert Claim("x", "4.2", "It is so.", checks).verdict == verdict


def test_checks_carry_the_numbers_of_the_table(trials):
    (claim,) = (claim for claim in check_claims(trials) if claim.key == "f")
    shown = MEASURES["relight_rmse"].shown(mean_of(trials, "todo", "relight_rmse")["center"])
    assert f"todo {shown}" in claim.checks[0].numbers
    assert "36 trials" in claim.checks[0].numbers
