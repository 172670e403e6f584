"""Checks of rooms against walls, and of the openings in the walls."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from scenes.apartment import Apartment, Passage, Point, Window
from scenes.openings import Opening, lining_of, nearest_wall, place
from scenes.rooms import room_shapes
from scenes.solids import GAP, building_region, masonry_region, passage_rooms

__all__ = [
    "TOLERANCE",
    "check_covered_floor",
    "check_enclosure",
    "check_openings",
    "check_overlaps",
    "check_shared_openings",
    "is_thick",
    "metres",
    "opening_rectangle",
]

Shapes = NDArray[np.object_]

TOLERANCE = 0.02
"""How far things may reach into one another before it is a mistake, m."""
FRAME_LIMIT = 0.3
"""The widest and deepest door frame, m."""


def metres(point: Iterable[float]) -> str:
    """Text of a point, to three digits."""
    return "(" + ", ".join(f"{value:.3g}" for value in point) + ")"


def is_thick(region: shapely.Geometry) -> bool:
    """Whether a region is wider than the tolerance anywhere."""
    return not region.buffer(-TOLERANCE / 2).is_empty


def check_overlaps(apartment: Apartment) -> Iterator[str]:
    """Yield the pairs of rooms that overlap."""
    shapes = room_shapes(apartment)
    for b, a in _meeting(shapes, shapes):
        shared = shapes[a].intersection(shapes[b])
        if a < b and is_thick(shared):
            other = apartment.rooms[a].name
            yield (
                f"rooms[{b}].polygon: {apartment.rooms[b].name!r} overlaps {other!r} by "
                f"{shared.area:.3g} m²; expected clear floors apart by a wall"
            )


def check_covered_floor(apartment: Apartment) -> Iterator[str]:
    """Yield the walls that stand on a room's clear floor."""
    shapes = room_shapes(apartment)
    bands = [
        shapely.LineString([wall.start, wall.end]).buffer(wall.thickness / 2, cap_style="flat")
        for wall in apartment.walls
    ]
    for index, number in _meeting(np.array(bands, dtype=object), shapes):
        covered = bands[index].intersection(shapes[number])
        if is_thick(covered):
            wall, room = apartment.walls[index], apartment.rooms[number]
            yield (
                f"walls[{index}]: from {metres(wall.start)} to {metres(wall.end)}, "
                f"{wall.thickness:.3g} m thick, covers {covered.area:.3g} m² of the clear "
                f"floor of {room.name!r}; expected the room to end at the wall's face"
            )


def _meeting(shapes: Shapes, others: Shapes) -> list[tuple[int, int]]:
    """Indices of the shapes and others that touch or overlap, in order."""
    pairs = shapely.STRtree(others).query(shapes, predicate="intersects")
    return [(int(a), int(b)) for a, b in sorted(pairs.T.tolist())]


def check_enclosure(apartment: Apartment) -> Iterator[str]:
    """Yield the sides of rooms that no wall closes."""
    bands = [
        shapely.LineString([wall.start, wall.end]).buffer(
            wall.thickness / 2 + GAP, cap_style="square", join_style="mitre"
        )
        for wall in apartment.walls
    ]
    masonry = masonry_region(apartment).buffer(GAP, join_style="mitre")
    # A side may also be a declared border to a room that no wall parts.
    own = shapely.linestrings(np.array(apartment.borders, dtype=float).reshape(-1, 2, 2))
    walls = shapely.union_all([*bands, masonry, *shapely.buffer(own, GAP)])
    # Asking whether a side is covered is much cheaper than cutting the walls out of it.
    shapely.prepare(walls)
    for index, room in enumerate(apartment.rooms):
        corners = [*room.polygon, room.polygon[0]]
        for a, b in itertools.pairwise(corners):
            side = shapely.LineString([a, b])
            if not walls.covers(side) and (bare := side.difference(walls)).length > TOLERANCE:
                yield (
                    f"rooms[{index}].polygon: the side of {room.name!r} from {metres(a)} to "
                    f"{metres(b)} has no wall along {bare.length:.3g} m; expected a wall (open "
                    f"plans: a wall with a wide passage without lintel, or a line in `borders`)"
                )


def check_openings(apartment: Apartment) -> Iterator[str]:
    """Yield passages and windows that fit into no wall, or join the wrong things."""
    for index, passage in enumerate(apartment.passages):
        field = f"passages[{index}]"
        if problem := _off_wall(apartment, passage.position):
            yield f"{field}.position: {problem}"
        else:
            yield from _passage(apartment, passage, field)
    building = building_region(apartment) if apartment.windows else Polygon()
    for index, window in enumerate(apartment.windows):
        field = f"windows[{index}]"
        if problem := _off_wall(apartment, window.position):
            yield f"{field}.position: {problem}"
        else:
            yield from _window(apartment, window, field, building)


def _off_wall(apartment: Apartment, position: Point) -> str | None:
    if not apartment.walls:
        return f"{metres(position)} lies on no wall: there are none; expected one in `walls`"
    index, distance = nearest_wall(apartment.walls, position)
    if distance <= TOLERANCE:
        return None
    on_line = place(apartment, position, 1.0).centre
    return (
        f"{metres(position)} lies on no wall's centre line; the nearest is that of "
        f"walls[{index}], {distance:.3g} m away; expected a point on one, such as "
        f"{metres(on_line)}"
    )


