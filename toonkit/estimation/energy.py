"""
What the refinement minimizes (Section 3.3): the energies of the paper and of our own method, built from a drawing.

Both are energies of unit normals N whose illumination L · N should lie within the interval that the color of the pixel
allows (Eq. 6). `printed_energy` is Eq. 5 of the paper. `change_energy` is ours: it prefers a smooth *change* from the
initial normals, and normals of an actual surface. Both functions return an energy object of `toonkit.numerics`, which
every solver can minimize and which can be evaluated and differentiated without a solver.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toonkit._validation import FloatArray, is_number, refuse
from toonkit.estimation.edges import edge_links
from toonkit.estimation.silhouette import Silhouette
from toonkit.model.color_map import IlluminationInterval
from toonkit.numerics.change_energy import ChangeEnergy
from toonkit.numerics.masked_grid import MaskedGrid, block_sums
from toonkit.numerics.parallel import run_on_chunks
from toonkit.numerics.smoothness_energy import SmoothnessEnergy
from toonkit.numerics.unit_vectors import Stored

MARGIN_SHARE = 0.25
"""Largest margin, as a share of the interval."""

MARGIN_PER_EXCESS = 2.0
"""Largest margin, as a multiple of the root mean square by which the start misses its intervals."""


STORED = np.float32
"""What our energy is stored in: exact to seven digits, which turns normals by less than a thousandth of a degree."""

TINY, HUGE = 1e-6, 1e12
"""Limits of options that a refinement divides by. Beyond them nothing changes, and squares would overflow."""

LIMITS = {
    "margin": (0.0, 2.0, "illumination spans 2"),
    "change_length": (0.0, 1e3, "it is relative to the object"),
    "change_reach": (1e-3, 1e6, "it is relative to the object"),
    "integrability_length": (0.0, 1e3, "it is relative to the object"),
    "crease_turn": (TINY, HUGE, "beyond, all links are alike"),
    "color_jump": (TINY, HUGE, "beyond, all links are alike"),
    "rim_hold": (0.0, 1e6, "1 is as firmly as neighbors hold each other"),
    "tolerance": (1e-15, 1.0, "it is a share of the energy"),
}
"""Least and greatest value of each option of a refinement, and why."""


@dataclass(frozen=True)
class RefinementOptions:
    """
    What our refinement weighs, in lengths relative to the object.

    Attributes
    ----------
    margin : float
        How far inside its interval the illumination of a pixel should be. It is at most a quarter of the interval, and
        at most twice the root mean square by which the start misses its intervals. Without a margin, every pixel that
        is moved ends exactly on a bound. The smallest turn of the light then flips its color, and old band edges show
        in the relit picture.
    change_length : float
        Length over which the change of the normals is smooth, in units of sqrt(object area).
    change_reach : float
        Length over which a change fades away from the pixels that cause it, in the same units.
    integrability_length : float
        Length over which the field is integrable, in the same units.
    crease_turn : float
        Turn of the initial normals, in radians per sqrt(object area), at which the smoothness of their change has half
        its weight. It keeps the edges of a cube sharp.
    color_jump : float
        Distance between the illuminations of two neighboring colors at which the smoothness between them has half its
        weight. Colors that meet in the picture but not in the color map are not bands of one smooth surface.
    rim_hold : float
        Weight of the normals at the silhouette, from 0 (free) to 1 (the weight between neighbors).
    tolerance : float
        Relative decrease of the energy in one cycle at which the solver stops. All further cycles together would gain
        less.

    Raises
    ------
    ToonkitError
        If an option lies outside its `LIMITS`.
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
        for name, (least, most, why) in LIMITS.items():
            value = getattr(self, name)
            if not is_number(value) or not least <= value <= most:
                raise refuse(name, f"must be a number from {least:g} to {most:g} ({why})", value)
            object.__setattr__(self, name, float(value))


def printed_energy(
    grid: MaskedGrid,
    initial: FloatArray,
    light: FloatArray,
    allowed: IlluminationInterval,
    *,
    rho: float,
    smoothness: float,
) -> SmoothnessEnergy:
    """
    Build Eq. 5: rho times the penalty of Eq. 6 plus lambda times the squared Laplacian of the normals.

    Parameters
    ----------
    grid : MaskedGrid
        The object.
    initial : ndarray, shape (P, 3)
        N0, where the paper starts.
    light : ndarray, shape (3,)
        Unit vector L.
    allowed : IlluminationInterval
        Range of illumination that each pixel's color allows, bounds of shape (P,); lower = upper gives Eq. 3.
    rho, smoothness : float
        The paper's rho and lambda, per pixel.

    Returns
    -------
    SmoothnessEnergy
        The energy.
    """
    return SmoothnessEnergy.on_pixels(
        grid, initial, light, allowed.lower, allowed.upper, weight=rho, smoothness=smoothness
    )


