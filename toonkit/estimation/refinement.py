"""Normal refinement (Section 3.3): build an energy and minimize it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from toonkit._validation import (
    BoolArray,
    FloatArray,
    as_coverage,
    check_callable,
    of_type,
    refuse,
    same_mask,
    same_shape,
)
from toonkit.estimation.energy import RefinementOptions, change_energy
from toonkit.estimation.islands import Island, islands_of, join_vectors
from toonkit.model.color_map import IlluminationInterval
from toonkit.model.light import direction_of
from toonkit.model.normals import NormalField
from toonkit.numerics.change_energy import ChangeEnergy
from toonkit.numerics.gauss_seidel import over_relaxed_sweeps
from toonkit.numerics.report import SolverReport, join_reports
from toonkit.numerics.smoothness_energy import SmoothnessEnergy
from toonkit.numerics.unit_field import solve_unit_field
from toonkit.numerics.unit_vectors import unit_vectors

Progress = Callable[[float], None]

MAX_ILLUMINATION_BOUND = 2.0
"""Largest allowed absolute value of an illumination bound. A margin may move a bound outside [-1, 1]."""

NEGLIGIBLE = 1.5e-5
"""Squared illumination of one step of an 8-bit picture. The solver stops when a cycle
lowers the energy by less than this per pixel."""

SWEEP_RELAXATION, MAX_SWEEPS, SWEEP_TOLERANCE = 1.5, 500, 1e-5
"""Settings of the paper's solver: over-relaxation factor, maximum number of sweeps, and the relative energy decrease per
sweep below which it stops."""


@dataclass(frozen=True, eq=False)
class Refinement:
    """
    Result of a refinement.

    Attributes
    ----------
    normals : NormalField
        Refined normals.
    report : SolverReport
        Iterations, energies and why it stopped.
    """

    normals: NormalField
    report: SolverReport


def refine(
    initial_normals: NormalField,
    light: ArrayLike,
    interval: IlluminationInterval,
    *,
    alpha: ArrayLike | None = None,
    options: RefinementOptions | None = None,
    guess: NormalField | None = None,
    progress: Progress | None = None,
) -> Refinement:
    """
    Refine normals so that their illumination fits the painted colors, changing them smoothly.

    Parameters
    ----------
    initial_normals : NormalField
        Initial normals N0, from which the change is measured.
    light : array_like, shape (3,) or (2,)
        Direction from the surface to the light, or its azimuth and elevation in degrees.
    interval : IlluminationInterval
        Range of illumination that each pixel's color allows, bounds of shape (H, W). Where the ranges of
        two neighbors do not overlap, there is an edge, across which the change is barely smoothed. A mixed pixel whose
        range covers both sides conceals such an edge.
    alpha : array_like, shape (H, W), optional
        Coverage in [0, 1], used to locate the outline to sub-pixel precision; 1 inside the mask by default.
    options : RefinementOptions, optional
        Weights.
    guess : NormalField, optional
        Initial guess for the solver. A result for a nearby light or other weights speeds it up.
    progress : callable, optional
        Called with the fraction done, 0 to 1. An exception it raises aborts the refinement and propagates.

    Returns
    -------
    Refinement
        Normals and report. If the solver did not converge, the report says so; no error is raised.

    Raises
    ------
    ToonkitError
        If an argument has the wrong type, the light is invalid, a size differs, the interval is not finite or lies outside
        [-2, 2] on the object, alpha lies outside [0, 1], or the guess has a different mask.

    Notes
    -----
    Minimizes the energy of `toonkit.estimation.energy.change_energy`. Disconnected parts are
    refined separately, small ones together; see `toonkit.estimation.islands`.
    """
    of_type("initial_normals", initial_normals, NormalField)
    of_type("interval", interval, IlluminationInterval)
    if options is not None:
        of_type("options", options, RefinementOptions)
    if guess is not None:
        of_type("guess", guess, NormalField)
        same_mask("guess", guess.mask, initial_normals.mask, "the initial normals")
    check_callable("progress", progress)
    mask = initial_normals.mask
    direction, allowed = direction_of("light", light), _on_object(interval, mask)
    coverage = (
        mask.astype(np.float64) if alpha is None else as_coverage("alpha", alpha, initial_normals.shape)
    )
    islands, weights = islands_of(mask, coverage), RefinementOptions() if options is None else options
    energies = build_energies(islands, initial_normals, direction, allowed, weights)
    return refine_islands(islands, energies, mask, weights, guess=guess, progress=progress)


def build_energies(
    islands: tuple[Island, ...],
    initial_normals: NormalField,
    light: FloatArray,
    allowed: IlluminationInterval,
    options: RefinementOptions,
    *,
    painted: IlluminationInterval | None = None,
    hold: FloatArray | None = None,
) -> tuple[ChangeEnergy, ...]:
    """
    Build the energy of each of an object's islands; see `refine`. Nothing that it is built from is needed after that.

    Here the light is a unit vector, and intervals have bounds of shape (P,); for `painted` and `hold`, (P,), see
    `toonkit.estimation.energy.change_energy`.
    """
    return tuple(
        change_energy(
            island.grid, island.silhouette, island.own_vectors(initial_normals.compact),
            island.turn.vectors(light), _select(allowed, island.pixels), options,
            painted=None if painted is None else _select(painted, island.pixels),
            hold=None if hold is None else hold[island.pixels],
        )
        for island in islands
    )  # fmt: skip


def refine_islands(
    islands: tuple[Island, ...],
    energies: tuple[ChangeEnergy, ...],
    mask: BoolArray,
    options: RefinementOptions,
    *,
    guess: NormalField | None = None,
    progress: Progress | None = None,
) -> Refinement:
    """Minimize the energies of an object's islands, those of `build_energies`, one after the other; see `refine`."""
    tell = progress if progress is not None else _no_progress
    whole, done = sum(energy.grid.size for energy in energies), 0
    fields, reports = [], []
    for island, energy in zip(islands, energies, strict=True):
        size = energy.grid.size
        field, report = solve_unit_field(
            energy,
            guess=None if guess is None else island.own_vectors(guess.compact),
            tolerance=options.tolerance,
            negligible=NEGLIGIBLE,
            progress=partial(_report_share, tell, done / whole, size / whole),
        )
        fields.append(field)
        reports.append(report)
        done += size
    return Refinement(
        NormalField.of_pixels(unit_vectors(join_vectors(islands, fields)), mask), join_reports(reports)
    )


