"""The model that comes with roomseg."""

from __future__ import annotations

from roomseg.features import FEATURES
from roomseg.shipped import SHIPPED_MODEL, shipped_model, usual_room_count


def test_it_is_small_and_tells_what_it_was_trained_on() -> None:
    model = shipped_model()
    assert model.names == FEATURES
    assert SHIPPED_MODEL.stat().st_size < 200_000
    # Places and runs of the reference set.
    places = {item.environment for item in model.trained_on}
    assert {"sim3", "sim4", "real1", "real3"} <= places
    assert all(item.edges > 500 and item.border_edges > 10 for item in model.trained_on)


def test_larger_homes_have_more_rooms() -> None:
    counts = [usual_room_count(nodes) for nodes in (1, 2, 400, 1400, 2800)]
    assert counts == sorted(counts)
    assert counts[0] == 1 and counts[1] <= 2
    assert 2 <= counts[2] < counts[-1] <= 15
