"""The problems of the estimation, solved the usual ways: assembled and factorized, by pyamg, and by over-relaxed sweeps.

All of them work on the very same problem objects as toonkit's own solvers, in the same process.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import pyamg
import scipy.sparse as sp
from numba import njit
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from toonkit.numerics.change_energy import ChangeEnergy
from toonkit.numerics.change_kernels import sweep_change
from toonkit.numerics.gauss_seidel import OverRelaxation
from toonkit.numerics.masked_grid import OUTSIDE, RIGHT, UP, MaskedGrid
from toonkit.numerics.screened_poisson import ScreenedPoisson
from toonkit.numerics.smoothness_energy import SmoothnessEnergy
from toonkit.numerics.unit_vectors import UnitVectorEnergy, add_and_normalize

RELAXATION = 1.5
"""The paper's over-relaxation."""

LOOKED_AT_EVERY = 25
"""Sweeps between two looks at the energy and the clock."""

LEAST_DAMPING, MOST_DAMPING = 1e-8, 1e8
"""Of Newton's method, in units of the matrix's diagonal: with more no step lowers the energy any more."""

LEAST_DIAGONAL = 1e-9
"""Share of the largest entry on the diagonal that counts where there is less."""

Array = NDArray[np.float64]
LinearSolver = Callable[[sp.csr_matrix, Array], Array]
"""From a symmetric positive definite matrix (n, n) and right sides (n, C) to the solution (n, C)."""


def factorized(matrix: sp.csr_matrix, right_side: Array) -> Array:
    """Solve by a sparse LU factorization in the order for symmetric matrices."""
    return splu(
        matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.0
    ).solve(right_side)


def by_pyamg(matrix: sp.csr_matrix, right_side: Array) -> Array:
    """Solve by conjugate gradients with pyamg's smoothed aggregation, to the residual that toonkit asks for."""
    hierarchy = pyamg.smoothed_aggregation_solver(matrix)
    parts = [hierarchy.solve(part, tol=2e-5, accel="cg") for part in right_side.T]
    return np.stack(parts, axis=1)


def laplacian(grid: MaskedGrid, edge_weights: Array, screening: Array) -> sp.csr_matrix:
    """Assemble the matrix of a screened Poisson system."""
    matrix = sp.diags(screening + edge_weights.sum(axis=1)).tocsr()
    for k in range(4):
        here = np.flatnonzero(grid.neighbors[:, k] != OUTSIDE)
        there = grid.neighbors[here, k]
        matrix = matrix - sp.csr_matrix((edge_weights[here, k], (here, there)), matrix.shape)
    return matrix.tocsr()


def solve_poisson_with(
    poisson: ScreenedPoisson, right_side: NDArray[np.complex128], solve: LinearSolver
) -> Array:
    """Solve a screened Poisson system with two right sides, assembling included."""
    matrix = laplacian(poisson.grid, poisson.edge_weights, poisson.screening)
    return solve(matrix, np.stack([right_side.real, right_side.imag], axis=1))


def sweep_poisson(
    poisson: ScreenedPoisson, right_side: NDArray[np.complex128], tolerance: float, limit: float
) -> float:
    """Sweep from zero until the residual is as small as asked for; return the seconds, `limit` at most."""
    field = np.zeros_like(right_side)
    goal = tolerance * np.linalg.norm(right_side)
    begin = time.perf_counter()
    while time.perf_counter() - begin < limit:
        for _ in range(LOOKED_AT_EVERY):
            poisson.sweep(right_side, field, backward=False)
        if np.linalg.norm(right_side - poisson.apply(field)) <= goal:
            break
    return time.perf_counter() - begin


def energy(problem: UnitVectorEnergy, field: Array, gradient: Array | None = None) -> float:
    """Energy of a field, by the same compiled loop for everyone."""
    return problem.value_and_gradient(
        problem.terms, field, np.empty_like(field) if gradient is None else gradient
    )


