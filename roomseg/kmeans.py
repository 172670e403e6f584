"""Repeated k-means as Matlab's, of which the lowest summed distance wins (§2.4, Eq. 22).

Matlab's defaults: k-means++ starts, squared Euclidean distance, at most 100 iterations, a
cluster that runs empty takes the farthest row. Eq. 22 then sums plain distances.

All the paper's hundred repetitions count, but few are run to their end. What follows from
a partition does not depend on how it came about: a repetition that meets a partition
which an earlier one has met, however its clusters are numbered, would end as that one did,
and is left off there. One repetition more, the first, starts from the rows that a pivoted
QR factorisation takes (Damle, Minden and Ying, 2019); rarely does another one end lower.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray
from scipy import linalg

__all__ = ["REPETITIONS", "cluster_rows"]

REPETITIONS = 100
MAX_ITERATIONS = 100
TABLE = 1 << 14
"""Places for marks of partitions; at most `MAX_ITERATIONS` of each repetition are kept."""

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Marks = NDArray[np.uint64]
Function = TypeVar("Function", bound=Callable[..., object])


def _compiled(function: Function) -> Function:
    """Compile with numba on first use; the machine code is kept for the next run."""
    return cast(Function, numba.njit(cache=True, error_model="numpy")(function))


def cluster_rows(
    rows: Floats,
    clusters: int,
    rng: np.random.Generator,
    repetitions: int = REPETITIONS,
) -> Integers:
    """k-means, repeated; the lowest summed distance wins (§2.4, Eq. 22).

    Parameters
    ----------
    rows : array, shape (n, d)
        V.
    clusters : int
    rng : numpy.random.Generator
    repetitions : int
        Random ones, besides the one that starts from pivoted rows.

    Returns
    -------
    array, shape (n,)
        Cluster of each row.
    """
    draws = rng.random((repetitions, clusters))
    rows = np.ascontiguousarray(rows, dtype=np.float64)
    # Fixed random numbers: equal partitions have equal marks.
    marks = np.random.default_rng(0).integers(0, 2**63, len(rows)).astype(np.uint64)
    labels: Integers = _best_of(rows, _pivoted_centres(rows, clusters), draws, marks)
    return labels


def _pivoted_centres(rows: Floats, clusters: int) -> Floats:
    """Rows that a pivoted QR factorisation takes first, shape (k, d); of few columns, any rows."""
    pivots = linalg.qr(rows.T, mode="r", pivoting=True, check_finite=False)[1]
    return np.ascontiguousarray(rows[pivots[:clusters]])


@_compiled
def _best_of(rows: Floats, first: Floats, draws: Floats, marks: Marks) -> Integers:
    """Run k-means from the given centres, then once per row of draws; keep the best."""
    columns, best = np.ascontiguousarray(rows.T), np.zeros(rows.shape[0], np.int64)
    norms = (columns**2).sum(axis=0)
    lowest, seen = np.inf, np.zeros(TABLE, np.uint64)
    for repetition in range(-1, draws.shape[0]):
        centres = first.copy() if repetition < 0 else _plus_plus(columns, norms, draws[repetition])
        labels, summed = _lloyd(rows, columns, centres, marks, seen)
        if summed < lowest:
            lowest, best = summed, labels
    return best


@_compiled
def _plus_plus(columns: Floats, norms: Floats, draws: Floats) -> Floats:
    """k-means++ start: each next centre is drawn by its squared distance to the others."""
    n, k = columns.shape[1], draws.shape[0]
    centres, nearest = np.empty((k, columns.shape[0])), np.ones(n)
    for c in range(k):
        left, pick = draws[c] * nearest.sum(), 0
        while pick < n - 1 and left >= nearest[pick]:
            left -= nearest[pick]
            pick += 1
        centres[c] = columns[:, pick]
        products, norm = np.dot(centres[c : c + 1], columns)[0], norms[pick]
        for i in range(n):
            squared = max(norms[i] + norm - 2.0 * products[i], 0.0)
            nearest[i] = squared if c == 0 else min(nearest[i], squared)
        nearest[pick] = 0.0
    return centres


@_compiled
def _assign(columns: Floats, centres: Floats, labels: Integers) -> bool:
    """Give each row its nearest centre c, of least |c|² / 2 - c x; whether any label changed."""
    k, n = centres.shape[0], columns.shape[1]
    products = np.dot(centres, columns)
    best, at = np.full(n, np.inf), np.zeros(n)
    for c in range(k):
        half = 0.5 * (centres[c] ** 2).sum()
        for i in range(n):
            distance = half - products[c, i]
            nearer = distance < best[i]
            best[i] = distance if nearer else best[i]
            at[i] = float(c) if nearer else at[i]
    changed = 0
    for i in range(n):
        label = int(at[i])
        changed += labels[i] != label
        labels[i] = label
    return changed > 0


@_compiled
def _recentre(rows: Floats, centres: Floats, labels: Integers) -> bool:
    """Move the centres to their rows' means; whether every cluster had rows.

    An empty cluster takes the row that is farthest from its centre, but none that is alone in
    its cluster, as in Matlab.
    """
    counts, filled = np.zeros(centres.shape[0]), True
    for i in range(rows.shape[0]):
        counts[labels[i]] += 1
    for c in range(centres.shape[0]):
        if counts[c] == 0:
            filled = False
            farthest = _farthest(rows, centres, labels, counts)
            counts[labels[farthest]] -= 1
            labels[farthest], counts[c] = c, 1
            centres[c] = rows[farthest]
    centres[:] = 0.0
    for i in range(rows.shape[0]):
        for j in range(rows.shape[1]):
            centres[labels[i], j] += rows[i, j]
    for c in range(centres.shape[0]):
        centres[c] /= counts[c]
    return filled


@_compiled
def _farthest(rows: Floats, centres: Floats, labels: Integers, counts: Floats) -> int:
    """Row that is farthest from its centre, of those that share their cluster."""
    farthest, most = 0, -1.0
    for i in range(rows.shape[0]):
        squared = ((rows[i] - centres[labels[i]]) ** 2).sum()
        if counts[labels[i]] > 1 and squared > most:
            farthest, most = i, squared
    return farthest


@_compiled
def _is_new(labels: Integers, clusters: int, marks: Marks, seen: Marks) -> bool:
    """Whether no repetition has met this partition, which is noted."""
    sums = np.zeros(clusters, np.uint64)
    for i in range(len(labels)):
        sums[labels[i]] += marks[i]
    mark = np.uint64(0)
    for c in range(clusters):
        mixed = sums[c] * np.uint64(0x9E3779B97F4A7C15)
        mark += (mixed ^ (mixed >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9)
    mark |= np.uint64(1)
    place = mark >> np.uint64(50)
    for _ in range(TABLE):
        if seen[place] == mark:
            return False
        if seen[place] == 0:
            seen[place] = mark
            return True
        place = (place + np.uint64(1)) & np.uint64(TABLE - 1)
    return True


@_compiled
def _lloyd(
    rows: Floats, columns: Floats, centres: Floats, marks: Marks, seen: Marks
) -> tuple[Integers, float]:
    """Labels after convergence, and d_sum of Eq. 22; infinite where another run ended likewise."""
    labels = np.full(rows.shape[0], -1)
    for _ in range(MAX_ITERATIONS):
        if not _assign(columns, centres, labels):
            break
        filled = _recentre(rows, centres, labels)
        if filled and not _is_new(labels, centres.shape[0], marks, seen):
            return labels, np.inf
    summed = 0.0
    for i in range(rows.shape[0]):
        summed += np.sqrt(((rows[i] - centres[labels[i]]) ** 2).sum())
    return labels, summed
