"""Furniture and fittings as prisms, with real clearances.

What a robot of 10 cm meets is what stands within 10 cm of the floor: four legs
of a table or a bed, the whole of a wardrobe. Every kind is one small function
of its (width, depth, height) that yields parts in the piece's own frame: the
middle of the footprint at the origin, the back towards +y, the floor at z = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import shapely

from scenes import fittings, furniture
from scenes.apartment import Piece
from scenes.parts import Part, Parts

__all__ = ["KINDS", "Kind", "piece_parts"]


@dataclass(frozen=True)
class Kind:
    """A kind of piece: default size, its slots with their default materials, and its maker."""

    size: tuple[float, float, float]
    slots: Mapping[str, str]
    build: Callable[[float, float, float], Parts]


def _kind(
    size: tuple[float, float, float], build: Callable[[float, float, float], Parts], **slots: str
) -> Kind:
    return Kind(size, MappingProxyType(slots), build)


_CABINET = {"body": "lacquer_white", "fronts": "lacquer_white", "handles": "metal"}
_CERAMIC = {"ceramic": "ceramic", "tap": "metal"}

KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "armchair": _kind(
            (0.8, 0.85, 0.85),
            furniture.armchair,
            fabric="fabric_grey",
            cushions="fabric_grey",
            legs="wood",
        ),
        "basin": _kind((0.6, 0.48, 0.86), fittings.basin, **_CERAMIC),
        "bath": _kind((1.7, 0.75, 0.56), fittings.bath, **_CERAMIC),
        "bed": _kind(
            (1.6, 2.1, 0.95),
            furniture.bed,
            frame="wood",
            mattress="fabric_white",
            cover="fabric_blue",
        ),
        "box": _kind((0.5, 0.4, 0.5), fittings.whole, body="wood_light"),
        "chair": _kind((0.44, 0.48, 0.9), furniture.chair, frame="wood", seat="wood"),
        "coffee_table": _kind((1.0, 0.6, 0.42), furniture.coffee_table, top="wood", legs="wood"),
        "curtain": _kind((0.7, 0.1, 2.35), fittings.curtain, fabric="fabric_beige", rail="metal"),
        "desk": _kind(
            (1.4, 0.7, 0.74),
            furniture.desk,
            top="wood_light",
            legs="metal",
            drawers="wood_light",
            screen="plastic_black",
        ),
        "fridge": _kind(
            (0.6, 0.66, 1.8),
            fittings.fridge,
            body="lacquer_white",
            plinth="plastic_black",
            handles="metal",
        ),
        "kitchen_counter": _kind(
            (2.4, 0.62, 0.9),
            fittings.kitchen_counter,
            worktop="stone",
            hob="glass_dark",
            **_CABINET,
        ),
        "floor_lamp": _kind(
            (0.4, 0.4, 1.6), fittings.floor_lamp, stand="metal_dark", shade="paper"
        ),
        "office_chair": _kind(
            (0.6, 0.6, 1.05), furniture.office_chair, frame="metal_dark", seat="fabric_dark"
        ),
        "picture": _kind((0.6, 0.03, 0.45), fittings.picture, frame="wood_dark", picture="paper"),
        "plant": _kind(
            (0.6, 0.6, 1.2),
            fittings.plant,
            pot="tiles_terracotta",
            soil="soil",
            stem="wood",
            leaves="leaves",
        ),
        "radiator": _kind((0.9, 0.1, 0.7), fittings.radiator, body="lacquer_white"),
        "round_table": _kind(
            (0.9, 0.9, 0.75), furniture.round_table, top="wood_light", legs="metal"
        ),
        "rug": _kind((2.0, 1.4, 0.008), fittings.rug, fabric="carpet_red"),
        "shelf": _kind(
            (0.8, 0.3, 1.9), furniture.shelf, body="wood_light", books="paper", boxes="fabric_red"
        ),
        "shower_tray": _kind((0.9, 0.9, 0.05), fittings.shower_tray, **_CERAMIC),
        "sofa": _kind(
            (2.0, 0.9, 0.82),
            furniture.sofa,
            fabric="fabric_grey",
            cushions="fabric_grey",
            legs="wood",
        ),
        "table": _kind((1.4, 0.8, 0.75), furniture.table, top="wood", legs="wood"),
        "toilet": _kind((0.38, 0.66, 0.8), fittings.toilet, ceramic="ceramic", lid="plastic_white"),
        "tv_stand": _kind(
            (1.6, 0.42, 1.1), furniture.tv_stand, body="wood", screen="plastic_black"
        ),
        "wall_cupboard": _kind((1.2, 0.37, 0.7), fittings.wall_cupboard, **_CABINET),
        "wardrobe": _kind((1.5, 0.62, 2.1), furniture.wardrobe, **_CABINET),
        "washing_machine": _kind(
            (0.6, 0.6, 0.85), fittings.washing_machine, body="lacquer_white", door="glass_dark"
        ),
    }
)
"""Every kind by its name in files."""


def piece_parts(piece: Piece) -> list[Part]:
    """Parts of a piece in the scene frame, each with its *material* in ``slot``.

    Raises
    ------
    KeyError
        If the kind is not in `KINDS`.
    ValueError
        If the size leaves no room for a part.
    """
    kind = KINDS[piece.kind]
    angle = np.radians(piece.rotation_deg)
    # Rounding keeps quarter turns exact, so that edges stay parallel to the walls.
    c, s = round(float(np.cos(angle)), 15), round(float(np.sin(angle)), 15)
    turn = np.array([[c, s], [-s, c]])
    materials = {**kind.slots, **piece.materials}
    parts = list(kind.build(*(piece.size or kind.size)))
    footprints = shapely.transform(
        [part.footprint for part in parts], lambda xy: xy @ turn + np.array(piece.position)
    )
    return [
        Part(shape, part.bottom + piece.elevation, part.top + piece.elevation, materials[part.slot])
        for shape, part in zip(footprints, parts, strict=True)
    ]
