"""Borders of the plan on the robot's own map: each is moved as the nodes around it are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from dataset.topomap import Nodes

__all__ = ["carried_to_map"]

Floats = NDArray[np.float64]

NEIGHBOURS = 16
"""Nodes that tell how the map lies around a border."""


def carried_to_map(nodes: Nodes, borders: Floats) -> Floats:
    """Carry borders, shape (b, 2, 2), from the scene's frame into the map's.

    The map is bent by drift, but around one border it is the plan, turned and shifted.
    """
    assert nodes.true_pose is not None
    true = nodes.true_pose[:, :2]
    near = KDTree(true).query(borders.mean(axis=1), k=min(NEIGHBOURS, len(true)))[1]
    carried = [
        _carried(line, true[index], nodes.position[index])
        for line, index in zip(borders, near.reshape(len(borders), -1), strict=True)
    ]
    return np.array(carried).reshape(-1, 2, 2)


def _carried(line: Floats, source: Floats, target: Floats) -> Floats:
    """Move points as the rigid motion that fits ``source`` to ``target`` best (Kabsch)."""
    middle, goal = source.mean(axis=0), target.mean(axis=0)
    left, _, right = np.linalg.svd((source - middle).T @ (target - goal))
    flip = np.diag([1.0, np.sign(np.linalg.det(left @ right))])
    moved: Floats = (line - middle) @ (left @ flip @ right) + goal
    return moved
