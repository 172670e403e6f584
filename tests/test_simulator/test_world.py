"""The true plan against shapely."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from simulator.world import World, nearest, spots

ROOM = shapely.box(-0.1, -0.1, 4.1, 3.1).difference(shapely.box(0, 0, 4, 3))
LEGS = shapely.union_all([shapely.Point(x, 1.5).buffer(0.02) for x in (1.0, 1.4, 2.2)])
SOLID = shapely.union(ROOM, LEGS)


def test_distance_and_direction_agree_with_shapely():
    world = World(SOLID)
    for point in np.random.default_rng(0).uniform([0.05, 0.05], [3.95, 2.95], (300, 2)):
        place = shapely.Point(point)
        expected = shapely.distance(SOLID, place)
        if expected == 0.0:
            continue
        distance, angle = nearest(world.touched, *point)
        assert distance == pytest.approx(min(expected, 0.5), abs=1e-9)
        if expected < 0.49:
            touched = shapely.Point(point + distance * np.array([np.cos(angle), np.sin(angle)]))
            assert shapely.distance(SOLID, touched) < 1e-9


def test_ranges_see_through_nothing():
    world = World(SOLID)
    bearings = np.linspace(-np.pi, np.pi, 16, endpoint=False)
    for x, y in np.random.default_rng(1).uniform([0.2, 0.2], [3.8, 1.3], (40, 2)):
        ranges = spots(world.seen, np.array([x, y, 0.3]), bearings).range
        for bearing, length in zip(bearings, np.minimum(ranges, 1.0), strict=True):
            end = (x + length * np.cos(0.3 + bearing), y + length * np.sin(0.3 + bearing))
            beam = shapely.linestrings([(x, y), end])
            assert shapely.intersection(beam, SOLID).length < 1e-6


def test_free_places():
    world = World(SOLID)
    assert world.is_free(np.array([0.5, 0.5]), 0.15)
    assert not world.is_free(np.array([0.1, 0.5]), 0.15)
    assert not world.is_free(np.array([-0.05, 0.5]), 0.15)


def test_a_plan_without_obstacles_is_refused():
    with pytest.raises(ValueError, match="empty"):
        World(shapely.MultiPolygon())
