"""What the types of an apartment cannot say: every check yields its problems.

The checks come in stages. References and shapes first; then the walls
with their openings; then lamps, furniture, the robot. A later stage runs only if the
earlier ones found nothing, because it relies on their geometry.
"""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Iterable, Iterator

import numpy as np
import shapely
from shapely import Polygon

from scenes.apartment import Apartment, Piece, Room
from scenes.faults import shape_fault
from scenes.lamps import BODY_HEIGHT, lamp_underside
from scenes.materials import BUILT_IN
from scenes.parts import Part
from scenes.passages import ROBOT_RADIUS, free_region
from scenes.pieces import KINDS, piece_parts
from scenes.rooms import room_shapes, rooms_at
from scenes.solids import Prism, block_footprint, floor_region, polygons
from scenes.wall_checks import (
    check_covered_floor,
    check_enclosure,
    check_openings,
    check_overlaps,
    check_shared_openings,
    is_thick,
    metres,
    opening_rectangle,
)

__all__ = ["check", "check_blocks", "check_lamps", "piece_faults"]


def check(apartment: Apartment) -> Iterator[str]:
    """Yield every semantic problem of an apartment, one line each.

    Each line says which field (``rooms[2].polygon``), what is wrong with its
    value, and what would be right.
    """
    stages = (
        (_names, _materials, _kinds, _shapes),
        (
            check_overlaps,
            check_covered_floor,
            check_enclosure,
            check_openings,
            check_shared_openings,
            _ceiling_steps,
        ),
        (check_lamps,),
        (_furniture, _start),
    )
    for stage in stages:
        problems = [problem for part in stage for problem in part(apartment)]
        yield from problems
        if problems:
            return


def _closest(name: str, known: Iterable[str]) -> str:
    """What to write instead of an unknown name."""
    known = sorted(known)
    close = difflib.get_close_matches(name, known, n=1)
    return f"did you mean {close[0]!r}?" if close else f"expected one of {', '.join(known)}"


# ---- references and shapes ------------------------------------------------------------------


def _names(apartment: Apartment) -> Iterator[str]:
    counts = Counter(room.name for room in apartment.rooms)
    for index, room in enumerate(apartment.rooms):
        if counts[room.name] > 1:
            counts[room.name] = 0
            yield f"rooms[{index}].name: {room.name!r} is the name of several rooms; expected one"


def _materials(apartment: Apartment) -> Iterator[str]:
    known = {*BUILT_IN, *apartment.materials}
    for field, name in _used_materials(apartment):
        if name not in known:
            yield f"{field}: {name!r} is no material; {_closest(name, known)}"


def _used_materials(apartment: Apartment) -> Iterator[tuple[str, str]]:
    """Every field that names a material, and the name."""
    for index, room in enumerate(apartment.rooms):
        yield from _room_materials(room, f"rooms[{index}]")
    for index, block in enumerate(apartment.blocks):
        if block.material is not None:
            yield f"blocks[{index}].material", block.material
    for index, passage in enumerate(apartment.passages):
        if passage.frame is not None:
            yield f"passages[{index}].frame.material", passage.frame.material
        if passage.threshold is not None:
            yield f"passages[{index}].threshold.material", passage.threshold.material
    for index, window in enumerate(apartment.windows):
        yield f"windows[{index}].frame", window.frame
    for index, piece in enumerate(apartment.furniture):
        for slot, name in piece.materials.items():
            yield f"furniture[{index}].materials.{slot}", name


def _room_materials(room: Room, field: str) -> Iterator[tuple[str, str]]:
    for part in ("floor", "walls", "ceiling"):
        yield f"{field}.{part}", getattr(room, part)
    if room.skirting is not None:
        yield f"{field}.skirting.material", room.skirting.material


def _kinds(apartment: Apartment) -> Iterator[str]:
    for index, piece in enumerate(apartment.furniture):
        yield from (f"furniture[{index}].{fault}" for fault in piece_faults(piece))


def piece_faults(piece: Piece) -> Iterator[str]:
    """Yield why a piece cannot be made: the field, its value, what would be right."""
    kind = KINDS.get(piece.kind)
    if kind is None:
        yield f"kind: {piece.kind!r} is no kind; {_closest(piece.kind, KINDS)}"
        return
    unknown = [slot for slot in piece.materials if slot not in kind.slots]
    for slot in unknown:
        hint = _closest(slot, kind.slots)
        yield f"materials: a {piece.kind} has no slot {slot!r}; {hint}"
    if not unknown:
        try:
            size, slots = piece.size or kind.size, {slot: slot for slot in kind.slots}
            for part in kind.build(*size, **slots):
                Prism(part.footprint, part.bottom, part.top, part.material)
        except ValueError as error:
            yield f"size: {piece.size} is too small for a {piece.kind}: {error}"


def _shapes(apartment: Apartment) -> Iterator[str]:
    for index, room in enumerate(apartment.rooms):
        shape = Polygon(room.polygon)
        if not shape.is_valid:
            yield f"rooms[{index}].polygon: {shape_fault(shape)}; expected a simple polygon"
        elif shape.area < 0.1:
            yield f"rooms[{index}].polygon: {shape.area:.3g} m²; expected at least 0.1 m²"
    yield from check_blocks(apartment)
    for index, wall in enumerate(apartment.walls):
        if np.hypot(*np.subtract(wall.start, wall.end)) < 1e-3:
            yield f"walls[{index}].end: {metres(wall.end)} is its start; expected another point"


