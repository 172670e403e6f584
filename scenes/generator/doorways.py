"""Doors, wide passages, the entrance, thresholds, and windows of a plan."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from scenes.apartment import RoomKind, Threshold
from scenes.generator.plan import OUTSIDE, FloorPlan, Stretch
from scenes.generator.wishes import Brief

__all__ = ["Doorway", "Pane", "draw_doorways", "draw_panes", "draw_threshold"]

JAMB = 0.14
"""Least distance from a doorway's clear width to a corner of the room, m."""
PUBLIC: tuple[RoomKind, ...] = ("living_room", "kitchen", "corridor", "other")
"""Kinds that a wide passage without a door may join."""
BALCONY = (0.08, 2.15)
"""Sill and head of a glass door, m."""

_WINDOWS: dict[RoomKind, tuple[float, float, float]] = {
    "bathroom": (0.6, 1.35, 2.05),
    "kitchen": (1.2, 1.1, 2.1),
    "corridor": (0.7, 0.95, 2.1),
    "storage": (0.5, 1.45, 2.0),
}
"""Width, sill and head height, m; other rooms have large windows."""


@dataclass(frozen=True)
class Doorway:
    """A doorway of clear ``width`` m at ``position`` between two rooms (indices).

    ``second`` is `OUTSIDE` for the entrance; ``upright``: the wall runs along y;
    ``wide``: no door, no frame, no lintel.
    """

    position: tuple[float, float]
    width: float
    upright: bool
    first: int
    second: int
    wide: bool = False


@dataclass(frozen=True)
class Pane:
    """A window of a room: clear width at a point of an outer wall's centre line, m."""

    room: int
    position: tuple[float, float]
    upright: bool
    width: float
    sill: float
    head: float


def draw_doorways(
    rng: np.random.Generator, plan: FloorPlan, brief: Brief
) -> tuple[Doorway, ...] | None:
    """One doorway for every link, some more, the entrance last; None if one does not fit."""
    links = [*plan.links, *_second_ways(rng, plan)]
    wide = _wide_links(rng, plan, brief, links)
    doorways = []
    for link in links:
        doorway = _doorway(rng, plan, link, link in wide)
        if doorway is None:
            return None
        doorways.append(doorway)
    entrance = _entrance(rng, plan, doorways)
    return None if entrance is None else (*doorways, entrance)


def _second_ways(rng: np.random.Generator, plan: FloorPlan) -> Iterator[tuple[int, int]]:
    """A kitchen that lies beside the living room often opens to it as well."""
    linked = {frozenset(link) for link in plan.links}
    for index, kind in enumerate(plan.kinds):
        near = any(s.high - s.low > 1.5 for s in plan.between(0, index))
        if kind == "kitchen" and near and {0, index} not in linked and rng.random() < 0.45:
            yield 0, index


