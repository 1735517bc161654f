"""Tables of studies that were never run: what every method's measures are is given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict

import numpy as np
import pandas as pd

from toonkit.study.records import Record

SHAPES = ("sphere", "torus", "cat", "duck", "pear", "hand")
COLOR_MAPS = ("plum_cream", "terracotta", "candy", "ocean", "amber_steps", "clay_smooth")

AS_THE_PAPER_SAYS: dict[str, dict[str, float]] = {
    "toonkit": {"angular_error": 12, "illumination_error": 0.08, "input_rmse": 0.01, "relight_rmse": 0.08},
    "todo": {"angular_error": 16, "illumination_error": 0.10, "input_rmse": 0.03, "relight_rmse": 0.10},
    "lumo": {"angular_error": 18, "illumination_error": 0.16, "input_rmse": 0.12, "relight_rmse": 0.13},
    "lambert": {"angular_error": 26, "illumination_error": 0.20, "input_rmse": 0.02, "relight_rmse": 0.15},
    "flat": {"angular_error": 42, "illumination_error": 0.30, "input_rmse": 0.0, "relight_rmse": 0.22},
}
DOME = {"angular_error": 14, "illumination_error": 0.09, "input_rmse": 0.05, "relight_rmse": 0.09}
"""A newcomer."""
RESPONSES = {"toonkit": 1.0, "todo": 1.01, "lumo": 0.99, "lambert": 0.6, "flat": 0.0}


def study_table(
    methods: Mapping[str, Mapping[str, float]] = AS_THE_PAPER_SAYS,
    responses: Mapping[str, float] = RESPONSES,
    *,
    shapes: tuple[str, ...] = SHAPES,
    color_maps: tuple[str, ...] = COLOR_MAPS,
    seed: int = 0,
    noise: float = 0.02,
    overfitted: str = "lambert",
) -> pd.DataFrame:
    """
    Return a study's table in which each measure is a mean times a shape's and a color map's own factor, and some noise.

    `overfitted` has normals that get worse toward the first of the color maps, the one of fewest and hardest tones.
    """
    generator = np.random.default_rng(seed)
    shape_factor = dict(zip(shapes, generator.uniform(0.7, 1.3, len(shapes)), strict=True))
    map_factor = dict(zip(color_maps, generator.uniform(0.8, 1.2, len(color_maps)), strict=True))
    records = []
    for shape in shapes:
        for place, color_map in enumerate(color_maps):
            for method, means in methods.items():
                factor = shape_factor[shape] * map_factor[color_map]
                values = {
                    name: mean * factor * (1 + noise * generator.normal()) for name, mean in means.items()
                }
                if method == overfitted:
                    values["angular_error"] += 2.0 * (len(color_maps) - place)
                records.append(
                    _record(
                        shape, color_map, method, values, responses[method] * (1 + noise * generator.normal())
                    )
                )
    return pd.DataFrame([asdict(record) for record in records])


def with_newcomers(trials: pd.DataFrame, *names: str) -> pd.DataFrame:
    """Return the table with newcomers that are all alike but for their noise."""
    parts = [
        study_table({name: DOME}, {name: 0.9}, seed=seed, noise=0.05)
        for seed, name in enumerate(names, start=1)
    ]
    return pd.concat([trials, *parts], ignore_index=True)


def failed(trials: pd.DataFrame, **which: str) -> pd.DataFrame:
    """Return the table with the trials of these shapes, color maps or methods ended in an error."""
    rows = np.logical_and.reduce([trials[name] == value for name, value in which.items()])
    table = trials.copy()
    measures = [name for name in table.select_dtypes("float") if not name.startswith("light_")]
    table.loc[rows, measures] = np.nan
    table.loc[rows, "error"] = "ValueError: it | broke"
    return table


def _record(shape: str, color_map: str, method: str, values: dict[str, float], response: float) -> Record:
    return Record(
        shape,
        "primitive" if shape in {"sphere", "torus"} else "complex",
        color_map,
        method,
        "given",
        size=64,
        pixels=1000,
        light_azimuth=129.0,
        light_elevation=50.0,
        light_error=0.0,
        **values,
        angular_error_without_rim=values["angular_error"],
        illumination_error_without_rim=values["illumination_error"],
        input_rmse_without_rim=values["input_rmse"],
        relight_rmse_without_rim=values["relight_rmse"],
        input_difference=60 * values["input_rmse"],
        color_map_rmse=values["illumination_error"] / 2,
        relight_response=response,
        relight_response_without_rim=response,
        iterations=50,
        converged=True,
        stopped="the energy stands still",
        seconds=0.5,
        toonkit="0.1.0",
        python="3.11",
        numpy="2",
        scipy="1",
        numba="0",
    )
