"""Edges between the nodes of a track: what is adjacent, with nothing in the way (§2.1)."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from dataset.importers.track import Drive
from dataset.topomap import Nodes, Visits

__all__ = ["CLEARANCE", "EDGE_RADIUS", "adjacent_pairs", "connected_drive"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

EDGE_RADIUS = 0.40
"""Nodes of different lanes this near are adjacent, m, with lanes 0.30 m apart (§2.2)."""
CLEARANCE = 0.10
"""No obstacle point is nearer to the line of direct travel, m."""
LONG_LANE = 8
"""Nodes of a lane that tells how far apart lanes are."""
FARTHEST_JOIN = 1.0
"""Pieces of a track that are farther apart are not one map, m."""


def lane_spacing(nodes: Nodes) -> float:
    """Usual distance from a lane to the next of its part, m; 0.30 if there are none."""
    gaps: list[Floats] = []
    keys = np.stack([nodes.part, nodes.lane], axis=1)
    for part, lane in np.unique(keys, axis=0).tolist():
        here = nodes.position[(keys == (part, lane)).all(axis=1)]
        beside = nodes.position[(keys == (part, lane + 1)).all(axis=1)]
        if min(len(here), len(beside)) >= LONG_LANE:
            gaps.append(KDTree(here).query(beside)[0])
    return float(np.median(np.concatenate(gaps))) if gaps else 0.30


def adjacent_pairs(drive: Drive, obstacles: Floats) -> Integers:
    """All edges of a drive.

    Consecutive nodes are joined, whatever is said to be between: the robot drove there.
    Nodes of other lanes are joined within `EDGE_RADIUS`, or as much less as lanes are
    nearer than 0.30 m, if no obstacle point is within `CLEARANCE` of the line.

    Parameters
    ----------
    drive : Drive
    obstacles : array, shape (k, 2)
        m.

    Returns
    -------
    array, shape (e, 2)
        Smaller node first, rows sorted, none twice.
    """
    nodes = drive.nodes
    radius = EDGE_RADIUS * float(np.clip(lane_spacing(nodes) / 0.30, 0.65, 1.1))
    pairs = KDTree(nodes.position).query_pairs(radius, output_type="ndarray").astype(np.int64)
    first, second = pairs.T
    other = (nodes.part[first] != nodes.part[second]) | (nodes.lane[first] != nodes.lane[second])
    pairs = pairs[other]
    if len(obstacles) and len(pairs):
        tree = shapely.STRtree(shapely.points(np.unique(obstacles, axis=0)))
        lines = shapely.linestrings(nodes.position[pairs])
        barred = tree.query(lines, predicate="dwithin", distance=CLEARANCE)[0]
        pairs = np.delete(pairs, np.unique(barred), axis=0)
    every = np.concatenate([np.sort(pairs, axis=1), drive.driven.reshape(-1, 2)])
    found: Integers = np.unique(every, axis=0).astype(np.int64)
    return found


def connected_drive(drive: Drive, edges: Integers) -> tuple[Drive, Integers, tuple[str, ...]]:
    """Join pieces of a map that are near each other, and leave out all others but the largest.

    Returns
    -------
    drive, edges, notes
        With nodes counted anew.
    """
    notes = []
    position = drive.nodes.position
    while len(sizes := np.bincount(piece := _pieces(len(position), edges))) > 1:
        main = piece == sizes.argmax()
        gap, near = KDTree(position[main]).query(position[~main])
        k = int(gap.argmin())
        a, b = np.flatnonzero(main)[near[k]], np.flatnonzero(~main)[k]
        if gap[k] > FARTHEST_JOIN:
            notes.append(f"{(~main).sum()} nodes are not joined to the others; left out")
            return *_subset(drive, edges, main), tuple(notes)
        notes.append(f"two pieces of the path, {gap[k]:.2f} m apart, are joined")
        edges = np.unique(np.vstack([edges, sorted((a, b))]), axis=0)
    return drive, edges, tuple(notes)


def _pieces(n: int, edges: Integers) -> NDArray[np.int32]:
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(n, n))
    labels: NDArray[np.int32] = connected_components(graph, directed=False)[1]
    return labels


def _subset(drive: Drive, edges: Integers, kept: NDArray[np.bool_]) -> tuple[Drive, Integers]:
    nodes, number = drive.nodes, np.cumsum(kept) - 1
    some = Nodes(nodes.position[kept], nodes.heading[kept], nodes.part[kept], nodes.lane[kept])
    seen = kept[drive.visits.node]
    visits = Visits(number[drive.visits.node[seen]].astype(np.int32), drive.visits.time[seen])
    driven = number[drive.driven[kept[drive.driven].all(axis=1)]]
    return Drive(some, visits, driven), number[edges[kept[edges].all(axis=1)]]