def _select(interval: IlluminationInterval, pixels: NDArray[np.integer] | slice) -> IlluminationInterval:
    return IlluminationInterval(interval.lower[pixels], interval.upper[pixels])


def _report_share(tell: Progress, done: float, share: float, fraction: float) -> None:
    """Report the progress of one island as that of the whole object."""
    tell(done + share * fraction)


def _no_progress(_fraction: float) -> None:
    """Stand in for a progress callable."""


def refine_as_printed(
    energy: SmoothnessEnergy,
    mask: BoolArray,
    *,
    relaxation: float = SWEEP_RELAXATION,
    max_sweeps: int = MAX_SWEEPS,
    tolerance: float = SWEEP_TOLERANCE,
    progress: Progress | None = None,
) -> Refinement:
    """
    Minimize Eq. 5 from N0 by Gauss-Seidel with successive over-relaxation, as in the paper.

    Parameters
    ----------
    energy : SmoothnessEnergy
        Energy returned by `toonkit.estimation.energy.printed_energy`.
    mask : ndarray, shape (H, W)
        The picture's mask, whose pixels in row-major order are those of the energy.
    relaxation : float, optional
        Over-relaxation factor.
    max_sweeps : int, optional
        Maximum number of sweeps.
    tolerance : float, optional
        Relative energy decrease per sweep below which it stops.
    progress : callable, optional
        Called with the fraction done, 0 to 1. An exception it raises aborts the refinement and propagates.

    Returns
    -------
    Refinement
        Normals and report.
    """
    field, report = over_relaxed_sweeps(
        energy, relaxation=relaxation, max_sweeps=max_sweeps, tolerance=tolerance, progress=progress
    )
    return Refinement(NormalField.of_pixels(field, mask), report)


def _on_object(interval: IlluminationInterval, mask: BoolArray) -> IlluminationInterval:
    """Check an interval (H, W) and return its bounds at the object's pixels, shape (P,)."""
    for name, bound in (("interval.lower", interval.lower), ("interval.upper", interval.upper)):
        same_shape(name, bound.shape, mask.shape, "the normals")
        if not np.isfinite(bound[mask]).all():
            raise refuse(name, "must be known and finite on the object", "NaN or infinite values")
        if np.abs(bound[mask]).max() > MAX_ILLUMINATION_BOUND:
            rule = f"must lie in [-{MAX_ILLUMINATION_BOUND:g}, {MAX_ILLUMINATION_BOUND:g}] (illumination lies in [-1, 1])"
            raise refuse(name, rule, f"{bound[mask].min():.4g} to {bound[mask].max():.4g}")
    return IlluminationInterval(interval.lower[mask], interval.upper[mask])
