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

import numpy as np
from numpy.typing import NDArray

from simulator.graph import MapGraph
from simulator.gridcells import CELL, Covered, Discs
from simulator.gridmap import GridMap
from simulator.outlook import Outlook
from simulator.robot import RobotSpec
from simulator.trigonometry import sine_cosine

__all__ = ["Entrance", "Frontier", "find_frontiers", "free_run", "outlook", "propose_entrance"]

Floats = NDArray[np.float64]

_STEP = 0.05
"""Spacing of the places that are looked at along a free run, m."""
_BESIDE = 0.05
"""So much more than the lane spacing from a node, m, a cell is still beside it."""
_TRIED = 0.1
"""So far around a place that was tried nothing else is tried, m."""
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


def outlook(spec: RobotSpec, clearance: float) -> Outlook:
    """For `find_frontiers` with a ``clearance``, m."""
    far = max(spec.cover_radius + spec.frontier_depth, spec.lane_spacing + _BESIDE) + CELL
    return Outlook(clearance, spec.cover_radius, far)


def find_frontiers(
    grid: GridMap, nodes: Floats, tried: Floats, spec: RobotSpec, view: Outlook
) -> list[Frontier]:
    """Uncovered components worth a part, as seen from the nodes (n, 2), m.

    What is within 0.1 m of a place in ``tried`` (t, 2), m, is left out. ``view`` keeps
    what it saw for the next time.
    """
    cells, component, node = view.look(grid, nodes, Covered(tried, _TRIED))
    near = np.flatnonzero(node >= 0)
    x, y = (grid.centres(cells[near]) - nodes[node[near]]).T
    away = np.full(len(cells), np.inf)
    away[near] = np.sqrt(x * x + y * y)
    deep = np.bincount(component, away >= spec.cover_radius + spec.frontier_depth) > 0
    worth = deep & (np.bincount(component) * CELL**2 >= spec.frontier_area)
    beside = near[(away[near] <= spec.lane_spacing + _BESIDE) & worth[component[near]]]
    beside = beside[np.argsort(component[beside], kind="stable")]
    parts = np.split(beside, np.flatnonzero(np.diff(component[beside])) + 1)
    return [
        Frontier(grid.centres(cells[mine]), node[mine], away[mine]) for mine in parts if len(mine)
    ]


def free_run(
    grid: GridMap,
    covered: Discs,
    points: Floats,
    heading: float,
    clearance: float,
) -> Floats:
    """How far the centre may go from each point along a heading, uncovered and seen.

    Parameters
    ----------
    covered : Discs
        Of radius 0: all is uncovered.
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
    points = np.ascontiguousarray(points)
    return grid.free_steps(points, offsets, clearance, covered) * _STEP


def propose_entrance(
    grid: GridMap,
    graph: MapGraph,
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
    nodes, covered = graph.position, Discs(graph.table(), spec.overlap_radius)
    order = np.argsort(np.abs(frontier.distance - spec.lane_spacing), kind="stable")
    order = order[:: max(1, len(order) // 60)][:60]
    points, node = frontier.points[order], frontier.node[order]
    reach = [grid.is_clear(nodes[k], p, clearance) for k, p in zip(node, points, strict=True)]
    points, node = points[reach], node[reach]
    if len(points) == 0:
        return None
    headings = axis + 0.5 * np.pi * np.arange(4)
    runs = np.stack([free_run(grid, covered, points, h, clearance) for h in headings], axis=1)
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
