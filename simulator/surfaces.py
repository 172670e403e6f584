"""What the beams hit and the wheels roll over: surfaces and floor covers of the true plan.

The beams see what there is at their own height, which is not all that the body can
touch: a shower tray on the floor is felt only, and a bar that hangs lower than the body
is high may be below or above the beams. How bright a spot is depends on the surface;
its reflectance is the red part of the material's colour, as the lasers are red. Of
clear glass hardly anything comes back.

Thresholds, rugs, mats and cables up to 1 cm are driven over; while a wheel or the castor stands on
one, the robot, and its camera with it, is tilted.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from scenes.apartment import DRIVEN_OVER, Apartment
from scenes.materials import LAMP_PREFIX, resolve
from scenes.mesh import wall_materials
from scenes.solids import WALL, Prism
from simulator.compiled import compiled
from simulator.trigonometry import arctangent, sine_cosine

__all__ = ["FloorCovers", "Surfaces", "boundary", "floor_covers", "seen_surfaces"]

Floats = NDArray[np.float64]

_GLASS = 0.05
"""Reflectance of clear glass."""
_LAMP = 0.8
"""Reflectance of a lamp's shade."""


@dataclass(frozen=True)
class Surfaces:
    """Upright surfaces in the plan: walls (w, 2, 2) m and their reflectance (w,), 0..1."""

    walls: Floats
    reflectance: Floats


@dataclass(frozen=True)
class FloorCovers:
    """What lies on the floor: footprints and their heights, m."""

    shapes: list[Polygon] = field(default_factory=list)
    heights: list[float] = field(default_factory=list)

    def height(self, points: Floats) -> Floats:
        """Height of the floor at points (n, 2) m, shape (n,), m."""
        height = np.zeros(len(points))
        for shape, top in zip(self.shapes, self.heights, strict=True):
            inside = shapely.intersects_xy(shape, points[:, 0], points[:, 1])
            height[inside] = np.maximum(height[inside], top)
        return height

    def tilt(self, poses: Floats, wheel_base: float, castor: float) -> Floats:
        """Roll and pitch of a robot that stands on two wheels and a castor.

        Parameters
        ----------
        poses : array, shape (n, 3)
            m, m, rad.
        wheel_base, castor : float
            Distance between the wheels, and of the castor ahead of their axle, m.

        Returns
        -------
        array, shape (n, 2)
            About the axis ahead (left side up) and about the axis to the left
            (front down), rad.
        """
        points = _standing(poses, wheel_base, castor)
        return _tilts(self.height(points).reshape(-1, 3), wheel_base, castor)


@compiled
def _standing(poses: Floats, wheel_base: float, castor: float) -> Floats:
    """Where left wheel, right wheel and castor touch the floor, (3 n, 2), m."""
    points = np.empty((3 * len(poses), 2))
    for k in range(len(poses)):
        ahead_y, ahead_x = sine_cosine(poses[k, 2])
        left_x, left_y = -ahead_y * 0.5 * wheel_base, ahead_x * 0.5 * wheel_base
        points[3 * k] = poses[k, 0] + left_x, poses[k, 1] + left_y
        points[3 * k + 1] = poses[k, 0] - left_x, poses[k, 1] - left_y
        points[3 * k + 2] = poses[k, 0] + castor * ahead_x, poses[k, 1] + castor * ahead_y
    return points


@compiled
def _tilts(heights: Floats, wheel_base: float, castor: float) -> Floats:
    """Roll and pitch, (n, 2) rad, from the heights of wheels and castor, (n, 3) m."""
    tilts = np.empty((len(heights), 2))
    for k in range(len(heights)):
        left, right, front = heights[k, 0], heights[k, 1], heights[k, 2]
        tilts[k, 0] = arctangent(left - right, wheel_base)
        tilts[k, 1] = arctangent(0.5 * (left + right) - front, castor)
    return tilts


def boundary(region: shapely.Geometry) -> Floats:
    """Sides of a region's polygons, (w, 2, 2) m, in an order that depends on its shape only."""
    rings = shapely.get_rings(shapely.get_parts(shapely.normalize(region)))
    sides = [
        np.stack([ring[:-1], ring[1:]], axis=1) for ring in map(shapely.get_coordinates, rings)
    ]
    return np.concatenate(sides) if sides else np.zeros((0, 2, 2))


def floor_covers(solids: list[Prism]) -> FloorCovers:
    """Thresholds, rugs, mats and cables, among all solids, that the robot drives over."""
    low = [p for p in solids if p.bottom < DRIVEN_OVER / 2 and p.top > 0.0]
    low = [prism for prism in low if prism.top <= DRIVEN_OVER]
    return FloorCovers([p.footprint for p in low], [p.top for p in low])


def seen_surfaces(apartment: Apartment, solids: list[Prism], height: float) -> Surfaces:
    """What beams at ``height`` m above the floor can hit of the apartment's solids."""
    prisms = [p for p in solids if p.bottom <= height < p.top]
    walls = boundary(shapely.union_all([prism.footprint for prism in prisms]))
    if len(walls) == 0:
        return Surfaces(walls, np.zeros(0))
    middle = walls.mean(axis=1)
    outlines = shapely.boundary([prism.footprint for prism in prisms])
    nearest = shapely.STRtree(outlines).nearest(shapely.points(middle))
    return Surfaces(walls, _reflectance(apartment, [prisms[k] for k in nearest], middle))


def _reflectance(apartment: Apartment, prisms: list[Prism], places: Floats) -> Floats:
    """Of each prism's material at a place (k, 2), m; walls take that of the nearest room."""
    wall = wall_materials(apartment, places).tolist()
    names = [w if p.material == WALL else p.material for p, w in zip(prisms, wall, strict=True)]
    known = {name: _of_material(apartment, name) for name in set(names)}
    return np.array([known[name] for name in names])


def _of_material(apartment: Apartment, name: str) -> float:
    if name.startswith(LAMP_PREFIX):
        return _LAMP
    material = resolve(apartment, name)
    return _GLASS if material.pattern == "glass" else material.colour[0]
