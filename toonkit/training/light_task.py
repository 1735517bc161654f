"""What the light prior learns: a distribution of light directions that makes the true one likely."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from toonkit.estimation.light_prior import CERTAINTIES, LEAST_CONCENTRATION, features
from toonkit.training.drawings import INKED, Drawings
from toonkit.training.network import LightNetwork, fast_arithmetic


class LightTask:
    """Likelihood of the true light under a von Mises-Fisher distribution."""

    name = "light_prior"

    def network(self) -> nn.Module:
        """Build the network."""
        return LightNetwork()

    def loss(
        self, network: nn.Module, drawings: Drawings, rng: np.random.Generator, size: int
    ) -> tuple[Tensor, float]:
        """Return the loss of a batch, and its mean error in degrees."""
        seen, light = _batch(drawings, [rng] * size, INKED)
        with fast_arithmetic():
            answer = network(seen)
        likelihood, error = _compared(answer.float(), light)
        return -likelihood.mean(), float(error.mean())

    def figures(self, average: nn.Module, drawings: Drawings, count: int) -> dict[str, float]:
        """
        Return figures over `count` drawings that never change.

        Errors in degrees: mean, median and of the surest half without ink, and the mean in ink.
        """
        error, sure = _measure_errors(average, drawings, count, inked=0.0)
        in_ink, _ = _measure_errors(average, drawings, count, inked=1.0)
        order = torch.argsort(sure, descending=True)
        surest, rest = order.tensor_split(2)
        return {
            "mean": float(error.mean()),
            "median": float(error.median()),
            "surest half": float(error[surest].mean()),
            "rest": float(error[rest].mean()),
            "mean, in ink": float(in_ink.mean()),
        }


def _measure_errors(
    average: nn.Module, drawings: Drawings, count: int, *, inked: float
) -> tuple[Tensor, Tensor]:
    """Errors in degrees, and how sure the network was of each."""
    errors, certain = [], []
    for first in range(0, count, 64):
        generators = [np.random.default_rng([k]) for k in range(first, min(first + 64, count))]
        seen, light = _batch(drawings, generators, inked)
        with torch.no_grad():
            answer = average(seen)
        errors.append(_compared(answer, light)[1])
        certain.append(answer[:, 3])
    return torch.cat(errors), torch.cat(certain)


def _batch(drawings: Drawings, generators: list[np.random.Generator], inked: float) -> tuple[Tensor, Tensor]:
    items = [drawings.draw(rng, turned=True, inked=inked) for rng in generators]
    seen = np.stack([features(item.tones, item.mask, item.ink, item.initial_normals) for item in items])
    light = torch.from_numpy(np.stack([item.light for item in items]))
    return torch.from_numpy(seen).contiguous(memory_format=torch.channels_last), light


def _compared(answer: Tensor, light: Tensor) -> tuple[Tensor, Tensor]:
    """Log-likelihood of the lights, up to a constant, and the angle to them in degrees."""
    concentration = LEAST_CONCENTRATION + torch.exp(answer[:, 3].clamp(*CERTAINTIES))
    apart = (functional.normalize(answer[:, :3], dim=1) - light).norm(dim=1)  # 1 - cosine is half its square
    scale = torch.log(concentration) - torch.log(-torch.expm1(-2.0 * concentration))
    error = torch.rad2deg(2.0 * torch.arcsin((apart.detach() / 2.0).clamp_max(1.0)))
    return scale - concentration * apart**2 / 2.0, error
