"""Which edges of the map graph cross the border segments that were drawn (§3.1.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["borders_between", "crosses_border"]

Floats = NDArray[np.float64]


def crosses_border(
    positions: Floats, edges: NDArray[np.int32], borders: Floats
) -> NDArray[np.bool_]:
    """Edges that cross any border segment (§3.1.1).

    Parameters
    ----------
    positions : array, shape (n, 2)
        Node positions in the borders' frame, m.
    edges : array, shape (e, 2)
    borders : array, shape (b, 2, 2)
        m.

    Returns
    -------
    array of bool, shape (e,)
    """
    # Imported only now: `import dataset` needs NumPy, h5py and nothing heavier.
    import shapely

    crossed = np.zeros(len(edges), np.bool_)
    if len(edges) and len(borders):
        tree = shapely.STRtree(shapely.linestrings(borders))
        lines = shapely.linestrings(positions[edges])
        crossed[tree.query(lines, predicate="intersects")[0]] = True
    return crossed


def borders_between(positions: Floats, edges: NDArray[np.int32], room: NDArray[np.int32]) -> Floats:
    """Border segments that part rooms of which only the nodes are known.

    Every place belongs to its nearest node; where the places of two rooms meet, and an
    edge leads across, is a border. So every edge between rooms crosses one; an edge
    within a room may, where it cuts a corner of another.

    Parameters
    ----------
    positions : array, shape (n, 2)
        m.
    edges : array, shape (e, 2)
    room : array, shape (n,)

    Returns
    -------
    array, shape (b, 2, 2)
        m.
    """
    import shapely
    from scipy.spatial import Voronoi

    places, first = np.unique(positions, axis=0, return_index=True)
    own = room[first]
    if len(np.unique(own)) < 2 or not len(edges):
        return np.empty((0, 2, 2))
    low, high = places.min(axis=0), places.max(axis=0)
    # Corners far outside: no cell of a node is open.
    far = (low + high) / 2 + 10 * (1 + (high - low).max()) * np.array(
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
    )
    diagram = Voronoi(np.vstack([places, far]))
    pair, ends = np.asarray(diagram.ridge_points), np.asarray(diagram.ridge_vertices)
    parting = (pair < len(places)).all(axis=1) & (ends >= 0).all(axis=1)
    parting[parting] = own[pair[parting, 0]] != own[pair[parting, 1]]
    longest = np.linalg.norm(positions[edges[:, 0]] - positions[edges[:, 1]], axis=1).max()
    lines = _near(diagram.vertices[ends[parting]], places[pair[parting]], longest / 2)
    tree = shapely.STRtree(shapely.linestrings(positions[edges]))
    crossed = np.unique(tree.query(shapely.linestrings(lines), predicate="intersects")[0])
    return np.asarray(lines[crossed])


def _near(lines: Floats, nodes: Floats, reach: float) -> Floats:
    """The parts of lines (b, 2, 2) between two nodes (b, 2, 2) each within reach of these, m.

    An edge is nowhere farther than half its length from a node.
    """
    middle, across = nodes.mean(axis=1), nodes[:, 1] - nodes[:, 0]
    length = np.linalg.norm(across, axis=1, keepdims=True)
    along = np.stack([-across[:, 1], across[:, 0]], axis=1) / length
    half = np.sqrt(np.maximum(1.01 * reach**2 - length**2 / 4, 0.0))
    at = np.einsum("bij,bj->bi", lines - middle[:, None], along)
    return np.asarray(middle[:, None] + np.clip(at, -half, half)[..., None] * along[:, None])
