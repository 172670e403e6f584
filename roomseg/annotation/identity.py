"""Room identities that stay while borders move.

Clustering numbers the rooms anew each time. A new room takes the identity of
the old one with which it shares most nodes, one to one, such that as many nodes
as possible keep theirs. A room that vanishes, because two flow together for a
moment, is remembered with its last nodes and returns with its name.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from roomseg.annotation.drawing import Drawing, Room, ranges_of

__all__ = ["identified", "room_of_nodes"]

Integers = NDArray[np.int64]


def identified(drawing: Drawing, label: Integers) -> Drawing:
    """Give the rooms of a labelling, shape (n,), their identities."""
    count = int(label.max()) + 1
    owner = _owners(drawing.rooms, label, count)
    seen = {}
    number = drawing.next_room
    for index in range(count):
        nodes = ranges_of(np.flatnonzero(label == index))
        old = owner.get(index)
        if old is None:
            seen[number] = Room(number, "", nodes)
            number += 1
        else:
            seen[old.id] = replace(old, nodes=nodes, active=True)
    away = [replace(room, active=False) for room in drawing.rooms if room.id not in seen]
    rooms = sorted([*seen.values(), *away], key=lambda room: room.id)
    return replace(drawing, rooms=tuple(rooms), next_room=number)


def _owners(rooms: tuple[Room, ...], label: Integers, count: int) -> dict[int, Room]:
    """Old room of each new one, where they share nodes."""
    if not rooms:
        return {}
    shared = np.stack([np.bincount(label[room.indices()], minlength=count) for room in rooms])
    # One that is there goes before one that is remembered, if both fit as well.
    there = np.array([room.active for room in rooms])
    old, new = linear_sum_assignment(2 * shared + there[:, None], maximize=True)
    return {int(n): rooms[o] for o, n in zip(old, new, strict=True) if shared[o, n]}


def room_of_nodes(drawing: Drawing, node_count: int) -> Integers:
    """Number of each node's room, shape (n,); 0 where there is none."""
    number = np.zeros(node_count, np.int64)
    for room in drawing.active_rooms:
        number[room.indices()] = room.id
    return number
