"""`python -m toonkit.training`: from nothing to weights, again from where it was stopped, and what it refuses."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import torch

from toonkit.estimation import convolution, light_prior, shape_prior, weights
from toonkit.estimation.working_square import SIZE
from toonkit.training import __main__ as command
from toonkit.training import dataset
from toonkit.training.train import Training

pytestmark = pytest.mark.usefixtures("narrow", "one_thread")

KINDS = pytest.mark.parametrize("kind", ["shape", "colored_shape", "light"])


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Six shapes in three files, made by threads: a process of its own would not know how small they are."""
    monkeypatch.setattr(dataset, "SHARD", 2)
    monkeypatch.setattr(dataset, "ProcessPoolExecutor", lambda workers, **_: ThreadPoolExecutor(workers))
    monkeypatch.setattr(command, "KEPT_ASIDE", 2)
    monkeypatch.setattr(command, "CHECKED_EVERY", 2)
    monkeypatch.setattr(command, "FIGURE_DRAWINGS", 4)
    handlers = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}
    yield
    for number, handler in handlers.items():
        signal.signal(number, handler)


@pytest.fixture(scope="module")
def shapes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which all tests of this file find the shapes they train on."""
    return tmp_path_factory.mktemp("shapes")


@pytest.fixture
def output(tmp_path: Path, shapes: Path) -> Path:
    (tmp_path / "shapes").symlink_to(shapes, target_is_directory=True)
    return tmp_path


def run(kind: str, output: Path, **options: object) -> int:
    given: dict[str, object] = {"shapes": 6, "steps": 5, "batch": 4, "workers": 1} | options
    words = [word for name, value in given.items() for word in (f"--{name.replace('_', '-')}", str(value))]
    return command.main([kind, "-o", str(output), *words])


def weights_in(output: Path, kind: str) -> dict[str, np.ndarray]:
    with (output / f"{kind}_prior.npz").open("rb") as file:
        return weights.weights_in(file)


def differing(first: dict[str, np.ndarray], second: dict[str, np.ndarray]) -> list[str]:
    assert first.keys() == second.keys()
    return [name for name in first if not np.array_equal(first[name], second[name])]


@KINDS
def test_it_makes_shapes_trains_and_writes_weights_that_run(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(kind, tmp_path) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        f"{kind}_prior.{end}" for end in ("json", "npz", "pt")
    ] + ["shapes"]
    assert len(list((tmp_path / "shapes").iterdir())) == 3
    with np.load(tmp_path / f"{kind}_prior.npz") as stored:
        assert {stored[name].dtype for name in stored.files if name.endswith(".weight")} <= {
            np.dtype(np.int8),
            np.dtype(np.float16),
        }
    channels, ask, shape = {
        "shape": (shape_prior.CHANNELS, convolution.field, (3, SIZE, SIZE)),
        "colored_shape": (shape_prior.CHANNELS + 1, convolution.field, (3, SIZE, SIZE)),
        "light": (light_prior.CHANNELS, convolution.summary, (4,)),
    }[kind]
    answer = ask(weights_in(tmp_path, kind), np.ones((channels, SIZE, SIZE), np.float32))
    assert answer.shape == shape
    assert np.isfinite(answer).all()
    assert answer.any()
    assert str(tmp_path / f"{kind}_prior.npz") in capsys.readouterr().out


@KINDS
def test_the_weights_say_how_they_were_made(kind: str, output: Path) -> None:
    run(kind, output, seed=11, shape_seed=3)
    text = (output / f"{kind}_prior.json").read_text(encoding="utf-8")
    made = json.loads(text)
    command_line = (
        f"{kind} -o DIR --shapes 6 --shape-seed 3 --steps 5 --batch 4 --rate 0.002 --keep 0.0 --seed 11"
    )
    assert made["command"] == f"python -m toonkit.training {command_line}"
    assert made["parameters"] == sum(values.size for values in weights_in(output, kind).values())
    assert (
        made["versions"]["torch"] == torch.__version__.partition("+")[0]
        or made["versions"]["torch"] == torch.__version__
    )
    history = made["figures, degrees, on shapes kept aside"]
    assert [entry["step"] for entry in history] == [2, 4, 5]
    assert all(0 < value < 180 for entry in history for name, value in entry.items() if name != "step")
    assert str(output) not in text  # nothing of this machine


@KINDS
def test_a_finished_training_trains_no_further(
    kind: str, output: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(kind, output)
    trained = weights_in(output, kind)
    monkeypatch.setattr(Training, "advance", None)
    assert run(kind, output) == 0
    assert differing(weights_in(output, kind), trained) == []


def stopping(at: int, number: signal.Signals) -> Callable[..., None]:
    """In the place of `Tensor.backward`: a signal comes in the middle of a step."""
    backward, calls = torch.Tensor.backward, iter(range(1, 1000))

    def interrupted(loss: torch.Tensor) -> None:
        if next(calls) == at:
            signal.raise_signal(number)
        backward(loss)

    return interrupted


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@KINDS
def test_a_training_stopped_in_the_middle_of_a_step_goes_on_as_if_it_had_not_been(
    kind: str,
    number: signal.Signals,
    output: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    run(kind, output)
    through = weights_in(output, kind)
    for path in output.glob("*.*"):
        path.unlink()
    with monkeypatch.context() as patch:
        patch.setattr(torch.Tensor, "backward", stopping(4, number))
        capsys.readouterr()
        assert run(kind, output) == 130
    last = capsys.readouterr().err.strip().splitlines()[-1]
    assert last == f"Stopped; the same command goes on from the checkpoint in {output}."
    assert not (output / f"{kind}_prior.npz").exists()
    assert run(kind, output) == 0
    assert differing(weights_in(output, kind), through) == []


def test_shapes_kept_aside_are_never_trained_on(output: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: dict[str, set[tuple[int, int]]] = {"trained": set(), "figures": set()}
    advance, task = Training.advance, command.TASKS["light"]
    figures = task.figures

    def watched_advance(training, drawings):
        seen["trained"].add((drawings.first, drawings.last))
        return advance(training, drawings)

    def watched_figures(self, average, drawings, count):
        seen["figures"].add((drawings.first, drawings.last))
        return figures(self, average, drawings, count)

    monkeypatch.setattr(Training, "advance", watched_advance)
    monkeypatch.setattr(task, "figures", watched_figures)
    run("light", output)
    assert seen == {"trained": {(2, 6)}, "figures": {(0, 2)}}


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"shapes": 2}, "--shapes must be at least 3; got 2"),
        ({"shapes": -5}, "--shapes must be at least 3; got -5"),
        ({"steps": 0}, "--steps must be at least 1; got 0"),
        ({"batch": 3}, "--batch must be at least 4; got 3"),
        ({"workers": 0}, "--workers must be at least 1; got 0"),
        ({"seed": -1}, "--seed must be at least 0; got -1"),
        ({"shape_seed": -1}, "--shape-seed must be at least 0; got -1"),
        ({"rate": 0.0}, "--rate must be between 0 and 1; got 0.0"),
        ({"keep": 1.0}, "--keep must be at least 0 and less than 1; got 1.0"),
        ({"keep": 0.5}, "--keep needs weights (.npz) to --start from; got 0.5"),
        ({"start": "nowhere.pt"}, "--start must be a file that exists; got nowhere.pt"),
    ],
)
def test_bad_arguments_are_refused_in_one_line(
    options: dict[str, object], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("shape", tmp_path / "new", **options) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 1
    assert said[0].startswith("training: ")
    assert words in said[0]
    assert not (tmp_path / "new").exists()


def test_an_output_that_is_a_file_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("in the way")
    assert run("shape", tmp_path / "file") == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


@pytest.mark.parametrize("ending", ["pt", "npz"])
@KINDS
def test_a_training_started_from_another_says_so(
    kind: str, ending: str, output: Path, tmp_path_factory
) -> None:
    run(kind, output, shape_seed=3)
    second = tmp_path_factory.mktemp("second")
    (second / "shapes").symlink_to(output / "shapes", target_is_directory=True)
    assert run(kind, second, steps=3, shape_seed=3, start=output / f"{kind}_prior.{ending}") == 0
    first, made = (
        json.loads((folder / f"{kind}_prior.json").read_text(encoding="utf-8")) for folder in (output, second)
    )
    assert "--start BEFORE" in made["command"]
    (earlier,) = made["started from"]
    assert earlier["command"] == first["command"]
    figures = "figures, degrees, on shapes kept aside"
    assert earlier[figures] == first[figures]
    assert "started from" not in first
    (second / f"{kind}_prior.json").unlink()
    assert run(kind, second, steps=3, shape_seed=3) == 0  # gone on with, and told no more of the start
    again = json.loads((second / f"{kind}_prior.json").read_text(encoding="utf-8"))
    assert again["command"] == made["command"]


@KINDS
def test_what_is_kept_of_the_weights_it_started_from_is_in_what_it_writes(
    kind: str, output: Path, tmp_path_factory
) -> None:
    run(kind, output)
    before = weights_in(output, kind)
    written = []
    for keep in (0.0, 0.75):
        folder = tmp_path_factory.mktemp("next")
        (folder / "shapes").symlink_to(output / "shapes", target_is_directory=True)
        assert run(kind, folder, seed=8, start=output / f"{kind}_prior.npz", keep=keep) == 0
        written.append(weights_in(folder, kind))
    made = json.loads((folder / f"{kind}_prior.json").read_text(encoding="utf-8"))
    assert "--keep 0.75" in made["command"]
    figures = "figures, degrees, on shapes kept aside"
    assert [entry["step"] for entry in made[figures]] == [0, 2, 4, 5, 5]
    *_, last, mixed = made[figures]
    assert mixed["kept"] == 0.75
    assert mixed.keys() - {"kept"} == last.keys()
    options = {"seed": 8, "keep": 0.75, "start": output / f"{kind}_prior.npz"}
    assert run(kind, folder, **options) == 0  # from its checkpoint
    assert differing(weights_in(folder, kind), written[1]) == []
    for name, values in before.items():
        mixed = 0.25 * written[0][name].astype(float) + 0.75 * values
        rounding = np.abs(mixed).max() / 100 + 2.0**-24  # of 8-bit kernels, and of the least 16-bit numbers
        assert written[1][name] == pytest.approx(mixed, abs=rounding)


@pytest.mark.parametrize(
    ("ending", "words"),
    [
        ("pt", "start must be a checkpoint of the shape_prior; got one of the light_prior"),
        ("npz", "start must be weights of the shape_prior; got those of another network"),
    ],
)
def test_what_another_task_learned_is_no_start(
    ending: str, words: str, output: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run("light", output)
    capsys.readouterr()
    assert run("shape", output, start=output / f"light_prior.{ending}") == 2
    assert capsys.readouterr().err.splitlines()[-1] == f"training: {words}"


def test_weights_without_their_record_are_no_start(output: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run("light", output)
    (output / "light_prior.json").unlink()
    (output / "light_prior.pt").unlink()
    capsys.readouterr()
    assert run("light", output, start=output / "light_prior.npz") == 2
    assert "must have its record light_prior.json beside it" in capsys.readouterr().err.splitlines()[-1]


@pytest.mark.parametrize("changed", [{"seed": 8}, {"batch": 5}, {"steps": 9}])
def test_a_checkpoint_of_other_options_is_not_taken_for_ones_own(
    changed: dict[str, int], output: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What ships says how it was made: that must be true."""
    run("light", output)
    made = (output / "light_prior.json").read_text(encoding="utf-8")
    capsys.readouterr()
    assert run("light", output, **changed) == 2
    assert capsys.readouterr().err.splitlines()[-1].startswith("training: ")
    assert (output / "light_prior.json").read_text(encoding="utf-8") == made


@pytest.mark.parametrize(
    "arguments", [[], ["shape"], ["color", "-o", "out"], ["light", "-o", "out", "--steps", "many"]]
)
def test_arguments_that_mean_nothing_show_the_usage(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        command.main(arguments)
    assert capsys.readouterr().err.startswith("usage: python -m toonkit.training")
