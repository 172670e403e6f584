"""Furniture along the walls of a room, with its doors and ways kept clear.

Every kind of room has a list of what it needs and what may fill it further.
Pieces stand with their back to a wall, tables with chairs anywhere; a place is
drawn at random and kept if nothing overlaps, doorways stay clear, tall pieces
leave the windows free, and all doorways of the room remain joined by a way of
`WAY` m clear width. Filling stops when the robot can drive on about as much of
the floor as in the homes of Table 8 (15 to 22 nodes of 0.03 m² per m²).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import Polygon

from scenes.apartment import Piece, RoomKind
from scenes.passages import ROBOT_RADIUS

__all__ = ["Site", "furnish", "ways"]

WAY = 0.5
"""Clear width that must remain from doorway to doorway and to most of the room, m."""
DRIVEN = 0.46
"""Share of the floor for the robot's centre at which filling stops; tables count as solid here."""
TRIES = 40


@dataclass(frozen=True)
class Site:
    """An empty room to furnish.

    ``box`` (x0, y0, x1, y1) m; ``doors`` keep-clear zones with the point just
    inside each doorway; ``windows`` zones that tall pieces leave free.
    """

    kind: RoomKind
    box: tuple[float, float, float, float]
    ceiling: float
    doors: tuple[Polygon, ...]
    entries: tuple[tuple[float, float], ...]
    windows: tuple[Polygon, ...]
    has_kitchen: bool


@dataclass(frozen=True)
class Item:
    """A piece to place: its kind, size and whether it needs a wall behind it."""

    kind: str
    size: tuple[float, float, float]
    wall: bool = True
    chairs: int = 0

    @property
    def footprint(self) -> tuple[float, float]:
        """Width and depth with the chairs around it, m."""
        return self.size[0], self.size[1] + (0.8 if self.chairs else 0.0)


def furnish(rng: np.random.Generator, site: Site) -> tuple[Piece, ...]:
    """Pieces for one room, deterministic for the generator's state."""
    pieces: list[Piece] = []
    taken: list[Polygon] = []
    for item in _needs(rng, site):
        _add(rng, site, item, pieces, taken)
    for item in _fillers(rng, site):
        if ways(site, taken, ROBOT_RADIUS).area <= DRIVEN * _room(site).area:
            break
        _add(rng, site, item, pieces, taken)
    fittings = (*_over(site, pieces), *_radiators(site, taken), *_pictures(rng, site, taken))
    return (*pieces, *fittings)


def ways(site: Site, taken: Sequence[Polygon], radius: float) -> shapely.Geometry:
    """Where a disc of that radius (m) can be centred when it comes in at the first doorway."""
    free = _room(site).buffer(-radius, join_style="mitre")
    free = free.difference(shapely.union_all(list(taken)).buffer(radius))
    parts = [part for part in shapely.get_parts(free) if part.geom_type == "Polygon"]
    if not parts:
        return Polygon()
    if not site.entries:
        return max(parts, key=lambda part: part.area)
    return min(parts, key=lambda part: part.distance(shapely.Point(site.entries[0])))


def _room(site: Site) -> Polygon:
    return shapely.box(*site.box)


def _add(
    rng: np.random.Generator, site: Site, item: Item, pieces: list[Piece], taken: list[Polygon]
) -> None:
    """Place an item if a place is found among `TRIES`; otherwise leave it out."""
    for _ in range(TRIES):
        position, turn = _against_wall(rng, site, item) if item.wall else _free(rng, site, item)
        shape = _turned(item.footprint, position, turn)
        if _fits(site, item, shape, taken):
            pieces.extend(_pieces(item, position, turn))
            taken.append(shape)
            return


def _against_wall(
    rng: np.random.Generator, site: Site, item: Item
) -> tuple[tuple[float, float], float]:
    """Draw a place with the back at a wall, half of them in a corner."""
    x0, y0, x1, y1 = site.box
    side = int(rng.integers(4))
    low, high = (y0, y1) if side % 2 else (x0, x1)
    width, depth = item.footprint
    ends = (low + 0.03 + width / 2, high - 0.03 - width / 2)
    along = rng.uniform(*ends) if ends[1] > ends[0] else (low + high) / 2
    if rng.random() < 0.5:
        along = ends[int(rng.integers(2))]
    inset = (0.005 if item.kind == "picture" else 0.02) + depth / 2
    place = ((along, y1 - inset), (x0 + inset, along), (along, y0 + inset), (x1 - inset, along))
    x, y = place[side]
    return (round(float(x), 3), round(float(y), 3)), (0.0, 90.0, 180.0, -90.0)[side]


def _free(rng: np.random.Generator, site: Site, item: Item) -> tuple[tuple[float, float], float]:
    """Draw a place anywhere in the room, along either axis."""
    x0, y0, x1, y1 = site.box
    turn = 90.0 * int(rng.integers(2))
    half = max(item.footprint) / 2
    x = rng.uniform(x0 + half, x1 - half) if x1 - x0 > 2 * half else (x0 + x1) / 2
    y = rng.uniform(y0 + half, y1 - half) if y1 - y0 > 2 * half else (y0 + y1) / 2
    return (round(float(x), 3), round(float(y), 3)), turn


