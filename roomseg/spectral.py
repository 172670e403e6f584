"""Normalised-cut clustering after Shi and Malik (§2.4).

What the paper says: the m smallest eigenvectors of L v = λ D v, k-means on the
rows of V, repeated 100 times; the repetition with the lowest summed distance
(Eq. 22) wins. It uses Matlab's eig and kmeans with default parameters.

* §2.4 prints L_rw = D⁻¹W. Shi and Malik's, and the one equivalent to
  L v = λ D v, is I - D⁻¹W = D⁻¹L; the "smallest" eigenvalues only make sense so.
* Matlab's eig scales the vectors of a symmetric-definite pair to vᵀDv = 1, so
  do we. (k-means depends on the scale; here it is common to all vectors.)
* Matlab's kmeans defaults: k-means++ start, squared Euclidean distance, at most
  100 iterations, a cluster that runs empty takes the farthest point. Eq. 22
  then sums plain, not squared, distances.
* A node without edges has no degree; it counts as joined to itself, a piece of
  its own. `roomseg.segmentation` never passes such graphs.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.sparse.linalg import eigsh

__all__ = [
    "REPETITIONS",
    "adjacency",
    "cluster_rows",
    "embedding",
    "laplacian_eigenvalues",
    "ncut",
    "spectral_clustering",
]

REPETITIONS = 100
MAX_ITERATIONS = 100
DENSE_NODES = 200
"""Below this size a dense eigensolver is as fast as the sparse one."""

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Function = TypeVar("Function", bound=Callable[..., object])


def _compiled(function: Function) -> Function:
    """Compile with numba on first use; the machine code is kept for the next run."""
    return cast(Function, numba.njit(cache=True, nogil=True)(function))


def adjacency(node_count: int, edges: Integers, weights: Floats) -> sparse.csr_array:
    """Symmetric weighted adjacency matrix W, shape (n, n) (§2.4)."""
    first, second = edges[:, 0], edges[:, 1]
    rows, columns = np.concatenate([first, second]), np.concatenate([second, first])
    return sparse.csr_array(
        (np.concatenate([weights, weights]).astype(float), (rows, columns)),
        shape=(node_count, node_count),
    )


def embedding(affinity: sparse.csr_array, count: int) -> tuple[Floats, Floats]:
    """Find the smallest eigenpairs of L v = λ D v, L = D - W (§2.4).

    Solved as D^-½ L D^-½ u = λ u with v = D^-½ u, a symmetric problem.

    Parameters
    ----------
    affinity : sparse array, shape (n, n)
        W.
    count : int
        m, 1 <= m <= n.

    Returns
    -------
    eigenvalues : array, shape (m,)
        Ascending.
    vectors : array, shape (n, m)
        V; vᵀDv = 1, and each vector's largest component is positive.

    Raises
    ------
    ValueError
        If ``count`` is not in 1 .. n.
    """
    n = affinity.shape[0]
    if not 1 <= count <= n:
        raise ValueError(f"count: {count}, expected 1..{n}")
    degree = np.asarray(affinity.sum(axis=1)).reshape(-1)
    root = 1.0 / np.sqrt(np.where(degree > 0, degree, 1.0))
    scaling = sparse.diags_array(root)
    normalised = sparse.diags_array((degree > 0).astype(float)) - scaling @ affinity @ scaling
    values, vectors = _smallest_pairs(normalised.tocsc(), count)
    vectors = vectors * root[:, None]
    largest = vectors[np.abs(vectors).argmax(axis=0), np.arange(count)]
    return np.maximum(values, 0.0), vectors * np.where(largest < 0, -1.0, 1.0)


def _smallest_pairs(matrix: sparse.csc_array, count: int) -> tuple[Floats, Floats]:
    """Smallest eigenpairs of a symmetric positive semidefinite matrix."""
    n = matrix.shape[0]
    if n < DENSE_NODES or count > n // 4:
        values, vectors = linalg.eigh(matrix.toarray(), subset_by_index=[0, count - 1])
    else:
        # Just below zero the shifted matrix is regular, and eigenvalues of 1e-7, which
        # weights of 1e-4 give, are still told apart. A fixed start makes it repeatable.
        start = 1.0 + np.cos(np.arange(n))
        values, vectors = eigsh(matrix, k=count, sigma=-1e-5, which="LM", v0=start, tol=1e-12)
    order = np.argsort(values, kind="stable")
    return values[order], vectors[:, order]


def laplacian_eigenvalues(affinity: sparse.csr_array, count: int) -> Floats:
    """λ_1 .. λ_count of the normalised Laplacian, ascending (§2.4.1)."""
    return embedding(affinity, min(count, affinity.shape[0]))[0]


def spectral_clustering(
    affinity: sparse.csr_array, clusters: int, rng: np.random.Generator
) -> Integers:
    """Cluster a graph's nodes by minimal normalised cut, approximately (§2.4).

    Parameters
    ----------
    affinity : sparse array, shape (n, n)
    clusters : int
        m.
    rng : numpy.random.Generator

    Returns
    -------
    array, shape (n,)
        0 .. m - 1, numbered by the first node of each cluster.
    """
    vectors = embedding(affinity, clusters)[1]
    return first_node_order(cluster_rows(vectors, clusters, rng))


def first_node_order(labels: Integers) -> Integers:
    """Renumber clusters in the order of their first nodes, shape (n,)."""
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(first))
    ordered: Integers = rank[inverse.reshape(-1)].astype(np.int64)
    return ordered


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

    Returns
    -------
    array, shape (n,)
        Cluster of each row.
    """
    draws = rng.random((repetitions, clusters))
    labels: Integers = _best_of(np.ascontiguousarray(rows, dtype=np.float64), draws)
    return labels


