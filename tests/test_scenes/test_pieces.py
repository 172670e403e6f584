"""Every kind of piece: what its signature says, what stands on what, what a robot meets."""

from __future__ import annotations

import itertools

import pytest
import shapely

from scenes import apartment_solids, check, obstacles
from scenes.parts import Part
from scenes.pieces import KINDS, piece_parts
from scenes.solids import Prism
from test_scenes.places import two_rooms

ROBOT = 0.15
"""Radius of the robot, m; it is 10 cm high."""
WALL_HELD = {"coat_rack", "curtain", "shower_cabin", "shower_tray", "towel_radiator", "vanity"}
"""Kinds that do not hang by themselves, but have parts that only the wall holds."""

CONTACT = 6e-3
"""Parts this near to each other touch, m: a fridge's doors have seals, a shower head a joint."""
SCALES = [1.0, 0.8, 1.25]
every_kind = pytest.mark.parametrize("kind", sorted(KINDS))


def build(kind: str, scale: float = 1.0) -> list[Part]:
    """Parts at a scale of the default size, each with its slot as its material."""
    size = (scale * length for length in KINDS[kind].size)
    return list(KINDS[kind].build(*size, **{slot: slot for slot in KINDS[kind].slots}))


def test_there_are_all_the_kinds_that_a_home_needs():
    assert len(KINDS) >= 70
    assert {"bed", "sofa", "kitchen_counter", "toilet", "radiator", "cable"} <= set(KINDS)


def test_a_kind_is_what_its_signature_says():
    kind = KINDS["table"]
    assert (kind.size, dict(kind.slots)) == ((1.4, 0.8, 0.75), {"top": "wood", "legs": "wood"})
    assert (kind.elevation, KINDS["picture"].elevation) == (0.0, 1.4)
    assert kind.summary == "Four legs, rails and a top."


@every_kind
@pytest.mark.parametrize("scale", SCALES)
def test_parts_are_sound_and_within_the_footprint(kind, scale):
    width, depth, _ = (scale * length for length in KINDS[kind].size)
    parts = build(kind, scale)
    for part in parts:
        Prism(part.footprint, part.bottom, part.top, part.material)
    left, front, right, back = shapely.total_bounds([part.footprint for part in parts])
    # The rail of a curtain stands over.
    over = 0.05 if kind == "curtain" else 0.0
    assert max(-left, right) <= width / 2 + over + 1e-6
    assert max(-front, back) <= depth / 2 + 1e-6
    assert min(part.bottom for part in parts) >= 0.0


@every_kind
def test_parts_reach_the_height(kind):
    top = max(part.top for part in build(kind))
    # Screens, taps and shower heads stand on what the height is of.
    higher = {"desk", "kitchen_counter", "kitchen_sink", "basin", "vanity", "bath", "shower_tray"}
    if kind in higher:
        assert top >= KINDS[kind].size[2]
    else:
        assert top == pytest.approx(KINDS[kind].size[2])


@every_kind
def test_every_slot_is_used_and_every_part_has_a_slot(kind):
    assert {part.material for part in build(kind)} == set(KINDS[kind].slots)


@every_kind
@pytest.mark.parametrize("scale", SCALES)
def test_parts_do_not_pierce_one_another(kind, scale):
    crosses = {"office_chair", "radiator", "toilet", "curtain"}  # whose bars run through others
    for one, other in itertools.combinations(build(kind, scale), 2):
        overlap = min(one.top, other.top) - max(one.bottom, other.bottom)
        if overlap > 1e-9 and kind not in crosses:
            shared = one.footprint.intersection(other.footprint).area
            assert shared < 1e-9, (one, other)


@every_kind
@pytest.mark.parametrize("scale", SCALES)
def test_nothing_floats(kind, scale):
    parts, back = build(kind, scale), scale * KINDS[kind].size[1] / 2
    by_wall = KINDS[kind].elevation > 0.0 or kind in WALL_HELD
    held = {
        k
        for k, part in enumerate(parts)
        if part.bottom < 1e-6 or (by_wall and part.footprint.bounds[3] > back - 1e-6)
    }
    if KINDS[kind].elevation > 0.0:
        held = {k for k in held if parts[k].footprint.bounds[3] > back - 1e-6} or held
    reached = list(held)
    for k in reached:
        for j, other in enumerate(parts):
            gap = max(parts[k].bottom, other.bottom) - min(parts[k].top, other.top)
            near = shapely.dwithin(parts[k].footprint, other.footprint, CONTACT)
            if j not in held and gap < CONTACT and near:
                held.add(j)
                reached.append(j)
    assert not [parts[k] for k in set(range(len(parts))) - held]


