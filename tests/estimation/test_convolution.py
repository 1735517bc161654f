"""The plain-array network computes what its layers say, and folds pixels into channels and back."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import correlate2d

from toonkit.estimation import convolution
from toonkit.estimation.convolution import LEVELS, Weights, encoded, field, summary

CHANNELS, SIDE = 2, 32
WIDTHS = (3, 5, 4, 6)


def random_weights(seed: int = 3) -> tuple[Weights, Weights]:
    """A network that answers at each pixel, and one that answers once."""
    rng = np.random.default_rng(seed)

    def layer(leaving: int, entering: int, size: int) -> tuple[np.ndarray, np.ndarray]:
        kernels = rng.normal(size=(leaving, entering, size, size)) / np.sqrt(entering * size * size)
        return kernels.astype(np.float32), rng.normal(0, 0.3, leaving).astype(np.float32)

    layers = {"stem": layer(WIDTHS[0], 4 * CHANNELS, 3)}
    for level, width in enumerate(WIDTHS):
        if level:
            layers[f"down.{level}.enter"] = layer(width, WIDTHS[level - 1], 3)
        for part in ("first", "second"):
            layers[f"down.{level}.{part}"] = layer(width, width, 3)
    pooled, across = dict(layers), dict(layers)
    for level in range(LEVELS - 1):
        across[f"up.{level}.enter"] = layer(WIDTHS[level], WIDTHS[level] + WIDTHS[level + 1], 1)
        for part in ("first", "second"):
            across[f"up.{level}.{part}"] = layer(WIDTHS[level], WIDTHS[level], 3)
    across["out"] = layer(12, WIDTHS[0], 3)
    dense = {"hidden": (7, 2 * WIDTHS[-1]), "out": (4, 7)}
    for name, shape in dense.items():
        pooled[name] = rng.normal(size=shape).astype(np.float32), rng.normal(size=shape[0]).astype(np.float32)
    return _flat(across), _flat(pooled)


def _flat(layers: dict[str, tuple[np.ndarray, np.ndarray]]) -> Weights:
    parts = [(f"{name}.weight", weight) for name, (weight, _) in layers.items()]
    return dict(parts + [(f"{name}.bias", bias) for name, (_, bias) in layers.items()])


class Reference:
    """The same network in float64, with scipy's correlation and one loop over each pair of maps."""

    def __init__(self, weights: Weights) -> None:
        self.weights = {name: values.astype(np.float64) for name, values in weights.items()}

    def layer(self, name: str, maps: np.ndarray, stride: int = 1) -> np.ndarray:
        kernels, bias = self.weights[f"{name}.weight"], self.weights[f"{name}.bias"]
        answers = []
        for kernel_of_map, offset in zip(kernels, bias, strict=True):
            parts = [correlate2d(m, k, mode="same") for m, k in zip(maps, kernel_of_map, strict=True)]
            answers.append(np.sum(parts, axis=0) + offset)
        return np.array(answers)[:, ::stride, ::stride]

    def block(self, name: str, maps: np.ndarray) -> np.ndarray:
        inner = relu(self.layer(f"{name}.first", maps))
        return relu(maps + self.layer(f"{name}.second", inner))

    def encoded(self, seen: np.ndarray) -> list[np.ndarray]:
        cells = [m[row::2, column::2] for m in seen for row in (0, 1) for column in (0, 1)]
        states = [self.block("down.0", relu(self.layer("stem", np.array(cells))))]
        for level in (1, 2, 3):
            entering = relu(self.layer(f"down.{level}.enter", states[-1], stride=2))
            states.append(self.block(f"down.{level}", entering))
        return states

    def field(self, seen: np.ndarray) -> np.ndarray:
        states = self.encoded(seen)
        state = states[3]
        for level in (2, 1, 0):
            wide = np.array([np.kron(m, np.ones((2, 2))) for m in state])
            state = relu(self.layer(f"up.{level}.enter", np.concatenate([wide, states[level]])))
            state = self.block(f"up.{level}", state)
        folded = self.layer("out", state)
        answer = np.zeros((3, *seen.shape[1:]))
        for k in range(12):
            answer[k // 4, (k // 2) % 2 :: 2, k % 2 :: 2] = folded[k]
        return answer

    def summary(self, seen: np.ndarray) -> np.ndarray:
        coarse = self.encoded(seen)[-1]
        pooled = np.array([m.mean() for m in coarse] + [m.max() for m in coarse])
        hidden = relu(self.weights["hidden.weight"] @ pooled + self.weights["hidden.bias"])
        return self.weights["out.weight"] @ hidden + self.weights["out.bias"]


def relu(values: np.ndarray) -> np.ndarray:
    return np.maximum(values, 0)


@pytest.fixture
def seen() -> np.ndarray:
    return np.random.default_rng(8).normal(size=(CHANNELS, SIDE, SIDE)).astype(np.float32)


ROUNDING = 2e-5  # of sums of some dozen float32 products, layer upon layer


def test_each_level_of_the_way_down_is_what_scipy_computes(seen: np.ndarray) -> None:
    across, _ = random_weights()
    states, expected = encoded(across, seen), Reference(across).encoded(seen)
    assert [state.shape for state in states] == [(3, 16, 16), (5, 8, 8), (4, 4, 4), (6, 2, 2)]
    for state, wanted in zip(states, expected, strict=True):
        assert wanted.std() > 0.1
        assert np.abs(state - wanted).max() < ROUNDING


def test_the_answer_at_each_pixel_is_what_scipy_computes(seen: np.ndarray) -> None:
    across, _ = random_weights()
    answer, expected = field(across, seen), Reference(across).field(seen)
    assert answer.shape == (3, SIDE, SIDE)
    assert expected.std() > 0.1
    assert np.abs(answer - expected).max() < ROUNDING


def test_the_answer_for_the_whole_is_what_scipy_computes(seen: np.ndarray) -> None:
    _, pooled = random_weights()
    answer, expected = summary(pooled, seen), Reference(pooled).summary(seen)
    assert answer.shape == (4,)
    assert expected.std() > 0.1
    assert np.abs(answer - expected).max() < ROUNDING


def test_a_network_of_float32_stays_float32(seen: np.ndarray) -> None:
    across, pooled = random_weights()
    assert field(across, seen).dtype == np.float32
    assert summary(pooled, seen).dtype == np.float32


@pytest.mark.parametrize("stride", [1, 2])
def test_a_kernel_that_picks_its_right_neighbor_moves_a_map_to_the_left(stride: int) -> None:
    """A correlation, not a convolution, and zero beyond the edge."""
    kernel = np.zeros((1, 1, 3, 3), np.float32)
    kernel[0, 0, 1, 2] = 1
    weights = {"layer.weight": kernel, "layer.bias": np.zeros(1, np.float32)}
    state = np.arange(1, 37, dtype=np.float32).reshape(1, 6, 6)
    moved = np.concatenate([state[:, :, 1:], np.zeros((1, 6, 1))], axis=2)
    assert np.array_equal(
        convolution._convolve(weights, "layer", state, stride=stride), moved[:, ::stride, ::stride]
    )


def test_folding_into_channels_and_back_changes_nothing(seen: np.ndarray) -> None:
    folded = convolution._to_channels(seen)
    assert folded.shape == (4 * CHANNELS, SIDE // 2, SIDE // 2)
    assert np.array_equal(convolution._from_channels(folded), seen)


def test_four_channels_hold_the_four_pixels_of_a_cell_row_by_row() -> None:
    row, column = np.mgrid[:4, :4]
    folded = convolution._to_channels(
        np.stack([10 * row + column, 100 + 10 * row + column]).astype(np.float32)
    )
    assert folded[:, 1, 0].tolist() == [20, 21, 30, 31, 120, 121, 130, 131]