@_compiled
def _best_of(rows: Floats, draws: Floats) -> Integers:
    """Run k-means once per row of draws; keep the lowest d_sum of Eq. 22."""
    best = np.zeros(rows.shape[0], np.int64)
    lowest = np.inf
    for repetition in range(draws.shape[0]):
        centres = _plus_plus(rows, draws[repetition])
        labels, summed = _lloyd(rows, centres)
        if summed < lowest:
            lowest, best = summed, labels
    return best


@_compiled
def _plus_plus(rows: Floats, draws: Floats) -> Floats:
    """k-means++ start: each next centre is drawn by its squared distance to the others."""
    n, k = rows.shape[0], draws.shape[0]
    centres = np.empty((k, rows.shape[1]))
    nearest = np.ones(n)
    for c in range(k):
        total = 0.0
        for i in range(n):
            total += nearest[i]
        left, pick = draws[c] * total, 0
        while pick < n - 1 and left >= nearest[pick]:
            left -= nearest[pick]
            pick += 1
        for j in range(rows.shape[1]):
            centres[c, j] = rows[pick, j]
        for i in range(n):
            squared = _squared_distance(rows, i, centres, c)
            if c == 0 or squared < nearest[i]:
                nearest[i] = squared
    return centres


@_compiled
def _squared_distance(rows: Floats, i: int, centres: Floats, c: int) -> float:
    """Squared distance of row i and centre c."""
    total = 0.0
    for j in range(rows.shape[1]):
        total += (rows[i, j] - centres[c, j]) ** 2
    return total


@_compiled
def _assign(rows: Floats, centres: Floats, labels: Integers, squared: Floats) -> bool:
    """Give each row its nearest centre; whether any label changed."""
    changed = False
    for i in range(rows.shape[0]):
        best, at = np.inf, 0
        for c in range(centres.shape[0]):
            distance = _squared_distance(rows, i, centres, c)
            if distance < best:
                best, at = distance, c
        changed = changed or labels[i] != at
        labels[i], squared[i] = at, best
    return changed


@_compiled
def _recentre(rows: Floats, centres: Floats, labels: Integers, squared: Floats) -> None:
    """Move the centres to their rows' means; an empty cluster takes the farthest row.

    A row that is alone in its cluster stays there, as in Matlab.
    """
    counts = np.zeros(centres.shape[0])
    for i in range(rows.shape[0]):
        counts[labels[i]] += 1
    for c in range(centres.shape[0]):
        if counts[c] == 0:
            farthest = np.argmax(np.where(counts[labels] > 1, squared, -1.0))
            counts[labels[farthest]] -= 1
            labels[farthest], squared[farthest], counts[c] = c, 0.0, 1
    centres[:] = 0.0
    for i in range(rows.shape[0]):
        for j in range(rows.shape[1]):
            centres[labels[i], j] += rows[i, j] / counts[labels[i]]


@_compiled
def _lloyd(rows: Floats, centres: Floats) -> tuple[Integers, float]:
    """Labels after convergence, and d_sum of Eq. 22."""
    n = rows.shape[0]
    labels, squared = np.full(n, -1), np.zeros(n)
    for _ in range(MAX_ITERATIONS):
        if not _assign(rows, centres, labels, squared):
            break
        _recentre(rows, centres, labels, squared)
    summed = 0.0
    for i in range(n):
        summed += np.sqrt(_squared_distance(rows, i, centres, labels[i]))
    return labels, summed


def ncut(affinity: sparse.csr_array, labels: Integers) -> float:
    """Normalised cut of a clustering (Eqs. 19-21).

    Parameters
    ----------
    affinity : sparse array, shape (n, n)
        W.
    labels : array, shape (n,)

    Returns
    -------
    float
        Sum over clusters of cut / vol; a cluster without edges adds nothing.
    """
    entries = affinity.tocoo()
    crosses = labels[entries.row] != labels[entries.col]
    n_labels = int(labels.max()) + 1
    volume = np.bincount(labels[entries.row], entries.data, n_labels)
    cut = np.bincount(labels[entries.row][crosses], entries.data[crosses], n_labels)
    present = volume > 0
    return float((cut[present] / volume[present]).sum())
