"""The study's table survives the way to disk and back."""

from __future__ import annotations

from dataclasses import replace

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
    "method": {"todo": "4", "mine": "5"},
    "light_track": {"given": "", "estimated": "6"},
}


def sidecar(**changes):
    return {"code": "1", "settings": {"size": 32}, "digests": DIGESTS, **changes}


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


def test_a_record_of_another_method_color_map_or_shape_is_not_current(tmp_path):
    trial = TRIALS[0]
    RecordStore(tmp_path, sidecar()).save(trial, records()[0])
    for group, name in (("shape", "b"), ("color_map", "plum"), ("method", "todo")):
        changed = {**DIGESTS, group: {**DIGESTS[group], name: "another"}}
        assert not RecordStore(tmp_path, sidecar(digests=changed)).is_done(trial)
        assert RecordStore(tmp_path, sidecar(digests=changed)).records() == []
        assert RecordStore(tmp_path, sidecar(digests=changed)).outdated() == 1
    for other in ({"code": "2"}, {"settings": {"size": 33}}):
        assert not RecordStore(tmp_path, sidecar(**other)).is_done(trial)
    assert RecordStore(tmp_path, sidecar()).is_done(trial)


def test_other_ways_to_estimate_the_light_change_the_trials_that_estimate_it(tmp_path):
    given = TRIALS[0]
    estimated = replace(given, light_track="estimated")
    store = RecordStore(tmp_path, sidecar())
    for trial in (given, estimated):
        store.save(trial, unmeasured(trial, "mesh", StudySettings(size=32), error=""))
    changed = {**DIGESTS, "light_track": {"given": "", "estimated": "another"}}
    other = RecordStore(tmp_path, sidecar(digests=changed))
    assert [store.is_done(trial) for trial in (given, estimated)] == [True, True]
    assert [other.is_done(trial) for trial in (given, estimated)] == [True, False]


def test_a_trial_whose_worker_was_lost_is_tried_again(tmp_path):
    store = RecordStore(tmp_path, sidecar())
    store.save(TRIALS[0], unmeasured(TRIALS[0], "mesh", StudySettings(), error=f"{LOST}KilledWorker: gone"))
    store.save(TRIALS[1], unmeasured(TRIALS[1], "mesh", StudySettings(), error="ValueError: no"))
    assert [store.is_done(trial) for trial in TRIALS[:2]] == [False, True]
    assert [store.is_done(trial, retry_failed=True) for trial in TRIALS[:2]] == [False, False]
