"""Sequential minimal optimisation of a C-SVM's dual (Eqs. 12-14), compiled.

Written for signed multipliers β = y α with low ≤ β ≤ high and Σ β = 0, where f = K β and the error
is y - f. A pair moves: β of the row with the largest error among those that may rise goes up, β
of another that may fall goes down as much; it is the one with which the dual gains most (Fan,
Chen and Lin, 2005, as in libsvm). The optimality gap is the largest error of a row that may
rise less the smallest of one that may fall; libsvm stops at 1e-3, too.

The loops over rows have no branches, so that the compiler can work on several at a time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray

from roomseg.kernel import kernel_column

__all__ = ["minimise"]

Floats = NDArray[np.float64]
Function = TypeVar("Function", bound=Callable[..., object])

NEVER = 1e300
"""Added to the error of a row that may not move."""
LEAST_CURVATURE = 1e-12


def _compiled(function: Function) -> Function:
    """Compile with numba on first use; sums and maxima may be taken in any order."""
    options = {"cache": True, "fastmath": {"contract", "nnan", "nsz", "reassoc"}}
    return cast(Function, numba.njit(**options, error_model="numpy")(function))


@_compiled
def _largest_error(
    error: Floats, first: Floats, second: Floats, moved: float, stuck_high: Floats
) -> float:
    """Take the last pair's move into account; the largest error of a row that may rise."""
    best = -NEVER
    for t in range(error.shape[0]):
        value = error[t] - moved * (first[t] - second[t])
        error[t] = value
        best = max(best, value - stuck_high[t])
    return best


@_compiled
def _pair_gains(
    error: Floats, first: Floats, best: float, stuck_low: Floats, gains: Floats
) -> tuple[float, float]:
    """What the dual gains with each partner: the largest, and the smallest error of one."""
    top, least = 0.0, NEVER
    for t in range(error.shape[0]):
        value = error[t] + stuck_low[t]
        least = min(least, value)
        difference = max(best - value, 0.0)
        gain = difference * difference / max(2.0 - 2.0 * first[t], LEAST_CURVATURE)
        gains[t] = gain
        top = max(top, gain)
    return top, least


@_compiled
def minimise(
    columns: Floats,
    low: Floats,
    high: Floats,
    beta: Floats,
    error: Floats,
    gamma: float,
    tolerance: float,
    most_steps: int,
) -> int:
    """Move pairs until the optimality gap of these rows is below the tolerance.

    Parameters
    ----------
    columns : array, shape (f, n)
        The rows, transposed; a few thousand, as their kernel matrix is kept.
    low, high : arrays, shape (n,)
    beta, error : arrays, shape (n,)
        Are changed.
    gamma, tolerance : float
    most_steps : int

    Returns
    -------
    int
        Pairs moved.
    """
    n = columns.shape[1]
    kernel, known = np.empty((n, n), np.float32), np.zeros(n, np.bool_)
    stuck_high = np.where(beta < high, 0.0, NEVER)
    stuck_low = np.where(beta > low, 0.0, NEVER)
    gains, moved, i, j = np.empty(n), 0.0, 0, 0
    kernel_column(columns, 0, gamma, kernel[0])
    known[0] = True
    for step in range(most_steps):
        best = _largest_error(error, kernel[i], kernel[j], moved, stuck_high)
        i = 0
        while error[i] - stuck_high[i] != best:
            i += 1
        if not known[i]:
            kernel_column(columns, i, gamma, kernel[i])
            known[i] = True
        top, least = _pair_gains(error, kernel[i], best, stuck_low, gains)
        if best - least < tolerance or top <= 0.0:
            return step
        j = 0
        while gains[j] != top:
            j += 1
        if not known[j]:
            kernel_column(columns, j, gamma, kernel[j])
            known[j] = True
        curvature = max(2.0 - 2.0 * kernel[i, j], LEAST_CURVATURE)
        up, down = high[i] - beta[i], beta[j] - low[j]
        moved = min((best - error[j]) / curvature, up, down)
        beta[i] = high[i] if moved == up else beta[i] + moved
        beta[j] = low[j] if moved == down else beta[j] - moved
        for t in (i, j):
            stuck_high[t] = 0.0 if beta[t] < high[t] else NEVER
            stuck_low[t] = 0.0 if beta[t] > low[t] else NEVER
    _largest_error(error, kernel[i], kernel[j], moved, stuck_high)
    return most_steps
