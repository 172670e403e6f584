"""Algorithm 1 against a straight transcription of its pseudo-code."""

from __future__ import annotations

import numpy as np
import pytest
from cleaned_flat import cleaned_flat
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from dataset.topomap import Nodes, Obstacles, TopoMap, Visits
from roomseg.preprocessing import MINIMUM_LENGTH, length_weights, preprocess


def map_of(position, part, lane, edges) -> TopoMap:
    n = len(position)
    return TopoMap(
        environment="test",
        run="run1",
        seed=1,
        created="2026-01-01",
        software="test",
        nodes=Nodes(position, np.zeros(n), part, lane),
        edges=edges,
        visits=Visits(np.arange(n), np.arange(n) * 1.0),
        obstacles=Obstacles(np.zeros((0, 2)), np.zeros(0), np.zeros(0)),
    )


def random_map(seed: int, nodes: int = 60) -> TopoMap:
    """Nodes of three parts with a few lanes each, in any order, and random edges."""
    rng = np.random.default_rng(seed)
    pairs = np.stack(np.triu_indices(nodes, 1), axis=1)
    edges = pairs[rng.random(len(pairs)) < 0.3]
    position = rng.random((nodes, 2))
    return map_of(position, rng.integers(0, 3, nodes), rng.integers(0, 4, nodes), edges)


def algorithm_1(topomap: TopoMap, linked_only: bool) -> list[int]:
    """Lines 1-14 as printed; ``linked_only`` restricts both argmins to linked nodes."""
    part, lane = topomap.nodes.part, topomap.nodes.lane
    position, everyone = topomap.nodes.position, range(len(topomap.nodes))
    index = {frozenset(edge): i for i, edge in enumerate(topomap.edges.tolist())}
    alive = set(index.values())

    def thin_out(n: int, candidates: list[int]) -> None:
        linked = [m for m in candidates if frozenset((m, n)) in index]
        pool = linked if linked_only else candidates
        if pool:
            nearest = min(pool, key=lambda m: np.linalg.norm(position[m] - position[n]))
            for m in linked:
                if m != nearest:
                    alive.discard(index[frozenset((m, n))])

    for n in everyone:
        thin_out(n, [m for m in everyone if part[m] == part[n] and lane[m] == lane[n] - 1])
        for p in range(part[n]):
            thin_out(n, [m for m in everyone if part[m] == p])
    return sorted(alive)


@pytest.mark.parametrize("linked_only", [True, False])
@pytest.mark.parametrize("seed", range(5))
def test_same_edges_as_pseudo_code(seed: int, linked_only: bool) -> None:
    topomap = random_map(seed)
    graph = preprocess(topomap, linked_only=linked_only)
    assert graph.kept.tolist() == algorithm_1(topomap, linked_only)


def test_same_edges_as_pseudo_code_on_a_flat() -> None:
    topomap = cleaned_flat()
    assert preprocess(topomap).kept.tolist() == algorithm_1(topomap, linked_only=True)


def test_by_hand() -> None:
    # Lane 0 below, lane 1 above; node 3 is nearest to 1, node 4 is the lane's next node.
    position = [[0, 0], [0.1, 0], [0.2, 0], [0.1, 0.3], [0.2, 0.3], [0.3, 0.0]]
    part, lane = [0, 0, 0, 0, 0, 1], [0, 0, 0, 1, 1, 0]
    edges = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3], [3, 4], [0, 5], [2, 5], [3, 5]]
    graph = preprocess(map_of(position, part, lane, edges))
    # In-lane edges stay, even 0-2; of 0-3, 1-3, 2-3 only 1-3; of node 5's links only 2-5.
    assert graph.edges.tolist() == [[0, 1], [0, 2], [1, 2], [1, 3], [3, 4], [2, 5]]
    assert graph.length == pytest.approx([0.1, 0.2, 0.1, 0.3, 0.1, 0.1])
    assert graph.node_count == 6
    assert len(graph) == 6


def test_unlinked_nearest_node_does_not_cut_the_map() -> None:
    # Node 2 (part 1) is nearest to node 0, but a wall stands between: linked to 1 only.
    position, edges = [[0, 0], [0.1, 0], [0.0, 0.1]], [[0, 1], [1, 2]]
    topomap = map_of(position, [0, 0, 1], [0, 0, 0], edges)
    assert preprocess(topomap).edges.tolist() == edges
    assert preprocess(topomap, linked_only=False).edges.tolist() == [[0, 1]]


def test_lanes_that_are_not_subsequent_are_left_alone() -> None:
    position = [[0, 0], [0.1, 0], [0, 0.3]]
    topomap = map_of(position, [0, 0, 0], [0, 0, 2], [[0, 1], [0, 2], [1, 2]])
    assert len(preprocess(topomap)) == 3


def test_flat_stays_connected() -> None:
    graph = preprocess(cleaned_flat())
    matrix = coo_array((np.ones(len(graph)), graph.edges.T), shape=(graph.node_count,) * 2)
    assert connected_components(matrix, directed=False)[0] == 1


def test_length_weights() -> None:
    weights = length_weights(np.array([0.1, 0.3, 0.0]))
    assert weights == pytest.approx([10.0, 1 / 0.3, 1 / MINIMUM_LENGTH])


def test_map_without_edges() -> None:
    graph = preprocess(map_of([[0, 0]], [0], [0], np.empty((0, 2))))
    assert len(graph) == 0
    assert graph.edges.shape == (0, 2)
