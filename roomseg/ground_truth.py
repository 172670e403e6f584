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

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from dataset.errors import FormatError
from dataset.topomap import GroundTruth, TopoMap
from roomseg.preprocessing import MapGraph, preprocess
from roomseg.segmentation import affinity_of
from roomseg.spectral import adjacency, first_node_order, spectral_clustering

__all__ = ["BORDER_WEIGHT", "known_truth", "label_rooms"]

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


def label_rooms(topomap: TopoMap, seed: int | None = None) -> TopoMap:
    """Label every node with its room (§3.1.1).

    Parameters
    ----------
    topomap : TopoMap
        With ``edge_is_border`` and ``room_count`` in its ground truth.
    seed : int, optional
        For the starts of k-means; the map's own seed by default.

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
    rng = np.random.default_rng(topomap.seed if seed is None else seed)
    if not 1 <= truth.room_count <= graph.node_count:
        raise FormatError(
            f"ground_truth room_count: {truth.room_count}, expected 1..{graph.node_count}"
        )
    weights = np.where(is_border, BORDER_WEIGHT, 1.0)
    labels = spectral_clustering(affinity_of(graph, weights), truth.room_count, rng)
    labels = _confirmed(topomap, graph, is_border, labels, truth.room_count)
    return topomap.with_ground_truth(replace(truth, room=labels.astype(np.int32)))


def _confirmed(
    topomap: TopoMap, graph: MapGraph, is_border: Flags, labels: Integers, rooms: int
) -> Integers:
    """Confirm the clustering's labels, or take the pieces'; see the module's text."""
    piece, size = _pieces(topomap, graph, is_border)
    touching = np.bincount(piece[np.unique(graph.edges[is_border])], minlength=len(size))
    # A strip across a wide passage may have more nodes than a tiny room: strips come last.
    by_size = np.lexsort((-size, 2 * touching >= size))
    name = f"{topomap.environment}/{topomap.run}"
    if len(size) < rooms:
        raise FormatError(
            f"{name}: ground_truth/borders cut the map into {len(size)} pieces, "
            f"expected at least the room_count {rooms}"
        )
    surplus = (2 * touching < size) & (2 * size >= size[by_size[rooms - 1]])
    surplus[by_size[:rooms]] = False
    if surplus.any():
        raise FormatError(
            f"{name}: ground_truth/borders cut the map into {rooms + surplus.sum()} rooms, "
            f"expected the room_count {rooms}"
        )
    if _follows_pieces(labels, piece, by_size[:rooms]):
        return labels
    return _labels_of_pieces(graph, is_border, piece, by_size[:rooms])


def _pieces(topomap: TopoMap, graph: MapGraph, is_border: Flags) -> tuple[Integers, Integers]:
    """Piece of each node without the border edges, shape (n,), and nodes of each piece.

    Parts of a map that no edge joins at all are joined as for the clustering.
    """
    inner = topomap.edges[~known_truth(topomap).edge_is_border].astype(np.int64)
    joined = affinity_of(graph, np.where(is_border, BORDER_WEIGHT, 1.0)) > BORDER_WEIGHT
    joined = joined + adjacency(graph.node_count, inner, np.ones(len(inner)))
    piece = connected_components(joined, directed=False)[1].astype(np.int64)
    return piece, np.bincount(piece)


def _follows_pieces(labels: Integers, piece: Integers, rooms: Integers) -> bool:
    """Whether no piece is torn and the largest ones have labels of their own."""
    first = np.unique(piece, return_index=True)[1]
    of_piece = labels[first]
    return bool((labels == of_piece[piece]).all() and len(set(of_piece[rooms])) == len(rooms))


def _labels_of_pieces(
    graph: MapGraph, is_border: Flags, piece: Integers, rooms: Integers
) -> Integers:
    """Rooms are the largest pieces; strips join the room they have most edges to, in turn."""
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
