"""Parting a free floor into rooms, by lines or by rough room polygons.

Lines and room outlines cut the floor into faces. Faces of one room join; faces that
are too small to be a room, or that the robot cannot enter, go to the neighbour with
which they share the longest side. So the rooms always cover the floor without overlap,
however ragged the outlines are.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, Polygon

from scenes.apartment import RoomKind
from scenes.solids import polygons
from scenes.wall_checks import metres

__all__ = ["GRID", "FloorRoom", "part_floor", "shared_sides"]

Floats = NDArray[np.float64]
RoomShape = tuple[str, RoomKind, Polygon]

GRID = 1e-4
"""Coordinates are rounded to this, m."""
SMALLEST = 0.5
"""What is smaller is no room, m²: the strip between two lines across a doorway."""
ENTERED = 2e-3
"""Floor that the robot's centre must reach in a room, m²."""
REACH = 0.1
"""Borders are drawn on this far at either end, so that they meet the walls, m."""


@dataclass(frozen=True)
class FloorRoom:
    """A room of the floor; the holes of its polygon are obstacles.

    ``name`` is empty until the room is named.
    """

    name: str
    kind: RoomKind
    polygon: Polygon


def part_floor(
    floor: Polygon,
    robot_floor: Polygon,
    borders: Floats | None,
    rooms: Sequence[RoomShape] | None,
    tolerance: float,
) -> tuple[list[FloorRoom], tuple[str, ...]]:
    """Part a floor into rooms.

    Parameters
    ----------
    floor : Polygon
        m.
    robot_floor : Polygon
        Where the robot's centre can get to, m.
    borders : array, shape (b, 2, 2), optional
        Segments between rooms, m.
    rooms : sequence of (name, kind, Polygon), optional
        Rough outlines of rooms.
    tolerance : float
        How far the outlines may be moved to get fewer corners, m.

    Returns
    -------
    list of FloorRoom
        They cover the floor; each has a name of its own and can be entered.
    tuple of str
        Notes on borders and rooms that came to nothing.
    """
    segments = np.zeros((0, 2, 2)) if borders is None else np.asarray(borders, dtype=float)
    shapes = list(rooms or [])
    lines = [*_drawn_on(segments), *_outlines(shapes, tolerance)]
    faces = _faces(floor, lines)
    owned = _owned(faces, shapes) if shapes else [FloorRoom("", "other", f) for f in faces]
    parted, lost = _absorb(owned, robot_floor)
    parted, cut = _open_rings(parted)
    named = _named(parted)
    return named, (*_idle_borders(segments, named, floor), *_missing(shapes, owned), *lost, *cut)


def shared_sides(rooms: Sequence[FloorRoom]) -> list[LineString]:
    """The lines along which rooms meet without a wall, m."""
    sides = []
    for index, room in enumerate(rooms):
        for other in rooms[:index]:
            if room.polygon.intersects(other.polygon):
                sides.extend(_shared(room.polygon, other.polygon))
    return sides


def _shared(a: Polygon, b: Polygon) -> list[LineString]:
    """Lines that two polygons have in common."""
    parts = shapely.get_parts(a.boundary.intersection(b.boundary))
    lines = [part for part in parts if part.geom_type == "LineString" and part.length > 1e-3]
    return list(shapely.get_parts(shapely.line_merge(shapely.union_all(lines)))) if lines else []


# ---- cutting --------------------------------------------------------------------------------


def _drawn_on(segments: Floats) -> list[LineString]:
    """Segments made longer at both ends."""
    along = segments[:, 1] - segments[:, 0]
    length = np.hypot(along[:, 0], along[:, 1])
    along = along / np.maximum(length, 1e-9)[:, None] * REACH
    ends = np.stack([segments[:, 0] - along, segments[:, 1] + along], axis=1)
    return [LineString(pair) for pair in ends[length > 1e-6]]


def _outlines(rooms: Sequence[RoomShape], tolerance: float) -> list[LineString]:
    """Outlines of rooms with fewer corners, the shared ones once."""
    if not rooms:
        return []
    merged = shapely.line_merge(shapely.union_all([shape.boundary for _, _, shape in rooms]))
    return list(shapely.get_parts(merged.simplify(tolerance)))


def _faces(floor: Polygon, lines: Sequence[LineString]) -> list[Polygon]:
    """What lines make of a floor."""
    if not lines:
        return [floor]
    # Noded on a grid: corners of faces need no rounding later, which could make them cross.
    noded = shapely.union_all([floor.boundary, *lines], grid_size=GRID)
    faces = polygons(shapely.polygonize(shapely.get_parts(noded)), smallest=0.0)
    shapely.prepare(floor)
    return [face for face in faces if floor.intersects(face.representative_point())]


def _owned(faces: Sequence[Polygon], rooms: Sequence[RoomShape]) -> list[FloorRoom]:
    """Faces joined by the room that covers most of each; the others stay alone."""
    shapes = np.array([shape for _, _, shape in rooms])
    shapely.prepare(shapes)
    owned: dict[int, list[Polygon]] = {}
    alone: list[FloorRoom] = []
    for face in faces:
        near = np.flatnonzero(shapely.intersects(shapes, face))
        shared = shapely.area(shapely.intersection(shapes[near], face))
        if len(near) and shared.max() > 0.5 * face.area:
            owned.setdefault(int(near[shared.argmax()]), []).append(face)
        else:
            alone.append(FloorRoom("", "other", face))
    joined = [
        FloorRoom(rooms[index][0], rooms[index][1], part)
        for index, parts in owned.items()
        for part in polygons(shapely.union_all(parts), smallest=0.0)
    ]
    return joined + alone


