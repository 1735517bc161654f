"""A study ends with the same table, however often and however hard it was stopped, and wherever it ran."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import psutil
import pytest
from distributed import LocalCluster

import toonkit
from tests.dashboards.conftest import free_port
from toonkit import METHODS, ToonkitError
from toonkit.study import batches, cluster
from toonkit.study.batches import Batch
from toonkit.study.painting import StudySettings
from toonkit.study.plan import StudyPlan, plan_study
from toonkit.study.record_store import LOST
from toonkit.study.runner import StudyProgress, run_study
from toonkit.study.table import TIMING_COLUMNS, load_provenance, load_trials

ROOT = Path(__file__).parents[2]
SHAPES = ["sphere", "torus"]
MAPS = ["terracotta", "plum_cream", "dusk_smooth"]
NAMES = ["lumo", "toonkit", "flat"]
SIZE = 48
TRIALS = len(SHAPES) * len(MAPS) * len(NAMES)
COMMAND = [
    sys.executable, "-m", "toonkit", "study", "run", "--quiet", "--size", str(SIZE),
    "--shapes", *SHAPES, "--maps", *MAPS, "--methods", *NAMES, "-o",
]  # fmt: skip
WAIT_SECONDS = 120


def plan(**changes) -> StudyPlan:
    chosen = {"shapes": SHAPES, "color_maps": MAPS, "methods": NAMES, "settings": StudySettings(size=SIZE)}
    return plan_study(**{**chosen, **changes})


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> pd.DataFrame:
    """The table of a study that ran through, in this process."""
    return run_study(plan(), tmp_path_factory.mktemp("study"), workers=0)


def assert_same(table: pd.DataFrame, reference: pd.DataFrame) -> None:
    pd.testing.assert_frame_equal(
        table.drop(columns=TIMING_COLUMNS), reference.drop(columns=TIMING_COLUMNS), check_exact=True
    )


def records(folder: Path) -> set[Path]:
    return set((folder / "records").glob("*.json"))


def wait_for(what, process: subprocess.Popen | None = None) -> None:
    end = time.monotonic() + WAIT_SECONDS
    while not what():
        assert time.monotonic() < end, "it took too long"
        assert process is None or process.poll() is None, "it ended too early"
        time.sleep(0.02)


def test_every_trial_is_one_row(undisturbed):
    assert len(undisturbed) == TRIALS
    assert not undisturbed.duplicated(["shape", "color_map", "method", "light_track"]).any()
    assert (undisturbed["error"] == "").all()
    assert undisturbed["angular_error"].between(0, 90).all()


def test_a_study_that_was_stopped_goes_on_with_what_is_missing(tmp_path, undisturbed):
    class EnoughError(Exception):
        pass

    def stop(progress: StudyProgress) -> None:
        if progress.done == 7:
            raise EnoughError

    with pytest.raises(EnoughError):
        run_study(plan(), tmp_path, workers=0, progress=stop)
    before = {path: path.stat().st_mtime_ns for path in records(tmp_path)}
    assert len(before) == len(load_trials(tmp_path)) == 7
    seen: list[StudyProgress] = []
    assert_same(run_study(plan(), tmp_path, workers=0, progress=seen.append), undisturbed)
    assert (seen[0].done, seen[-1].done, seen[-1].total, len(seen)) == (7, TRIALS, TRIALS, TRIALS - 7 + 1)
    assert all(path.stat().st_mtime_ns == written for path, written in before.items())
    assert [run["trials"] for run in load_provenance(tmp_path)["runs"]] == [7, TRIALS - 7]


def test_a_study_in_pieces_is_the_study(tmp_path, undisturbed):
    run_study(plan(methods=["flat"]), tmp_path, workers=0)
    run_study(plan(shapes=["torus"], methods=["toonkit", "lumo"]), tmp_path, workers=0)
    assert_same(run_study(plan(), tmp_path, workers=0), undisturbed)
    assert load_provenance(tmp_path)["methods"] == ["flat", "toonkit", "lumo"]


def test_a_method_is_measured_again_if_that_is_asked_for(tmp_path, monkeypatch):
    small = {"shapes": ["sphere"], "color_maps": MAPS[:1], "methods": ["mine", "flat"]}
    monkeypatch.setitem(METHODS, "mine", METHODS["lumo"])
    first = run_study(plan(**small), tmp_path, workers=0)
    kept = {path: path.stat().st_mtime_ns for path in records(tmp_path)}
    monkeypatch.setitem(METHODS, "mine", METHODS["lambert"])
    pd.testing.assert_frame_equal(run_study(plan(**small), tmp_path, workers=0), first)
    second = run_study(plan(**small), tmp_path, workers=0, again=["mine"])
    written = {path.stem.split("--")[2] for path, at in kept.items() if path.stat().st_mtime_ns != at}
    assert written == {"mine"}
    errors = [table.set_index("method").loc["mine", "angular_error"] for table in (first, second)]
    assert errors[0] != errors[1]


def test_a_table_never_mixes_old_and_new_records_of_a_method_measured_again(tmp_path):
    both = {"color_maps": MAPS[:1], "methods": ["lumo", "flat"]}
    assert len(run_study(plan(**both), tmp_path, workers=0)) == 4
    table = run_study(plan(**both, shapes=["sphere"]), tmp_path, workers=0, again=["lumo"])
    pd.testing.assert_frame_equal(load_trials(tmp_path), table)
    left = set(zip(table["shape"], table["method"], strict=True))
    assert left == {("sphere", "lumo"), ("sphere", "flat"), ("torus", "flat")}
    assert len(run_study(plan(**both), tmp_path, workers=0)) == 4


def test_a_method_to_measure_again_is_one_of_the_plan(tmp_path):
    with pytest.raises(ToonkitError, match="again must be among the plan's lumo, toonkit, flat"):
        run_study(plan(), tmp_path, workers=0, again=["todo"])


def test_a_method_of_a_changed_file_is_measured_again(tmp_path, monkeypatch):
    file = tmp_path / "mine.py"
    monkeypatch.setitem(METHODS, "mine", METHODS["lumo"])

    def measured(text):
        """How many trials a run measures if this is the file of a method of one's own."""
        file.write_text(text)
        small = plan(shapes=["sphere"], methods=["mine", "flat"], method_files={"mine": file})
        seen: list[StudyProgress] = []
        run_study(small, tmp_path / "study", workers=0, progress=seen.append)
        return seen[0].total - seen[0].done

    assert [measured(text) for text in ("x = 1", "x = 1", "x = 2")] == [6, 0, 3]


