"""Which edges of the map graph cross the border segments that were drawn (§3.1.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["crosses_border"]

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
