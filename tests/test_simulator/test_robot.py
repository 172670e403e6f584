"""Kinematics against closed forms, odometry noise, and the settings' checks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulator.robot import RobotSpec, arc, roll, wheel_slip, wrap

BASE = 0.22
lengths = st.floats(-0.5, 0.5)
angles = st.floats(-3.0, 3.0)


def test_equal_wheels_drive_straight():
    np.testing.assert_allclose(
        arc(np.array([1.0, 2.0, np.pi / 3]), 0.4, 0.4, BASE),
        [1.0 + 0.2, 2.0 + 0.4 * np.sin(np.pi / 3), np.pi / 3],
        atol=1e-12,
    )


def test_opposite_wheels_turn_on_the_spot():
    quarter = BASE * np.pi / 4
    np.testing.assert_allclose(
        arc(np.array([1.0, 2.0, 0.0]), -quarter, quarter, BASE), [1.0, 2.0, np.pi / 2], atol=1e-12
    )


def test_one_wheel_still_draws_a_circle_around_it():
    """The left wheel at (0, b/2) stays; after a quarter turn the centre is beside it."""
    travel = BASE * np.pi / 2
    np.testing.assert_allclose(
        arc(np.zeros(3), 0.0, travel, BASE), [BASE / 2, BASE / 2, np.pi / 2], atol=1e-12
    )


@given(angles, lengths, lengths)
def test_the_arc_is_the_limit_of_many_small_steps(heading, left, right):
    pose = np.array([0.3, -0.2, heading])
    target = arc(pose, left, right, BASE)
    for _ in range(64):
        pose = arc(pose, left / 64, right / 64, BASE)
    np.testing.assert_allclose(pose[:2], target[:2], atol=1e-9)
    assert abs(wrap(pose[2] - target[2])) < 1e-9


@given(angles, lengths, lengths)
def test_rolling_back_returns(heading, left, right):
    pose = np.array([0.3, -0.2, heading])
    back = arc(arc(pose, left, right, BASE), -left, -right, BASE)
    np.testing.assert_allclose(back, pose, atol=1e-9)


@given(st.floats(-50, 50))
def test_wrap_keeps_the_direction(angle):
    wrapped = wrap(angle)
    assert -np.pi <= wrapped < np.pi
    assert np.exp(1j * wrapped) == pytest.approx(np.exp(1j * angle), abs=1e-9)


def test_slip_has_the_stated_spread_and_is_zero_without_noise():
    spec = RobotSpec(slip_bias=0.0, slip_noise=0.01)
    rng = np.random.default_rng(0)
    slip = wheel_slip(spec, rng)
    rolled = np.array([roll(slip, 0.02, 0.02, rng) for _ in range(20000)]) / 0.02 - 1.0
    assert np.abs(rolled.std(axis=0) - 0.01).max() < 0.002
    exact = wheel_slip(RobotSpec(slip_bias=0.0, slip_noise=0.0), rng)
    assert roll(exact, 0.02, -0.01, rng) == (0.02, -0.01)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"radius": 0.0}, "radius: 0"),
        ({"speed": -0.1}, "speed: -0.1"),
        ({"speed": np.nan}, "speed: nan"),
        ({"speed": 0.5}, r"speed \* time_step"),
    ],
)
def test_impossible_settings_are_refused(settings, message):
    with pytest.raises(ValueError, match=message):
        RobotSpec(**settings)


@pytest.mark.parametrize(
    "settings",
    [
        {"slip_memory": 0.0},
        {"correction_gain": 1.5},
        {"lane_spacing": 0.2},
        {"cover_radius": 0.25},
        {"speed": 1.0},
    ],
)
def test_impossible_robots_are_refused(settings):
    with pytest.raises(ValueError, match=next(iter(settings))):
        RobotSpec(**settings)
