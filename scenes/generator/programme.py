"""Which rooms a home of so many rooms has, and how large they are to each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scenes.apartment import RoomKind
from scenes.generator.wishes import Brief

__all__ = ["HABITABLE", "LEAST_SIDE", "MOST_AREA", "draw_programme", "draw_weights"]

SHARE: dict[RoomKind, float] = {
    "living_room": 4.0,
    "bedroom": 2.5,
    "kitchen": 1.8,
    "office": 1.9,
    "other": 1.7,
    "bathroom": 1.15,
    "storage": 0.7,
}
"""Areas of the rooms relative to each other; corridors have a width instead."""

LEAST_SIDE: dict[RoomKind, float] = {
    "living_room": 2.6,
    "bedroom": 2.2,
    "kitchen": 1.8,
    "office": 1.9,
    "other": 1.8,
    "bathroom": 1.5,
    "storage": 1.15,
    "corridor": 1.0,
}
"""Least clear side of a room or of an arm of it, m."""

MOST_AREA: dict[RoomKind, float] = {"bathroom": 9.0, "storage": 5.5, "kitchen": 18.0}
"""Area beyond which a room of a large home does not grow much, m²."""

HABITABLE: tuple[RoomKind, ...] = ("living_room", "bedroom", "office", "kitchen")
"""Kinds that need a window."""

EXTRAS: tuple[RoomKind, ...] = (
    "bedroom",
    "storage",
    "office",
    "bathroom",
    "bedroom",
    "other",
    "bedroom",
)
"""What larger homes have besides living room, bathroom, hall, bedroom and kitchen."""


def draw_programme(rng: np.random.Generator, brief: Brief) -> tuple[RoomKind, ...]:
    """Kinds of all rooms, the living room first; the hall second if there is one.

    Homes of up to four rooms, and some of five, have no hall unless a corridor
    is asked for: their rooms open to the living room.
    """
    kinds: list[RoomKind] = ["living_room"]
    least = 5 if rng.random() < 0.5 else 6
    if brief.layout == "corridor" or brief.rooms >= least:
        kinds.append("corridor")
    basics: list[RoomKind] = ["bathroom", "bedroom", "kitchen"]
    if brief.layout == "open" or rng.random() < 0.3:
        basics = ["bathroom", "kitchen", "bedroom"]
    extras = list(EXTRAS)
    for k in range(len(extras) - 1):
        if rng.random() < 0.5:
            extras[k : k + 2] = extras[k + 1], extras[k]
    return tuple([*kinds, *basics, *extras][: brief.rooms])


def draw_weights(rng: np.random.Generator, kinds: Sequence[RoomKind]) -> list[float]:
    """Relative areas of the rooms; 0 for the hall, later rooms of a kind a little smaller."""
    weights = []
    for index, kind in enumerate(kinds):
        earlier = sum(other == kind for other in kinds[:index])
        weight = SHARE.get(kind, 0.0) * rng.uniform(0.85, 1.2) * (0.85 if earlier else 1.0)
        weights.append(float(weight))
    return weights
