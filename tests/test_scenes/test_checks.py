"""One bad place for each check, and what it says."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes import Apartment, apartment_mesh, check, load_apartment, reference_names
from scenes.pieces import KINDS
from test_scenes.places import framed, two_rooms, two_rooms_data


def problems(**changes):
    return list(check(two_rooms(**changes)))


def changed(field, index, **values):
    """One list field of the place with one item changed."""
    items = two_rooms_data()[field]
    items[index] = {**items[index], **values}
    return {field: items}


def test_good_places_have_no_problems():
    assert problems() == []
    assert problems(passages=framed(), windows=[{"position": [2, 3.1]}]) == []
    entrance = {"position": [-0.1, 1.5], "width": 0.9, "frame": {}, "closed": True}
    assert problems(passages=[*framed(), entrance]) == []
    assert problems(lamps=[{"position": [1, 1]}, {"kind": "table", "position": [1, 1]}]) == []


@pytest.mark.parametrize("name", reference_names())
def test_reference_places_have_no_problems(name):
    assert list(check(load_apartment(name))) == []


CASES = {
    "duplicate name": (
        changed("rooms", 1, name="a"),
        "rooms[0].name: 'a' is the name of several rooms; expected one",
    ),
    "crossed polygon": (
        changed("rooms", 0, polygon=[[0, 0], [4, 3], [4, 0], [0, 3]]),
        "rooms[0].polygon: crosses itself at (2, 1.5); expected a simple polygon",
    ),
    "tiny room": (
        changed("rooms", 0, polygon=[[0, 0], [0.2, 0], [0, 0.2]]),
        "rooms[0].polygon: 0.02 m²; expected at least 0.1 m²",
    ),
    "wall without length": (
        changed("walls", 0, end=[-0.1, -0.1]),
        "walls[0].end: (-0.1, -0.1) is its start; expected another point",
    ),
    "unknown floor": (
        changed("rooms", 0, floor="parket"),
        "rooms[0].floor: 'parket' is no material; did you mean 'parquet'?",
    ),
    "unknown frame": (
        {"passages": framed(frame={"material": "frame_gray"})},
        "passages[0].frame.material: 'frame_gray' is no material; did you mean 'frame_grey'?",
    ),
    "unknown window frame": (
        {"windows": [{"position": [2, 3.1], "frame": "windowpaint"}]},
        "windows[0].frame: 'windowpaint' is no material; did you mean 'window_paint'?",
    ),
    "unknown kind": (
        {"furniture": [{"kind": "chiar", "position": [1, 1]}]},
        "furniture[0].kind: 'chiar' is no kind; did you mean 'chair'?",
    ),
    "unknown slot": (
        {"furniture": [{"kind": "rug", "position": [2, 1], "materials": {"x": "wood"}}]},
        "furniture[0].materials: a rug has no slot 'x'; expected one of fabric",
    ),
    "unknown slot material": (
        {"furniture": [{"kind": "rug", "position": [2, 1], "materials": {"fabric": "wod"}}]},
        "furniture[0].materials.fabric: 'wod' is no material; did you mean 'wood'?",
    ),
    "too small": (
        {"furniture": [{"kind": "table", "position": [2, 1], "size": [0.1, 0.5, 0.7]}]},
        "furniture[0].size: (0.1, 0.5, 0.7) is too small for a table: no room for its legs along x",
    ),
    "overlapping rooms": (
        changed("rooms", 1, polygon=[[3, 0], [7.1, 0], [7.1, 3], [3, 3]]),
        "rooms[1].polygon: 'b' overlaps 'a' by 3 m²; expected clear floors apart by a wall",
    ),
    "wall in a room": (
        changed("walls", 4, thickness=0.3),
        "walls[4]: from (4.05, -0.1) to (4.05, 3.1), 0.3 m thick, covers 0.3 m² of the clear "
        "floor of 'a'; expected the room to end at the wall's face",
    ),
    # The side wall ends with its cap at y = 1; 3 cm are forgiven at either end.
    "open side": (
        changed("walls", 3, end=[-0.1, 1.1]),
        "rooms[0].polygon: the side of 'a' from (0, 3) to (0, 0) has no wall along 0.94 m; "
        "expected a wall (open plans: a wall with a wide passage without lintel, or a line in "
        "`borders`)",
    ),
    "passage off every wall": (
        {"passages": [*framed(), {"position": [3, 1.5]}]},
        "passages[1].position: (3, 1.5) lies on no wall's centre line; the nearest is that of "
        "walls[4], 1.05 m away; expected a point on one, such as (4.05, 1.5)",
    ),
    "window off every wall": (
        {"windows": [{"position": [2, 3.0]}]},
        "windows[0].position: (2, 3) lies on no wall's centre line; the nearest is that of "
        "walls[2], 0.1 m away; expected a point on one, such as (2, 3.1)",
    ),
    "passage to the outside": (
        {"passages": [*framed(), {"position": [2, 3.1]}]},
        "passages[1].position: (2, 3.1) joins 'a' only; expected a wall between two rooms, or "
        "closed: true",
    ),
    "passage too wide": (
        {"passages": [{"position": [4.05, 1.5], "width": 3.1}]},
        "passages[0].width: 3.1 m does not fit in walls[4] there; expected at most 3 m about "
        "(4.05, 1.5)",
    ),
    "passage in the corner": (
        {"passages": [{"position": [4.05, 0.3], "width": 0.8}]},
        "passages[0].width: 0.8 m does not fit in walls[4] there; expected at most 0.6 m about "
        "(4.05, 0.3)",
    ),
    "lintel above the ceiling": (
        {"passages": framed(lintel_height=2.6)},
        "passages[0].lintel_height: 2.6 m is above the ceiling of 'b'; expected at most 2.5, or "
        "null for none",
    ),
    "window inside": (
        {"windows": [{"position": [4.05, 0.5], "width": 0.5}]},
        "windows[0].position: (4.05, 0.5) is not between a room and the outside; expected a place "
        "on an outer wall",
    ),
    "window too wide": (
        {"windows": [{"position": [3.8, 3.1], "width": 1.0}]},
        "windows[0].width: 1 m does not fit in walls[2] there; expected at most 0.4 m about "
        "(3.8, 3.1)",
    ),
    "window upside down": (
        {"windows": [{"position": [2, 3.1], "sill_height": 1.5, "head_height": 1.2}]},
        "windows[0].head_height: 1.2 m; expected above the sill at 1.5 m",
    ),
    "window above the ceiling": (
        {"windows": [{"position": [2, 3.1], "head_height": 2.6}]},
        "windows[0].head_height: 2.6 m is above the ceiling of 'a'; expected at most 2.5 m",
    ),
    "overlapping openings": (
        {"passages": [*framed(), {"position": [4.05, 2.2]}]},
        "passages[1].position: the opening overlaps passages[0]; expected wall between them",
    ),
    "furniture outside": (
        {"furniture": [{"kind": "chair", "position": [1, 5]}]},
        "furniture[0] (chair): position (1, 5) is in no room; expected inside one",
    ),
    "furniture in a wall": (
        {"furniture": [{"kind": "box", "position": [0.2, 1.5]}]},
        "furniture[0] (box): at (0.2, 1.5) reaches 0.050 m into the walls of 'a'; expected on the "
        "clear floor",
    ),
    "furniture through the ceiling": (
        {"furniture": [{"kind": "box", "position": [1, 2], "elevation": 2.2}]},
        "furniture[0] (box): its top at 2.7 m is above the ceiling; expected at most 2.5 m",
    ),
    "lamp outside": (
        {"lamps": [{"position": [1, 5]}]},
        "lamps[0].position: (1, 5) is in no room; expected inside one",
    ),
    "lamp through the ceiling": (
        {"lamps": [{"kind": "floor", "position": [1, 2], "height": 2.4}]},
        "lamps[0].height: 2.4 m in 'a'; expected 0.2 to 2.25 m under its ceiling",
    ),
    "lamp in a wall": (
        {"lamps": [{"position": [0.1, 1.5], "radius": 0.2}]},
        "lamps[0].radius: 0.2 m at (0.1, 1.5) reaches into the walls of 'a'; expected inside the "
        "room",
    ),
    "huge frame": (
        {"passages": framed(frame={"width": 0.5})},
        "passages[0].frame: 0.5 x 0.02 m; expected width and depth of at most 0.3 m",
    ),
    "threshold of nothing": (
        {"passages": framed(threshold={"material": "brasss"})},
        "passages[0].threshold.material: 'brasss' is no material; did you mean 'brass'?",
    ),
    "start by the wall": (
        {"start": {"position": [0.1, 1.5]}},
        "start.position: (0.1, 1.5) has no free floor for a robot of 0.15 m radius; expected a "
        "free place, such as (0.15, 1.5)",
    ),
    "unreachable room": (
        {"passages": framed(width=0.25)},
        "rooms[1]: 'b' cannot be reached from the start by a robot of 0.15 m radius; expected an "
        "open passage at least 0.3 m wide, with nothing before it",
    ),
}


@pytest.mark.parametrize("changes, message", CASES.values(), ids=CASES.keys())
def test_each_mistake_is_named(changes, message):
    assert message in problems(**changes)


@pytest.mark.parametrize("changes", [case[0] for case in CASES.values()], ids=CASES.keys())
def test_problems_are_single_lines(changes):
    found = problems(**changes)
    assert found
    assert not any("\n" in line for line in found)


def test_all_problems_of_a_stage_are_reported():
    found = problems(
        furniture=[{"kind": "box", "position": [1, 9]}, {"kind": "box", "position": [2, 9]}],
        start={"position": [9, 9]},
    )
    assert len(found) == 3


def test_touching_a_wall_within_the_tolerance_is_no_problem():
    assert problems(furniture=[{"kind": "box", "position": [0.24, 1.5]}]) == []


def test_chair_under_a_table_is_no_problem():
    furniture = [{"kind": "table", "position": [2, 1.5]}, {"kind": "chair", "position": [2, 1.2]}]
    assert problems(furniture=furniture) == []


number = st.integers(-4, 4).map(lambda k: k / 2)
point = st.tuples(number, number)
size = st.sampled_from([0.001, 0.1, 0.7, 2.0, 900.0])
passage = st.fixed_dictionaries(
    {"position": point, "width": size, "lintel_height": size, "closed": st.booleans()}
)


@settings(max_examples=150, deadline=None)
@given(
    rooms=st.lists(st.lists(point, min_size=3, max_size=5), min_size=1, max_size=3),
    walls=st.lists(st.tuples(point, point, size), min_size=3, max_size=6),
    passages=st.lists(passage, max_size=2),
    windows=st.lists(st.tuples(point, size, size), max_size=2),
    pieces=st.lists(st.tuples(st.sampled_from(sorted(KINDS)), point, size, size, size), max_size=3),
    lamps=st.lists(st.tuples(point, size, size), max_size=2),
    start=point,
)
def test_nonsense_is_reported_not_raised(rooms, walls, passages, windows, pieces, lamps, start):
    place = Apartment.model_validate(
        {
            "name": "x",
            "rooms": [{"name": f"r{k}", "polygon": polygon} for k, polygon in enumerate(rooms)],
            "walls": [{"start": a, "end": b, "thickness": t} for a, b, t in walls],
            "passages": passages,
            "windows": [{"position": p, "width": w, "head_height": h} for p, w, h in windows],
            "furniture": [{"kind": k, "position": p, "size": s} for k, p, *s in pieces],
            "lamps": [{"position": p, "height": h, "radius": r} for p, h, r in lamps],
            "start": {"position": start},
        }
    )
    assert all("\n" not in line for line in check(place))


@settings(max_examples=60, deadline=None)
@given(
    pieces=st.lists(st.tuples(st.sampled_from(sorted(KINDS)), size, size, size), max_size=3),
    lamp=st.tuples(st.sampled_from(["ceiling", "pendant", "floor", "table"]), size, size),
    passage=passage,
)
def test_what_passes_the_checks_can_be_built(pieces, lamp, passage):
    kind, height, radius = lamp
    place = two_rooms(
        furniture=[{"kind": k, "position": [1, 2], "size": s} for k, *s in pieces],
        lamps=[{"kind": kind, "position": [2, 1], "height": height, "radius": radius}],
        passages=[{**passage, "position": [4.05, 1.5]}],
    )
    if not list(check(place)):
        apartment_mesh(place)


def test_a_passage_whose_front_sees_no_floor_is_told():
    rooms = two_rooms_data()["rooms"]
    # The room begins 8 cm behind the wall: found, but not seen from the wall's face.
    rooms[1]["polygon"] = [[4.18, 0], [7.1, 0], [7.1, 3], [4.18, 3]]
    assert any("passages[0].width" in problem for problem in problems(rooms=rooms))
