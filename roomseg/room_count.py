"""Two estimates of the number of rooms (§2.4.1).

The paper leaves open what the eigenvalue-gap heuristic says if no gap is
classified as the room count's (Eq. 26 is then the minimum of nothing): we take
the gap with the highest probability. Regression results are rounded to the
nearest whole number, at least one. Both fits are without regularisation, as in
Matlab; the gaps are standardised before the logistic fit, which changes only
the course of the optimisation, not its optimum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from sklearn.linear_model import LinearRegression, LogisticRegression

from dataset.errors import FormatError

__all__ = [
    "EigenvalueGap",
    "NodeCountRegression",
    "RoomCountQuality",
    "room_count_quality",
    "usual_room_count",
]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class NodeCountRegression:
    """m̃_1 = a √n + b n + c (Eq. 23)."""

    a: float
    b: float
    c: float

    @classmethod
    def fit(cls, node_counts: Sequence[int], rooms: Sequence[int]) -> NodeCountRegression:
        """Least squares over the training maps: n and m of each.

        Raises
        ------
        FormatError
            If there is no map.
        """
        if not len(node_counts):
            raise FormatError("room count: 0 training maps, expected at least 1")
        n = np.asarray(node_counts, dtype=float)
        model = LinearRegression().fit(np.stack([np.sqrt(n), n], axis=1), np.asarray(rooms, float))
        return cls(float(model.coef_[0]), float(model.coef_[1]), float(model.intercept_))

    def predict(self, node_count: int) -> int:
        """Room count of a map with this many nodes."""
        return max(1, round(self.a * float(np.sqrt(node_count)) + self.b * node_count + self.c))


def usual_room_count(node_count: int) -> int:
    """Rooms of a home of that size, where there is nothing to fit Eq. 23 to.

    Only its first term, a sixth of the root of the nodes: within two of all places of Table 8, and
    sensible for smaller and larger maps, too, for which a fit with three terms is not.
    """
    return max(1, round(float(np.sqrt(node_count)) / 6.0))


@dataclass(frozen=True)
class EigenvalueGap:
    """First eigenvalue gap that a logistic regression takes for the m-th (Eqs. 24-26)."""

    a: float
    b: float

    @classmethod
    def fit(cls, eigenvalues: Sequence[Floats], rooms: Sequence[int]) -> EigenvalueGap:
        """Fit a and b of Eq. 25.

        Parameters
        ----------
        eigenvalues : sequence of arrays
            λ_1, λ_2, ... ascending, at least m + 1 of each training map.
        rooms : sequence of int
            m of each map.

        Raises
        ------
        FormatError
            If a map has too few eigenvalues, or all have a single room.
        """
        gaps, is_last = [], []
        for values, count in zip(eigenvalues, rooms, strict=True):
            if len(values) <= count:
                raise FormatError(
                    f"eigenvalues: {len(values)}, expected more than the {count} rooms"
                )
            gaps.append(eigenvalue_gaps(values)[:count])
            is_last.append(np.arange(1, count + 1) == count)
        g, y = np.concatenate(gaps), np.concatenate(is_last)
        if y.all():
            raise FormatError("room count: every training map has 1 room, expected some with more")
        middle, spread = g.mean(), g.std() or 1.0
        model = LogisticRegression(C=np.inf, max_iter=1000)
        model.fit(((g - middle) / spread)[:, None], y)
        a = float(model.coef_[0, 0]) / spread
        return cls(a, float(model.intercept_[0]) - a * middle)

    def predict(self, eigenvalues: Floats) -> int:
        """Room count of a map (Eq. 26).

        Parameters
        ----------
        eigenvalues : array, shape (q,)
            λ_1 .. λ_q ascending; at most q - 1 rooms can be found.
        """
        score = self.a * eigenvalue_gaps(eigenvalues) + self.b
        hits = np.flatnonzero(score >= 0)  # y_i = 1 where the probability is at least 1/2
        return int(hits[0] if len(hits) else np.argmax(score)) + 1


def eigenvalue_gaps(eigenvalues: Floats) -> Floats:
    """g_i = |λ_{i+1} - λ_i| (Eq. 24), shape (q - 1,)."""
    gaps: Floats = np.abs(np.diff(eigenvalues))
    return gaps


@dataclass(frozen=True)
class RoomCountQuality:
    """One row of Table 7: mean |e|, and the fractions with e = 0 and |e| <= 1."""

    mean_absolute_error: float
    exact: float
    within_one: float


def room_count_quality(estimated: Sequence[int], true: Sequence[int]) -> RoomCountQuality:
    """Judge room count estimates over maps (Table 7)."""
    error = np.abs(np.asarray(estimated) - np.asarray(true))
    return RoomCountQuality(
        float(error.mean()), float((error == 0).mean()), float((error <= 1).mean())
    )
