"""A C-SVM with Gaussian kernel (Eqs. 12-17) for tens of thousands of edges.

The optimum is libsvm's, found in another way. Border edges are few and the classes
overlap, so most of an edge classifier's support vectors lie at their bound, which makes
libsvm slow; here they cost next to nothing (`roomseg.dual_newton`). The kernel is
replaced by a factor of low rank as far as that changes no decision value by more
than a few hundredths, which is checked with the exact kernel where it matters most:
for rows next to a decision or to a margin. Where the factor would need too many
columns (γ or C is large), its solution is only the start for Newton steps with the exact
kernel. Either way every solution comes with the violation of the optimality conditions.

`SvmPath` solves for many C and class weights, each from the solution before;
`BorderSVC` is one solution as a scikit-learn classifier.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils.validation import check_is_fitted, validate_data

from roomseg.dual_newton import WIDTHS, DualPoint, kkt_violations, solve
from roomseg.kernel import KernelFactor, kernel_factor, kernel_sum
from roomseg.svm_polish import ExactKernel
from roomseg.svm_spaces import FactorSpace

__all__ = ["BorderSVC", "SvmPath", "SvmSolution"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

LEAST_COLUMNS, MOST_COLUMNS = 64, 800
"""Fewer save nothing; with more, the exact kernel is faster."""
MISSING = 3e-6
"""C times the mean of what a factor lacks of the kernel's diagonal (1)."""
ACCURACY = 0.02
"""Of a factor's decision values, checked for `CHECKED` rows."""
CHECKED = 256
FIRST_WIDTHS = (2.0, *WIDTHS)
START_PASSES, START_VIOLATION = 3, 0.05
"""Of a factor's solutions that are only a start for the exact kernel."""


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
        tolerance: float = 1e-3,
    ) -> None:
        self._count, self._gamma, self._tolerance = len(rows), gamma, tolerance
        self._is_border, self._y = is_border, np.where(is_border, 1.0, -1.0)
        self._rows = np.concatenate([rows, others])
        self.factor: KernelFactor = kernel_factor(
            self._rows, gamma, max(MISSING / largest_c, 1e-12), LEAST_COLUMNS, MOST_COLUMNS
        )
        self.columns = 0
        self._low = FactorSpace(self.factor.matrix[: len(rows), :0], self._y)
        self._exact: ExactKernel | None = None
        self._exact_c = 1.0
        self._cost = np.full(len(rows), np.inf)
        self._point = DualPoint(np.zeros(len(rows)), 0.0, np.inf, np.inf, 0)

    @property
    def weights(self) -> Floats:
        """w of a solution that is not exact: f = F w + b, shape (columns,)."""
        return self._low.w

    def fit(self, C: float, class_weight: float) -> SvmSolution:
        """Solve for C, with class_weight times C for border edges."""
        cost = C * np.where(self._is_border, class_weight, 1.0)
        wanted = self.factor.columns_for(MISSING / C)
        wanted = max(wanted, min(LEAST_COLUMNS, len(self.factor.pivots)))
        enough = bool(self.factor.missing[wanted] <= MISSING / C)
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
        self.columns = columns
        self._low.use(self.factor.matrix[: self._count, :columns])
        point = solve(self._low, self._y, cost, start, self._tolerance, widths)
        decision = self.factor.matrix[self._count :, :columns] @ self._low.w + point.bias
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
        matrix = self.factor.matrix[: self._count]
        point, before = start, np.inf
        for turn in range(START_PASSES):
            f = self._exact.take(point.alpha)[: self._count]
            if turn:
                wrong = kkt_violations(point.alpha, cost, self._y * (f + point.bias)).max()
                if not START_VIOLATION < wrong < 0.5 * before:
                    break
                before = float(wrong)
            self._low.use(matrix, f - matrix @ (matrix.T @ (self._y * point.alpha)))
            widths = FIRST_WIDTHS if first and not turn else WIDTHS
            point = solve(self._low, self._y, cost, point, START_VIOLATION, widths)
        point = self._exact.improve(point, cost, self._tolerance)
        return point, self._exact.values[self._count :] + point.bias


class BorderSVC(ClassifierMixin, BaseEstimator):  # type: ignore[misc]
    """C-SVM with Gaussian kernel; what scikit-learn's ``SVC`` finds, faster.

    Parameters
    ----------
    C, gamma : float
    class_weight : float
        C is multiplied by it for the second class (border edges, §2.3.2).
    tol : float
        How far an optimality condition may be violated.

    Attributes
    ----------
    classes_ : array, shape (2,)
    points_ : array, shape (m, f)
    coefficients_ : array, shape (m,)
    intercept_ : float
        The decision value is Σ coefficients_j K(points_j, x) + intercept. The points are
        support vectors, or fewer that span nearly the same.
    violation_, gap_ : float
        How good the solution is, see `SvmSolution`.
    """

    def __init__(
        self, C: float = 1.0, gamma: float = 1.0, class_weight: float = 1.0, tol: float = 1e-3
    ) -> None:
        self.C, self.gamma, self.class_weight, self.tol = C, gamma, class_weight, tol

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Train.

        Parameters
        ----------
        X : array, shape (n, f)
            Standardised features.
        y : array, shape (n,)
            Two classes.

        Raises
        ------
        ValueError
            If there are not two classes, or a parameter is not positive.
        """
        rows, labels = validate_data(self, X, y, dtype=np.float64)
        for name, value in self.get_params().items():
            if not (np.isfinite(value) and value > 0):
                raise ValueError(f"{name}: {value}, expected > 0")
        self.classes_, index = np.unique(labels, return_inverse=True)
        if len(self.classes_) != 2:
            raise ValueError(f"y: {len(self.classes_)} classes, expected 2")
        path = SvmPath(rows, index == 1, rows[:0], self.gamma, self.C, self.tol)
        for C in (self.C / 256.0, self.C / 16.0):  # cheap, and good starts
            path.fit(C, self.class_weight)
        solution = path.fit(self.C, self.class_weight)
        self.points_, self.coefficients_ = _expansion(path, solution, rows, index)
        self.intercept_ = solution.bias
        self.violation_, self.gap_ = solution.violation, solution.gap
        return self

    def decision_function(self, X: ArrayLike) -> Floats:
        """Decision value of each row (Eq. 15 before sgn), shape (t,)."""
        check_is_fitted(self)
        rows = validate_data(self, X, dtype=np.float64, reset=False)
        values = np.full(len(rows), float(self.intercept_))
        columns = np.ascontiguousarray(rows.T)
        kernel_sum(columns, self.points_, self.coefficients_, float(self.gamma), values)
        return values

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """Class of each row, shape (t,)."""
        above = self.decision_function(X) > 0.0
        return np.asarray(self.classes_[above.astype(np.int64)])


def _expansion(
    path: SvmPath, solution: SvmSolution, rows: Floats, index: NDArray[np.int64]
) -> tuple[Floats, Floats]:
    """Points and coefficients whose kernels add up to the solution."""
    if solution.exact:
        support = np.flatnonzero(solution.alpha)
        return rows[support], (np.where(index == 1, 1.0, -1.0) * solution.alpha)[support]
    pivots = path.factor.pivots[: path.columns]
    corner = path.factor.matrix[pivots, : path.columns]
    coefficients = linalg.solve_triangular(corner, path.weights, lower=True, trans="T")
    return rows[pivots], coefficients
