"""Ground-truth room labels from border edges and the room count (§3.1.1).

What the paper says: spectral clustering of the map graph, with weight 10⁻⁴ for
border edges and 1 for all others, into the given number of rooms; a human
confirms the result. Several parallel lines may cover a deep passage; nodes
between two lines belong to no room by the lines alone and take the label that
the clustering gives them.

Nobody looks at thousands of generated maps, so we confirm by rule. Without the
border edges the map falls into pieces; all its edges count, since of a lane between
two lanes of an older part Algorithm 1 keeps the edges to one of them only. Pieces of
which at least half the nodes touch a border edge are taken for strips within passages; the largest
``room_count`` pieces, strips last, are the rooms. Another piece that is no strip
and has at least half of the smallest room's nodes is one room more than the
operator counted: then the lines or the count are wrong, and that is an error.
Otherwise each room must have one label of its own and no strip may be
torn; if so, the clustering's labels stand. If the clustering misses that
(k-means may), the pieces become the rooms, and each strip goes to the room to
which border edges tie it most.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from dataset.errors import FormatError
from dataset.topomap import GroundTruth, TopoMap
from roomseg.preprocessing import MapGraph, preprocess
from roomseg.segmentation import affinity_of
from roomseg.spectral import adjacency, first_node_order, spectral_clustering

__all__ = [
    "BORDER_WEIGHT",
    "Pieces",
    "cut_pieces",
    "known_truth",
    "label_rooms",
    "rooms_by_clustering",
    "rooms_of_pieces",
]

BORDER_WEIGHT = 1e-4

Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]


def known_truth(topomap: TopoMap) -> GroundTruth:
    """Ask for the map's ground truth.

    Raises
    ------
    FormatError
        If it has none.
    """
    if topomap.ground_truth is None:
        raise FormatError(
            f"{topomap.environment}/{topomap.run}: no ground_truth, expected borders "
            "and a room count; annotate the map first"
        )
    return topomap.ground_truth


def label_rooms(
    topomap: TopoMap, seed: int | None = None, *, room_of_node: Integers | None = None
) -> TopoMap:
    """Label every node with its room (§3.1.1).

    Parameters
    ----------
    topomap : TopoMap
        With ``edge_is_border`` and ``room_count`` in its ground truth.
    seed : int, optional
        For the starts of k-means; the map's own seed by default.
    room_of_node : array, shape (n,), optional
        The room that each node is known to lie in, -1 if none: pieces within one are one.

    Returns
    -------
    TopoMap
        The same map with ``ground_truth.room``: labels 0 .. room_count - 1,
        numbered by the first node of each room.

    Raises
    ------
    FormatError
        If there is no ground truth, or its borders do not cut the map into
        ``room_count`` rooms.
    """
    truth = known_truth(topomap)
    graph = preprocess(topomap)
    is_border = truth.edge_is_border[graph.kept]
    if not 1 <= truth.room_count <= graph.node_count:
        raise FormatError(
            f"ground_truth room_count: {truth.room_count}, expected 1..{graph.node_count}"
        )
    rng = np.random.default_rng(topomap.seed if seed is None else seed)
    labels = rooms_by_clustering(graph, is_border, truth.room_count, rng)
    pieces = cut_pieces(topomap, graph, truth.edge_is_border)
    if room_of_node is not None:
        pieces = pieces.joined_within(room_of_node)
    labels = _confirmed(topomap, graph, pieces, labels)
    return topomap.with_ground_truth(replace(truth, room=labels.astype(np.int32)))


def rooms_by_clustering(
    graph: MapGraph, is_border: Flags, rooms: int, rng: np.random.Generator
) -> Integers:
    """Spectral clustering with weight 10⁻⁴ for border edges, as the paper has it, shape (n,)."""
    weights = np.where(is_border, BORDER_WEIGHT, 1.0)
    return spectral_clustering(affinity_of(graph, weights), rooms, rng)


@dataclass(frozen=True)
class Pieces:
    """What the map falls into without its border edges.

    Attributes
    ----------
    piece : array, shape (n,)
        Piece of each node.
    size : array, shape (p,)
        Its nodes.
    is_strip : array, shape (p,)
        Whether at least half of them touch a border edge: a strip within a passage.
    """

    piece: Integers
    size: Integers
    is_strip: Flags

    def largest(self, count: int) -> Integers:
        """The pieces that are rooms if there are so many of them, strips last."""
        # A strip across a wide passage may have more nodes than a tiny room.
        order: Integers = np.lexsort((-self.size, self.is_strip))
        return order[:count]

    def joined_within(self, room_of_node: Integers) -> Pieces:
        """The same with those made one that lie in one room for the most part, strips left out."""
        inside = (room_of_node >= 0) & ~self.is_strip[self.piece]
        if not inside.any():
            return self
        nodes = np.zeros((len(self.size), room_of_node.max() + 1), dtype=np.int64)
        np.add.at(nodes, (self.piece[inside], room_of_node[inside]), 1)
        known, room = np.flatnonzero(nodes.any(axis=1)), nodes.argmax(axis=1)
        first = {int(room[piece]): int(piece) for piece in known[::-1]}
        owner = np.arange(len(self.size))
        owner[known] = [first[int(room[piece])] for piece in known]
        kept, piece = np.unique(owner[self.piece], return_inverse=True)
        return Pieces(piece, np.bincount(piece), self.is_strip[kept])


def cut_pieces(topomap: TopoMap, graph: MapGraph, edge_is_border: Flags) -> Pieces:
    """Cut the map's border edges, shape (e,).

    Parts of a map that no edge joins at all are joined as for the clustering.
    """
    is_border = edge_is_border[graph.kept]
    inner = topomap.edges[~edge_is_border].astype(np.int64)
    joined = affinity_of(graph, np.where(is_border, BORDER_WEIGHT, 1.0)) > BORDER_WEIGHT
    joined = joined + adjacency(graph.node_count, inner, np.ones(len(inner)))
    piece = connected_components(joined, directed=False)[1].astype(np.int64)
    size = np.bincount(piece)
    touching = np.bincount(piece[np.unique(graph.edges[is_border])], minlength=len(size))
    return Pieces(piece, size, 2 * touching >= size)


def _confirmed(topomap: TopoMap, graph: MapGraph, pieces: Pieces, labels: Integers) -> Integers:
    """Confirm the clustering's labels, or take the pieces'; see the module's text."""
    truth = known_truth(topomap)
    count = truth.room_count
    size, rooms = pieces.size, pieces.largest(truth.room_count)
    name = f"{topomap.environment}/{topomap.run}"
    if len(size) < count:
        raise FormatError(
            f"{name}: ground_truth/borders cut the map into {len(size)} pieces, "
            f"expected at least the room_count {count}"
        )
    surplus = ~pieces.is_strip & (2 * size >= size[rooms[-1]])
    surplus[rooms] = False
    if surplus.any():
        raise FormatError(
            f"{name}: ground_truth/borders cut the map into {count + surplus.sum()} rooms, "
            f"expected the room_count {count}"
        )
    if _follows_pieces(labels, pieces.piece, rooms):
        return labels
    return rooms_of_pieces(graph, truth.edge_is_border[graph.kept], pieces, count)


