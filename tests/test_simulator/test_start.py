"""Where a run begins."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from scenes.passages import free_region
from simulator import RobotSpec, random_start
from simulator.start import base_pose

from .plans import box_room


def test_the_prototype_begins_at_the_base() -> None:
    assert base_pose(box_room(start=(0.16, 1.0), heading_deg=90.0), RobotSpec()) == (
        0.16,
        1.0,
        math.pi / 2,
    )


def test_a_larger_robot_begins_beside_the_base() -> None:
    place = box_room(start=(0.16, 1.0), heading_deg=90.0)
    x, y, heading = base_pose(place, RobotSpec(radius=0.2))
    assert (y, heading) == (1.0, math.pi / 2)
    assert x == pytest.approx(0.201, abs=1e-4)


def test_a_robot_that_fits_nowhere_near_stays_where_it_is() -> None:
    place = box_room(height=0.5, start=(0.16, 0.2))
    assert base_pose(place, RobotSpec(radius=0.28))[:2] == (0.16, 0.2)


def test_random_starts_of_a_larger_robot_fit() -> None:
    place = box_room(start=(0.16, 1.0), heading_deg=90.0)
    x, y, _ = random_start(place, RobotSpec(radius=0.2), np.random.default_rng(0))
    assert free_region(place, 0.2 - 1e-6).covers(shapely.Point(x, y))