def _wide_links(
    rng: np.random.Generator, plan: FloorPlan, brief: Brief, links: Sequence[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Links without a door: that share of those that may be; in an open plan the kitchen's."""
    may = [link for link in links if all(plan.kinds[room] in PUBLIC for room in link)]
    # Rounded at random, so that the share is met over many homes.
    count = int(brief.wide_share * len(may) + rng.random())
    order = [may[k] for k in rng.permutation(len(may))]
    if brief.layout == "open":
        order.sort(key=lambda link: "kitchen" not in {plan.kinds[room] for room in link})
        count = max(count, 1)
    return order[:count]


def _doorway(
    rng: np.random.Generator, plan: FloorPlan, link: tuple[int, int], wide: bool
) -> Doorway | None:
    """Draw a doorway in the longest wall that two rooms share, often near a corner."""
    shared = plan.between(*link)
    if not shared:
        return None
    stretch = max(shared, key=lambda s: s.high - s.low)
    low, high = _clear_span(plan, stretch, link)
    most = round(high - low - 2 * JAMB, 2)
    width = _door_width(rng, plan, link)
    if wide and most >= 1.2:
        width = float(rng.uniform(1.2, max(1.2, min(most, 3.2))))
    elif wide and most < 1.0:
        wide = False
    width = round(min(width, most), 2)
    if width < 0.66:
        return None
    along = _along(rng, low + JAMB + width / 2, high - JAMB - width / 2)
    return Doorway(stretch.point(along), width, stretch.upright, *link, wide=wide)


def _door_width(rng: np.random.Generator, plan: FloorPlan, link: tuple[int, int]) -> float:
    """Clear width of a door by what it leads to, m."""
    if {plan.kinds[room] for room in link} & {"bathroom", "storage"}:
        return float(rng.choice([0.7, 0.76, 0.8]))
    return float(rng.choice([0.8, 0.86, 0.92]))


def _clear_span(plan: FloorPlan, stretch: Stretch, rooms: Sequence[int]) -> tuple[float, float]:
    """The part of a stretch that all the rooms beside it see, m."""
    low, high = stretch.low, stretch.high
    reach = plan.thickness(stretch) / 2 + 0.01
    for room in rooms:
        side = -reach if room == stretch.first else reach
        ends = [(stretch.line + side, low), (stretch.line + side, high)]
        line = shapely.LineString(ends if stretch.upright else [end[::-1] for end in ends])
        seen = shapely.get_coordinates(line.intersection(plan.rooms[room]))
        if not len(seen):
            return 0.0, 0.0
        along = seen[:, 1 if stretch.upright else 0]
        low, high = max(low, float(along.min())), min(high, float(along.max()))
    return low, high


def _along(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw a place between two limits: at either end or anywhere, m."""
    choice = int(rng.integers(3))
    anywhere = float(rng.uniform(low, high)) if high > low else (low + high) / 2
    return round((low, high, anywhere)[choice] if high > low else anywhere, 2)


def _entrance(
    rng: np.random.Generator, plan: FloorPlan, doorways: Sequence[Doorway]
) -> Doorway | None:
    """Draw the closed entrance door, into the hall if it has an outer wall."""
    for room in dict.fromkeys((plan.hub, 0)):
        fitting = []
        for stretch in plan.between(room, OUTSIDE):
            low, high = _clear_span(plan, stretch, [room])
            if high - low >= 0.8 + 2 * JAMB:
                fitting.append((stretch, low, high))
        if plan.kinds[room] == "corridor" and len(fitting) > 1:
            # The end of a corridor rather than its side.
            fitting = [min(fitting, key=lambda item: item[2] - item[1])]
        if fitting:
            stretch, low, high = fitting[int(rng.integers(len(fitting)))]
            width = min(0.92, round(high - low - 2 * JAMB, 2))
            along = _along(rng, low + JAMB + width / 2, high - JAMB - width / 2)
            return Doorway(stretch.point(along), width, stretch.upright, room, OUTSIDE)
    return None


def draw_threshold(rng: np.random.Generator) -> Threshold | None:
    """What lies in one home's doorways where the floor changes; nothing in some homes."""
    if rng.random() < 0.35:
        return None
    return Threshold(
        height=round(float(rng.uniform(0.003, 0.009)), 4),
        depth=round(float(rng.uniform(0.03, 0.08)), 3),
        material=str(rng.choice(["metal", "brass", "wood", "wood_light"])),
    )


def draw_panes(
    rng: np.random.Generator, plan: FloorPlan, doorways: Sequence[Doorway]
) -> tuple[Pane, ...]:
    """Windows in the outer walls; every room with a long enough one has at least one."""
    entrance = doorways[-1]
    spacing = float(rng.uniform(2.2, 3.6))
    panes: list[Pane] = []
    for room in range(len(plan.kinds)):
        spans = []
        for stretch in plan.between(room, OUTSIDE):
            low, high = _clear_span(plan, stretch, [room])
            if high - low > 1.0:
                spans.append((stretch, low, high))
        spans.sort(key=lambda item: item[1] - item[2])
        for k, (stretch, low, high) in enumerate(spans):
            # Rooms at a corner of the building have a second window wall now and then.
            if k == 0 or rng.random() < 0.35:
                for along, *size in _row(rng, plan.kinds[room], (low, high), spacing):
                    panes.append(Pane(room, stretch.point(along), stretch.upright, *size))
    return tuple(pane for pane in panes if _apart(pane, entrance))


def _row(
    rng: np.random.Generator, kind: RoomKind, span: tuple[float, float], spacing: float
) -> Iterator[tuple[float, float, float, float]]:
    """Windows evenly along a wall: where, width, sill and head, m."""
    width, sill, head = _WINDOWS.get(kind, (float(rng.uniform(1.1, 1.9)), 0.85, 2.15))
    low, high = span
    count = max(1, int((high - low) / spacing))
    step = (high - low) / count
    # The first window of a living room may be a glass door to a balcony.
    balcony = kind == "living_room" and rng.random() < 0.4
    for k in range(count):
        heights = BALCONY if balcony and k == 0 else (sill, head)
        yield round(low + step * (k + 0.5), 2), round(min(width, step - 0.45), 2), *heights


def _apart(pane: Pane, entrance: Doorway) -> bool:
    """Whether a window leaves the entrance door its wall."""
    gap = float(np.hypot(*np.subtract(pane.position, entrance.position)))
    return gap > (pane.width + entrance.width) / 2 + 0.35