def change_energy(
    grid: MaskedGrid,
    silhouette: Silhouette,
    initial: FloatArray,
    light: FloatArray,
    allowed: IlluminationInterval,
    options: RefinementOptions,
    *,
    painted: IlluminationInterval | None = None,
    hold: FloatArray | None = None,
) -> ChangeEnergy:
    """
    Build our energy, whose lengths are relative to the object.

    Parameters
    ----------
    grid : MaskedGrid
        The object.
    silhouette : Silhouette
        Its outline, which holds the normals of the rim.
    initial : ndarray, shape (P, 3)
        Unit normals N0 from which the change is measured.
    light : ndarray, shape (3,)
        Unit vector L.
    allowed : IlluminationInterval
        Range of illumination that each pixel's color allows, bounds of shape (P,).
    options : RefinementOptions
        Weights.
    painted : IlluminationInterval, optional
        Range that each color allows by itself, without the range of mixed pixels; `allowed` by default. If the ranges
        of neighbors are apart, there is an edge.
    hold : ndarray, shape (P,), optional
        How firmly normals are held to N0 because a person asks for them, relative to the weight of a painted color; not at
        all by default. It needs a `change_length` above 0.

    Returns
    -------
    ChangeEnergy
        The energy.
    """
    links = edge_links(
        grid,
        initial,
        allowed if painted is None else painted,
        turn=options.crease_turn,
        jump=options.color_jump,
    )
    lower, upper = _with_margin(allowed, initial, light, options.margin)
    size = float(np.sqrt(grid.size))
    ties = options.rim_hold * block_sums(silhouette.pixels, 1.0 / silhouette.distances, grid.size)
    ties += 1.0 / (options.change_reach * size) ** 2
    if hold is not None:
        ties += hold / (options.change_length * size) ** 2
    return ChangeEnergy(
        grid=grid,
        start=initial.astype(STORED),
        direction=light,
        lower=lower,
        upper=upper,
        weight=np.ones(grid.size, STORED),
        edge_weights=links,
        screening=ties.astype(STORED),
        change_weight=(options.change_length * size) ** 2,
        integrability_weight=(options.integrability_length * size) ** 2,
    )


def _with_margin(
    allowed: IlluminationInterval, initial: FloatArray, light: FloatArray, margin: float
) -> tuple[Stored, Stored]:
    """
    Move the bounds inward, except -1 and 1, which are not band edges.

    The margin depends on how far pixels have to move. A start that already explains the picture should stay as it is.
    """
    found = run_on_chunks(_occurring, len(initial), allowed, initial, light)
    missed, darkest, brightest = np.array(found).T
    margin = min(margin, MARGIN_PER_EXCESS * float(np.sqrt(missed.sum() / len(initial))))
    lower, upper = np.empty((2, len(initial)), STORED)
    run_on_chunks(_narrow, len(initial), allowed, margin, darkest.min(), brightest.max(), lower, upper)
    return lower, upper


def _occurring(
    allowed: IlluminationInterval, initial: FloatArray, light: FloatArray, piece: slice
) -> tuple[float, float, float]:
    """Return by how much some pixels miss their intervals, squared, and their least and greatest illumination."""
    value = initial[piece] @ light
    excess = value - np.clip(value, allowed.lower[piece], allowed.upper[piece])
    return float(excess @ excess), float(value.min()), float(value.max())


def _narrow(
    allowed: IlluminationInterval,
    margin: float,
    darkest: float,
    brightest: float,
    lower: Stored,
    upper: Stored,
    piece: slice,
) -> None:
    """Write the bounds of some pixels, moved inward."""
    low, high = allowed.lower[piece], allowed.upper[piece]
    width = np.minimum(high, brightest) - np.maximum(low, darkest)
    inward = np.minimum(margin, MARGIN_SHARE * np.maximum(width, 0.0))
    lower[piece] = np.where(low > -1.0, low + inward, low)
    upper[piece] = np.maximum(np.where(high < 1.0, high - inward, high), lower[piece])
