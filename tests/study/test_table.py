"""The study's table survives the way to disk and back."""

from __future__ import annotations

import json

import pandas as pd
import pytest

from toonkit import ToonkitError
from toonkit.export.sole_use import LOCK_NAME
from toonkit.study.painting import StudySettings
from toonkit.study.plan import plan_study
from toonkit.study.provenance import provenance
from toonkit.study.record_store import LOST, RecordStore
from toonkit.study.records import Record, Trial, blank_record
from toonkit.study.runner import run_study
from toonkit.study.study_folder import open_sidecar
from toonkit.study.table import (
    COLUMN_TYPES,
    CSV_NAME,
    PROVENANCE_NAME,
    TABLE_NAME,
    as_table,
    load_provenance,
    load_trials,
    write_csv,
    write_table,
)

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
    return [blank_record(trial, "mesh", settings, error=e) for trial, e in zip(TRIALS, errors, strict=True)]


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
        store.save(trial, blank_record(trial, "mesh", StudySettings(size=32)))
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
    store.save(TRIALS[0], blank_record(TRIALS[0], "mesh", StudySettings(), error=f"{LOST}KilledWorker: gone"))
    store.save(TRIALS[1], blank_record(TRIALS[1], "mesh", StudySettings(), error="ValueError: no"))
    assert [store.is_done(trial) for trial in TRIALS[:2]] == [False, True]
    assert [store.is_done(trial, retry_failed=True) for trial in TRIALS[:2]] == [False, False]


DAMAGES = {
    "cut off": lambda text: text[: len(text) // 2],
    "empty": lambda text: "",
    "no object": lambda text: "[1, 2]",
    "nested": lambda text: "[" * 100_000,
    "no record": lambda text: json.dumps({"fingerprint": json.loads(text)["fingerprint"]}),
    "other columns": lambda text: text.replace('"pixels"', '"pixel"'),
    "text for a number": lambda text: text.replace('"pixels": 0', '"pixels": "0"'),
    "bool for a number": lambda text: text.replace('"pixels": 0', '"pixels": false'),
    "a number beyond 64 bits": lambda text: text.replace('"pixels": 0', f'"pixels": {10**30}'),
    "a number for text": lambda text: text.replace('"error": ""', '"error": 5'),
    "another trial": lambda text: text.replace('"shape": "b"', '"shape": "a"'),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_record_is_measured_again(damage, tmp_path):
    store = RecordStore(tmp_path, sidecar())
    for trial, record in zip(TRIALS, records(), strict=True):
        store.save(trial, record)
    path = tmp_path / "records" / f"{TRIALS[0].key}.json"
    damaged = damage(path.read_text())
    assert damaged != path.read_text()
    path.write_text(damaged)
    assert [store.is_done(trial) for trial in TRIALS] == [False, True, True, True]
    assert len(store.records()) == 3
    store.forget(["mine"])
    assert len(store.records()) == 1
    store.save(TRIALS[0], records()[0])
    assert store.is_done(TRIALS[0])


PLAN = plan_study(
    shapes=["sphere"], color_maps=["terracotta"], methods=["flat"], settings=StudySettings(size=32)
)


def test_a_provenance_reads_back_as_it_was_written(tmp_path):
    written = open_sidecar(provenance(PLAN), tmp_path)
    assert load_provenance(tmp_path) == json.loads(json.dumps(written))


@pytest.mark.parametrize(
    "changes",
    [
        *({name: odd} for name in provenance(PLAN) for odd in (None, 5)),
        {"runs": [{}]},
        {"runs": [5]},
        {"digests": {"shape": {"a": 5}}},
        {"color_maps": [["nested"]]},
        {"settings": {"size": "large", "light": [0, 90], "new_lights": [[0, 90]]}},
        {"settings": {"size": 64, "light": [0, 90], "new_lights": [[0]]}},
    ],
    ids=str,
)
def test_an_odd_provenance_is_refused(changes, tmp_path):
    written = {**open_sidecar(provenance(PLAN), tmp_path), **changes}
    (tmp_path / PROVENANCE_NAME).write_text(json.dumps(written))
    with pytest.raises(ToonkitError, match=r"source must have .*study\.json"):
        load_provenance(tmp_path)
    with pytest.raises(ToonkitError, match=r"source must have .*study\.json"):
        run_study(PLAN, tmp_path, workers=0)


@pytest.mark.parametrize("text", ["", "[]", "[" * 100_000, "{", "\x00"])
def test_a_provenance_that_is_no_object_is_refused(text, tmp_path):
    (tmp_path / PROVENANCE_NAME).write_text(text)
    with pytest.raises(ToonkitError, match=r"source must have .*study\.json"):
        load_provenance(tmp_path)


@pytest.mark.parametrize("name", [LOCK_NAME, "records"])
def test_a_folder_that_cannot_be_written_to_is_refused(name, tmp_path):
    if name == LOCK_NAME:
        (tmp_path / name).mkdir()
    else:
        (tmp_path / name).write_text("")
    with pytest.raises(ToonkitError, match="folder must be writable; got "):
        run_study(PLAN, tmp_path, workers=0)


def _lines(**changes):
    """A table of one trial as CSV, with some of its values changed."""
    return as_table(records()[:1]).astype(object).assign(**changes).to_csv(index=False)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "must be the table of a study"),
        ("\x00\xff", "must (be the table|have the column)"),
        (_lines().splitlines()[0], "must hold at least one trial"),
        (_lines(pixels="many"), "must have the columns of a study's table"),
        (_lines(pixels=None), "must have the columns of a study's table"),
        (
            _lines(light_track="sideways"),
            "must be of the light tracks given and estimated; got .* with 'sideways'",
        ),
    ],
)
def test_a_csv_file_that_is_no_table_is_refused(text, reason, tmp_path):
    (tmp_path / CSV_NAME).write_text(text)
    with pytest.raises(ToonkitError, match=f"source {reason}"):
        load_trials(tmp_path)
