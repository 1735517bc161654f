"""What the shape prior learns: to correct inflated normals."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from toonkit.estimation.shape_prior import CHANNELS, features
from toonkit.training.drawings import INKED, OUTLINED, Drawing, Drawings
from toonkit.training.network import ShapeNetwork, fast_arithmetic

BALANCE = 6.0
"""Degrees: a shape whose N0 is better than this weighs as if it were no better."""


class ShapeTask:
    """Mean angle to the true normals, over the mask, of drawings in one material."""

    name = "shape_prior"
    inked = INKED
    colored = False

    def network(self) -> nn.Module:
        """Build the network."""
        return ShapeNetwork(CHANNELS + self.colored)

    def loss(
        self, network: nn.Module, drawings: Drawings, rng: np.random.Generator, size: int
    ) -> tuple[Tensor, float]:
        """Return the loss of a batch, and its mean error in degrees."""
        items = [
            drawings.draw(rng, turned=False, doubtful=True, inked=self.inked, colored=self.colored)
            for _ in range(size)
        ]
        with fast_arithmetic():
            change = network(_seen(items))
        error = chord(change.float(), items)
        before = chord(torch.zeros_like(change, dtype=torch.float32), items)
        return (error / torch.sqrt(before.clamp_min(BALANCE))).mean(), float(error.detach().mean())

    def figures(self, average: nn.Module, drawings: Drawings, count: int) -> dict[str, float]:
        """Return mean errors over `count` drawings that never change, degrees: of N0, corrected, and corrected in ink."""
        (initial, corrected), (_, in_ink) = (
            _measure_errors(average, drawings, count, inked=ink, colored=self.colored) for ink in (0.0, 1.0)
        )
        return {"initial": initial, "corrected": corrected, "corrected, in ink": in_ink}


class ColoredShapeTask(ShapeTask):
    """The same of drawings in several materials, whose borders are seen."""

    name = "colored_shape_prior"
    inked = OUTLINED
    colored = True


def _measure_errors(
    average: nn.Module, drawings: Drawings, count: int, *, inked: float, colored: bool
) -> tuple[float, float]:
    """Mean errors in degrees of N0 and of what the network makes of it."""
    before, after = [], []
    for first in range(0, count, 32):
        generators = [np.random.default_rng([k]) for k in range(first, min(first + 32, count))]
        items = [drawings.draw(rng, turned=False, inked=inked, colored=colored) for rng in generators]
        with torch.no_grad():
            change = average(_seen(items)).float()
        before.append(chord(torch.zeros_like(change), items))
        after.append(chord(change, items))
    return float(torch.cat(before).mean()), float(torch.cat(after).mean())


def chord(change: Tensor, items: list[Drawing]) -> Tensor:
    """Mean distance of N0 from the truth over each mask after a change, in degrees, shape (n,)."""
    after = torch.from_numpy(np.stack([item.initial_normals for item in items])) + change.permute(0, 2, 3, 1)
    after = torch.cat([after[..., :2], after[..., 2:].clamp_min(0.0)], -1)
    after = functional.normalize(after, dim=-1, eps=1e-6)
    truth = torch.from_numpy(np.stack([item.normals for item in items]))
    mask = torch.from_numpy(np.stack([item.mask for item in items]))
    apart = torch.sqrt(((after - truth) ** 2).sum(-1) + 1e-6)
    return torch.rad2deg((apart * mask).sum((1, 2)) / mask.sum((1, 2)))


def _seen(items: list[Drawing]) -> Tensor:
    rows = []
    for item in items:
        elevation = float(np.arctan2(item.light[2], item.light[0]))
        rows.append(
            features(
                item.tones, item.mask, item.ink, item.borders, item.initial_normals, elevation, item.doubt
            )
        )
    return torch.from_numpy(np.stack(rows)).contiguous(memory_format=torch.channels_last)
