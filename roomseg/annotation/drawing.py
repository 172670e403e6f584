"""What a person has drawn on a map: borders, rooms and their names. Edits give a new drawing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dataset.errors import RoomsegError

__all__ = ["LONGEST_NAME", "SHORTEST_BORDER", "Border", "Drawing", "Room", "Segment", "ranges_of"]

Floats = NDArray[np.float64]
Segment = tuple[float, float, float, float]
"""x0, y0, x1, y1, m, in the map frame."""

SHORTEST_BORDER = 0.03
"""m; a shorter line is a slip of the hand."""
FARTHEST = 1e4
"""m; no coordinate is farther away."""
LONGEST_NAME = 60
DECIMALS = 4


@dataclass(frozen=True)
class Border:
    """A line across a room border; its number stays while it is moved."""

    id: int
    ends: Segment

    @property
    def length(self) -> float:
        """M."""
        x0, y0, x1, y1 = self.ends
        return float(np.hypot(x1 - x0, y1 - y0))


@dataclass(frozen=True)
class Room:
    """A room's identity: number and name stay while its outline changes.

    Attributes
    ----------
    id : int
    name : str
        Empty if nobody has named it.
    nodes : tuple of (first, last)
        Ranges of the nodes that it had when it was last seen.
    active : bool
        Whether it is there now. One that is not may return with its old nodes.
    """

    id: int
    name: str
    nodes: tuple[tuple[int, int], ...]
    active: bool = True

    @property
    def title(self) -> str:
        """Its name, or its number."""
        return self.name or f"room {self.id}"

    @property
    def size(self) -> int:
        """How many nodes it had when it was last seen."""
        return sum(last - first + 1 for first, last in self.nodes)

    def indices(self) -> NDArray[np.int64]:
        """Those nodes, shape (k,)."""
        pieces = [np.arange(first, last + 1) for first, last in self.nodes]
        return np.concatenate(pieces) if pieces else np.zeros(0, np.int64)


def ranges_of(nodes: NDArray[np.int64]) -> tuple[tuple[int, int], ...]:
    """Ascending node numbers as ranges (first, last): a lane's nodes follow one another."""
    if not len(nodes):
        return ()
    cuts = np.flatnonzero(np.diff(nodes) != 1)
    first = nodes[np.r_[0, cuts + 1]]
    last = nodes[np.r_[cuts, len(nodes) - 1]]
    return tuple(zip(first.tolist(), last.tolist(), strict=True))


@dataclass(frozen=True)
class Drawing:
    """The state of an annotation; every edit makes a new one.

    Attributes
    ----------
    borders : tuple of Border
    count : int or None
        The number of rooms that the person gives; None: as many as the borders cut off.
    rooms : tuple of Room
    struck : tuple of Segment
        Suggestions that the person has struck out.
    next_border, next_room : int
        Numbers are never used again.
    """

    borders: tuple[Border, ...] = ()
    count: int | None = None
    rooms: tuple[Room, ...] = ()
    struck: tuple[Segment, ...] = ()
    next_border: int = 1
    next_room: int = 1

    @property
    def segments(self) -> Floats:
        """The borders as an array, shape (b, 2, 2), m."""
        return np.array([border.ends for border in self.borders], float).reshape(-1, 2, 2)

    @property
    def active_rooms(self) -> tuple[Room, ...]:
        """The rooms that are there, by their numbers."""
        return tuple(sorted((r for r in self.rooms if r.active), key=lambda room: room.id))

    def border(self, number: int) -> Border:
        """Find a border by its number (RoomsegError if it is not there)."""
        for border in self.borders:
            if border.id == number:
                return border
        raise RoomsegError(f"border {number}: there is none, expected one of those drawn")

    def room(self, number: int) -> Room:
        """Find a room that is there by its number (RoomsegError if it is not)."""
        for room in self.rooms:
            if room.id == number and room.active:
                return room
        raise RoomsegError(f"room {number}: there is none, expected one of the list")

    def with_borders(self, lines: Iterable[Any], shortest: float = SHORTEST_BORDER) -> Drawing:
        """Draw more lines, each x0, y0, x1, y1 (RoomsegError if one is too short)."""
        new = [
            Border(self.next_border + index, checked_line(line, shortest))
            for index, line in enumerate(lines)
        ]
        return replace(
            self,
            borders=(*self.borders, *new),
            next_border=self.next_border + len(new),
        )

    def moved(self, number: int, line: Any) -> Drawing:
        """Give a border other ends."""
        self.border(number)
        ends = checked_line(line)
        borders = tuple(Border(b.id, ends) if b.id == number else b for b in self.borders)
        return replace(self, borders=borders)

    def without(self, numbers: Iterable[int]) -> Drawing:
        """Delete borders."""
        gone = {self.border(number).id for number in numbers}
        return replace(self, borders=tuple(b for b in self.borders if b.id not in gone))

    def counted(self, count: int | None, most: int) -> Drawing:
        """Give the number of rooms, 1 .. most; None: as many as the borders cut off."""
        if count is not None and not 1 <= count <= most:
            raise RoomsegError(f"rooms: {count}, expected 1..{most}")
        return replace(self, count=count)

    def renamed(self, number: int, name: str) -> Drawing:
        """Name a room; an empty name takes it back. No two rooms have the same."""
        text = " ".join(name.split())
        if len(text) > LONGEST_NAME or not text.isprintable():
            raise RoomsegError(
                f"room name: {text[:LONGEST_NAME]!r}, expected at most {LONGEST_NAME} "
                "letters that can be printed"
            )
        self.room(number)
        for other in self.active_rooms:
            if text and other.id != number and other.title == text:
                raise RoomsegError(f"room name: {text!r} is that of another room")
        rooms = tuple(replace(r, name=text) if r.id == number else r for r in self.rooms)
        return replace(self, rooms=rooms)

    def with_struck(self, line: Any) -> Drawing:
        """Strike out a suggestion."""
        ends = checked_line(line)
        return self if ends in self.struck else replace(self, struck=(*self.struck, ends))


def checked_line(line: Any, shortest: float = SHORTEST_BORDER) -> Segment:
    """Four finite numbers, rounded to 0.1 mm, that are a line at least ``shortest`` m long."""
    values = np.asarray(line, dtype=float).reshape(-1)
    if values.shape != (4,) or not (np.abs(values) < FARTHEST).all():
        raise RoomsegError(f"border: {line!r}, expected four numbers x0, y0, x1, y1 in metres")
    x0, y0, x1, y1 = np.round(values, DECIMALS).tolist()
    length = np.hypot(x1 - x0, y1 - y0)
    if length < shortest:
        raise RoomsegError(f"border: {length:.3f} m long, expected at least {shortest} m")
    return x0, y0, x1, y1
