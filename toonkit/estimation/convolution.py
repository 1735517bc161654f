"""Small convolutional networks at run time, in NumPy."""

from __future__ import annotations

import math
import threading

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]
Weights = dict[str, Array]
"""`<layer>.weight` of shape (out, in, k, k) and `<layer>.bias` of shape (out,)."""

LEVELS = 4
"""Resolutions: half the input's, and each next one half of the last."""

_kept = threading.local()


def encoded(weights: Weights, seen: Array) -> list[Array]:
    """
    Run the encoder: from the input down to the coarsest level.

    Parameters
    ----------
    weights : dict
        Arrays by layer: `stem`, and for level k `down.k.enter` (but for the first), `down.k.first` and `down.k.second`.
    seen : ndarray of float32, shape (C, S, S)
        Feature maps; S is divisible by 2 ** LEVELS.

    Returns
    -------
    list of ndarray
        State at each level, fine to coarse; the first has half the size of `seen`. The arrays are overwritten when this
        thread runs a network again.
    """
    states = [_rectified(_convolve(weights, "stem", _to_channels(seen)))]
    for level in range(LEVELS):
        state = states[-1]
        if level:
            state = _rectified(_convolve(weights, f"down.{level}.enter", state, stride=2))
        states.append(_block(weights, f"down.{level}", state))
    return states[1:]


def field(weights: Weights, seen: Array) -> Array:
    """
    Run a network with one output per pixel.

    Parameters
    ----------
    weights : dict
        Those of `encoded`; `up.k.enter`, `up.k.first` and `up.k.second` of the decoder at level k; and `out`.
    seen : ndarray of float32, shape (C, S, S)
        Feature maps.

    Returns
    -------
    ndarray of float32, shape (channels of `out` / 4, S, S)
        The answer.
    """
    *passed, state = encoded(weights, seen)
    for level in reversed(range(LEVELS - 1)):
        state = _rectified(_joined(weights, f"up.{level}.enter", state, passed.pop()))
        state = _block(weights, f"up.{level}", state)
    return _from_channels(_convolve(weights, "out", state))


def summary(weights: Weights, seen: Array) -> Array:
    """
    Run the encoder, global pooling and two dense layers; one output vector per picture.

    Parameters
    ----------
    weights : dict
        The weights that `encoded` needs, plus the dense layers `hidden` and `out`.
    seen : ndarray of float32, shape (C, S, S)
        Feature maps.

    Returns
    -------
    ndarray of float32, shape (rows of `out`,)
        Network output.
    """
    coarse = encoded(weights, seen)[-1]
    pooled = np.concatenate([coarse.mean((1, 2)), coarse.max((1, 2))])
    hidden = np.maximum(weights["hidden.weight"] @ pooled + weights["hidden.bias"], 0.0)
    return np.asarray(weights["out.weight"] @ hidden + weights["out.bias"])


def _block(weights: Weights, name: str, state: Array) -> Array:
    inner = _rectified(_convolve(weights, f"{name}.first", state))
    change = _convolve(weights, f"{name}.second", inner)
    change += state
    return _rectified(change)


def _rectified(state: Array) -> Array:
    """Set negative values to zero, in place."""
    return np.maximum(state, 0.0, out=state)


def _convolve(weights: Weights, layer: str, state: Array, *, stride: int = 1) -> Array:
    """Correlate with kernels of 3 pixels, zero beyond the edge."""
    kernels, bias = weights[f"{layer}.weight"], weights[f"{layer}.bias"]
    out, channels, size, _ = kernels.shape
    _, height, width = state.shape
    down, across = -(-height // stride), -(-width // stride)
    columns = _room("columns", channels, size, size, down, across)
    reach = size // 2
    for row in range(size):
        for column in range(size):
            here = columns[:, row, column]
            rows, seen_rows = _overlap(row - reach, height, stride)
            along, seen_along = _overlap(column - reach, width, stride)
            here[:, : rows.start] = here[:, rows.stop :] = 0.0
            here[:, :, : along.start] = here[:, :, along.stop :] = 0.0
            here[:, rows, along] = state[:, seen_rows, seen_along]
    flat = _room(layer, out, down * across)
    np.matmul(kernels.reshape(out, -1), columns.reshape(channels * size * size, -1), out=flat)
    flat += bias[:, None]
    return flat.reshape(out, down, across)


def _joined(weights: Weights, layer: str, coarse: Array, fine: Array) -> Array:
    """Mix the channels of a state, each pixel of which stands for 2 x 2, with those of a finer one."""
    mixing, bias = weights[f"{layer}.weight"][:, :, 0, 0], weights[f"{layer}.bias"]
    count, height, width = coarse.shape
    mixed = _room(layer, len(mixing), height, 2, width, 2)
    np.matmul(mixing[:, count:], fine.reshape(len(fine), -1), out=mixed.reshape(len(mixing), -1))
    blocks = _room(f"{layer}, blocks", len(mixing), height * width)
    np.matmul(mixing[:, :count], coarse.reshape(count, -1), out=blocks)
    blocks += bias[:, None]
    mixed += blocks.reshape(-1, height, 1, width, 1)
    return mixed.reshape(-1, 2 * height, 2 * width)


def _overlap(shift: int, length: int, stride: int) -> tuple[slice, slice]:
    """Return the slices of outputs and of inputs that overlap, where output k reads input stride * k + shift."""
    first = -(min(shift, 0) // stride)
    last = (length - 1 - shift) // stride + 1
    last = min(last, -(-length // stride))
    return slice(first, last), slice(stride * first + shift, stride * (last - 1) + shift + 1, stride)


def _room(name: str, *shape: int) -> Array:
    """Return this thread's buffer for an array; it is reused, because allocating costs more than the arithmetic."""
    rooms: dict[str, Array] = _kept.__dict__
    size = math.prod(shape)
    if name not in rooms or rooms[name].size < size:
        rooms[name] = np.empty(size, np.float32)
    return rooms[name][:size].reshape(shape)


def _to_channels(seen: Array) -> Array:
    """Fold cells of 2 x 2 pixels into channels: (C, S, S) to (4 C, S / 2, S / 2)."""
    count, height, width = seen.shape
    cells = seen.reshape(count, height // 2, 2, width // 2, 2)
    return cells.transpose(0, 2, 4, 1, 3).reshape(4 * count, height // 2, width // 2)


def _from_channels(state: Array) -> Array:
    """Undo `_to_channels`: (4 C, h, w) to (C, 2 h, 2 w)."""
    count, height, width = state.shape
    cells = state.reshape(count // 4, 2, 2, height, width)
    return cells.transpose(0, 3, 1, 4, 2).reshape(count // 4, 2 * height, 2 * width)
