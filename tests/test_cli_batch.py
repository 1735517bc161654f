"""A batch ends with the files that `toonkit analyze` writes, however often and however hard it was stopped."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import psutil
import pytest
from distributed import LocalCluster
from PIL import Image

from tests.dashboards.conftest import free_port
from tests.fatal_work import FatalWork
from toonkit.cli import main
from toonkit.cli.batch import LAYERED_SUFFIXES, SUFFIXES, _folder_names
from toonkit.cli.batch_work import ENDED, BatchItem, analyzed_in_processes
from toonkit.cli.drawing_work import DrawingWork
from toonkit.export.folder import ARCHIVE_NAME, REPORT_NAME
from toonkit.export.picture import write_picture
from toonkit.model import decoding
from toonkit.study import cluster
from toonkit.synthetic.drawing import draw_scene

ROOT = Path(__file__).parents[1]
DRAWINGS = [f"drawing {number}" for number in range(3)]
WAIT_SECONDS = 120


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Three drawings, each larger than the one before, a broken one, and what is none."""
    home = tmp_path_factory.mktemp("folder")
    for number, name in enumerate(DRAWINGS):
        write_picture(draw_scene(number, size=64 << number).image, home / f"{name}.png")
    (home / "broken.jpg").write_bytes(b"no picture")
    (home / "notes.txt").write_text("mine")
    (home / ".hidden.png").write_bytes(b"no picture")
    (home / "below.png").mkdir()
    return home


def contents(out):
    """The files below a folder with their bytes."""
    return {
        str(path.relative_to(out)): path.read_bytes() for path in sorted(out.rglob("*")) if path.is_file()
    }


@pytest.fixture(scope="module")
def in_one_go(folder, tmp_path_factory):
    """What a batch writes that runs through, in this process."""
    out = tmp_path_factory.mktemp("in one go")
    assert main(["batch", str(folder), "-o", str(out), "--workers", "0", "--quiet"]) == 1
    return contents(out)


def test_a_batch_writes_what_analyze_writes_but_for_its_seconds(folder, in_one_go, tmp_path):
    for name in DRAWINGS[:2]:
        out = tmp_path / name
        assert main(["analyze", str(folder / f"{name}.png"), "-o", str(out), "--quiet"]) == 0
        single = contents(out)
        report = json.loads(single.pop(REPORT_NAME))
        assert report.pop("seconds")
        assert report == json.loads(in_one_go[f"{name}/{REPORT_NAME}"])
        batch = {key: value for key, value in in_one_go.items() if key.startswith(f"{name}/")}
        assert {f"{name}/{key}" for key in single} == batch.keys() - {f"{name}/{REPORT_NAME}"}
        assert all(batch[f"{name}/{key}"] == value for key, value in single.items())


def test_what_cannot_be_read_is_told_at_the_end_and_nothing_else_fails(folder, in_one_go, tmp_path, capsys):
    assert main(["batch", str(folder), "-o", str(tmp_path), "--workers", "0"]) == 1
    said, complained = capsys.readouterr()
    assert "4 drawings: 3 analyzed in" in said
    assert ", 0 analyzed before, 1 failed" in said
    errors = [line for line in complained.splitlines() if line.startswith("toonkit: error: ")]
    assert len(errors) == 1
    assert errors[0].startswith(f"toonkit: error: {folder / 'broken.jpg'}: source must be a PNG")
    assert {name.split("/")[0] for name in in_one_go} == {*DRAWINGS, ".lock"}


def test_a_batch_whose_drawings_are_all_fine_ends_with_0(folder, tmp_path):
    (tmp_path / "one").mkdir()
    (tmp_path / "one" / "a.png").write_bytes((folder / f"{DRAWINGS[0]}.png").read_bytes())
    command = ["batch", str(tmp_path / "one"), "-o", str(tmp_path / "out"), "--workers", "0", "--quiet"]
    assert main(command) == 0


def test_a_warning_tells_of_which_drawing_it_is(tmp_path, capsys):
    path = tmp_path / "drawings" / "odd.png"
    path.parent.mkdir()
    Image.fromarray(draw_scene(0, size=64).image.to_rgba()).save(path, icc_profile=b"damaged")
    command = ["batch", str(path.parent), "-o", str(tmp_path / "out"), "--workers", "0", "--quiet"]
    assert main([*command, "--method", "lambert", "--light", "130,42"]) == 0
    (warning,) = capsys.readouterr().err.splitlines()
    assert warning.startswith(f"toonkit: warning: {path}: source: its color profile is damaged")


