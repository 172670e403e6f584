"""Free floor as an apartment: components, obstacles, rooms, borders and lintels."""

import numpy as np
import pytest
import shapely
from shapely import LineString, Point, Polygon, box

from scenes import check, floor_area, floor_region, obstacles, room_borders
from scenes.apartment import SceneFile
from scenes.errors import SceneError
from scenes.importers.free_space import free_space_apartment
from scenes.importers.rooms import SMALLEST

LEFT, DOOR, RIGHT = box(0, 0, 3, 3), box(3, 1, 3.2, 1.9), box(3.2, 0, 6, 3)
FLAT = shapely.union_all([LEFT, DOOR, RIGHT])
ACROSS = [[3.1, 1.0], [3.1, 1.9]]


def imported(free=FLAT, **options):
    result = free_space_apartment(free, name="flat", **options)
    assert list(check(result.apartment)) == []
    return result


def free_floor(apartment):
    return floor_region(apartment).difference(obstacles(apartment))


def test_floor_and_obstacles_are_the_region():
    free = FLAT.difference(Point(1, 1).buffer(0.2)).difference(box(5, 2, 6, 2.5))
    apartment = imported(free).apartment
    assert free_floor(apartment).symmetric_difference(free).area < 2e-3
    assert len(apartment.blocks) == 2
    assert all(block.is_masonry for block in apartment.blocks)
    walls = obstacles(apartment)
    assert walls.contains(Point(-0.19, 1)) and not walls.contains(Point(-0.21, 1))


def test_the_start_is_the_place_with_most_clearance():
    start = imported(LEFT.difference(box(0, 0, 1, 3))).apartment.start.position
    assert start[0] == pytest.approx(2.0, abs=0.02)
    assert min(start[1], 3 - start[1]) >= 0.98


def test_a_start_chooses_its_floor_and_wrong_ones_are_told():
    apart = shapely.union_all([LEFT, RIGHT])
    assert floor_area(imported(apart).apartment) == pytest.approx(9.0)
    assert floor_area(imported(apart, start=(4.0, 1.0)).apartment) == pytest.approx(8.4)
    with pytest.raises(SceneError) as error:
        free_space_apartment(apart, name="flat", start=(3.1, 1.5), origin="a.yaml")
    assert str(error.value) == (
        "a.yaml: start: (3.1, 1.5) has no free floor for a robot of 0.15 m radius; expected a "
        "free place, such as (2.85, 1.5)"
    )


def test_standing_things_are_no_masonry_and_stand_on_the_floor():
    scene = SceneFile(file="flat.blend", sha256="0" * 64)
    free = FLAT.difference(box(1, 1, 2, 2))
    apartment = imported(free, obstacle_top=0.4, scene_file=scene).apartment
    standing = [block for block in apartment.blocks if not block.is_masonry]
    assert [block.top for block in standing] == [0.4]
    assert floor_area(apartment) == pytest.approx(FLAT.area)
    assert free_floor(apartment).area == pytest.approx(free.area)
    assert apartment.scene_file == scene


def test_specks_are_left_out_and_told():
    result = imported(FLAT.difference(box(1, 1, 1.005, 1.005)))
    assert len(result.apartment.blocks) == 1
    assert result.notes == ("1 obstacles of less than 1 cm²: left out",)


def test_simplification_never_shuts_the_robot_out():
    # A passage of 0.32 m with ragged sides: simplified by 5 cm it would be too narrow.
    teeth = [box(3 + 0.04 * i, 1.32, 3.02 + 0.04 * i, 1.36) for i in range(5)]
    free = shapely.union_all([LEFT, RIGHT, box(3, 1, 3.2, 1.32), *teeth])
    apartment = imported(free, tolerance=0.05, borders=[ACROSS]).apartment
    assert floor_area(apartment) == pytest.approx(free.area, rel=0.01)
    assert len(apartment.rooms) == 2


# ---- rooms ----------------------------------------------------------------------------------


def test_a_border_parts_the_floor_and_is_crossed():
    apartment = imported(borders=np.array([ACROSS])).apartment
    areas = sorted(Polygon(room.polygon).area for room in apartment.rooms)
    assert areas == pytest.approx([8.4 + 0.09, 9.0 + 0.09])
    (border,) = room_borders(apartment)
    assert LineString(border).equals(LineString(ACROSS))


def test_several_lines_across_a_doorway_are_one_border():
    lines = [[[x, 1.0], [x, 1.9]] for x in (3.0, 3.1, 3.2)]
    result = imported(borders=lines)
    assert len(result.apartment.rooms) == 2
    assert len(result.apartment.borders) == 1
    assert sum("parts no two rooms; left out" in note for note in result.notes) == 2
    assert DOOR.area < SMALLEST


