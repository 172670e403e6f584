"""What the types of an apartment cannot say: every check yields its problems.

The checks come in three stages. References and shapes first; then the walls
with their openings; then contents and the robot. A later stage runs only if the
earlier ones found nothing, because it relies on their geometry.
"""

from __future__ import annotations

import difflib
import itertools
from collections import Counter
from collections.abc import Iterable, Iterator

import numpy as np
import shapely
from shapely import Polygon

from scenes.apartment import Apartment, Passage, Piece, Point, Window
from scenes.lamps import BODY_HEIGHT, lamp_underside
from scenes.materials import BUILT_IN
from scenes.openings import Opening, lining_of, nearest_wall, place
from scenes.passages import free_region
from scenes.pieces import KINDS, piece_parts
from scenes.solids import (
    GAP,
    building_region,
    passage_footprint,
    passage_rooms,
    polygons,
    rooms_region,
    wall_region,
)

__all__ = ["check"]

ROBOT_RADIUS = 0.15
"""Radius of the robot that must be able to start and to enter every room, m (§2.1)."""
TOLERANCE = 0.02
"""How far things may reach into one another before it is a mistake, m."""


def check(apartment: Apartment) -> Iterator[str]:
    """Yield every semantic problem of an apartment, one line each.

    Each line says which field (``rooms[2].polygon``), what is wrong with its
    value, and what would be right.
    """
    stages = (
        (_names, _materials, _kinds, _shapes),
        (_overlaps, _walls, _enclosure, _openings, _neighbours),
        (_furniture, _lamps, _start),
    )
    for stage in stages:
        problems = [problem for part in stage for problem in part(apartment)]
        yield from problems
        if problems:
            return


def _metres(point: Iterable[float]) -> str:
    return "(" + ", ".join(f"{value:.3g}" for value in point) + ")"


def _closest(name: str, known: Iterable[str]) -> str:
    """What to write instead of an unknown name."""
    known = sorted(known)
    close = difflib.get_close_matches(name, known, n=1)
    return f"did you mean {close[0]!r}?" if close else f"expected one of {', '.join(known)}"


def _thick(region: shapely.Geometry) -> bool:
    """Whether a region is wider than the tolerance anywhere."""
    return not region.buffer(-TOLERANCE / 2).is_empty


# ---- references and shapes ------------------------------------------------------------------


def _names(apartment: Apartment) -> Iterator[str]:
    counts = Counter(room.name for room in apartment.rooms)
    for index, room in enumerate(apartment.rooms):
        if counts[room.name] > 1:
            counts[room.name] = 0
            yield f"rooms[{index}].name: {room.name!r} is the name of several rooms; expected one"


def _materials(apartment: Apartment) -> Iterator[str]:
    known = {*BUILT_IN, *apartment.materials}
    used: list[tuple[str, str]] = []
    for index, room in enumerate(apartment.rooms):
        used += [(f"rooms[{index}].{part}", getattr(room, part)) for part in _SURFACES]
    for index, passage in enumerate(apartment.passages):
        if passage.frame is not None:
            used.append((f"passages[{index}].frame.material", passage.frame.material))
    for index, window in enumerate(apartment.windows):
        used.append((f"windows[{index}].frame", window.frame))
    for index, piece in enumerate(apartment.furniture):
        slots = piece.materials.items()
        used += [(f"furniture[{index}].materials.{slot}", name) for slot, name in slots]
    for field, name in used:
        if name not in known:
            yield f"{field}: {name!r} is no material; {_closest(name, known)}"


_SURFACES = ("floor", "walls", "ceiling")


def _kinds(apartment: Apartment) -> Iterator[str]:
    for index, piece in enumerate(apartment.furniture):
        field = f"furniture[{index}]"
        kind = KINDS.get(piece.kind)
        if kind is None:
            yield f"{field}.kind: {piece.kind!r} is no kind; {_closest(piece.kind, KINDS)}"
            continue
        unknown = [slot for slot in piece.materials if slot not in kind.slots]
        for slot in unknown:
            hint = _closest(slot, kind.slots)
            yield f"{field}.materials: a {piece.kind} has no slot {slot!r}; {hint}"
        if not unknown:
            try:
                piece_parts(piece)
            except ValueError as error:
                yield f"{field}.size: {piece.size} is too small for a {piece.kind}: {error}"


def _shapes(apartment: Apartment) -> Iterator[str]:
    for index, room in enumerate(apartment.rooms):
        shape = Polygon(room.polygon)
        if not shape.is_valid:
            reason = shapely.is_valid_reason(shape)
            yield f"rooms[{index}].polygon: {reason}; expected a simple polygon"
        elif shape.area < 0.1:
            yield f"rooms[{index}].polygon: {shape.area:.3g} m²; expected at least 0.1 m²"
    for index, wall in enumerate(apartment.walls):
        if np.hypot(*np.subtract(wall.start, wall.end)) < 1e-3:
            yield f"walls[{index}].end: {_metres(wall.end)} is its start; expected another point"


