"""From a map graph and its border edges to rooms (§2.4).

The robot has driven from every node to the next, so a map graph is connected.
Should a file's graph be in pieces nevertheless, each piece is joined to the
node created just before its first node, with the median weight: without such a
link, spectral clustering would spend its clusters on the pieces.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from dataset.errors import FormatError
from roomseg.preprocessing import MapGraph, length_weights
from roomseg.spectral import adjacency, spectral_clustering

__all__ = ["affinity_of", "edge_weights", "segment"]

Floats = NDArray[np.float64]


def edge_weights(
    graph: MapGraph, is_border: NDArray[np.bool_] | None = None, rho: float = 60.0
) -> Floats:
    """Weights for clustering: 1 / l (§2.1.1), over ρ for predicted border edges (§2.3.2).

    Parameters
    ----------
    graph : MapGraph
    is_border : array, shape (e',), optional
        The classifier's prediction. None gives the *uniform* variant of §3.3:
        every edge weighs 1, and lengths play no role either.
    rho : float
        ρ.

    Returns
    -------
    array, shape (e',)
    """
    if is_border is None:
        return np.ones(len(graph))
    weights: Floats = length_weights(graph.length) / np.where(is_border, rho, 1.0)
    return weights


def affinity_of(graph: MapGraph, weights: Floats) -> sparse.csr_array:
    """Adjacency matrix W of the map graph, pieces joined (see the module's text)."""
    affinity = adjacency(graph.node_count, graph.edges, weights)
    pieces, piece = connected_components(affinity, directed=False)
    if pieces == 1:
        return affinity
    first = np.sort(np.unique(piece, return_index=True)[1])[1:]
    links = np.stack([first - 1, first], axis=1)
    usual = float(np.median(weights)) if len(weights) else 1.0
    return affinity + adjacency(graph.node_count, links, np.full(len(links), usual))


def segment(
    graph: MapGraph,
    is_border: NDArray[np.bool_] | None,
    rooms: int,
    rng: np.random.Generator,
    rho: float = 60.0,
) -> NDArray[np.int32]:
    """Room label of each node (§2.4).

    Parameters
    ----------
    graph : MapGraph
        From `roomseg.preprocessing.preprocess`.
    is_border : array, shape (e',), or None
        Predicted border edges; None: the uniform variant.
    rooms : int
        m, the number of rooms.
    rng : numpy.random.Generator
        For the starts of k-means.
    rho : float
        ρ.

    Returns
    -------
    array, shape (n,)
        0 .. m - 1, numbered by the first node of each room.

    Raises
    ------
    FormatError
        If there are more rooms than nodes, or fewer than one.
    """
    if not 1 <= rooms <= graph.node_count:
        raise FormatError(f"rooms: {rooms}, expected 1..{graph.node_count}, the number of nodes")
    affinity = affinity_of(graph, edge_weights(graph, is_border, rho))
    return spectral_clustering(affinity, rooms, rng).astype(np.int32)
