"""Shortest paths over the growing map, as machine code (Dijkstra, §2.1)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import compiled

__all__ = ["Ways", "shortest"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Ways(NamedTuple):
    """The edges of every node, as linked lists of the newest first.

    End e of edge k, 0 or 1, is entry 2 k + e. ``edges`` (k, 2): the nodes that are joined;
    ``length`` (k,) m; ``newest`` (n,): the newest entry of a node, -1 for none;
    ``older`` (2 k,): the next older one of the same node.
    """

    edges: NDArray[np.int32]
    length: Floats
    newest: Ints
    older: Ints


@compiled
def shortest(ways: Ways, total: int, start: int, goal: int) -> tuple[Floats, Ints]:
    """Path length, m, from ``start`` to each of ``total`` nodes, and the node before it.

    ``inf`` and -1 where there is no path. The search ends at ``goal``, or with -1 nowhere:
    what is farther away than the goal may then not be right yet.
    """
    length, previous = np.full(total, np.inf), np.full(total, -1)
    keys, nodes = np.empty(len(ways.older) + 1), np.empty(len(ways.older) + 1, np.int64)
    length[start] = 0.0
    keys[0], nodes[0], size = 0.0, start, 1
    while size > 0:
        reached, node = keys[0], nodes[0]
        size = _pop(keys, nodes, size)
        if node == goal:
            break
        entry = ways.newest[node] if reached <= length[node] else -1
        while entry >= 0:
            other = int(ways.edges[entry // 2, 1 - entry % 2])
            through = reached + ways.length[entry // 2]
            if through < length[other]:
                length[other], previous[other] = through, node
                size = _push(keys, nodes, size, through, other)
            entry = ways.older[entry]
    return length, previous


@compiled
def _push(keys: Floats, nodes: Ints, size: int, key: float, node: int) -> int:
    """Put a node into a heap, the least key first; returns its new size."""
    place = size
    while place > 0 and keys[(place - 1) // 2] > key:
        above = (place - 1) // 2
        keys[place], nodes[place] = keys[above], nodes[above]
        place = above
    keys[place], nodes[place] = key, node
    return size + 1


@compiled
def _pop(keys: Floats, nodes: Ints, size: int) -> int:
    """Take the first node out of a heap; returns its new size."""
    size -= 1
    key, node = keys[size], nodes[size]
    place, below = 0, 1
    while below < size:
        if below + 1 < size and keys[below + 1] < keys[below]:
            below += 1
        if keys[below] >= key:
            break
        keys[place], nodes[place] = keys[below], nodes[below]
        place, below = below, 2 * below + 1
    keys[place], nodes[place] = key, node
    return size