def swept(problem: UnitVectorEnergy, goal: float, limit: float) -> tuple[float, float]:
    """
    Sweep over-relaxed from the start until the energy is down to `goal`; return seconds, at `limit` at most, and energy.

    Eq. 5 by the sweeps of the paper's method as it stands in toonkit, the refinement by its own steps.
    """
    sweeps = _paper_sweeps if isinstance(problem, SmoothnessEnergy) else _field_sweeps
    sweeps(problem, problem.start.copy(), 1)  # compiled
    field = problem.start.copy()
    spent, reached = 0.0, np.inf
    while spent < limit and reached > goal:
        begin = time.perf_counter()
        field = sweeps(problem, field, LOOKED_AT_EVERY)
        spent += time.perf_counter() - begin
        reached = energy(problem, field)
    return spent, reached


def _paper_sweeps(problem: SmoothnessEnergy, field: Array, sweeps: int) -> Array:
    OverRelaxation(problem, RELAXATION).sweep(field, sweeps)
    return field


def _field_sweeps(problem: ChangeEnergy, field: Array, sweeps: int) -> Array:
    nothing = np.zeros(0)
    _over_relaxed(
        problem.grid.neighbors, problem.start, problem.direction, nothing, nothing, problem.lower, problem.upper,
        problem.weight, problem.edge_weights, problem.screening, problem.change_weight, problem.integrability_weight,
        np.zeros((0, 3)), field, RELAXATION, sweeps,
    )  # fmt: skip
    return field


def newton(
    problem: UnitVectorEnergy, goal: float, limit: float, solve: LinearSolver
) -> tuple[float, float, Array]:
    """
    Solve by Newton's method on the tangent planes, each step with an assembled matrix, until the energy meets `goal`.

    Returns the seconds, the energy and the field; the energy is above the goal if the time is up or no step lowers it.
    """
    begin = time.perf_counter()
    field = problem.start.copy()
    gradient, slopes_after = np.empty((2, *field.shape))
    reached = energy(problem, field, gradient)
    smoothness, rest = _bilinear(problem)
    damping = 1e-3
    while reached > goal and damping < MOST_DAMPING and time.perf_counter() - begin < limit:
        frame = _tangents(field)
        matrix = _curvature(problem, field, smoothness, rest, frame)
        diagonal = matrix.diagonal()
        # A pixel by itself, within its interval, is held by nothing: any step of it is as good.
        matrix = matrix + damping * sp.diags(np.maximum(diagonal, LEAST_DIAGONAL * diagonal.max()))
        slopes = -(frame.T @ gradient.ravel())
        step = (frame @ solve(matrix.tocsr(), slopes[:, None])[:, 0]).reshape(field.shape)
        for length in (1.0, 0.5, 0.25, 0.1, 0.03):
            trial = add_and_normalize(problem.grid, field, length * step)
            after = energy(problem, trial, slopes_after)
            if after < reached:
                break
        if after >= reached:
            damping *= 10
            continue
        field, reached, damping = trial, after, max(damping / 4, LEAST_DAMPING)
        gradient, slopes_after = slopes_after, gradient
    return time.perf_counter() - begin, reached, field


def _tangents(field: Array) -> sp.csr_matrix:
    """Two tangents at each normal, as a matrix (3 P, 2 P)."""
    x, y, z = field.T
    share = 1.0 / (1.0 + z)
    first = np.stack([1.0 - x * x * share, -x * y * share, -x], axis=1)
    second = np.stack([-x * y * share, 1.0 - y * y * share, -y], axis=1)
    count = len(field)
    rows = np.arange(3 * count).repeat(2)
    columns = (2 * np.arange(count))[:, None, None] + np.array([0, 1])
    values = np.stack([first, second], axis=2)
    return sp.csr_matrix(
        (values.ravel(), (rows, np.broadcast_to(columns, values.shape).ravel())), (3 * count, 2 * count)
    )


