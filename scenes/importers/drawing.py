"""What a floor plan says, whatever its file format: rooms, walls, openings, fixtures.

Readers of floor plans fill a `PlanDrawing`, in metres, x right, y up;
`scenes.importers.plan.build_apartment` makes an apartment of it. Every element
has a ``label`` by which notes and errors call it (``features[3] (door)``).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from scenes.apartment import Block, Piece, Point, RoomKind, Wall

__all__ = [
    "PlanDrawing",
    "PlanFixture",
    "PlanOpening",
    "PlanRoom",
    "free_name",
    "long_axis",
    "renamed",
]


@dataclass(frozen=True)
class PlanRoom:
    """A room as drawn; ``fields`` are further fields of `scenes.apartment.Room`."""

    label: str
    name: str
    kind: RoomKind
    shape: Polygon
    fields: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class PlanOpening:
    """A door or a window: the line along its wall, as long as it is wide.

    ``outside`` is what a door becomes behind which there is no room.
    ``fields`` are further fields of `Passage` (doors) or `Window`.
    """

    label: str
    kind: Literal["door", "window"]
    start: Point
    end: Point
    outside: Literal["closed", "window"] = "closed"
    fields: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class PlanFixture:
    """A piece of furniture by its outline; ``kind`` is one of `scenes.pieces.KINDS`.

    ``piece`` is the piece itself where a file says all of it.
    """

    label: str
    kind: str
    shape: Polygon
    piece: Piece | None = None


@dataclass(frozen=True)
class PlanDrawing:
    """A floor plan in metres.

    ``walls`` are centre lines, ``wall_shapes`` the footprints of walls;
    ``openings`` may lie in either, or in no wall at all. ``blocks`` and
    ``borders`` go into the apartment as they are, and so do ``fields``, further
    fields of `scenes.apartment.Apartment`. ``notes`` say what the reader could
    not use.
    """

    rooms: tuple[PlanRoom, ...]
    walls: tuple[Wall, ...] = ()
    wall_shapes: tuple[Polygon, ...] = ()
    openings: tuple[PlanOpening, ...] = ()
    fixtures: tuple[PlanFixture, ...] = ()
    blocks: tuple[Block, ...] = ()
    borders: tuple[tuple[Point, Point], ...] = ()
    fields: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def free_name(text: str, taken: Iterable[str]) -> str:
    """A name that an apartment's file allows, like ``text`` and unlike those taken."""
    name = re.sub(r"[^A-Za-z0-9_.-]+", "_", text).strip("_.-")[:56] or "room"
    taken, count, free = set(taken), 1, name
    while free in taken:
        count += 1
        free = f"{name}_{count}"
    return free


def renamed(label: str, name: str, chosen: str) -> str:
    """The note on a name that an apartment's file does not allow."""
    return f"{label}: {name!r:.60} is no name for a room; called {chosen!r}"


def long_axis(shape: shapely.Geometry) -> NDArray[np.float64]:
    """The line (2, 2) through the middle of a thin shape, from end to end."""
    box = shapely.get_coordinates(shapely.minimum_rotated_rectangle(shape))
    if len(box) < 4:
        return box[[0, -1]] if len(box) > 1 else np.repeat(box, 2, axis=0)
    if np.hypot(*(box[1] - box[0])) < np.hypot(*(box[2] - box[1])):
        box = box[[1, 2, 3, 0]]
    axis: NDArray[np.float64] = np.array([(box[0] + box[3]) / 2, (box[1] + box[2]) / 2])
    return axis
