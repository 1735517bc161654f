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
from toonkit.numerics.gauss_seidel import over_relaxed_sweeps
from toonkit.numerics.report import SolverReport, join_reports
from toonkit.numerics.smoothness_energy import SmoothnessEnergy
from toonkit.numerics.unit_field import solve_unit_field

Progress = Callable[[float], None]

FARTHEST = 2.0
"""Largest absolute value of a bound of illumination. A margin may move bounds beyond -1 and 1."""

NEGLIGIBLE = 1.5e-5
"""Squared illumination of one step of an 8-bit picture. A cycle that gains less than this per pixel is the last one."""

SWEEP_RELAXATION, MAX_SWEEPS, SWEEP_TOLERANCE = 1.5, 500, 1e-5
"""How the paper's solver runs: over-relaxation factor, sweeps allowed, and the relative decrease of the energy in one sweep
at which it stops."""


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
        N0.
    light : array_like, shape (3,) or (2,)
        Direction from the surface to the light, or its azimuth and elevation in degrees.
    interval : IlluminationInterval
        Range of illumination that each pixel's color allows, bounds of shape (H, W). If the ranges of neighbors are
        apart, there is an edge between them. A mixed pixel whose range spans both sides hides it.
    alpha : array_like, shape (H, W), optional
        Coverage in [0, 1], which places the outline between pixels; the mask's own by default.
    options : RefinementOptions, optional
        Weights.
    guess : NormalField, optional
        Start of the search. The result under a nearby light or with other weights makes it faster.
    progress : callable, optional
        Called with the fraction done, 0 to 1; what it raises stops the refinement.

    Returns
    -------
    Refinement
        Normals and report; not having converged is a state in it, not an error.

    Raises
    ------
    ToonkitError
        If the light is refused, the interval or alpha has another size, the interval is unknown on the object, alpha leaves
        [0, 1], or the guess covers another mask.

    Notes
    -----
    Minimizes the energy of `toonkit.estimation.energy.change_energy`. Parts of the object that do not touch are refined each
    by itself.
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
    return refine_islands(
        islands_of(mask, coverage), initial_normals, direction, allowed,
        options=options, guess=guess, progress=progress,
    )  # fmt: skip


def refine_islands(
    islands: tuple[Island, ...],
    initial_normals: NormalField,
    light: FloatArray,
    allowed: IlluminationInterval,
    *,
    painted: IlluminationInterval | None = None,
    options: RefinementOptions | None = None,
    guess: NormalField | None = None,
    progress: Progress | None = None,
) -> Refinement:
    """
    Refine the normals of an object's islands, each by itself; see `refine`.

    Here the light is a unit vector, and intervals have bounds of shape (P,); for `painted` see
    `toonkit.estimation.energy.change_energy`.
    """
    options = RefinementOptions() if options is None else options
    tell = progress if progress is not None else _ignored
    whole, done = len(initial_normals.compact), 0
    fields, reports = [], []
    for island in islands:
        size, pixels = island.grid.size, island.pixels
        energy = change_energy(
            island.grid, island.silhouette, island.own_vectors(initial_normals.compact),
            island.turn.vectors(light), _of_pixels(allowed, pixels), options,
            painted=None if painted is None else _of_pixels(painted, pixels),
        )  # fmt: skip
        field, report = solve_unit_field(
            energy,
            guess=None if guess is None else island.own_vectors(guess.compact),
            tolerance=options.tolerance,
            negligible=NEGLIGIBLE,
            progress=partial(_tell_share, tell, done / whole, size / whole),
        )
        fields.append(field)
        reports.append(report)
        done += size
    return Refinement(
        NormalField.of_pixels(join_vectors(islands, fields), initial_normals.mask), join_reports(reports)
    )


def _of_pixels(interval: IlluminationInterval, pixels: NDArray[np.integer] | slice) -> IlluminationInterval:
    return IlluminationInterval(interval.lower[pixels], interval.upper[pixels])


def _tell_share(tell: Progress, done: float, share: float, fraction: float) -> None:
    """Report the progress of one island as that of the whole object."""
    tell(done + share * fraction)


def _ignored(_fraction: float) -> None:
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
    Minimize Eq. 5 from N0 by Gauss-Seidel with successive over-relaxation: the paper's own way.

    Parameters
    ----------
    energy : SmoothnessEnergy
        Of `toonkit.estimation.energy.printed_energy`.
    mask : ndarray, shape (H, W)
        The picture's mask, whose pixels in row-major order are those of the energy.
    relaxation : float, optional
        Over-relaxation factor.
    max_sweeps : int, optional
        Sweeps allowed.
    tolerance : float, optional
        Relative decrease of the energy in one sweep at which it stops.
    progress : callable, optional
        Called with the fraction done, 0 to 1; what it raises stops the refinement.

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
    """Return an interval (H, W) at the object's pixels, (P,)."""
    for name, bound in (("interval.lower", interval.lower), ("interval.upper", interval.upper)):
        same_shape(name, bound.shape, mask.shape, "the normals")
        if not np.isfinite(bound[mask]).all():
            raise refuse(name, "must be known and finite on the object", "NaN or infinite values")
        if np.abs(bound[mask]).max() > FARTHEST:
            rule = f"must lie in [-{FARTHEST:g}, {FARTHEST:g}] (illumination lies in [-1, 1])"
            raise refuse(name, rule, f"{bound[mask].min():.4g} to {bound[mask].max():.4g}")
    return IlluminationInterval(interval.lower[mask], interval.upper[mask])
