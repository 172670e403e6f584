"""Floor plans by recursive splits of a rectangle around a hub.

The subdivision is a slice-and-dice treemap (Shneiderman 1992) whose hierarchy,
social part first and then a corridor with the private rooms along it, follows
Marson and Musse (2010). They squarify the treemap and add a corridor
afterwards where rooms have no door; here the corridor is split off first and
every slice touches it, so that all rooms open to the hub by construction and
no bathroom is ever the way to another room.

Either the corridor is the hub (living room at one end over the full depth, the
other rooms in one or two bands along the corridor) or, in small homes, the
living room itself with the others along one of its sides. Cells are bounded by
wall centre lines; a clear room is the cell without half of each wall.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from scenes.apartment import RoomKind

__all__ = ["Cell", "Door", "FloorPlan", "draw_plan"]

OUTER, INNER = 0.28, 0.12
"""Wall thicknesses, m."""
JAMB = 0.16
"""Least distance from a doorway's clear width to a corner of the room, m."""

PROGRAMME: tuple[RoomKind, ...] = (
    "living_room",
    "bathroom",
    "bedroom",
    "corridor",
    "kitchen",
    "bedroom",
    "office",
    "storage",
    "bedroom",
    "bathroom",
    "bedroom",
    "other",
)
"""Kinds in the order in which homes of growing size get them."""

SHARE = {
    "living_room": 4.0,
    "bedroom": 2.6,
    "kitchen": 1.9,
    "office": 2.1,
    "other": 1.8,
    "bathroom": 1.2,
    "storage": 0.9,
}
"""Areas of the rooms relative to each other; the corridor has a width instead."""

LEAST_SIDE = {
    "living_room": 2.6,
    "bedroom": 2.1,
    "kitchen": 1.8,
    "office": 1.9,
    "other": 1.8,
    "bathroom": 1.5,
    "storage": 1.2,
    "corridor": 1.0,
}
"""Least clear side of a room, m."""


@dataclass(frozen=True)
class Cell:
    """A room's rectangle between wall centre lines: corners (x0, y0) and (x1, y1), m."""

    kind: RoomKind
    x0: float
    y0: float
    x1: float
    y1: float


@dataclass(frozen=True)
class Door:
    """A doorway of clear ``width`` m at ``position`` between two cells (indices).

    ``second`` is -1 for the entrance door; ``upright``: the wall runs along y.
    """

    position: tuple[float, float]
    width: float
    upright: bool
    first: int
    second: int


@dataclass(frozen=True)
class FloorPlan:
    """Cells, inner walls (k, 2, 2) and doors; ``size`` of the centre-line rectangle, m."""

    cells: tuple[Cell, ...]
    walls: tuple[tuple[tuple[float, float], tuple[float, float]], ...]
    doors: tuple[Door, ...]
    size: tuple[float, float]
    hub: int

    def clear(self, index: int) -> tuple[float, float, float, float]:
        """Clear rectangle (x0, y0, x1, y1) of a room between the wall faces, m."""
        cell = self.cells[index]
        width, depth = self.size
        trim = [
            (OUTER if value in (0.0, limit) else INNER) / 2
            for value, limit in (
                (cell.x0, width),
                (cell.y0, depth),
                (cell.x1, width),
                (cell.y1, depth),
            )
        ]
        x0, y0, x1, y1 = cell.x0 + trim[0], cell.y0 + trim[1], cell.x1 - trim[2], cell.y1 - trim[3]
        return round(x0, 3), round(y0, 3), round(x1, 3), round(y1, 3)

    def clear_area(self) -> float:
        """Sum of the clear rectangles, m²."""
        boxes = [self.clear(index) for index in range(len(self.cells))]
        return sum((x1 - x0) * (y1 - y0) for x0, y0, x1, y1 in boxes)


@dataclass(frozen=True)
class _Sketch:
    """What chance decides of a plan, before its size is known."""

    bands: tuple[tuple[RoomKind, ...], ...]
    weights: tuple[tuple[float, ...], ...]
    living: float
    aspect: float
    corridor: float | None


