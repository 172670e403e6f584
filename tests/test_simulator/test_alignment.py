"""The walls' direction from obstacle points."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from simulator.alignment import wall_heading


@settings(deadline=None, max_examples=40)
@given(st.floats(-np.pi, np.pi), st.floats(-np.pi, np.pi), st.integers(0, 1000))
def test_a_corner_gives_its_direction(wall, heading, seed):
    """The answer is along a wall and at most 45° from where the robot faces."""
    rng = np.random.default_rng(seed)
    along = np.concatenate(
        [
            np.column_stack([np.linspace(0, 0.8, 12), np.zeros(12)]),
            np.column_stack([np.zeros(12), np.linspace(0, 0.8, 12)]),
        ]
    )
    turn = np.array([[np.cos(wall), -np.sin(wall)], [np.sin(wall), np.cos(wall)]])
    points = along @ turn.T + rng.normal(0.0, 0.004, (24, 2))
    found = wall_heading(points, heading)
    off = (found - wall + np.pi / 4) % (np.pi / 2) - np.pi / 4
    assert abs(off) < np.radians(2.0)
    assert abs(found - heading) <= np.pi / 4 + 1e-9


def test_too_few_points_leave_the_heading():
    assert wall_heading(np.zeros((0, 2)), 0.7) == 0.7
    assert wall_heading(np.array([[0.0, 0.0], [0.3, 0.1]]), 0.7) == 0.7
