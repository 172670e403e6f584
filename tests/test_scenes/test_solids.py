"""Solids against areas, heights and volumes worked out by hand."""

from __future__ import annotations

import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes import Prism, apartment_mesh, apartment_solids, floor_region, obstacles
from scenes.pieces import KINDS
from scenes.solids import WALL, passage_rooms, wall_region
from test_scenes.places import AREA_A, AREA_B, OUTER, framed, two_rooms

PASSAGE = 0.1 * 0.8


def piece(kind: str, **fields: object) -> list[dict[str, object]]:
    return [{"kind": kind, "position": [2, 1.5], **fields}]


def inner(apartment):
    """Obstacles away from the walls."""
    return obstacles(apartment).intersection(shapely.box(0.3, 0.3, 3.7, 2.7))


def prisms_at(apartment, x, y):
    point = shapely.Point(x, y)
    found = [p for p in apartment_solids(apartment) if p.footprint.contains(point)]
    return sorted(found, key=lambda prism: prism.bottom)


def test_floor_region_is_rooms_and_passage():
    assert floor_region(two_rooms()).area == pytest.approx(AREA_A + AREA_B + PASSAGE, abs=1e-5)


def test_closed_passage_is_no_floor_and_is_filled():
    place = two_rooms(passages=framed(closed=True))
    assert floor_region(place).area == pytest.approx(AREA_A + AREA_B, abs=1e-5)
    assert obstacles(place).contains(shapely.Point(4.05, 1.5))


def test_walls_fill_everything_between_rooms_and_outer_face():
    walls = wall_region(two_rooms())
    assert walls.area == pytest.approx(OUTER - AREA_A - AREA_B, abs=1e-5)
    assert walls.contains(shapely.MultiPoint([(-0.15, -0.15), (7.25, 3.15), (4.05, 0.01)]))


def test_obstacles_of_an_empty_place_are_its_cut_walls():
    expected = OUTER - AREA_A - AREA_B - PASSAGE
    assert obstacles(two_rooms()).area == pytest.approx(expected, abs=1e-5)


def test_gap_between_room_and_wall_becomes_wall():
    rooms = two_rooms().model_dump(mode="json")["rooms"]
    rooms[0]["polygon"] = [[0.025, 0], [4, 0], [4, 3], [0.025, 3]]
    blocked = obstacles(two_rooms(rooms=rooms))
    assert blocked.contains(shapely.Point(0.012, 1.0))


@pytest.mark.parametrize("angle", [0, 30, 90, -45])
def test_obstacles_of_a_table_are_its_four_legs(angle):
    legs = inner(two_rooms(furniture=piece("table", rotation_deg=angle)))
    assert [leg.area for leg in shapely.get_parts(legs)] == pytest.approx([0.05**2] * 4)
    assert legs.centroid.coords[0] == pytest.approx((2, 1.5))


def test_bed_is_open_underneath_but_for_its_legs():
    legs = inner(two_rooms(furniture=piece("bed", rotation_deg=90)))
    assert [leg.area for leg in shapely.get_parts(legs)] == pytest.approx([0.06**2] * 4)


@pytest.mark.parametrize("kind", ["rug", "picture", "wall_cupboard", "curtain"])
def test_what_lies_flat_or_hangs_is_no_obstacle(kind):
    elevation = 1.2 if kind in ("picture", "wall_cupboard") else 0.0
    size = (0.7, 0.1, 1.0) if kind == "curtain" else None
    blocked = inner(two_rooms(furniture=piece(kind, elevation=elevation, size=size)))
    # A curtain ends 3 cm above the floor and is met by the robot.
    assert blocked.is_empty == (kind != "curtain")


def test_robot_height_decides_what_is_an_obstacle():
    place = two_rooms(furniture=piece("sofa"))
    assert obstacles(place, high=0.13).area > obstacles(place, high=0.11).area + 1.0


@pytest.mark.parametrize("rotation, side", [(0, (0, 1)), (90, (-1, 0)), (180, (0, -1))])
def test_back_is_towards_plus_y_and_turns_counter_clockwise(rotation, side):
    place = two_rooms(furniture=piece("sofa", rotation_deg=rotation))
    high = [p.footprint for p in apartment_solids(place) if p.top == 0.82]
    (x, y) = shapely.union_all(high).centroid.coords[0]
    assert (x - 2, y - 1.5) == pytest.approx((0.34 * side[0], 0.34 * side[1]))


def test_lintel_begins_at_its_height():
    floor, lintel = prisms_at(two_rooms(), 4.05, 1.5)
    assert (floor.top, lintel.bottom, lintel.material) == (0.0, 2.0, WALL)
    assert lintel.top == pytest.approx(2.7)
    assert lintel.footprint.area == pytest.approx(PASSAGE, abs=1e-5)


def test_passage_without_lintel_is_open_to_the_lower_ceiling():
    rooms = two_rooms().model_dump(mode="json")["rooms"]
    rooms[1]["ceiling_height"] = 2.3
    place = two_rooms(rooms=rooms, passages=[{"position": [4.05, 1.5], "lintel_height": None}])
    floor, skin, rest = prisms_at(place, 4.05, 1.5)
    assert (floor.top, skin.bottom, skin.material) == (0.0, 2.3, "white_paint")
    assert skin.top == pytest.approx(2.31)
    assert (rest.bottom, rest.top) == pytest.approx((2.31, 2.7))
    ceilings = {p.bottom for p in apartment_solids(place) if p.material == "white_paint"}
    assert ceilings == {2.3, 2.5}


