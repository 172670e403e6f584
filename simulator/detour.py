"""A short way around obstacles on the robot's own grid.

The map graph leads over places where the robot has been; where it has left the
graph, or something is in the way, it looks for a way on the local grid. The
cost of a cell grows near obstacles, so that tight gaps are taken in the middle.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from simulator.gridmap import CELL, GridMap

__all__ = ["plan_detour"]

Floats = NDArray[np.float64]

_MARGIN = 1.2
"""The way may lead so far around start and goal, m."""
_COMFORT = 0.25
"""A cell nearer to an obstacle than this, m, costs more, ..."""
_PENALTY = 15.0
"""... by this for each metre that is lacking, beside 1 for the cell."""


def plan_detour(grid: GridMap, start: Floats, goal: Floats, clearance: float) -> Floats:
    """Way points from ``start`` to ``goal``, both (2,), m.

    Only seen cells with at least ``clearance`` m to known obstacles are used,
    within 1.2 m around start and goal; the start itself is always allowed.

    Returns
    -------
    array, shape (k, 2)
        About every 10 cm, ending at ``goal``; k = 0 if there is no way.
    """
    low = grid.cells(np.minimum(start, goal)[None] - _MARGIN)[0]
    high = grid.cells(np.maximum(start, goal)[None] + _MARGIN)[0]
    low = np.maximum(low, 0)
    high = np.minimum(high, np.array(grid.seen.shape) - 1)
    window = np.s_[low[0] : high[0] + 1, low[1] : high[1] + 1]
    room = grid.room(window)
    first, last = grid.cells(np.stack([start, goal])) - low
    allowed = grid.seen[window] & (room >= clearance)
    x, y = np.indices(room.shape)
    allowed |= np.hypot(x - first[0], y - first[1]) * CELL < 0.06
    if not allowed[tuple(last)]:
        return np.zeros((0, 2))
    cost = 1.0 + _PENALTY * np.maximum(_COMFORT - room, 0.0)
    source, target = (int(np.ravel_multi_index(tuple(c), room.shape)) for c in (first, last))
    _, previous = dijkstra(
        _grid_graph(allowed, cost), directed=False, indices=source, return_predecessors=True
    )
    chain = [target]
    while chain[-1] != source:
        chain.append(int(previous[chain[-1]]))
        if chain[-1] < 0:
            return np.zeros((0, 2))
    cells = np.stack(np.unravel_index(chain[::-1], room.shape), axis=1) + low
    points = grid.centres(cells)[4::4]
    return np.vstack([points, goal])


def _grid_graph(allowed: NDArray[np.bool_], cost: Floats) -> csr_array:
    """Eight-connected graph of the allowed cells; entering costs length x cell cost."""
    index = np.arange(allowed.size).reshape(allowed.shape)
    rows, columns, weights = [], [], []
    for here, there, length in (
        (np.s_[:, :-1], np.s_[:, 1:], 1.0),
        (np.s_[:-1, :], np.s_[1:, :], 1.0),
        (np.s_[:-1, :-1], np.s_[1:, 1:], np.sqrt(2.0)),
        (np.s_[1:, :-1], np.s_[:-1, 1:], np.sqrt(2.0)),
    ):
        both = allowed[here] & allowed[there]
        rows.append(index[here][both])
        columns.append(index[there][both])
        weights.append(0.5 * length * (cost[here] + cost[there])[both])
    shape = (allowed.size, allowed.size)
    return csr_array(
        (np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns))), shape=shape
    )
