"""Where passages and windows sit in the walls.

An opening is cut into the wall on whose centre line its middle lies. All the
geometry of an opening (cut, lining, casing, leaf, border lines) is made of
rectangles in the opening's own frame: *along* the wall and *across* it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from scenes.apartment import Apartment, Passage, Point, Wall

__all__ = ["LINING", "Opening", "lining_of", "nearest_wall", "passage_depth", "place", "wall_lines"]

LINING = 0.02
"""Thickness of the boards that line a framed opening, m."""


@dataclass(frozen=True)
class Opening:
    """A gap in a wall: its middle on the centre line, and its own frame.

    ``centre`` (2,) m; ``along``, ``across`` (2,) unit vectors, across is along
    turned by +90°; ``width`` the clear width, ``thickness`` the wall's, m.
    """

    wall: int
    centre: NDArray[np.float64]
    along: NDArray[np.float64]
    across: NDArray[np.float64]
    width: float
    thickness: float

    def points(self, local: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (..., 2) given as (along, across), m, in the scene frame."""
        local = np.asarray(local, dtype=float)
        points: NDArray[np.float64] = (
            self.centre + local[..., :1] * self.along + local[..., 1:] * self.across
        )
        return points

    def rectangle(self, along: tuple[float, float], across: tuple[float, float]) -> Polygon:
        """The rectangle between two offsets along and two across the wall, m."""
        (a, b), (c, d) = along, across
        return Polygon(self.points(np.array([(a, c), (b, c), (b, d), (a, d)])))

    def strip(self, depth: float) -> Polygon:
        """A rectangle over the clear width, ``depth`` m deep, in the middle of the wall."""
        return self.rectangle((-self.width / 2, self.width / 2), (-depth / 2, depth / 2))


def wall_lines(walls: Sequence[Wall]) -> NDArray[np.float64]:
    """Centre lines of the walls, (w, 2, 2) m."""
    return np.array([(wall.start, wall.end) for wall in walls], dtype=float).reshape(-1, 2, 2)


def nearest_wall(walls: Sequence[Wall], position: Point) -> tuple[int, float]:
    """Index of the wall whose centre line is nearest to a point, and the distance, m."""
    distance = shapely.distance(shapely.linestrings(wall_lines(walls)), shapely.Point(position))
    index = int(np.argmin(distance))
    return index, float(distance[index])


def place(apartment: Apartment, position: Point, width: float) -> Opening:
    """The opening of that clear width at the nearest wall's centre line."""
    index, _ = nearest_wall(apartment.walls, position)
    wall = apartment.walls[index]
    start, end = np.array(wall.start), np.array(wall.end)
    along = (end - start) / np.sqrt(((end - start) ** 2).sum())
    # No np.dot: the order of its sum depends on the processor.
    centre = start + along * ((np.array(position) - start) * along).sum()
    across = np.array([-along[1], along[0]])
    return Opening(index, centre, along, across, width, wall.thickness)


def lining_of(passage: Passage) -> float:
    """Thickness of the lining boards beside the clear width, m; 0 without a frame."""
    return 0.0 if passage.frame is None else min(LINING, passage.frame.width)


def passage_depth(passage: Passage, thickness: float) -> float:
    """Depth of a passage: the wall and what its frame stands out on both sides, m."""
    return thickness + (0.0 if passage.frame is None else 2.0 * passage.frame.depth)
