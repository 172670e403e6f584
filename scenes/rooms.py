"""Rooms as shapes, and which of them hold a point."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from scenes.apartment import Apartment

__all__ = ["room_of_each", "room_shapes", "rooms_at"]


def room_shapes(apartment: Apartment) -> NDArray[np.object_]:
    """Polygons of the rooms, shape (r,), m; masonry that stands in them included."""
    # Made in one go: openings, lamps and pieces all ask for the rooms around them.
    corners = [room.polygon for room in apartment.rooms]
    owner = np.repeat(np.arange(len(corners)), [len(ring) for ring in corners])
    shapes: NDArray[np.object_] = shapely.polygons(
        shapely.linearrings(np.concatenate(corners), indices=owner)
    )
    return shapes


def rooms_at(apartment: Apartment, spot: shapely.Point) -> list[int]:
    """Indices of the rooms that hold a point."""
    found: list[int] = np.flatnonzero(shapely.intersects(room_shapes(apartment), spot)).tolist()
    return found


def room_of_each(apartment: Apartment, positions: NDArray[np.float64]) -> NDArray[np.int64]:
    """The first room that holds each position (n, 2), shape (n,); -1 in a passage or outside."""
    tree = shapely.STRtree(room_shapes(apartment))
    spot, room = tree.query(shapely.points(positions), predicate="intersects")
    found = np.full(len(positions), len(tree), dtype=np.int64)
    np.minimum.at(found, spot, room)
    found[found == len(tree)] = -1
    return found
