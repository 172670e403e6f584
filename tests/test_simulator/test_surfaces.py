"""What the beams can see, and how rugs and thresholds tilt the robot."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from scenes.apartment import Apartment, Block, Piece, Room, Start, Threshold
from scenes.solids import apartment_solids
from simulator.surfaces import FloorCovers, floor_covers, seen_surfaces
from simulator.world import World, spots

from .plans import two_rooms

RING = Block(
    polygon=((-0.2, -0.2), (4.2, -0.2), (4.2, 3.2), (-0.2, 3.2)),
    holes=(((0, 0), (4, 0), (4, 3), (0, 3)),),
)
ROOM = Room(name="room", polygon=((0, 0), (4, 0), (4, 3), (0, 3)), walls="white_plaster")


def room(*blocks, furniture=()):
    return Apartment(
        name="surfaces",
        rooms=(ROOM,),
        blocks=(RING, *blocks),
        furniture=furniture,
        start=Start(position=(0.5, 0.5)),
    )


def square(x, y, half, **fields):
    corners = (
        (x - half, y - half),
        (x + half, y - half),
        (x + half, y + half),
        (x - half, y + half),
    )
    return Block(polygon=corners, **fields)


def test_beams_see_what_is_at_their_height_only():
    low = square(1.0, 1.0, 0.1, top=0.03, material="wood")
    hanging = square(2.0, 1.0, 0.1, bottom=0.07, top=0.5, material="wood")
    tall = square(3.0, 1.0, 0.1, top=0.5, material="plastic_black")
    apartment = room(low, hanging, tall)
    surfaces = seen_surfaces(apartment, apartment_solids(apartment), 0.05)
    lines = shapely.multilinestrings(list(surfaces.walls))
    for x, seen in ((1.0, False), (2.0, False), (3.0, True)):
        assert lines.intersects(shapely.Point(x, 1.0).buffer(0.2)) == seen


def test_reflectance_is_that_of_the_surface():
    apartment = room(square(3.0, 1.0, 0.1, top=0.5, material="plastic_black"))
    surfaces = seen_surfaces(apartment, apartment_solids(apartment), 0.05)
    world = World(shapely.box(9, 9, 10, 10), surfaces)
    hit = spots(world.seen, np.array([2.5, 1.0, 0.0]), np.radians([0.0, 90.0, 180.0]))
    assert hit.range[0] == pytest.approx(0.4)
    assert hit.reflectance[0] < 0.1
    wall = spots(world.seen, np.array([3.5, 2.5, 0.0]), np.zeros(1))
    assert wall.range[0] == pytest.approx(0.5)
    assert wall.reflectance[0] == pytest.approx(0.8, abs=0.05)


def test_rugs_are_driven_over_and_tilt():
    rug = Piece(kind="rug", position=(2.0, 1.5), size=(1.0, 1.0, 0.008))
    covers = floor_covers(apartment_solids(room(furniture=(rug,))))
    assert covers.heights == [0.008]
    # The left wheel on the rug's lower edge, driving along it.
    roll, pitch = covers.tilt(np.array([[2.0, 1.0, 0.0]]), 0.22, 0.10)[0]
    assert roll == pytest.approx(np.arctan(0.008 / 0.22))
    assert pitch == pytest.approx(np.arctan((0.004 - 0.008) / 0.10))
    # Only the castor on it: nose up. Everything on it, or nothing: level.
    roll, pitch = covers.tilt(np.array([[1.45, 1.5, 0.0]]), 0.22, 0.10)[0]
    assert (roll, pitch) == (0.0, pytest.approx(-np.arctan(0.008 / 0.10)))
    assert covers.tilt(np.array([[2.0, 1.5, 1.0]]), 0.22, 0.10).tolist() == [[0.0, 0.0]]
    assert covers.tilt(np.array([[0.5, 0.5, 1.0]]), 0.22, 0.10).tolist() == [[0.0, 0.0]]


def test_a_threshold_tilts_as_one_drives_over_it():
    place = two_rooms(threshold=Threshold(height=0.008, depth=0.04))
    covers = floor_covers(apartment_solids(place))
    assert covers.heights == [0.008]
    # Across the wall's middle at x = 2.06: the castor 0.10 m ahead first, then both wheels.
    step = np.arctan(0.008 / 0.10)
    for x, pitch in ((1.93, 0.0), (1.95, -step), (1.99, 0.0), (2.06, step), (2.09, 0.0)):
        assert covers.tilt(np.array([[x, 1.2, 0.0]]), 0.22, 0.10)[0].tolist() == [
            0.0,
            pytest.approx(pitch),
        ]
    # At a slant of 45° the right wheel and the castor are on it, the left wheel is not.
    x, y = 2.06 - 0.11 * np.sqrt(0.5), 1.2 + 0.11 * np.sqrt(0.5)
    roll, pitch = covers.tilt(np.array([[x, y, np.pi / 4]]), 0.22, 0.10)[0]
    assert roll == pytest.approx(-np.arctan(0.008 / 0.22))
    assert pitch == pytest.approx(np.arctan((0.004 - 0.008) / 0.10))


def test_without_covers_the_floor_is_level():
    assert FloorCovers().tilt(np.zeros((1, 3)), 0.22, 0.10).tolist() == [[0.0, 0.0]]