def _turned(size: tuple[float, float], position: tuple[float, float], turn: float) -> Polygon:
    """Footprint of a size (m) turned by a multiple of 90°."""
    width, depth = size if turn % 180.0 == 0.0 else size[::-1]
    x, y = position
    return shapely.box(x - width / 2, y - depth / 2, x + width / 2, y + depth / 2)


def _fits(site: Site, item: Item, shape: Polygon, taken: Sequence[Polygon]) -> bool:
    """Inside, apart from everything, and all doorways still joined by a clear way."""
    if not _room(site).buffer(-0.005, join_style="mitre").covers(shape):
        return False
    if any(shape.intersects(zone) for zone in site.doors):
        return False
    if any(shape.distance(other) < 0.01 for other in taken):
        return False
    if item.size[2] > 0.95 and any(shape.intersects(zone) for zone in site.windows):
        return False
    clear = ways(site, [*taken, shape], WAY / 2)
    if clear.area < 0.12 * _room(site).area:
        return False
    return all(clear.distance(shapely.Point(entry)) < 0.1 for entry in site.entries)


def _pieces(item: Item, position: tuple[float, float], turn: float) -> Iterator[Piece]:
    """Yield the piece itself and what belongs under or around it."""
    yield Piece(kind=item.kind, position=position, rotation_deg=turn, size=item.size)
    if item.kind in _BASES:
        inset, height = _BASES[item.kind]
        size = (round(item.size[0] - inset, 3), round(item.size[1] - inset, 3), height)
        yield Piece(
            kind="box", position=position, rotation_deg=turn, size=size, materials={"body": "wood"}
        )
    for k in range(item.chairs):
        side = 1 if k % 2 else -1
        row, per_side = k // 2, (item.chairs + 1) // 2
        along = item.size[0] * ((row + 0.5) / per_side - 0.5)
        across = side * (item.size[1] / 2 + 0.15)
        dx, dy = (along, across) if turn % 180.0 == 0.0 else (-across, along)
        x, y = round(position[0] + dx, 3), round(position[1] + dy, 3)
        back = turn if side > 0 else turn + 180.0
        yield Piece(kind="chair", position=(x, y), rotation_deg=back, size=(0.43, 0.46, 0.88))


_BASES = {"bed": (0.04, 0.17), "sofa": (0.1, 0.115), "tv_stand": (0.04, 0.125)}
"""Inset (m) and height (m) of the drawer box that closes the space under a piece."""


def _needs(rng: np.random.Generator, site: Site) -> Iterator[Item]:
    """Yield what a room of its kind needs, the largest first."""
    make = _NEEDS.get(site.kind)
    if make is not None:
        yield from make(rng, _room(site).area)
    if site.kind == "living_room" and not site.has_kitchen:
        yield Item("kitchen_counter", (float(rng.choice([1.5, 1.8, 2.1])), 0.62, 0.9))
        yield Item("fridge", (0.6, 0.65, 1.8))


def _living_room(rng: np.random.Generator, area: float) -> Iterator[Item]:
    yield Item("sofa", (1.6 if area < 14 else 2.1, 0.9, 0.82))
    yield Item("tv_stand", (1.2 if area < 14 else 1.6, 0.42, 1.1))
    if area > 12:
        yield Item("table", (1.4, 0.8, 0.75), wall=False, chairs=4)
    yield Item("coffee_table", (0.9, 0.55, 0.42), wall=False)


def _bedroom(rng: np.random.Generator, area: float) -> Iterator[Item]:
    yield Item("bed", (0.9 if area < 8 else 1.5, 2.02, 0.9))
    yield Item("wardrobe", (1.0 if area < 8 else 1.7, 0.6, 2.1))
    if rng.random() < 0.4:
        yield Item("desk", (1.2, 0.6, 0.74))


def _kitchen(rng: np.random.Generator, area: float) -> Iterator[Item]:
    yield Item("kitchen_counter", (float(rng.choice([1.6, 1.9, 2.3])), 0.62, 0.9))
    yield Item("fridge", (0.6, 0.65, 1.8))
    if area > 8:
        yield Item("table", (1.0, 0.7, 0.75), wall=False, chairs=2)


def _bathroom(rng: np.random.Generator, area: float) -> Iterator[Item]:
    tub = area > 4.2 and rng.random() < 0.6
    yield Item("bath", (1.65, 0.72, 0.56)) if tub else Item("shower_tray", (0.85, 0.85, 0.05))
    yield Item("toilet", (0.38, 0.65, 0.8))
    yield Item("basin", (0.55, 0.45, 0.86))


def _office(rng: np.random.Generator, area: float) -> Iterator[Item]:
    yield Item("desk", (1.4, 0.65, 0.74))
    yield Item("shelf", (1.2 if area > 6 else 0.8, 0.35, 1.9))


def _shelves(rng: np.random.Generator, area: float) -> Iterator[Item]:
    yield Item("shelf", (0.9, 0.25 if area < 4 else 0.4, 1.8))


