"""Borders and reachable places against hand-drawn ones."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes import (
    SceneError,
    apartment_mesh,
    apartment_solids,
    check,
    floor_region,
    obstacles,
    reachable_positions,
    room_borders,
)
from scenes.passages import free_region
from test_scenes.places import framed, turned, two_rooms


def test_three_borders_cover_the_depth_of_wall_and_frame():
    borders = room_borders(two_rooms(passages=framed()))
    assert borders.shape == (3, 2, 2)
    assert borders[:, :, 0] == pytest.approx(np.array([[4.12] * 2, [4.05] * 2, [3.98] * 2]))
    assert np.sort(borders[:, :, 1], axis=1) == pytest.approx(np.array([[1.05, 1.95]] * 3))


def test_borders_without_frame_lie_in_the_wall_faces():
    borders = room_borders(two_rooms(), depths=(-1, 1), extension=0.0)
    assert sorted(borders[:, 0, 0]) == pytest.approx([4.0, 4.1])
    assert np.ptp(borders[:, :, 1], axis=1) == pytest.approx([0.8, 0.8])


@pytest.mark.parametrize("x", [3.9, 4.0, 4.05, 4.1])
def test_every_way_through_the_passage_crosses_a_border(x):
    """An edge 0.2 m long that begins at any depth of the passage."""
    lines = shapely.multilinestrings(list(room_borders(two_rooms())))
    for y in np.linspace(1.11, 1.89, 9):
        assert shapely.LineString([(x, y), (x + 0.2, y + 0.05)]).intersects(lines)


def test_closed_passages_and_passages_inside_a_room_have_no_border():
    assert len(room_borders(two_rooms(passages=framed(closed=True)))) == 0
    # A stub wall with an opening, all inside room a.
    walls = two_rooms().model_dump(mode="json")["walls"]
    rooms = two_rooms().model_dump(mode="json")["rooms"]
    walls.append({"start": [2, 0], "end": [2, 2], "thickness": 0.1})
    rooms[0]["polygon"] = [
        [0, 0], [1.95, 0], [1.95, 2], [2.05, 2], [2.05, 0], [4, 0], [4, 3], [0, 3]
    ]  # fmt: skip
    passages = [*framed(), {"position": [2, 1], "width": 0.8}]
    assert len(room_borders(two_rooms(walls=walls, rooms=rooms, passages=passages))) == 3


def test_reachable_positions_fill_the_eroded_rooms():
    points = reachable_positions(two_rooms(), radius=0.15, spacing=0.05)
    in_a = points[points[:, 0] < 3.8]
    assert in_a.min(axis=0) == pytest.approx([0.15, 0.15], abs=0.0501)
    assert in_a.max(axis=0) == pytest.approx([3.75, 2.85], abs=0.0501)
    # 2.7 m and 3.7 m, the passage's 0.5 m strip between them: 17.5 m² at 400 points each.
    expected = (2.7 * 3.7 + 2.7 * 2.7 + 0.5 * 0.4) * 400
    assert len(points) == pytest.approx(expected, rel=0.03)
    assert points / 0.05 == pytest.approx(np.round(points / 0.05))


def test_reachable_positions_keep_their_distance():
    place = two_rooms(passages=framed(), furniture=[{"kind": "table", "position": [2, 1.5]}])
    points = shapely.points(reachable_positions(place, radius=0.15))
    assert shapely.distance(obstacles(place), points).min() >= 0.15 - 1e-3
    assert shapely.intersects(floor_region(place), points).all()


def test_a_closed_door_ends_what_is_reachable():
    points = reachable_positions(two_rooms(passages=framed(closed=True)))
    assert points[:, 0].max() < 4.0


def test_a_passage_narrower_than_the_robot_ends_what_is_reachable():
    points = reachable_positions(two_rooms(passages=framed(width=0.29)))
    assert points[:, 0].max() < 4.0


def test_start_in_a_wall_is_refused():
    with pytest.raises(SceneError, match=r"start\.position .* expected free floor"):
        reachable_positions(two_rooms(start={"position": [4.05, 0.2]}))


FULL = two_rooms(
    passages=framed(),
    windows=[{"position": [2, 3.1]}],
    furniture=[{"kind": "table", "position": [2, 1.5]}, {"kind": "bath", "position": [6, 0.4]}],
    lamps=[{"position": [1, 1]}],
)


@settings(max_examples=40, deadline=None)
@given(
    angle=st.floats(-180, 180), x=st.floats(-50, 50), y=st.floats(-50, 50), gap=st.floats(0, 0.0299)
)
def test_a_turned_place_is_the_same_place(angle, x, y, gap):
    """Rounding must neither close a passage nor open a wall."""
    rooms = FULL.model_dump(mode="json")["rooms"]
    rooms[0]["polygon"] = [[gap, gap], [4 - gap, gap], [4 - gap, 3 - gap], [gap, 3 - gap]]
    still = FULL.model_copy(update={"rooms": two_rooms(rooms=rooms).rooms})
    moved = turned(still, angle, (x, y))
    assert list(check(moved)) == []
    for measure in (floor_region, obstacles, lambda place: free_region(place, 0.15)):
        assert measure(moved).area == pytest.approx(measure(still).area, abs=2e-3)
    volume = sum(prism.volume for prism in apartment_solids(still))
    assert sum(prism.volume for prism in apartment_solids(moved)) == pytest.approx(volume, rel=1e-3)
    assert len(apartment_mesh(moved).triangles) > 100
    lengths = np.linalg.norm(np.diff(room_borders(moved), axis=1), axis=-1)
    assert lengths == pytest.approx(np.full((3, 1), 0.9))
