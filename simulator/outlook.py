"""What is open and uncovered on the robot's grid, kept from one look to the next.

A look at the whole grid would cost more with every room. Here only the tiles that have
changed since the last look are looked at again, and only the new nodes are taken in.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from simulator import gridcells
from simulator.gridcells import CELL, SUPPORT, TILE, Covered
from simulator.gridmap import GridMap

__all__ = ["Outlook", "Uncovered"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bytes = NDArray[np.int8] | NDArray[np.bool_]

_WORD = 8
"""Bytes that are compared at once; a tile is a whole number of them."""


class Uncovered(NamedTuple):
    """Uncovered cells that the centre may stand in, in the order of the grid.

    ``cells`` (n, 2): their indices; ``component`` (n,): which hang together, numbered by
    their first cell; ``node`` (n,): the nearest node, -1 where none is near.
    """

    cells: Ints
    component: Ints
    node: Ints


class Outlook:
    """Looks at a growing grid, from the growing map.

    Parameters
    ----------
    clearance : float
        That the centre needs to known obstacles, m.
    radius : float
        A node covers so much around it, m.
    near : float
        Nodes are near that are closer than this, m.
    """

    def __init__(self, clearance: float, radius: float, near: float) -> None:
        self._clearance, self._radius, self._near = clearance, radius, near
        self._nodes: Floats = np.zeros((0, 2))
        self._corner: Floats = np.zeros(2)
        self._begin((0, 0))

    def look(self, grid: GridMap, nodes: Floats, tried: Covered) -> Uncovered:
        """What the nodes (n, 2), m, do not cover, but for places that were tried."""
        nodes = np.ascontiguousarray(nodes)
        known = len(self._nodes)
        grown = grid.seen.shape != self._open.shape or (grid.corner != self._corner).any()
        if grown or not np.array_equal(nodes[:known], self._nodes):
            # Cells lie elsewhere in the last bit, or nodes have been forgotten.
            self._begin(grid.seen.shape)
            self._corner, known = grid.corner, 0
        self._take_in_cells(grid)
        gridcells.keep_nearest(self._nearest, grid.table, nodes, known, self._near)
        grid.erase(self._left, Covered(nodes[known:], self._radius))
        self._nodes = nodes
        mask = self._open & self._left
        grid.erase(mask, tried)
        flat = _nonzero(mask)
        columns = mask.shape[1]
        cells = np.stack(np.divmod(flat, columns), axis=1)
        node = self._nearest.ravel()[flat].astype(np.int64)
        return Uncovered(cells, gridcells.components(flat, columns), node)

    def _begin(self, shape: tuple[int, ...]) -> None:
        """Forget all, for a grid of this shape."""
        self._open = np.zeros(shape, np.uint8)
        self._left = np.ones(shape, np.uint8)
        self._nearest = np.full(shape, -1, np.int32)
        self._evidence = np.zeros(shape, np.int8)
        self._seen = np.zeros(shape, np.bool_)

    def _take_in_cells(self, grid: GridMap) -> None:
        """Find anew where the centre may stand, where the grid has changed."""
        changed = _changed_tiles(grid.evidence, self._evidence)
        changed |= _changed_tiles(grid.seen, self._seen)
        # A cell says something about those around it.
        around = math.ceil((math.ceil(self._clearance / CELL) + SUPPORT) / TILE)
        square = np.ones((2 * around + 1, 2 * around + 1), np.uint8)
        tiles = np.argwhere(cv2.dilate(changed.view(np.uint8), square))
        gridcells.open_again(self._open, grid.table, np.ascontiguousarray(tiles), self._clearance)
        np.copyto(self._evidence, grid.evidence)
        np.copyto(self._seen, grid.seen)


def _changed_tiles(now: Bytes, before: Bytes) -> NDArray[np.bool_]:
    """Which tiles of two grids differ."""
    words = now.view(np.uint64) != before.view(np.uint64)
    rows = words.view(np.uint32) != 0
    return np.asarray(rows.reshape(-1, TILE, rows.shape[1]).any(axis=1))


def _nonzero(mask: NDArray[np.uint8]) -> Ints:
    """Flat indices where a mask is not 0, ascending."""
    words = np.flatnonzero(mask.view(np.uint64))
    flat = (_WORD * words[:, None] + np.arange(_WORD)).ravel()
    return np.asarray(flat[mask.ravel()[flat] > 0])
