"""Normal refinement (Section 3.3): an energy and a solver make normals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from toonkit._validation import (
    FloatArray,
    as_coverage,
    as_light,
    is_number,
    of_type,
    refuse,
    same_mask,
    same_shape,
)
from toonkit.estimation.edges import edge_links
from toonkit.estimation.energy import PrintedEnergy, ShadingTerm
from toonkit.estimation.silhouette import Silhouette, trace_silhouette
from toonkit.model.color_map import IlluminationInterval
from toonkit.model.normals import NormalField
from toonkit.numerics.bands import run_in_pieces
from toonkit.numerics.gauss_seidel import over_relaxed_sweeps
from toonkit.numerics.masked_grid import MaskedGrid, block_sums
from toonkit.numerics.report import SolverReport
from toonkit.numerics.unit_field import UnitFieldProblem, solve_unit_field

Progress = Callable[[float], None]

MARGIN_SHARE = 0.25
"""Largest share of an interval, on either side, that the margin takes."""

MARGIN_PER_EXCESS = 2.0
"""Largest margin, as a multiple of the root mean square by which the start misses its intervals."""

NEGLIGIBLE = 1.5e-5
"""Square of an illumination that nobody sees, a step of an 8-bit picture: a cycle that gains less a pixel is the last."""


@dataclass(frozen=True)
class RefinementOptions:
    """
    What our refinement weighs, in lengths relative to the object.

    Attributes
    ----------
    margin : float
        How far inside its interval a pixel is asked to be, in illumination; never more than a quarter of the interval, or
        than twice what the start misses its intervals by, root mean square.
        Without it every pixel that its interval moved would end exactly on a bound, and the smallest turn of the light
        would flip its color: old band edges would show in the relit picture.
    change_length : float
        Over what length the change of the normals is smooth, in units of sqrt(object area).
    change_reach : float
        Over what length a change dies out where nothing asks for it, in the same units.
    integrability_length : float
        Over what length the field is integrable, in the same units.
    crease_turn : float
        How much the initial normals turn, in radians per sqrt(object area), where their change is held together half as
        firmly: the edges of a cube stay edges.
    color_jump : float
        How far apart the illuminations of two neighbors' colors lie where their change is held together half as firmly:
        colors that meet in the picture but not in the color map are no shading bands of one smooth surface.
    rim_hold : float
        How firmly the silhouette's normals hold, 0 (free) to 1 (as firmly as neighbors hold each other).
    tolerance : float
        Relative decrease of the energy in one cycle of the solver at which it stops: all others together would gain less
        than that.
    """

    margin: float = 0.05
    change_length: float = 0.004
    change_reach: float = 0.2
    integrability_length: float = 0.01
    crease_turn: float = 10.0
    color_jump: float = 0.02
    rim_hold: float = 1.0
    tolerance: float = 0.04

    def __post_init__(self) -> None:
        for name in ("margin", "change_length", "integrability_length", "rim_hold"):
            value = getattr(self, name)
            if not is_number(value) or value < 0:
                raise refuse(name, "must be a number >= 0", value)
        for name in ("crease_turn", "color_jump", "change_reach", "tolerance"):
            value = getattr(self, name)
            if not is_number(value) or value <= 0:
                raise refuse(name, "must be a number > 0", value)


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
    light : array_like, shape (3,)
        Direction from the surface to the light.
    interval : IlluminationInterval
        Range of illumination that each pixel's color allows, bounds of shape (H, W). Where those of neighbors lie apart runs
        an edge; a mixed pixel whose range spans both sides hides it.
    alpha : array_like, shape (H, W), optional
        Coverage in [0, 1], which places the outline between pixels; the mask's own by default.
    options : RefinementOptions, optional
        Weights.
    guess : NormalField, optional
        Where to start looking: the answer to a problem like this one, under a light nearby or with other weights, makes it
        quick.
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
    Minimizes `toonkit.estimation.energy.ChangeEnergy`.
    """
    of_type("initial_normals", initial_normals, NormalField)
    of_type("interval", interval, IlluminationInterval)
    if options is not None:
        of_type("options", options, RefinementOptions)
    if guess is not None:
        of_type("guess", guess, NormalField)
        same_mask("guess", guess.mask, initial_normals.mask, "the initial normals")
    grid = MaskedGrid(initial_normals.mask)
    shading = _shading_term(grid, light, interval)
    coverage = (
        grid.mask.astype(np.float64) if alpha is None else as_coverage("alpha", alpha, initial_normals.shape)
    )
    return refine_traced(
        trace_silhouette(grid, coverage), initial_normals, shading,
        grid=grid, options=options, guess=guess, progress=progress,
    )  # fmt: skip


def refine_traced(
    silhouette: Silhouette,
    initial_normals: NormalField,
    shading: ShadingTerm,
    *,
    grid: MaskedGrid,
    painted: IlluminationInterval | None = None,
    options: RefinementOptions | None = None,
    guess: NormalField | None = None,
    progress: Progress | None = None,
) -> Refinement:
    """
    Refine normals of an object whose outline has been traced, and whose intervals are known; see `refine`.

    What the colors allow by themselves, mixtures apart, is `painted`, with bounds of shape (P,); by default as the shading.
    """
    options = RefinementOptions() if options is None else options
    field, report = solve_unit_field(
        stated(silhouette, initial_normals, shading, grid, options, painted),
        guess=None if guess is None else guess.compact,
        tolerance=options.tolerance,
        negligible=NEGLIGIBLE,
        progress=progress,
    )
    return Refinement(NormalField.of_pixels(field, grid.mask), report)