def test_a_method_of_a_file_does_not_pass_for_the_one_of_toonkit(tmp_path):
    small = {"shapes": ["sphere"], "color_maps": MAPS[:1], "methods": ["lumo"]}
    (tmp_path / "mine.py").write_text("")
    run_study(plan(**small, method_files={"lumo": tmp_path / "mine.py"}), tmp_path / "study", workers=0)
    seen: list[StudyProgress] = []
    run_study(plan(**small), tmp_path / "study", workers=0, progress=seen.append)
    assert seen[0].done == 0


def test_a_study_that_was_killed_shows_what_is_on_file(tmp_path):
    small = {"shapes": ["sphere"], "color_maps": MAPS[:1]}
    run_study(plan(**small, methods=["flat"]), tmp_path, workers=0)
    table = (tmp_path / "trials.parquet").read_bytes()
    run_study(plan(**small, methods=["lumo"]), tmp_path, workers=0)
    (tmp_path / "trials.parquet").write_bytes(table)  # as a killed run leaves it
    os.utime(tmp_path / "trials.parquet", ns=(0, 0))
    assert set(load_trials(tmp_path)["method"]) == {"flat", "lumo"}


def failing(image, light, *, progress=None):
    raise MemoryError("just now")


def test_a_failure_is_measured_again_only_if_that_is_asked_for(tmp_path, monkeypatch):
    small = {"shapes": ["sphere"], "color_maps": MAPS[:1], "methods": ["mine"]}
    attempts = []

    def now_and_then(image, light, *, progress=None):
        attempts.append(light)
        return failing(image, light) if len(attempts) == 1 else METHODS["lumo"](image, light)

    monkeypatch.setitem(METHODS, "mine", now_and_then)
    assert (run_study(plan(**small), tmp_path, workers=0)["error"] == "MemoryError: just now").all()
    attempts[:] = attempts[-1:]
    assert (run_study(plan(**small), tmp_path, workers=0)["error"] == "MemoryError: just now").all()
    assert (run_study(plan(**small), tmp_path, workers=0, retry_failed=True)["error"] == "").all()


def test_a_folder_serves_one_run_at_a_time(tmp_path):
    def another(progress: StudyProgress) -> None:
        with pytest.raises(ToonkitError, match="in use by another run"):
            run_study(plan(), tmp_path, workers=0)

    run_study(
        plan(shapes=["sphere"], color_maps=MAPS[:1], methods=["flat"]), tmp_path, workers=0, progress=another
    )


