"""The planes of triangles, and coordinates in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Planes", "planes_of"]

LEVEL = 0.9999
"""Vertical part of the normal from which on a plane counts as level."""
Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True)
class Planes:
    """The plane of every triangle.

    Attributes
    ----------
    normal : array, shape (t, 3)
    axes : array, shape (t, 2, 3)
        Orthonormal; with the normal they make a right-handed frame. In upright planes
        the second axis is z. Parallel planes that look the same way share their axes.
    distance : array, shape (t,)
        From the scene's origin along the normal, m.
    """

    normal: Floats
    axes: Floats
    distance: Floats

    @property
    def level(self) -> NDArray[np.bool_]:
        """Which planes are level, shape (t,)."""
        found: NDArray[np.bool_] = np.abs(self.normal[:, 2]) > LEVEL
        return found

    @property
    def upright(self) -> NDArray[np.bool_]:
        """Which planes are upright, shape (t,)."""
        found: NDArray[np.bool_] = np.abs(self.normal[:, 2]) < 1e-4
        return found

    def flat(self, corners: Floats) -> Floats:
        """Plane coordinates (t, 3, 2) of corners (t, 3, 3), m."""
        found: Floats = np.einsum("tki,tci->tck", self.axes, corners)
        return found

    def solid(self, points: Floats, which: Ints, lift: float) -> Floats:
        """Points (k, c, 3), ``lift`` m in front of the planes ``which`` (k,).

        Parameters
        ----------
        points : array, shape (k, c, 2)
            Plane coordinates, m.
        """
        away = (self.distance[which] + lift)[:, None] * self.normal[which]
        found: Floats = np.einsum("kca,kai->kci", points, self.axes[which]) + away[:, None]
        return found


def planes_of(corners: Floats) -> Planes:
    """Planes of triangles (t, 3, 3)."""
    normal = _unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    # Rounded, so that triangles of one plane get the very same axes.
    normal = _unit(np.round(normal, 5))
    across = np.column_stack([-normal[:, 1], normal[:, 0], np.zeros(len(normal))])
    across[np.abs(normal[:, 2]) > LEVEL] = (1.0, 0.0, 0.0)
    across = _unit(across)
    axes = np.stack([across, _unit(np.cross(normal, across))], axis=1)
    return Planes(normal, axes, np.einsum("ti,ti->t", normal, corners[:, 0]))


def _unit(vectors: Floats) -> Floats:
    found: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-15)
    return found
