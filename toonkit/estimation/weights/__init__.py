"""Weights of the trained networks, each with a JSON file that says how it was made."""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from toonkit.estimation.convolution import Weights

STEP, MOST_STEPS = ".step", 127
"""End of the name of a layer's steps, and how many a weight is at most."""


@cache
def read_weights(name: str) -> Weights:
    """Read a network's weights, once in a process."""
    with files(__name__).joinpath(f"{name}.npz").open("rb") as file:
        return weights_in(file)


def weights_in(file: IO[bytes]) -> Weights:
    """Read weights that a training wrote, packed or as plain numbers: layer -> float32 array."""
    with np.load(file) as stored:
        arrays = {name: stored[name].astype(np.float32) for name in stored.files}
    steps = {name.removesuffix(STEP): arrays.pop(name) for name in [*arrays] if name.endswith(STEP)}
    return {name: values * steps[name] if name in steps else values for name, values in arrays.items()}


def packed(weights: Weights) -> dict[str, NDArray[Any]]:
    """
    Store weights in a quarter of the room.

    Parameters
    ----------
    weights : dict
        Layer -> array.

    Returns
    -------
    dict
        Kernels as 8-bit multiples of a step, one for each map that they make: `<layer>` and `<layer>.step`; all else as
        16-bit numbers.
    """
    arrays: dict[str, NDArray[Any]] = {}
    for name, values in weights.items():
        if values.ndim == 4:
            greatest = np.abs(values).max(axis=(1, 2, 3), keepdims=True)
            arrays[name + STEP] = np.maximum(greatest / MOST_STEPS, 1e-12).astype(np.float32)
            arrays[name] = np.rint(values / arrays[name + STEP]).astype(np.int8)
        else:
            arrays[name] = values.astype(np.float16)
    return arrays


def provenance(name: str) -> dict[str, Any]:
    """Return how a network's weights were made: command, seed, data, steps and figures."""
    text = files(__name__).joinpath(f"{name}.json").read_text(encoding="utf-8")
    return dict(json.loads(text))
