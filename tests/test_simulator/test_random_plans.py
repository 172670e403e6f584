"""What holds of every run, in rooms with blocks anywhere at any angle."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from dataset import problems, write_map
from scenes.apartment import Apartment, Block
from scenes.passages import free_region
from scenes.solids import obstacles
from simulator import RobotSpec, SensorSpec, random_start, simulate

from .plans import box_room

RADIUS = RobotSpec().radius
LEEWAY = 0.03
"""The robot's map may be wrong by that, m."""


@st.composite
def rooms(draw: st.DrawFn) -> Apartment:
    """A room of a few square metres with up to five blocks, none near the start."""
    width, depth = draw(st.floats(1.5, 2.6)), draw(st.floats(1.3, 2.2))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    blocks = []
    for _ in range(draw(st.integers(0, 5))):
        size, turn = rng.uniform(0.04, 0.5, 2), rng.uniform(0.0, np.pi)
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * size / 2.0
        c, s = np.cos(turn), np.sin(turn)
        middle = rng.uniform([0.3, 0.3], [width - 0.3, depth - 0.3])
        corners = corners @ np.array([[c, s], [-s, c]]) + middle
        if shapely.Polygon(corners).distance(shapely.Point(0.3, 0.3)) > RADIUS + 0.05:
            blocks.append(Block(polygon=tuple(map(tuple, corners.tolist())), top=0.5))
    room = box_room(width, depth, start=(0.3, 0.3))
    return room.model_copy(update={"blocks": tuple(blocks)})


@settings(deadline=None, max_examples=8)
@given(rooms(), st.integers(0, 2**32 - 1))
def test_every_run(tmp_path_factory, room, seed):
    start = random_start(room, RobotSpec(), np.random.default_rng(seed))
    topomap = simulate(room, seed=seed, start=start)
    nodes, visits, solid = topomap.nodes, topomap.visits, obstacles(room)

    track = shapely.points(topomap.path.true_pose[:, :2])
    assert shapely.distance(solid, track).min() > RADIUS - 1e-3
    np.testing.assert_array_equal(np.unique(visits.node), np.arange(len(nodes)))
    assert (np.diff(visits.time) >= 0.0).all()
    _, first = np.unique(visits.node, return_index=True)
    assert (np.diff(first) > 0).all(), "nodes are numbered as they are made"
    graph = csr_array((np.ones(len(topomap.edges)), topomap.edges.T), shape=(len(nodes),) * 2)
    assert connected_components(graph, directed=False)[0] == 1

    path = tmp_path_factory.mktemp("run") / "map.h5"
    write_map(path, topomap)
    assert list(problems(path)) == []

    region = free_region(room, RADIUS - LEEWAY)
    shapely.prepare(region)
    position = nodes.true_pose[:, :2]
    for a, b in position[topomap.edges]:
        if not shapely.covers(region, shapely.LineString([a, b])):
            assert detour(region, a, b) < 1.5 * np.hypot(*(a - b)) + 0.05


def detour(region: shapely.Geometry, a: np.ndarray, b: np.ndarray, cell: float = 0.01) -> float:
    """Length of the shortest way between two points in a region, m, on a grid of 1 cm."""
    low = np.minimum(a, b) - 0.3
    nx, ny = np.ceil((np.maximum(a, b) + 0.3 - low) / cell).astype(int)
    x, y = np.indices((nx, ny)) * cell + low[:, None, None] + cell / 2.0
    # The end points may stand on the very limit.
    free = shapely.contains_xy(region, x, y)
    for end in (a, b):
        free |= np.hypot(x - end[0], y - end[1]) < 0.02
    index = np.arange(nx * ny).reshape(nx, ny)
    rows, columns, lengths = [], [], []
    whole, head, tail = np.s_[:], np.s_[:-1], np.s_[1:]
    for here, there, length in (
        ((whole, head), (whole, tail), 1.0),
        ((head, whole), (tail, whole), 1.0),
        ((head, head), (tail, tail), np.sqrt(2.0)),
        ((tail, head), (head, tail), np.sqrt(2.0)),
    ):
        both = free[here] & free[there]
        rows.append(index[here][both])
        columns.append(index[there][both])
        lengths.append(np.full(both.sum(), length * cell))
    joined = np.concatenate(rows), np.concatenate(columns)
    graph = csr_array((np.concatenate(lengths), joined), shape=(nx * ny, nx * ny))
    begin, end = (index[tuple(((p - low) / cell).astype(int))] for p in (a, b))
    return float(dijkstra(graph, directed=False, indices=begin)[end])


@settings(deadline=None, max_examples=5)
@given(rooms(), st.integers(0, 2**32 - 1))
def test_without_errors_every_point_lies_on_a_surface(room, seed):
    robot = RobotSpec(
        slip_bias=0.0, slip_noise=0.0, correction_position_noise=0.0, correction_heading_noise=0.0
    )
    sensor = SensorSpec(
        range_noise=0.0, range_noise_quadratic=0.0, range_noise_slant=0.0, false_rate=0.0
    )
    topomap = simulate(room, seed=seed, robot=robot, sensor=sensor)
    points = topomap.obstacles
    assume(len(points.position) > 0)
    surface = obstacles(room, low=sensor.height, high=sensor.height + 1e-6).boundary
    away = shapely.distance(surface, shapely.points(points.position))
    assert away.max() < 2e-3
    row = np.searchsorted(topomap.path.time, points.time - 1e-9)
    ranges = np.hypot(*(points.position - topomap.path.estimate[row, :2]).T)
    assert ranges.max() <= sensor.maximum_range + 1e-9


def test_the_way_around_is_found():
    """The oracle itself: along an L, and none where a wall is."""
    shape = shapely.box(0.0, 0.0, 0.3, 0.3).difference(shapely.box(0.1, 0.1, 0.3, 0.3))
    a, b = np.array([0.05, 0.25]), np.array([0.25, 0.05])
    assert detour(shape, a, b) == pytest.approx(0.2 + 0.2 - 0.06, abs=0.03)
    assert detour(shape.difference(shapely.box(0.1, 0.0, 0.15, 0.3)), a, b) == np.inf