def _bilinear(problem: UnitVectorEnergy) -> tuple[sp.csr_matrix, Array]:
    """Return what holds the vectors together, as a matrix (P, P) for each component, and the field left at rest."""
    if isinstance(problem, SmoothnessEnergy):
        turns = laplacian(problem.grid, problem.edge_weights, np.zeros(problem.grid.size))
        squared = turns.T @ sp.diags(1.0 / problem.areas) @ turns
        return (problem.smoothness * squared).tocsr(), np.zeros_like(problem.start)
    return problem.change_weight * laplacian(
        problem.grid, problem.edge_weights, problem.screening
    ), problem.start


def _curvature(
    problem: UnitVectorEnergy, field: Array, smoothness: sp.csr_matrix, rest: Array, frame: sp.csr_matrix
) -> sp.csr_matrix:
    """Second derivatives of the energy's convex part on the tangent planes, shape (2 P, 2 P)."""
    pull = 2.0 * (smoothness @ (field - rest))
    bend = np.maximum(-np.sum(pull * field, axis=1), 0.0)
    curvature = sp.kron(2.0 * smoothness + sp.diags(bend), sp.eye(3))
    lit = field @ problem.direction
    outside = ((lit < problem.lower) | (lit > problem.upper)) * 2.0 * problem.weight
    curvature = curvature + sp.kron(sp.diags(outside), np.outer(problem.direction, problem.direction))
    if isinstance(problem, ChangeEnergy):
        residual = _curl(problem.grid, field)
        curvature = curvature + 2.0 * problem.integrability_weight * (residual.T @ residual)
    return (frame.T @ curvature @ frame).tocsr()


def _curl(grid: MaskedGrid, field: Array) -> sp.csr_matrix:
    """Return the derivatives of the integrability residuals by the normals, shape (cells, 3 P)."""
    right, up = grid.neighbors[:, RIGHT], grid.neighbors[:, UP]
    across = np.where(right != OUTSIDE, grid.neighbors[right, UP], OUTSIDE)
    here = np.flatnonzero((right != OUTSIDE) & (up != OUTSIDE) & (across != OUTSIDE))
    cells = np.stack([here, right[here], up[here], across[here]], axis=1)
    corners = field[cells]
    mean = corners.mean(axis=1)
    sides = np.array([(-1, -1), (1, -1), (-1, 1), (1, 1)])
    by_x, by_y = (np.einsum("k,nkc->nc", side / 2.0, corners) for side in sides.T)
    rows, columns, values = [], [], []
    for corner, (x, y) in enumerate(sides):
        slopes = (
            y / 2 * mean[:, 2] - by_y[:, 2] / 4,
            by_x[:, 2] / 4 - x / 2 * mean[:, 2],
            (by_y[:, 0] - by_x[:, 1]) / 4 - y / 2 * mean[:, 0] + x / 2 * mean[:, 1],
        )
        for part, value in enumerate(slopes):
            rows.append(np.arange(len(cells)))
            columns.append(3 * cells[:, corner] + part)
            values.append(value)
    return sp.csr_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (len(cells), field.size)
    )


@njit(cache=True)
def _over_relaxed(  # type: ignore[no-untyped-def]
    neighbors, start, light, hold, target, lower, upper, weight, edge_weights, screening, change_weight, curl_weight, tau,
    field, relaxation, sweeps,
):  # fmt: skip
    old = np.empty(3)
    for _ in range(sweeps):
        for p in range(field.shape[0]):
            for c in range(3):
                old[c] = field[p, c]
            sweep_change(
                neighbors, start, light, hold, target, lower, upper, weight, edge_weights, screening,
                change_weight, curl_weight, tau, field, False, p, p + 1,
            )  # fmt: skip
            length = 0.0
            for c in range(3):
                field[p, c] = old[c] + relaxation * (field[p, c] - old[c])
                if c == 2:
                    field[p, c] = max(field[p, c], 0.0)
                length += field[p, c] ** 2
            for c in range(3):
                field[p, c] /= np.sqrt(length)