@pytest.mark.parametrize(("height", "lintels"), [(2.0, 1), (None, 0), (3.0, 0)])
def test_doorways_get_a_lintel_and_wide_passages_none(height, lintels):
    doorway = imported(borders=[ACROSS], lintel_height=height).apartment
    assert sum(block.bottom == height for block in doorway.blocks) == lintels
    if lintels:
        over = next(Polygon(b.polygon) for b in doorway.blocks if b.bottom == height)
        assert over.equals(DOOR)
    wide = imported(borders=[[[1.5, 0], [1.5, 3]]]).apartment
    assert not any(block.bottom for block in wide.blocks)


def test_a_border_through_an_obstacle_keeps_rooms_closed():
    free = FLAT.difference(box(1.4, 1, 1.6, 2))
    for top in (None, 0.5):
        apartment = imported(free, borders=[[[1.5, 0], [1.5, 3]]], obstacle_top=top).apartment
        assert len(apartment.rooms) == 2


def test_rough_rooms_cover_the_floor():
    rooms = [("hall", "corridor", box(-1, -1, 3.05, 4)), ("bath", "bathroom", box(3.15, -1, 7, 4))]
    apartment = imported(rooms=rooms).apartment
    assert {room.name: room.kind for room in apartment.rooms} == {
        "hall": "corridor",
        "bath": "bathroom",
    }
    assert floor_area(apartment) == pytest.approx(FLAT.area)


def test_parts_of_one_room_that_are_apart_get_names_of_their_own():
    rooms = [("a", "office", box(0, 0, 1, 3)), ("b", "office", box(1, 0, 2, 3))]
    rooms.append(("a", "office", box(2, 0, 3, 3)))
    apartment = imported(LEFT, rooms=rooms).apartment
    assert sorted(room.name for room in apartment.rooms) == ["a", "a_2", "b"]


def test_floor_of_no_room_is_a_room_without_a_name():
    apartment = imported(rooms=[("a", "office", box(0, 0, 3, 3))]).apartment
    assert sorted(room.name for room in apartment.rooms) == ["a", "room_1"]


def test_a_room_around_another_is_cut_in_two():
    result = imported(LEFT, rooms=[("in", "office", box(1, 1, 2, 2))])
    assert sorted(room.name for room in result.apartment.rooms) == ["in", "room_1", "room_2"]
    assert result.notes == ("a room runs around another room: cut in two",)
    assert floor_area(result.apartment) == pytest.approx(9.0)


def test_rooms_that_the_robot_cannot_enter_go_to_their_neighbour():
    free = shapely.union_all([LEFT, box(3, 1, 3.2, 1.2), RIGHT])
    rooms = [("a", "office", LEFT), ("closet", "storage", RIGHT)]
    result = imported(free, rooms=rooms)
    assert [room.name for room in result.apartment.rooms] == ["a"]
    assert result.notes[0].startswith("closet of 8.4 m² about (")
    assert result.notes[0].endswith("no way in for the robot; its floor goes to a")


def test_a_room_without_floor_and_an_idle_border_are_told():
    rooms = [("a", "office", LEFT), ("b", "office", RIGHT), ("far", "office", box(9, 9, 11, 10))]
    result = imported(rooms=rooms, borders=[[[0.5, 1.0], [1.5, 1.0]]])
    assert result.notes == (
        "border 1, from (0.5, 1) to (1.5, 1): parts no two rooms: the end at (0.5, 1) is 0.50 m "
        "from a wall and the end at (1.5, 1) is 1.00 m from a wall, expected at most 0.1 m; "
        "left out",
        "room 'far' of 2.0 m²: has no floor of its own; left out",
    )


def test_the_open_end_of_a_border_is_told():
    (note,) = imported(LEFT, borders=[[[1.0, 0.0], [1.0, 2.6]]]).notes
    assert "the end at (1, 2.6) is 0.40 m from a wall, expected at most 0.1 m; left out" in note
    assert "(1, 0) is" not in note


def test_masonry_stays_outside_the_floor_across_a_slanted_niche():
    corners = [(0, 0), (3, 0), (4.5, 0.25), (5, 1.25), (3, 2), (3.5, 3.25), (4.5, 3.5), (3, 5)]
    free = Polygon([*corners, (0, 5)])
    apartment = imported(free).apartment
    assert obstacles(apartment).is_valid
    assert floor_area(apartment) == pytest.approx(free.area, rel=0.01)
