"""The Gaussian kernel (Eq. 17): blocks, sums, and a factor of low rank.

A kernel matrix of tens of thousands of edges does not fit into memory. Over five
features it is almost of low rank, though: an incomplete Cholesky factorisation whose
pivots are the rows that are worst represented so far gives K ≈ F Fᵀ, and tells what is
missing (the diagonal of K - F Fᵀ, which is positive semidefinite). The first columns of
F are the factor of lower rank.

Sums over kernel columns are compiled: the exponential is a polynomial over
[-1/2, 1/2] and an exponent put together from bits, which a compiler turns into vector
instructions. Its relative error is below 1e-9.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray
from scipy import linalg

__all__ = ["KernelFactor", "kernel_block", "kernel_factor", "kernel_sum"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Function = TypeVar("Function", bound=Callable[..., object])

BLOCK = 256
"""Rows worked on at once: they stay in the fastest cache."""
ROUNDING = 1.5 * 2.0**52
"""Added to a number it leaves the nearest whole number in the lowest bits."""
LOG2_E = 1.4426950408889634
PIVOTS = 64
"""Columns that the factor grows by at once."""


def _compiled(function: Function) -> Function:
    """Compile with numba on first use; terms are not reordered, lest the rounding be lost."""
    options = {"cache": True, "fastmath": {"contract"}, "error_model": "numpy"}
    return cast(Function, numba.njit(**options)(function))


@_compiled
def _kernel_of_point(
    columns: Floats, begin: int, count: int, point: Floats, gamma: float, out: Floats, bits: Floats
) -> None:
    """Kernel of one point with rows begin .. begin + count; columns has shape (f, n)."""
    for i in range(count):
        out[i] = 0.0
    for k in range(columns.shape[0]):
        value = point[k]
        for i in range(count):
            difference = columns[k, begin + i] - value
            out[i] += difference * difference
    for i in range(count):
        power = max(-gamma * LOG2_E * out[i], -1020.0)
        rounded = power + ROUNDING
        bits[i] = rounded
        out[i] = power - (rounded - ROUNDING)
    exponents = bits.view(np.int64)
    for i in range(count):
        exponents[i] = (exponents[i] + 1023) << 52
    for i in range(count):
        x = out[i]
        p = 7.054911620801123e-09
        p = p * x + 1.0178086009239699e-07
        p = p * x + 1.3215486790144307e-06
        p = p * x + 1.5252733804059840e-05
        p = p * x + 1.5403530393381608e-04
        p = p * x + 1.3333558146428441e-03
        p = p * x + 9.6181291076284770e-03
        p = p * x + 5.5504108664821580e-02
        p = p * x + 2.4022650695910070e-01
        p = p * x + 6.9314718055994530e-01
        out[i] = (p * x + 1.0) * bits[i]


@_compiled
def kernel_sum(
    columns: Floats, points: Floats, coefficients: Floats, gamma: float, out: Floats
) -> None:
    """Add Σ_j coefficients_j K(row_i, points_j) to out_i.

    Parameters
    ----------
    columns : array, shape (f, n)
        The rows, transposed.
    points : array, shape (m, f)
    coefficients : array, shape (m,)
    gamma : float
    out : array, shape (n,)
        Is changed.
    """
    kernel, bits = np.empty(BLOCK), np.empty(BLOCK)
    for begin in range(0, columns.shape[1], BLOCK):
        count = min(BLOCK, columns.shape[1] - begin)
        for j in range(points.shape[0]):
            _kernel_of_point(columns, begin, count, points[j], gamma, kernel, bits)
            factor = coefficients[j]
            for i in range(count):
                out[begin + i] += factor * kernel[i]


@_compiled
def kernel_block(columns: Floats, points: Floats, gamma: float, out: Floats) -> None:
    """Put K of points (m, f) and rows (given as columns, (f, n)) into out, shape (m, n)."""
    kernel, bits = np.empty(BLOCK), np.empty(BLOCK)
    for begin in range(0, columns.shape[1], BLOCK):
        count = min(BLOCK, columns.shape[1] - begin)
        for j in range(points.shape[0]):
            _kernel_of_point(columns, begin, count, points[j], gamma, kernel, bits)
            for i in range(count):
                out[j, begin + i] = kernel[i]


@dataclass(frozen=True)
class KernelFactor:
    """Incomplete Cholesky factorisation, K ≈ F Fᵀ.

    Attributes
    ----------
    pivots : array, shape (r,)
        Rows that the factor represents exactly.
    matrix : array, shape (n, r)
        F.
    missing : array, shape (r + 1,)
        Mean of the diagonal of K - F Fᵀ with the first 0 .. r columns.
    """

    pivots: Integers
    matrix: Floats
    missing: Floats

    def columns_for(self, missing: float) -> int:
        """How many columns bring the mean of what is missing down to this; at most all."""
        enough = np.flatnonzero(self.missing <= missing)
        return int(enough[0]) if len(enough) else len(self.pivots)


def kernel_factor(
    rows: Floats, gamma: float, tolerance: float, least: int, most: int
) -> KernelFactor:
    """Factorise the kernel matrix of rows.

    Parameters
    ----------
    rows : array, shape (n, f)
    gamma : float
    tolerance : float
        Stop when the mean of the diagonal of K - F Fᵀ is below.
    least, most : int
        Bounds of the rank; it is below ``least`` only if that many columns represent K
        to rounding errors.
    """
    columns = np.ascontiguousarray(rows.T)
    most = min(most, len(rows))
    matrix, missing = np.empty((len(rows), most)), [1.0]
    left, rank, pivots = np.ones(len(rows)), 0, np.zeros(0, np.int64)
    while rank < most and (rank < least or left.mean() > tolerance):
        chosen, corner = _next_pivots(rows, matrix[:, :rank], left, gamma, most - rank)
        if not len(chosen):
            break
        block = np.empty((len(chosen), len(rows)))
        kernel_block(columns, rows[chosen], gamma, block)
        block -= matrix[chosen, :rank] @ matrix[:, :rank].T
        added = linalg.solve_triangular(corner, block, lower=True, overwrite_b=True)
        pivots, rank = np.append(pivots, chosen), rank + len(chosen)
        matrix[:, rank - len(chosen) : rank] = added.T
        squares = added**2
        missing.extend(np.maximum(left.mean() - np.cumsum(squares.mean(axis=1)), 0.0))
        left = np.maximum(left - squares.sum(axis=0), 0.0)
        left[pivots] = 0.0
    return KernelFactor(pivots, matrix[:, :rank], np.array(missing[: rank + 1]))


def _next_pivots(
    rows: Floats, matrix: Floats, left: Floats, gamma: float, most: int
) -> tuple[Integers, Floats]:
    """Rows that are badly represented and unlike each other, and their Cholesky factor."""
    wanted = min(PIVOTS, most)
    candidates = np.argsort(-left, kind="stable")[: 4 * wanted]
    corner = np.empty((len(candidates), len(candidates)))
    kernel_block(np.ascontiguousarray(rows[candidates].T), rows[candidates], gamma, corner)
    corner -= matrix[candidates] @ matrix[candidates].T
    factor, diagonal = np.zeros((len(candidates), wanted)), corner.diagonal().copy()
    least, chosen = max(0.05 * diagonal.max(), 1e-14), []
    for k in range(wanted):
        pivot = int(diagonal.argmax())
        if diagonal[pivot] <= least:
            break
        column = corner[:, pivot] - factor[:, :k] @ factor[pivot, :k]
        factor[:, k] = column / np.sqrt(diagonal[pivot])
        diagonal -= factor[:, k] ** 2
        diagonal[pivot] = -1.0
        chosen.append(pivot)
    at = np.array(chosen, np.int64)
    return candidates[at], factor[at, : len(at)]
