"""The networks of the shape prior and of the light while they learn: the same layers, with batch normalization."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from toonkit.estimation import light_prior, shape_prior
from toonkit.estimation.convolution import LEVELS, Weights

SHAPE_WIDTHS = (64, 104, 128, 144)
LIGHT_WIDTHS = (32, 64, 80, 96)
"""Feature maps at each level, fine to coarse."""


def fast_arithmetic() -> torch.autocast:
    """Let the layers compute in 16 bits where the processor can; where that is emulated it takes many times as long."""
    able = torch.cpu.get_capabilities()
    return torch.autocast(
        "cpu", torch.bfloat16, enabled=any(able.get(name, False) for name in ("avx512_bf16", "amx_bf16"))
    )


class Layer(nn.Module):
    """A convolution and its batch normalization, which become one convolution when training is over."""

    def __init__(self, entering: int, leaving: int, size: int = 3, stride: int = 1) -> None:
        super().__init__()
        self.convolution = nn.Conv2d(entering, leaving, size, stride, size // 2, bias=False)
        self.norm = nn.BatchNorm2d(leaving)

    def forward(self, state: Tensor) -> Tensor:
        """Return the state after it, before any activation."""
        return self.norm(self.convolution(state))

    def folded(self) -> tuple[Tensor, Tensor]:
        """Return weight and bias of the one convolution."""
        scale = self.norm.weight / torch.sqrt(self.norm.running_var + self.norm.eps)
        return self.convolution.weight * scale[
            :, None, None, None
        ], self.norm.bias - self.norm.running_mean * scale


class Stage(nn.Module):
    """An entering layer, if any, and a residual block."""

    def __init__(self, width: int, enter: Layer | None) -> None:
        super().__init__()
        self.enter = enter
        self.first = Layer(width, width)
        self.second = Layer(width, width)

    def forward(self, state: Tensor) -> Tensor:
        """Return the state after it."""
        if self.enter is not None:
            state = functional.relu(self.enter(state))
        return functional.relu(state + self.second(functional.relu(self.first(state))))


class Encoder(nn.Module):
    """Features (n, channels, S, S) to their state at each level, fine to coarse."""

    def __init__(self, channels: int, widths: Sequence[int]) -> None:
        super().__init__()
        self.stem = Layer(4 * channels, widths[0])
        self.down = nn.ModuleList(
            Stage(widths[k], Layer(widths[k - 1], widths[k], stride=2) if k else None) for k in range(LEVELS)
        )

    def forward(self, seen: Tensor) -> list[Tensor]:
        """Return the state at each level."""
        states = [functional.relu(self.stem(functional.pixel_unshuffle(seen, 2)))]
        for stage in self.down:
            states.append(stage(states[-1]))
        return states[1:]


class ShapeNetwork(nn.Module):
    """Features (n, channels, S, S) to a change of the normals (n, 3, S, S)."""

    def __init__(self, channels: int = shape_prior.CHANNELS) -> None:
        super().__init__()
        self.encoder = Encoder(channels, SHAPE_WIDTHS)
        self.up = nn.ModuleList(
            Stage(fine, Layer(fine + coarse, fine, size=1)) for fine, coarse in pairwise(SHAPE_WIDTHS)
        )
        self.out = nn.Conv2d(SHAPE_WIDTHS[0], 12, 3, padding=1)
        nn.init.zeros_(self.out.weight)  # it starts by leaving the normals as they are
        nn.init.zeros_(self.out.bias)

    def forward(self, seen: Tensor) -> Tensor:
        """Return the change."""
        *passed, state = self.encoder(seen)
        for stage in reversed(self.up):
            wide = functional.interpolate(state, scale_factor=2, mode="nearest")
            state = stage(torch.cat([wide, passed.pop()], 1))
        return functional.pixel_shuffle(self.out(state), 2)


class LightNetwork(nn.Module):
    """Features (n, CHANNELS, S, S) to a light and how sure it is, (n, 4)."""

    def __init__(self) -> None:
        super().__init__()
        self.encoder = Encoder(light_prior.CHANNELS, LIGHT_WIDTHS)
        self.hidden = nn.Linear(2 * LIGHT_WIDTHS[-1], 128)
        self.out = nn.Linear(128, 4)

    def forward(self, seen: Tensor) -> Tensor:
        """Return the direction, of any length, and the raw certainty."""
        coarse = self.encoder(seen)[-1]
        pooled = torch.cat([coarse.mean((2, 3)), coarse.amax((2, 3))], 1)
        return self.out(functional.relu(self.hidden(pooled)))


def take_over(network: nn.Module, weights: Weights) -> None:
    """
    Make a network answer as exported weights do; feature maps that were added since, at the end, count for nothing.

    Normalizations do nothing at first: see `set_normalizations`.
    """
    for name, module in network.named_modules():
        if not (isinstance(module, Layer | nn.Linear) or name == "out"):
            continue
        key = name.removeprefix("encoder.")
        weight, bias = (torch.from_numpy(weights[f"{key}.{part}"]) for part in ("weight", "bias"))
        with torch.no_grad():
            if isinstance(module, Layer):
                module.convolution.weight.zero_()
                module.convolution.weight[:, : weight.shape[1]] = weight
                module.norm.bias.copy_(bias)
                module.norm.running_mean.zero_()
                module.norm.running_var.fill_(1.0 - module.norm.eps)
            else:
                module.weight.copy_(weight)
                module.bias.copy_(bias)


def set_normalizations(network: nn.Module, run: Callable[[], object]) -> None:
    """
    Let the normalizations of a network do what they are for, without a change of its answers.

    Parameters
    ----------
    network : Module
        In evaluation mode, its normalizations as `take_over` leaves them.
    run : callable
        Runs it on typical features, of whose states each normalization takes mean and variance.
    """
    measured: dict[nn.BatchNorm2d, tuple[Tensor, Tensor]] = {}

    def measure(norm: nn.Module, entering: tuple[Tensor, ...]) -> None:
        state = entering[0].detach().float()
        assert isinstance(norm, nn.BatchNorm2d)
        measured[norm] = state.mean((0, 2, 3)), state.var((0, 2, 3))

    norms = [module.norm for module in network.modules() if isinstance(module, Layer)]
    hooks = [norm.register_forward_pre_hook(measure) for norm in norms]
    with torch.no_grad():
        run()
        for norm, (mean, variance) in measured.items():
            norm.running_mean.copy_(mean)
            norm.running_var.copy_(variance)
            norm.bias += mean
            norm.weight.copy_(torch.sqrt(variance + norm.eps))
    for hook in hooks:
        hook.remove()


def export_weights(network: nn.Module) -> Weights:
    """Return the weights as `toonkit.estimation.convolution` takes them, each normalization folded into its layer."""
    weights: Weights = {}
    for name, module in network.named_modules():
        if isinstance(module, Layer):
            weight, bias = module.folded()
        elif isinstance(module, nn.Linear) or name == "out":
            weight, bias = module.weight, module.bias
        else:
            continue
        key = name.removeprefix("encoder.")
        weights[f"{key}.weight"] = weight.detach().numpy().astype(np.float32)
        weights[f"{key}.bias"] = bias.detach().numpy().astype(np.float32)
    return weights
