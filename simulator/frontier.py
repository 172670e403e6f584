"""Where the map ends: uncovered places beside the covered area (§2.1).

The paper: a new part begins with a lane along the boundary of the previously
covered area; a piercing lane leads through a narrow passage. It does not say
how either is found. Here: the uncovered cells of the robot's own grid that its
centre may stand in fall into connected components; each is entered from a
node beside it, the outward axis being the part's own axis or its normal,
whichever points there. The room for the centre across the outward axis is the
width of the entrance: below ``piercing_width`` the lane pierces outward,
otherwise it follows the boundary.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from simulator.gridcells import CELL, Covered
from simulator.gridmap import GridMap
from simulator.robot import RobotSpec
from simulator.trigonometry import sine_cosine

__all__ = ["Entrance", "Frontier", "find_frontiers", "free_run", "propose_entrance"]

Floats = NDArray[np.float64]

_STEP = 0.05
"""Spacing of the places that are looked at along a free run, m."""
_BESIDE = 0.05
"""So much more than the lane spacing from a node, m, a cell is still beside it."""
_RUN_LIMIT = 4.0
"""No run is looked at further than this, m."""


@dataclass(frozen=True)
class Frontier:
    """An uncovered component: its cells beside nodes (m, 2), nearest node of each, distance."""

    points: Floats
    node: NDArray[np.int64]
    distance: Floats


@dataclass(frozen=True)
class Entrance:
    """How to begin a new part.

    ``node``: where the map is left; ``point``: where the lane is entered;
    ``heading``: of the lane's way out to its nearer end (or of the piercing lane).
    """

    node: int
    point: Floats
    heading: float
    piercing: bool


def find_frontiers(
    grid: GridMap, nodes: Floats, tried: Floats, spec: RobotSpec, clearance: float
) -> list[Frontier]:
    """Uncovered components worth a part, as seen from the nodes (n, 2), m.

    What is within 0.1 m of a place in ``tried`` (t, 2), m, is left out; the
    centre needs ``clearance`` m to known obstacles.
    """
    mask = grid.open_cells(clearance)
    grid.erase(mask, Covered(np.ascontiguousarray(nodes), spec.cover_radius))
    grid.erase(mask, Covered(tried, 0.1))
    found = cv2.findNonZero(mask)
    if found is None:
        return []
    cells = found[:, 0, ::-1].astype(np.int64)
    column, row, width, height = cv2.boundingRect(found)
    part = np.ascontiguousarray(mask[row : row + height, column : column + width])
    count, labels = cv2.connectedComponents(part, connectivity=4)
    points = grid.centres(cells)
    label = labels[cells[:, 0] - row, cells[:, 1] - column]
    far = max(spec.cover_radius + spec.frontier_depth, spec.lane_spacing + _BESIDE) + CELL
    tree = cKDTree(nodes, balanced_tree=False, compact_nodes=False)
    deep, node = tree.query(points, distance_upper_bound=far)
    area = np.bincount(label, minlength=count) * CELL**2
    depth = np.zeros(count)
    np.maximum.at(depth, label, deep)
    worth = (area >= spec.frontier_area) & (depth >= spec.cover_radius + spec.frontier_depth)
    beside = np.flatnonzero(deep <= spec.lane_spacing + _BESIDE)
    frontiers = []
    for k in np.flatnonzero(worth):
        mine = beside[label[beside] == k]
        if len(mine):
            frontiers.append(Frontier(points[mine], node[mine], deep[mine]))
    return frontiers


def free_run(
    grid: GridMap,
    nodes: Floats,
    points: Floats,
    heading: float,
    *,
    spec: RobotSpec,
    clearance: float,
) -> Floats:
    """How far the centre may go from each point along a heading, uncovered and seen.

    Parameters
    ----------
    nodes : array, shape (n, 2)
        What covers the floor, m; n = 0 leaves all uncovered.
    points : array, shape (m, 2)
        m.
    heading : float
        rad.
    clearance : float
        That the centre needs to known obstacles, m.

    Returns
    -------
    array, shape (m,)
        m, in steps of 5 cm, at most 4 m.
    """
    steps = np.arange(1, round(_RUN_LIMIT / _STEP) + 1)[:, None] * _STEP
    sine, cosine = sine_cosine(heading)
    offsets = steps * np.array([cosine, sine])
    covered = Covered(np.ascontiguousarray(nodes), spec.overlap_radius)
    return grid.free_steps(np.ascontiguousarray(points), offsets, clearance, covered) * _STEP


def propose_entrance(
    grid: GridMap,
    nodes: Floats,
    frontier: Frontier,
    axis: float,
    *,
    spec: RobotSpec,
    clearance: float,
) -> Entrance | None:
    """The best way into one frontier, or None if none can be driven.

    Parameters
    ----------
    axis : float
        Lane heading of the neighbouring part, rad.
    """
    order = np.argsort(np.abs(frontier.distance - spec.lane_spacing), kind="stable")
    order = order[:: max(1, len(order) // 60)][:60]
    points, node = frontier.points[order], frontier.node[order]
    reach = [grid.is_clear(nodes[k], p, clearance) for k, p in zip(node, points, strict=True)]
    points, node = points[reach], node[reach]
    if len(points) == 0:
        return None
    headings = axis + 0.5 * np.pi * np.arange(4)
    runs = np.stack(
        [free_run(grid, nodes, points, h, spec=spec, clearance=clearance) for h in headings], axis=1
    )
    units = np.array([sine_cosine(heading) for heading in headings.tolist()])[:, ::-1]
    outward = ((points - nodes[node])[:, None] * units).sum(axis=2).argmax(axis=1)
    rows = np.arange(len(points))
    left, right = runs[rows, (outward + 1) % 4], runs[rows, (outward + 3) % 4]
    width = left + right
    if width.max() >= spec.piercing_width:
        # The longest lane, but at the lane spacing first of all.
        off = np.round(np.abs(frontier.distance[order][reach] - spec.lane_spacing), 2)
        wide = width >= spec.piercing_width
        best = int(np.lexsort((-width, np.maximum(off, 0.02), ~wide))[0])
        nearer = 1 if left[best] <= right[best] else 3
        heading = headings[(outward[best] + nearer) % 4]
        return Entrance(int(node[best]), points[best], float(heading), piercing=False)
    best = int(runs[rows, outward].argmax())
    return Entrance(int(node[best]), points[best], float(headings[outward[best]]), piercing=True)
