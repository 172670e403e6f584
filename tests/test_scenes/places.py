"""A small place whose every measure can be worked out by hand.

Room ``a`` is [0, 4] x [0, 3], room ``b`` [4.1, 7.1] x [0, 3]; the outer walls are
0.2 m thick, the wall between the rooms 0.1 m, with a passage of 0.8 m at y = 1.5.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from scenes import Apartment

AREA_A, AREA_B = 12.0, 9.0
OUTER = 7.5 * 3.4
"""Area inside the outer faces of the walls: [-0.2, 7.3] x [-0.2, 3.2], m²."""


def two_rooms_data(**changes: Any) -> dict[str, Any]:
    """The place as JSON data; ``changes`` replaces fields."""
    data: dict[str, Any] = {
        "name": "two",
        "rooms": [
            {"name": "a", "polygon": [[0, 0], [4, 0], [4, 3], [0, 3]], "walls": "red_plaster"},
            {
                "name": "b",
                "polygon": [[4.1, 0], [7.1, 0], [7.1, 3], [4.1, 3]],
                "walls": "blue_plaster",
                "floor": "tiles_white",
            },
        ],
        "walls": [
            {"start": [-0.1, -0.1], "end": [7.2, -0.1], "thickness": 0.2},
            {"start": [7.2, -0.1], "end": [7.2, 3.1], "thickness": 0.2},
            {"start": [7.2, 3.1], "end": [-0.1, 3.1], "thickness": 0.2},
            {"start": [-0.1, 3.1], "end": [-0.1, -0.1], "thickness": 0.2},
            {"start": [4.05, -0.1], "end": [4.05, 3.1], "thickness": 0.1},
        ],
        "passages": [{"position": [4.05, 1.5], "width": 0.8}],
        "start": {"position": [1, 1]},
    }
    return {**data, **changes}


def two_rooms(**changes: Any) -> Apartment:
    """The place with fields replaced."""
    return Apartment.model_validate(two_rooms_data(**changes))


def framed(**changes: Any) -> list[dict[str, Any]]:
    """Its passage with a door frame (casing 7 cm wide, 2 cm deep)."""
    return [{"position": [4.05, 1.5], "width": 0.8, "frame": {}, **changes}]


def turned(apartment: Apartment, angle_deg: float, shift: tuple[float, float]) -> Apartment:
    """The same place turned about the origin and moved."""
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))

    def move(point: Sequence[float]) -> tuple[float, float]:
        x, y = point
        return c * x - s * y + shift[0], s * x + c * y + shift[1]

    data = apartment.model_dump()
    for room in data["rooms"]:
        room["polygon"] = [move(point) for point in room["polygon"]]
    for wall in data["walls"]:
        wall["start"], wall["end"] = move(wall["start"]), move(wall["end"])
    for field in ("passages", "windows", "furniture", "lamps"):
        for item in data[field]:
            item["position"] = move(item["position"])
    for item in data["furniture"]:
        item["rotation_deg"] += angle_deg
    data["start"]["position"] = move(data["start"]["position"])
    return Apartment.model_validate(data)
