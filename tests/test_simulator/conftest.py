"""Runs that several test modules look at; each is driven once per session."""

from __future__ import annotations

import pytest

from simulator import simulate

from .plans import box_room, chair, l_shape, two_rooms


@pytest.fixture(scope="session")
def two_rooms_map():
    """A run through two rooms and their doorway."""
    return simulate(two_rooms(), seed=1)


@pytest.fixture(scope="session", params=["box", "legs", "ell", "two", "oblique"])
def plan_and_map(request):
    """Plans of different shapes, start poses and headings, with one run each."""
    plan = {
        "box": lambda: box_room(start=(1.9, 1.4), heading_deg=-90.0),
        "legs": lambda: box_room(furniture=(chair((1.5, 1.0)),)),
        "ell": l_shape,
        "two": lambda: two_rooms(start=(3.4, 1.8), heading_deg=180.0),
        "oblique": lambda: l_shape(start=(0.6, 1.7), heading_deg=37.0),
    }[request.param]()
    return plan, simulate(plan, seed=3)
