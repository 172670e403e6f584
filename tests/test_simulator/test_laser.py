"""Beams against shapely's intersections; noise, drop-outs and false ranges by counting."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from simulator.laser import SensorSpec, cast_beams, measure


def oracle(origin, angle, walls, reach=100.0):
    """Range by shapely: the nearest point of walls and a long segment."""
    end = origin + reach * np.array([np.cos(angle), np.sin(angle)])
    hit = shapely.intersection(
        shapely.linestrings([origin, end]), shapely.multilinestrings(list(walls))
    )
    return np.inf if hit.is_empty else shapely.distance(shapely.points(origin), hit)


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(1, 30))
def test_ranges_agree_with_shapely(seed, count):
    rng = np.random.default_rng(seed)
    walls = rng.uniform(-3, 3, (count, 2, 2))
    origin, angles = rng.uniform(-1, 1, 2), rng.uniform(-np.pi, np.pi, 8)
    expected = [oracle(origin, angle, walls) for angle in angles]
    np.testing.assert_allclose(cast_beams(origin, angles, walls), expected, atol=1e-7)


def test_a_square_room_by_hand():
    corners = np.array([[-1.0, -2.0], [3.0, -2.0], [3.0, 4.0], [-1.0, 4.0]])
    walls = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    ranges = cast_beams(np.zeros(2), np.radians([0.0, 90.0, 180.0, 270.0, 45.0]), walls)
    np.testing.assert_allclose(ranges, [3.0, 4.0, 1.0, 2.0, 3.0 * np.sqrt(2)])


def test_nothing_to_hit():
    assert np.isinf(cast_beams(np.zeros(2), np.zeros(3), np.zeros((0, 2, 2)))).all()
    behind = np.array([[[-1.0, -1.0], [-1.0, 1.0]]])
    assert np.isinf(cast_beams(np.zeros(2), np.zeros(1), behind)).all()


def test_noise_grows_with_range():
    spec = SensorSpec(dropout=0.0, dropout_far=0.0, false_rate=0.0)
    rng = np.random.default_rng(0)
    near = measure(np.full(20000, 0.2), spec, rng)
    far = measure(np.full(20000, 0.8), spec, rng)
    assert near.std() == pytest.approx(
        spec.range_noise + spec.range_noise_quadratic * 0.04, rel=0.05
    )
    assert far.std() == pytest.approx(
        spec.range_noise + spec.range_noise_quadratic * 0.64, rel=0.05
    )


def test_missing_measurements_and_none_beyond_the_range():
    spec = SensorSpec(dropout=0.2, dropout_far=0.6, false_rate=0.0)
    rng = np.random.default_rng(0)
    middle = measure(np.full(20000, 0.5 * spec.maximum_range), spec, rng)
    assert np.isnan(middle).mean() == pytest.approx(0.3, abs=0.01)
    assert np.isnan(measure(np.full(100, np.inf), spec, rng)).all()
    assert np.isnan(measure(np.full(100, 1.2), spec, rng)).all()


def test_false_measurements_appear_where_nothing_is():
    spec = SensorSpec(false_rate=0.05)
    ranges = measure(np.full(20000, np.inf), spec, np.random.default_rng(0))
    false = np.isfinite(ranges)
    assert false.mean() == pytest.approx(0.05, abs=0.005)
    assert ranges[false].min() >= 0.15 and ranges[false].max() <= spec.maximum_range


@pytest.mark.parametrize(
    "settings",
    [{"beams": 0}, {"period": 0.0}, {"dropout": 1.2}, {"false_rate": -0.1}, {"range_noise": -1.0}],
)
def test_impossible_settings_are_refused(settings):
    with pytest.raises(ValueError, match=next(iter(settings))):
        SensorSpec(**settings)
