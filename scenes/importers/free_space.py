"""From a region of free floor to an apartment.

Grid maps and slices of 3D scenes know where the floor is free, and nothing of walls
or rooms. The part of the floor that holds the start becomes the clear floor, what
encloses it one ring of masonry, and what stands in it blocks. Lines or polygons part
the floor into rooms (`scenes.importers.rooms`).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon

from scenes.apartment import Apartment, Block, Point, Room, RoomKind, SceneFile, Start
from scenes.errors import SceneError
from scenes.importers import Imported
from scenes.importers.rooms import GRID, FloorRoom, part_floor, shared_sides
from scenes.passages import ROBOT_RADIUS
from scenes.solids import polygons
from scenes.wall_checks import metres

__all__ = ["free_space_apartment"]

Floats = NDArray[np.float64]
Corners = tuple[Point, ...]

LINTEL_LIMIT = 1.6
"""Borders narrower than this are taken for doorways and get a lintel, m."""
NICHE = 2.0
"""Niches of the outer face of the masonry are filled up to this width, m."""
SPECK = 1e-4
"""Obstacles with a smaller footprint are left out, m²."""
WORTH_A_LINE = 0.5
"""Free areas from this size on are reported one by one, m²."""
LEEWAY = 0.005
"""Where the robot's centre has less than this to move in, it has no place, m²."""
LARGEST = 1000.0
"""Coordinates of an apartment are at most this large, m."""
KEPT = 0.99
"""Share of the robot's floor that simplification must leave."""


def free_space_apartment(
    free: Polygon | MultiPolygon,
    *,
    name: str,
    start: Point | None = None,
    borders: Floats | None = None,
    rooms: Sequence[tuple[str, RoomKind, Polygon]] | None = None,
    ceiling_height: float = 2.5,
    wall_thickness: float = 0.2,
    lintel_height: float | None = 2.0,
    scene_file: SceneFile | None = None,
    obstacle_top: float | None = None,
    obstacle_material: str = "white_paint",
    tolerance: float = 0.0,
    origin: str | None = None,
) -> Imported:
    """Make an apartment of a region of free floor.

    Parameters
    ----------
    free : Polygon or MultiPolygon
        Free floor, m; its holes are obstacles.
    name : str
        Name of the apartment.
    start : tuple of float, optional
        Where the robot starts, m; the place with most clearance if absent. The
        connected floor around it is the apartment's; without it, the one with most
        floor for a robot of `ROBOT_RADIUS`.
    borders : array, shape (b, 2, 2), optional
        Segments between rooms, m.
    rooms : sequence of (name, kind, Polygon), optional
        Where the rooms are; they may be apart by doorways and overhang the floor.
    ceiling_height, wall_thickness : float
        m.
    lintel_height : float, optional
        Clear height of the doorways (borders narrower than 1.6 m), m; None: no lintels.
    scene_file : SceneFile, optional
        The 3D scene that the floor was cut from.
    obstacle_top : float, optional
        Height of what stands on the floor, m; None: it is masonry up to the ceiling.
    obstacle_material : str
        Material of what stands on the floor, if it is no masonry.
    tolerance : float
        How far the outlines may be moved to get fewer corners, m.
    origin : str, optional
        What errors begin with: the file; the name if absent.

    Returns
    -------
    Imported
        An apartment that passes `scenes.check`, and a note on everything left out.

    Raises
    ------
    SceneError
        If the robot finds no place, or not the one it shall start at, or the floor
        lies beyond the coordinates of an apartment.
    """
    ground = _choose_floor(free, origin or name, start, tolerance)
    notes = list(ground.notes)
    holes = [Polygon(ring) for ring in ground.floor.interiors]
    kept = [hole for hole in holes if hole.area >= SPECK]
    if specks := len(holes) - len(kept):
        notes.append(f"{specks} obstacles of less than {1e4 * SPECK:g} cm²: left out")
    shell = Polygon(ground.floor.exterior)
    # Masonry takes its footprint from the floor; what only stands on it does not.
    floor = Polygon(shell.exterior, [h.exterior for h in kept]) if obstacle_top is None else shell
    parted, told = part_floor(floor, ground.robot_floor, borders, rooms, tolerance)
    sides = shared_sides(parted)
    material = None if obstacle_top is None else obstacle_material
    blocks = [
        _surround(shell, wall_thickness),
        *(Block(polygon=_corners(h.exterior), top=obstacle_top, material=material) for h in kept),
    ]
    if lintel_height is not None and lintel_height < ceiling_height:
        blocks.extend(_lintels(sides, floor, wall_thickness, lintel_height))
    apartment = Apartment(
        name=name,
        rooms=tuple(_room(room, ceiling_height) for room in parted),
        blocks=tuple(blocks),
        borders=tuple(
            segment for side in sides for segment in _segments(shapely.get_coordinates(side))
        ),
        scene_file=scene_file,
        start=Start(position=ground.start),
    )
    return Imported(apartment, (*notes, *told))


