"""Segmentations side by side: the same rooms have the same colours, others are counted."""

from __future__ import annotations

import numpy as np
import pytest
from cleaned_flat import cleaned_flat

from roomseg.browser.comparison import TRUE_ROOMS, Segmentation, segmentations_of, shown_beside

FLAT = cleaned_flat("flat")
ROOM = FLAT.ground_truth.room
POSITION = FLAT.nodes.position


def other_names(room: np.ndarray) -> np.ndarray:
    return np.array([7, 0, 3])[room]


def test_other_names_of_the_same_rooms_show_the_same() -> None:
    both = [Segmentation(TRUE_ROOMS, ROOM), Segmentation("found", other_names(ROOM))]
    shown = shown_beside(both, POSITION)
    for left in range(2):
        pair = shown[left][left], shown[left][1 - left]
        assert np.array_equal(pair[0].colour, pair[1].colour)
        assert pair[0].rooms == pair[1].rooms
        assert "; 0 of" in pair[1].about
    assert len(np.unique(shown[0][0].colour)) == 3
    assert shown[0][1].about.endswith("impurity 0.0 %")
    assert "impurity" not in shown[1][0].about, "of the truth there is none"


def test_nodes_of_another_room_differ() -> None:
    moved = ROOM.copy()
    wrong = np.flatnonzero(ROOM == 1)[:5]
    moved[wrong] = 0
    both = [Segmentation(TRUE_ROOMS, ROOM), Segmentation("found", other_names(moved))]
    shown = shown_beside(both, POSITION)
    assert f"3 rooms; 5 of {len(ROOM)} nodes differ" in shown[0][1].about
    differs = np.flatnonzero(shown[0][0].colour != shown[0][1].colour)
    assert np.array_equal(differs, wrong)


def test_a_room_too_many_has_a_colour_of_its_own() -> None:
    torn = ROOM.copy()
    torn[np.flatnonzero(ROOM == 2)[::3]] = 9
    shown = shown_beside([Segmentation("a", ROOM), Segmentation("b", torn)], POSITION)
    extra = shown[0][1].colour[torn == 9]
    assert set(extra).isdisjoint(shown[0][0].colour) and len(set(extra)) == 1


def test_names_stand_inside_their_rooms() -> None:
    named = Segmentation(TRUE_ROOMS, ROOM, room_names=("kitchen", "", "hall"))
    rooms = shown_beside([named], POSITION)[0][0].rooms
    assert rooms["name"] == ["kitchen", "2", "hall"]
    for number, place in enumerate(zip(rooms["x"], rooms["y"], strict=True)):
        nearest = np.linalg.norm(POSITION - place, axis=1).argmin()
        assert ROOM[nearest] == number


def test_what_a_map_has() -> None:
    truth, found = segmentations_of(FLAT, other_names(ROOM), "model.skops")
    assert (truth.name, found.name) == (TRUE_ROOMS, "rooms by model.skops")
    assert len(truth.crossing) == FLAT.ground_truth.edge_is_border.sum()
    assert segmentations_of(cleaned_flat(real=True).with_ground_truth(None)) == []
    assert shown_beside([], POSITION) == []


@pytest.mark.parametrize("count", [0, 30])
def test_more_rooms_than_colours(count: int) -> None:
    label = np.arange(len(ROOM)) % (count + 1)
    shown = shown_beside([Segmentation("many", label)], POSITION)[0][0]
    assert shown.about == ("31 rooms" if count else "1 room")
    assert shown.colour.max() < 27
