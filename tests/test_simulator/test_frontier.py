"""Uncovered components, against other libraries that look at the whole grid."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage
from scipy.spatial import cKDTree

from simulator.frontier import find_frontiers, outlook
from simulator.gridcells import CELL
from simulator.gridmap import GridMap
from simulator.robot import RobotSpec

from .machines import seen_square

SPEC = RobotSpec()
CLEARANCE = SPEC.radius - SPEC.caution
NOTHING = np.zeros((0, 2))


def expected(grid, nodes):
    """Cells beside nodes of every component that is large and deep enough."""
    away = ndimage.distance_transform_edt(~grid.blocked()) * CELL
    mask = grid.seen & (away >= CLEARANCE)
    indices = np.argwhere(mask)
    gap, node = cKDTree(nodes).query(grid.centres(indices))
    mask[tuple(indices[gap <= SPEC.cover_radius].T)] = False
    labels, count = ndimage.label(mask)
    left = gap > SPEC.cover_radius
    indices, gap, node = indices[left], gap[left], node[left]
    label = labels[tuple(indices.T)]
    for k in range(1, count + 1):
        mine = label == k
        deep = gap[mine].max() >= SPEC.cover_radius + SPEC.frontier_depth
        beside = mine & (gap <= SPEC.lane_spacing + 0.05)
        if mine.sum() * CELL**2 >= SPEC.frontier_area and deep and beside.any():
            yield grid.centres(indices[beside]), node[beside], gap[beside]


@pytest.mark.parametrize("seed", range(4))
def test_frontiers_are_the_components_that_are_large_and_deep(seed):
    rng = np.random.default_rng(seed)
    grid, view = GridMap(np.zeros(2)), outlook(SPEC, CLEARANCE)
    nodes, counts = [np.zeros(2)], set()
    for _ in range(6):
        seen_square(grid, rng.uniform(-2.0, 2.0, 2), rng.uniform(0.1, 0.6))
        x = nodes[-1][0] + 0.1 * np.arange(1, 9)
        nodes.extend(np.stack([x, np.full(8, rng.uniform(-1.0, 1.0))], axis=1))
        found = find_frontiers(grid, np.array(nodes), NOTHING, SPEC, view)
        right = list(expected(grid, np.array(nodes)))
        assert len(found) == len(right)
        for frontier, (points, node, distance) in zip(found, right, strict=True):
            np.testing.assert_allclose(frontier.points, points)
            np.testing.assert_array_equal(frontier.node, node)
            np.testing.assert_allclose(frontier.distance, distance)
        counts.add(len(found))
    assert len(counts) > 1


def test_what_was_tried_is_no_frontier():
    grid, view = GridMap(np.zeros(2)), outlook(SPEC, CLEARANCE)
    seen_square(grid, np.zeros(2), 0.5)
    nodes = np.array([[-0.5, 0.0]])
    (frontier,) = find_frontiers(grid, nodes, NOTHING, SPEC, view)
    assert find_frontiers(grid, nodes, frontier.points, SPEC, view) == []
    assert len(find_frontiers(grid, nodes, NOTHING, SPEC, view)) == 1