def test_a_folder_of_other_settings_is_refused(tmp_path):
    small = {"shapes": ["sphere"], "color_maps": MAPS[:1], "methods": ["flat"]}
    run_study(plan(**small), tmp_path, workers=0)
    with pytest.raises(ToonkitError, match="same size and lights"):
        run_study(plan(**small, settings=StudySettings(size=32)), tmp_path, workers=0)


def test_another_version_of_toonkit_measures_its_own_records(tmp_path, monkeypatch):
    small = {"shapes": ["sphere"], "color_maps": MAPS[:1], "methods": ["flat"]}
    run_study(plan(**small), tmp_path, workers=0)
    monkeypatch.setattr(toonkit, "__version__", "another")
    table = run_study(plan(**small), tmp_path, workers=0)
    assert table["toonkit"].tolist() == ["another"]


def test_a_shape_that_cannot_be_rendered_fails_in_all_its_trials(tmp_path, monkeypatch):
    def render(scene, size):
        raise MemoryError("too large")

    monkeypatch.setattr(batches, "render", render)
    table = run_study(plan(), tmp_path, workers=0)
    assert table["error"].tolist() == ["MemoryError: too large"] * TRIALS


def test_a_study_whose_process_was_killed_goes_on(tmp_path, undisturbed):
    with subprocess.Popen([*COMMAND, str(tmp_path)], cwd=ROOT) as process:
        wait_for(lambda: len(records(tmp_path)) >= 3, process)
        process.kill()
    left = records(tmp_path)
    assert 3 <= len(left) < TRIALS
    before = {path: path.stat().st_mtime_ns for path in left}
    assert_same(run_study(plan(), tmp_path, workers=0), undisturbed)
    assert all(path.stat().st_mtime_ns == written for path, written in before.items())


