"""Splitting and merging rooms, done on the borders that part them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dataset.errors import RoomsegError
from roomseg.annotation.cut import Cut, CuttableMap
from roomseg.annotation.drawing import SHORTEST_BORDER, Border, Drawing
from roomseg.annotation.identity import room_of_nodes
from roomseg.annotation.suggestion import dividing_lines

__all__ = ["merged", "split"]

Floats = NDArray[np.float64]


def split(canvas: CuttableMap, drawing: Drawing, number: int) -> Drawing:
    """Draw borders where a room is narrow; one room more than were given.

    Raises
    ------
    RoomsegError
        If there is no such room, or no straight lines part its nodes.
    """
    room = drawing.room(number)
    lines = dividing_lines(canvas, room.indices(), drawing.segments, number)
    if not len(lines):
        raise RoomsegError(f"{room.title}: found no place to split it; draw the border by hand")
    drawn = drawing.with_borders(lines.reshape(-1, 4))
    return drawn if drawn.count is None else replace(drawn, count=drawn.count + 1)


def merged(canvas: CuttableMap, drawing: Drawing, cut: Cut, first: int, second: int) -> Drawing:
    """Take away the borders between two rooms; the one with more nodes keeps its identity.

    Of a line that parts other rooms, too, what crosses edges between the two goes.

    Raises
    ------
    RoomsegError
        If there are no such rooms, or no border parts them.
    """
    rooms = (drawing.room(first), drawing.room(second))
    if first == second:
        raise RoomsegError(f"{rooms[0].title}: expected two rooms to merge")
    ends = room_of_nodes(drawing, len(canvas.position))[canvas.edges]
    between = np.isin(ends, (first, second)).all(axis=1)
    parts = between & cut.edge_is_border & (ends[:, 0] != ends[:, 1])
    if not parts.any():
        raise RoomsegError(f"{rooms[0].title} and {rooms[1].title}: no border parts them")
    borders: list[Border] = []
    number = drawing.next_border
    for index, border in enumerate(drawing.borders):
        edges = cut.edge[cut.border == index]
        if not between[edges].any():
            borders.append(border)
            continue
        for line in _without(canvas, border, edges, between[edges]):
            borders.append(Border(number, line))
            number += 1
    kept, lost = sorted(rooms, key=lambda room: (-room.size, room.id))
    name = kept.name or lost.name
    return replace(
        drawing,
        borders=tuple(borders),
        next_border=number,
        count=None if drawing.count is None else max(1, drawing.count - 1),
        rooms=tuple(
            replace(room, name=name) if room.id == kept.id else room
            for room in drawing.rooms
            if room.id != lost.id
        ),
    )


def _without(
    canvas: CuttableMap, border: Border, edges: NDArray[np.int64], gone: NDArray[np.bool_]
) -> list[tuple[float, float, float, float]]:
    """What is left of a line without its crossings of some edges."""
    start, end = np.array(border.ends[:2]), np.array(border.ends[2:])
    at = _places(canvas.position[canvas.edges[edges]], start, end)
    order = np.argsort(at, kind="stable")
    at, gone = at[order], gone[order]
    # The line changes between an edge that goes and the next one that stays.
    cuts = np.flatnonzero(np.diff(gone.astype(int))) + 1
    limits = np.concatenate([[0.0], (at[cuts - 1] + at[cuts]) / 2, [1.0]])
    stays = ~gone[np.r_[0, cuts]]
    lines = []
    for low, high in zip(limits[:-1][stays], limits[1:][stays], strict=True):
        if (high - low) * border.length >= SHORTEST_BORDER:
            a, b = start + low * (end - start), start + high * (end - start)
            lines.append((float(a[0]), float(a[1]), float(b[0]), float(b[1])))
    return lines


def _places(segments: Floats, start: Floats, end: Floats) -> Floats:
    """Where segments, shape (k, 2, 2), cross the line, as shares of its length, (k,)."""
    normal = np.array([start[1] - end[1], end[0] - start[0]])
    side = (segments - start) @ normal
    total = side[:, 0] - side[:, 1]
    share = np.where(total == 0.0, 0.5, side[:, 0] / np.where(total == 0.0, 1.0, total))
    point = segments[:, 0] + share[:, None] * (segments[:, 1] - segments[:, 0])
    direction = end - start
    return np.clip((point - start) @ direction / (direction @ direction), 0.0, 1.0)