# ---- the floor ------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Ground:
    """The floor that becomes the apartment's.

    ``floor`` the connected free floor; ``robot_floor`` where the robot's centre can
    get to from ``start``; ``notes`` on the floor left out.
    """

    floor: Polygon
    robot_floor: Polygon
    start: Point
    notes: tuple[str, ...]


def _choose_floor(
    free: shapely.Geometry, origin: str, start: Point | None, tolerance: float
) -> _Ground:
    """Choose the connected floor, and simplify it as far as the robot loses nothing."""
    parts = polygons(shapely.set_precision(shapely.make_valid(free), GRID))
    _check_extent(parts, origin)
    robot_floor = _robot_floor(parts, origin, start)
    floor = next(part for part in parts if part.intersects(robot_floor))
    place = start or _clearest(robot_floor)
    apart = [part for part in parts if part is not floor]
    for step in (tolerance, tolerance / 2):
        simple = _simplified(floor, step)
        reached = _part_at(_robot_parts(simple), place)
        if reached is not None and reached.area >= KEPT * robot_floor.area:
            around = _part_at(simple, place)
            assert around is not None
            cut_off = [part for part in simple if part is not around]
            return _Ground(around, reached, place, _left_out(apart + cut_off))
    return _Ground(floor, robot_floor, place, _left_out(apart))


def _check_extent(parts: list[Polygon], origin: str) -> None:
    if not parts:
        raise SceneError(f"{origin}: no free floor at all; expected some")
    bounds = shapely.total_bounds(parts)
    if np.abs(bounds).max() > LARGEST - 1.0:
        raise SceneError(
            f"{origin}: the free floor reaches from {metres(bounds[:2])} to "
            f"{metres(bounds[2:])} m; expected coordinates within ±{LARGEST:g} m; check the "
            f"scale and the origin"
        )


def _robot_parts(parts: list[Polygon]) -> list[Polygon]:
    """Where the robot's centre can be, part by part, without the specks."""
    return polygons(shapely.buffer(parts, -ROBOT_RADIUS, quad_segs=16), smallest=LEEWAY)


def _robot_floor(parts: list[Polygon], origin: str, start: Point | None) -> Polygon:
    """Where the robot's centre can get to: from the start, or the largest such part."""
    robot_parts = _robot_parts(parts)
    if not robot_parts:
        raise SceneError(
            f"{origin}: the free floor is nowhere {2 * ROBOT_RADIUS:g} m wide; expected a place "
            f"for the robot; check the scale and what counts as free"
        )
    if start is None:
        return max(robot_parts, key=lambda part: part.area)
    found = _part_at(robot_parts, start)
    if found is None:
        nearest = shapely.shortest_line(shapely.union_all(robot_parts), shapely.Point(start))
        raise SceneError(
            f"{origin}: start: {metres(start)} has no free floor for a robot of {ROBOT_RADIUS:g} m "
            f"radius; expected a free place, such as {metres(shapely.get_coordinates(nearest)[0])}"
        )
    return found


def _part_at(parts: list[Polygon], place: Point) -> Polygon | None:
    spot = shapely.Point(place)
    return next((part for part in parts if part.intersects(spot)), None)