def draw_plan(rng: np.random.Generator, rooms: int, area: float) -> FloorPlan | None:
    """One random plan of that many rooms and clear floor area (m²).

    Returns
    -------
    FloorPlan or None
        None if this draw has a room that is too narrow or too long; draw again.
    """
    sketch = _draw_sketch(rng, rooms)
    gross = 1.1 * area
    plan = _build(sketch, gross)
    for _ in range(8):
        gross *= area / plan.clear_area() if plan.clear_area() > 0.0 else 2.0
        plan = _build(sketch, gross)
    if not _acceptable(plan, area):
        return None
    plan = _with_doors(rng, plan)
    return _mirrored(plan, bool(rng.integers(2)), bool(rng.integers(2)))


def _draw_sketch(rng: np.random.Generator, rooms: int) -> _Sketch:
    kinds = list(PROGRAMME[:rooms])
    open_hub = rooms < 4 or (rooms == 4 and rng.random() < 0.4)
    if open_hub:
        kinds = ["kitchen" if kind == "corridor" else kind for kind in kinds]
    others = [kind for kind in kinds if kind not in ("living_room", "corridor")]
    rng.shuffle(others)
    weight = {kind: SHARE[kind] * rng.uniform(0.85, 1.2) for kind in sorted(set(others))}
    two = not open_hub and len(others) > 2 and rng.random() < 0.8
    bands: list[list[RoomKind]] = [[], []] if two else [[]]
    for kind in sorted(others, key=lambda kind: -weight[kind]) if two else others:
        min(bands, key=lambda band: sum(weight[k] for k in band)).append(kind)
    for band in bands:
        rng.shuffle(band)
    return _Sketch(
        bands=tuple(tuple(band) for band in bands),
        weights=tuple(tuple(weight[kind] for kind in band) for band in bands),
        living=SHARE["living_room"] * float(rng.uniform(0.8, 1.2)),
        aspect=float(rng.uniform(1.0, 2.4 if open_hub else 1.4 + 0.12 * rooms)),
        corridor=None if open_hub else float(rng.uniform(1.1, 1.5)) + INNER,
    )


def _cuts(start: float, end: float, weights: Sequence[float]) -> list[float]:
    """Borders of slices between start and end, in proportion to the weights, m."""
    shares = np.cumsum([0.0, *weights]) / sum(weights) if weights else np.array([0.0, 1.0])
    return [round(float(value), 2) for value in start + (end - start) * shares]


def _build(sketch: _Sketch, gross: float) -> FloorPlan:
    """Build the plan of a sketch with that area (m²) inside the outer centre lines."""
    depth = round(float(np.sqrt(gross / sketch.aspect)), 2)
    width = round(gross / depth, 2)
    rest = sum(map(sum, sketch.weights))
    share = sketch.living / (sketch.living + rest)
    if rest == 0.0:
        return FloorPlan((Cell("living_room", 0.0, 0.0, width, depth),), (), (), (width, depth), 0)
    if sketch.corridor is None:
        return _around_living(sketch, round(share * width, 2), width, depth)
    side = share * width * (depth - sketch.corridor) / (depth - share * sketch.corridor)
    return _along_corridor(sketch, round(side, 2), width, depth)


def _around_living(sketch: _Sketch, side: float, width: float, depth: float) -> FloorPlan:
    """Living room as hub, one band along its right side."""
    cells = [Cell("living_room", 0.0, 0.0, side, depth)]
    walls = [((side, 0.0), (side, depth))]
    levels = _cuts(0.0, depth, sketch.weights[0])
    for kind, (low, high) in zip(sketch.bands[0], pairwise(levels), strict=True):
        cells.append(Cell(kind, side, low, width, high))
    walls += [((side, y), (width, y)) for y in levels[1:-1]]
    return FloorPlan(tuple(cells), tuple(walls), (), (width, depth), 0)


def _along_corridor(sketch: _Sketch, side: float, width: float, depth: float) -> FloorPlan:
    """Living room at the left end, corridor to the right, bands below and above it."""
    assert sketch.corridor is not None
    sums = [sum(weights) for weights in sketch.weights]
    free = depth - sketch.corridor
    low = round(free * sums[0] / sum(sums), 2) if len(sums) == 2 else 0.0
    high = round(low + sketch.corridor, 2)
    cells = [Cell("living_room", 0.0, 0.0, side, depth), Cell("corridor", side, low, width, high)]
    walls = [((side, 0.0), (side, depth)), ((side, high), (width, high))]
    spans = [(high, depth)] if len(sums) == 1 else [(0.0, low), (high, depth)]
    if len(sums) == 2:
        walls.append(((side, low), (width, low)))
    for kinds, weights, (y0, y1) in zip(sketch.bands, sketch.weights, spans, strict=True):
        borders = _cuts(side, width, weights)
        for kind, (x0, x1) in zip(kinds, pairwise(borders), strict=True):
            cells.append(Cell(kind, x0, y0, x1, y1))
        walls += [((x, y0), (x, y1)) for x in borders[1:-1]]
    return FloorPlan(tuple(cells), tuple(walls), (), (width, depth), 1)


