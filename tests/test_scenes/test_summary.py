"""An apartment in figures, against a place whose every measure is known."""

from __future__ import annotations

import pytest

from scenes import Apartment, load_apartment, reference_names
from scenes.summary import summarise_apartment

from .places import AREA_A, AREA_B, framed, two_rooms


def test_rooms_passages_and_areas():
    summary = summarise_apartment(two_rooms(passages=framed()))
    assert [(room.name, room.area, room.passages_to) for room in summary.rooms] == [
        ("a", pytest.approx(AREA_A), ("b",)),
        ("b", pytest.approx(AREA_B), ("a",)),
    ]
    assert summary.floor_area == pytest.approx(AREA_A + AREA_B)
    assert (summary.passages, summary.framed_passages, summary.closed_passages) == (1, 1, 0)
    # Without the doorway's floor, which no room has; the casing stands on the rooms'.
    assert summary.free_area == pytest.approx(21.0 - 4 * 0.07 * 0.02)


def test_thresholds_are_counted():
    assert summarise_apartment(two_rooms(passages=framed())).thresholds == 0
    assert summarise_apartment(two_rooms(passages=framed(threshold={}))).thresholds == 1


def test_pieces_and_lamps_are_counted():
    pieces = [{"kind": "box", "position": (x, 2.0)} for x in (1.0, 2.0)]
    pieces.append({"kind": "table", "position": (5.5, 1.5)})
    lamps = [{"position": (1.0, 1.0), "power": 30.0}, {"position": (5.0, 1.0), "power": 12.0}]
    summary = summarise_apartment(two_rooms(furniture=pieces, lamps=lamps))
    assert summary.pieces == {"box": 2, "table": 1}
    assert (summary.lamps, summary.lamp_power) == (2, 42.0)
    bare = summarise_apartment(two_rooms())
    assert summary.free_area < bare.free_area - 2 * 0.5 * 0.4 + 1e-9


def test_a_closed_door_leads_nowhere():
    closed = [{"position": [4.05, 1.5], "closed": True, "lintel_height": None}]
    summary = summarise_apartment(two_rooms(passages=closed))
    assert [room.passages_to for room in summary.rooms] == [(), ()]
    assert (summary.passages, summary.closed_passages) == (0, 1)
    assert summary.passages_without_lintel == 0


def test_rooms_open_to_each_other_lead_to_each_other():
    rooms = [(0, 0, 3, 3), (3, 0, 6, 3), (3, 3, 6, 5)]
    place = Apartment.model_validate(
        {
            "name": "open",
            "rooms": [
                {"name": name, "polygon": [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]}
                for name, (x0, y0, x1, y1) in zip("abc", rooms, strict=True)
            ],
            "borders": [[[3, 0], [3, 3]], [[3, 3], [6, 3]]],
            "start": {"position": [1, 1]},
        }
    )
    summary = summarise_apartment(place)
    # Rooms a and c meet in a corner only.
    assert [room.passages_to for room in summary.rooms] == [("b",), ("a", "c"), ("b",)]
    assert summary.free_area == pytest.approx(summary.floor_area) == pytest.approx(24.0)


@pytest.mark.parametrize("name", reference_names())
def test_no_more_floor_is_free_than_there_is(name):
    summary = summarise_apartment(load_apartment(name))
    assert 0.5 * summary.floor_area < summary.free_area <= summary.floor_area
    assert all(room.passages_to for room in summary.rooms)
