"""The true plan, for the physics only: contact and ray casting.

The robot's strategy never sees this. Obstacles are what occupies any height
between 1 cm (what the robot cannot drive over) and the robot's height.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from simulator.compiled import compiled
from simulator.laser import Spots, cast_beams
from simulator.surfaces import FloorCovers, Surfaces, boundary
from simulator.trigonometry import arctangent

__all__ = ["Walls", "World", "nearest", "spots"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_CELL = 0.25
"""Walls are looked up by cells of this size, m."""
_REACH = 0.5
"""How far the nearest obstacle is looked for, m."""


class World:
    """What the body can touch, what the beams can hit, and what lies on the floor.

    Parameters
    ----------
    obstacles : shapely geometry
        Solid footprints that the body cannot enter, m.
    surfaces : Surfaces, optional
        What there is at the height of the beams; default: the obstacles, white.
    covers : FloorCovers, optional
        Rugs, mats and cables that the robot drives over; default: none.
    maximum_range : float
        Of the longest beam that will be cast, m.

    Attributes
    ----------
    touched, seen : Walls
        What the body can touch, and what the beams can hit.

    Raises
    ------
    ValueError
        If there is no obstacle at all: the robot would drive for ever.
    """

    def __init__(
        self,
        obstacles: shapely.Geometry,
        surfaces: Surfaces | None = None,
        covers: FloorCovers | None = None,
        *,
        maximum_range: float = 1.0,
    ) -> None:
        walls = boundary(obstacles)
        if len(walls) == 0:
            raise ValueError("obstacles: empty, expected walls around the floor")
        surfaces = surfaces or Surfaces(walls, np.ones(len(walls)))
        self.solid = obstacles
        shapely.prepare(self.solid)
        self.covers = covers or FloorCovers()
        self.touched = _by_cell(Surfaces(walls, np.ones(len(walls))), _REACH)
        self.seen = _by_cell(surfaces, maximum_range)

    def is_free(self, point: Floats, radius: float) -> bool:
        """Whether a body of ``radius`` m stands at ``point`` without touching."""
        place = shapely.Point(float(point[0]), float(point[1]))
        return bool(shapely.distance(self.solid, place) >= radius)


class Walls(NamedTuple):
    """The walls of a plan by square cells.

    Those of cell c = i · ny + j are ``walls[first[c] : first[c + 1]]``;
    ``low`` (2,) m is the outer corner of cell (0, 0), ``shape`` (nx, ny).
    """

    walls: Floats
    reflectance: Floats
    first: Ints
    low: Floats
    shape: Ints


def _by_cell(surfaces: Surfaces, reach: float) -> Walls:
    """For every cell the walls that may be within ``reach`` m of a point in it."""
    ends = surfaces.walls.reshape(-1, 2)
    low = np.floor(ends.min(axis=0) / _CELL) * _CELL
    shape = np.floor((ends.max(axis=0) - low) / _CELL).astype(np.int64) + 1
    i, j = (index.ravel() for index in np.indices(tuple(shape)))
    x, y = low[0] + i * _CELL, low[1] + j * _CELL
    boxes = shapely.box(x - reach, y - reach, x + _CELL + reach, y + _CELL + reach)
    lines = shapely.linestrings(surfaces.walls)
    cell, wall = shapely.STRtree(lines).query(boxes, predicate="intersects")
    order = np.lexsort((wall, cell))
    wall = wall[order]
    first = np.searchsorted(cell[order], np.arange(len(boxes) + 1)).astype(np.int64)
    return Walls(surfaces.walls[wall], surfaces.reflectance[wall], first, low, shape)


@compiled
def _at(plan: Walls, x: float, y: float) -> tuple[Floats, Floats]:
    """Walls near a point (m) and their reflectance; none outside the plan."""
    i, j = math.floor((x - plan.low[0]) / _CELL), math.floor((y - plan.low[1]) / _CELL)
    if not (0 <= i < plan.shape[0] and 0 <= j < plan.shape[1]):
        return plan.walls[:0], plan.reflectance[:0]
    cell = i * plan.shape[1] + j
    first, last = plan.first[cell], plan.first[cell + 1]
    return plan.walls[first:last], plan.reflectance[first:last]


@compiled
def nearest(touched: Walls, x: float, y: float) -> tuple[float, float]:
    """Distance, m, and direction, rad, of the nearest obstacle.

    Where nothing is within 0.5 m, the distance is 0.5 m and the direction 0.
    """
    best, gap_x, gap_y = _REACH * _REACH, 1.0, 0.0
    walls, _ = _at(touched, x, y)
    for k in range(len(walls)):
        along_x, along_y = walls[k, 1, 0] - walls[k, 0, 0], walls[k, 1, 1] - walls[k, 0, 1]
        to_x, to_y = x - walls[k, 0, 0], y - walls[k, 0, 1]
        share = (to_x * along_x + to_y * along_y) / (along_x * along_x + along_y * along_y)
        share = min(max(share, 0.0), 1.0)
        off_x, off_y = share * along_x - to_x, share * along_y - to_y
        squared = off_x * off_x + off_y * off_y
        if squared < best:
            best, gap_x, gap_y = squared, off_x, off_y
    return math.sqrt(best), arctangent(gap_y, gap_x)


@compiled
def spots(seen: Walls, pose: Floats, bearings: Floats) -> Spots:
    """What beams from the centre truly hit, as far as ``seen`` reaches."""
    walls, reflectance = _at(seen, pose[0], pose[1])
    return Spots(*cast_beams(pose[:2], pose[2] + bearings, walls, reflectance))
