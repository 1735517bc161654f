"""The networks while they learn and the plain arrays that are left of them answer alike."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torch import nn

from toonkit.estimation import convolution, light_prior, shape_prior
from toonkit.estimation.convolution import Array, Weights
from toonkit.training.network import LightNetwork, ShapeNetwork, export_weights, fast_arithmetic

SIDE = 32  # any multiple of 16 will do


def as_if_trained(network: nn.Module, seed: int = 6) -> nn.Module:
    """Random weights and statistics, in evaluation mode."""
    generator = torch.Generator().manual_seed(seed)
    with torch.no_grad():
        for name, values in [*network.named_parameters(), *network.named_buffers()]:
            if name.endswith("running_var") or (values.ndim == 1 and name.endswith("norm.weight")):
                values.uniform_(0.4, 1.6, generator=generator)
            elif values.ndim == 1:
                values.normal_(0, 0.3, generator=generator)
            elif values.ndim > 1:
                values.normal_(0, float(values[0].numel()) ** -0.5, generator=generator)
    return network.eval()


def random_features(channels: int) -> Array:
    return np.random.default_rng(9).normal(size=(channels, SIDE, SIDE)).astype(np.float32)


def answer_of(network: nn.Module, seen: Array) -> Array:
    with torch.no_grad():
        return np.asarray(network(torch.from_numpy(seen)[None])[0].numpy())


class Watched(dict):
    """Weights that remember which of them were asked for."""

    def __init__(self, weights: Weights) -> None:
        super().__init__(weights)
        self.asked: set[str] = set()

    def __getitem__(self, name: str) -> Array:
        self.asked.add(name)
        return np.asarray(super().__getitem__(name))


ROUNDING = (
    1e-4  # of float32, relative to the answers' spread: sums of a thousand products, through twenty layers
)


@pytest.mark.parametrize(
    ("network", "channels", "run"),
    [
        (ShapeNetwork, shape_prior.CHANNELS, convolution.field),
        (LightNetwork, light_prior.CHANNELS, convolution.summary),
    ],
    ids=["shape", "light"],
)
def test_exported_arrays_answer_as_the_network_does(network, channels, run) -> None:
    trained, seen = as_if_trained(network()), random_features(channels)
    weights = Watched(export_weights(trained))
    expected, answer = answer_of(trained, seen), run(weights, seen)
    assert answer.shape == expected.shape
    assert expected.std() > 0.05
    assert np.abs(answer - expected).max() < ROUNDING * expected.std()
    assert weights.asked == set(weights)  # nothing is exported in vain


@pytest.mark.parametrize("network", [ShapeNetwork, LightNetwork])
def test_exported_arrays_are_float32_and_hold_no_normalization(network: type[nn.Module]) -> None:
    weights = export_weights(as_if_trained(network()))
    assert {values.dtype for values in weights.values()} == {np.dtype(np.float32)}
    assert {name.rpartition(".")[2] for name in weights} == {"weight", "bias"}
    assert not any("norm" in name or "encoder" in name for name in weights)


@pytest.mark.parametrize("network", [ShapeNetwork, LightNetwork])
def test_what_is_exported_does_not_change_with_the_network_afterwards(network: type[nn.Module]) -> None:
    trained = as_if_trained(network())
    weights = export_weights(trained)
    before = {name: values.copy() for name, values in weights.items()}
    changed = export_weights(as_if_trained(trained, seed=7))
    assert all((changed[name] != before[name]).any() for name in before)
    assert all(np.array_equal(weights[name], before[name]) for name in before)


def test_an_untrained_shape_network_leaves_the_normals_as_they_are() -> None:
    answer = answer_of(ShapeNetwork().eval(), random_features(shape_prior.CHANNELS))
    assert answer.shape == (3, SIDE, SIDE)
    assert not answer.any()


@pytest.mark.parametrize("network", [ShapeNetwork, LightNetwork])
def test_every_parameter_learns(network: type[nn.Module]) -> None:
    trained = as_if_trained(network()).train()
    channels = shape_prior.CHANNELS if network is ShapeNetwork else light_prior.CHANNELS
    trained(torch.from_numpy(random_features(channels))[None].repeat(2, 1, 1, 1)).square().sum().backward()
    idle = [
        name for name, values in trained.named_parameters() if values.grad is None or not values.grad.any()
    ]
    assert idle == []


@pytest.mark.parametrize(
    ("able", "kind"),
    [
        ({"avx512_f": True, "avx512_bf16": True}, torch.bfloat16),
        ({"amx_bf16": True}, torch.bfloat16),
        ({"avx512_f": True, "avx512_bf16": False}, torch.float32),
        ({"architecture": "aarch64"}, torch.float32),
    ],
)
def test_layers_compute_in_16_bits_where_that_is_fast(
    able: dict[str, object], kind: torch.dtype, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(torch.cpu, "get_capabilities", lambda: able)
    with torch.no_grad(), fast_arithmetic():
        assert ShapeNetwork()(torch.zeros(1, shape_prior.CHANNELS, SIDE, SIDE)).dtype == kind
