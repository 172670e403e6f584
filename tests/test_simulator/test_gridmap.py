"""The robot's own grid: what it believes from beams, contacts and its body."""

from __future__ import annotations

import numpy as np
import pytest

from simulator import gridcells
from simulator.gridmap import CELL, GridMap

ALONG = np.arange(-0.2, 0.21, 0.04)


def add_body(grid, pose):
    grid.hold(pose, 1.0)
    gridcells.stand(grid.table, pose, 0.15)


def add_scan(grid, pose, angle, distance):
    """One beam; ``nan``: without a spot, free for 0.6 m."""
    grid.hold(pose, 5.0)
    angles, ranges = np.array([angle]), np.array([distance])
    gridcells.pass_beams(grid.table, pose, angles, ranges, 0.6)
    gridcells.hit(grid.table, pose, angles, ranges)


def scan_of_wall(grid, wall_x=0.7, ys=ALONG):
    """Drive along a wall at x = wall_x; one beam looks at it."""
    for y in ys:
        pose = np.array([0.0, y, 0.0])
        add_body(grid, pose)
        add_scan(grid, pose, 0.0, wall_x)


def blocked_points(grid):
    return grid.centres(np.argwhere(grid.blocked()))


def test_a_wall_is_blocked_and_the_way_to_it_seen_and_clear():
    grid = GridMap(np.zeros(2))
    scan_of_wall(grid)
    blocked = blocked_points(grid)
    assert len(blocked) >= 8
    assert np.abs(blocked[:, 0] - 0.7).max() <= CELL
    assert grid.is_seen(np.array([[0.4, 0.0], [0.9, 0.0]])).tolist() == [True, False]
    assert grid.is_open(np.array([[0.4, 0.0], [0.62, 0.0]]), 0.15).tolist() == [True, False]
    assert not grid.is_clear(np.array([0.3, 0.0]), np.array([1.1, 0.0]), 0.1)
    assert grid.is_clear(np.array([0.3, -0.2]), np.array([0.3, 0.2]), 0.15)


def test_clearance_is_the_distance_to_the_wall():
    grid = GridMap(np.zeros(2))
    scan_of_wall(grid)
    assert grid.clearance(np.array([[0.5, 0.0]]))[0] == pytest.approx(0.2, abs=CELL)
    assert grid.clearance(np.array([[0.0, 0.0]]), limit=0.3)[0] == 0.3


def test_a_single_false_point_is_not_an_obstacle():
    grid = GridMap(np.zeros(2))
    pose = np.zeros(3)
    add_body(grid, pose)
    add_scan(grid, pose, 0.0, 0.5)
    assert not grid.blocked().any()
    gridcells.feel(grid.table, pose, 0.0, 0.15)
    assert grid.blocked().any()


def test_beams_that_pass_clear_what_is_gone():
    grid = GridMap(np.zeros(2))
    scan_of_wall(grid, 0.4, np.zeros(3))
    assert grid.blocked().any()
    for _ in range(10):
        add_scan(grid, np.zeros(3), 0.0, 0.9)
    assert (blocked_points(grid)[:, 0] > 0.8).all()


def test_a_beam_without_spot_is_free_only_so_far():
    grid = GridMap(np.zeros(2))
    add_body(grid, np.zeros(3))
    add_scan(grid, np.zeros(3), 0.0, np.nan)
    assert grid.is_seen(np.array([[0.55, 0.0], [0.65, 0.0]])).tolist() == [True, False]


def test_the_grid_grows_and_keeps_what_it_knows():
    grid = GridMap(np.zeros(2))
    scan_of_wall(grid)
    before = blocked_points(grid)
    for pose in ([9.0, 0.0, 0.0], [-7.0, -8.0, 0.0]):
        add_body(grid, np.array(pose))
    after = blocked_points(grid)
    np.testing.assert_allclose(after, before, atol=1e-9)
    assert grid.is_seen(np.array([[9.0, 0.0], [-7.0, -8.0], [200.0, 0.0]])).tolist() == [1, 1, 0]


def test_room_agrees_with_clearance():
    grid = GridMap(np.zeros(2))
    scan_of_wall(grid)
    room = grid.room()
    points = np.random.default_rng(0).uniform([0.45, -0.2], [0.65, 0.2], (50, 2))
    x, y = grid.cells(points).T
    np.testing.assert_allclose(grid.clearance(points), room[x, y], atol=1.5 * CELL)


def test_a_long_beam_is_marked_where_it_ends():
    grid = GridMap(np.zeros(2))
    add_body(grid, np.zeros(3))
    for distance in (3.3, 3.31):
        add_scan(grid, np.zeros(3), np.pi, distance)
    assert grid.clearance(np.array([[-3.3, 0.0]]))[0] < 0.05
    assert grid.is_seen(np.array([[-2.5, 0.0]]))[0]
    assert grid.clearance(np.array([[3.3, 0.0], [3.1, 0.0]])).min() == 0.3


def test_floor_between_near_beams_counts_as_seen():
    """Beams 10 cm apart; there is nothing between those 30 cm apart."""
    grid = GridMap(np.zeros(2))
    for y in (0.0, 0.1, 0.4):
        add_scan(grid, np.array([0.0, y, 0.0]), 0.0, np.nan)
    between = np.array([[0.3, 0.05], [0.3, 0.25], [0.8, 0.05]])
    assert grid.is_seen(between).tolist() == [False, False, False]
    grid.bridge_seen(0.1)
    assert grid.is_seen(between).tolist() == [True, False, False]
