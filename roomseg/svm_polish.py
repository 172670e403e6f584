"""An SVM's solution improved with the exact kernel, some thousand rows at a time.

A decomposition as in SVM-light, with a large working set: the rows that violate the
optimality conditions most, those whose multiplier is free, and those next to a margin. Their
problem is solved by Newton steps, all other multipliers stay, and then f of all rows
is brought up to date. From a start that is nearly right, a few rounds suffice.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from roomseg.dual_newton import DualPoint, kkt_violations, relative_gap, solve
from roomseg.kernel import kernel_block, kernel_sum
from roomseg.svm_spaces import KernelSpace

__all__ = ["ExactKernel"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

WORKING_SET = 2000
ROUNDS = 25
WIDTHS = (0.1, 0.01, 0.001)


class ExactKernel:
    """f of all rows for multipliers of the first n, and how to improve them.

    Parameters
    ----------
    rows : array, shape (n + t, f)
        Training rows, then others.
    y : array, shape (n,)
        1 or -1.
    gamma : float
    """

    def __init__(self, rows: Floats, y: Floats, gamma: float) -> None:
        self._rows, self._y, self._gamma = np.ascontiguousarray(rows), y, gamma
        self._columns = np.ascontiguousarray(rows.T)
        self._alpha: Floats = np.zeros(len(y))
        self.values: Floats = np.zeros(len(rows))

    def scale(self, factor: float) -> None:
        """Multiply all multipliers."""
        self.values *= factor
        self._alpha = self._alpha * factor

    def take(self, alpha: Floats) -> Floats:
        """Make f = Σ α y K of all rows; cheap if few α differ from those before."""
        changed = np.flatnonzero(np.abs(alpha - self._alpha) > 1e-12 * alpha)
        self._change(changed, alpha[changed])
        return self.values

    def improve(self, start: DualPoint, cost: Floats, tolerance: float) -> DualPoint:
        """Solve from a start.

        Parameters
        ----------
        start : DualPoint
        cost : array, shape (n,)
        tolerance : float
            For `DualPoint.violation`.

        Returns
        -------
        DualPoint
            ``values`` is then its f, without b, of all rows.
        """
        f = self.take(start.alpha)[: len(self._y)]
        bias, steps = start.bias, start.steps
        for _ in range(ROUNDS):
            wrong = kkt_violations(self._alpha, cost, self._y * (f + bias))
            if wrong.max(initial=0.0) <= tolerance:
                break
            part = self._solve_part(self._working_set(wrong, cost, bias), cost, bias, tolerance)
            bias, steps = part.bias, steps + part.steps
        wrong = kkt_violations(self._alpha, cost, self._y * (f + bias))
        gap = relative_gap(f, self._y, cost, self._alpha, bias)
        return DualPoint(self._alpha, bias, float(wrong.max(initial=0.0)), gap, steps)

    def _change(self, at: Integers, alpha: Floats) -> None:
        """Take these multipliers."""
        difference = self._y[at] * (alpha - self._alpha[at])
        kernel_sum(self._columns, self._rows[at], difference, self._gamma, self.values)
        self._alpha = self._alpha.copy()
        self._alpha[at] = alpha

    def _working_set(self, wrong: Floats, cost: Floats, bias: float) -> Integers:
        """The rows that matter most."""
        distance = np.abs(1.0 - self._y * (self.values[: len(self._y)] + bias))
        free = (self._alpha > 0.0) & (self._alpha < cost)
        order = np.argsort(np.where(free, -wrong - 1.0, np.where(wrong > 0.0, -wrong, distance)))
        return np.sort(order[:WORKING_SET])

    def _solve_part(
        self, chosen: Integers, cost: Floats, bias: float, tolerance: float
    ) -> DualPoint:
        """Solve for these rows' multipliers, and take them."""
        rows, y, alpha = self._rows[chosen], self._y[chosen], self._alpha[chosen]
        kernel = np.empty((len(chosen), len(chosen)))
        kernel_block(np.ascontiguousarray(rows.T), rows, self._gamma, kernel)
        balance = float(self._y @ self._alpha) - float(y @ alpha)
        space = KernelSpace(kernel, y, alpha, self.values[chosen], balance)
        start = DualPoint(alpha, bias, np.inf, np.inf, 0)
        part = solve(space, y, cost[chosen], start, 0.5 * tolerance, WIDTHS, np.inf)
        changed = part.alpha != alpha
        self._change(chosen[changed], part.alpha[changed])
        return part
