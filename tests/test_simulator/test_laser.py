"""Beams against shapely's intersections; noise, drop-outs and false ranges by counting."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from simulator.laser import SensorSpec, Spots, cast_beams, measure


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
    white = np.ones(len(walls))
    np.testing.assert_allclose(cast_beams(origin, angles, walls, white)[0], expected, atol=1e-7)


def test_a_square_room_by_hand():
    corners = np.array([[-1.0, -2.0], [3.0, -2.0], [3.0, 4.0], [-1.0, 4.0]])
    walls = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    shade = np.array([0.1, 0.2, 0.3, 0.4])
    angles = np.radians([0.0, 90.0, 180.0, 270.0, 45.0])
    ranges, cosine, reflectance = cast_beams(np.zeros(2), angles, walls, shade)
    np.testing.assert_allclose(ranges, [3.0, 4.0, 1.0, 2.0, 3.0 * np.sqrt(2)])
    np.testing.assert_allclose(cosine, [1.0, 1.0, 1.0, 1.0, np.sqrt(0.5)])
    np.testing.assert_allclose(reflectance, [0.2, 0.3, 0.4, 0.1, 0.2])


def test_nothing_to_hit():
    nothing = np.zeros((0, 2, 2)), np.zeros(0)
    assert np.isinf(cast_beams(np.zeros(2), np.zeros(3), *nothing)[0]).all()
    behind = np.array([[[-1.0, -1.0], [-1.0, 1.0]]])
    assert np.isinf(cast_beams(np.zeros(2), np.zeros(1), behind, np.ones(1))[0]).all()


def spots(distance, count=20000, *, cosine=1.0, reflectance=1.0):
    """The same spot many times."""
    return Spots(*(np.full(count, float(value)) for value in (distance, cosine, reflectance)))


BRIGHT = SensorSpec(dropout=0.0, least_reflectance=1e-9, false_rate=0.0)


@pytest.mark.parametrize(("distance", "degrees"), [(0.2, 0.0), (0.8, 0.0), (0.2, 60.0)])
def test_noise_grows_with_range_and_slant(distance, degrees):
    slant = np.radians(degrees)
    measured = measure(
        spots(distance, cosine=np.cos(slant)), BRIGHT.look(), np.random.default_rng(0)
    )
    expected = BRIGHT.range_noise + BRIGHT.range_noise_quadratic * distance**2
    expected += BRIGHT.range_noise_slant * np.tan(slant)
    assert np.nanstd(measured) == pytest.approx(expected, rel=0.05)


def test_dark_slanted_and_far_surfaces_are_missed():
    spec = SensorSpec(dropout=0.2, least_reflectance=0.4, false_rate=0.0)
    rng = np.random.default_rng(0)

    def missed(*args, **kwargs):
        return np.isnan(measure(spots(*args, **kwargs), spec.look(), rng)).mean()

    # Found: 0.8 of what the brightness leaves, 1 - 0.4 r² / (cosine · reflectance).
    assert missed(0.5, reflectance=0.8) == pytest.approx(1 - 0.8 * 0.875, abs=0.01)
    assert missed(0.5, reflectance=0.2) == pytest.approx(1 - 0.8 * 0.5, abs=0.01)
    assert missed(0.5, reflectance=0.2, cosine=0.5) == 1.0
    assert missed(np.inf) == 1.0
    assert missed(1.2) == 1.0


def test_false_measurements_appear_where_nothing_is():
    spec = SensorSpec(false_rate=0.05)
    ranges = measure(spots(np.inf), spec.look(), np.random.default_rng(0))
    false = np.isfinite(ranges)
    assert false.mean() == pytest.approx(0.05, abs=0.005)
    assert ranges[false].min() >= 0.15 and ranges[false].max() <= spec.maximum_range


def test_beams_of_another_arrangement():
    spec = SensorSpec(beams=3, bearings_deg=(0.0, 30.0, -30.0))
    np.testing.assert_allclose(spec.bearings(), np.radians([0.0, 30.0, -30.0]))
    with pytest.raises(ValueError, match="bearings_deg: 3 bearings, expected beams = 8"):
        SensorSpec(bearings_deg=(0.0, 1.0, 2.0))


@pytest.mark.parametrize(
    "settings",
    [{"beams": 0}, {"period": 0.0}, {"dropout": 1.2}, {"false_rate": -0.1}, {"range_noise": -1.0}],
)
def test_impossible_settings_are_refused(settings):
    with pytest.raises(ValueError, match=next(iter(settings))):
        SensorSpec(**settings)
