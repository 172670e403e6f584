"""The model that comes with roomseg."""

from __future__ import annotations

from roomseg.features import FEATURES
from roomseg.room_count import usual_room_count
from roomseg.shipped import SHIPPED_MODEL, shipped_model


def test_it_is_small_and_tells_what_it_was_trained_on() -> None:
    model = shipped_model()
    assert model.names == FEATURES
    assert SHIPPED_MODEL.stat().st_size < 200_000
    places = {item.environment for item in model.trained_on}
    assert places == {*(f"sim{i}" for i in range(1, 6)), *(f"real{i}" for i in range(1, 4))}
    assert all(item.edges > 500 and item.border_edges > 10 for item in model.trained_on)


def test_the_usual_room_count_is_near_that_of_table_8() -> None:
    maps = [(item.nodes, item.rooms) for item in shipped_model().trained_on]
    assert all(abs(usual_room_count(nodes) - rooms) <= 2 for nodes, rooms in maps)


def test_larger_homes_have_more_rooms() -> None:
    counts = [usual_room_count(nodes) for nodes in (1, 2, 236, 400, 1400, 2800, 10_000)]
    assert counts == sorted(counts)
    assert counts[:2] == [1, 1] and counts[2] == 3 and counts[-1] == 17
