"""The apartment as vertical prisms: one geometry for simulator and renderer.

Everything solid is a vertical prism, so that the robot's 2D obstacles are by
construction the footprints of what the 3D scene has near the floor. The shell
is closed and thick: walls run from below the floor to above every ceiling and
each ceiling slab fills all the space above its room, so that no ray of light
slips in between and rooms of different height need no extra pieces.

Gaps of up to 3 cm between a drawn room and a drawn wall become wall; what a
wall covers of a room is floor: the room polygons have the last word.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon

from scenes.apartment import DRIVEN_OVER, Apartment, Block, Passage, Room, Window
from scenes.lamps import lamp_parts
from scenes.openings import Opening, lining_of, place
from scenes.parts import Part
from scenes.pieces import piece_parts
from scenes.rooms import room_shapes

__all__ = [
    "WALL",
    "Prism",
    "SolidGroup",
    "apartment_solids",
    "block_footprint",
    "building_region",
    "cutter",
    "floor_area",
    "floor_region",
    "masonry_region",
    "obstacles",
    "passage_rooms",
    "polygons",
    "rooms_region",
    "solid_groups",
    "standing",
    "wall_region",
]

WALL = "<wall>"
"""Material of prisms whose faces take the ``walls`` material of the room they look into.

No user can give a material this name."""

SLAB = 0.2
"""Thickness of floors, and of the ceiling over the highest room, m."""
GAP = 0.03
"""Gaps up to this width between a room and a wall are closed, m."""
OVERLAP = 0.03
"""How far floor and ceiling slabs reach into the walls against light leaks, m."""
LEAF = 0.04
"""Thickness of a closed door's leaf, m."""
SASH = 0.06
"""Width and depth of a window frame's bars, m."""


@dataclass(frozen=True)
class Prism:
    """A solid: a polygon (holes allowed) between two heights.

    ``footprint`` in m; ``bottom`` and ``top`` m above the floor; ``material``
    a name for `scenes.materials.resolve`, or `WALL`.
    """

    footprint: Polygon
    bottom: float
    top: float
    material: str

    def __post_init__(self) -> None:
        if not self.top > self.bottom:
            raise ValueError(f"top: {self.top}, expected above the bottom at {self.bottom} m")
        if not (self.footprint.area > 0.0 and self.footprint.is_valid):
            raise ValueError("footprint: expected a valid polygon with an area")

    @property
    def volume(self) -> float:
        """Volume, m³."""
        return float(self.footprint.area) * (self.top - self.bottom)


@dataclass(frozen=True)
class SolidGroup:
    """What a person would call one thing: the walls, a ceiling, a sofa.

    ``collection`` ('furniture') and ``name`` ('sofa 3') say what it is; ``pose``
    (x m, y m, degrees) is where it is taken hold of, the origin for what is built in.
    """

    collection: str
    name: str
    prisms: tuple[Prism, ...]
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0)


def polygons(region: shapely.Geometry, smallest: float = 1e-7) -> list[Polygon]:
    """The polygons of any geometry, without lines, points and specks below ``smallest`` m²."""
    return [
        part
        for part in shapely.get_parts(shapely.get_parts(region))
        if part.geom_type == "Polygon" and part.area > smallest
    ]


def block_footprint(block: Block) -> Polygon:
    """Footprint of a block, holes left out."""
    return Polygon(block.polygon, block.holes)


def masonry_region(apartment: Apartment) -> shapely.Geometry:
    """Union of the blocks that are walls."""
    return shapely.union_all([block_footprint(b) for b in apartment.blocks if b.is_masonry])


def rooms_region(apartment: Apartment) -> shapely.Geometry:
    """Union of the room polygons, without the masonry that stands in them."""
    rooms = shapely.union_all(room_shapes(apartment))
    masonry = masonry_region(apartment)
    return rooms if masonry.is_empty else rooms.difference(masonry)


