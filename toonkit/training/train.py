"""Training: optimizer steps, an average of the weights over them, and checkpoints from which training resumes."""

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
from toonkit.estimation.convolution import Weights
from toonkit.export.atomic import atomic_write
from toonkit.training.drawings import Drawings
from toonkit.training.network import export_weights, set_normalizations, take_over

AVERAGING = 0.998
"""Weight of the old average in the new one at each step; the averaged weights are the ones shipped."""


STORED_OPTIONS = ("shapes", "shape_seed", "steps", "batch", "rate", "keep", "seed")
"""Options that a record names."""

FIGURES = "figures, degrees, on shapes kept aside"


class Task(Protocol):
    """What a network learns."""

    name: str

    def network(self) -> nn.Module:
        """Build the network, untrained."""
        ...

    def loss(
        self, network: nn.Module, drawings: Drawings, rng: np.random.Generator, size: int
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
        Total number of optimizer steps; the learning rate falls to zero over them.
    batch : int
        Drawings per step (batch size).
    rate : float
        Peak learning rate.
    warmup : int
        Steps over which the learning rate rises to its peak.
    decay : float
        Weight decay.
    keep : float
        Weight, 0 to 1, of the starting weights in a linear average with the trained ones, to reduce forgetting.
    seed : int
        Seed for initial weights and drawings.
    shapes, shape_seed : int
        Number of distinct shapes drawn, and the seed that generates them.
    """

    steps: int
    batch: int = 32
    rate: float = 2e-3
    warmup: int = 200
    decay: float = 0.02
    keep: float = 0.0
    seed: int = 7
    shapes: int = 9000
    shape_seed: int = 3


class Training:
    """
    A network, its optimizer and how far they are.

    Step k draws its batch from (seed, k) alone: an interrupted training resumes as if it had not been interrupted.
    `earlier` holds the records of the trainings whose weights it was started from, if any.
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
        self.begun: dict[str, Tensor] = {}

    def start_from_weights(self, weights: Weights, made: list[dict[str, Any]], drawings: Drawings) -> None:
        """
        Begin with weights as they ship, made by earlier trainings; the drawings show what to normalize.

        Raises
        ------
        ToonkitError
            If the weights are of another network.
        """
        known = export_weights(self.network)
        if _output_shapes(weights) != _output_shapes(known) or _more_enter(weights, known):
            raise refuse("start", f"must be weights of the {self.task.name}", "those of another network")
        take_over(self.network, weights)
        self.begun = {name: torch.from_numpy(values) for name, values in export_weights(self.network).items()}
        rng = np.random.default_rng([self.options.seed])
        self.network.eval()
        set_normalizations(
            self.network, lambda: self.task.loss(self.network, drawings, rng, self.options.batch)
        )
        self.network.train()
        self.average.load_state_dict(self.network.state_dict())
        self.earlier = made

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
        self.earlier = [*state["earlier"], _record(state)]

    @property
    def record(self) -> dict[str, Any]:
        """What to say of this training: its command, steps, seconds and figures."""
        return _record(self._facts)

    @property
    def _facts(self) -> dict[str, Any]:
        """What a checkpoint says in words and numbers, but for what was learned."""
        return {
            "task": self.task.name,
            "options": asdict(self.options),
            "step": self.step,
            "seconds": self.seconds,
            "history": self.history,
            "earlier": self.earlier,
        }

    def advance(self, drawings: Drawings) -> float:
        """Take one step; return the mean error of its batch, degrees."""
        started = time.perf_counter()
        for group in self.optimizer.param_groups:
            group["lr"] = self._rate()
        rng = np.random.default_rng([self.options.seed, self.step])
        loss, error = self.task.loss(self.network, drawings, rng, self.options.batch)
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

    def shipped(self) -> Weights:
        """Return the averaged weights, mixed with those it was started from as far as they are to be kept."""
        keep = self.options.keep
        if keep and not self.begun:
            raise refuse("keep", "needs weights to start from", keep)
        return {
            name: (1.0 - keep) * values + keep * self.begun[name].numpy() if keep else values
            for name, values in export_weights(self.average).items()
        }

    def shipped_network(self) -> nn.Module:
        """Return a network that answers as what ships does."""
        network = self.task.network()
        take_over(network, self.shipped())
        return network.eval()

    def save(self, path: Path) -> None:
        """Write a checkpoint atomically."""
        state = {
            **self._facts,
            "network": self.network.state_dict(),
            "average": self.average.state_dict(),
            "optimizer": self.optimizer.state_dict(),
            "begun": self.begun,
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
            if made.get(name) != value:
                raise refuse(name, f"must be {made.get(name)}, as in the checkpoint {path.name}", value)
        self.network.load_state_dict(state["network"])
        self.average.load_state_dict(state["average"])
        self.optimizer.load_state_dict(state["optimizer"])
        self.step, self.seconds = state["step"], state["seconds"]
        self.history, self.earlier, self.begun = state["history"], state["earlier"], state["begun"]

    def _rate(self) -> float:
        options = self.options
        rising = min((self.step + 1) / options.warmup, 1.0)
        falling = 0.5 + 0.5 * np.cos(np.pi * min(self.step / options.steps, 1.0))
        return float(options.rate * rising * falling)


def _record(told: dict[str, Any]) -> dict[str, Any]:
    """Return what to say of a training, given what its checkpoint tells."""
    words = [f"--{name.replace('_', '-')} {told['options'][name]}" for name in STORED_OPTIONS]
    start = ["--start BEFORE"] if told["earlier"] else []
    kind = told["task"].removesuffix("_prior")
    return {
        "command": " ".join([f"python -m toonkit.training {kind} -o DIR", *start, *words]),
        "steps": told["step"],
        "seconds": round(told["seconds"]),
        FIGURES: told["history"],
    }


def _output_shapes(weights: Weights) -> dict[str, tuple[int, ...]]:
    """Return what tells one network from another: the maps that leave each layer, and its size; not those that enter."""
    return {name: (len(values), *values.shape[2:]) for name, values in weights.items()}


def _more_enter(weights: Weights, known: Weights) -> bool:
    """Tell whether a layer was fed maps that its network has no longer."""
    return any(values.shape[1:2] > known[name].shape[1:2] for name, values in weights.items())
