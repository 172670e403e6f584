"""Beams through plans of random polygons, against shapely."""

from __future__ import annotations

import numpy as np
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from simulator.surfaces import Surfaces, boundary
from simulator.world import World, spots

ROOM = shapely.box(-2.1, -2.1, 2.1, 2.1).difference(shapely.box(-2.0, -2.0, 2.0, 2.0))
BEARINGS = np.arange(12) * (np.pi / 6.0) + 0.1


def polygons(rng: np.random.Generator, count: int) -> shapely.Geometry:
    """Overlapping polygons and rings at any angle in a room, around a place left free."""
    shapes: list[shapely.Geometry] = [ROOM]
    for _ in range(count):
        centre = rng.uniform(-1.5, 1.5, 2)
        corners = centre + rng.normal(0.0, 0.25, (rng.integers(3, 7), 2))
        shape = shapely.convex_hull(shapely.multipoints(corners))
        hollow = shape.buffer(0.1).difference(shape) if rng.random() < 0.3 else shape
        shapes.append(hollow)
    return shapely.union_all(shapes).difference(shapely.Point(0.0, 0.0).buffer(0.12, quad_segs=3))


def beam(pose: np.ndarray, bearing: float, length: float) -> shapely.LineString:
    angle = pose[2] + bearing
    end = pose[:2] + length * np.array([np.cos(angle), np.sin(angle)])
    return shapely.LineString([pose[:2], end])


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(1, 12), st.floats(0.3, 2.5))
def test_beams_end_where_shapely_says(seed, count, reach):
    """Range up to the longest, no hit before it, and which wall is hit at what slant."""
    rng = np.random.default_rng(seed)
    solid = polygons(rng, count)
    walls = boundary(solid)
    shades = rng.uniform(0.1, 1.0, len(walls))
    world = World(solid, Surfaces(walls, shades), maximum_range=reach)
    pose = np.array([*rng.uniform(-0.05, 0.05, 2), rng.uniform(-np.pi, np.pi)])
    found = spots(world.seen, pose, BEARINGS)
    outline = shapely.boundary(solid)
    for k, bearing in enumerate(BEARINGS):
        met = shapely.intersection(outline, beam(pose, bearing, reach))
        expected = np.inf if met.is_empty else shapely.distance(shapely.Point(pose[:2]), met)
        if abs(min(expected, 10.0) - reach) < 1e-7 or grazes(walls, pose, bearing, expected):
            continue
        if np.isinf(expected):
            assert found.range[k] > reach
        else:
            assert np.isclose(found.range[k], expected, atol=1e-7)
            along, shade = hit_wall(walls, shades, pose, bearing, expected)
            ahead = np.array([np.cos(pose[2] + bearing), np.sin(pose[2] + bearing)])
            assert np.isclose(found.cosine[k], np.sqrt(1.0 - (along @ ahead) ** 2), atol=1e-6)
            assert found.reflectance[k] == shade


def grazes(walls: np.ndarray, pose: np.ndarray, bearing: float, expected: float) -> bool:
    """Whether a beam passes a corner so near that rounding decides what it hits."""
    line = beam(pose, bearing, min(expected, 10.0) + 1e-6)
    return bool((shapely.distance(shapely.points(walls.reshape(-1, 2)), line) < 1e-7).any())


def hit_wall(
    walls: np.ndarray, shades: np.ndarray, pose: np.ndarray, bearing: float, length: float
) -> tuple[np.ndarray, float]:
    """Direction and shade of the wall that the spot lies on."""
    spot = shapely.Point(beam(pose, bearing, length).coords[1])
    k = int(shapely.distance(shapely.linestrings(walls), spot).argmin())
    along = walls[k, 1] - walls[k, 0]
    return along / np.hypot(*along), float(shades[k])
