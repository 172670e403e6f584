"""Where the functions of an SVM live: in the span of a factor's columns, or of some kernels.

Both are a `roomseg.dual_newton.Space`. In the first, a function is a vector w of as many
numbers as the factor has columns, and f = F w. In the second it is a coefficient β of each
row's kernel, f = offset + K (y β), exact for any γ but of a few thousand rows only.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from roomseg.dual_newton import RIDGE, Direction, newton_target

__all__ = ["FactorSpace", "KernelSpace"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class FactorSpace:
    """f = F w + offset for the columns F of a kernel factor.

    Parameters
    ----------
    matrix : array, shape (n, r)
        F of the training rows.
    y : array, shape (n,)
        1 or -1.
    """

    def __init__(self, matrix: Floats, y: Floats) -> None:
        self.matrix, self.y = matrix, y
        self.w: Floats = np.zeros(matrix.shape[1])
        self.offset: Floats = np.zeros(len(y))
        self.values: Floats = np.zeros(len(y))

    def use(self, matrix: Floats, offset: Floats | float = 0.0) -> None:
        """Go on from the same w with more or fewer of the factor's columns, and an offset."""
        same = min(len(self.w), matrix.shape[1])
        w = np.zeros(matrix.shape[1])
        w[:same] = self.w[:same]
        self.matrix, self.w = matrix, w
        self.offset = np.zeros(len(self.y)) + offset
        self.release()

    def restrict(self, active: Integers, p: Floats) -> Floats:
        """See `Space`."""
        every = len(active) == len(self.y)
        self._local = self.matrix if every else self.matrix[active]
        self._y, settled = self.y[active], self.y * p
        settled[active] = 0.0
        self._fixed = np.zeros_like(self.w) if every else self.matrix.T @ settled
        self._balance = float(settled.sum())
        self._offset = self.offset[active]
        return self.values[active]

    def direction(self, p: Floats, band: Integers, pull: Floats, pushed: Floats) -> Direction:
        """See `Space`."""
        rest: Floats = np.asarray(self._y * p, dtype=np.float64)
        rest[band] = 0.0
        others: Floats = np.add(self._fixed, self._local.T @ rest)
        balance = self._balance + float(rest.sum())
        matrix, y = self._local[band], self._y[band]
        pushed = np.asarray(pushed - y * self._offset[band], dtype=np.float64)
        if len(band) < len(self.w):
            pushed = pushed - y * (matrix @ others)
            beta, bias = newton_target(matrix @ matrix.T, y, pull, pushed, balance)
            target = others + matrix.T @ (y * beta)
        else:
            target, bias = _target(matrix, y, pull, pushed, others, balance)
            beta = pull * (pushed - y * (matrix @ target + bias))
        multipliers = p.copy()
        multipliers[band] = beta
        step = target - self.w
        slope = float((self.w - self._fixed) @ step) - self._balance * bias
        square = float(step @ step)
        return Direction(self._local @ step, bias, slope, square, multipliers, step)

    def move(self, direction: Direction, t: float) -> None:
        """See `Space`."""
        self.w = self.w + t * direction.coefficients

    def release(self) -> None:
        """See `Space`."""
        self.values = self.matrix @ self.w + self.offset

    def assign(self, alpha: Floats) -> None:
        """See `Space`."""
        self.w = self.matrix.T @ (self.y * alpha)
        self.release()


def _target(
    matrix: Floats, y: Floats, pull: Floats, pushed: Floats, others: Floats, balance: float
) -> tuple[Floats, float]:
    """`newton_target` as a system of as many rows as the factor has columns: w, and b's change."""
    weighted = matrix * pull[:, None]
    size = matrix.shape[1]
    system, side = np.empty((size + 1, size + 1)), np.empty(size + 1)
    system[:size, :size] = matrix.T @ weighted
    system[:size, size] = system[size, :size] = weighted.sum(axis=0)
    system[size, size] = pull.sum() + RIDGE
    system[np.diag_indices(size)] += 1.0
    side[:size] = others + weighted.T @ (y * pushed)
    side[size] = balance + (pull * y) @ pushed
    solution = linalg.solve(system, side, assume_a="pos", overwrite_a=True, check_finite=False)
    return solution[:size], float(solution[size])


class KernelSpace:
    """f = offset + K (y β) of a few thousand rows, exactly; what others add stays.

    Parameters
    ----------
    kernel : array, shape (a, a)
        K of these rows.
    y, beta, values : arrays, shape (a,)
        1 or -1; multipliers; f of all rows' multipliers.
    balance : float
        Σ y α of all other rows.
    """

    def __init__(
        self, kernel: Floats, y: Floats, beta: Floats, values: Floats, balance: float
    ) -> None:
        self._kernel, self._y, self._balance = kernel, y, balance
        self._offset = values - kernel @ (y * beta)
        self._beta, self.values = beta, values

    def restrict(self, active: Integers, p: Floats) -> Floats:
        """See `Space`; all rows move."""
        return self.values

    def direction(self, p: Floats, band: Integers, pull: Floats, pushed: Floats) -> Direction:
        """See `Space`."""
        step = p - self._beta
        step[band] = 0.0
        values, y, beta = self._kernel @ (self._y * step), self._y[band], self._beta[band]
        corner = self._kernel[np.ix_(band, band)]
        others = (self.values + values)[band] - corner @ (y * beta)
        balance = self._balance + float(self._y @ (self._beta + step)) - float(y @ beta)
        target, bias = newton_target(corner, y, pull, pushed - y * others, balance)
        step[band] = target - beta
        values = self._kernel @ (self._y * step)
        slope = float((self._beta * self._y) @ values) - self._balance * bias
        square = float((step * self._y) @ values)
        return Direction(values, bias, slope, square, self._beta + step, step)

    def move(self, direction: Direction, t: float) -> None:
        """See `Space`."""
        self._beta = self._beta + t * direction.coefficients
        self.values = self.values + t * direction.values

    def release(self) -> None:
        """See `Space`; nothing was left out."""

    def assign(self, alpha: Floats) -> None:
        """See `Space`."""
        self._beta = alpha
        self.values = self._offset + self._kernel @ (self._y * alpha)