def _follows_pieces(labels: Integers, piece: Integers, rooms: Integers) -> bool:
    """Whether no piece is torn and the largest ones have labels of their own."""
    first = np.unique(piece, return_index=True)[1]
    of_piece = labels[first]
    return bool((labels == of_piece[piece]).all() and len(set(of_piece[rooms])) == len(rooms))


def rooms_of_pieces(graph: MapGraph, is_border: Flags, pieces: Pieces, count: int) -> Integers:
    """Rooms are the largest pieces; strips join the room they have most edges to, in turn."""
    piece, rooms = pieces.piece, pieces.largest(count)
    label = np.full(piece.max() + 1, -1)
    label[rooms] = np.arange(len(rooms))
    ends = piece[graph.edges[is_border]]
    while (label[ends] >= 0).any(axis=1).sum() > (label[ends] >= 0).all(axis=1).sum():
        towards = np.concatenate([ends, ends[:, ::-1]])
        open_end = (label[towards[:, 0]] < 0) & (label[towards[:, 1]] >= 0)
        votes = np.zeros((len(label), len(rooms)), dtype=np.int64)
        np.add.at(votes, (towards[open_end, 0], label[towards[open_end, 1]]), 1)
        strip = votes.argmax(axis=0)[votes.max(axis=0).argmax()]
        label[strip] = votes[strip].argmax()
    return first_node_order(label[piece])
