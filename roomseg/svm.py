"""A C-SVM with Gaussian kernel (Eqs. 12-17) for tens of thousands of edges, and many of them.

The optimum is libsvm's, found in another way. Border edges are few and the classes
overlap, so most of an edge classifier's support vectors lie at their bound, which makes
libsvm slow; here they cost next to nothing (`roomseg.dual_newton`). The kernel is replaced by a
factor of low rank as far as that changes no decision value by more than a few
hundredths, which is checked with the exact kernel where it matters most: for rows next to a
decision or to a margin. Where the factor would need too many columns (γ or C is large), it
stands only for what changes since the solution before, and Newton steps with the exact
kernel follow (`roomseg.svm_polish`). Where even that start would be poor (γ and C are large), or
these steps do not meet libsvm's own stopping rule, libsvm is called.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from sklearn.svm import SVC

from roomseg.dual_newton import WIDTHS, DualPoint, kkt_violations, solve
from roomseg.kernel import kernel_factor, kernel_sum
from roomseg.svm_polish import ExactKernel
from roomseg.svm_spaces import FactorSpace

__all__ = ["SvmPath", "SvmSolution"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

LEAST_COLUMNS, MOST_COLUMNS = 64, 1000
"""Fewer save nothing; with more, the exact kernel is faster."""
MISSING = 3e-6
"""C times the mean of what a factor lacks of the kernel's diagonal (1)."""
ACCURACY = 0.02
"""Of a factor's decision values, checked for `CHECKED` rows."""
CHECKED = 256
FIRST_WIDTHS = (2.0, *WIDTHS)
START_MISSING, START_PASSES, START_VIOLATION = 3e-4, 3, 0.05
"""Of a factor's solutions that are only a start for the exact kernel; C times the mean of what
it lacks, beyond which libsvm is faster."""
CACHE_MB = 300
HOPELESS = 1.0
"""Violation of a start from which libsvm is as fast."""


@dataclass(frozen=True)
class SvmSolution:
    """A trained SVM.

    Attributes
    ----------
    alpha : array, shape (n,)
        Multipliers α of the training rows.
    bias : float
        b.
    decision : array, shape (t,)
        Decision values (Eq. 16, with b) of the other rows.
    violation : float
        Largest violation of an optimality condition of the training rows, in the kernel
        that was used; libsvm stops at 1e-3.
    gap : float
        Relative duality gap.
    exact : bool
        Whether the exact kernel was used, not a factor.
    steps : int
        Newton steps.
    """

    alpha: Floats
    bias: float
    decision: Floats
    violation: float
    gap: float
    exact: bool
    steps: int


