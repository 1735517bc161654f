"""Weights of the trained networks, each with a JSON file that says how it was made."""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from toonkit.estimation.convolution import Weights


@cache
def read_weights(name: str) -> Weights:
    """Read a network's weights, once in a process: layer -> float32 array."""
    with files(__name__).joinpath(f"{name}.npz").open("rb") as file, np.load(file) as stored:
        return {layer: stored[layer].astype(np.float32) for layer in stored.files}


def provenance(name: str) -> dict[str, Any]:
    """Return how a network's weights were made: command, seed, data, steps and figures."""
    text = files(__name__).joinpath(f"{name}.json").read_text(encoding="utf-8")
    return dict(json.loads(text))
