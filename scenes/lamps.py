"""Lamps as prisms: glowing bodies and what carries them.

The glowing body of ``apartment.lamps[i]`` has the material ``lamp:i``, by which
the renderer finds its power and colour temperature.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely

from scenes.apartment import Apartment, Lamp
from scenes.materials import LAMP_PREFIX
from scenes.parts import Part, Span, cylinder
from scenes.rooms import room_shapes

__all__ = ["BODY_HEIGHT", "lamp_parts", "lamp_underside"]

BODY_HEIGHT = {"ceiling": 0.06, "pendant": 0.20, "floor": 0.25, "table": 0.18}
"""Height of the glowing body by kind, m."""
CARRIER = "metal_dark"


def _ceiling_over(apartment: Apartment, lamp: Lamp) -> float:
    """Ceiling height of the room that the lamp is in or nearest to, m."""
    distance = shapely.distance(room_shapes(apartment), shapely.Point(lamp.position))
    nearest = int(np.argmin(distance))
    return apartment.rooms[nearest].ceiling_height


def lamp_underside(apartment: Apartment, lamp: Lamp) -> float:
    """Underside of the glowing body above the floor, m, with the kind's default."""
    if lamp.height is not None:
        return lamp.height
    ceiling = _ceiling_over(apartment, lamp)
    drop = {"ceiling": BODY_HEIGHT["ceiling"], "pendant": 0.7}
    if lamp.kind in drop:
        return ceiling - drop[lamp.kind]
    return {"floor": 1.4, "table": 0.95}[lamp.kind]


def lamp_parts(apartment: Apartment, index: int) -> Iterator[Part]:
    """Body, and cord or stand, of one lamp in the scene frame."""
    lamp = apartment.lamps[index]
    low = lamp_underside(apartment, lamp)
    high = low + BODY_HEIGHT[lamp.kind]
    ceiling = _ceiling_over(apartment, lamp)
    if lamp.kind in ("ceiling", "pendant"):
        high = min(high, ceiling)
    yield _disc(lamp, lamp.radius, (low, high), f"{LAMP_PREFIX}{index}", 20)
    if lamp.kind in ("ceiling", "pendant") and ceiling - high > 1e-6:
        yield _disc(lamp, 0.006, (high, ceiling), CARRIER, 6)
    if lamp.kind == "floor":
        yield _disc(lamp, 0.14, (0.0, 0.025), CARRIER, 16)
        yield _disc(lamp, 0.012, (0.025, low), CARRIER, 8)
    if lamp.kind == "table":
        yield _disc(lamp, 0.05, (max(0.0, low - 0.2), low), CARRIER, 10)


def _disc(lamp: Lamp, radius: float, heights: Span, material: str, corners: int) -> Part:
    return cylinder(lamp.position, (radius, radius), heights, material, corners)