class SvmPath:
    """SVMs of the same rows and γ, for one C and class weight after the other.

    A solution is the start of the next, so neighbours should come in turn, smaller C first.

    Parameters
    ----------
    rows : array, shape (n, f)
        Standardised training rows.
    is_border : array of bool, shape (n,)
        Both kinds must be there.
    others : array, shape (t, f)
        Rows to decide on.
    gamma : float
    largest_c : float
        The largest C that will be asked for; the factor is made for it.
    tolerance : float
        For `SvmSolution.violation`.
    """

    def __init__(
        self,
        rows: Floats,
        is_border: Flags,
        others: Floats,
        gamma: float,
        largest_c: float,
        *,
        tolerance: float = 1e-3,
    ) -> None:
        self._count, self._gamma, self._tolerance = len(rows), gamma, tolerance
        self._is_border, self._y = is_border, np.where(is_border, 1.0, -1.0)
        self._rows = np.concatenate([rows, others])
        self._factor = kernel_factor(
            self._rows, gamma, max(MISSING / largest_c, 1e-12), LEAST_COLUMNS, MOST_COLUMNS
        )
        self._low = FactorSpace(self._factor.matrix[: len(rows), :0], self._y)
        self._exact: ExactKernel | None = None
        self._exact_c = 1.0
        self._cost = np.full(len(rows), np.inf)
        self._point = DualPoint(np.zeros(len(rows)), 0.0, np.inf, np.inf, 0)

    def fit(self, C: float, class_weight: float) -> SvmSolution:
        """Solve for C, with class_weight times C for border edges."""
        cost = C * np.where(self._is_border, class_weight, 1.0)
        wanted = self._factor.columns_for(MISSING / C)
        wanted = max(wanted, min(LEAST_COLUMNS, len(self._factor.pivots)))
        enough = bool(self._factor.missing[wanted] <= MISSING / C)
        start, first = self._start(cost), not self._point.alpha.any()
        exact = not enough
        if enough:
            point, decision = self._nearly(start, cost, wanted, FIRST_WIDTHS if first else WIDTHS)
            exact = self._error(point, decision) > ACCURACY
        if exact:
            point, decision = self._exactly(start, cost, C, first)
        self._point, self._cost = point, cost
        return SvmSolution(
            point.alpha, point.bias, decision, point.violation, point.gap, exact, point.steps
        )

    def _nearly(
        self, start: DualPoint, cost: Floats, columns: int, widths: Sequence[float]
    ) -> tuple[DualPoint, Floats]:
        """Solve with so many of the factor's columns."""
        self._low.use(self._factor.matrix[: self._count, :columns])
        point = solve(self._low, self._y, cost, start, self._tolerance, widths)
        decision = self._factor.matrix[self._count :, :columns] @ self._low.w + point.bias
        return point, decision

    def _start(self, cost: Floats) -> DualPoint:
        """The solution before: what was at its bound is so again, the others stay."""
        before = self._point
        bounded = before.alpha >= self._cost
        alpha = np.where(bounded, cost, np.minimum(before.alpha, cost))
        return DualPoint(alpha, before.bias, np.inf, np.inf, 0)

    def _error(self, point: DualPoint, decision: Floats) -> float:
        """Largest error of a factor's f among the rows next to a decision or a margin."""
        margin = np.abs(1.0 - self._y * (self._low.values + point.bias))
        first = np.argsort(margin, kind="stable")[:CHECKED]
        second = np.argsort(np.abs(decision), kind="stable")[:CHECKED]
        chosen = np.concatenate([first, self._count + second])
        ours = np.concatenate([self._low.values[first], decision[second] - point.bias])
        exact, support = np.zeros(len(chosen)), np.flatnonzero(point.alpha)
        columns = np.ascontiguousarray(self._rows[chosen].T)
        coefficients = (self._y * point.alpha)[support]
        kernel_sum(columns, self._rows[support], coefficients, self._gamma, exact)
        return float(np.abs(exact - ours).max(initial=0.0))

    def _exactly(
        self, start: DualPoint, cost: Floats, C: float, first: bool
    ) -> tuple[DualPoint, Floats]:
        """Solve with the exact kernel.

        The factor stands for the changes of the start's multipliers only, whose f is known.
        """
        if self._exact is None:
            self._exact = ExactKernel(self._rows, self._y, self._gamma)
        self._exact.scale(C / self._exact_c)
        self._exact_c = C
        point, wrong = start, np.inf
        if C * self._factor.missing[-1] <= START_MISSING:
            point, wrong = self._start_exactly(start, cost, C, FIRST_WIDTHS if first else WIDTHS)
        if wrong <= HOPELESS:
            point = self._exact.improve(point, cost, self._tolerance)
            wrong = point.violation
        if wrong > self._tolerance:
            point = self._exact.improve(self._by_libsvm(cost), cost, np.inf)
        return point, self._exact.values[self._count :] + point.bias

    def _start_exactly(
        self, start: DualPoint, cost: Floats, C: float, widths: Sequence[float]
    ) -> tuple[DualPoint, float]:
        """What the factor finds, and how much the exact kernel says that it is wrong."""
        assert self._exact is not None
        columns = max(self._factor.columns_for(START_MISSING / C), LEAST_COLUMNS)
        matrix = self._factor.matrix[: self._count, :columns]
        f, point, wrong = self._exact.take(start.alpha)[: self._count], start, np.inf
        for _ in range(START_PASSES):
            self._low.use(matrix, f - matrix @ (matrix.T @ (self._y * point.alpha)))
            point, before = solve(self._low, self._y, cost, point, START_VIOLATION, widths), wrong
            f, widths = self._exact.take(point.alpha)[: self._count], WIDTHS
            margin = self._y * (f + point.bias)
            wrong = float(kkt_violations(point.alpha, cost, margin).max())
            if not START_VIOLATION < wrong < 0.5 * before:
                break
        return point, wrong

    def _by_libsvm(self, cost: Floats) -> DualPoint:
        """What always works, and takes longest."""
        svm = SVC(C=1.0, gamma=self._gamma, tol=self._tolerance, cache_size=CACHE_MB)
        svm.fit(self._rows[: self._count], self._is_border, sample_weight=cost)
        alpha = np.zeros(self._count)
        alpha[svm.support_] = np.abs(svm.dual_coef_[0])
        return DualPoint(alpha, float(svm.intercept_[0]), np.inf, np.inf, 0)
