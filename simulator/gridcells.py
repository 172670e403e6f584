"""The loops over the cells of the robot's local grid, as machine code.

`simulator.gridmap` says what they are about. Points and poses are in m and rad.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import compiled
from simulator.graph import Table, is_near
from simulator.trigonometry import sine_cosine

__all__ = [
    "BLOCKED",
    "CELL",
    "CONTACT",
    "HIGH",
    "HIT",
    "LOW",
    "SUPPORT",
    "TILE",
    "Cells",
    "Covered",
    "Discs",
    "are_clear",
    "clearances",
    "components",
    "erase",
    "feel",
    "free_steps",
    "hit",
    "holds",
    "is_blocked_ahead",
    "is_clear",
    "keep_nearest",
    "open_again",
    "pass_beams",
    "stand",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

CELL = 0.025
"""m."""

HIT, PASS = 2, 1
"""What a laser point adds to a cell's evidence, and a beam that passes takes from it."""
CONTACT = 100
"""Evidence of a contact. Beams do not lessen it: what was felt may be below or above them."""
LOW, HIGH, BLOCKED = -2, 8, 2
"""Limits of the evidence, and from where on a cell may count as an obstacle."""
SHY = 0.06
"""A beam says nothing about the last 6 cm before its end: noise, slanted walls."""
RIM = 0.03
"""The rim of the body's disc says nothing: what it touches is an obstacle, m."""
TILE = 32
"""Cells of a side of a tile; the grid is made of whole ones."""
SUPPORT = 3
"""A second point must support the first, at most so many cells away either way."""


class Cells(NamedTuple):
    """The grid.

    ``evidence`` (nx, ny) for and against an obstacle in a cell; ``seen`` (nx, ny): passed by a
    beam or the body; ``corner`` (2,) m: the outer corner of cell (0, 0).
    """

    evidence: NDArray[np.int8]
    seen: NDArray[np.bool_]
    corner: Floats


class Covered(NamedTuple):
    """Discs of ``radius`` m around points (n, 2) m."""

    points: Floats
    radius: float


class Discs(NamedTuple):
    """Discs of ``radius`` m around the map's nodes."""

    nodes: Table
    radius: float


@compiled
def cell_at(cells: Cells, x: float, y: float) -> tuple[int, int]:
    """Indices of the cell that a point lies in; they may be off the grid."""
    i = math.floor((x - cells.corner[0]) / CELL)
    return i, math.floor((y - cells.corner[1]) / CELL)


@compiled
def offset(cells: Cells, i: int, j: int, point: Floats) -> tuple[float, float]:
    """From a point to the centre of a cell, m."""
    x = cells.corner[0] + (i + 0.5) * CELL - point[0]
    return x, cells.corner[1] + (j + 0.5) * CELL - point[1]


@compiled
def window(cells: Cells, low: Floats, high: Floats, margin: float) -> tuple[int, int, int, int]:
    """Ranges i0..i1, j0..j1 (ends excluded) of the cells that a widened box covers."""
    i0, j0 = cell_at(cells, low[0] - margin, low[1] - margin)
    i1, j1 = cell_at(cells, high[0] + margin, high[1] + margin)
    rows, columns = cells.seen.shape
    return max(i0, 0), min(i1 + 1, rows), max(j0, 0), min(j1 + 1, columns)


@compiled
def holds(cells: Cells, point: Floats, margin: float) -> bool:
    """Whether everything within ``margin`` m of a point is on the grid."""
    i0, j0 = cell_at(cells, point[0] - margin, point[1] - margin)
    i1, j1 = cell_at(cells, point[0] + margin, point[1] + margin)
    rows, columns = cells.seen.shape
    return i0 >= 0 and j0 >= 0 and i1 < rows and j1 < columns


@compiled
def pass_beams(cells: Cells, pose: Floats, angles: Floats, ranges: Floats, free: float) -> None:
    """Enter the beams' free parts: every cell on them is seen and less likely an obstacle.

    Beams without a spot (``nan``) are free for ``free`` m.
    """
    for k in range(len(angles)):
        reach = free if math.isnan(ranges[k]) else ranges[k] - SHY
        along_y, along_x = sine_cosine(angles[k])
        last = (-1, -1)
        for n in range(math.ceil(reach / CELL - 0.5)):
            length = (n + 0.5) * CELL
            i, j = cell_at(cells, pose[0] + length * along_x, pose[1] + length * along_y)
            if (i, j) != last:
                cells.seen[i, j] = True
                if cells.evidence[i, j] <= HIGH:
                    cells.evidence[i, j] = max(cells.evidence[i, j] - PASS, LOW)
                last = (i, j)


