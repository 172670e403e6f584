"""The true plan, for the physics only: contact and ray casting.

The robot's strategy never sees this. Obstacles are what occupies any height
between 1 cm (what the robot cannot drive over) and the robot's height.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from simulator.laser import cast_beams

__all__ = ["World"]

Floats = NDArray[np.float64]

_CELL = 0.25
"""Walls are looked up by cells of this size, m."""


class World:
    """True obstacles as wall segments with a lazily filled cell index.

    Parameters
    ----------
    obstacles : shapely geometry
        Solid footprints, m.

    Raises
    ------
    ValueError
        If there is no obstacle at all: the robot would drive for ever.
    """

    def __init__(self, obstacles: shapely.Geometry) -> None:
        rings = shapely.get_rings(shapely.get_parts(shapely.normalize(obstacles)))
        points = [shapely.get_coordinates(ring) for ring in rings]
        if not points:
            raise ValueError("obstacles: empty, expected walls around the floor")
        self.walls: Floats = np.concatenate(
            [np.stack([ring[:-1], ring[1:]], axis=1) for ring in points]
        )
        self.solid = obstacles
        shapely.prepare(self.solid)
        self._tree = shapely.STRtree(shapely.linestrings(self.walls))
        self._cache: dict[tuple[int, int, float], Floats] = {}

    def near(self, point: Floats, reach: float) -> Floats:
        """Walls that may be within ``reach`` m of ``point``, shape (w, 2, 2)."""
        cell = np.floor(point[:2] / _CELL)
        key = (int(cell[0]), int(cell[1]), reach)
        if key not in self._cache:
            low = cell * _CELL - reach
            box = shapely.box(*low, *(low + _CELL + 2.0 * reach))
            self._cache[key] = self.walls[np.sort(self._tree.query(box))]
        return self._cache[key]

    def nearest(self, point: Floats, reach: float = 0.5) -> tuple[float, float]:
        """Distance, m, and direction, rad, of the nearest obstacle.

        Where nothing is within ``reach`` m, the distance is ``reach``.
        """
        walls = self.near(point, reach)
        if len(walls) == 0:
            return reach, 0.0
        start, along = walls[:, 0], walls[:, 1] - walls[:, 0]
        to_point = point[:2] - start
        share = (to_point * along).sum(axis=1) / (along * along).sum(axis=1)
        gap = np.clip(share, 0.0, 1.0)[:, None] * along - to_point
        squared = (gap * gap).sum(axis=1)
        best = int(squared.argmin())
        return min(float(np.sqrt(squared[best])), reach), float(
            np.arctan2(gap[best, 1], gap[best, 0])
        )

    def ranges(self, pose: Floats, bearings: Floats, reach: float) -> Floats:
        """True ranges of beams from the centre, m; ``inf`` beyond ``reach``."""
        ranges = cast_beams(pose[:2], pose[2] + bearings, self.near(pose, reach))
        return np.where(ranges <= reach, ranges, np.inf)

    def is_free(self, point: Floats, radius: float) -> bool:
        """Whether a body of ``radius`` m stands at ``point`` without touching."""
        place = shapely.Point(float(point[0]), float(point[1]))
        return bool(shapely.distance(self.solid, place) >= radius)