_NEEDS: dict[RoomKind, Callable[[np.random.Generator, float], Iterator[Item]]] = {
    "living_room": _living_room,
    "bedroom": _bedroom,
    "kitchen": _kitchen,
    "bathroom": _bathroom,
    "office": _office,
    "storage": _shelves,
    "corridor": _shelves,
}


def _fillers(rng: np.random.Generator, site: Site) -> Iterator[Item]:
    """More pieces for a room that is still too empty, in random order."""
    choices = {
        "living_room": ("shelf", "armchair", "plant", "low_shelf", "box", "armchair"),
        "bedroom": ("low_shelf", "shelf", "box", "armchair", "plant"),
        "kitchen": ("shelf", "low_shelf", "box"),
        "bathroom": ("washing_machine", "box", "shelf"),
        "corridor": ("narrow", "narrow"),
        "office": ("shelf", "low_shelf", "armchair", "plant", "shelf"),
    }
    kinds = choices.get(site.kind, ("shelf", "low_shelf", "box", "table"))
    rounds = 1 + int(_room(site).area / 12.0)
    for kind in rng.permutation(kinds * rounds):
        yield _FILLERS[str(kind)]


_FILLERS = {
    "shelf": Item("shelf", (1.0, 0.35, 1.9)),
    "low_shelf": Item("shelf", (1.1, 0.4, 0.85)),
    "narrow": Item("shelf", (0.7, 0.24, 0.9)),
    "armchair": Item("armchair", (0.8, 0.82, 0.84)),
    "plant": Item("plant", (0.5, 0.5, 1.1)),
    "box": Item("box", (0.5, 0.42, 0.5)),
    "table": Item("table", (1.0, 0.6, 0.75)),
    "washing_machine": Item("washing_machine", (0.6, 0.6, 0.85)),
}


def _over(site: Site, pieces: Sequence[Piece]) -> Iterator[Piece]:
    """Cupboards over the kitchen counter and a mirror over the basin, clear of windows."""
    for piece in pieces:
        if piece.kind not in _OVER or piece.size is None:
            continue
        kind, depth, height, elevation = _OVER[piece.kind]
        position, size = _back(piece, depth), (piece.size[0], depth, height)
        shape = _turned((size[0], size[1]), position, piece.rotation_deg)
        if not any(shape.intersects(zone) for zone in site.windows):
            yield Piece(
                kind=kind,
                position=position,
                rotation_deg=piece.rotation_deg,
                elevation=elevation,
                size=size,
            )


_OVER = {
    "kitchen_counter": ("wall_cupboard", 0.36, 0.65, 1.42),
    "basin": ("picture", 0.03, 0.6, 1.25),
}
"""What hangs over a piece: kind, depth, height and elevation, m."""


def _radiators(site: Site, taken: Sequence[Polygon]) -> Iterator[Piece]:
    """A radiator under each window that no piece stands before."""
    x0, y0, x1, y1 = site.box
    for zone in site.windows:
        a, b, c, d = zone.bounds
        upright = a == x0 or c == x1
        length = round(min(1.2, (d - b if upright else c - a) - 0.15), 3)
        side = (d == y1, a == x0, b == y0, c == x1) if not upright else (0, a == x0, 0, c == x1)
        turn = (0.0, 90.0, 180.0, -90.0)[side.index(True)]
        x = (x0 + 0.08 if a == x0 else x1 - 0.08) if upright else (a + c) / 2
        y = (b + d) / 2 if upright else (y1 - 0.08 if d == y1 else y0 + 0.08)
        place = (round(x, 3), round(y, 3))
        shape = _turned((length, 0.1), place, turn)
        blocked = any(shape.intersects(other) for other in (*taken, *site.doors))
        if length > 0.4 and not blocked and _room(site).covers(shape):
            yield Piece(
                kind="radiator", position=place, rotation_deg=turn, size=(length, 0.1, 0.65)
            )


def _pictures(rng: np.random.Generator, site: Site, taken: Sequence[Polygon]) -> Iterator[Piece]:
    """Up to two pictures on bare walls at eye height."""
    zones = [*taken, *site.doors, *site.windows]
    for _ in range(2):
        width, height = (round(float(value), 2) for value in rng.uniform(0.35, 0.8, 2))
        item = Item("picture", (width, 0.03, height))
        position, turn = _against_wall(rng, site, item)
        shape = _turned(item.footprint, position, turn)
        if _room(site).covers(shape) and not any(shape.intersects(zone) for zone in zones):
            yield Piece(
                kind="picture", position=position, rotation_deg=turn, elevation=1.3, size=item.size
            )
            zones.append(shape)


def _back(piece: Piece, depth: float) -> tuple[float, float]:
    """Where something of that depth (m) hangs at the wall behind a piece."""
    assert piece.size is not None
    angle = np.radians(piece.rotation_deg)
    shift = (piece.size[1] - depth) / 2 + 0.01
    x, y = piece.position
    return round(float(x - shift * np.sin(angle)), 3), round(float(y + shift * np.cos(angle)), 3)