# ---- walls and openings ---------------------------------------------------------------------


def _overlaps(apartment: Apartment) -> Iterator[str]:
    shapes = [Polygon(room.polygon) for room in apartment.rooms]
    for b in range(len(shapes)):
        for a in range(b):
            shared = shapes[a].intersection(shapes[b])
            if _thick(shared):
                other = apartment.rooms[a].name
                yield (
                    f"rooms[{b}].polygon: {apartment.rooms[b].name!r} overlaps {other!r} by "
                    f"{shared.area:.3g} m²; expected clear floors apart by a wall"
                )


def _walls(apartment: Apartment) -> Iterator[str]:
    for index, wall in enumerate(apartment.walls):
        line = shapely.LineString([wall.start, wall.end])
        band = line.buffer(wall.thickness / 2, cap_style="flat")
        for room in apartment.rooms:
            covered = band.intersection(Polygon(room.polygon))
            if _thick(covered):
                yield (
                    f"walls[{index}]: from {_metres(wall.start)} to {_metres(wall.end)}, "
                    f"{wall.thickness:.3g} m thick, covers {covered.area:.3g} m² of the clear "
                    f"floor of {room.name!r}; expected the room to end at the wall's face"
                )


def _enclosure(apartment: Apartment) -> Iterator[str]:
    bands = [
        shapely.LineString([wall.start, wall.end]).buffer(
            wall.thickness / 2 + GAP, cap_style="square", join_style="mitre"
        )
        for wall in apartment.walls
    ]
    walls = shapely.union_all(bands)
    for index, room in enumerate(apartment.rooms):
        corners = [*room.polygon, room.polygon[0]]
        for a, b in itertools.pairwise(corners):
            bare = shapely.LineString([a, b]).difference(walls)
            if bare.length > TOLERANCE:
                yield (
                    f"rooms[{index}].polygon: the side of {room.name!r} from {_metres(a)} to "
                    f"{_metres(b)} has no wall along {bare.length:.3g} m; expected a wall (open "
                    f"plans: a wall with a wide passage without lintel)"
                )


def _openings(apartment: Apartment) -> Iterator[str]:
    for index, passage in enumerate(apartment.passages):
        field = f"passages[{index}]"
        if problem := _off_wall(apartment, passage.position):
            yield f"{field}.position: {problem}"
        else:
            yield from _passage(apartment, passage, field)
    for index, window in enumerate(apartment.windows):
        field = f"windows[{index}]"
        if problem := _off_wall(apartment, window.position):
            yield f"{field}.position: {problem}"
        else:
            yield from _window(apartment, window, field)


def _off_wall(apartment: Apartment, position: Point) -> str | None:
    index, distance = nearest_wall(apartment.walls, position)
    if distance <= TOLERANCE:
        return None
    on_line = place(apartment, position, 1.0).centre
    return (
        f"{_metres(position)} lies on no wall's centre line; the nearest is that of "
        f"walls[{index}], {distance:.3g} m away; expected a point on one, such as "
        f"{_metres(on_line)}"
    )


def _passage(apartment: Apartment, passage: Passage, field: str) -> Iterator[str]:
    right, left = passage_rooms(apartment, passage)
    joined = [index for index in (right, left) if index is not None]
    if not joined or (len(joined) < 2 and not passage.closed):
        names = " and ".join(repr(apartment.rooms[i].name) for i in joined) or "no room"
        yield (
            f"{field}.position: {_metres(passage.position)} joins {names} only; expected a wall "
            f"between two rooms, or closed: true"
        )
        return
    opening = place(apartment, passage.position, passage.width)
    sides = [(side, i) for side, i in ((-1.0, right), (1.0, left)) if i is not None]
    yield from _too_wide(apartment, opening, sides, lining_of(passage), field)
    lowest = min((apartment.rooms[i] for i in joined), key=lambda room: room.ceiling_height)
    if passage.lintel_height is not None and passage.lintel_height > lowest.ceiling_height + 1e-9:
        yield (
            f"{field}.lintel_height: {passage.lintel_height:g} m is above the ceiling of "
            f"{lowest.name!r}; expected at most {lowest.ceiling_height:g}, or null for none"
        )


def _window(apartment: Apartment, window: Window, field: str) -> Iterator[str]:
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
    if len(inner) != 1 or building_region(apartment).intersects(outer[0]):
        yield (
            f"{field}.position: {_metres(window.position)} is not between a room and the outside; "
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
            f"expected at most {max(room_for, 0.0):.3g} m about {_metres(opening.centre)}"
        )


