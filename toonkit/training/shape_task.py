"""What the shape prior learns: to correct normals, at a first look and at a second."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from toonkit.estimation.shape_prior import completed, features
from toonkit.training.drawings import INKED, Drawing, Drawings
from toonkit.training.network import ShapeNetwork, fast_arithmetic

SECOND_LOOK_FROM = 500
"""Steps before half of each batch shows the network its own first answer."""

BALANCE = 6.0
"""Degrees: a shape whose N0 is better than this weighs as if it were no better."""


class ShapeTask:
    """Mean angle to the true normals, over the mask."""

    name = "shape_prior"

    def network(self) -> nn.Module:
        """Build the network."""
        return ShapeNetwork()

    def loss(
        self,
        network: nn.Module,
        average: nn.Module,
        drawings: Drawings,
        rng: np.random.Generator,
        size: int,
        step: int,
    ) -> tuple[Tensor, float]:
        """Return the loss of a batch, and its mean error in degrees."""
        items = [drawings.draw(rng, turned=False, doubtful=True, inked=INKED) for _ in range(size)]
        seen, normals = _first_look(items)
        if step >= SECOND_LOOK_FROM:
            half = size // 2
            with fast_arithmetic():
                change = _answer(average, seen[:half])
            seen[:half], normals[:half] = _second_look(items[:half], change)
        with fast_arithmetic():
            change = network(_channels_last(seen))
        error = chord(change.float(), items, normals)
        before = chord(torch.zeros_like(change, dtype=torch.float32), items, normals)
        return (error / torch.sqrt(before.clamp_min(BALANCE))).mean(), float(error.detach().mean())

    def figures(self, average: nn.Module, drawings: Drawings, count: int) -> dict[str, float]:
        """Return mean errors over `count` drawings that never change, degrees: of N0, after one look, after two, in ink."""
        errors = [_judged(average, drawings, count, inked=inked) for inked in (0.0, 1.0)]
        names = ("initial", "one look", "two looks")
        return {**dict(zip(names, errors[0], strict=True)), "two looks, in ink": errors[1][-1]}


def _judged(average: nn.Module, drawings: Drawings, count: int, *, inked: float) -> list[float]:
    """Mean errors in degrees of N0, after one look and after two."""
    errors: list[list[Tensor]] = [[], [], []]
    for first in range(0, count, 32):
        generators = [np.random.default_rng([k]) for k in range(first, min(first + 32, count))]
        items = [drawings.draw(rng, turned=False, inked=inked) for rng in generators]
        seen, normals = _first_look(items)
        change = _answer(average, seen)
        errors[0].append(chord(torch.zeros(change.shape), items, normals))
        errors[1].append(chord(torch.from_numpy(change), items, normals))
        seen, normals = _second_look(items, change)
        errors[2].append(chord(torch.from_numpy(_answer(average, seen)), items, normals))
    return [float(torch.cat(parts).mean()) for parts in errors]


def chord(change: Tensor, items: list[Drawing], normals: np.ndarray) -> Tensor:
    """Mean distance of unit normals from the truth over each mask after a change, in degrees, shape (n,)."""
    after = torch.from_numpy(normals) + change.permute(0, 2, 3, 1)
    after = torch.cat([after[..., :2], after[..., 2:].clamp_min(0.0)], -1)
    after = functional.normalize(after, dim=-1, eps=1e-6)
    truth = torch.from_numpy(np.stack([item.normals for item in items]))
    mask = torch.from_numpy(np.stack([item.mask for item in items]))
    apart = torch.sqrt(((after - truth) ** 2).sum(-1) + 1e-6)
    return torch.rad2deg((apart * mask).sum((1, 2)) / mask.sum((1, 2)))


def _first_look(items: list[Drawing]) -> tuple[np.ndarray, np.ndarray]:
    normals = np.stack([item.initial_normals for item in items])
    return _seen(items, normals), normals


def _second_look(items: list[Drawing], change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    normals = np.stack(
        [
            completed(item.initial_normals + np.moveaxis(part, 0, -1)) * item.mask[..., None]
            for item, part in zip(items, change, strict=True)
        ]
    )
    return _seen(items, normals), normals


def _seen(items: list[Drawing], normals: np.ndarray) -> np.ndarray:
    rows = []
    for item, now in zip(items, normals, strict=True):
        elevation = float(np.arctan2(item.light[2], item.light[0]))
        rows.append(
            features(item.tones, item.mask, item.ink, now, item.initial_normals, elevation, item.doubt)
        )
    return np.stack(rows)


def _answer(average: nn.Module, seen: np.ndarray) -> np.ndarray:
    with torch.no_grad():
        return np.asarray(average(_channels_last(seen)).float())


def _channels_last(seen: np.ndarray) -> Tensor:
    return torch.from_numpy(seen).contiguous(memory_format=torch.channels_last)
