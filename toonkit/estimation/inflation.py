"""Initial normals by silhouette inflation (Section 3.1, Eq. 1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from toonkit._validation import FloatArray, as_coverage, as_mask
from toonkit.estimation.islands import Island, islands_of, join_vectors
from toonkit.estimation.silhouette import Silhouette
from toonkit.model.normals import NormalField
from toonkit.numerics.masked_grid import MaskedGrid, block_sums
from toonkit.numerics.parallel import run_on_chunks
from toonkit.numerics.screened_poisson import ScreenedPoisson, solve_screened_poisson, uniform_edge_weights

RESIDUAL_TOLERANCE = 1e-5
"""Relative residual of the harmonic solve. It changes the normals by a few thousandths of a degree on average, far less than
the error of the outline."""


def inflate(mask: ArrayLike, *, alpha: ArrayLike | None = None) -> NormalField:
    """
    Inflate a silhouette to a rounded normal field.

    Parameters
    ----------
    mask : array_like, shape (H, W)
        True on the object; it may have several components and holes.
    alpha : array_like, shape (H, W), optional
        Coverage in [0, 1], used to locate the outline to sub-pixel precision. Without it the mask's outline is smoothed.

    Returns
    -------
    NormalField
        The initial normals N0.

    Raises
    ------
    ToonkitError
        If the mask covers fewer than 9 pixels, or alpha has a different size or contains values outside [0, 1].

    Notes
    -----
    Eq. 1 asks for a harmonic N0 with N = (nx, ny, 0) on the silhouette. Taken literally, this makes nz zero everywhere.
    Following Lumo [1]_ the harmonic functions are nx and ny, and nz = sqrt(1 - nx² - ny²). The boundary conditions
    are imposed at the sub-pixel distance of the outline from each rim pixel, with the symmetric scheme of [2]_. For a disc
    the result converges to a hemisphere at second order in the pixel size.

    References
    ----------
    .. [1] S. F. Johnston, "Lumo: illumination for cel animation", NPAR 2002, doi:10.1145/508530.508538
    .. [2] F. Gibou, R. Fedkiw, L.-T. Cheng, M. Kang, "A second-order-accurate symmetric discretization of the Poisson
       equation on irregular domains", J. Comput. Phys. 176 (2002), doi:10.1006/jcph.2001.6977

    Examples
    --------
    >>> y, x = np.mgrid[:65, :65] - 32
    >>> normals = inflate(x**2 + y**2 < 30**2)
    >>> float(normals.vectors[32, 32, 2].round(6))
    1.0
    """
    on_object = as_mask("mask", mask)
    shape = on_object.shape
    coverage = (
        on_object.astype(np.float64) if alpha is None else as_coverage("alpha", alpha, (shape[0], shape[1]))
    )
    islands = islands_of(on_object, coverage)
    return NormalField.of_pixels(inflate_islands(islands), on_object)


def inflate_islands(islands: tuple[Island, ...]) -> FloatArray:
    """Return the inflated normals (P, 3) of an object's islands; see `inflate`."""
    return join_vectors(islands, [inflate_silhouette(island.grid, island.silhouette) for island in islands])


def inflate_silhouette(grid: MaskedGrid, silhouette: Silhouette) -> FloatArray:
    """Return the inflated normals (P, 3) of an outline that has been traced; see `inflate`."""
    sideways, _ = solve_screened_poisson(*silhouette_system(grid, silhouette), tolerance=RESIDUAL_TOLERANCE)
    vectors = np.empty((grid.size, 3))
    run_on_chunks(_fill_in_nz, grid.size, sideways, vectors)
    return vectors


def silhouette_system(
    grid: MaskedGrid, silhouette: Silhouette
) -> tuple[ScreenedPoisson, NDArray[np.complex128]]:
    """
    Return the screened Poisson system, and its right-hand side (P,) for nx + i ny.

    Its screening holds each rim pixel to the outward outline normal (Eq. 1).
    """
    stiffness = 1.0 / silhouette.distances
    ties = block_sums(silhouette.pixels, stiffness, grid.size)
    pull = [block_sums(silhouette.pixels, stiffness * part, grid.size) for part in silhouette.outward.T]
    return ScreenedPoisson(grid, uniform_edge_weights(grid), ties), pull[0] + 1j * pull[1]


def _fill_in_nz(sideways: NDArray[np.complex128], vectors: FloatArray, piece: slice) -> None:
    """Write the normals (P, 3) given nx + i ny, whose length is clipped to 1 because the solver may exceed it slightly."""
    flat = sideways[piece] / np.maximum(np.abs(sideways[piece]), 1.0)
    vectors[piece, 0], vectors[piece, 1] = flat.real, flat.imag
    vectors[piece, 2] = np.sqrt(np.maximum(1.0 - flat.real**2 - flat.imag**2, 0.0))