def floor_area(apartment: Apartment) -> float:
    """Total clear floor of the rooms, furniture included, m² (Table 8)."""
    masonry = masonry_region(apartment)
    return float(shapely.area(shapely.difference(room_shapes(apartment), masonry)).sum())


def building_region(apartment: Apartment) -> shapely.Geometry:
    """Rooms and walls together, small gaps closed, openings filled."""
    lines = [
        shapely.LineString([wall.start, wall.end]).buffer(
            wall.thickness / 2, cap_style="square", join_style="mitre"
        )
        for wall in apartment.walls
    ]
    region = shapely.union_all([*lines, masonry_region(apartment), rooms_region(apartment)])
    # A little more than GAP, so that rounding does not decide about gaps of just that width.
    reach = GAP / 2 + 1e-3
    # GEOS raises floating-point flags on nearly straight mitres; its results are sound.
    with np.errstate(divide="ignore", invalid="ignore"):
        closed = region.buffer(reach, join_style="mitre").buffer(-reach, join_style="mitre")
    # Rounding drops the specks of the two buffers; the grid must not stick to the result,
    # or every later overlay would round furniture too.
    return shapely.set_precision(shapely.set_precision(closed.union(region), 1e-6), 0.0)


def wall_region(apartment: Apartment) -> shapely.Geometry:
    """Footprint of the walls before any opening is cut: the building without its rooms."""
    return building_region(apartment).difference(rooms_region(apartment))


def passage_rooms(apartment: Apartment, passage: Passage) -> tuple[int | None, int | None]:
    """Indices of the rooms on the right (-across) and the left (+across) side of a passage."""
    opening = place(apartment, passage.position, passage.width)
    shapes = room_shapes(apartment)

    def room_at(side: float) -> int | None:
        for step in (GAP + 0.01, 0.1):
            offset = side * (opening.thickness / 2 + step)
            point = shapely.Point(opening.points(np.array([0.0, offset])))
            inside = np.flatnonzero(shapely.intersects(shapes, point))
            if len(inside):
                return int(inside[0])
        return None

    return room_at(-1.0), room_at(1.0)


def cutter(opening: Opening, margin: float = 0.0) -> Polygon:
    """The rectangle that cuts an opening, ``margin`` m wider on either side.

    It reaches beyond both wall faces, into the rooms: were it to end on the faces,
    rounding could leave slits or spikes of no width across a passage of a turned
    apartment, and eroding by the robot's radius would then close the passage.
    """
    half, depth = opening.width / 2 + margin, opening.thickness / 2 + GAP + 0.01
    return opening.rectangle((-half, half), (-depth, depth))


def floor_region(apartment: Apartment) -> shapely.Geometry:
    """Rooms and the footprints of the open passages."""
    floors = [
        cutter(place(apartment, passage.position, passage.width))
        for passage in apartment.passages
        if not passage.closed
    ]
    return shapely.union_all([rooms_region(apartment), *floors])


def apartment_solids(apartment: Apartment) -> list[Prism]:
    """Every solid of the apartment, in a fixed order.

    Raises
    ------
    KeyError
        If a piece of furniture is of an unknown kind.
    ValueError
        If a piece is too small for its parts.
    """
    return [prism for group in solid_groups(apartment) for prism in group.prisms]


def solid_groups(apartment: Apartment) -> list[SolidGroup]:
    """Every solid of the apartment, by what it belongs to; empty groups are left out.

    Raises
    ------
    KeyError
        If a piece of furniture is of an unknown kind.
    """
    groups = [*_shell(apartment), *_contents(apartment)]
    return [group for group in groups if group.prisms]


def obstacles(apartment: Apartment, low: float = DRIVEN_OVER, high: float = 0.10) -> MultiPolygon:
    """What the robot can bump into: footprints of the solids between two heights.

    Parameters
    ----------
    apartment : Apartment
    low, high : float
        m above the floor: what is lower is driven over (rugs, thresholds), what begins
        higher is driven under (tables, beds).

    Returns
    -------
    MultiPolygon
    """
    return standing(apartment_solids(apartment), low, high)


