"""`python -m toonkit.training shape`, `colored_shape` or `light`: make the shapes, train the network, write its weights."""

from __future__ import annotations

import argparse
import json
import platform
import signal
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
from tqdm import tqdm

from toonkit._validation import ToonkitError, refuse
from toonkit.estimation.convolution import Weights
from toonkit.estimation.weights import packed, weights_in
from toonkit.export.atomic import atomic_write
from toonkit.training.dataset import Dataset, make_dataset
from toonkit.training.drawings import Drawings
from toonkit.training.light_task import LightTask
from toonkit.training.shape_task import ColoredShapeTask, ShapeTask
from toonkit.training.train import FIGURES, STORED_OPTIONS, Task, Training, TrainingOptions

TASKS: dict[str, type[Task]] = {"shape": ShapeTask, "colored_shape": ColoredShapeTask, "light": LightTask}

DEFAULTS = {
    "shape": {"steps": 11500, "batch": 32},
    "colored_shape": {"steps": 2200, "batch": 32},
    "light": {"steps": 8800, "batch": 64},
}

KEPT_ASIDE = 400
"""Shapes, the first ones of the dataset, that are never trained on: figures are of drawings of these."""

CHECKED_EVERY = 500
"""Steps between two checkpoints, with figures."""

STARTED_FROM = "started from"

FIGURE_DRAWINGS = 256
"""Drawings of the shapes kept aside over which the figures are means."""


def main(arguments: list[str] | None = None) -> int:
    """Train; return the exit status."""
    given = _parser().parse_args(arguments)
    try:
        _train(given)
    except ToonkitError as error:
        print(f"training: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(f"\nStopped; the same command goes on from the checkpoint in {given.output}.", file=sys.stderr)
        return 130
    return 0


def _parser() -> argparse.ArgumentParser:
    usual = TrainingOptions(steps=0)
    parser = argparse.ArgumentParser(prog="python -m toonkit.training", description=__doc__)
    parser.add_argument("task", choices=sorted(TASKS), help="what to learn")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, help="folder of shapes, checkpoints and weights"
    )
    parser.add_argument(
        "--start", type=Path, help="checkpoint (.pt) of an earlier training to begin with, or weights (.npz)"
    )
    parser.add_argument(
        "--shapes", type=int, default=usual.shapes, help="random shapes to render (default: %(default)s)"
    )
    parser.add_argument(
        "--shape-seed", type=int, default=usual.shape_seed, help="seed of the shapes (default: %(default)s)"
    )
    for option, help_text in (("steps", "steps of training"), ("batch", "drawings in a step")):
        defaults = ", ".join(f"{DEFAULTS[task][option]} for the {task}" for task in DEFAULTS)
        parser.add_argument(f"--{option}", type=int, help=f"{help_text} (default: {defaults})")
    parser.add_argument(
        "--rate", type=float, default=usual.rate, help="highest learning rate (default: %(default)s)"
    )
    parser.add_argument(
        "--keep", type=float, default=usual.keep,
        help="share of the weights (.npz) it started from in what it writes (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--seed", type=int, default=usual.seed, help="seed of weights and drawings (default: %(default)s)"
    )
    parser.add_argument("--workers", type=int, default=2, help="processes that render (default: %(default)s)")
    return parser


