"""Lamps for scenes that come without any light."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from scenes.apartment import Apartment, Lamp
from scenes.importers.slicing import Triangles, lowest_above
from scenes.passages import ROBOT_RADIUS, free_region, reachable_positions

__all__ = ["ceiling_lamps"]

SPACING = 0.5
REACH = 4.0
"""A lamp lights what is in sight up to this distance, m."""
RADIUS = 0.12
THICKNESS = 0.1
LOWEST = 1.9
"""Least height of a ceiling that carries a lamp, m."""
POWER = 40.0
CLEARANCE = 0.5
"""Lamps are better that far from walls and furniture, m."""
WORTH = 3
"""A lamp more must light so many spots, 0.5 m apart."""


def ceiling_lamps(apartment: Apartment, triangles: Triangles) -> tuple[Lamp, ...]:
    """As few ceiling lamps as light nearly all of the floor that the robot can reach.

    Each is the one that lights most of what is still dark; it hangs under the ceiling
    over its place.

    Parameters
    ----------
    apartment : Apartment
    triangles : Triangles
        Of the scene, m, the floor at height 0.

    Returns
    -------
    tuple of Lamp
    """
    spots = reachable_positions(apartment, spacing=SPACING)
    if not len(spots):
        spots = np.array([apartment.start.position])
    heights = lowest_above(triangles, spots, LOWEST)
    heights = np.minimum(heights, min(room.ceiling_height for room in apartment.rooms))
    chosen = _chosen(_in_sight(apartment, spots), _is_roomy(apartment, spots))
    return tuple(
        Lamp(
            position=(float(spots[k, 0]), float(spots[k, 1])),
            height=float(heights[k]) - THICKNESS,
            radius=RADIUS,
            power=POWER,
        )
        for k in chosen
    )


def _chosen(sees: NDArray[np.bool_], roomy: NDArray[np.bool_]) -> list[int]:
    """Spots that have nearly all others in sight, in roomy places as far as that goes."""
    dark = np.ones(len(sees), dtype=bool)
    chosen: list[int] = []
    for allowed in (roomy, np.ones_like(roomy)):
        while True:
            gain = np.where(allowed, (sees & dark).sum(axis=1), 0)
            best = int(gain.argmax())
            if gain[best] < WORTH and (chosen or not allowed.all()):
                break
            chosen.append(best)
            dark &= ~sees[best]
    return chosen


def _is_roomy(apartment: Apartment, spots: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which spots are in no doorway or corner."""
    roomy: NDArray[np.bool_] = shapely.intersects_xy(free_region(apartment, CLEARANCE), spots)
    return roomy


def _in_sight(apartment: Apartment, spots: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which spots (s, s) see each other over free floor within reach."""
    free = free_region(apartment, ROBOT_RADIUS / 2)
    shapely.prepare(free)
    first, second = cKDTree(spots).query_pairs(REACH, output_type="ndarray").T
    clear = shapely.covers(free, shapely.linestrings(np.stack([spots[first], spots[second]], 1)))
    sees = np.eye(len(spots), dtype=bool)
    sees[first[clear], second[clear]] = sees[second[clear], first[clear]] = True
    return sees
