"""Few points instead of an SVM's many support vectors.

Of 60,000 edges some 20,000 become support vectors, as w times as many border edges are
found as there are. The decision function Σ_j c_j K(x, s_j) (Eq. 16) is much simpler than their
number: over a few features the Gaussian kernel has low rank. It is approached by the
function that agrees with it at some of the training edges: the next one is where they differ
most, until they differ nowhere by more than the SVM's own tolerance. In the basis of Newton
(Müller & Schaback, 2009) every new point adds a column, and changes nothing of the others.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from threadpoolctl import threadpool_limits

from roomseg.kernel import kernel_sum

__all__ = ["reduced_set"]

Floats = NDArray[np.float64]

MOST_POINTS = 1500
MOST_BYTES = 1_000_000_000
"""Of the basis: a million edges get fewer points, or keep their support vectors."""
LEAST_POWER = 1e-6
"""Squared distance of a point from what the chosen ones span; below, it adds rounding only."""


@threadpool_limits.wrap(limits=1)  # type: ignore[untyped-decorator]
def reduced_set(
    rows: Floats, points: Floats, coefficients: Floats, gamma: float, tolerance: float = 1e-3
) -> tuple[Floats, Floats]:
    """Fewer points with almost the same Σ_j coefficients_j K(x, points_j).

    Parameters
    ----------
    rows : array, shape (t, f)
        Where the sums shall be the same; some of them become points.
    points : array, shape (m, f)
    coefficients : array, shape (m,)
    gamma : float
    tolerance : float
        The most by which the sums may differ.

    Returns
    -------
    points : array, shape (k, f)
    coefficients : array, shape (k,)
        Both as they were if half as many points, or `MOST_POINTS`, do not suffice.
    """
    columns = np.ascontiguousarray(rows.T)
    residual, power = _sum(points, coefficients, columns, gamma), np.ones(len(rows))
    most = min(MOST_POINTS, len(points) // 2, len(rows), MOST_BYTES // (8 * max(1, len(rows))))
    # Only what is filled takes memory.
    basis, weights, chosen = np.empty((most, len(rows))), np.empty(most), np.empty(most, np.intp)
    count = 0
    while np.abs(residual).max(initial=0.0) > tolerance:
        new = int(np.argmax(np.where(power > LEAST_POWER, np.abs(residual), -1.0)))
        if count == most or power[new] <= LEAST_POWER:
            return points, coefficients
        kernel = _sum(rows[new : new + 1], np.ones(1), columns, gamma)
        basis[count] = (kernel - basis[:count, new] @ basis[:count]) / np.sqrt(power[new])
        weights[count] = residual[new] / basis[count, new]
        residual -= weights[count] * basis[count]
        power -= basis[count] ** 2
        chosen[count], count = new, count + 1
    if not count:
        return points, coefficients
    # Those chosen later are zero at this one: the matrix is triangular.
    values = basis[:count, chosen[:count]]
    return rows[chosen[:count]], solve_triangular(values, weights[:count])


def _sum(points: Floats, coefficients: Floats, columns: Floats, gamma: float) -> Floats:
    """Σ_j coefficients_j K(row, points_j) of each row, given as columns (f, t)."""
    out = np.zeros(columns.shape[1])
    kernel_sum(columns, points, coefficients, gamma, out)
    return out