def test_the_suffixes_are_those_of_the_formats_that_are_read():
    Image.init()
    kinds = {Image.registered_extensions()[suffix] for suffix in SUFFIXES if suffix not in LAYERED_SUFFIXES}
    assert kinds == {*decoding._FORMATS, "TIFF"}


@contextmanager
def hearing_interrupts():
    """Undo what a shell does to a job in the background, these tests perhaps: what they start would not hear Ctrl-C."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@hearing_interrupts()
def batch(folder, out, *options):
    return subprocess.Popen(
        [sys.executable, "-m", "toonkit", "batch", folder, "-o", out, "--quiet", *options],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stderr=subprocess.PIPE,
        text=True,
    )


def reports(out):
    return {path: path.stat().st_mtime_ns for path in out.glob(f"*/{REPORT_NAME}")}


@pytest.mark.parametrize("stop", [signal.SIGKILL, signal.SIGINT])
def test_a_batch_that_was_stopped_goes_on_and_ends_as_one_in_one_go(folder, in_one_go, tmp_path, stop):
    process = batch(folder, tmp_path, "--workers", "1")
    deadline = time.monotonic() + WAIT_SECONDS
    while not reports(tmp_path) and time.monotonic() < deadline:
        time.sleep(0.01)
    workers = psutil.Process(process.pid).children(recursive=True)
    for worker in workers:  # else the batch might be through before it is stopped
        worker.suspend()
    process.send_signal(stop)
    for worker in workers:
        worker.resume()
    _, complained = process.communicate(timeout=WAIT_SECONDS)
    assert process.returncode == (130 if stop == signal.SIGINT else -stop)
    assert ("the same command goes on from there" in complained) is (stop == signal.SIGINT)
    assert psutil.wait_procs(workers, timeout=WAIT_SECONDS)[1] == []
    done = reports(tmp_path)
    assert done
    # Interrupted, it finishes what has begun; killed, it does not.
    assert len(done) < len(DRAWINGS) or stop == signal.SIGINT
    assert main(["batch", str(folder), "-o", str(tmp_path), "--workers", "0", "--quiet"]) == 1
    assert contents(tmp_path) == in_one_go
    assert reports(tmp_path).items() >= done.items()


@pytest.fixture
def out(folder, in_one_go, tmp_path):
    """A folder that a batch has been written to."""
    for name, content in in_one_go.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    return tmp_path


def analyzed_again(folder, out, *options):
    """Run a batch once more; return the names of the drawings that it analyzes."""
    before = reports(out)
    assert main(["batch", str(folder), "-o", str(out), "--workers", "0", "--quiet", *options]) == 1
    return {path.parent.name for path in reports(out).items() - before.items() for path in path[:1]}


def test_nothing_is_done_twice(folder, out):
    assert analyzed_again(folder, out) == set()


def test_again_does_all_of_it(folder, out):
    assert analyzed_again(folder, out, "--again") == set(DRAWINGS)


def test_what_lacks_a_file_is_analyzed_again(folder, in_one_go, out):
    (out / DRAWINGS[1] / ARCHIVE_NAME).unlink()
    assert analyzed_again(folder, out) == {DRAWINGS[1]}
    assert contents(out) == in_one_go


def test_what_was_left_half_replaced_is_analyzed_again(folder, in_one_go, out):
    report = json.loads((out / DRAWINGS[1] / REPORT_NAME).read_text())
    del report["inputs"]
    (out / DRAWINGS[1] / REPORT_NAME).write_text(json.dumps(report))
    (out / DRAWINGS[1] / ".input.png.toonkit-0123456789ab.tmp").write_bytes(b"cut off")
    assert analyzed_again(folder, out) == {DRAWINGS[1]}
    assert contents(out) == in_one_go


def test_what_another_version_wrote_is_analyzed_again(folder, out):
    path = out / DRAWINGS[2] / REPORT_NAME
    path.write_text(path.read_text().replace('"toonkit": "', '"toonkit": "0.0.', 1))
    assert analyzed_again(folder, out) == {DRAWINGS[2]}


def test_other_options_are_another_analysis(folder, out):
    lumo = "--method", "lumo", "--light"
    assert analyzed_again(folder, out, *lumo, "130,42") == set(DRAWINGS)
    assert analyzed_again(folder, out, *lumo, "130.0,42", "--bleed", "4") == set()
    assert analyzed_again(folder, out, *lumo, "130,42", "--engine", "godot") == set(DRAWINGS)
    assert (out / DRAWINGS[0] / "base_color_n.png").is_file()
    assert analyzed_again(folder, out, *lumo, "130,42", "--engine", "godot", "--bleed", "4") == set(DRAWINGS)


def test_a_drawing_that_changed_is_analyzed_again(out, folder, tmp_path_factory):
    changed = tmp_path_factory.mktemp("changed")
    for path in folder.glob("*.*"):
        if path.is_file():
            (changed / path.name).write_bytes(path.read_bytes())
    write_picture(draw_scene(9, size=64).image, changed / f"{DRAWINGS[1]}.png")
    assert analyzed_again(changed, out) == {DRAWINGS[1]}


def test_a_folder_is_for_one_batch_at_a_time(folder, tmp_path, capsys):
    from toonkit.export.sole_use import sole_use

    with sole_use(tmp_path):
        assert main(["batch", str(folder), "-o", str(tmp_path)]) == 2
    assert "must not be in use by another run" in capsys.readouterr().err


def test_a_drawing_that_ends_its_process_fails_and_nothing_else_does(folder, tmp_path):
    kinds = [FatalWork, DrawingWork]  # the second is handed over when the first ends their process
    items = [
        BatchItem(kind(name, folder / f"{name}.png", "130,42", "lumo"), tmp_path / name)
        for kind, name in zip(kinds, DRAWINGS, strict=False)
    ]
    outcomes = {outcome.item.work.drawing: outcome.error for outcome in analyzed_in_processes(items, 1)}
    assert outcomes == {DRAWINGS[0]: ENDED, DRAWINGS[1]: None}
    assert set(reports(tmp_path)) == {tmp_path / DRAWINGS[1] / REPORT_NAME}


def test_workers_of_a_scheduler_write_the_same(folder, in_one_go, tmp_path, capsys):
    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="tcp", dashboard_address=":0"
    ) as there:
        command = [
            "batch",
            str(folder),
            "-o",
            str(tmp_path),
            "--scheduler",
            there.scheduler_address,
            "--quiet",
        ]
        assert main(command) == 1
    assert contents(tmp_path) == in_one_go
    (error,) = capsys.readouterr().err.strip().splitlines()
    assert str(folder / "broken.jpg") in error
    assert "analysis" not in error  # of the worker's folder nothing is told


def test_a_scheduler_that_is_not_there_is_refused(folder, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 1)
    address = f"tcp://127.0.0.1:{free_port()}"
    assert main(["batch", str(folder), "-o", str(tmp_path), "--scheduler", address]) == 2
    assert "scheduler must be the address of a running dask scheduler" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("names", "folders"),
    [
        (["a.png", "b.jpg"], ["a", "b"]),
        (["a.png", "a.jpg", "b.png"], ["a.png", "a.jpg", "b"]),
        (["a.png", "a.jpg", "a.png.webp"], ["a.png", "a.jpg", "a.png.webp"]),
    ],
)
def test_each_drawing_has_a_folder_of_its_own(names, folders):
    assert _folder_names([Path(name) for name in names]) == folders


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ("{tmp}/nowhere -o {tmp}/out", "folder must be an existing folder"),
        ("{tmp} -o {tmp}/out", "folder must hold pictures"),
        ("{folder} -o {tmp}/out --light left", "--light must be AZIMUTH,ELEVATION"),
        ("{folder} -o {tmp}/out --workers -1", "--workers must be a whole number"),
        ("{folder} -o {tmp}/out --workers 1 --scheduler tcp://a:1", "not allowed with"),
        ("{folder} -o {tmp}/out --method magic", "invalid choice: 'magic'"),
        ("{folder} -o {tmp}/out --engine godot --bleed -1", "--bleed must be a number of pixels >= 0"),
    ],
)
def test_what_cannot_be_done_is_refused_in_one_line(folder, tmp_path, capsys, arguments, reason):
    assert main(["batch", *arguments.format(folder=folder, tmp=tmp_path).split()]) == 2
    complained = capsys.readouterr().err
    assert reason in complained
    assert complained.count("\n") == 1
    assert not list(tmp_path.iterdir())
