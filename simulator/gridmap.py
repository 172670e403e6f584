"""The robot's own local occupancy grid, in the frame of its estimate.

Every laser point and bumper contact is evidence for an obstacle in its cell,
every beam that passes is evidence against, and cells that a beam or the body
has passed are *seen*. The robot plans on seen cells only: it never drives into
the unknown on purpose, and it knows nothing but what it has sensed. The grid
grows with the map. It is used locally only, as the map has no global
consistency.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from simulator import gridcells
from simulator.gridcells import CELL, Cells, Covered, Discs

__all__ = ["CELL", "GridMap"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_BLOCK = 4 * gridcells.TILE
"""The grid grows by this many cells."""


class GridMap:
    """Evidence and seen cells around the driven track.

    Parameters
    ----------
    origin : array, shape (2,)
        A point that the map is begun around, m.
    """

    def __init__(self, origin: Floats) -> None:
        self.corner: Floats = np.floor(np.asarray(origin[:2]) / CELL) * CELL - _BLOCK * CELL
        shape = (2 * _BLOCK, 2 * _BLOCK)
        self.evidence = np.zeros(shape, np.int8)
        self.seen = np.zeros(shape, np.bool_)

    @property
    def table(self) -> Cells:
        """The grid as the compiled loops take it."""
        return Cells(self.evidence, self.seen, self.corner)

    def hold(self, point: Floats, margin: float) -> None:
        """Grow until everything within ``margin`` m of ``point`` is on the grid."""
        low = [(p - margin - c) / CELL for p, c in zip(point[:2], self.corner, strict=True)]
        high = [(p + margin - c) / CELL for p, c in zip(point[:2], self.corner, strict=True)]
        rows, columns = self.seen.shape
        if min(low) <= 0.0 or high[0] >= rows or high[1] >= columns:
            short, over = -np.array(low), np.array(high) - self.seen.shape
            before = _BLOCK * np.maximum(np.floor(short / _BLOCK) + 1, 0).astype(np.int64)
            after = _BLOCK * np.maximum(np.floor(over / _BLOCK) + 1, 0).astype(np.int64)
            pads = tuple(zip(before.tolist(), after.tolist(), strict=True))
            self.evidence = np.pad(self.evidence, pads)
            self.seen = np.pad(self.seen, pads)
            self.corner = self.corner - before * CELL

    def cells(self, points: Floats) -> NDArray[np.int64]:
        """Cell indices (x, y) of points (n, 2) m, shape (n, 2)."""
        return np.asarray(np.floor((points - self.corner) / CELL), dtype=np.int64)

    def centres(self, cells: NDArray[np.int64]) -> Floats:
        """Cell centres, m, shape (n, 2)."""
        return np.asarray(self.corner + (cells + 0.5) * CELL)

    def forget_contacts(self, point: Floats, radius: float) -> None:
        """Take back the contacts within a square of ``radius`` m around a point."""
        low, high = self.cells(np.stack([point - radius, point + radius]))
        window = np.s_[max(low[0], 0) : high[0] + 1, max(low[1], 0) : high[1] + 1]
        felt = self.evidence[window] > gridcells.HIGH
        self.evidence[window][felt] = 0

    def blocked(self, window: tuple[slice, slice] = np.s_[:, :]) -> Bools:
        """Which cells in a part of the grid count as obstacles.

        A single laser point does not: like the clustering of §2.2.2, this asks
        for a second one within a few centimetres.
        """
        evidence = np.maximum(self.evidence[window], 0).astype(np.float32)
        size = (2 * gridcells.SUPPORT + 1, 2 * gridcells.SUPPORT + 1)
        around = cv2.boxFilter(evidence, -1, size, normalize=False, borderType=cv2.BORDER_CONSTANT)
        return np.asarray((evidence >= gridcells.BLOCKED) & (around >= 2 * gridcells.HIT))

    def clearance(self, points: Floats, limit: float = 0.3) -> Floats:
        """Distance from points (n, 2) to the nearest known obstacle, m, at most ``limit``."""
        return gridcells.clearances(self.table, np.ascontiguousarray(points), limit)

    def is_seen(self, points: Floats) -> Bools:
        """Whether each point (n, 2) lies in a seen cell."""
        cells = self.cells(points)
        inside = ((cells >= 0) & (cells < self.seen.shape)).all(axis=1)
        x, y = np.where(inside[:, None], cells, 0).T
        return np.asarray(inside & self.seen[x, y])

    def is_open(self, points: Floats, clearance: float) -> Bools:
        """Whether the centre may stand at points (n, 2): seen, nothing known near."""
        return np.asarray(self.is_seen(points) & (self.clearance(points) >= clearance))

    def is_clear(self, start: Floats, end: Floats, clearance: float) -> bool:
        """Whether no known obstacle is nearer than ``clearance`` m to a segment."""
        return gridcells.is_clear(self.table, start, end, clearance)

    def are_clear(self, start: Floats, ends: Floats, clearance: float) -> Bools:
        """`is_clear` for the segments from ``start`` to each of ``ends`` (k, 2), m; shape (k,)."""
        return gridcells.are_clear(self.table, start, ends, clearance)

    def free_steps(
        self, points: Floats, offsets: Floats, clearance: float, covered: Discs
    ) -> NDArray[np.int64]:
        """How many of the successive ``offsets`` (s, 2), m, the centre may go from each point.

        A place is free if it is seen, no known obstacle is nearer than
        ``clearance`` m, and it is not covered. ``points`` (m, 2) m; shape (m,).
        """
        return gridcells.free_steps(self.table, points, offsets, clearance, covered)

    def bridge_seen(self, gap: float) -> None:
        """Take for seen what lies between seen cells no more than ``gap`` m apart."""
        size = round(gap / CELL) + 1
        seen = self.seen.view(np.uint8)
        closed = cv2.morphologyEx(seen, cv2.MORPH_CLOSE, np.ones((size, size), np.uint8))
        np.logical_or(self.seen, closed, out=self.seen)

    def room(self, window: tuple[slice, slice] = np.s_[:, :]) -> Floats:
        """Distance of every cell in a part of the grid to known obstacles, m."""
        free = np.ascontiguousarray(~self.blocked(window), dtype=np.uint8)
        distance = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        return np.asarray(distance, dtype=np.float64) * CELL

    def erase(self, mask: NDArray[np.uint8], covered: Covered) -> None:
        """Set a mask of the grid's shape to 0 where it is covered."""
        gridcells.erase(mask, self.table, covered)
