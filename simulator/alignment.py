"""The direction of the walls in sight (§2.1 leaves the first lane's direction open)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.trigonometry import arctangent

__all__ = ["wall_heading"]

Floats = NDArray[np.float64]

_APART = (0.08, 0.6)
"""Distance of the two points of a pair, m."""
_WIDTH = np.radians(3.0)
"""Half the width of the window of directions, rad."""


def wall_heading(points: Floats, heading: float) -> float:
    """The heading nearest to ``heading`` that is parallel or normal to the walls.

    Pairs of points on one wall, or on two walls at right angles, agree in
    direction modulo 90°; the fullest window of directions wins and its circular
    mean is the walls' direction.

    Parameters
    ----------
    points : array, shape (k, 2)
        Obstacle points seen from the base, m.
    heading : float
        rad; returned as it is where fewer than eight pairs agree.

    Returns
    -------
    float
        rad.
    """
    a, b = np.triu_indices(len(points), 1)
    gap = points[b] - points[a]
    length = np.hypot(gap[:, 0], gap[:, 1])
    keep = (length >= _APART[0]) & (length <= _APART[1])
    angle = np.array([arctangent(y, x) for x, y in gap[keep].tolist()]) % (0.5 * np.pi)
    if len(angle) < 8:
        return heading
    centres = np.arange(0.0, 0.5 * np.pi, _WIDTH / 3.0)
    away = (angle[:, None] - centres + 0.25 * np.pi) % (0.5 * np.pi) - 0.25 * np.pi
    near = np.abs(away) <= _WIDTH
    best = int(near.sum(axis=0).argmax())
    if near[:, best].sum() < max(8, 1.5 * len(angle) * 2.0 * _WIDTH / (0.5 * np.pi)):
        return heading
    wall = centres[best] + away[near[:, best], best].mean()
    turn = (wall - heading + 0.25 * np.pi) % (0.5 * np.pi) - 0.25 * np.pi
    return float(heading + turn)
