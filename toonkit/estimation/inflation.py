"""Initial normals by silhouette inflation (Section 3.1, Eq. 1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from toonkit._validation import FloatArray, as_coverage, as_mask
from toonkit.estimation.islands import Island, islands_of, join_vectors
from toonkit.estimation.silhouette import Silhouette
from toonkit.model.normals import NormalField
from toonkit.numerics.bands import run_in_pieces
from toonkit.numerics.masked_grid import MaskedGrid, block_sums
from toonkit.numerics.membrane import Membrane, solve_membrane, uniform_links

RESIDUAL_TOLERANCE = 1e-5
"""Relative residual of the harmonic solve. It is worth a few thousandths of a degree on average, far less than the
error of the outline."""


def inflate(mask: ArrayLike, *, alpha: ArrayLike | None = None) -> NormalField:
    """
    Inflate a silhouette to a rounded normal field.

    Parameters
    ----------
    mask : array_like, shape (H, W)
        True on the object; it may have several components and holes.
    alpha : array_like, shape (H, W), optional
        Coverage in [0, 1], which places the outline between pixels. Without it the outline of the mask is smoothed.

    Returns
    -------
    NormalField
        The initial normals N0.

    Raises
    ------
    ToonkitError
        If the mask is empty or too small, or alpha has another size or leaves [0, 1].

    Notes
    -----
    Eq. 1 asks for a harmonic N0 with N = (nx, ny, 0) on the silhouette; read literally nz would vanish everywhere.
    Following Lumo [1]_ the harmonic functions are nx and ny, and nz = sqrt(1 - nx² - ny²). The silhouette conditions
    stand at the outline's sub-pixel distance from each rim pixel, by the symmetric scheme of [2]_: a disc becomes the
    hemisphere up to second order.

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
    sideways, _ = solve_membrane(*silhouette_system(grid, silhouette), tolerance=RESIDUAL_TOLERANCE)
    vectors = np.empty((grid.size, 3))
    run_in_pieces(_complete, grid.size, sideways, vectors)
    return vectors


def silhouette_system(grid: MaskedGrid, silhouette: Silhouette) -> tuple[Membrane, NDArray[np.complex128]]:
    """Membrane that ties every rim pixel to the outline's direction (Eq. 1), and its right side (P,): that of nx + i ny."""
    stiffness = 1.0 / silhouette.distances
    ties = block_sums(silhouette.pixels, stiffness, grid.size)
    pull = [block_sums(silhouette.pixels, stiffness * part, grid.size) for part in silhouette.outward.T]
    return Membrane(grid, uniform_links(grid), ties), pull[0] + 1j * pull[1]


def _complete(sideways: NDArray[np.complex128], vectors: FloatArray, piece: slice) -> None:
    """Write vectors (P, 3): nz beside nx + i ny, which a solver may leave a rounding error longer than one."""
    flat = sideways[piece] / np.maximum(np.abs(sideways[piece]), 1.0)
    vectors[piece, 0], vectors[piece, 1] = flat.real, flat.imag
    vectors[piece, 2] = np.sqrt(np.maximum(1.0 - flat.real**2 - flat.imag**2, 0.0))
