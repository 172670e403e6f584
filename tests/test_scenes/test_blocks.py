"""Blocks (masonry, columns, ceiling steps), skirting boards and borders without a wall."""

import numpy as np
import pytest
from shapely import Point, Polygon

from scenes.apartment import Apartment, Block, Passage, Piece, Room, Skirting, Start, Wall
from scenes.checks import check
from scenes.passages import reachable_positions, room_borders
from scenes.solids import apartment_solids, floor_area, floor_region, obstacles

SHELL = Block(
    polygon=((-0.2, -0.2), (6.2, -0.2), (6.2, 3.2), (-0.2, 3.2)),
    holes=(((0, 0), (6, 0), (6, 3), (0, 3)),),
)
COLUMN = Block(polygon=((1.4, 1.4), (1.6, 1.4), (1.6, 1.6), (1.4, 1.6)))
STEP = Block(polygon=((2, 0), (2.4, 0), (2.4, 3), (2, 3)), bottom=2.2, material="white_paint")
LEFT = Room(name="left", polygon=((0, 0), (3, 0), (3, 3), (0, 3)))
RIGHT = Room(name="right", polygon=((3, 0), (6, 0), (6, 3), (3, 3)))


def flat(**changes):
    """Two rooms in a shell of masonry, parted by a border and no wall."""
    fields = {
        "name": "blocks",
        "rooms": (LEFT, RIGHT),
        "blocks": (SHELL, COLUMN, STEP),
        "borders": (((3, 0), (3, 3)),),
        "start": Start(position=(0.5, 0.5)),
    }
    return Apartment(**(fields | changes))


def test_masonry_closes_rooms_and_borders_part_them():
    assert list(check(flat())) == []
    assert np.array_equal(room_borders(flat()), [[[3, 0], [3, 3]]])


def test_a_side_with_neither_wall_nor_border_is_a_problem():
    problems = list(check(flat(borders=())))
    assert len(problems) == 2
    assert "rooms[0].polygon" in problems[0]
    assert "`borders`" in problems[0]


def test_column_is_an_obstacle_and_no_floor():
    apartment = flat()
    assert floor_area(apartment) == pytest.approx(18.0 - 0.04)
    assert obstacles(apartment).contains(Point(1.5, 1.5))
    assert not floor_region(apartment).contains(Point(1.5, 1.5))
    reach = reachable_positions(apartment)
    assert np.hypot(*(reach - 1.5).T).min() > 0.15


def test_step_of_the_ceiling_hangs_over_the_floor():
    apartment = flat()
    assert not obstacles(apartment).intersects(Point(2.2, 1.0))
    step = [s for s in apartment_solids(apartment) if s.bottom == 2.2]
    assert len(step) == 1
    assert step[0].top > LEFT.ceiling_height


@pytest.mark.parametrize(
    ("block", "said"),
    [
        (
            Block(polygon=((0, 0), (1, 1), (1, 0), (0, 1))),
            "blocks[0].polygon: crosses itself at (0.5, 0.5)",
        ),
        (Block(polygon=((0, 0), (1, 0), (1, 1)), bottom=2.0, top=1.0), "blocks[0].top: 1 m"),
        (Block(polygon=((0, 0), (1, 0), (1, 1)), material="woood"), "did you mean 'wood'?"),
    ],
)
def test_impossible_blocks_are_told(block, said):
    assert any(said in problem for problem in check(flat(blocks=(block, SHELL))))


def test_openings_cut_masonry():
    rooms = (LEFT, RIGHT.model_copy(update={"polygon": ((3.2, 0), (6, 0), (6, 3), (3.2, 3))}))
    party = Block(polygon=((3, 0), (3.2, 0), (3.2, 3), (3, 3)))
    line = Wall(start=(3.1, 0.4), end=(3.1, 2.6), thickness=0.2)
    door = Passage(position=(3.1, 1.5), width=0.9)
    apartment = flat(
        rooms=rooms, blocks=(SHELL, party), walls=(line,), borders=(), passages=(door,)
    )
    assert list(check(apartment)) == []
    assert not obstacles(apartment).intersects(Point(3.1, 1.5))
    assert obstacles(apartment).contains(Point(3.1, 0.5))


def test_skirting_follows_the_walls_and_stops_at_openings():
    boards = Skirting(height=0.08, depth=0.02)
    apartment = flat(rooms=(LEFT.model_copy(update={"skirting": boards}), RIGHT))
    solids = [s for s in apartment_solids(apartment) if s.top == pytest.approx(0.08)]
    area = sum(s.footprint.area for s in solids)
    # Three sides of the left room and the column; none along the border to the right room.
    inner = Polygon(LEFT.polygon).buffer(-0.02, join_style="mitre")
    around = Polygon(COLUMN.polygon).buffer(0.02, join_style="mitre").area - 0.04
    assert area == pytest.approx(9.0 - inner.area - 0.02 * 2.96 + around, rel=0.02)
    assert not any(s.footprint.intersects(Point(2.99, 1.5)) for s in solids)


@pytest.mark.parametrize(("bottom", "seen"), [(2.49, True), (2.5, False), (3.0, False)])
def test_a_step_above_the_ceiling_is_told(bottom, seen):
    step = STEP.model_copy(update={"bottom": bottom})
    assert list(check(flat(blocks=(SHELL, step)))) == (
        []
        if seen
        else [
            f"blocks[1].bottom: {bottom:g} m is not below the ceiling of 'left'; expected less "
            f"than 2.5 m for a step of the ceiling"
        ]
    )


def test_a_step_over_two_rooms_may_be_below_one_ceiling_only():
    high = RIGHT.model_copy(update={"ceiling_height": 3.0})
    across = ((2.5, 1), (3.5, 1), (3.5, 2), (2.5, 2))
    step = Block(polygon=across, bottom=2.7)
    assert list(check(flat(rooms=(LEFT, high), blocks=(SHELL, step)))) == []


@pytest.mark.parametrize(
    ("position", "said"),
    [
        # A box covers the whole column; another reaches 4 cm into it, or 5 cm into
        # the wall.
        ((1.5, 1.5), "reaches 0.200 m into the masonry of 'left', blocks[1]"),
        ((1.19, 1.5), "reaches 0.040 m into the masonry of 'left', blocks[1]"),
        ((0.2, 2.2), "reaches 0.050 m into the masonry of 'left', blocks[0]"),
        ((2.2, 1.5), "reaches 0.400 m into blocks[2]; expected beside, below or above it"),
    ],
)
def test_a_piece_in_a_block_is_told(position, said):
    box = Piece(kind="box", position=position, size=(0.5, 0.5, 2.4))
    (problem,) = check(flat(furniture=(box,)))
    assert said in problem