@pytest.fixture
def heeding_ctrl_c():
    """New processes heed Ctrl-C even if these tests were started in the background, where a shell has it ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heeding_ctrl_c")
def test_ctrl_c_ends_all_processes_without_a_stack_trace(tmp_path):
    with subprocess.Popen(
        [*COMMAND, str(tmp_path)], cwd=ROOT, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        wait_for(lambda: len(records(tmp_path)) >= 3, process)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does
        complaint = process.communicate(timeout=WAIT_SECONDS)[1]
    assert process.returncode == 130
    assert complaint.splitlines() == [
        "what was measured is on file: the same command goes on from there",
        "toonkit: interrupted",
    ]
    assert len(load_trials(tmp_path)) == len(records(tmp_path))


def test_a_killed_worker_loses_nothing(tmp_path, undisturbed):
    killed = []

    def kill_one(progress: StudyProgress) -> None:
        if progress.done == 4 and not killed:
            killed.append(_workers_of(os.getpid())[0])
            os.kill(killed[0], signal.SIGKILL)

    table = run_study(plan(), tmp_path, workers=2, progress=kill_one)
    assert killed
    assert_same(table, undisturbed)


def _workers_of(parent: int) -> list[int]:
    psutil = pytest.importorskip("psutil")
    children = psutil.Process(parent).children(recursive=True)
    return [child.pid for child in children if "spawn_main" in " ".join(child.cmdline())]


def fatal(image, light, *, progress=None):
    """A method that takes its process with it."""
    os._exit(1)


def test_a_method_that_kills_its_worker_fails_and_nothing_else_does(tmp_path, monkeypatch):
    monkeypatch.setitem(METHODS, "fatal", fatal)
    small = {"shapes": ["sphere", "torus"], "color_maps": MAPS[:1], "methods": ["fatal", "lumo", "flat"]}
    table = run_study(plan(**small), tmp_path, workers=2)
    assert set(table.loc[table["error"] != "", "method"]) == {"fatal"}
    assert table.loc[table["method"] == "fatal", "error"].str.startswith(LOST).all()
    assert np.isnan(table.loc[table["method"] == "fatal", "angular_error"]).all()
    monkeypatch.setitem(METHODS, "fatal", METHODS["lumo"])
    again = run_study(plan(**small), tmp_path, workers=0)
    assert (again["error"] == "").all()


class NeverDone:
    """A future that no worker takes up."""

    def done(self) -> bool:
        return False


class Deserted:
    """A client of a scheduler that has lost its workers."""

    def nthreads(self) -> dict[str, int]:
        return {}


def test_cells_that_find_no_worker_are_not_waited_for(monkeypatch):
    monkeypatch.setattr(cluster, "LOOK_SECONDS", 0.01)
    monkeypatch.setattr(cluster, "NO_WORKER_SECONDS", 0.05)
    batch = batches.Batch.of(plan().batches()[0], plan())
    assert list(cluster.yield_done({NeverDone(): batch}, Deserted())) == []


def test_the_cluster_of_a_study_answers_to_this_machine_only():
    with cluster.cluster_client(1, None, 1):
        this = psutil.Process()
        connections = [
            one for process in (this, *this.children(recursive=True)) for one in process.net_connections()
        ]
    addresses = {one.laddr.ip for one in connections if one.status == psutil.CONN_LISTEN}
    assert addresses == {"127.0.0.1"}


def test_a_batch_for_another_toonkit_is_refused():
    other = replace(batches.Batch.of(plan().batches()[0], plan()), toonkit="version 0.0")
    with pytest.raises(ToonkitError, match=r"workers must have toonkit version 0\.0; got version"):
        batches.measure(ToonkitError("not looked at"), other)


@pytest.fixture
def scheduler():
    """A dask scheduler and two workers, each a process of its own, as on another machine."""
    address = f"tcp://127.0.0.1:{free_port()}"
    commands = [["scheduler", "--port", address.rsplit(":", 1)[1], "--no-dashboard"]]
    commands += [["worker", address, "--nthreads", "1", "--no-dashboard", "--no-nanny"]] * 2
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    processes = [
        subprocess.Popen(
            [sys.executable, "-m", "dask", *command],
            env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )
        for command in commands
    ]  # fmt: skip
    yield address, processes[0]
    for process in processes:
        process.kill()
        process.wait()


def test_two_processes_joined_to_a_scheduler_give_the_same_table(tmp_path, undisturbed, scheduler):
    address, process = scheduler
    assert_same(run_study(plan(), tmp_path / "by address", scheduler=address), undisturbed)

    def kill(progress: StudyProgress) -> None:
        if progress.done >= 4:
            process.kill()

    with pytest.raises(ToonkitError, match="run the same command again"):
        run_study(plan(), tmp_path / "lost", scheduler=address, progress=kill)
    assert 4 <= len(records(tmp_path / "lost")) < TRIALS
    assert_same(run_study(plan(), tmp_path / "lost", workers=0), undisturbed)


class LostOnTheWay:
    """A client whose scheduler goes away after a batch was measured, before its records have arrived."""

    status = "finished"

    def submit(self, *_, **__):
        return self

    def done(self):
        return True

    def result(self):
        raise ConnectionResetError


def test_records_that_do_not_arrive_are_those_of_a_lost_scheduler():
    batch = Batch.of(next(iter(plan().batches())), plan())
    with pytest.raises(ToonkitError, match=f"lost with {len(batch.trials)} trials to go"):
        list(cluster._submit_all([batch], LostOnTheWay(), []))


class Mixed:
    """A client of a scheduler that has two workers: one with this toonkit, one with another."""

    def wait_for_workers(self, count, *, timeout) -> None:
        pass

    def run(self, function) -> dict[str, str]:
        return {"tcp://a:1": function(), "tcp://b:2": "version 0.0"}


def test_workers_with_another_toonkit_are_refused():
    with pytest.raises(
        ToonkitError, match=r"scheduler must have workers with toonkit .* got tcp://b:2 with version 0\.0"
    ):
        cluster._refuse_other_toonkit(Mixed(), "tcp://c:3")


def test_a_scheduler_that_nobody_works_for_is_refused(tmp_path, monkeypatch):
    with LocalCluster(n_workers=0, dashboard_address=":0") as alone:
        monkeypatch.setattr(cluster, "NO_WORKER_SECONDS", 1)
        with pytest.raises(ToonkitError, match="scheduler must have workers"):
            run_study(plan(), tmp_path, scheduler=alone.scheduler_address)


def test_a_scheduler_that_is_not_there_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 1)
    with pytest.raises(ToonkitError, match="scheduler must be the address"):
        run_study(plan(), tmp_path, scheduler=f"tcp://127.0.0.1:{free_port()}")


@pytest.mark.parametrize(
    "wrong", [{"workers": -1}, {"workers": 2.5}, {"workers": 1, "scheduler": "tcp://a:1"}]
)
def test_workers_that_cannot_be_had_are_refused(tmp_path, wrong):
    with pytest.raises(ToonkitError, match="workers must"):
        run_study(plan(), tmp_path, **wrong)


def test_the_table_on_disk_is_the_one_returned(tmp_path):
    table = run_study(plan(shapes=["sphere"], color_maps=MAPS[:1]), tmp_path, workers=0)
    pd.testing.assert_frame_equal(load_trials(tmp_path), table)
    assert load_provenance(tmp_path)["toonkit"] == toonkit.__version__
