"""Weights of the trained networks, each with a JSON file that says how it was made."""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import IO, Any

import numpy as np

from toonkit.estimation.convolution import Weights


@cache
def read_weights(name: str) -> Weights:
    """Read a network's weights, once in a process."""
    with files(__name__).joinpath(f"{name}.npz").open("rb") as file:
        return weights_in(file)


def weights_in(file: IO[bytes]) -> Weights:
    """Read weights that a training wrote: layer -> float32 array."""
    with np.load(file) as stored:
        return {layer: stored[layer].astype(np.float32) for layer in stored.files}


def provenance(name: str) -> dict[str, Any]:
    """Return how a network's weights were made: command, seed, data, steps and figures."""
    text = files(__name__).joinpath(f"{name}.json").read_text(encoding="utf-8")
    return dict(json.loads(text))