def stated(
    silhouette: Silhouette,
    initial_normals: NormalField,
    shading: ShadingTerm,
    grid: MaskedGrid,
    options: RefinementOptions,
    painted: IlluminationInterval | None = None,
) -> UnitFieldProblem:
    """State the problem that a refinement solves: `ChangeEnergy`, in lengths of the object; see `refine_traced`."""
    start = initial_normals.compact
    if painted is None:
        painted = IlluminationInterval(shading.lower, shading.upper)
    links = edge_links(grid, start, painted, turn=options.crease_turn, jump=options.color_jump)
    shading = _with_margin(shading, start, options.margin)
    size = float(np.sqrt(grid.size))
    rim = block_sums(silhouette.pixels, 1.0 / silhouette.distances, grid.size)
    return UnitFieldProblem(
        grid=grid,
        start=start,
        direction=shading.light,
        lower=shading.lower,
        upper=shading.upper,
        weight=np.ones(grid.size),
        links=links,
        ties=options.rim_hold * rim + 1.0 / (options.change_reach * size) ** 2,
        change_weight=(options.change_length * size) ** 2,
        integrability_weight=(options.integrability_length * size) ** 2,
    )


def refine_as_printed(
    initial_normals: NormalField,
    light: ArrayLike,
    interval: IlluminationInterval,
    *,
    rho: float,
    smoothness: float,
    relaxation: float = 1.5,
    max_sweeps: int = 500,
    tolerance: float = 1e-5,
    progress: Progress | None = None,
) -> Refinement:
    """
    Refine normals by Eq. 5 with Gauss-Seidel and successive over-relaxation, from N0: the paper's own way.

    Parameters
    ----------
    initial_normals : NormalField
        N0.
    light : array_like, shape (3,)
        Direction from the surface to the light.
    interval : IlluminationInterval
        Range of illumination that each pixel's color allows; lower = upper gives Eq. 3.
    rho, smoothness : float
        The paper's rho and lambda, per pixel.
    relaxation : float, optional
        Over-relaxation factor.
    max_sweeps : int, optional
        Sweeps allowed.
    tolerance : float, optional
        Relative decrease of the energy in one sweep below which it stands still.
    progress : callable, optional
        Called with the fraction done, 0 to 1; what it raises stops the refinement.

    Returns
    -------
    Refinement
        Normals and report.

    Raises
    ------
    ToonkitError
        If the light is refused or the interval has another size or is unknown on the object.
    """
    grid = MaskedGrid(initial_normals.mask)
    shading = _shading_term(grid, light, interval)
    energy = PrintedEnergy(grid, shading, rho, smoothness)
    field, report = over_relaxed_sweeps(
        grid,
        initial_normals.compact,
        shading.light,
        shading.lower,
        shading.upper,
        rho=rho,
        smoothness=smoothness,
        relaxation=relaxation,
        max_sweeps=max_sweeps,
        tolerance=tolerance,
        energy=energy.value,
        progress=progress,
    )
    return Refinement(NormalField.of_pixels(field, grid.mask), report)


def _with_margin(shading: ShadingTerm, start: FloatArray, margin: float) -> ShadingTerm:
    """
    Move the bounds inward, but for -1 and 1: those end the darkest and the brightest color, and are no band edges.

    The margin is for pixels that have to move: a start that explains the picture already is to stay as it is.
    """
    missed, darkest, brightest = np.array(run_in_pieces(_occurring, len(start), shading, start)).T
    margin = min(margin, MARGIN_PER_EXCESS * float(np.sqrt(missed.sum() / len(start))))
    lower, upper = np.empty((2, len(start)))
    run_in_pieces(_narrow, len(start), shading, margin, darkest.min(), brightest.max(), lower, upper)
    return ShadingTerm(shading.light, lower, upper)


def _occurring(shading: ShadingTerm, start: FloatArray, piece: slice) -> tuple[float, float, float]:
    """Return by how much some pixels miss their intervals, squared, and their least and greatest illumination."""
    value = start[piece] @ shading.light
    excess = value - np.clip(value, shading.lower[piece], shading.upper[piece])
    return float(excess @ excess), float(value.min()), float(value.max())


def _narrow(
    shading: ShadingTerm,
    margin: float,
    darkest: float,
    brightest: float,
    lower: FloatArray,
    upper: FloatArray,
    piece: slice,
) -> None:
    """Write the bounds of some pixels, moved inward."""
    low, high = shading.lower[piece], shading.upper[piece]
    width = np.minimum(high, brightest) - np.maximum(low, darkest)
    inward = np.minimum(margin, MARGIN_SHARE * np.maximum(width, 0.0))
    lower[piece] = np.where(low > -1.0, low + inward, low)
    upper[piece] = np.maximum(np.where(high < 1.0, high - inward, high), lower[piece])


def _shading_term(grid: MaskedGrid, light: ArrayLike, interval: IlluminationInterval) -> ShadingTerm:
    for name, bound in (("interval.lower", interval.lower), ("interval.upper", interval.upper)):
        same_shape(name, bound.shape, grid.mask.shape, "the normals")
        if not np.isfinite(bound[grid.mask]).all():
            raise refuse(name, "must be known and finite on the object", "NaN or infinite values")
    return ShadingTerm(as_light("light", light), interval.lower[grid.mask], interval.upper[grid.mask])
