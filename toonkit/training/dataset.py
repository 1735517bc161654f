"""The shapes to learn from: rendered once, kept in shards that can be made in any order and again."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import BoolArray, ToonkitError
from toonkit.estimation.convolution import Array
from toonkit.estimation.inflation import inflate
from toonkit.estimation.turn import TURNS
from toonkit.estimation.working_square import FILL, SIZE
from toonkit.export.atomic import atomic_write
from toonkit.training.families import random_solid
from toonkit.training.rendering import Rendered, render_solid

SHARD = 200
"""Shapes in a file."""

CUT_OFF = 0.12
"""Share of the attempts at a shape that let the picture's frame cut it off: what ends there has no rim. A quarter fails."""


class Shape(NamedTuple):
    """One shape of a dataset: see `Dataset` for its fields."""

    normals: Array
    initial_normals: Array
    mask: BoolArray
    contours: BoolArray
    parts: NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class Dataset:
    """
    Shapes without color or light.

    Attributes
    ----------
    normals, initial_normals : ndarray of float16, shape (n, SIZE, SIZE, 3)
        The truth and N0; zero beside the object.
    masks : ndarray of bool, shape (n, SIZE, SIZE)
        The object.
    contours : ndarray of bool, shape (n, SIZE, SIZE)
        Where it ends in front of another part of itself.
    parts : ndarray of int8, shape (n, SIZE, SIZE)
        Number of the part that is seen, -1 beside the object.
    """

    normals: NDArray[np.float16]
    initial_normals: NDArray[np.float16]
    masks: BoolArray
    contours: BoolArray
    parts: NDArray[np.int8]

    def __len__(self) -> int:
        return len(self.masks)

    def view(self, index: int, variant: int) -> Shape:
        """Return a shape in one of the eight turns and reflections of a square."""
        turn = TURNS[variant]
        fields = (field[index].astype(np.float32) for field in (self.normals, self.initial_normals))
        vectors = [turn.vectors(turn.picture(field)) for field in fields]
        places = [turn.picture(field[index]) for field in (self.masks, self.contours, self.parts)]
        return Shape(*vectors, *places)


def make_dataset(
    folder: Path,
    count: int,
    seed: int,
    *,
    workers: int,
    progress: Callable[[Iterator[int], int], Iterable[int]],
) -> Dataset:
    """
    Render shapes, or read those that are there already.

    Parameters
    ----------
    folder : Path
        Where the shards are kept.
    count : int
        Shapes wanted.
    seed : int
        Of all shapes together; shard k depends on (seed, k) alone.
    workers : int
        Processes.
    progress : callable
        Wraps the iterator over finished shards; also told how many there will be.

    Returns
    -------
    Dataset
        The shapes.
    """
    folder.mkdir(parents=True, exist_ok=True)
    shards = range(-(-count // SHARD))
    missing = [k for k in shards if not _is_whole(_path(folder, seed, k))]
    if missing:
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            for _ in progress(pool.map(partial(_make_shard, folder, seed), missing), len(missing)):
                pass
    parts: list[dict[str, NDArray[np.generic]]] = []
    for k in shards:
        with np.load(_path(folder, seed, k)) as stored:
            parts.append({name: stored[name] for name in stored.files})
    joined = {name: np.concatenate([part[name] for part in parts])[:count] for name in parts[0]}
    return Dataset(**joined)


def draw_cut_off(rng: np.random.Generator) -> Rendered | None:
    """
    Draw a solid of which the picture's frame cuts a part off.

    Parameters
    ----------
    rng : Generator
        Source of every choice.

    Returns
    -------
    Rendered or None
        Some rows and columns of a larger picture, of which the object takes about the share `FILL` of SIZE; None if it does
        not, or does not reach the frame.
    """
    whole = render_solid(random_solid(rng), int(rng.integers(SIZE, 2 * SIZE)))
    side = round(FILL * SIZE)
    height, width = rng.permutation([side, int(rng.integers(side // 2, side + 1))])
    if whole is None:
        return None
    top, left = (int(rng.integers(len(whole.mask) - length + 1)) for length in (height, width))
    rows, columns = slice(top, top + height), slice(left, left + width)
    mask = whole.mask[rows, columns]
    extents = [np.ptp(np.flatnonzero(mask.any(axis=axis))) + 1 if mask.any() else 0 for axis in (0, 1)]
    border = np.concatenate([mask[0], mask[-1], mask[:, 0], mask[:, -1]])
    if max(extents) < 0.9 * side or mask.sum() < 0.2 * side**2 or not border.any():
        return None
    return Rendered(
        whole.normals[rows, columns],
        mask,
        whole.coverage[rows, columns],
        whole.contours[rows, columns],
        whole.parts[rows, columns],
    )


def _place(mask: BoolArray) -> tuple[slice, slice]:
    """Return rows and columns of the square at which a picture stands, its object as near the middle as there is room."""
    places = []
    for axis, length in ((1, mask.shape[0]), (0, mask.shape[1])):
        first, last = np.flatnonzero(mask.any(axis=axis))[[0, -1]]
        start = int(np.clip(round((SIZE - 1 - first - last) / 2), 0, SIZE - length))
        places.append(slice(start, start + length))
    return places[0], places[1]


def _path(folder: Path, seed: int, shard: int) -> Path:
    return folder / f"shapes-{seed}-{shard:05d}.npz"


def _is_whole(path: Path) -> bool:
    """Tell whether a shard is there, with all that shapes have by now."""
    if not path.exists():
        return False
    with np.load(path) as stored:
        return set(stored.files) == {part.name for part in fields(Dataset)}


def _make_shard(folder: Path, seed: int, shard: int) -> int:
    rng = np.random.default_rng([seed, shard])
    normals = np.zeros((SHARD, SIZE, SIZE, 3), np.float16)
    initial = np.zeros_like(normals)
    masks, contours = np.zeros((2, SHARD, SIZE, SIZE), np.bool_)
    parts = np.full(masks.shape, -1, np.int8)
    done = 0
    while done < SHARD:
        rendered = draw_cut_off(rng) if rng.random() < CUT_OFF else render_solid(random_solid(rng), SIZE)
        if rendered is None:
            continue
        try:
            inflated = inflate(rendered.mask, alpha=rendered.coverage)
        except ToonkitError:  # a sliver too thin to inflate
            continue
        rows, columns = _place(rendered.mask)
        normals[done, rows, columns], masks[done, rows, columns] = rendered.normals, rendered.mask
        contours[done, rows, columns], parts[done, rows, columns] = rendered.contours, rendered.parts
        initial[done, rows, columns] = np.nan_to_num(inflated.vectors)
        done += 1
    with atomic_write(_path(folder, seed, shard)) as file:
        np.savez(file, normals=normals, initial_normals=initial, masks=masks, contours=contours, parts=parts)
    return shard
