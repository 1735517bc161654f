"""`python -m toonkit.training shape` or `light`: make the shapes, train the network, write its weights."""

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

import numpy as np
from tqdm import tqdm

from toonkit._validation import ToonkitError, refuse
from toonkit.training.dataset import Dataset, make_dataset
from toonkit.training.drawings import Drawings
from toonkit.training.light_task import LightTask
from toonkit.training.network import exported
from toonkit.training.shape_task import ShapeTask
from toonkit.training.train import Task, Training, TrainingOptions

TASKS: dict[str, type[Task]] = {"shape": ShapeTask, "light": LightTask}

DEFAULTS = {"shape": {"steps": 3000, "batch": 32}, "light": {"steps": 2000, "batch": 64}}

KEPT_ASIDE = 400
"""Shapes, the first ones of the dataset, that are never trained on: figures are of drawings of these."""

CHECKED_EVERY = 500
"""Steps between two checkpoints, with figures."""

FIGURE_DRAWINGS = 256
"""Drawings of the shapes kept aside over which the figures are means."""


def main(arguments: list[str] | None = None) -> int:
    """Train; return the exit status."""
    given = _parser().parse_args(arguments)
    try:
        _train(given)
    except ToonkitError as error:
        print(f"toonkit.training: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(f"\nStopped; the same command goes on from the checkpoint in {given.output}.", file=sys.stderr)
        return 130
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m toonkit.training", description=__doc__)
    parser.add_argument("task", choices=sorted(TASKS), help="what to learn")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, help="folder of shapes, checkpoints and weights"
    )
    parser.add_argument(
        "--shapes", type=int, default=7000, help="random shapes to render (default: %(default)s)"
    )
    parser.add_argument("--shape-seed", type=int, default=1, help="seed of the shapes (default: %(default)s)")
    parser.add_argument(
        "--steps", type=int, help="steps of training (default: 3000 for the shape, 2000 for the light)"
    )
    parser.add_argument(
        "--batch", type=int, help="drawings in a step (default: 32 for the shape, 64 for the light)"
    )
    parser.add_argument(
        "--seed", type=int, default=7, help="seed of weights and drawings (default: %(default)s)"
    )
    parser.add_argument("--workers", type=int, default=2, help="processes that render (default: %(default)s)")
    return parser


def _train(given: argparse.Namespace) -> None:
    for option, default in DEFAULTS[given.task].items():
        if getattr(given, option) is None:
            setattr(given, option, default)
    if given.shapes <= KEPT_ASIDE:
        raise refuse("--shapes", f"must be more than the {KEPT_ASIDE} kept aside", given.shapes)
    if given.steps < 1 or given.batch < 4:
        raise refuse("--steps, --batch", "must be at least 1 and 4", (given.steps, given.batch))
    for option in ("workers", "seed", "shape_seed"):
        if getattr(given, option) < (option == "workers"):
            raise refuse(f"--{option.replace('_', '-')}", "must not be so low", getattr(given, option))
    if given.output.exists() and not given.output.is_dir():
        raise refuse("--output", "must be a folder", given.output)
    dataset = _dataset(given)
    options = {name: getattr(given, name) for name in ("steps", "batch", "seed", "shapes", "shape_seed")}
    training = Training(TASKS[given.task](), TrainingOptions(**options))
    checkpoint = given.output / f"{training.task.name}.pt"
    if checkpoint.exists():
        training.load(checkpoint)
    stopping = _asked_to_stop()
    learned, aside = Drawings(dataset, KEPT_ASIDE, len(dataset)), Drawings(dataset, 0, KEPT_ASIDE)
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
    _write_weights(given, training)


def _dataset(given: argparse.Namespace) -> Dataset:
    return make_dataset(
        given.output / "shapes",
        given.shapes,
        given.shape_seed,
        workers=given.workers,
        progress=lambda shards: tqdm(shards, desc="rendering shapes", unit="shard"),
    )


def _write_weights(given: argparse.Namespace, training: Training) -> None:
    """Write the averaged weights as 16-bit numbers, and beside them how they were made."""
    name = training.task.name
    weights = {layer: values.astype(np.float16) for layer, values in exported(training.average).items()}
    path = given.output / f"{name}.npz"
    unfinished = path.with_suffix(".part")
    with unfinished.open("wb") as file:
        np.savez(file, allow_pickle=False, **weights)
    unfinished.replace(path)
    provenance = {
        "command": f"python -m toonkit.training {given.task} -o DIR --shapes {given.shapes} "
        f"--shape-seed {given.shape_seed} --steps {given.steps} --batch {given.batch} --seed {given.seed}",
        "data": "random solids of toonkit.training.solids, painted by random color maps of toonkit.training.painting",
        "parameters": int(sum(values.size for values in weights.values())),
        "seconds": round(training.seconds),
        "processor": platform.processor() or platform.machine(),
        "versions": {package: version(package) for package in ("torch", "numpy")},
        "figures, degrees, on shapes kept aside": training.history,
    }
    path.with_suffix(".json").write_text(json.dumps(provenance, indent=2) + "\n", encoding="utf-8")
    print(f"Weights in {path}; toonkit/estimation/weights/ is where they ship.")


def _asked_to_stop() -> Callable[[], bool]:
    """Let a signal wait for the end of the running step, as half a step cannot be gone on from; return whether one came."""
    came = []

    def remember(number: int, _frame: FrameType | None) -> None:
        came.append(number)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, remember)
    return lambda: bool(came)


if __name__ == "__main__":
    sys.exit(main())
