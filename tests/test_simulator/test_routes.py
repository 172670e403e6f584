"""Shortest paths over the growing map, against scipy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from simulator.graph import MapGraph


@pytest.mark.parametrize("seed", range(3))
def test_paths_agree_with_scipy(seed):
    """Over a map that grows, is barred and forgets."""
    rng = np.random.default_rng(seed)
    graph = MapGraph()
    for count in (40, 300, 700):
        graph.remove_from(int(0.8 * len(graph)))
        while len(graph) < count:
            place = rng.uniform(0.0, 0.1 * np.sqrt(count), 3)
            node = graph.add_node(place, np.zeros(3), 0, 0, 0.0)
            for other in graph.within(place, 0.2)[1:6]:
                graph.add_edge(node, int(other))
        lengths = np.linalg.norm(
            graph.position[graph.edges[:, 0]] - graph.position[graph.edges[:, 1]], axis=1
        )
        matrix = csr_array((lengths, graph.edges.T), shape=(count, count))
        for start, goal in rng.integers(0, count, (5, 2)):
            right = dijkstra(matrix, directed=False, indices=start)
            length, previous = graph.routes(start)
            np.testing.assert_allclose(length, right, atol=1e-3)
            steps = np.flatnonzero(previous >= 0)
            assert set(steps) == set(np.flatnonzero(np.isfinite(right))) - {start}
            pairs = {tuple(pair) for pair in graph.edges.tolist()}
            assert all((min(k, p), max(k, p)) in pairs for k, p in enumerate(previous) if p >= 0)
            length, until = graph.routes(start, goal)
            assert length[goal] == pytest.approx(right[goal], abs=1e-3)
            node = goal
            while until[node] >= 0:
                assert until[node] == previous[node]
                node = until[node]
