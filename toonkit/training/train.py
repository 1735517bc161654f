"""Training: steps, an average of the weights over them, and checkpoints from which it goes on."""

from __future__ import annotations

import copy
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import torch
from torch import Tensor, nn

from toonkit._validation import refuse
from toonkit.export.atomic import atomic_write
from toonkit.training.drawings import Drawings

AVERAGING = 0.998
"""What is kept of the averaged weights at each step; the average is what ships."""


class Task(Protocol):
    """What a network learns."""

    name: str

    def network(self) -> nn.Module:
        """Build the network, untrained."""
        ...

    def loss(
        self,
        network: nn.Module,
        average: nn.Module,
        drawings: Drawings,
        rng: np.random.Generator,
        size: int,
        step: int,
    ) -> tuple[Tensor, float]:
        """Return the loss of a batch, and its mean error in degrees."""
        ...

    def figures(self, average: nn.Module, drawings: Drawings, count: int) -> dict[str, float]:
        """Return how good the averaged network is on drawings that never change."""
        ...


@dataclass(frozen=True)
class TrainingOptions:
    """
    How a network is trained.

    Attributes
    ----------
    steps : int
        Steps in all; the learning rate falls to zero over them.
    batch : int
        Drawings in a step.
    rate : float
        Highest learning rate.
    warmup : int
        Steps over which it rises.
    decay : float
        Weight decay.
    seed : int
        Of weights and drawings.
    shapes, shape_seed : int
        How many shapes the drawings are of, and their seed.
    """

    steps: int
    batch: int = 32
    rate: float = 2e-3
    warmup: int = 200
    decay: float = 0.02
    seed: int = 7
    shapes: int = 9000
    shape_seed: int = 3


class Training:
    """
    A network, its optimizer and how far they are.

    Step k draws its batch from (seed, k) alone: a training that was interrupted goes on as if it had not been. What it
    was started from, if from anything, is in `earlier`: options, steps, seconds and figures of each training before.
    """

    def __init__(self, task: Task, options: TrainingOptions) -> None:
        torch.manual_seed(options.seed)
        self.task = task
        self.options = options
        self.network = task.network().to(memory_format=torch.channels_last)
        self.average = copy.deepcopy(self.network).eval()
        self.optimizer = torch.optim.AdamW(
            self.network.parameters(), options.rate, betas=(0.9, 0.98), weight_decay=options.decay
        )
        self.step = 0
        self.seconds = 0.0
        self.history: list[dict[str, float]] = []
        self.earlier: list[dict[str, Any]] = []

    def start_from(self, path: Path) -> None:
        """
        Begin with the averaged weights of another training of the same task, which may have had other options.

        Raises
        ------
        ToonkitError
            If the checkpoint is of another task.
        """
        state = torch.load(path, weights_only=True)
        if state["task"] != self.task.name:
            raise refuse(
                "start", f"must be a checkpoint of the {self.task.name}", f"one of the {state['task']}"
            )
        self.network.load_state_dict(state["average"])
        self.average.load_state_dict(state["average"])
        made = {name: state[name] for name in ("options", "step", "seconds", "history")}
        self.earlier = [*state["earlier"], made]

    def advance(self, drawings: Drawings) -> float:
        """Take one step; return the mean error of its batch, degrees."""
        started = time.perf_counter()
        for group in self.optimizer.param_groups:
            group["lr"] = self._rate()
        rng = np.random.default_rng([self.options.seed, self.step])
        loss, error = self.task.loss(self.network, self.average, drawings, rng, self.options.batch, self.step)
        self.optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.network.parameters(), 1.0)
        self.optimizer.step()
        self.step += 1
        keep = min(AVERAGING, (1 + self.step) / (10 + self.step))
        with torch.no_grad():
            for mean, now in zip(self.average.parameters(), self.network.parameters(), strict=True):
                mean.lerp_(now, 1 - keep)
            for mean, now in zip(self.average.buffers(), self.network.buffers(), strict=True):
                mean.copy_(now)
        self.seconds += time.perf_counter() - started
        return error

    def save(self, path: Path) -> None:
        """Write a checkpoint, whole or not at all."""
        state = {
            "task": self.task.name,
            "options": asdict(self.options),
            "network": self.network.state_dict(),
            "average": self.average.state_dict(),
            "optimizer": self.optimizer.state_dict(),
            "step": self.step,
            "seconds": self.seconds,
            "history": self.history,
            "earlier": self.earlier,
        }
        with atomic_write(path) as file:
            torch.save(state, file)

    def load(self, path: Path) -> None:
        """
        Go on from a checkpoint of the same task and options.

        Raises
        ------
        ToonkitError
            If it is of another task or of other options: what came out would not be what either says.
        """
        state = torch.load(path, weights_only=True)
        made = {"task": state["task"], **state["options"]}
        for name, value in {"task": self.task.name, **asdict(self.options)}.items():
            if made[name] != value:
                raise refuse(name, f"must be {made[name]}, as in the checkpoint {path.name}", value)
        self.network.load_state_dict(state["network"])
        self.average.load_state_dict(state["average"])
        self.optimizer.load_state_dict(state["optimizer"])
        self.step, self.seconds = state["step"], state["seconds"]
        self.history, self.earlier = state["history"], state["earlier"]

    def _rate(self) -> float:
        options = self.options
        rising = min((self.step + 1) / options.warmup, 1.0)
        falling = 0.5 + 0.5 * np.cos(np.pi * min(self.step / options.steps, 1.0))
        return float(options.rate * rising * falling)
