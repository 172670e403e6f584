"""The growing map: visits, shortest paths, forgotten nodes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from simulator.graph import MapGraph, distance_at, is_near


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


@pytest.mark.parametrize("seed", range(3))
def test_nodes_are_found_as_by_a_tree(seed):
    """While the table grows, and nodes far apart share its buckets."""
    rng = np.random.default_rng(seed)
    graph = MapGraph()
    for count in (100, 300, 1100):
        while len(graph) < count:
            graph.add_node(rng.uniform(-5.0, 5.0, 3), np.zeros(3), 0, 0, 0.0)
        graph.remove_from(count - 40)
        tree = cKDTree(graph.position)
        points = rng.uniform(-6.0, 6.0, (50, 2))
        np.testing.assert_allclose(
            graph.distances(points), tree.query(points, distance_upper_bound=1.0)[0], atol=1e-12
        )
        for point in points:
            away = np.hypot(*(graph.position - point).T)
            near = graph.within(point, 0.7)
            assert sorted(near) == sorted(tree.query_ball_point(point, 0.7))
            assert (np.diff(away[near]) >= 0.0).all()
            for limit in (0.15, 0.5):
                right = away.min() if away.min() <= limit else np.inf
                found = distance_at(graph.table(), point[0], point[1], limit)
                assert found == pytest.approx(right)
                assert is_near(graph.table(), point[0], point[1], limit) == np.isfinite(right)


def test_whether_an_edge_joins_a_lane_to_older_nodes():
    graph = chain(6)
    assert graph.joins(4)
    for node in (6, 7, 8):
        graph.add_node(np.array([0.1 * node, 0.5, 0.0]), np.zeros(3), 0, 1, 9.0)
    graph.add_edge(6, 7)
    graph.add_edge(7, 8)
    assert not graph.joins(6)
    graph.add_edge(2, 7)
    assert graph.joins(6)
    graph.remove_from(6)
    assert len(graph.edges) == 5


def test_distances_leave_out_a_lane():
    graph = chain(3)
    graph.add_node(np.array([0.0, 0.3, 0.0]), np.zeros(3), 0, 7, 9.0)
    points = np.array([[0.0, 0.3]])
    assert graph.distances(points)[0] == 0.0
    assert graph.distances(points, running_lane=7)[0] == pytest.approx(0.3)
    assert graph.within(np.array([0.0, 0.29]), 0.3).tolist() == [3, 0]
