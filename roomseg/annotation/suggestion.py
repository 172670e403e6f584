"""Border lines that the computer proposes for a person to correct.

A classifier marks edges and a clustering parts nodes, but a person draws lines. A
group of edges is crossed by the straight line near their middles, about at right
angles to them, that crosses fewest edges of the map: the narrowest place. The line
runs on to both sides as long as there are edges to cross, to the walls or the furniture.
Rooms that meet in the middle of a floor give lines that part nothing; they are not proposed.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from roomseg.annotation.cut import CuttableMap
from roomseg.ground_truth import cut_pieces
from roomseg.room_count import usual_room_count
from roomseg.segmentation import affinity_of, edge_weights
from roomseg.spectral import adjacency, spectral_clustering

__all__ = ["dividing_lines", "suggested_lines"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]

REACH = 0.35
"""m; middles of edges of one border, and crossings of one line, lie no farther apart."""
ALIKE = float(np.cos(np.radians(40.0)))
"""Edges of one border point the same way, roughly."""
BEYOND = 0.12
"""m; a line ends so far beyond the last edge that it crosses."""
SHIFTS = np.linspace(-0.2, 0.2, 9)
TURNS = np.radians(np.linspace(-20.0, 20.0, 9))
NEAR = 4.0
"""m; no line goes on so far from the edges that it is for."""
PARTED = 0.5
"""Share of the edges crossed by a line whose nodes it has to part."""
NEARLY = 0.8
"""A line without which so much of a part stays cut off is one too many."""


@dataclass(frozen=True)
class _Line:
    centre: Floats
    across: Floats
    """Unit vector along the line."""

    def places(self, segments: Floats) -> tuple[Floats, Integers]:
        """Where the endless line crosses segments, (k, 2, 2): m from the centre, and which."""
        normal = np.array([-self.across[1], self.across[0]])
        side = (segments - self.centre) @ normal
        which = np.flatnonzero((side[:, 0] < 0) != (side[:, 1] < 0))
        first, second = side[which].T
        share = first / (first - second)
        start, end = segments[which, 0], segments[which, 1]
        point = start + share[:, None] * (end - start)
        return (point - self.centre) @ self.across, which

    def run(self, segments: Floats) -> tuple[Floats, Integers]:
        """Those crossings around the centre between which there is no gap, ascending."""
        place, which = self.places(segments)
        order = np.argsort(place, kind="stable")
        place, which = place[order], which[order]
        if not len(place):
            return place, which
        group = np.cumsum(np.r_[0, np.diff(place) > REACH])
        own = group == group[np.abs(place).argmin()]
        return place[own], which[own]


def suggested_lines(
    canvas: CuttableMap, is_border: Flags, rho: float, rooms: int | None, seed: int
) -> Floats:
    """Lines where the rooms meet that a classifier's edges give.

    A classifier marks far more edges than there are borders; the clustering finds those
    that part the map (§2.4).

    Parameters
    ----------
    canvas : CuttableMap
    is_border : array, shape (e',)
        What the classifier says of the edges of ``canvas.graph``.
    rho : float
        Its ρ.
    rooms : int or None
        How many rooms; None: as homes of that size have.
    seed : int
        For the starts of k-means.

    Returns
    -------
    array, shape (k, 2, 2)
        m; those that cross most edges for which the classifier speaks first.
    """
    affinity = affinity_of(canvas.graph, edge_weights(canvas.graph, is_border, rho))
    nodes = canvas.graph.node_count
    # One more than usual: a line too many is soon struck out.
    count = rooms or min(nodes, usual_room_count(nodes) + 1)
    label = spectral_clustering(affinity, count, np.random.default_rng(seed))
    edges = canvas.graph.edges
    segments = canvas.position[edges]
    meeting = label[edges[:, 0]] != label[edges[:, 1]]
    found = []
    for group in _groups(segments[meeting]):
        line, crossed = _narrowest(segments[meeting][group], segments)
        found.append((-int(is_border[crossed].sum()), line))
    found.sort(key=lambda suggestion: suggestion[0])
    lines = np.round(np.array([line for _, line in found]).reshape(-1, 2, 2), 4)
    return _parting(canvas, lines)


def _parting(canvas: CuttableMap, lines: Floats, drawn: Floats | None = None) -> Floats:
    """Those lines, (k, 2, 2), that with those drawn part the nodes of most edges they cross."""
    drawn = np.zeros((0, 2, 2)) if drawn is None else drawn
    line, edge = canvas.crossings(lines)
    kept = np.ones(len(lines), bool)
    while kept.any():
        ends = _pieces(canvas, np.concatenate([drawn, lines[kept]]))[canvas.edges[edge]]
        parted = np.bincount(line[ends[:, 0] != ends[:, 1]], minlength=len(lines))
        share = parted / np.maximum(np.bincount(line, minlength=len(lines)), 1)
        share[~kept] = 1.0
        if share.min() >= PARTED:
            break
        kept[share.argmin()] = False
    chosen: Floats = lines[kept]
    return chosen


def _pieces(canvas: CuttableMap, lines: Floats) -> Integers:
    """Into which piece each node comes if borders are drawn, shape (n,)."""
    is_border = np.zeros(len(canvas.edges), bool)
    is_border[canvas.crossings(lines)[1]] = True
    return cut_pieces(canvas.topomap, canvas.graph, is_border).piece


def dividing_lines(canvas: CuttableMap, nodes: Integers, drawn: Floats, seed: int) -> Floats:
    """Lines that divide a room where it is narrow, near its normalised cut, shape (k, 2, 2).

    Several if it is divided at several places, as a room with a loop; none if no edge
    joins two of its nodes, or no straight lines part them.

    Parameters
    ----------
    canvas : CuttableMap
    nodes : array, shape (k,)
        The room's.
    drawn : array, shape (b, 2, 2)
        Borders that are there.
    seed : int
        For the starts of k-means.
    """
    none = np.zeros((0, 2, 2))
    inside = np.full(len(canvas.position), -1)
    inside[nodes] = np.arange(len(nodes))
    edges = inside[canvas.graph.edges]
    edges = edges[(edges >= 0).all(axis=1)]
    if not len(edges):
        return none
    affinity = adjacency(len(nodes), edges, np.ones(len(edges)))
    pieces, piece = connected_components(affinity, directed=False)
    if pieces == 1:
        half = spectral_clustering(affinity, 2, np.random.default_rng(seed))
    else:
        half = (piece == np.bincount(piece).argmax()).astype(np.int64)
    inner = inside[canvas.edges]
    inner = inner[(inner >= 0).all(axis=1)]
    between = half[inner[:, 0]] != half[inner[:, 1]]
    segments = canvas.position[nodes][inner]
    groups = _groups(segments[between])
    lines = [_narrowest(segments[between][group], segments)[0] for group in groups]
    found = _parting(canvas, np.round(np.array(lines).reshape(-1, 2, 2), 4), drawn)

    def other_part(lines: Floats) -> int:
        size = np.bincount(_pieces(canvas, np.concatenate([drawn, lines]))[nodes])
        return int(np.sort(size)[-2]) if np.count_nonzero(size) > 1 else 0

    whole = other_part(found)
    for index in reversed(range(len(found))):
        fewer = np.delete(found, index, axis=0)
        if other_part(fewer) >= NEARLY * whole > 0:
            found = fewer
    return found


def _groups(segments: Floats) -> list[Integers]:
    """Indices of segments, shape (k, 2, 2), that one line may cross."""
    if not len(segments):
        return []
    step = segments[:, 1] - segments[:, 0]
    way = step / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-9)
    pairs = KDTree(segments.mean(axis=1)).query_pairs(REACH, output_type="ndarray")
    alike = np.abs(np.einsum("ij,ij->i", way[pairs[:, 0]], way[pairs[:, 1]])) >= ALIKE
    linked = adjacency(len(segments), pairs[alike], np.ones(int(alike.sum())))
    count, group = connected_components(linked, directed=False)
    return [np.flatnonzero(group == index) for index in range(count)]


def _narrowest(group: Floats, segments: Floats) -> tuple[Floats, Integers]:
    """Line across a group of segments that crosses fewest of all, and which it crosses."""
    step = group[:, 1] - group[:, 0]
    # The axis to which they are parallel, whichever way each of them points.
    along = np.linalg.eigh(step.T @ step)[1][:, 1]
    centre = np.median(group.mean(axis=1), axis=0)
    nearby = np.flatnonzero((np.abs(segments[:, 0] - centre) < NEAR).all(axis=1))
    segments = segments[nearby]
    best: tuple[float, _Line] | None = None
    for shift, turn in product(SHIFTS, TURNS):
        c, s = np.cos(turn), np.sin(turn)
        across = np.array([-c * along[1] - s * along[0], c * along[0] - s * along[1]])
        line = _Line(centre + shift * along, across)
        crossed = len(line.run(segments)[0])
        cost = (crossed or np.inf) + abs(shift) + abs(turn)
        if best is None or cost < best[0]:
            best = cost, line
    assert best is not None
    line = best[1]
    place, which = line.run(segments)
    if not len(place):
        place = np.zeros(1)
    ends = np.array([place[0] - BEYOND, place[-1] + BEYOND])
    return line.centre + ends[:, None] * line.across, nearby[which]
