"""Columns of the Gaussian kernel (Eq. 17), and sums over them.

A kernel matrix of tens of thousands of edges does not fit into memory, so its columns are
made when they are needed, compiled: the exponential is a polynomial over
[-1/2, 1/2] and an exponent put together from bits, which a compiler turns into vector
instructions. Its relative error is below 1e-9.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray

__all__ = ["kernel_column", "kernel_sum"]

Floats = NDArray[np.float64]
Function = TypeVar("Function", bound=Callable[..., object])

BLOCK = 256
"""Rows worked on at once: they stay in the fastest cache."""
ROUNDING = 1.5 * 2.0**52
"""Added to a number it leaves the nearest whole number in the lowest bits."""
LOG2_E = 1.4426950408889634


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
def kernel_column(columns: Floats, row: int, gamma: float, out: NDArray[np.float32]) -> None:
    """Put K of one of the rows, given as columns (f, n), with all of them into out, shape (n,)."""
    kernel, bits, point = np.empty(BLOCK), np.empty(BLOCK), columns[:, row].copy()
    for begin in range(0, columns.shape[1], BLOCK):
        count = min(BLOCK, columns.shape[1] - begin)
        _kernel_of_point(columns, begin, count, point, gamma, kernel, bits)
        for i in range(count):
            out[begin + i] = kernel[i]
