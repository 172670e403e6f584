"""A room to be furnished: its walls, what must stay clear, and where a robot can drive.

All of it is boxes (x0, y0, x1, y1) in m, so that a hundred places for a piece
are tried at once; ways are judged on a raster of 5 cm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from scenes.apartment import RoomKind
from scenes.passages import ROBOT_RADIUS

__all__ = ["Boxes", "Side", "Site", "boxes_of"]

Boxes = NDArray[np.float64]
CELL = 0.05
"""Raster on which ways are judged, m."""


@dataclass(frozen=True)
class Side:
    """A straight wall of a room: pieces with that ``turn`` (degrees) have their back to it.

    ``line`` is x or y of the wall's face; it runs from ``low`` to ``high``, m;
    ``low_corner``, ``high_corner``: whether another wall juts out into the room there.
    """

    turn: int
    line: float
    low: float
    high: float
    low_corner: bool = True
    high_corner: bool = True


@dataclass
class Site:
    """A room and what stands in it so far.

    ``doors``: floor that stays clear before doorways; ``windows``: floor before
    windows, which tall pieces leave free; ``entries``: a point just inside each
    doorway; ``solids``: what stands on the floor; ``access``: floor that must
    stay clear before pieces; ``hung``: what hangs on the walls.
    """

    kind: RoomKind
    shape: Polygon
    ceiling: float
    doors: Boxes
    windows: Boxes
    entries: NDArray[np.float64]
    solids: list[Boxes] = field(default_factory=list)
    access: list[Boxes] = field(default_factory=list)
    hung: list[Boxes] = field(default_factory=list)

    @cached_property
    def box(self) -> tuple[float, float, float, float]:
        """Bounds of the room."""
        x0, y0, x1, y1 = self.shape.bounds
        return x0, y0, x1, y1

    @cached_property
    def area(self) -> float:
        """Clear floor, m²."""
        return float(self.shape.area)

    @cached_property
    def sides(self) -> tuple[Side, ...]:
        """All walls of the room, counter-clockwise."""
        ring = shapely.get_coordinates(shapely.orient_polygons(self.shape).exterior)[:-1]
        steps = np.roll(ring, -1, axis=0) - ring
        before = np.roll(steps, 1, axis=0)
        # Counter-clockwise the room lies to the left; its corners are left turns.
        convex = before[:, 0] * steps[:, 1] - before[:, 1] * steps[:, 0] > 0.0
        sides = []
        for k, (start, step) in enumerate(zip(ring, steps, strict=True)):
            axis = 0 if step[1] == 0.0 else 1
            turn = ((0, 180) if axis == 0 else (90, -90))[int(step[axis] > 0.0)]
            a, b = float(start[axis]), float(start[axis] + step[axis])
            corners = (bool(convex[k]), bool(convex[(k + 1) % len(ring)]))
            corners = corners if a < b else corners[::-1]
            sides.append(Side(turn, float(start[1 - axis]), min(a, b), max(a, b), *corners))
        return tuple(sides)

    @cached_property
    def notches(self) -> Boxes:
        """What of the bounds is not the room: walls between the arms of an L."""
        corners = shapely.get_coordinates(self.shape)
        xs, ys = np.unique(corners[:, 0]), np.unique(corners[:, 1])
        x, y = np.meshgrid((xs[:-1] + xs[1:]) / 2, (ys[:-1] + ys[1:]) / 2)
        j, i = np.nonzero(~shapely.contains_xy(self.shape, x, y))
        return np.column_stack([xs[i], ys[j], xs[i + 1], ys[j + 1]]).reshape(-1, 4)

    def standing(self) -> Boxes:
        """Everything solid on the floor."""
        return np.concatenate([np.empty((0, 4)), *self.solids])

    def ways(self, radius: float, more: Boxes | None = None) -> tuple[NDArray[np.int32], int]:
        """Where a disc of that radius (m) can be: components on the raster.

        Returns
        -------
        labels : array, shape (ny, nx)
            0 where it cannot be.
        home : int
            Label of the component at the first doorway; 0 if it cannot be there.
        """
        free = self._raster(radius)
        taken = self.standing() if more is None else np.concatenate([self.standing(), more])
        _clear(free, self._indices(taken, radius))
        labels = cv2.connectedComponents(free, connectivity=4)[1]
        spots = self._cells_of(self.entries, labels.shape)
        home = int(labels[spots[0, 1], spots[0, 0]]) if len(spots) else 1
        return labels, home

    def is_open(self, more: Boxes, radius: float, least: float) -> bool:
        """Whether all doorways stay joined and hardly any floor is cut off.

        ``least``: share of the room that the disc must still reach.
        """
        labels, home = self.ways(radius, more)
        spots = self._cells_of(self.entries, labels.shape)
        if not home or not (labels[spots[:, 1], spots[:, 0]] == home).all():
            return False
        reached = np.count_nonzero(labels == home) * CELL**2
        return bool(reached >= least * self.area)

    def pockets(self, more: Boxes) -> float:
        """Floor that the robot could be on but not get to, m²."""
        labels, home = self.ways(ROBOT_RADIUS, more)
        return float(np.count_nonzero(labels) - np.count_nonzero(labels == home)) * CELL**2

    def driven(self) -> float:
        """Share of the floor on which the robot's centre can be."""
        labels, home = self.ways(ROBOT_RADIUS)
        return float(np.count_nonzero(labels == home) * CELL**2 / self.area)

    def _raster(self, radius: float) -> NDArray[np.uint8]:
        x0, y0, x1, y1 = self.box
        shape = (int((y1 - y0) / CELL), int((x1 - x0) / CELL))
        free = np.ones(shape, dtype=np.uint8)
        rim = max(1, round(radius / CELL))
        free[:rim], free[-rim:], free[:, :rim], free[:, -rim:] = 0, 0, 0, 0
        _clear(free, self._indices(self.notches, radius))
        return free

    def _indices(self, boxes: Boxes, radius: float) -> NDArray[np.int64]:
        """Columns and rows that boxes widened by a radius cover."""
        grown = boxes + np.array([-radius, -radius, radius, radius]) - np.tile(self.box[:2], 2)
        indices: NDArray[np.int64] = np.maximum(np.round(grown / CELL), 0.0).astype(int)
        return indices

    def _cells_of(self, points: NDArray[np.float64], shape: tuple[int, ...]) -> NDArray[np.int64]:
        cells = ((points - np.array(self.box[:2])) / CELL).astype(int)
        inside: NDArray[np.int64] = np.clip(cells, 0, np.array(shape[::-1]) - 1)
        return inside


def _clear(free: NDArray[np.uint8], boxes: NDArray[np.int64]) -> None:
    for i0, j0, i1, j1 in boxes:
        free[j0:j1, i0:i1] = 0


def boxes_of(values: Sequence[tuple[float, float, float, float]]) -> Boxes:
    """Boxes as an array, also if there are none."""
    return np.array(values, dtype=float).reshape(-1, 4)