def standing(solids: list[Prism], low: float = DRIVEN_OVER, high: float = 0.10) -> MultiPolygon:
    """`obstacles` of an apartment with these solids."""
    shapes = [prism.footprint for prism in solids if prism.bottom < high and prism.top > low]
    return MultiPolygon(polygons(shapely.union_all(shapes)))


def _prisms(region: shapely.Geometry, bottom: float, top: float, material: str) -> Iterator[Prism]:
    """One prism for each polygon of a region; none where there is no height left."""
    if top > bottom:
        for polygon in polygons(region):
            yield Prism(polygon, bottom, top, material)


def _shell(apartment: Apartment) -> Iterator[SolidGroup]:
    """Passages, windows, walls, floors, ceilings, skirting and blocks."""
    walls = wall_region(apartment)
    top = max(room.ceiling_height for room in apartment.rooms) + SLAB
    cutters = []
    for index, passage in enumerate(apartment.passages):
        opening = place(apartment, passage.position, passage.width)
        cutters.append(cutter(opening, lining_of(passage)))
        cut = cutters[-1].intersection(walls)
        parts = tuple(_passage(apartment, passage, opening, cut, top))
        yield SolidGroup("passages", f"passage {index}", parts)
    for index, window in enumerate(apartment.windows):
        opening = place(apartment, window.position, window.width)
        cutters.append(cutter(opening))
        cut = cutters[-1].intersection(walls)
        yield SolidGroup("windows", f"window {index}", tuple(_window(window, opening, cut, top)))
    cuts = shapely.union_all(cutters)
    solid = walls.difference(cuts)
    yield SolidGroup("walls", "walls", tuple(_prisms(solid, -SLAB, top, WALL)))
    for room in apartment.rooms:
        floor, ceiling = _slabs(room, solid, top)
        yield SolidGroup("floors", f"floor {room.name}", floor)
        yield SolidGroup("ceilings", f"ceiling {room.name}", ceiling)
        yield SolidGroup("skirting", f"skirting {room.name}", tuple(_skirting(room, solid, cuts)))
    for index, block in enumerate(apartment.blocks):
        if not block.is_masonry:
            name = WALL if block.material is None else block.material
            height = top if block.top is None else block.top
            prism = Prism(block_footprint(block), block.bottom, height, name)
            yield SolidGroup("blocks", f"block {index}", (prism,))


def _window(window: Window, opening: Opening, cut: shapely.Geometry, top: float) -> Iterator[Prism]:
    """Wall below and above a window, and its frame."""
    yield from _prisms(cut, -SLAB, window.sill_height, WALL)
    yield from _prisms(cut, window.head_height, top, WALL)
    yield from _window_frame(opening, (window.sill_height, window.head_height), window.frame)


def _slabs(
    room: Room, solid: shapely.Geometry, top: float
) -> tuple[tuple[Prism, ...], tuple[Prism, ...]]:
    """Floor and ceiling of a room, reaching a little into the walls around it."""
    shape = Polygon(room.polygon)
    wide = shape.buffer(OVERLAP, join_style="mitre").intersection(solid).union(shape)
    floor = tuple(_prisms(wide, -SLAB, 0.0, room.floor))
    return floor, tuple(_prisms(wide, room.ceiling_height, top, room.ceiling))


def _skirting(room: Room, solid: shapely.Geometry, cuts: shapely.Geometry) -> Iterator[Prism]:
    """Boards along the walls of a room, as far as no opening interrupts them."""
    if room.skirting is not None:
        depth = room.skirting.depth
        shape = Polygon(room.polygon).difference(solid)
        band = shape.difference(shape.buffer(-depth, join_style="mitre")).difference(cuts)
        near = band.intersection(solid.buffer(depth + 1e-6, join_style="mitre"))
        yield from _prisms(near, 0.0, room.skirting.height, room.skirting.material)


