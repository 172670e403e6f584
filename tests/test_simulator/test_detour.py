"""Ways on the local grid."""

from __future__ import annotations

import numpy as np

from simulator import gridcells
from simulator.detour import plan_detour
from simulator.gridmap import GridMap


def grid_with_post():
    """Everything within 1 m seen; a post at the origin."""
    grid = GridMap(np.zeros(2))
    centres = np.stack(np.indices(grid.seen.shape), axis=-1)
    points = grid.centres(centres.reshape(-1, 2)).reshape(centres.shape)
    grid.seen[:] = np.abs(points).max(axis=-1) < 1.0
    for angle in np.linspace(0, 2 * np.pi, 24, endpoint=False):
        gridcells.feel(grid.table, np.zeros(3), angle, 0.05)
    return grid


def test_the_way_keeps_its_distance_and_arrives():
    grid = grid_with_post()
    start, goal = np.array([-0.6, 0.01]), np.array([0.6, 0.0])
    way = plan_detour(grid, start, goal, 0.15)
    np.testing.assert_array_equal(way[-1], goal)
    assert grid.clearance(way).min() >= 0.14
    steps = np.diff(np.vstack([start, way]), axis=0)
    length = np.hypot(steps[:, 0], steps[:, 1]).sum()
    assert 1.2 < length < 1.9


def test_no_way_into_the_unseen_or_the_blocked():
    grid = grid_with_post()
    assert len(plan_detour(grid, np.array([-0.6, 0.0]), np.array([1.5, 0.0]), 0.15)) == 0
    assert len(plan_detour(grid, np.array([-0.6, 0.0]), np.array([0.0, 0.0]), 0.15)) == 0
