"""The study's table survives the way to disk and back."""

from __future__ import annotations

import pandas as pd
import pytest

from toonkit import ToonkitError
from toonkit.study.record_store import LOST, RecordStore
from toonkit.study.table import (
    COLUMN_TYPES,
    CSV_NAME,
    TABLE_NAME,
    as_table,
    load_trials,
    write_csv,
    write_table,
)
from toonkit.study.trials import Record, StudySettings, Trial, unmeasured

TRIALS = [Trial(shape, "plum", method, "given") for shape in ("b", "a") for method in ("todo", "mine")]
DIGESTS = {
    "shape": {"a": "1", "b": "2"},
    "color_map": {"plum": "3"},
    "method_file": {"todo": None, "toonkit": None, "mine": "4"},
    "weights": {"light_prior": "5", "shape_prior": "6"},
}


def sidecar(**changes):
    return {"toonkit": "1.0", "settings": {"size": 32}, "digests": DIGESTS, **changes}


def records() -> list[Record]:
    settings = StudySettings(size=32)
    errors = ["", 'ValueError: a "quote", a comma\nand a line', "", ""]
    return [unmeasured(trial, "mesh", settings, error=e) for trial, e in zip(TRIALS, errors, strict=True)]


def test_rows_are_sorted_and_typed_whatever_the_order_of_records():
    table = as_table(records())
    pd.testing.assert_frame_equal(table, as_table(reversed(records())))
    assert list(zip(table["shape"], table["method"], strict=True)) == [
        ("a", "mine"), ("a", "todo"), ("b", "mine"), ("b", "todo"),
    ]  # fmt: skip
    assert list(table.columns) == list(COLUMN_TYPES)
    assert list(as_table([]).columns) == list(COLUMN_TYPES)


def test_a_table_reads_back_as_it_was_written(tmp_path):
    table = as_table(records())
    write_csv(table, tmp_path / CSV_NAME)
    pd.testing.assert_frame_equal(load_trials(tmp_path), table)
    write_table(table, tmp_path)
    pd.testing.assert_frame_equal(load_trials(tmp_path), table)
    pd.testing.assert_frame_equal(load_trials(tmp_path / TABLE_NAME), table)


def test_what_is_no_table_is_refused(tmp_path):
    with pytest.raises(ToonkitError, match="toonkit study run"):
        load_trials(tmp_path)
    with pytest.raises(ToonkitError, match="toonkit study run"):
        load_trials(tmp_path / "nothing.csv")
    (tmp_path / CSV_NAME).write_text("a,b\n1,2\n")
    with pytest.raises(ToonkitError, match="column shape"):
        load_trials(tmp_path)
    (tmp_path / TABLE_NAME).write_bytes(b"not parquet")
    with pytest.raises(ToonkitError, match="table of a study"):
        load_trials(tmp_path)


def test_records_read_back_as_they_were_saved(tmp_path):
    store = RecordStore(tmp_path, sidecar())
    for trial, record in zip(TRIALS, records(), strict=True):
        assert not store.is_done(trial)
        store.save(trial, record)
        assert store.is_done(trial)
    pd.testing.assert_frame_equal(as_table(store.records()), as_table(records()))


@pytest.mark.parametrize(
    "changes",
    [
        {"digests": {**DIGESTS, "shape": {**DIGESTS["shape"], "b": "another"}}},
        {"digests": {**DIGESTS, "color_map": {"plum": "another"}}},
        {"digests": {**DIGESTS, "method_file": {"todo": "a user's own"}}},
        {"toonkit": "2.0"},
        {"settings": {"size": 33}},
    ],
)
def test_a_record_of_other_inputs_is_not_current(changes, tmp_path):
    trial = TRIALS[0]
    RecordStore(tmp_path, sidecar()).save(trial, records()[0])
    changed = RecordStore(tmp_path, sidecar(**changes))
    assert not changed.is_done(trial)
    assert changed.records() == []
    assert RecordStore(tmp_path, sidecar()).is_done(trial)


@pytest.mark.parametrize(
    ("network", "depending"),
    [
        ("shape_prior", {"toonkit given", "mine given"}),
        ("light_prior", {"mine given"}),
    ],
)
def test_other_weights_change_the_trials_that_use_them(network, depending, tmp_path):
    trials = [
        Trial("a", "plum", method, track)
        for method in ("toonkit", "todo", "mine")
        for track in ("given", "estimated")
    ]
    store = RecordStore(tmp_path, sidecar())
    for trial in trials:
        store.save(trial, unmeasured(trial, "mesh", StudySettings(size=32)))
    assert all(store.is_done(trial) for trial in trials)
    weights = {**DIGESTS["weights"], network: "another"}
    changed = RecordStore(tmp_path, sidecar(digests={**DIGESTS, "weights": weights}))
    measured_anew = {f"{trial.method} {trial.light_track}" for trial in trials if not changed.is_done(trial)}
    assert measured_anew == depending | {"toonkit estimated", "todo estimated", "mine estimated"}


def test_only_the_records_of_the_methods_named_are_forgotten(tmp_path):
    store = RecordStore(tmp_path, sidecar())
    for trial, record in zip(TRIALS, records(), strict=True):
        store.save(trial, record)
    store.forget(["mine"])
    assert {record.method for record in store.records()} == {"todo"}
    assert [store.is_done(trial) for trial in TRIALS] == [trial.method == "todo" for trial in TRIALS]


def test_a_trial_whose_worker_was_lost_is_tried_again(tmp_path):
    store = RecordStore(tmp_path, sidecar())
    store.save(TRIALS[0], unmeasured(TRIALS[0], "mesh", StudySettings(), error=f"{LOST}KilledWorker: gone"))
    store.save(TRIALS[1], unmeasured(TRIALS[1], "mesh", StudySettings(), error="ValueError: no"))
    assert [store.is_done(trial) for trial in TRIALS[:2]] == [False, True]
    assert [store.is_done(trial, retry_failed=True) for trial in TRIALS[:2]] == [False, False]