def _absorb(
    rooms: list[FloorRoom], robot_floor: Polygon
) -> tuple[list[FloorRoom], tuple[str, ...]]:
    """Give what is no room to its neighbours, the smallest first."""
    rest, notes = list(rooms), []
    entered = [float(room.polygon.intersection(robot_floor).area) for room in rest]
    while len(rest) > 1:
        areas = [room.polygon.area for room in rest]
        unfit = [i for i, area in enumerate(areas) if area < SMALLEST or entered[i] < ENTERED]
        if not unfit:
            break
        index = min(unfit, key=areas.__getitem__)
        room, own = rest.pop(index), entered.pop(index)
        target = _closest_neighbour(room.polygon, rest)
        host = rest[target]
        rest[target] = _joined(host, room)
        entered[target] += own
        if room.polygon.area >= SMALLEST:
            where = metres(shapely.get_coordinates(room.polygon.representative_point())[0])
            notes.append(
                f"{room.name or 'room'} of {room.polygon.area:.1f} m² about {where}: no way in "
                f"for the robot; its floor goes to {host.name or 'the room beside it'}"
            )
    return rest, tuple(notes)


def _closest_neighbour(shape: Polygon, rooms: Sequence[FloorRoom]) -> int:
    """The room that shares the longest side."""
    others = np.array([room.polygon for room in rooms])
    touching = np.flatnonzero(shapely.dwithin(others, shape, 1e-6))
    if not len(touching):
        return int(shapely.distance(others, shape).argmin())
    lengths = shapely.length(shapely.intersection(others[touching], shape))
    return int(touching[lengths.argmax()])


def _joined(host: FloorRoom, guest: FloorRoom) -> FloorRoom:
    union = polygons(shapely.union_all([host.polygon, guest.polygon]), smallest=0.0)
    # Parts that touch in a corner only: the smaller one is a sliver, and is lost.
    return replace(host, polygon=max(union, key=lambda part: part.area))


def _open_rings(rooms: list[FloorRoom]) -> tuple[list[FloorRoom], tuple[str, ...]]:
    """Cut rooms that run around others: the polygon of a room has no holes."""
    inner = [room.polygon.representative_point() for room in rooms]
    done: list[FloorRoom] = []
    notes = []
    todo = list(rooms)
    while todo:
        room = todo.pop()
        holes = [Polygon(ring) for ring in room.polygon.interiors]
        island = next((hole for hole in holes if shapely.intersects(hole, inner).any()), None)
        halves = [] if island is None else _halves(room.polygon, island)
        if len(halves) < 2:
            done.append(room)
            continue
        todo.extend(replace(room, polygon=part) for part in halves)
        notes.append(f"{room.name or 'a room'} runs around another room: cut in two")
    return done, tuple(notes)


def _halves(shape: Polygon, island: Polygon) -> list[Polygon]:
    """A polygon cut from one of its holes upwards and downwards."""
    x, _ = shapely.get_coordinates(island.representative_point())[0]
    _, low, _, high = shape.bounds
    line = LineString([(x, low - 1.0), (x, high + 1.0)])
    inside = [part for part in shapely.get_parts(line.intersection(shape)) if part.length > 0.0]
    return _faces(shape, [part for part in inside if part.dwithin(island, GRID)])


# ---- names and notes ------------------------------------------------------------------------


def _named(rooms: Sequence[FloorRoom]) -> list[FloorRoom]:
    """Rooms from the largest to the smallest, each with a name of its own."""
    ordered = sorted(rooms, key=lambda room: -room.polygon.area)
    taken = Counter(room.name for room in ordered if room.name)
    seen: Counter[str] = Counter()
    named = []
    for room in ordered:
        base = room.name or "room"
        seen[base] += 1
        name = base if room.name and seen[base] == 1 else f"{base}_{seen[base]}"
        while name != room.name and name in taken:
            seen[base] += 1
            name = f"{base}_{seen[base]}"
        taken[name] += 1
        named.append(replace(room, name=name))
    return named


def _idle_borders(segments: Floats, rooms: Sequence[FloorRoom], floor: Polygon) -> list[str]:
    """Borders along which no two rooms meet, and which of their ends is open."""
    sides = shapely.union_all(shared_sides(rooms))
    notes = []
    for index, ends in enumerate(segments):
        if sides.is_empty or not sides.dwithin(shapely.Point(ends.mean(axis=0)), REACH):
            others = shapely.linestrings(np.delete(segments, index, axis=0))
            walls = shapely.union_all([floor.boundary, *others])
            notes.append(
                f"border {index + 1}, from {metres(ends[0])} to {metres(ends[1])}: parts no two "
                f"rooms{_open_ends(ends, floor, walls)}; left out"
            )
    return notes


def _open_ends(ends: Floats, floor: Polygon, walls: shapely.Geometry) -> str:
    """Which ends of a border are too far from the walls to meet them, and how far."""
    found = [
        f"the end at {metres(end)} is {walls.distance(spot):.2f} m from a wall"
        for end, spot in zip(ends, shapely.points(ends), strict=True)
        if floor.contains(spot) and walls.distance(spot) > REACH
    ]
    return f": {' and '.join(found)}, expected at most {REACH:g} m" if found else ""


def _missing(rooms: Sequence[RoomShape], owned: Sequence[FloorRoom]) -> list[str]:
    """Rooms that have no part of the floor from the size of a room on."""
    names = {room.name for room in owned if room.polygon.area >= SMALLEST}
    return [
        f"room {name!r} of {shape.area:.1f} m²: has no floor of its own; left out"
        for name, _, shape in rooms
        if name and name not in names
    ]