def _passage(apartment: Apartment, passage: Passage, field: str) -> Iterator[str]:
    right, left = passage_rooms(apartment, passage)
    joined = [index for index in (right, left) if index is not None]
    if not joined or (len(joined) < 2 and not passage.closed):
        names = " and ".join(repr(apartment.rooms[i].name) for i in joined) or "no room"
        yield (
            f"{field}.position: {metres(passage.position)} joins {names} only; expected a wall "
            f"between two rooms, or closed: true"
        )
        return
    if passage.frame is not None and max(passage.frame.width, passage.frame.depth) > FRAME_LIMIT:
        size = f"{passage.frame.width:g} x {passage.frame.depth:g} m"
        yield f"{field}.frame: {size}; expected width and depth of at most {FRAME_LIMIT:g} m"
    opening = place(apartment, passage.position, passage.width)
    sides = [(side, i) for side, i in ((-1.0, right), (1.0, left)) if i is not None]
    yield from _too_wide(apartment, opening, sides, lining_of(passage), field)
    lowest = min((apartment.rooms[i] for i in joined), key=lambda room: room.ceiling_height)
    if passage.lintel_height is not None and passage.lintel_height > lowest.ceiling_height + 1e-9:
        yield (
            f"{field}.lintel_height: {passage.lintel_height:g} m is above the ceiling of "
            f"{lowest.name!r}; expected at most {lowest.ceiling_height:g}, or null for none"
        )


def _window(
    apartment: Apartment, window: Window, field: str, building: shapely.Geometry
) -> Iterator[str]:
    as_passage = Passage(position=window.position, width=window.width)
    sides = passage_rooms(apartment, as_passage)
    opening = place(apartment, window.position, window.width)
    inner = [(side, i) for side, i in zip((-1.0, 1.0), sides, strict=True) if i is not None]
    reach = opening.thickness / 2 + GAP + 0.02
    outer = [
        shapely.Point(opening.points(np.array([0.0, side * reach])))
        for side, i in zip((-1.0, 1.0), sides, strict=True)
        if i is None
    ]
    if len(inner) != 1 or building.intersects(outer[0]):
        yield (
            f"{field}.position: {metres(window.position)} is not between a room and the outside; "
            f"expected a place on an outer wall"
        )
        return
    yield from _too_wide(apartment, opening, inner, 0.0, field)
    if window.head_height <= window.sill_height:
        yield (
            f"{field}.head_height: {window.head_height:g} m; expected above the sill at "
            f"{window.sill_height:g} m"
        )
    room = apartment.rooms[inner[0][1]]
    if window.head_height > room.ceiling_height + 1e-9:
        yield (
            f"{field}.head_height: {window.head_height:g} m is above the ceiling of "
            f"{room.name!r}; expected at most {room.ceiling_height:g} m"
        )


def _too_wide(
    apartment: Apartment,
    opening: Opening,
    sides: list[tuple[float, int]],
    lining: float,
    field: str,
) -> Iterator[str]:
    """Wider than its wall, or than the stretch of wall that both rooms share."""
    wall = apartment.walls[opening.wall]
    start, end = (
        np.dot(np.array(p) - opening.centre, opening.along) for p in (wall.start, wall.end)
    )
    room_for = 2 * min(-start, end) - 2 * lining
    half = opening.width / 2
    for side, index in sides:
        offset = side * (opening.thickness / 2 + GAP + 0.01)
        front = shapely.LineString(opening.points(np.array([(-half, offset), (half, offset)])))
        seen = front.intersection(Polygon(apartment.rooms[index].polygon))
        room_for = min(room_for, 2 * _half_width(opening, seen))
    if opening.width > room_for + TOLERANCE:
        yield (
            f"{field}.width: {opening.width:g} m does not fit in walls[{opening.wall}] there; "
            f"expected at most {max(room_for, 0.0):.3g} m about {metres(opening.centre)}"
        )


def _half_width(opening: Opening, seen: shapely.Geometry) -> float:
    """How far a line before the opening goes on unbroken from its middle to either side, m."""
    for part in shapely.get_parts(seen):
        if part.is_empty:  # the one part of an empty line
            continue
        along = (shapely.get_coordinates(part) - opening.centre) @ opening.along
        if along.min() <= 0.0 <= along.max():
            return float(min(-along.min(), along.max()))
    return 0.0


def check_shared_openings(apartment: Apartment) -> Iterator[str]:
    """Yield the pairs of openings that overlap."""
    cuts: list[tuple[str, Polygon]] = []
    for index, passage in enumerate(apartment.passages):
        cuts.append(
            (f"passages[{index}]", opening_rectangle(apartment, passage, lining_of(passage)))
        )
    for index, window in enumerate(apartment.windows):
        cuts.append((f"windows[{index}]", opening_rectangle(apartment, window, 0.0)))
    for b, (field, shape) in enumerate(cuts):
        for other, other_shape in cuts[:b]:
            if shape.intersection(other_shape).area > 1e-4:
                yield f"{field}.position: the opening overlaps {other}; expected wall between them"


def opening_rectangle(apartment: Apartment, item: Passage | Window, margin: float) -> Polygon:
    """What an opening, ``margin`` m wider on either side, takes of its wall."""
    opening = place(apartment, item.position, item.width)
    half, face = opening.width / 2 + margin, opening.thickness / 2
    return opening.rectangle((-half, half), (-face, face))
