"""Which rooms hold a point."""

import numpy as np
import pytest
import shapely

from scenes import Apartment
from scenes.rooms import room_of_each, room_shapes, rooms_at

from .places import AREA_A, AREA_B, two_rooms_data


def test_shapes_are_the_polygons_of_the_rooms():
    place = Apartment.model_validate(two_rooms_data())
    assert shapely.area(room_shapes(place)).tolist() == pytest.approx([AREA_A, AREA_B])
    for shape, room in zip(room_shapes(place), place.rooms, strict=True):
        assert shape.equals(shapely.Polygon(room.polygon))


@pytest.mark.parametrize(("spot", "rooms"), [((1, 1), [0]), ((5, 1), [1]), ((4.05, 1), [])])
def test_rooms_at_a_point(spot, rooms):
    assert rooms_at(Apartment.model_validate(two_rooms_data()), shapely.Point(spot)) == rooms


def test_the_room_of_each_of_many_points():
    place = Apartment.model_validate(two_rooms_data())
    spots = np.array([[5.0, 1.0], [4.05, 1.0], [1.0, 1.0], [-3.0, 1.0]])
    assert room_of_each(place, spots).tolist() == [1, -1, 0, -1]
