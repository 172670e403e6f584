"""How the covered share of the floor grows during a run."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from dataset.topomap import Path
from scenes.apartment import Apartment
from simulator.report import reachable_from, track_line

__all__ = ["coverage_progress"]

Floats = NDArray[np.float64]


def coverage_progress(
    path: Path,
    apartment: Apartment,
    times: Floats,
    *,
    radius: float = 0.15,
    near: float = 0.2,
    spacing: float = 0.05,
) -> Floats:
    """Share of the reachable positions that has been covered, as `coverage_report` counts.

    Parameters
    ----------
    path : Path
        With at least one moment.
    apartment : Apartment
    times : array, shape (m,)
        When to tell, ascending, s.
    radius : float
        Of the robot, m.
    near : float
        A position is covered if the driven path is this near, m.
    spacing : float
        Grid spacing of the positions, m.

    Returns
    -------
    array, shape (m,)
        0..1.

    Raises
    ------
    SceneError
        If the run does not begin where the robot fits.
    """
    track = path.true_pose[:, :2]
    reachable = reachable_from(track, apartment, radius, spacing)
    rows = np.maximum(np.searchsorted(path.time, times, side="right"), 1)
    begins = np.maximum(np.r_[0, rows[:-1]] - 1, 0)
    # A piece of the track for each time, from where the last one ended.
    pieces = [track_line(track[begin:end]) for begin, end in zip(begins, rows, strict=True)]
    tree = shapely.STRtree(shapely.points(reachable))
    piece, point = tree.query(pieces, predicate="dwithin", distance=near)
    first = np.full(len(reachable), len(times))
    np.minimum.at(first, point, piece)
    counts = np.bincount(first, minlength=len(times) + 1)[: len(times)]
    share: Floats = np.cumsum(counts) / len(reachable)
    return share
