"""Rooms of a drawing made fit to live in one apartment, and what closes them.

Rooms become apart from one another (of two that overlap the smaller keeps the
floor), clear of the walls, and of one piece. Rooms that touch with no wall
between get a border; the other sides that no wall closes get masonry.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np
import shapely
from shapely import Polygon

from scenes.apartment import Block, Point, Wall
from scenes.errors import SceneError
from scenes.faults import shape_fault
from scenes.importers.drawing import PlanDrawing, PlanRoom, free_name
from scenes.solids import GAP, block_footprint, polygons
from scenes.wall_checks import TOLERANCE, is_thick

__all__ = ["borders_between", "closing_masonry", "fit_rooms", "solid_shapes", "wall_mass"]

OPEN_GAP = 0.06
"""Rooms apart by no more than this, with no wall between, are open to each other, m."""
GRID = 1e-3
"""Corners of rooms are multiples of this, m."""
LEAST_ROOM = 0.5
"""What is left of a room must have this area, m²."""


def solid_shapes(shapes: Sequence[Polygon]) -> tuple[Polygon, ...]:
    """Footprints of walls without their parts that are as thin as a line."""
    reach = GRID / 2 + 1e-4
    thick = [_grown(_grown(shapely.make_valid(shape), -reach), reach) for shape in shapes]
    return tuple(part for shape in thick for part in polygons(_on_grid(shape), 1e-5))


def wall_mass(drawing: PlanDrawing) -> shapely.Geometry:
    """Footprint of all walls drawn, openings filled."""
    return shapely.union_all(
        [
            *(_band(wall) for wall in drawing.walls),
            *drawing.wall_shapes,
            *(block_footprint(block) for block in drawing.blocks if block.is_masonry),
        ]
    )


@dataclass(frozen=True)
class FittedRooms:
    """Rooms apart from each other and clear of the walls.

    ``islands`` are solids that stand in them, ``notes`` what could not be used.
    """

    rooms: list[PlanRoom]
    islands: list[Polygon]
    notes: list[str]


def fit_rooms(drawing: PlanDrawing, thickness: float) -> FittedRooms:
    """Make the rooms of a drawing fit.

    Parameters
    ----------
    drawing : PlanDrawing
    thickness : float
        Of the walls between touching rooms of a drawing that has no walls at all, m.

    Raises
    ------
    SceneError
        If a room crosses itself.
    """
    for room in drawing.rooms:
        if not room.shape.is_valid:
            fault = shape_fault(room.shape)
            raise SceneError(f"{room.label}: {fault}; expected a simple polygon")
    notes: list[str] = []
    rooms = [replace(room, shape=_on_grid(room.shape)) for room in drawing.rooms]
    rooms = _clear(rooms, _covering(drawing))
    rooms = _apart(rooms, notes)
    mass = wall_mass(drawing)
    rooms = _parted(rooms, drawing, thickness) if mass.is_empty else _closed_up(rooms, mass)
    islands: list[Polygon] = []
    rooms = _noded(_whole(rooms, islands, notes))
    return FittedRooms(rooms, islands, notes)


def borders_between(
    rooms: Sequence[PlanRoom], drawn: Sequence[tuple[Point, Point]]
) -> tuple[tuple[Point, Point], ...]:
    """Borders along the edges that rooms share, those drawn first."""
    own = shapely.union_all([shapely.LineString(line) for line in drawn])
    known = own.buffer(GAP)
    found = list(drawn)
    for a, b in combinations([room.shape for room in rooms], 2):
        shared = a.exterior.intersection(b.exterior).difference(known)
        merged = shapely.line_merge(shapely.union_all(_lines(shared)))
        for line in _lines(merged):
            points = np.round(shapely.get_coordinates(line.simplify(1e-5)), 6).tolist()
            found.extend((tuple(p), tuple(q)) for p, q in pairwise(points))
    return tuple(found)


def closing_masonry(
    drawing: PlanDrawing,
    rooms: Sequence[PlanRoom],
    borders: Sequence[tuple[Point, Point]],
    thickness: float,
) -> list[Polygon]:
    """Footprints of masonry: the wall shapes, and along the sides that nothing closes."""
    floor = shapely.union_all([room.shape for room in rooms])
    own = shapely.union_all([shapely.LineString(line) for line in borders]).buffer(GAP)
    closed = _grown(wall_mass(drawing), GAP - 1e-3).union(own)
    bare = [
        line.buffer(thickness, cap_style="square", join_style="mitre")
        for room in rooms
        for line in _lines(room.shape.exterior.difference(closed))
        if line.length > TOLERANCE / 2
    ]
    solid = shapely.union_all([*drawing.wall_shapes, *bare]).difference(floor)
    return polygons(solid, smallest=1e-5)


def with_islands(drawing: PlanDrawing, islands: Sequence[Polygon]) -> PlanDrawing:
    """The drawing with islands as masonry, without the walls that are part of them.

    The floor of a room has no holes: masonry takes its footprint from it, walls do not.
    """
    inside = shapely.union_all(list(islands)).buffer(GAP)
    walls = tuple(
        wall
        for wall in drawing.walls
        if not inside.covers(shapely.LineString([wall.start, wall.end]))
    )
    blocks = (Block(polygon=corners(island.exterior)) for island in islands)
    return replace(drawing, walls=walls, blocks=(*drawing.blocks, *blocks))


def corners(ring: shapely.LinearRing) -> tuple[Point, ...]:
    """Corners of a closed ring, the last one left out."""
    points = np.round(shapely.get_coordinates(ring)[:-1], 6)
    return tuple((float(x), float(y)) for x, y in points)


def _band(wall: Wall) -> shapely.Geometry:
    line = shapely.LineString([wall.start, wall.end])
    return line.buffer(wall.thickness / 2, cap_style="square", join_style="mitre")


def _lines(region: shapely.Geometry) -> list[shapely.LineString]:
    parts = shapely.get_parts(shapely.get_parts(region))
    return [part for part in parts if part.geom_type == "LineString" and part.length > 1e-4]


def _covering(drawing: PlanDrawing) -> shapely.Geometry:
    """What of the walls takes floor from the rooms; the ends of lines do not."""
    bands = [
        shapely.LineString([wall.start, wall.end]).buffer(wall.thickness / 2, cap_style="flat")
        for wall in drawing.walls
    ]
    return shapely.union_all([*bands, *drawing.wall_shapes])


def _clear(rooms: Sequence[PlanRoom], walls: shapely.Geometry) -> list[PlanRoom]:
    """Rooms without the floor that walls cover by more than half of what the checks allow."""
    shapely.prepare(walls)
    return [
        room
        if room.shape.intersection(walls).buffer(-TOLERANCE / 4).is_empty
        else replace(room, shape=room.shape.difference(walls))
        for room in rooms
    ]


def _apart(rooms: Sequence[PlanRoom], notes: list[str]) -> list[PlanRoom]:
    """Rooms that do not overlap: the smaller keeps what two of them claim."""
    order = sorted(range(len(rooms)), key=lambda i: (rooms[i].shape.area, i))
    shapes = [room.shape for room in rooms]
    for place, larger in enumerate(order):
        for smaller in order[:place]:
            shared = shapes[larger].intersection(rooms[smaller].shape)
            if shared.area > 1e-4:
                shapes[larger] = shapes[larger].difference(rooms[smaller].shape)
            if is_thick(shared):
                notes.append(
                    f"{rooms[larger].label}: {rooms[larger].name!r} overlaps "
                    f"{rooms[smaller].name!r} by {shared.area:.3g} m², which the smaller keeps"
                )
    return [replace(room, shape=shape) for room, shape in zip(rooms, shapes, strict=True)]


def _parted(rooms: list[PlanRoom], drawing: PlanDrawing, thickness: float) -> list[PlanRoom]:
    """Rooms drawn up to the middle of walls that are not drawn: walls where two touch."""
    drawn = [shapely.LineString(line) for line in drawing.borders]
    open_sides = shapely.union_all(drawn).buffer(GAP)
    bands = [
        _grown(a.shape, OPEN_GAP / 2)
        .intersection(_grown(b.shape, OPEN_GAP / 2))
        .difference(open_sides)
        for a, b in combinations(rooms, 2)
    ]
    reach = (thickness - OPEN_GAP) / 2
    walls = [
        _grown(part, reach) for band in bands for part in polygons(band, smallest=0.1 * OPEN_GAP)
    ]
    solid = shapely.union_all(walls)
    return [replace(room, shape=room.shape.difference(solid)) for room in rooms]


def _closed_up(rooms: list[PlanRoom], mass: shapely.Geometry) -> list[PlanRoom]:
    """Rooms joined over the narrow gaps in which no wall stands."""
    shapes = [room.shape for room in rooms]
    reach = OPEN_GAP / 2 + 1e-3
    for i, j in combinations(range(len(rooms)), 2):
        if not 0.0 < shapes[i].distance(shapes[j]) <= OPEN_GAP:
            continue
        both = shapes[i].union(shapes[j])
        closed = _grown(_grown(both, reach), -reach)
        others = shapely.union_all([s for k, s in enumerate(shapes) if k not in (i, j)])
        gap = closed.difference(both).difference(mass).difference(others)
        near = [p for p in polygons(gap, 1e-4) if all(p.distance(shapes[k]) < 1e-3 for k in (i, j))]
        if near:
            grown = shapely.union_all([shapes[i], *near], grid_size=GRID)
            shapes[i] = grown.difference(shapely.union_all([shapes[j], others]))
    return [replace(room, shape=shape) for room, shape in zip(rooms, shapes, strict=True)]


def _whole(rooms: list[PlanRoom], islands: list[Polygon], notes: list[str]) -> list[PlanRoom]:
    """Rooms of one piece without slivers; further large pieces become rooms of their own."""
    whole: list[PlanRoom] = []
    for index, room in enumerate(rooms):
        others = shapely.union_all([r.shape for k, r in enumerate(rooms) if k != index])
        parts = [
            cut for part in _solid_parts(room.shape) for cut in _unholed(part, others, islands)
        ]
        pieces = sorted((p for p in parts if p.area >= LEAST_ROOM), key=lambda p: -p.area)
        if not pieces:
            notes.append(
                f"{room.label}: {room.shape.area:.2g} m² are left of {room.name!r}; expected "
                f"at least {LEAST_ROOM:g} m²; left out"
            )
        for number, piece in enumerate(pieces):
            taken = {other.name for other in (*rooms, *whole)}
            name = free_name(room.name, taken) if number else room.name
            if number:
                notes.append(f"{room.label}: a second part of {room.name!r} is called {name!r}")
            whole.append(replace(room, name=name, shape=piece))
    return whole


def _solid_parts(shape: shapely.Geometry) -> list[Polygon]:
    """Parts of a shape without spikes."""
    if shape.geom_type == "Polygon" and not shape.interiors and _is_clean(shape):
        return [shape]
    reach = 2 * GAP
    opened = _grown(_grown(shape, -reach), reach).intersection(shape)
    return polygons(opened, 1e-3)


def _is_clean(shape: Polygon) -> bool:
    """Whether a room has no part that is narrower than a gap that counts as wall."""
    core = _grown(shape, -GAP / 2)
    back = _grown(core, GAP / 2 + 1e-3)
    return core.geom_type == "Polygon" and bool(back.covers(shape.buffer(-1e-3)))


def _unholed(part: Polygon, others: shapely.Geometry, islands: list[Polygon]) -> Iterator[Polygon]:
    """A polygon without its holes: cut through one with a room in it, others made islands."""
    holes = [Polygon(ring) for ring in part.interiors]
    around = [hole for hole in holes if hole.intersection(others).area > 0.01]
    if not around:
        islands.extend(holes)
        yield Polygon(part.exterior)
        return
    (west, south, east, north), (_, low, _, high) = part.bounds, around[0].bounds
    middle = (low + high) / 2
    for half in (shapely.box(west, south, east, middle), shapely.box(west, middle, east, north)):
        for piece in polygons(part.intersection(half), 1e-3):
            yield from _unholed(piece, others, islands)


def _grown(shape: shapely.Geometry, reach: float) -> shapely.Geometry:
    """A shape grown (shrunk) by a reach, m, its corners kept sharp."""
    # GEOS raises floating-point flags on nearly straight mitres; its results are sound.
    with np.errstate(divide="ignore", invalid="ignore"):
        return shape.buffer(reach, join_style="mitre", mitre_limit=10.0)


def _on_grid(shape: shapely.Geometry) -> shapely.Geometry:
    return shapely.set_precision(shapely.set_precision(shape, GRID), 0.0)


def _noded(rooms: list[PlanRoom]) -> list[PlanRoom]:
    """Rooms that touch share every corner along their common edge.

    Otherwise rounding leaves a slit between them that no robot passes.
    """
    shapes = [room.shape.simplify(1e-6) for room in rooms]
    for i, j in combinations(range(len(shapes)), 2):
        if shapes[i].distance(shapes[j]) < 2e-3:
            for a, b in ((i, j), (j, i)):
                corners = shapely.multipoints(shapely.get_coordinates(shapes[b]))
                snapped = shapely.snap(shapes[a], corners, 2e-3)
                shapes[a] = snapped if snapped.is_valid else shapes[a]
    # The grid makes one of corners that were nearly so.
    return [replace(room, shape=_on_grid(shape)) for room, shape in zip(rooms, shapes, strict=True)]