def test_frame_keeps_the_clear_width_and_stands_out_of_both_faces():
    place = two_rooms(passages=framed())
    line = shapely.LineString([(4.05, 0.5), (4.05, 2.5)])
    assert line.difference(obstacles(place)).length == pytest.approx(0.8)
    parts = [p for p in apartment_solids(place) if p.material == "frame_paint"]
    assert len(parts) == 9  # 2 jambs and a head of lining, twice 2 jambs and a head of casing
    xs = shapely.union_all([p.footprint for p in parts]).bounds
    assert xs == pytest.approx((3.98, 1.5 - 0.47, 4.12, 1.5 + 0.47))
    assert max(p.top for p in parts) == pytest.approx(2.07)
    assert min(p.bottom for p in prisms_at(place, 4.05, 1.5) if p.bottom > 0) == 2.0


def test_threshold_lies_across_the_clear_width_and_is_driven_over():
    sill = {"height": 0.008, "depth": 0.06, "material": "brass"}
    place, bare = two_rooms(passages=framed(threshold=sill)), two_rooms(passages=framed())
    (strip,) = [p for p in apartment_solids(place) if p.material == "brass"]
    assert strip.footprint.bounds == pytest.approx((4.02, 1.1, 4.08, 1.9))
    assert (strip.bottom, strip.top) == (0.0, 0.008)
    assert obstacles(place).equals(obstacles(bare))
    assert floor_region(place).equals(floor_region(bare))
    assert strip.material in apartment_mesh(place).materials


def test_a_closed_leaf_stands_on_its_threshold():
    place = two_rooms(passages=framed(closed=True, threshold={"height": 0.01, "depth": 0.02}))
    floor, strip, leaf, *_ = prisms_at(place, 4.05, 1.5)
    assert (floor.top, strip.top, leaf.bottom, leaf.material) == (0.0, 0.01, 0.01, "door_paint")
    assert obstacles(place).contains(shapely.Point(4.05, 1.5))


def test_frame_has_no_head_without_a_lintel():
    place = two_rooms(passages=framed(lintel_height=None))
    parts = [p for p in apartment_solids(place) if p.material == "frame_paint"]
    assert [(p.bottom, p.top) for p in parts] == [(0.0, 2.5)] * 6


def test_window_leaves_sill_head_and_bars():
    place = two_rooms(windows=[{"position": [2, 3.1]}])
    below, above = prisms_at(place, 1.7, 3.05)  # beside the middle bar, off the frame
    sill, head = prisms_at(place, 1.7, 3.1)[0], prisms_at(place, 1.7, 3.1)[-1]
    assert (below.top, above.bottom) == (sill.top, head.bottom) == (0.9, 2.1)
    bars = [p for p in apartment_solids(place) if p.material == "window_paint"]
    assert len(bars) == 5
    assert not obstacles(two_rooms()).symmetric_difference(obstacles(place)).area > 1e-5


def test_passage_joins_right_and_left_room():
    place = two_rooms()
    assert passage_rooms(place, place.passages[0]) == (1, 0)


@settings(max_examples=40, deadline=None)
@given(
    kind=st.sampled_from(sorted(KINDS)),
    angle=st.floats(-360, 360),
    x=st.floats(-5, 5),
    y=st.floats(-5, 5),
)
def test_pieces_keep_their_volume_wherever_they_stand(kind, angle, x, y):
    still = apartment_solids(two_rooms(furniture=[{"kind": kind, "position": [0, 0]}]))
    moved = apartment_solids(
        two_rooms(furniture=[{"kind": kind, "position": [x, y], "rotation_deg": angle}])
    )
    assert [p.volume for p in moved] == pytest.approx([p.volume for p in still])


def test_lamps_glow_by_index_and_hang_from_the_ceiling():
    lamps = [{"position": [1, 1]}, {"kind": "pendant", "position": [5, 1]}]
    lamps += [{"kind": "floor", "position": [3, 2], "height": 1.5}]
    prisms = {p.material: p for p in apartment_solids(two_rooms(lamps=lamps)) if ":" in p.material}
    assert (prisms["lamp:0"].bottom, prisms["lamp:0"].top) == pytest.approx((2.44, 2.5))
    assert prisms["lamp:1"].bottom == pytest.approx(1.8)
    assert prisms["lamp:2"].bottom == 1.5
    assert obstacles(two_rooms(lamps=lamps)).contains(shapely.Point(3, 2))


@pytest.mark.parametrize(
    "shape, heights, word",
    [
        (shapely.box(0, 0, 1, 1), (1.0, 1.0), "top"),
        (shapely.Polygon([(0, 0), (1, 1), (1, 0), (0, 1)]), (0.0, 1.0), "footprint"),
    ],
)
def test_prism_refuses_flat_and_crossed(shape, heights, word):
    with pytest.raises(ValueError, match=word):
        Prism(shape, *heights, "wood")
