"""Spectral clustering on matrices small enough for paper, and against scikit-learn."""

from __future__ import annotations

import numpy as np
import pytest
from cleaned_flat import labelled_flat
from scipy import linalg
from sklearn.cluster import KMeans
from sklearn.metrics import adjusted_rand_score

from roomseg.kmeans import _recentre, cluster_rows
from roomseg.segmentation import affinity_of, edge_weights
from roomseg.spectral import (
    adjacency,
    embedding,
    first_node_order,
    laplacian_eigenvalues,
    ncut,
    spectral_clustering,
)

CHAIN = adjacency(3, np.array([[0, 1], [1, 2]]), np.ones(2))


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def grid(columns: int, rows: int) -> np.ndarray:
    index = np.arange(columns * rows).reshape(rows, columns)
    along = np.stack([index[:, :-1].ravel(), index[:, 1:].ravel()], axis=1)
    across = np.stack([index[:-1].ravel(), index[1:].ravel()], axis=1)
    return np.concatenate([along, across])


def cliques(weak: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes 0-3 and 4-7, each all linked, and one weak edge 3-4."""
    one = np.stack(np.triu_indices(4, 1), axis=1)
    edges = np.concatenate([one, one + 4, [[3, 4]]])
    return edges, np.array([1.0] * 12 + [weak])


def test_adjacency() -> None:
    weights = adjacency(3, np.array([[0, 1], [1, 2]]), np.array([2.0, 5.0]))
    assert weights.toarray().tolist() == [[0, 2, 0], [2, 0, 5], [0, 5, 0]]


def test_chain_of_three_by_hand() -> None:
    """D = diag(1, 2, 1): eigenvalues 0, 1, 2, with vᵀDv = 1."""
    values, vectors = embedding(CHAIN, 3)
    half, root = 0.5, np.sqrt(0.5)
    assert values == pytest.approx([0, 1, 2], abs=1e-12)
    expected = np.array([[half, half, half], [root, 0, -root], [half, -half, half]]).T
    for column in range(3):
        same = vectors[:, column] * np.sign(vectors[0, column])
        assert same == pytest.approx(expected[:, column], abs=1e-12)


def test_weighted_chain_by_hand() -> None:
    """Weights 1 and 3: D = diag(1, 4, 3), and the eigenvalues are again 0, 1, 2."""
    weights = adjacency(3, np.array([[0, 1], [1, 2]]), np.array([1.0, 3.0]))
    assert laplacian_eigenvalues(weights, 3) == pytest.approx([0, 1, 2], abs=1e-12)


def test_triangle_by_hand() -> None:
    """I - D⁻¹W of a triangle: 0 and twice 3/2. D⁻¹W as printed would give 1 and -1/2."""
    triangle = adjacency(3, np.array([[0, 1], [0, 2], [1, 2]]), np.ones(3))
    assert laplacian_eigenvalues(triangle, 3) == pytest.approx([0, 1.5, 1.5], abs=1e-12)


def test_sparse_solver_agrees_with_dense_generalised_problem() -> None:
    edges = grid(30, 20)
    weights = rng(1).uniform(0.2, 3.0, len(edges))
    weights[(edges % 30 == 14)[:, 0] & (edges[:, 1] == edges[:, 0] + 1)] = 1e-4
    affinity = adjacency(600, edges, weights)
    values, vectors = embedding(affinity, 7)
    dense = affinity.toarray()
    degree = np.diag(dense.sum(axis=1))
    expected, expected_vectors = linalg.eigh(degree - dense, degree, subset_by_index=[0, 6])
    assert values == pytest.approx(expected, abs=1e-9)
    overlap = np.abs(expected_vectors.T @ degree @ vectors)
    assert overlap == pytest.approx(np.eye(7), abs=1e-6)


def test_signs_are_determined() -> None:
    vectors = embedding(adjacency(600, grid(30, 20), np.ones(1150)), 5)[1]
    largest = np.abs(vectors).argmax(axis=0)
    assert (vectors[largest, range(5)] > 0).all()


def test_count_out_of_range() -> None:
    with pytest.raises(ValueError, match=r"count: 4, expected 1\.\.3"):
        embedding(CHAIN, 4)


@pytest.mark.parametrize("weak", [1e-4, 0.02, 0.5])
def test_two_cliques_are_parted_at_the_weak_edge(weak: float) -> None:
    edges, weights = cliques(weak)
    labels = spectral_clustering(adjacency(8, edges, weights), 2, rng())
    assert labels.tolist() == [0, 0, 0, 0, 1, 1, 1, 1]


def test_labels_are_numbered_by_first_node() -> None:
    edges, weights = cliques(0.01)
    turned = np.sort((edges + 4) % 8, axis=1)
    labels = spectral_clustering(adjacency(8, turned, weights), 2, rng())
    assert labels.tolist() == [0, 0, 0, 0, 1, 1, 1, 1]
    assert first_node_order(np.array([7, 7, 2, 9, 2])).tolist() == [0, 0, 1, 2, 1]


def test_four_nearly_separate_rooms() -> None:
    """Weights of 1e-4, as for the ground truth, between the quarters of a grid."""
    edges = grid(40, 40)
    place = np.stack(np.divmod(np.arange(1600), 40), axis=1)
    room = (place[:, 0] >= 13) * 2 + (place[:, 1] >= 22)
    crosses = room[edges[:, 0]] != room[edges[:, 1]]
    labels = spectral_clustering(adjacency(1600, edges, np.where(crosses, 1e-4, 1)), 4, rng())
    assert adjusted_rand_score(room, labels) == 1.0


def test_node_without_edges_is_a_piece_of_its_own() -> None:
    affinity = adjacency(4, np.array([[0, 1], [1, 2]]), np.ones(2))
    assert laplacian_eigenvalues(affinity, 4) == pytest.approx([0, 0, 1, 2], abs=1e-12)
    assert spectral_clustering(affinity, 2, rng()).tolist() == [0, 0, 0, 1]


def test_ncut_by_hand() -> None:
    """Chain cut at its second edge: 1 / 3 + 1 / 1; weights 1, 3: 3 / 5 + 3 / 3."""
    assert ncut(CHAIN, np.array([0, 0, 1])) == pytest.approx(1 / 3 + 1)
    weighted = adjacency(3, np.array([[0, 1], [1, 2]]), np.array([1.0, 3.0]))
    assert ncut(weighted, np.array([0, 0, 1])) == pytest.approx(3 / 5 + 1)
    assert ncut(CHAIN, np.zeros(3, int)) == 0


def test_ncut_of_three_parts_as_a_double_loop() -> None:
    edges = grid(6, 5)
    affinity = adjacency(30, edges, rng(2).random(len(edges)))
    labels, dense = rng(3).integers(0, 3, 30), affinity.toarray()
    expected = 0.0
    for part in range(3):
        inside = labels == part
        expected += dense[inside][:, ~inside].sum() / dense[inside].sum()
    assert ncut(affinity, labels) == pytest.approx(expected)


def test_clustering_finds_the_best_cut_of_a_small_graph() -> None:
    """Against all 2^11 - 1 bipartitions of twelve nodes."""
    edges = grid(4, 3)
    weights = rng(5).uniform(0.5, 1.0, len(edges))
    weights[(edges[:, 0] % 4 == 1) & (edges[:, 1] == edges[:, 0] + 1)] = 0.05
    affinity = adjacency(12, edges, weights)
    every = (np.arange(1, 2**11)[:, None] >> np.arange(12)) & 1
    best = min(ncut(affinity, labels) for labels in every)
    assert ncut(affinity, spectral_clustering(affinity, 2, rng())) == pytest.approx(best)


def blobs(seed: int) -> tuple[np.ndarray, np.ndarray]:
    source = rng(seed)
    centres = source.uniform(-5, 5, (6, 3))
    label = source.integers(0, 6, 400)
    return centres[label] + source.normal(0, 0.6, (400, 3)), label


def summed_distance(rows: np.ndarray, labels: np.ndarray) -> float:
    """Eq. 22."""
    centres = np.stack([rows[labels == c].mean(axis=0) for c in range(labels.max() + 1)])
    return float(np.linalg.norm(rows - centres[labels], axis=1).sum())


@pytest.mark.parametrize("seed", range(4))
def test_k_means_is_as_good_as_scikit_learn(seed: int) -> None:
    rows = blobs(seed)[0]
    labels = cluster_rows(rows, 6, rng(seed))
    theirs = KMeans(6, n_init=100, random_state=seed).fit(rows).labels_
    assert summed_distance(rows, labels) <= summed_distance(rows, theirs) * 1.002
    assert adjusted_rand_score(labels, theirs) > 0.97


def test_result_of_k_means_is_a_fixed_point() -> None:
    rows = blobs(9)[0]
    labels = cluster_rows(rows, 6, rng())
    centres = np.stack([rows[labels == c].mean(axis=0) for c in range(6)])
    nearest = np.linalg.norm(rows[:, None] - centres, axis=2).argmin(axis=1)
    assert (nearest == labels).all()


def test_more_repetitions_are_never_worse() -> None:
    rows = blobs(4)[0]
    draws = [summed_distance(rows, cluster_rows(rows, 6, rng(), count)) for count in (1, 10, 100)]
    assert draws[0] >= draws[1] >= draws[2]


def test_same_generator_same_labels() -> None:
    rows = blobs(2)[0]
    assert (cluster_rows(rows, 6, rng(5)) == cluster_rows(rows, 6, rng(5))).all()


def test_an_empty_cluster_takes_no_row_that_is_a_cluster_of_its_own() -> None:
    rows = np.array([[0.0], [1.0], [10.0]])
    centres, labels = np.array([[5.0], [0.8], [90.0]]), np.array([1, 1, 0])
    assert not _recentre(rows, centres, labels)
    assert labels.tolist() == [2, 1, 0]
    assert centres.tolist() == [[10.0], [1.0], [0.0]]


def test_duplicate_rows_still_fill_every_cluster() -> None:
    rows = np.repeat([[0.0, 0.0], [1.0, 0.0]], 5, axis=0)
    labels = cluster_rows(rows, 3, rng())
    assert set(labels) == {0, 1, 2}
    assert labels.min() == 0


@pytest.mark.parametrize("seed", range(3))
def test_of_a_map_no_better_partition_is_found(seed: int) -> None:
    """Eq. 22 of the embedding of a map is that of the best of a hundred of scikit-learn's runs."""
    item, source = labelled_flat("flat", seed), rng(seed)
    graph, rooms = item.features.graph, 6
    found = np.where(
        item.is_border, source.random(len(graph)) > 0.3, source.random(len(graph)) < 0.05
    )
    rows = embedding(affinity_of(graph, edge_weights(graph, found, 60.0)), rooms)[1]
    ours = summed_distance(rows, cluster_rows(rows, rooms, rng(seed)))
    theirs = min(
        summed_distance(
            rows,
            KMeans(rooms, n_init=1, max_iter=100, tol=0.0, random_state=start).fit(rows).labels_,
        )
        for start in range(100)
    )
    assert ours <= theirs * (1.0 + 1e-9)


def test_repetitions_that_end_alike_are_left_off_without_a_difference() -> None:
    rows = blobs(3)[0]
    every = [cluster_rows(rows, 6, rng(seed), 1) for seed in range(20)]
    best = min(summed_distance(rows, labels) for labels in every)
    assert summed_distance(rows, cluster_rows(rows, 6, rng(), 100)) <= best * (1.0 + 1e-9)