@compiled
def hit(cells: Cells, pose: Floats, angles: Floats, ranges: Floats) -> None:
    """Enter the beams' spots; ``nan``: none. What was felt stays more than what is seen."""
    for k in range(len(angles)):
        if not math.isnan(ranges[k]):
            along_y, along_x = sine_cosine(angles[k])
            x, y = pose[0] + ranges[k] * along_x, pose[1] + ranges[k] * along_y
            i, j = cell_at(cells, x, y)
            if cells.evidence[i, j] <= HIGH:
                cells.evidence[i, j] = min(max(cells.evidence[i, j], 0) + HIT, HIGH)


@compiled
def feel(cells: Cells, pose: Floats, bearing: float, radius: float) -> None:
    """Enter a contact at ``bearing`` from the heading."""
    along_y, along_x = sine_cosine(pose[2] + bearing)
    i, j = cell_at(cells, pose[0] + radius * along_x, pose[1] + radius * along_y)
    cells.evidence[i, j] = CONTACT


@compiled
def stand(cells: Cells, pose: Floats, radius: float) -> None:
    """Enter the body's disc: seen and, but for its rim, free."""
    radius -= RIM
    i0, i1, j0, j1 = window(cells, pose, pose, radius)
    for i in range(i0, i1):
        for j in range(j0, j1):
            x, y = offset(cells, i, j, pose)
            if x * x + y * y < radius * radius:
                cells.seen[i, j] = True
                cells.evidence[i, j] = LOW


@compiled
def is_blocked(evidence: NDArray[np.int8], i: int, j: int) -> bool:
    """Whether a cell counts as an obstacle; see `simulator.gridmap.GridMap.blocked`."""
    if evidence[i, j] < BLOCKED:
        return False
    around = 0
    rows, columns = evidence.shape
    for x in range(max(i - SUPPORT, 0), min(i + SUPPORT + 1, rows)):
        for y in range(max(j - SUPPORT, 0), min(j + SUPPORT + 1, columns)):
            around += max(evidence[x, y], 0)
    return around >= 2 * HIT


@compiled
def clearances(cells: Cells, points: Floats, limit: float) -> Floats:
    """See `simulator.gridmap.GridMap.clearance`."""
    found = np.full(len(points), limit)
    for k in range(len(points)):
        i0, i1, j0, j1 = window(cells, points[k], points[k], limit)
        for i in range(i0, i1):
            for j in range(j0, j1):
                if cells.evidence[i, j] >= BLOCKED:
                    x, y = offset(cells, i, j, points[k])
                    gap = math.sqrt(x * x + y * y)
                    if gap < found[k] and is_blocked(cells.evidence, i, j):
                        found[k] = gap
    return found


@compiled
def is_clear(cells: Cells, start: Floats, end: Floats, clearance: float) -> bool:
    """Whether no blocked cell is nearer than ``clearance`` m to a segment."""
    along_x, along_y = end[0] - start[0], end[1] - start[1]
    length = max(along_x * along_x + along_y * along_y, 1e-12)
    low, high = np.minimum(start, end), np.maximum(start, end)
    i0, i1, j0, j1 = window(cells, low, high, clearance + CELL)
    for i in range(i0, i1):
        for j in range(j0, j1):
            if cells.evidence[i, j] >= BLOCKED:
                x, y = offset(cells, i, j, start)
                share = min(max((x * along_x + y * along_y) / length, 0.0), 1.0)
                x, y = x - share * along_x, y - share * along_y
                near = x * x + y * y < clearance * clearance
                if near and is_blocked(cells.evidence, i, j):
                    return False
    return True


@compiled
def are_clear(cells: Cells, start: Floats, ends: Floats, clearance: float) -> Bools:
    """`is_clear` for the segments from one point to many, (k, 2)."""
    clear = np.empty(len(ends), np.bool_)
    for k in range(len(ends)):
        clear[k] = is_clear(cells, start, ends[k], clearance)
    return clear


@compiled
def is_blocked_ahead(cells: Cells, pose: Floats, distance: float, frontal: float) -> bool:
    """Whether a blocked cell lies within ``distance`` m ahead of the centre.

    Ahead is where the cosine of the bearing is above ``frontal``.
    """
    ahead_y, ahead_x = sine_cosine(pose[2])
    i0, i1, j0, j1 = window(cells, pose, pose, distance)
    for i in range(i0, i1):
        for j in range(j0, j1):
            if cells.evidence[i, j] >= BLOCKED:
                x, y = offset(cells, i, j, pose)
                gap = math.sqrt(x * x + y * y)
                near = gap < distance and x * ahead_x + y * ahead_y > frontal * gap
                if near and is_blocked(cells.evidence, i, j):
                    return True
    return False


