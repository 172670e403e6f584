"""From border lines to crossed edges, pieces, rooms and leaks (§3.1.1).

A border leaks if some edge that it crosses joins two nodes which are still
joined without the border edges: the line does not separate. The shortest way
round, by the number of edges, shows where.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse.csgraph import breadth_first_order

from dataset.topomap import GroundTruth, TopoMap
from roomseg.annotation.drawing import Drawing
from roomseg.ground_truth import (
    Pieces,
    cut_pieces,
    label_rooms,
    rooms_by_clustering,
    rooms_of_pieces,
)
from roomseg.preprocessing import MapGraph, preprocess
from roomseg.spectral import adjacency

__all__ = ["Cut", "CuttableMap", "Leak"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Leak:
    """A way round a border: its nodes, shape (k,), and length, m."""

    border: int
    nodes: Integers
    length: float


@dataclass(frozen=True)
class Cut:
    """What the borders of a drawing do to the map.

    Attributes
    ----------
    border, edge : arrays, shape (c,)
        Each crossing: position in ``Drawing.borders``, edge of the map.
    edge_is_border : array, shape (e,)
    pieces : Pieces
    leaks : tuple of Leak
        Of borders that do not separate; ``border`` is the border's number.
    idle : tuple of int
        Numbers of the borders that cross no edge.
    """

    border: Integers
    edge: Integers
    edge_is_border: NDArray[np.bool_]
    pieces: Pieces
    leaks: tuple[Leak, ...]
    idle: tuple[int, ...]

    @property
    def proposed_count(self) -> int:
        """As many rooms as there are pieces that are no strips within a passage."""
        return max(1, int(np.count_nonzero(~self.pieces.is_strip)))


class CuttableMap:
    """A map prepared for being cut again and again.

    Parameters
    ----------
    topomap : TopoMap
        Its position estimates count, as the operator sees them.
    """

    def __init__(self, topomap: TopoMap) -> None:
        self.topomap = topomap
        self.graph: MapGraph = preprocess(topomap)
        self.position: Floats = topomap.nodes.position
        self.edges: Integers = topomap.edges.astype(np.int64)
        lines = self.position[self.edges].reshape(-1, 2, 2)
        self._tree = shapely.STRtree(shapely.linestrings(lines))

    @cached_property
    def lengths(self) -> Floats:
        """Of all edges, m, shape (e,)."""
        return self.topomap.edge_lengths()

    def crossings(self, segments: Floats) -> tuple[Integers, Integers]:
        """Which lines, shape (b, 2, 2), cross which edges: line and edge, shapes (c,)."""
        if not len(segments):
            return np.zeros(0, np.int64), np.zeros(0, np.int64)
        pairs = self._tree.query(shapely.linestrings(segments), predicate="intersects")
        line, edge = pairs[:, np.lexsort(pairs[::-1])]
        return line, edge

    def cut(self, drawing: Drawing) -> Cut:
        """Cut along the borders of a drawing."""
        border, edge = self.crossings(drawing.segments)
        is_border = np.zeros(len(self.edges), bool)
        is_border[edge] = True
        pieces = cut_pieces(self.topomap, self.graph, is_border)
        crossed = np.bincount(border, minlength=len(drawing.borders))
        idle = tuple(b.id for b, n in zip(drawing.borders, crossed, strict=True) if not n)
        leaks = self._leaks(drawing, border, edge, is_border, pieces.piece)
        return Cut(border, edge, is_border, pieces, leaks, idle)

    def _leaks(
        self,
        drawing: Drawing,
        border: Integers,
        edge: Integers,
        is_border: NDArray[np.bool_],
        piece: Integers,
    ) -> tuple[Leak, ...]:
        ends = piece[self.edges[edge]]
        leaking = ends[:, 0] == ends[:, 1]
        if not leaking.any():
            return ()
        inner = ~is_border
        graph = adjacency(len(self.position), self.edges[inner], np.ones(inner.sum()))
        leaks = []
        for index in np.unique(border[leaking]):
            line = drawing.borders[index]
            found = self._way_round(graph, line.ends, edge[leaking & (border == index)])
            if found is not None:
                leaks.append(Leak(line.id, *found))
        return tuple(leaks)

    def _way_round(
        self, graph: object, ends: tuple[float, ...], edges: Integers
    ) -> tuple[Integers, float] | None:
        """Shortest way from one side of a line to the other, tried at both of its ends."""
        middle = self.position[self.edges[edges]].mean(axis=1)
        along = middle @ (np.array(ends[2:]) - np.array(ends[:2]))
        ways = [
            self._way(graph, *self.edges[edges[at]])
            for at in {int(along.argmin()), int(along.argmax())}
        ]
        measured = [(way, self._length(way)) for way in ways if way is not None]
        return min(measured, key=lambda way: way[1]) if measured else None

    def _way(self, graph: object, start: int, goal: int) -> Integers | None:
        _, before = breadth_first_order(graph, start, directed=False)
        way = [int(goal)]
        while way[-1] != start:
            if before[way[-1]] < 0:
                return None
            way.append(int(before[way[-1]]))
        return np.array(way[::-1])

    def _length(self, nodes: Integers) -> float:
        return float(np.linalg.norm(np.diff(self.position[nodes], axis=0), axis=1).sum())

    def rooms_at_once(self, cut: Cut, count: int) -> Integers:
        """Room of each node as the pieces have it, 0 .. , shape (n,)."""
        is_border = cut.edge_is_border[self.graph.kept]
        return rooms_of_pieces(self.graph, is_border, cut.pieces, count)

    def confirmed(self, drawing: Drawing, cut: Cut, count: int) -> Integers:
        """Rooms by `roomseg.ground_truth.label_rooms`, shape (n,).

        Raises
        ------
        FormatError
            If the borders do not cut the map into so many rooms.
        """
        truth = GroundTruth(drawing.segments, "map", cut.edge_is_border, count)
        room = label_rooms(self.topomap.with_ground_truth(truth)).ground_truth
        assert room is not None and room.room is not None
        return room.room.astype(np.int64)

    def clustered(self, cut: Cut, count: int) -> Integers:
        """Rooms as the clustering alone has them, whether or not the borders cut, (n,)."""
        rng = np.random.default_rng(self.topomap.seed)
        return rooms_by_clustering(self.graph, cut.edge_is_border[self.graph.kept], count, rng)
