"""Map-graph preprocessing: fewer edges, and weights by length (§2.1.1).

The paper gives Algorithm 1 and says that a weight is divided by the length of
its edge. It leaves open what happens where the nearest node of the previous
lane (or of an older part) is not linked to the node at all, for instance
because a wall corner stands between them: taken to the letter, the pseudo-code
then deletes every edge to that lane or part. We keep "those edges with the
minimal spatial distance", that is, we look for the nearest *linked* node; a
node never loses its last edge to a lane, and a connected map stays connected.
``linked_only=False`` gives the letter of the pseudo-code.

Algorithm 1 speaks of the previous lane of the same part and of older parts
only: edges within a lane, and between lanes of a part that are not
subsequent, are left alone. An edge is judged by its newer node only, so the
order of the nodes does not matter and all edges can be judged at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from dataset.topomap import Nodes, TopoMap

__all__ = ["MINIMUM_LENGTH", "MapGraph", "length_weights", "preprocess"]

MINIMUM_LENGTH = 0.01
"""m; shorter edges weigh as much as this one, so that no weight is infinite."""

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class MapGraph:
    """The sparse graph that all later steps use (Fig. 5).

    Attributes
    ----------
    node_count : int
        n, nodes of the map.
    kept : array, shape (e',)
        Indices of the kept edges in ``TopoMap.edges``, ascending.
    edges : array, shape (e', 2)
        The kept edges, smaller node first.
    length : array, shape (e',)
        l from the position estimates, m (§2.2.1).
    """

    node_count: int
    kept: Integers
    edges: Integers
    length: Floats

    def __len__(self) -> int:
        return len(self.kept)


def preprocess(topomap: TopoMap, *, linked_only: bool = True) -> MapGraph:
    """Remove superfluous edges between lanes and between parts (Algorithm 1).

    Parameters
    ----------
    topomap : TopoMap
    linked_only : bool
        Take the nearest *linked* node of a lane or part (see the module's
        text); False: the nearest node, whether linked or not.

    Returns
    -------
    MapGraph
        With e' <= e edges.
    """
    edges = topomap.edges.astype(np.int64)
    length = topomap.edge_lengths()
    newer, older, group = _judged(topomap.nodes, edges)
    kept = _nearest_per_group(newer, older, group, length)
    if not linked_only:
        kept &= _is_nearest_node(topomap.nodes, newer, older, group)
    kept |= group == _UNTOUCHED
    index = np.flatnonzero(kept)
    return MapGraph(len(topomap.nodes), index, edges[index], length[index])


_UNTOUCHED = -2
_PREVIOUS_LANE = -1


def _judged(nodes: Nodes, edges: Integers) -> tuple[Integers, Integers, Integers]:
    """Newer node, older node and the older node's group of each edge, shapes (e,).

    The group is the older part's number, `_PREVIOUS_LANE`, or `_UNTOUCHED` for
    edges of which Algorithm 1 does not speak.
    """
    first, second = edges.T
    part_step = nodes.part[second].astype(np.int64) - nodes.part[first]
    lane_step = nodes.lane[second].astype(np.int64) - nodes.lane[first]
    swap = (part_step < 0) | ((part_step == 0) & (lane_step < 0))
    newer, older = np.where(swap, first, second), np.where(swap, second, first)
    same_part = np.where(np.abs(lane_step) == 1, _PREVIOUS_LANE, _UNTOUCHED)
    group = np.where(part_step == 0, same_part, nodes.part[older])
    return newer, older, group


def _nearest_per_group(
    newer: Integers, older: Integers, group: Integers, length: Floats
) -> NDArray[np.bool_]:
    """Whether an edge is the shortest from its newer node to its group, shape (e,)."""
    order = np.lexsort([older, length, group, newer])
    first = np.ones(len(order), dtype=bool)
    first[1:] = (np.diff(newer[order]) != 0) | (np.diff(group[order]) != 0)
    shortest = np.zeros(len(order), dtype=bool)
    shortest[order[first]] = True
    return shortest


def _is_nearest_node(
    nodes: Nodes, newer: Integers, older: Integers, group: Integers
) -> NDArray[np.bool_]:
    """Whether the older node is the nearest of its whole group, linked or not, shape (e,)."""
    nearest = np.zeros(len(newer), dtype=bool)
    target = np.where(group == _PREVIOUS_LANE, nodes.lane[older], -1)
    keys = np.stack([nodes.part[older], target], axis=1)
    for part, lane in np.unique(keys[group != _UNTOUCHED], axis=0):
        edge = np.flatnonzero(
            (keys == (part, lane)).all(axis=1) & ((group == _PREVIOUS_LANE) == (lane >= 0))
        )
        members = (nodes.part == part) & ((nodes.lane == lane) if lane >= 0 else True)
        tree = KDTree(nodes.position[members])
        distance = np.linalg.norm(nodes.position[newer[edge]] - nodes.position[older[edge]], axis=1)
        nearest[edge] = distance <= tree.query(nodes.position[newer[edge]])[0] + 1e-12
    return nearest


def length_weights(length: Floats) -> Floats:
    """Edge weight 1 / l, so that cuts along and across lanes cost the same (§2.1.1).

    Parameters
    ----------
    length : array, shape (e',)
        m; lengths below `MINIMUM_LENGTH` count as that.

    Returns
    -------
    array, shape (e',)
        1/m.
    """
    return 1.0 / np.maximum(length, MINIMUM_LENGTH)