@every_kind
def test_obstacle_outline_is_that_of_the_prisms_near_the_floor(kind):
    place = two_rooms(furniture=[{"kind": kind, "position": [2, 1.5]}])
    near = [
        shapely.affinity.translate(part.footprint, 2, 1.5)
        for part in build(kind)
        if part.bottom + KINDS[kind].elevation < 0.10 and part.top + KINDS[kind].elevation > 0.01
    ]
    walls = obstacles(two_rooms())
    added = obstacles(place).difference(walls)
    assert added.symmetric_difference(shapely.union_all(near)).area < 1e-5


def share_under(kind: str) -> float:
    """Share of the places beneath a piece where the middle of the robot can be."""
    lift = KINDS[kind].elevation
    parts = build(kind)
    blocked = shapely.union_all(
        [p.footprint for p in parts if p.bottom + lift < 0.10 and p.top + lift > 0.01]
    )
    outline = shapely.union_all([part.footprint for part in parts])
    free = outline.buffer(1.0).difference(blocked.buffer(ROBOT, quad_segs=32))
    outside = max(shapely.get_parts(free), key=lambda part: part.area)
    return outside.intersection(outline).area / outline.area


UNDER = {
    "yes": """basin bed bench bunk_bed cable chair clothes_horse coat_rack coffee_table desk
        door_mat ironing_board office_desk rug side_table sideboard sofa table tv_stand vanity
        blinds boiler ceiling_beam extractor_hood mirror picture radiator towel_radiator tv
        wall_cupboard wall_shelf whiteboard""",
    "partly": "kitchen_island nightstand office_chair piano round_table",
    "no": """armchair bar_stool bath bookcase box chest_of_drawers column cooker copier
        corner_sofa curtain dishwasher divan_bed filing_cabinet fireplace floor_lamp
        fridge kitchen_counter kitchen_sink laundry_basket low_sofa oven_tower pet_bowl plant
        room_divider shelf shoe_rack shoes shower_cabin shower_tray stool toilet toys
        umbrella_stand wardrobe washing_machine waste_bin""",
}
"""Whether a robot of 15 cm radius and 10 cm height drives beneath (over a rug, mat or cable)."""


@every_kind
def test_what_the_robot_drives_under(kind):
    (answer,) = (answer for answer, kinds in UNDER.items() if kind in kinds.split())
    share = share_under(kind)
    assert answer == ("yes" if share > 0.3 else "partly" if share > 0.1 else "no"), share


def test_kinds_that_hang_do_not_stand_on_the_floor():
    place = two_rooms(furniture=[{"kind": "picture", "position": [2, 2.98]}])
    assert min(part.bottom for part in piece_parts(place.furniture[0])) == pytest.approx(1.4)
    low = two_rooms(furniture=[{"kind": "picture", "position": [2, 2.98], "elevation": 0}])
    assert min(part.bottom for part in piece_parts(low.furniture[0])) == 0.0


def test_hung_pieces_must_fit_under_the_ceiling():
    beam = {"kind": "ceiling_beam", "position": [2, 1.5], "elevation": 2.4}
    (problem,) = check(two_rooms(furniture=[beam]))
    assert problem == (
        "furniture[0] (ceiling_beam): its top at 2.6 m is above the ceiling; expected at most 2.5 m"
    )


def test_pieces_do_not_hang_in_a_ceiling_step_or_stand_in_a_column():
    step = {"polygon": [[1, 1], [3, 1], [3, 2], [1, 2]], "bottom": 2.0}
    beam = {"kind": "ceiling_beam", "position": [2, 1.5], "elevation": 1.8}
    assert not list(check(two_rooms(furniture=[beam], blocks=[step])))
    (problem,) = check(two_rooms(furniture=[{**beam, "elevation": 1.9}], blocks=[step]))
    assert problem == (
        "furniture[0] (ceiling_beam): reaches 0.150 m into blocks[0]; "
        "expected beside, below or above it"
    )
    stub = {"polygon": [[1.9, 1.4], [2.1, 1.4], [2.1, 1.6], [1.9, 1.6]], "top": 1.0}
    (problem,) = check(
        two_rooms(furniture=[{"kind": "table", "position": [2, 1.5]}], blocks=[stub])
    )
    assert "reaches 0.200 m into blocks[0]" in problem


def test_unknown_slot_is_refused_with_a_hint():
    piece = {"kind": "table", "position": [2, 1.5], "materials": {"tops": "wood"}}
    (problem,) = check(two_rooms(furniture=[piece]))
    assert problem.endswith("a table has no slot 'tops'; did you mean 'top'?")


def test_slots_take_materials():
    piece = {"kind": "table", "position": [2, 1.5], "materials": {"top": "stone"}}
    names = [part.material for part in piece_parts(two_rooms(furniture=[piece]).furniture[0])]
    assert sorted(set(names)) == ["stone", "wood"] and names.count("stone") == 1
    assert "stone" in {prism.material for prism in apartment_solids(two_rooms(furniture=[piece]))}
