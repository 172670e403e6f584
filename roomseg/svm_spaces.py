"""Where the functions of an SVM live: in the span of a factor's columns, or of all kernels.

Both are a `roomseg.dual_newton.Space`. In the first, a function is a vector w of as many
numbers as the factor has columns, and f = F w. In the second it is a coefficient β of
each row's kernel, f = K (y β), exact for any γ; only what changes is ever computed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from roomseg.dual_newton import RIDGE, Direction, newton_target
from roomseg.kernel import kernel_block, kernel_sum

__all__ = ["FactorSpace", "KernelSpace"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class FactorSpace:
    """f = F w for the columns F of a kernel factor.

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
        self.values: Floats = np.zeros(len(y))

    def use(self, matrix: Floats) -> None:
        """Go on with more or fewer of the factor's columns."""
        if matrix.shape[1] != len(self.w):
            same = min(len(self.w), matrix.shape[1])
            w = np.zeros(matrix.shape[1])
            w[:same] = self.w[:same]
            self.matrix, self.w = matrix, w
            self.release()

    def restrict(self, active: Integers, p: Floats) -> Floats:
        """See `Space`."""
        every = len(active) == len(self.y)
        self._local = self.matrix if every else self.matrix[active]
        self._y, settled = self.y[active], self.y * p
        settled[active] = 0.0
        self._fixed = np.zeros_like(self.w) if every else self.matrix.T @ settled
        self._balance = float(settled.sum())
        return self.values[active]

    def direction(self, p: Floats, band: Integers, pull: Floats, pushed: Floats) -> Direction:
        """See `Space`."""
        rest = self._y * p
        rest[band] = 0.0
        others = self._fixed + self._local.T @ rest
        balance = self._balance + float(rest.sum())
        matrix, y = self._local[band], self._y[band]
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
        self.values = self.matrix @ self.w

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
    """f = K (y β), exactly; f of further rows is kept up to date, too.

    Parameters
    ----------
    rows : array, shape (n + t, f)
        Training rows, then others.
    y : array, shape (n,)
        1 or -1.
    gamma : float
    """

    def __init__(self, rows: Floats, y: Floats, gamma: float) -> None:
        self.rows, self.y, self.gamma = np.ascontiguousarray(rows), y, gamma
        self.columns = np.ascontiguousarray(rows.T)
        self.beta: Floats = np.zeros(len(y))
        self.all_values: Floats = np.zeros(len(rows))

    @property
    def values(self) -> Floats:
        """f of the training rows, shape (n,)."""
        return self.all_values[: len(self.y)]

    def begin(self, alpha: Floats, factor: float) -> None:
        """Make f = Σ α y K, cheaply if α is mostly ``factor`` times what it was."""
        self.all_values *= factor
        self.beta = self.beta * factor
        close = np.abs(alpha - self.beta) <= 1e-12 * alpha
        self._change(np.where(close, self.beta, alpha))

    def _change(self, beta: Floats) -> None:
        """Take these coefficients."""
        changed = np.flatnonzero(beta != self.beta)
        difference = (self.y * (beta - self.beta))[changed]
        kernel_sum(self.columns, self.rows[changed], difference, self.gamma, self.all_values)
        self.beta = beta.copy()

    def restrict(self, active: Integers, p: Floats) -> Floats:
        """See `Space`."""
        settled = p.copy()
        settled[active] = self.beta[active]
        self._change(settled)
        settled[active] = 0.0
        self._balance = float(self.y @ settled)
        self._active, self._y = active, self.y[active]
        self._rows = self.rows[active]
        self._columns = np.ascontiguousarray(self._rows.T)
        self._beta, self._f = self.beta[active], self.values[active]
        self._place, self._kernel = np.full(len(active), -1), np.empty((0, len(active)))
        return self._f

    def direction(self, p: Floats, band: Integers, pull: Floats, pushed: Floats) -> Direction:
        """See `Space`."""
        step = p - self._beta
        step[band] = 0.0
        turned = np.flatnonzero(step)
        block, values = self._block(band), self._effect(turned, (self._y * step)[turned])
        corner, y, beta = block[:, band], self._y[band], self._beta[band]
        others = (self._f + values)[band] - corner @ (y * beta)
        balance = self._balance + float(self._y @ (self._beta + step)) - float(y @ beta)
        target, bias = newton_target(corner, y, pull, pushed - y * others, balance)
        step[band] = target - beta
        values += (y * step[band]) @ block
        slope = float((self._beta * self._y) @ values) - self._balance * bias
        square = float((step * self._y) @ values)
        return Direction(values, bias, slope, square, self._beta + step, step)

    def _effect(self, turned: Integers, coefficients: Floats) -> Floats:
        """What these active rows' coefficients add to f of the active rows."""
        if (self._place[turned] >= 0).all():
            return coefficients @ self._kernel[self._place[turned]]
        values = np.zeros(len(self._f))
        kernel_sum(self._columns, self._rows[turned], coefficients, self.gamma, values)
        return values

    def _block(self, band: Integers) -> Floats:
        """Kernel of active rows with all active rows; what was computed for one step is kept."""
        new = band[self._place[band] < 0]
        if len(new):
            added = kernel_block(self._columns, self._rows[new], self.gamma)
            self._place[new] = len(self._kernel) + np.arange(len(new))
            self._kernel = np.concatenate([self._kernel, added])
        return self._kernel[self._place[band]]

    def move(self, direction: Direction, t: float) -> None:
        """See `Space`."""
        self._beta = self._beta + t * direction.coefficients
        self._f = self._f + t * direction.values

    def release(self) -> None:
        """See `Space`."""
        beta = self.beta.copy()
        beta[self._active] = self._beta
        self._change(beta)

    def assign(self, alpha: Floats) -> None:
        """See `Space`."""
        self._change(alpha)