def _half_width(opening: Opening, seen: shapely.Geometry) -> float:
    """How far a line before the opening goes on unbroken from its middle to either side, m."""
    for part in shapely.get_parts(seen):
        along = (shapely.get_coordinates(part) - opening.centre) @ opening.along
        if along.min() <= 0.0 <= along.max():
            return float(min(-along.min(), along.max()))
    return 0.0


def _neighbours(apartment: Apartment) -> Iterator[str]:
    """Openings that overlap one another."""
    cuts: list[tuple[str, Polygon]] = []
    for index, passage in enumerate(apartment.passages):
        cuts.append((f"passages[{index}]", _gap(apartment, passage, lining_of(passage))))
    for index, window in enumerate(apartment.windows):
        cuts.append((f"windows[{index}]", _gap(apartment, window, 0.0)))
    for b, (field, shape) in enumerate(cuts):
        for other, other_shape in cuts[:b]:
            if shape.intersection(other_shape).area > 1e-4:
                yield f"{field}.position: the opening overlaps {other}; expected wall between them"


def _gap(apartment: Apartment, item: Passage | Window, margin: float) -> Polygon:
    opening = place(apartment, item.position, item.width)
    half, face = opening.width / 2 + margin, opening.thickness / 2
    return opening.rectangle((-half, half), (-face, face))


# ---- contents and the robot -----------------------------------------------------------------


def _furniture(apartment: Apartment) -> Iterator[str]:
    walls = wall_region(apartment)
    gaps = [passage_footprint(apartment, p, walls) for p in apartment.passages if not p.closed]
    gaps += [_gap(apartment, window, 0.0) for window in apartment.windows]
    allowed = shapely.union_all([rooms_region(apartment), *gaps])
    shapely.prepare(allowed)
    for index, piece in enumerate(apartment.furniture):
        if problem := _misplaced(apartment, piece, allowed):
            yield f"furniture[{index}] ({piece.kind}): {problem}"


def _misplaced(apartment: Apartment, piece: Piece, allowed: shapely.Geometry) -> str | None:
    parts = piece_parts(piece)
    spot = shapely.Point(piece.position)
    homes = [room for room in apartment.rooms if Polygon(room.polygon).intersects(spot)]
    if not homes:
        return f"position {_metres(piece.position)} is in no room; expected inside one"
    outside = shapely.union_all([part.footprint for part in parts]).difference(allowed)
    if _thick(outside):
        worst = shapely.distance(shapely.points(shapely.get_coordinates(outside)), allowed).max()
        return (
            f"at {_metres(piece.position)} reaches {worst:.3f} m into the walls of "
            f"{homes[0].name!r}; expected on the clear floor"
        )
    top, ceiling = max(part.top for part in parts), homes[0].ceiling_height
    if top > ceiling + 1e-9:
        return f"its top at {top:.3g} m is above the ceiling; expected at most {ceiling:g} m"
    return None


def _lamps(apartment: Apartment) -> Iterator[str]:
    for index, lamp in enumerate(apartment.lamps):
        field = f"lamps[{index}]"
        spot = shapely.Point(lamp.position)
        homes = [room for room in apartment.rooms if Polygon(room.polygon).intersects(spot)]
        if not homes:
            yield f"{field}.position: {_metres(lamp.position)} is in no room; expected inside one"
            continue
        low, ceiling = lamp_underside(apartment, lamp), homes[0].ceiling_height
        standing = lamp.kind in ("floor", "table")
        highest = ceiling - (BODY_HEIGHT[lamp.kind] if standing else 0.01)
        lowest = 0.2 if standing else 0.0
        if not lowest <= low <= highest:
            yield (
                f"{field}.height: {low:.3g} m in {homes[0].name!r}; expected {lowest:g} to "
                f"{highest:.3g} m under its ceiling"
            )


def _start(apartment: Apartment) -> Iterator[str]:
    free = polygons(free_region(apartment, ROBOT_RADIUS))
    spot = shapely.Point(apartment.start.position)
    home = next((part for part in free if part.intersects(spot)), None)
    if home is None:
        hint = ""
        if free:
            nearest = min(free, key=spot.distance)
            point = shapely.get_coordinates(shapely.shortest_line(nearest, spot))[0]
            hint = f", such as {_metres(point)}"
        yield (
            f"start.position: {_metres(apartment.start.position)} has no free floor for a robot "
            f"of {ROBOT_RADIUS:g} m radius; expected a free place{hint}"
        )
        return
    for index, room in enumerate(apartment.rooms):
        if home.intersection(Polygon(room.polygon)).area < 1e-3:
            yield (
                f"rooms[{index}]: {room.name!r} cannot be reached from the start by a robot of "
                f"{ROBOT_RADIUS:g} m radius; expected an open passage at least "
                f"{2 * ROBOT_RADIUS:g} m wide, with nothing before it"
            )