def _train(given: argparse.Namespace) -> None:
    for option, default in DEFAULTS[given.task].items():
        if getattr(given, option) is None:
            setattr(given, option, default)
    least = {"shapes": KEPT_ASIDE + 1, "shape_seed": 0, "steps": 1, "batch": 4, "seed": 0, "workers": 1}
    for option, lowest in least.items():
        if getattr(given, option) < lowest:
            raise refuse(
                f"--{option.replace('_', '-')}", f"must be at least {lowest}", getattr(given, option)
            )
    if not 0.0 < given.rate < 1.0:
        raise refuse("--rate", "must be between 0 and 1", given.rate)
    if not 0.0 <= given.keep < 1.0:
        raise refuse("--keep", "must be at least 0 and less than 1", given.keep)
    if given.keep and (given.start is None or given.start.suffix != ".npz"):
        raise refuse("--keep", "needs weights (.npz) to --start from", given.keep)
    if given.start is not None and not given.start.is_file():
        raise refuse("--start", "must be a file that exists", given.start)
    if given.output.exists() and not given.output.is_dir():
        raise refuse("--output", "must be a folder", given.output)
    dataset = _dataset(given)
    training = Training(
        TASKS[given.task](), TrainingOptions(**{name: getattr(given, name) for name in STORED_OPTIONS})
    )
    checkpoint = given.output / f"{training.task.name}.pt"
    learned, aside = Drawings(dataset, KEPT_ASIDE, len(dataset)), Drawings(dataset, 0, KEPT_ASIDE)
    if checkpoint.exists():
        training.load(checkpoint)
    elif given.start is not None and given.start.suffix == ".npz":
        training.start_from_weights(*_stored_weights(given.start), learned)
    elif given.start is not None:
        training.start_from(given.start)
    if training.step == 0 and training.earlier and not training.history:
        figures = training.task.figures(training.average, aside, FIGURE_DRAWINGS)
        training.history.append({"step": 0, **figures})
    stopping = _watch_for_stop()
    with tqdm(total=given.steps, initial=training.step, desc=f"training {given.task}", unit="step") as bar:
        while training.step < given.steps:
            bar.set_postfix(error=f"{training.advance(learned):.1f}°", refresh=False)
            bar.update()
            if training.step % CHECKED_EVERY == 0 or training.step == given.steps:
                figures = training.task.figures(training.average, aside, FIGURE_DRAWINGS)
                training.history.append({"step": training.step, **figures})
                training.save(checkpoint)
            if stopping():
                training.save(checkpoint)
                raise KeyboardInterrupt
    history = training.history
    if training.options.keep:
        mixed = training.task.figures(training.shipped_network(), aside, FIGURE_DRAWINGS)
        history = [*history, {"step": training.step, "kept": training.options.keep, **mixed}]
    _write_weights(given, training, history)


def _dataset(given: argparse.Namespace) -> Dataset:
    return make_dataset(
        given.output / "shapes",
        given.shapes,
        given.shape_seed,
        workers=given.workers,
        progress=lambda shards, count: tqdm(shards, total=count, desc="rendering shapes", unit="shard"),
    )


def _stored_weights(path: Path) -> tuple[Weights, list[dict[str, Any]]]:
    """Read weights that `_write_weights` wrote, and the records of the trainings that made them, the first one first."""
    record = path.with_suffix(".json")
    if not record.is_file():
        raise refuse("--start", f"must have its record {record.name} beside it", path)
    made = json.loads(record.read_text(encoding="utf-8"))
    last = {"command": made["command"], "steps": made[FIGURES][-1]["step"]}
    last |= {name: made[name] for name in ("seconds", FIGURES, "note") if name in made}
    with path.open("rb") as file:
        return weights_in(file), [*made.get(STARTED_FROM, []), last]


def _write_weights(given: argparse.Namespace, training: Training, history: list[dict[str, float]]) -> None:
    """Write the averaged weights, packed, and beside them how they were made."""
    name, weights = training.task.name, training.shipped()
    path = given.output / f"{name}.npz"
    provenance: dict[str, Any] = {
        **training.record,
        FIGURES: history,
        "data": "random solids of training.families, painted by random color maps of training.painting "
        "and materials of training.materials, inked by training.inking",
        "parameters": int(sum(values.size for values in weights.values())),
        "processor": platform.processor() or platform.machine(),
        "versions": {package: version(package) for package in ("torch", "numpy")},
    }
    if training.earlier:
        provenance[STARTED_FROM] = training.earlier
    with atomic_write(path) as file:
        np.savez(file, allow_pickle=False, **packed(weights))
    with atomic_write(path.with_suffix(".json")) as file:
        file.write((json.dumps(provenance, indent=2) + "\n").encode())
    print(f"Weights in {path}; toonkit/estimation/weights/ is where they ship.")


def _watch_for_stop() -> Callable[[], bool]:
    """Let a signal wait for the end of the running step, as half a step cannot be gone on from; return whether one came."""
    came = []

    def remember(number: int, _frame: FrameType | None) -> None:
        came.append(number)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, remember)
    return lambda: bool(came)


if __name__ == "__main__":
    sys.exit(main())