def check_blocks(apartment: Apartment) -> Iterator[str]:
    """Yield the blocks whose outline or heights make no solid."""
    for index, block in enumerate(apartment.blocks):
        shape = block_footprint(block)
        if not shape.is_valid:
            fault = shape_fault(shape)
            yield f"blocks[{index}].polygon: {fault}; expected a simple polygon, holes inside it"
        elif shape.area < 1e-6:
            yield f"blocks[{index}].polygon: {shape.area:.3g} m²; expected a polygon with an area"
        if block.top is not None and block.top <= block.bottom:
            yield (
                f"blocks[{index}].top: {block.top:g} m; expected above the bottom at "
                f"{block.bottom:g} m, or null for through the ceiling"
            )


def _ceiling_steps(apartment: Apartment) -> Iterator[str]:
    """Yield the steps of the ceiling that begin above it, where nobody sees them."""
    shapes = room_shapes(apartment)
    for index, block in enumerate(apartment.blocks):
        if block.bottom == 0.0 or block.top is not None:
            continue
        under = np.flatnonzero(shapely.area(shapely.intersection(shapes, block_footprint(block))))
        highest = max((apartment.rooms[i].ceiling_height for i in under), default=np.inf)
        if block.bottom >= highest:
            names = " and ".join(repr(apartment.rooms[i].name) for i in under)
            yield (
                f"blocks[{index}].bottom: {block.bottom:g} m is not below the ceiling of {names}; "
                f"expected less than {highest:g} m for a step of the ceiling"
            )


# ---- contents and the robot -----------------------------------------------------------------


def _furniture(apartment: Apartment) -> Iterator[str]:
    gaps = [opening_rectangle(apartment, window, 0.0) for window in apartment.windows]
    allowed = shapely.union_all([floor_region(apartment), *gaps])
    shapely.prepare(allowed)
    for index, piece in enumerate(apartment.furniture):
        if problem := _misplaced(apartment, piece, allowed):
            yield f"furniture[{index}] ({piece.kind}): {problem}"


def _misplaced(apartment: Apartment, piece: Piece, allowed: shapely.Geometry) -> str | None:
    parts = piece_parts(piece)
    spot = shapely.Point(piece.position)
    homes = [apartment.rooms[index] for index in rooms_at(apartment, spot)]
    if not homes:
        return f"position {metres(piece.position)} is in no room; expected inside one"
    outside = shapely.union_all([part.footprint for part in parts]).difference(allowed)
    if is_thick(outside):
        for index, block in enumerate(apartment.blocks):
            shared = outside.intersection(block_footprint(block))
            if block.is_masonry and is_thick(shared):
                return (
                    f"at {metres(piece.position)} reaches {_width(shared):.3f} m into the masonry "
                    f"of {homes[0].name!r}, blocks[{index}]; expected on the clear floor"
                )
        return (
            f"at {metres(piece.position)} reaches {_width(outside):.3f} m into the walls of "
            f"{homes[0].name!r}; expected on the clear floor"
        )
    top, ceiling = max(part.top for part in parts), homes[0].ceiling_height
    if top > ceiling + 1e-9:
        return f"its top at {top:.3g} m is above the ceiling; expected at most {ceiling:g} m"
    return _in_block(apartment, parts)


def _in_block(apartment: Apartment, parts: list[Part]) -> str | None:
    """What is wrong if a piece stands in a column or hangs in a step of the ceiling."""
    for index, block in enumerate(apartment.blocks):
        top = np.inf if block.top is None else block.top
        level = [
            p.footprint for p in parts if p.bottom < top - 1e-9 and p.top > block.bottom + 1e-9
        ]
        shared = shapely.union_all(level).intersection(block_footprint(block))
        if is_thick(shared):
            return (
                f"reaches {_width(shared):.3f} m into blocks[{index}]; expected beside, below or "
                f"above it"
            )
    return None


def _width(region: shapely.Geometry) -> float:
    """How wide a region is where it is widest, to a tenth of a millimetre, m."""
    west, south, east, north = region.bounds
    low, high = 0.0, min(east - west, north - south)
    while high - low > 1e-4:
        middle = (low + high) / 2
        if region.buffer(-middle / 2).is_empty:
            high = middle
        else:
            low = middle
    return float(high)


def check_lamps(apartment: Apartment) -> Iterator[str]:
    """Yield the lamps that are in no room, in a wall, or above the ceiling."""
    for index, lamp in enumerate(apartment.lamps):
        field = f"lamps[{index}]"
        spot = shapely.Point(lamp.position)
        homes = [apartment.rooms[index] for index in rooms_at(apartment, spot)]
        if not homes:
            yield f"{field}.position: {metres(lamp.position)} is in no room; expected inside one"
            continue
        disc = spot.buffer(lamp.radius)
        if is_thick(disc.difference(Polygon(homes[0].polygon))):
            yield (
                f"{field}.radius: {lamp.radius:g} m at {metres(lamp.position)} reaches into the "
                f"walls of {homes[0].name!r}; expected inside the room"
            )
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
            hint = f", such as {metres(point)}"
        yield (
            f"start.position: {metres(apartment.start.position)} has no free floor for a robot "
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