def _clearest(region: Polygon) -> Point:
    """The point of a region that is farthest from its boundary, to the centimetre."""
    centre = shapely.maximum_inscribed_circle(region, tolerance=0.01)
    x, y = shapely.get_coordinates(centre)[0]
    rounded = (round(float(x), 2), round(float(y), 2))
    return rounded if region.intersects(shapely.Point(rounded)) else (float(x), float(y))


def _simplified(floor: Polygon, tolerance: float) -> list[Polygon]:
    """Fewer corners, ring by ring; what is hardly larger than the tolerance stays as it is."""
    # Normal rings begin at a true corner; one in the middle of a side would be kept.
    floor = shapely.normalize(floor)
    shell = Polygon(floor.exterior).simplify(tolerance)
    holes = [
        hole.simplify(tolerance) if hole.area > 9.0 * tolerance**2 else hole
        for hole in map(Polygon, floor.interiors)
    ]
    region = shell.difference(shapely.union_all(holes))
    return polygons(shapely.set_precision(region, GRID))


def _left_out(parts: list[Polygon]) -> tuple[str, ...]:
    """Notes on free floor without a connection to the apartment's."""
    large = [part for part in parts if part.area >= WORTH_A_LINE]
    notes = [
        f"free area of {part.area:.1f} m² about "
        f"{metres(shapely.get_coordinates(part.representative_point())[0])}: not connected with "
        f"the rest; left out"
        for part in sorted(large, key=lambda part: -part.area)
    ]
    small = [part.area for part in parts if part.area < WORTH_A_LINE]
    if small:
        notes.append(
            f"{len(small)} small free areas, {sum(small):.2f} m² in all: not connected with the "
            f"rest; left out"
        )
    return tuple(notes)


# ---- the apartment's parts ------------------------------------------------------------------


def _corners(ring: shapely.Geometry) -> Corners:
    """Corners of a closed ring, to a tenth of a millimetre, the last one left out."""
    points = np.round(shapely.get_coordinates(ring)[:-1], 4)
    return tuple((float(x), float(y)) for x, y in points)


def _segments(points: Floats) -> list[tuple[Point, Point]]:
    corners = [(float(x), float(y)) for x, y in np.round(points, 4)]
    return list(itertools.pairwise(corners))


def _room(room: FloorRoom, ceiling_height: float) -> Room:
    return Room(
        name=room.name,
        kind=room.kind,
        polygon=_corners(room.polygon.exterior),
        ceiling_height=ceiling_height,
    )


def _surround(shell: Polygon, thickness: float) -> Block:
    """The ring of masonry around the floor."""
    wide = shell.buffer(thickness + NICHE / 2, join_style="mitre", mitre_limit=2.0)
    wide = Polygon(wide.exterior).buffer(-NICHE / 2, join_style="mitre", mitre_limit=2.0)
    # Across a niche whose mouth is at a slant, the second mitre may cut into the floor.
    wide = wide.union(shell.buffer(thickness, join_style="mitre", mitre_limit=2.0))
    wide = Polygon(max(polygons(wide), key=lambda part: part.area).exterior)
    # Where the ring meets itself across a niche, rounding closes the slit of no width.
    whole = shapely.set_precision(wide, GRID)
    outline = max(polygons(whole), key=lambda part: part.area).exterior
    return Block(
        polygon=_corners(Polygon(outline).simplify(thickness / 4).exterior),
        holes=(_corners(shell.exterior),),
    )


def _lintels(
    sides: list[shapely.LineString], floor: Polygon, thickness: float, height: float
) -> list[Block]:
    """A piece of wall over every border that is as narrow as a doorway."""
    blocks: list[Block] = []
    for side in sides:
        if side.length < LINTEL_LIMIT and not side.is_ring:
            band = side.buffer(thickness / 2, cap_style="square", join_style="mitre")
            blocks.extend(
                Block(polygon=_corners(part.exterior), bottom=height)
                for part in polygons(shapely.set_precision(band.intersection(floor), GRID), SPECK)
            )
    return blocks
