"""An apartment in figures, against a place whose every measure is known."""

from __future__ import annotations

import pytest

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
    # The doorway's floor is free, too, between the boards that line it; the casing is not.
    assert summary.free_area == pytest.approx(21.0 + 0.8 * 0.1 - 4 * 0.07 * 0.02)


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