def _passage(
    apartment: Apartment, passage: Passage, opening: Opening, cut: shapely.Geometry, top: float
) -> Iterator[Prism]:
    """Floor, lintel or ceiling, frame, threshold and (closed) leaf of a passage."""
    joined = [apartment.rooms[i] for i in passage_rooms(apartment, passage) if i is not None]
    lowest = min(joined or apartment.rooms, key=lambda room: room.ceiling_height)
    floor = (joined or apartment.rooms)[0].floor
    yield from _prisms(cut, -SLAB, 0.0, floor)
    height = lowest.ceiling_height
    if passage.lintel_height is None or passage.lintel_height >= height:
        # A skin of ceiling; above it wall, which shows where the other room is higher.
        yield from _prisms(cut, height, height + 0.01, lowest.ceiling)
        yield from _prisms(cut, height + 0.01, top, WALL)
    else:
        height = passage.lintel_height
        yield from _prisms(cut, height + lining_of(passage), top, WALL)
    if passage.frame is not None:
        yield from _frame(passage, opening, height)
    foot = 0.0
    if (threshold := passage.threshold) is not None:
        foot = threshold.height
        yield Prism(opening.strip(threshold.depth), 0.0, foot, threshold.material)
    if passage.closed:
        yield Prism(opening.strip(LEAF), foot, height, "door_paint")


def _frame(passage: Passage, opening: Opening, height: float) -> Iterator[Prism]:
    """Lining inside the opening and casing on both wall faces; the head only under a lintel."""
    frame = passage.frame
    assert frame is not None
    half, face, lining = opening.width / 2, opening.thickness / 2, lining_of(passage)
    outer = half + frame.width
    headed = passage.lintel_height == height
    for a, b in ((-half - lining, -half), (half, half + lining)):
        board = opening.rectangle((a, b), (-face, face))
        yield Prism(board, 0.0, height + lining * headed, frame.material)
    if headed:
        board = opening.rectangle((-half, half), (-face, face))
        yield Prism(board, height, height + lining, frame.material)
    for c, d in ((-face - frame.depth, -face), (face, face + frame.depth)):
        for a, b in ((-outer, -half), (half, outer)):
            yield Prism(opening.rectangle((a, b), (c, d)), 0.0, height, frame.material)
        if headed:
            head = opening.rectangle((-outer, outer), (c, d))
            yield Prism(head, height, height + frame.width, frame.material)


def _window_frame(opening: Opening, heights: tuple[float, float], material: str) -> Iterator[Prism]:
    """Bars around the opening in the middle of the wall, one more in wide windows."""
    (sill, head), half, deep = heights, opening.width / 2, (-SASH / 2, SASH / 2)
    if head - sill < 4 * SASH or half < 2 * SASH:
        return
    uprights = [(-half, -half + SASH), (half - SASH, half)]
    for upright in uprights:
        yield Prism(opening.rectangle(upright, deep), sill, head, material)
    if opening.width > 1.0:
        middle = opening.rectangle((-SASH / 2, SASH / 2), deep)
        yield Prism(middle, sill + SASH, head - SASH, material)
    bar = opening.rectangle((-half + SASH, half - SASH), deep)
    yield Prism(bar, sill, sill + SASH, material)
    yield Prism(bar, head - SASH, head, material)


def _contents(apartment: Apartment) -> Iterator[SolidGroup]:
    """Furniture and lamps."""
    for index, piece in enumerate(apartment.furniture):
        prisms = tuple(_prism(part) for part in piece_parts(piece))
        pose = (*piece.position, piece.rotation_deg)
        yield SolidGroup("furniture", f"{piece.kind} {index}", prisms, pose)
    for index, lamp in enumerate(apartment.lamps):
        prisms = tuple(_prism(part) for part in lamp_parts(apartment, index))
        yield SolidGroup("lamps", f"{lamp.kind} lamp {index}", prisms, (*lamp.position, 0.0))


def _prism(part: Part) -> Prism:
    return Prism(part.footprint, part.bottom, part.top, part.material)
