"""Passageway width on corridors made by hand, and against brute force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cleaned_flat import cleaned_flat
from sklearn.cluster import DBSCAN

from dataset.topomap import Nodes, Obstacles, TopoMap, Visits
from roomseg.passage_width import (
    LocalObstacles,
    WidthParameters,
    passageway_widths,
    search_strips,
)
from roomseg.preprocessing import preprocess

PAPER = WidthParameters()


def lane_map(obstacles, times=None, nodes: int = 11, spacing: float = 0.1) -> TopoMap:
    """One lane along x through the origin, one node per second."""
    obstacles = np.asarray(obstacles, dtype=float).reshape(-1, 2)
    times = np.full(len(obstacles), 5.0) if times is None else times
    position = np.stack([np.arange(nodes) * spacing, np.zeros(nodes)], axis=1)
    return TopoMap(
        environment="test",
        run="run1",
        seed=1,
        created="2026-01-01",
        software="test",
        nodes=Nodes(position, np.zeros(nodes), np.zeros(nodes), np.zeros(nodes)),
        edges=np.stack([np.arange(nodes - 1), np.arange(1, nodes)], axis=1),
        visits=Visits(np.arange(nodes), np.arange(nodes) * 1.0),
        obstacles=Obstacles(obstacles, times, np.zeros(len(obstacles))),
    )


def wall(y: float, begin: float = -0.5, end: float = 1.5, step: float = 0.02) -> np.ndarray:
    x = np.arange(begin, end, step)
    return np.stack([x, np.full_like(x, y)], axis=1)


def test_corridor_width() -> None:
    topomap = lane_map(np.vstack([wall(0.4), wall(-0.6)]))
    assert passageway_widths(topomap, topomap.edges) == pytest.approx(np.ones(10), abs=6e-3)


def test_rotated_and_reversed_edges_measure_the_same() -> None:
    topomap = lane_map(np.vstack([wall(0.4), wall(-0.6)]))
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    turned = replace(
        topomap,
        nodes=replace(topomap.nodes, position=topomap.nodes.position[::-1] @ turn.T),
        obstacles=replace(topomap.obstacles, position=topomap.obstacles.position @ turn.T),
    )
    assert passageway_widths(turned, turned.edges) == pytest.approx(np.ones(10), abs=6e-3)


def test_doorway_is_narrow_only_near_the_posts() -> None:
    posts = [wall(side, 0.45, 0.56, 0.01) for side in (0.35, -0.35)]
    topomap = lane_map(np.vstack([*posts, wall(1.5), wall(-1.5)]))
    width = passageway_widths(topomap, topomap.edges)
    # The strip ends 6 cm + 5 cm beyond either node.
    assert width[3:7] == pytest.approx(np.full(4, 0.7), abs=0.02)
    assert width[0] == pytest.approx(3.0, abs=0.01)
    assert width[9] == pytest.approx(3.0, abs=0.01)


@pytest.mark.parametrize(("strays", "expected"), [(2, 1.0), (3, 0.6)])
def test_clusters_below_three_points_are_false_measurements(strays: int, expected: float) -> None:
    stray = np.array([[0.50, 0.20], [0.51, 0.21], [0.49, 0.21]])[:strays]
    topomap = lane_map(np.vstack([wall(0.6), wall(-0.4), stray]))
    assert passageway_widths(topomap, topomap.edges)[5] == pytest.approx(expected, abs=0.03)


def test_default_where_one_side_is_open() -> None:
    topomap = lane_map(wall(0.4))
    assert (passageway_widths(topomap, topomap.edges) == 5.0).all()
    assert (passageway_widths(lane_map([]), topomap.edges) == 5.0).all()


def test_zero_length_edge_gets_the_default() -> None:
    topomap = lane_map(np.vstack([wall(0.4), wall(-0.4)]), spacing=0.0)
    assert (passageway_widths(topomap, topomap.edges) == 5.0).all()


def test_points_of_other_times_do_not_count() -> None:
    both = np.vstack([wall(0.4), wall(-0.4)])
    # Node k + 4 at k + 4 s is the last within 0.5 m of node k, and counts for 7 s, exclusively.
    late = lane_map(both, np.full(len(both), 14.0))
    width = passageway_widths(late, late.edges)
    assert (width[:3] == 5.0).all()
    assert (width[3:] < 1.0).all()


def test_near_points_by_definition() -> None:
    """Eqs. A1 and A2, node by node and point by point."""
    topomap = cleaned_flat()
    local = LocalObstacles.of(topomap, PAPER)
    position, part = topomap.nodes.position, topomap.nodes.part
    for k in range(0, len(position), 17):
        near = (np.linalg.norm(position - position[k], axis=1) < 0.5) & (part == part[k])
        times = topomap.visits.time[near[topomap.visits.node]]
        gap = np.abs(topomap.obstacles.time[:, None] - times[None, :])
        expected = topomap.obstacles.position[(gap < 7.0).any(axis=1)]
        assert sorted(local.near(k).tolist()) == sorted(expected.tolist())


def brute_force_width(topomap: TopoMap, local: LocalObstacles, k: int, m: int, strip) -> float:
    """§2.2.2 with DBSCAN over all near points, point by point."""
    points = local.near(k, m)
    a, b = topomap.nodes.position[[k, m]]
    if not len(points):
        return 5.0
    clustered = DBSCAN(eps=0.1, min_samples=3).fit(points).labels_ >= 0
    ahead = (b - a) / np.linalg.norm(b - a)
    best = {True: (np.inf, None), False: (np.inf, None)}
    for point in points[clustered]:
        along = (point - (a + b) / 2) @ ahead
        if strip[0] <= along <= strip[1]:
            nearest = a + np.clip((point - a) @ ahead, 0, np.linalg.norm(b - a)) * ahead
            distance = np.linalg.norm(point - nearest)
            left = bool(ahead[0] * (point - a)[1] - ahead[1] * (point - a)[0] > 0)
            if distance < best[left][0]:
                best[left] = (distance, point)
    if best[True][1] is None or best[False][1] is None:
        return 5.0
    return float(np.linalg.norm(best[True][1] - best[False][1]))


def test_widths_against_brute_force() -> None:
    topomap = cleaned_flat()
    edges = preprocess(topomap).edges[::25]
    parameters = WidthParameters(time_distance=60.0)  # its points come in random order
    local = LocalObstacles.of(topomap, parameters)
    strips = search_strips(topomap.nodes, edges, topomap.robot_radius, PAPER)
    expected = [
        brute_force_width(topomap, local, k, m, strip)
        for (k, m), strip in zip(edges, strips, strict=True)
    ]
    width = passageway_widths(topomap, edges, parameters)
    assert width == pytest.approx(expected)
    assert 0.1 < (width == 5.0).mean() < 0.9  # both branches are reached


def test_search_strip_by_hand() -> None:
    nodes = lane_map([]).nodes
    edges = np.array([[0, 1], [1, 2], [2, 3], [4, 5], [8, 9], [9, 10], [0, 3], [3, 5]])
    strips = search_strips(nodes, edges, 0.15, PAPER)
    half = (0.10 + 0.15 - 0.03) / 2
    # At the lane's ends the strip already ends beyond the lane: nothing is added there.
    # The next edge's strip ends 4 cm before the end of the lane.
    assert strips[0] == pytest.approx([-half, half + 0.05, 0.05])
    assert strips[1] == pytest.approx([-half - 0.04, half + 0.05, 0.05])
    assert strips[2] == pytest.approx([-half - 0.05, half + 0.05, 0.05])
    assert strips[3] == pytest.approx([-half - 0.05, half + 0.05, 0.05])
    assert strips[4] == pytest.approx([-half - 0.05, half + 0.04, 0.05])
    assert strips[5] == pytest.approx([-half - 0.05, half, 0.05])
    assert strips[6] == pytest.approx([-0.21, 0.21, 0.15])  # not short
    assert strips[7] == pytest.approx([-0.16, 0.16, 0.10])  # neither short nor subsequent


@pytest.mark.parametrize(("reading", "reach"), [("whole", 0.21), ("node", 0.27), ("middle", 0.42)])
def test_readings_of_the_width(reading: str, reach: float) -> None:
    nodes, parameters = lane_map([]).nodes, WidthParameters(reading=reading)
    strips = search_strips(nodes, np.array([[0, 3]]), 0.15, parameters)
    assert strips[0] == pytest.approx([-reach, reach, 0.15])


def test_short_edges_between_lanes_are_not_extended() -> None:
    topomap = lane_map([])
    lanes = np.repeat([0, 1], [6, 5])
    strips = search_strips(replace(topomap.nodes, lane=lanes), np.array([[5, 6]]), 0.15, PAPER)
    assert strips[0] == pytest.approx([-0.11, 0.11, 0.05])