@compiled
def is_open(cells: Cells, place: Floats, clearance: float) -> bool:
    """Whether the centre may stand at a place: seen, no blocked cell within ``clearance``."""
    i, j = cell_at(cells, place[0], place[1])
    rows, columns = cells.seen.shape
    if not (0 <= i < rows and 0 <= j < columns and cells.seen[i, j]):
        return False
    return is_clear(cells, place, place, clearance)


@compiled
def free_steps(
    cells: Cells, points: Floats, offsets: Floats, clearance: float, discs: Discs
) -> Ints:
    """See `simulator.gridmap.GridMap.free_steps`."""
    steps = np.zeros(len(points), np.int64)
    for k in range(len(points)):
        for n in range(len(offsets)):
            place = points[k] + offsets[n]
            covered = is_near(discs.nodes, place[0], place[1], discs.radius)
            if covered or not is_open(cells, place, clearance):
                break
            steps[k] = n + 1
    return steps


@compiled
def erase(mask: NDArray[np.uint8], cells: Cells, covered: Covered) -> None:
    """See `simulator.gridmap.GridMap.erase`."""
    limit = covered.radius * covered.radius
    for k in range(len(covered.points)):
        point = covered.points[k]
        i0, i1, j0, j1 = window(cells, point, point, covered.radius)
        for i in range(i0, i1):
            for j in range(j0, j1):
                x, y = offset(cells, i, j, point)
                if x * x + y * y <= limit:
                    mask[i, j] = 0


@compiled
def open_again(mask: NDArray[np.uint8], cells: Cells, tiles: Ints, clearance: float) -> None:
    """Find anew in some tiles of a mask where the centre may stand: 1, else 0.

    ``tiles`` (k, 2): which; tile (a, b) begins with cell (a, b) · `TILE`.
    """
    rows, columns = mask.shape
    reach, limit = math.ceil(clearance / CELL), (clearance / CELL) ** 2
    for tile in range(len(tiles)):
        i0, j0 = TILE * tiles[tile, 0], TILE * tiles[tile, 1]
        i1, j1 = i0 + TILE, j0 + TILE
        for i in range(i0, i1):
            for j in range(j0, j1):
                mask[i, j] = cells.seen[i, j]
        for i in range(max(i0 - reach, 0), min(i1 + reach, rows)):
            for j in range(max(j0 - reach, 0), min(j1 + reach, columns)):
                if cells.evidence[i, j] >= BLOCKED and is_blocked(cells.evidence, i, j):
                    for x in range(max(i - reach, i0), min(i + reach + 1, i1)):
                        for y in range(max(j - reach, j0), min(j + reach + 1, j1)):
                            if (x - i) * (x - i) + (y - j) * (y - j) < limit:
                                mask[x, y] = 0


@compiled
def keep_nearest(
    nearest: NDArray[np.int32], cells: Cells, nodes: Floats, first: int, radius: float
) -> None:
    """Take in the nodes (n, 2) m from ``first`` on into every cell's nearest node.

    -1 where none is nearer than ``radius`` m.
    """
    for node in range(first, len(nodes)):
        i0, i1, j0, j1 = window(cells, nodes[node], nodes[node], radius)
        for i in range(i0, i1):
            for j in range(j0, j1):
                x, y = offset(cells, i, j, nodes[node])
                squared, limit = x * x + y * y, radius * radius
                if nearest[i, j] >= 0:
                    x, y = offset(cells, i, j, nodes[nearest[i, j]])
                    limit = x * x + y * y
                if squared < limit:
                    nearest[i, j] = node


@compiled
def components(cells: Ints, columns: int) -> Ints:
    """Which of some cells hang together side by side: the component of each, (n,).

    ``cells`` (n,): ascending flat indices into a grid of so many columns. Components are
    numbered from 0 by their first cell.
    """
    root = np.arange(len(cells))
    above = 0
    for k in range(len(cells)):
        if k > 0 and cells[k - 1] == cells[k] - 1 and cells[k] % columns > 0:
            root[k] = root[k - 1]
        while cells[above] < cells[k] - columns:
            above += 1
        if cells[above] == cells[k] - columns:
            a, b = _root(root, k), _root(root, above)
            root[max(a, b)] = min(a, b)
    count = 0
    for k in range(len(cells)):
        if root[k] == k:
            root[k] = count
            count += 1
        else:
            # What comes before has its number already.
            root[k] = root[root[k]]
    return root


@compiled
def _root(root: Ints, k: int) -> int:
    """The first cell that is known to hang together with cell ``k``."""
    while root[k] != k:
        root[k] = root[root[k]]
        k = root[k]
    return k
