"""Which rooms the passages join, the borders they imply, and where the robot can go.

§3.1.1: an operator marks room borders by lines across them; for doors and
similar deep passageways several lines cover the passage, and every edge that
meets any of them crosses the border. In a simulated place the apartment says
where its passages are, so the lines follow from it. The paper leaves their
number and places open; we draw them across the clear width at both ends of the
passage's depth (wall and frame) and in its middle.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from scenes.apartment import Apartment
from scenes.errors import SceneError
from scenes.openings import passage_depth, place
from scenes.solids import floor_region, obstacles, passage_rooms, polygons

__all__ = [
    "ROBOT_RADIUS",
    "free_region",
    "passage_rooms",
    "reachable_positions",
    "room_borders",
]

Floats = NDArray[np.float64]

ROBOT_RADIUS = 0.15
"""Radius of the robot that must be able to start and to enter every room, m (§2)."""


def room_borders(
    apartment: Apartment, depths: tuple[float, ...] = (-1.0, 0.0, 1.0), extension: float = 0.05
) -> Floats:
    """Border segments of all open passages that join two different rooms (§3.1.1).

    The apartment's own borders follow, those of rooms that no wall parts.

    Parameters
    ----------
    apartment : Apartment
    depths : tuple of float
        Where the lines lie, as fractions of half the passage's depth from its middle.
    extension : float
        How far the lines reach into the jambs on either side, m.

    Returns
    -------
    array, shape (b, 2, 2)
        End points, m, scene frame; ``len(depths)`` for each such passage.
    """
    segments = []
    for passage in apartment.passages:
        right, left = passage_rooms(apartment, passage)
        if passage.closed or right is None or left is None or right == left:
            continue
        opening = place(apartment, passage.position, passage.width)
        half = opening.width / 2 + extension
        reach = passage_depth(passage, opening.thickness) / 2
        ends = [[(-half, share * reach), (half, share * reach)] for share in depths]
        segments.append(opening.points(np.array(ends)))
    own = np.array(apartment.borders, dtype=float).reshape(-1, 2, 2)
    return np.concatenate([*segments, own])


def free_region(apartment: Apartment, radius: float) -> shapely.Geometry:
    """Where the centre of a disc of that radius (m) can be: free floor, eroded."""
    return floor_region(apartment).difference(obstacles(apartment)).buffer(-radius, quad_segs=16)


def reachable_positions(
    apartment: Apartment,
    radius: float = ROBOT_RADIUS,
    spacing: float = 0.05,
    start: tuple[float, float] | None = None,
) -> Floats:
    """Grid points that the robot's centre can reach from the start.

    Parameters
    ----------
    apartment : Apartment
    radius : float
        Robot radius, m.
    spacing : float
        Grid spacing, m; the grid has a point at the scene's origin.
    start : tuple of float, optional
        m; default: the apartment's.

    Returns
    -------
    array, shape (p, 2)
        m, by rows of growing y.

    Raises
    ------
    SceneError
        If the robot does not fit where it starts.
    """
    position = apartment.start.position if start is None else start
    place = shapely.Point(position)
    parts = [part for part in polygons(free_region(apartment, radius)) if part.dwithin(place, 1e-4)]
    if not parts:
        raise SceneError(
            f"{apartment.name}: start.position {position}: expected free floor "
            f"for a robot of {radius} m radius"
        )
    low = np.floor(np.array(parts[0].bounds[:2]) / spacing).astype(int)
    high = np.ceil(np.array(parts[0].bounds[2:]) / spacing).astype(int)
    x, y = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1))
    points = np.column_stack([x.ravel(), y.ravel()]) * spacing
    shapely.prepare(parts[0])
    inside: Floats = points[shapely.contains_xy(parts[0], points)]
    return inside
