"""Lamps for plans, which show none."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from shapely import Polygon

from scenes.apartment import Apartment, Lamp, Room
from scenes.solids import masonry_region, polygons

__all__ = ["with_room_lamps"]

AREA = 16.0
"""One lamp for every so much of a room, m²."""
APART = 2.5
"""Least distance between two lamps of a room, m."""
POWER, LEAST, MOST = 3.2, 20.0, 60.0
"""W for each m² of floor, and of one lamp."""


def with_room_lamps(apartment: Apartment) -> Apartment:
    """The apartment with ceiling lamps in every room, lit by them and through its windows."""
    masonry = masonry_region(apartment)
    lamps = [lamp for room in apartment.rooms for lamp in _lamps(room, masonry)]
    source = "mixed" if apartment.windows else "interior"
    lighting = apartment.lighting.model_copy(update={"source": source})
    return apartment.model_copy(update={"lamps": tuple(lamps), "lighting": lighting})


def _lamps(room: Room, masonry: shapely.Geometry) -> Iterator[Lamp]:
    """Lamps in the widest places of a room."""
    floor = Polygon(room.polygon).difference(masonry)
    count = max(1, round(floor.area / AREA))
    rest = floor
    for _ in range(count):
        circles = [
            shapely.maximum_inscribed_circle(part, tolerance=0.02)
            for part in polygons(rest, smallest=0.1)
        ]
        if not circles:
            return
        widest = max(circles, key=lambda circle: float(circle.length))
        x, y = np.round(shapely.get_coordinates(widest)[0], 3).tolist()
        rest = rest.difference(shapely.Point(x, y).buffer(APART))
        power = float(np.clip(POWER * floor.area / count, LEAST, MOST))
        radius = round(min(0.15, 0.8 * float(widest.length)), 3)
        yield Lamp(position=(x, y), radius=radius, power=round(power, 1))
