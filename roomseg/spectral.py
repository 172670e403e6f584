"""Normalised-cut clustering after Shi and Malik (§2.4).

What the paper says: the m smallest eigenvectors of L v = λ D v, k-means on the
rows of V, repeated 100 times; the repetition with the lowest summed distance
(Eq. 22) wins. It uses Matlab's eig and kmeans with default parameters.

* §2.4 prints L_rw = D⁻¹W. Shi and Malik's, and the one equivalent to
  L v = λ D v, is I - D⁻¹W = D⁻¹L; the "smallest" eigenvalues only make sense so.
* Matlab's eig scales the vectors of a symmetric-definite pair to vᵀDv = 1, so
  do we. (k-means depends on the scale; here it is common to all vectors.)
* A node without edges has no degree; it counts as joined to itself, a piece of
  its own. `roomseg.segmentation` never passes such graphs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.sparse.linalg import eigsh

from roomseg.kmeans import cluster_rows

__all__ = [
    "adjacency",
    "embedding",
    "laplacian_eigenvalues",
    "ncut",
    "spectral_clustering",
]

DENSE_NODES = 200
"""Below this size a dense eigensolver is as fast as the sparse one."""

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


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
