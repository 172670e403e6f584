"""What is in an apartment, in figures."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import Polygon

from scenes.apartment import Apartment, Passage
from scenes.passages import passage_rooms
from scenes.rooms import room_shapes
from scenes.solids import GAP, floor_area, masonry_region, obstacles, rooms_region

__all__ = ["ApartmentSummary", "RoomSummary", "summarise_apartment"]

LEAST_SHARED = 0.1
"""Rooms that share less of a border are not open to each other, m."""


@dataclass(frozen=True)
class RoomSummary:
    """A room: clear floor area, m², ceiling height, m, surfaces.

    ``passages_to`` are the rooms that it leads to by passages and borders without a wall.
    """

    name: str
    kind: str
    area: float
    ceiling_height: float
    floor: str
    walls: str
    ceiling: str
    passages_to: tuple[str, ...]


@dataclass(frozen=True)
class ApartmentSummary:
    """An apartment in figures; areas m², lamps' power W of light."""

    name: str
    description: str
    rooms: tuple[RoomSummary, ...]
    floor_area: float
    free_area: float
    """Floor of the rooms that nothing stands on; that of the doorways does not count."""
    passages: int
    framed_passages: int
    passages_without_lintel: int
    closed_passages: int
    thresholds: int
    windows: int
    borders_without_wall: int
    pieces: dict[str, int]
    """How many of each kind."""
    lamps: int
    lamp_power: float
    lighting: str
    passageway_contrast: str
    scene_file: str | None


def summarise_apartment(apartment: Apartment) -> ApartmentSummary:
    """The figures of an apartment."""
    open_passages = [passage for passage in apartment.passages if not passage.closed]
    scene = apartment.scene_file
    return ApartmentSummary(
        name=apartment.name,
        description=apartment.description,
        rooms=_rooms(apartment, open_passages),
        floor_area=floor_area(apartment),
        free_area=float(rooms_region(apartment).difference(obstacles(apartment)).area),
        passages=len(open_passages),
        framed_passages=sum(passage.frame is not None for passage in open_passages),
        passages_without_lintel=sum(passage.lintel_height is None for passage in open_passages),
        closed_passages=len(apartment.passages) - len(open_passages),
        thresholds=sum(passage.threshold is not None for passage in apartment.passages),
        windows=len(apartment.windows),
        borders_without_wall=len(apartment.borders),
        pieces=dict(sorted(Counter(piece.kind for piece in apartment.furniture).items())),
        lamps=len(apartment.lamps),
        lamp_power=sum(lamp.power for lamp in apartment.lamps),
        lighting=apartment.lighting.source,
        passageway_contrast=apartment.passageway_contrast,
        scene_file=None if scene is None else scene.file,
    )


def _rooms(apartment: Apartment, passages: list[Passage]) -> tuple[RoomSummary, ...]:
    masonry = masonry_region(apartment)
    joined = [passage_rooms(apartment, passage) for passage in passages]
    joined += _open_to_each_other(apartment)
    found = []
    for index, room in enumerate(apartment.rooms):
        ends = [set(pair) - {index, None} for pair in joined if index in pair]
        near = sorted({other for end in ends for other in end if other is not None})
        found.append(
            RoomSummary(
                room.name,
                room.kind,
                float(Polygon(room.polygon).difference(masonry).area),
                room.ceiling_height,
                room.floor,
                room.walls,
                room.ceiling,
                tuple(apartment.rooms[other].name for other in near),
            )
        )
    return tuple(found)


def _open_to_each_other(apartment: Apartment) -> list[tuple[int, int]]:
    """Indices of the rooms on either side of the borders that no wall parts."""
    if not apartment.borders:
        return []
    segments = np.array(apartment.borders, dtype=float).reshape(-1, 2, 2)
    lines = shapely.union_all(shapely.linestrings(segments))
    # A little wider: rooms may be up to a gap apart from the line.
    edges = shapely.buffer(shapely.boundary(room_shapes(apartment)), GAP)
    shared = shapely.intersection(edges, lines)
    pairs = shapely.STRtree(shared).query(shared, predicate="intersects").T
    return [
        (int(a), int(b))
        for a, b in pairs
        if a < b and shared[a].intersection(shared[b]).length > LEAST_SHARED
    ]
