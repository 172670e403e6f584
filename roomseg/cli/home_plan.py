"""What a plan shows of an apartment: from the scene's terms to those of the figure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

if TYPE_CHECKING:
    from roomseg.figures import HomePlan, PlanDoor, PlanWindow, Symbol
    from scenes import Apartment, Passage, Piece

__all__ = ["group_of", "home_plan"]

HEAD = 1.2
"""A plan is a section at this height, m; what begins above it is hung."""

SINGLE = {
    "boiler": "heating",
    "ceiling_beam": "fixtures",
    "door_mat": "decoration",
    "extractor_hood": "kitchen",
    "floor_lamp": "lamps",
    "plant": "decoration",
    "radiator": "heating",
    "rug": "decoration",
    "towel_radiator": "heating",
    "wall_cupboard": "kitchen",
    "wall_shelf": "storage",
    "washing_machine": "bathroom",
}
"""Kinds whose group in the figure is not that of the module that makes them."""
ALSO = {"walls": "decoration"}
"""Modules whose group has another name."""


def group_of(kind: str) -> str:
    """Group in the figure of a kind of piece: the module that makes it, mostly."""
    from roomseg.figures.plan import GROUPS
    from scenes.pieces import KINDS

    module = KINDS[kind].build.__module__.rpartition(".")[2]
    group = SINGLE.get(kind) or ALSO.get(module, module)
    return group if group in GROUPS else "other"


def home_plan(apartment: Apartment) -> HomePlan:
    """Everything that the plan of an apartment shows."""
    from roomseg.figures import HomePlan, PlanRoom
    from scenes.solids import block_footprint, masonry_region

    masonry = masonry_region(apartment)
    shapes = [shapely.Polygon(room.polygon).difference(masonry) for room in apartment.rooms]
    doors = tuple(_door(apartment, passage) for passage in apartment.passages)
    windows = _windows(apartment)
    free = [block for block in apartment.blocks if not block.is_masonry]
    start = apartment.start
    return HomePlan(
        name=apartment.name,
        rooms=tuple(
            PlanRoom(room.name, shape, float(shape.area))
            for room, shape in zip(apartment.rooms, shapes, strict=True)
        ),
        walls=_walls(apartment, [*(d.opening for d in doors), *(w.opening for w in windows)]),
        doors=doors,
        windows=windows,
        solids=tuple(block_footprint(block) for block in free if block.bottom < HEAD),
        overhead=tuple(block_footprint(block) for block in free if block.bottom >= HEAD),
        borders=np.array(apartment.borders, dtype=float).reshape(-1, 2, 2),
        symbols=_symbols(apartment),
        lamps=np.array([(*lamp.position, lamp.radius) for lamp in apartment.lamps]).reshape(-1, 3),
        start=(*start.position, float(np.radians(start.heading_deg))),
    )


def _walls(apartment: Apartment, openings: list[Any]) -> Any:
    from scenes.solids import polygons, wall_region

    solid = wall_region(apartment).difference(shapely.union_all(openings))
    return shapely.MultiPolygon(polygons(solid))


def _door(apartment: Apartment, passage: Passage) -> PlanDoor:
    """The gap with its frame: lining inside the opening, casing on both faces of the wall."""
    from roomseg.figures import PlanDoor
    from scenes.openings import lining_of, place
    from scenes.solids import LEAF

    opening = place(apartment, passage.position, passage.width)
    half, face = opening.width / 2, opening.thickness / 2
    faces = [[(-half, side), (half, side)] for side in (-face, face)]
    frame = leaf = threshold = None
    if passage.frame is not None:
        lining, outer = lining_of(passage), half + passage.frame.width
        depth = face + passage.frame.depth
        frame = shapely.union_all(
            [
                opening.rectangle((min(side * a, side * b), max(side * a, side * b)), across)
                for side in (-1.0, 1.0)
                for a, b, across in (
                    (half, half + lining, (-face, face)),
                    (half, outer, (-depth, -face)),
                    (half, outer, (face, depth)),
                )
            ]
        )
    if passage.closed:
        leaf = opening.strip(LEAF)
    if passage.threshold is not None:
        threshold = opening.strip(passage.threshold.depth)
    cut = opening.rectangle((-half, half), (-face, face))
    lintel = passage.lintel_height is not None
    return PlanDoor(cut, opening.points(np.array(faces)), lintel, frame, leaf, threshold)


def _windows(apartment: Apartment) -> tuple[PlanWindow, ...]:
    from roomseg.figures import PlanWindow
    from scenes.openings import place

    found = []
    for window in apartment.windows:
        opening = place(apartment, window.position, window.width)
        half, face = opening.width / 2, opening.thickness / 2
        pane = opening.points(np.array([(-half, 0.0), (half, 0.0)]))
        found.append(PlanWindow(opening.rectangle((-half, half), (-face, face)), pane))
    return tuple(found)


def _symbols(apartment: Apartment) -> tuple[Symbol, ...]:
    """Parts of the pieces, the lowest first, as one sees them from above."""
    drawn = [found for piece in apartment.furniture for found in _parts(piece)]
    return tuple(symbol for _, symbol in sorted(drawn, key=lambda found: found[0]))


def _parts(piece: Piece) -> list[tuple[float, Symbol]]:
    """Symbols of a piece's parts with their height, m; of a hung piece the outline."""
    from roomseg.figures import Symbol
    from scenes.pieces import piece_parts

    parts = piece_parts(piece)
    group, name = group_of(piece.kind), piece.kind.replace("_", " ")
    if min(part.bottom for part in parts) >= HEAD:
        outline = shapely.union_all([part.footprint for part in parts])
        return [(max(part.top for part in parts), Symbol(group, outline, hung=True, name=name))]
    return [(part.top, Symbol(group, part.footprint, name=name)) for part in parts]
