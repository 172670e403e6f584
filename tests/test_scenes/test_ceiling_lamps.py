"""Scenes without light get lamps that leave no room in the dark."""

from __future__ import annotations

import numpy as np
import shapely

from scenes import check
from scenes.importers.ceiling_lamps import ceiling_lamps
from scenes.importers.slicing import Triangles
from scenes.mesh import apartment_mesh
from scenes.passages import free_region, reachable_positions
from test_scenes.places import two_rooms


def lit(low_beam: bool = False) -> tuple:
    place = two_rooms()
    if low_beam:
        ceiling = {"polygon": [[0, 0], [4, 0], [4, 3], [0, 3]], "bottom": 2.2, "material": "facade"}
        place = two_rooms(blocks=[ceiling])
    mesh = apartment_mesh(place)
    corners = mesh.vertices[mesh.triangles]
    return place, ceiling_lamps(two_rooms(), Triangles(corners, np.zeros(len(corners), int)))


def test_every_room_has_a_lamp_in_sight() -> None:
    place, lamps = lit()
    assert 2 <= len(lamps) <= 4
    free = free_region(place, 0.0)
    spots = reachable_positions(place, spacing=0.25)
    lines = [[shapely.LineString([spot, lamp.position]) for lamp in lamps] for spot in spots]
    assert np.mean([any(free.covers(line) for line in row) for row in lines]) > 0.95
    assert not list(check(place.model_copy(update={"lamps": lamps})))


def test_lamps_hang_under_the_ceiling_over_them() -> None:
    _, lamps = lit(low_beam=True)
    heights = {lamp.height for lamp in lamps if lamp.position[0] < 4.0}
    assert heights == {2.1}
    assert {lamp.height for lamp in lamps if lamp.position[0] > 4.1} == {2.4}