def _acceptable(plan: FloorPlan, area: float) -> bool:
    """Whether every room is wide enough, none is a tube, and the area is met within 2 %."""
    for index, cell in enumerate(plan.cells):
        x0, y0, x1, y1 = plan.clear(index)
        short, long = sorted((x1 - x0, y1 - y0))
        if short < LEAST_SIDE[cell.kind] or (cell.kind != "corridor" and long > 2.6 * short):
            return False
    return abs(plan.clear_area() - area) <= 0.02 * area


def _with_doors(rng: np.random.Generator, plan: FloorPlan) -> FloorPlan:
    """One doorway from the hub to every other room, and the entrance into the hub."""
    doors = [_doorway(rng, plan, index) for index in range(len(plan.cells)) if index != plan.hub]
    return replace(plan, doors=(*doors, _entrance(rng, plan)))


def _doorway(rng: np.random.Generator, plan: FloorPlan, index: int) -> Door:
    """Draw a doorway in the wall that the hub shares with a room, often near a corner."""
    hub, cell = plan.cells[plan.hub], plan.cells[index]
    upright = cell.x0 == hub.x1 or cell.x1 == hub.x0
    a, b = plan.clear(plan.hub), plan.clear(index)
    axis = 1 if upright else 0
    low, high = max(a[axis], b[axis]), min(a[axis + 2], b[axis + 2])
    width = 0.76 if cell.kind in ("bathroom", "storage") else float(rng.choice([0.8, 0.86, 0.92]))
    width = min(width, round(high - low - 2 * JAMB, 2))
    place = _along(rng, low + JAMB + width / 2, high - JAMB - width / 2)
    if upright:
        line = cell.x0 if cell.x0 == hub.x1 else cell.x1
        return Door((line, place), width, True, plan.hub, index)
    line = cell.y0 if cell.y0 == hub.y1 else cell.y1
    return Door((place, line), width, False, plan.hub, index)


def _entrance(rng: np.random.Generator, plan: FloorPlan) -> Door:
    """Draw the closed entrance door: at the corridor's end, or in the living room's lower wall."""
    x0, y0, x1, y1 = plan.clear(plan.hub)
    width = min(0.9, round(y1 - y0 - 0.2, 2))
    if plan.cells[plan.hub].kind == "corridor":
        return Door((plan.size[0], round((y0 + y1) / 2, 2)), width, True, plan.hub, -1)
    place = _along(rng, x0 + JAMB + width / 2, x1 - JAMB - width / 2)
    return Door((place, 0.0), width, False, plan.hub, -1)


def _along(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw a place between two limits: at either end or anywhere, m."""
    choice = int(rng.integers(3))
    anywhere = float(rng.uniform(low, high)) if high > low else (low + high) / 2
    return round((low, high, anywhere)[choice] if high > low else anywhere, 2)


def _mirrored(plan: FloorPlan, in_x: bool, in_y: bool) -> FloorPlan:
    """Flip the plan left to right, upside down, both or neither."""
    width, depth = plan.size

    def flip(point: tuple[float, float]) -> tuple[float, float]:
        x, y = point
        return round(width - x if in_x else x, 3), round(depth - y if in_y else y, 3)

    cells = []
    for cell in plan.cells:
        (xa, ya), (xb, yb) = flip((cell.x0, cell.y0)), flip((cell.x1, cell.y1))
        cells.append(Cell(cell.kind, min(xa, xb), min(ya, yb), max(xa, xb), max(ya, yb)))
    return replace(
        plan,
        cells=tuple(cells),
        walls=tuple((flip(a), flip(b)) for a, b in plan.walls),
        doors=tuple(replace(door, position=flip(door.position)) for door in plan.doors),
    )
