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

from toonkit.numerics.masked_grid import OUTSIDE, RIGHT, UP, MaskedGrid
from toonkit.numerics.membrane import Membrane
from toonkit.numerics.unit_field_kernels import relax, slope
from toonkit.numerics.unit_field_problem import UnitFieldProblem
from toonkit.numerics.unit_vectors import moved

RELAXATION = 1.5
"""The paper's over-relaxation."""

LOOKED_AT_EVERY = 25
"""Sweeps between two looks at the energy and the clock."""

NEWTON_STEPS = 30

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


def laplacian(grid: MaskedGrid, links: Array, ties: Array) -> sp.csr_matrix:
    """Assemble a membrane's matrix."""
    matrix = sp.diags(ties + links.sum(axis=1)).tocsr()
    for k in range(4):
        here = np.flatnonzero(grid.neighbors[:, k] != OUTSIDE)
        there = grid.neighbors[here, k]
        matrix = matrix - sp.csr_matrix((links[here, k], (here, there)), matrix.shape)
    return matrix.tocsr()


def membrane_solved(membrane: Membrane, right_side: NDArray[np.complex128], solve: LinearSolver) -> Array:
    """Solve a membrane system with two right sides, assembling included."""
    matrix = laplacian(membrane.grid, membrane.links, membrane.ties)
    return solve(matrix, np.stack([right_side.real, right_side.imag], axis=1))


def membrane_swept(
    membrane: Membrane, right_side: NDArray[np.complex128], tolerance: float, limit: float
) -> float:
    """Sweep from zero until the residual is as small as asked for; return the seconds, `limit` at most."""
    field = np.zeros_like(right_side)
    goal = tolerance * np.linalg.norm(right_side)
    begin = time.perf_counter()
    while time.perf_counter() - begin < limit:
        for _ in range(LOOKED_AT_EVERY):
            membrane.relax(right_side, field, backward=False)
        if np.linalg.norm(right_side - membrane.apply(field)) <= goal:
            break
    return time.perf_counter() - begin


def energy(problem: UnitFieldProblem, field: Array, gradient: Array | None = None) -> float:
    """Energy of a field, by the same compiled loop for everyone."""
    out = np.empty_like(field) if gradient is None else gradient
    return float(slope(*_arguments(problem), field, out, 0, problem.grid.size))


def swept(problem: UnitFieldProblem, goal: float, limit: float) -> tuple[float, float]:
    """Sweep over-relaxed from n0 until the energy is down to `goal`; return seconds, at `limit` at most, and energy."""
    field = problem.start.copy()
    arguments = _arguments(problem)
    _over_relaxed(*arguments, field.copy(), RELAXATION, 1)  # compiled
    spent, reached = 0.0, np.inf
    while spent < limit and reached > goal:
        begin = time.perf_counter()
        _over_relaxed(*arguments, field, RELAXATION, LOOKED_AT_EVERY)
        spent += time.perf_counter() - begin
        reached = energy(problem, field)
    return spent, reached


def newton(problem: UnitFieldProblem, goal: float, limit: float, solve: LinearSolver) -> tuple[float, float]:
    """Solve by Newton's method on the tangent planes, each step with an assembled matrix, until the energy meets `goal`."""
    begin = time.perf_counter()
    field = problem.start.copy()
    gradient = np.empty_like(field)
    reached = energy(problem, field, gradient)
    stiffness = laplacian(problem.grid, problem.links, problem.ties)
    damping = 1e-3
    for _ in range(NEWTON_STEPS):
        if reached <= goal or time.perf_counter() - begin > limit:
            break
        frame = _tangents(field)
        matrix = _curvature(problem, field, stiffness, frame)
        matrix = matrix + damping * sp.diags(matrix.diagonal())
        slopes = -(frame.T @ gradient.ravel())
        step = (frame @ solve(matrix.tocsr(), slopes[:, None])[:, 0]).reshape(field.shape)
        slopes_after = np.empty_like(gradient)
        for length in (1.0, 0.5, 0.25, 0.1, 0.03):
            trial = moved(problem.grid, field, length * step)
            after = energy(problem, trial, slopes_after)
            if after < reached:
                break
        if after >= reached:
            damping *= 10
            continue
        field, gradient, reached, damping = trial, slopes_after, after, max(damping / 4, 1e-8)
    return time.perf_counter() - begin, reached


def _arguments(problem: UnitFieldProblem) -> tuple:
    nothing = np.zeros(0)
    return (
        problem.grid.neighbors, problem.start, problem.direction, nothing, nothing, problem.lower, problem.upper,
        problem.weight, problem.links, problem.ties, problem.change_weight, problem.integrability_weight,
        np.zeros((0, 3)),
    )  # fmt: skip


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


def _curvature(
    problem: UnitFieldProblem, field: Array, stiffness: sp.csr_matrix, frame: sp.csr_matrix
) -> sp.csr_matrix:
    """Second derivatives of the energy's convex part on the tangent planes, shape (2 P, 2 P)."""
    pull = 2.0 * problem.change_weight * (stiffness @ (field - problem.start))
    bend = np.maximum(-np.sum(pull * field, axis=1), 0.0)
    membrane = sp.kron(2.0 * problem.change_weight * stiffness + sp.diags(bend), sp.eye(3))
    lit = field @ problem.direction
    outside = ((lit < problem.lower) | (lit > problem.upper)) * 2.0 * problem.weight
    shading = sp.kron(sp.diags(outside), np.outer(problem.direction, problem.direction))
    residual = _curl(problem.grid, field)
    curl = 2.0 * problem.integrability_weight * (residual.T @ residual)
    return (frame.T @ (membrane + shading + curl) @ frame).tocsr()


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
    neighbors, start, light, hold, target, lower, upper, weight, links, ties, change_weight, curl_weight, source,
    field, relaxation, sweeps,
):  # fmt: skip
    old = np.empty(3)
    for _ in range(sweeps):
        for p in range(field.shape[0]):
            for c in range(3):
                old[c] = field[p, c]
            relax(
                neighbors, start, light, hold, target, lower, upper, weight, links, ties, change_weight, curl_weight,
                source, field, False, p, p + 1,
            )  # fmt: skip
            length = 0.0
            for c in range(3):
                field[p, c] = old[c] + relaxation * (field[p, c] - old[c])
                if c == 2:
                    field[p, c] = max(field[p, c], 0.0)
                length += field[p, c] ** 2
            for c in range(3):
                field[p, c] /= np.sqrt(length)
