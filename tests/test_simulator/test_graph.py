"""The growing map: visits, shortest paths, forgotten nodes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from simulator.graph import MapGraph


def chain(n=5, spacing=0.1):
    graph = MapGraph()
    for k in range(n):
        graph.add_node(np.array([k * spacing, 0.0, 0.0]), np.zeros(3), 0, 0, float(k))
        if k:
            graph.add_edge(k - 1, k)
    return graph


def test_shortest_path_over_a_shortcut():
    graph = chain(6)
    graph.add_edge(5, 0)
    length, previous = graph.routes(0)
    assert length[5] == pytest.approx(0.5, abs=1e-4)
    graph.add_node(np.array([0.5, 0.1, 0.0]), np.zeros(3), 0, 1, 9.0)
    graph.add_edge(6, 5)
    assert graph.routes(0)[1][6] == 5
    assert previous[1] == 0


def test_a_node_without_an_edge_has_no_path():
    graph = chain(3)
    graph.add_node(np.array([0.5, 0.1, 0.0]), np.zeros(3), 0, 1, 9.0)
    length, previous = graph.routes(0)
    assert length[3] == np.inf and previous[3] < 0 and previous[0] < 0


def test_a_barred_place_is_gone_around():
    """A square: two ways of 1 m and 3 m from corner to corner."""
    graph = MapGraph()
    for k, corner in enumerate([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]):
        graph.add_node(np.array([*corner, 0.0]), np.zeros(3), 0, 0, float(k))
        if k:
            graph.add_edge(k - 1, k)
    graph.add_edge(0, 3)
    assert graph.routes(0)[0][3] == pytest.approx(1.0, abs=1e-4)
    graph.bar(np.array([0.05, 0.5]), 0.1)
    length, previous = graph.routes(0)
    assert length[3] == pytest.approx(3.0, abs=1e-4) and previous[3] == 2
    assert length[1] == pytest.approx(1.0, abs=1e-4)
    # Where there is no other way, it is tried again; and a forgotten edge leaves no toll.
    graph.bar(np.array([0.5, 0.0]), 0.1)
    assert np.isfinite(graph.routes(0)[0]).all()
    graph.remove_from(3)
    graph.add_node(np.array([0.0, 1.0, 0.0]), np.zeros(3), 0, 0, 3.0)
    graph.add_edge(0, 3)
    assert graph.routes(0)[0][3] == pytest.approx(1.0, abs=1e-4)


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


def test_one_visit_per_approach():
    graph = chain(2)
    graph.visits.clear()
    x = np.array([0.5, 0.12, 0.11, 0.5, 0.1, 0.02])
    places, times = np.stack([x, np.zeros(6)], axis=1), np.arange(6.0)
    graph.visit(places[:2], times[:2], 0.03)
    graph.visit(places[2:], times[2:], 0.03)
    assert graph.visits == [(1.0, 1), (4.0, 1), (5.0, 0)]


def test_forgetting_the_last_nodes():
    graph = chain(6)
    graph.remove_from(4)
    assert len(graph) == 4
    assert graph.edges.tolist() == [[0, 1], [1, 2], [2, 3]]
    assert {node for _, node in graph.visits} == {0, 1, 2, 3}


def test_many_nodes_grow_the_arrays():
    graph = chain(700)
    np.testing.assert_allclose(graph.position[:, 0], 0.1 * np.arange(700))


def test_distances_leave_out_a_lane():
    graph = chain(3)
    graph.add_node(np.array([0.0, 0.3, 0.0]), np.zeros(3), 0, 7, 9.0)
    points = np.array([[0.0, 0.3]])
    assert graph.distances(points)[0] == 0.0
    assert graph.distances(points, running_lane=7)[0] == pytest.approx(0.3)
    assert graph.within(np.array([0.0, 0.29]), 0.3).tolist() == [3, 0]
