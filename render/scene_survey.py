"""What of a scene's surfaces the robot's camera sees, by rays from where it may be.

A texel that is never seen is wasted: the inside of a cupboard, the back of a wall, a
landscape to the horizon. Rays from the free floor count how often each side of each
piece is met; rays that bounce on count for less.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from render.scene_surfaces import Surfaces
from scenes.apartment import Apartment
from scenes.solids import obstacles, rooms_region

__all__ = ["survey"]

PLACES, RAYS = 1000, 200
"""Where the camera looks from, and how many rays each sends out."""
ROUNDS = 100
"""How often as many are tried; fewer places are enough where little of the floor is free."""
HEIGHT = 0.1
"""Of the camera, m."""
LOWEST = -0.2
"""Rays go up, or down by no more than this sine."""
BOUNCES = 2
ECHO = 0.25
"""What a ray counts after a bounce, of what it counted before."""
OFF = 1e-4
"""How far in front of a surface a ray starts, m."""
FAR = 1000.0
Floats = NDArray[np.float64]


def survey(surfaces: Surfaces, apartment: Apartment) -> Floats:
    """How often rays met the front and the back of every piece, shape (pieces, 2)."""
    generator = np.random.default_rng(0)
    met = np.zeros((len(surfaces.facing), 2))
    piece = surfaces.piece[surfaces.triangles[:, 0]]
    places = _places(apartment, generator)
    starts = np.column_stack([places, np.full(len(places), HEIGHT)]).repeat(RAYS, axis=0)
    ways = _directions(len(starts), generator)
    for bounce in range(BOUNCES + 1):
        found = [
            surfaces.tree.ray_cast(start, way, FAR)
            for start, way in zip(starts.tolist(), ways.tolist(), strict=True)
        ]
        hit = np.array([item[2] is not None for item in found], dtype=bool)
        index = np.array([item[2] for item in found if item[2] is not None], dtype=int)
        normal = np.array([item[1] for item in found if item[2] is not None]).reshape(-1, 3)
        point = np.array([item[0] for item in found if item[2] is not None]).reshape(-1, 3)
        behind = np.einsum("ki,ki->k", normal, ways[hit]) > 0.0
        np.add.at(met, (piece[index], behind.astype(int)), ECHO**bounce)
        normal[behind] *= -1.0
        starts = point + OFF * normal
        ways = _scattered(normal, generator)
    return met


def _places(apartment: Apartment, generator: np.random.Generator) -> Floats:
    """Places (n, 2) on the free floor, m."""
    free = rooms_region(apartment).difference(obstacles(apartment))
    shapely.prepare(free)
    low, high = np.array(free.bounds).reshape(2, 2)
    found = np.zeros((0, 2))
    for _ in range(ROUNDS):
        if len(found) == PLACES:
            break
        tried = generator.uniform(low, high, (PLACES, 2))
        found = np.concatenate([found, tried[shapely.contains_xy(free, tried)]])[:PLACES]
    return found


def _directions(count: int, generator: np.random.Generator) -> Floats:
    """Unit vectors (n, 3) that the camera looks along."""
    z = generator.uniform(LOWEST, 1.0, count)
    turn = generator.uniform(0.0, 2.0 * np.pi, count)
    level = np.sqrt(1.0 - z**2)
    return np.column_stack([level * np.cos(turn), level * np.sin(turn), z])


def _scattered(normal: Floats, generator: np.random.Generator) -> Floats:
    """Directions (n, 3) as a matte surface with that normal scatters light."""
    ball = generator.normal(size=normal.shape)
    ball /= np.maximum(np.linalg.norm(ball, axis=1, keepdims=True), 1e-12)
    made = normal + ball
    found: Floats = made / np.maximum(np.linalg.norm(made, axis=1, keepdims=True), 1e-12)
    return found
