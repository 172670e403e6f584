"""A C-SVM with Gaussian kernel (Eqs. 12-17) for tens of thousands of edges, and many of them.

The optimum is libsvm's, to libsvm's own tolerance, found with less work:

- The solution for C, scaled by C'/C, is the start for C': its multipliers are within their
  bounds and balanced, and what it gives for every row is known. Most of an edge classifier's
  thousands of support vectors lie at their bound, and stay there.
- A few thousand rows are solved at a time (`roomseg.smo`): those that violate the optimality
  conditions, are free, or are likely to be next. Then all other rows learn of the change.
- Kernel columns are compiled (`roomseg.kernel`): 0.16 ms for 60,000 edges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roomseg.kernel import kernel_sum
from roomseg.smo import minimise

__all__ = ["SvmPath", "SvmSolution"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

LEAST_ROWS, MOST_ROWS = 300, 2000
"""Of those that may rise and of those that may fall, besides the free ones, solved at a time;
the kernel matrix of 4000 has 64 MB."""
REACH = 2.0
"""Rows that are safe by more than so many gaps wait."""
PROGRESS = 0.1
"""What a part leaves of the gap; more would be in vain before the other rows have moved."""
MOST_STEPS = 10_000_000
"""libsvm's limit for up to 100,000 rows."""


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
    gap : float
        Optimality gap of the training rows (`roomseg.smo`).
    steps : int
        Pairs of multipliers that were moved.
    """

    alpha: Floats
    bias: float
    decision: Floats
    gap: float
    steps: int


class SvmPath:
    """SVMs of the same rows and γ, for one C and class weight after the other.

    A solution is the start of the next one with its class weight.

    Parameters
    ----------
    rows : array, shape (n, f)
        Standardised training rows.
    is_border : array of bool, shape (n,)
        Both kinds must be there.
    others : array, shape (t, f)
        Rows to decide on.
    gamma : float
    tolerance : float
        For `SvmSolution.gap`; libsvm's if absent.
    """

    def __init__(
        self,
        rows: Floats,
        is_border: Flags,
        others: Floats,
        gamma: float,
        *,
        tolerance: float = 1e-3,
    ) -> None:
        self._columns = np.ascontiguousarray(np.concatenate([rows, others]).T)
        self._y, self._gamma, self._tolerance = np.where(is_border, 1.0, -1.0), gamma, tolerance
        self._known: dict[float, tuple[float, Floats, Floats]] = {}

    def fit(self, C: float, class_weight: float) -> SvmSolution:
        """Solve for C, with class_weight times C for border edges."""
        n, t = len(self._y), self._columns.shape[1]
        before, beta, f = self._known.get(class_weight, (C, np.zeros(n), np.zeros(t)))
        bound = self._y * np.where(self._y > 0.0, class_weight * C, C)
        beta, f = beta * (C / before), f * (C / before)
        # Scaling rounds: what was at a bound is to stay there.
        beta = np.where(np.isclose(beta, bound, rtol=1e-12, atol=0.0), bound, beta)
        state = _State(beta, f, np.minimum(bound, 0.0), np.maximum(bound, 0.0), self._y)
        steps, (gap, bias) = 0, state.optimality()
        while gap > self._tolerance and steps < MOST_STEPS:
            steps += self._improve(state, gap, bias)
            gap, bias = state.optimality()
        self._known[class_weight] = C, beta, f
        return SvmSolution(np.abs(beta), bias, f[n:] + bias, gap, steps)

    def _improve(self, state: _State, gap: float, bias: float) -> int:
        """Solve for the rows that matter most, and bring f of all rows up to date."""
        chosen = state.most_urgent(gap, bias)
        columns = np.ascontiguousarray(self._columns[:, chosen])
        beta, aim = state.beta[chosen], max(0.5 * self._tolerance, PROGRESS * gap)
        rows = state.low[chosen], state.high[chosen], beta, state.error[chosen]
        steps = minimise(columns, *rows, self._gamma, aim, MOST_STEPS)
        change = beta - state.beta[chosen]
        moved = np.flatnonzero(change)
        points = np.ascontiguousarray(columns[:, moved].T)
        kernel_sum(self._columns, points, change[moved], self._gamma, state.f)
        state.beta[chosen] = beta
        return steps


@dataclass(frozen=True)
class _State:
    """Signed multipliers β = y α of the training rows, between low and high; f = K β of all rows.

    ``beta`` and ``f`` change.
    """

    beta: Floats
    f: Floats
    low: Floats
    high: Floats
    y: Floats

    @property
    def error(self) -> Floats:
        """What f lacks, y - f, of the training rows."""
        return self.y - self.f[: len(self.y)]

    def optimality(self) -> tuple[float, float]:
        """Optimality gap, and b: the mean error of free rows as in libsvm."""
        error, rises, falls = self.error, self.beta < self.high, self.beta > self.low
        most, least = float(error[rises].max()), float(error[falls].min())
        free = rises & falls
        bias = float(error[free].mean()) if free.any() else 0.5 * (most + least)
        return most - least, bias

    def most_urgent(self, gap: float, bias: float) -> NDArray[np.int64]:
        """Rows that are free, wrong or nearly so, some of either side, in order of their number."""
        excess, rises, falls = self.error - bias, self.beta < self.high, self.beta > self.low
        chosen = [np.flatnonzero(rises & falls)]
        for side, wrong in ((rises, excess), (falls, -excess)):
            rows = np.flatnonzero(side)
            near = np.count_nonzero(wrong[rows] > -REACH * gap)
            count = min(len(rows), max(LEAST_ROWS, min(near, MOST_ROWS)))
            chosen.append(rows[np.argpartition(-wrong[rows], count - 1)[:count]])
        urgent: NDArray[np.int64] = np.unique(np.concatenate(chosen))
        return urgent
