"""Edge weights by hand, and rooms of small map graphs."""

from __future__ import annotations

import numpy as np
import pytest

from dataset.errors import FormatError
from roomseg.preprocessing import MapGraph
from roomseg.segmentation import affinity_of, edge_weights, segment


def graph_of(edges: np.ndarray, length: np.ndarray, nodes: int | None = None) -> MapGraph:
    edges = np.asarray(edges)
    count = int(edges.max()) + 1 if nodes is None else nodes
    return MapGraph(count, np.arange(len(edges)), edges, np.asarray(length, dtype=float))


def hall(columns: int = 12, rows: int = 6, lane: float = 0.3) -> MapGraph:
    """A plain rectangle: nodes 0.1 m apart along lanes, ``lane`` between them."""
    index = np.arange(columns * rows).reshape(rows, columns)
    along = np.stack([index[:, :-1].ravel(), index[:, 1:].ravel()], axis=1)
    across = np.stack([index[:-1].ravel(), index[1:].ravel()], axis=1)
    length = np.repeat([0.1, lane], [len(along), len(across)])
    return graph_of(np.concatenate([along, across]), length)


def test_weights_by_hand() -> None:
    graph = graph_of([[0, 1], [1, 2], [2, 3]], [0.1, 0.3, 0.2])
    border = np.array([False, True, False])
    assert edge_weights(graph, border, rho=60) == pytest.approx([10, 1 / 18, 5])
    assert edge_weights(graph).tolist() == [1, 1, 1]


def test_predicted_border_is_cut() -> None:
    """The border is off the middle, where the plain graph would be cut."""
    graph = hall()
    column = graph.edges % 12
    border = (column[:, 0] == 3) & (column[:, 1] == 4)
    labels = segment(graph, border, 2, np.random.default_rng(0))
    assert (labels == (np.arange(72) % 12 > 3)).all()
    plain = segment(graph, np.zeros(len(graph), bool), 2, np.random.default_rng(0))
    assert (plain != labels).any()


def test_uniform_variant_ignores_lengths() -> None:
    """16 columns 0.1 m apart, 12 rows 0.3 m apart: longer in nodes is shorter in metres."""
    graph = hall(16, 12)
    uniform = segment(graph, None, 2, np.random.default_rng(0)).reshape(12, 16)
    assert (uniform == uniform[0]).all()  # across the 16 columns
    by_length = segment(graph, np.zeros(len(graph), bool), 2, np.random.default_rng(0))
    by_length = by_length.reshape(12, 16)
    assert (by_length[:, 0] == by_length.T).all()  # across the 3.3 m


def test_pieces_are_joined_to_the_node_before() -> None:
    graph = graph_of([[0, 1], [1, 2], [3, 4], [4, 5]], [0.1, 0.1, 0.2, 0.2])
    weights = edge_weights(graph, np.zeros(4, bool))
    joined = affinity_of(graph, weights).toarray()
    assert joined[2, 3] == joined[3, 2] == np.median(weights)
    assert np.count_nonzero(joined) == 10


def test_lonely_node_takes_no_room_of_its_own() -> None:
    graph = hall()
    column = graph.edges % 12
    border = (column[:, 0] == 5) & (column[:, 1] == 6)
    with_lonely = graph_of(graph.edges, graph.length, nodes=73)
    labels = segment(with_lonely, border, 2, np.random.default_rng(0))
    assert (labels[:72] == (np.arange(72) % 12 > 5)).all()
    assert labels[72] == labels[71]


@pytest.mark.parametrize("rooms", [0, 73])
def test_impossible_room_count(rooms: int) -> None:
    with pytest.raises(FormatError, match=rf"rooms: {rooms}, expected 1\.\.72"):
        segment(hall(), None, rooms, np.random.default_rng(0))


def test_one_room() -> None:
    assert (segment(hall(), None, 1, np.random.default_rng(0)) == 0).all()


def test_labels_are_int32() -> None:
    assert segment(hall(), None, 3, np.random.default_rng(0)).dtype == np.int32
