"""Materials: own before built-in, and the names that everything uses by default."""

from __future__ import annotations

import pytest

from scenes import SceneError
from scenes.apartment import Frame, Material, Room, Window
from scenes.materials import BUILT_IN, mean_colour, resolve
from scenes.pieces import KINDS
from scenes.solids import apartment_solids
from test_scenes.places import framed, two_rooms


def test_own_material_comes_before_the_built_in_one():
    place = two_rooms(materials={"parquet": {"colour": [0.1, 0.2, 0.3]}})
    assert resolve(place, "parquet").colour == (0.1, 0.2, 0.3)
    assert resolve(two_rooms(), "parquet") == BUILT_IN["parquet"]


@pytest.mark.parametrize("name", ["nothing", "lamp:1", "lamp:-1", "lamp:", "<wall>"])
def test_unknown_material_is_refused(name):
    with pytest.raises(SceneError, match=r"^two: material .* is neither its own nor built in$"):
        resolve(two_rooms(lamps=[{"position": [1, 1]}]), name)


def test_lamp_bodies_have_a_material():
    assert resolve(two_rooms(lamps=[{"position": [1, 1]}]), "lamp:0").pattern == "plain"


def test_defaults_are_built_in():
    room = Room(name="a", polygon=((0, 0), (1, 0), (1, 1)))
    used = {room.floor, room.walls, room.ceiling, Frame().material, Window(position=(0, 0)).frame}
    used |= {name for kind in KINDS.values() for name in kind.slots.values()}
    used |= {"facade"}
    assert used <= set(BUILT_IN)


def test_every_solid_has_a_material_that_resolves():
    lamps = [
        {"kind": kind, "position": [1, 1]} for kind in ("ceiling", "pendant", "floor", "table")
    ]
    entrance = {"position": [-0.1, 1.5], "closed": True}
    place = two_rooms(
        lamps=lamps, passages=[*framed(), entrance], windows=[{"position": [2, 3.1]}],
        furniture=[{"kind": kind, "position": [2, 1.5]} for kind in KINDS],
    )  # fmt: skip
    for prism in apartment_solids(place):
        assert prism.material == "<wall>" or resolve(place, prism.material)


def test_mean_colour_lies_between_the_two():
    assert mean_colour(Material(pattern="wood", colour=(0.1, 0.2, 0.3))) == (0.1, 0.2, 0.3)
    carpet = Material(pattern="carpet", colour=(0.2, 0.4, 0.6), second_colour=(0.0, 0.0, 0.0))
    assert mean_colour(carpet) == pytest.approx((0.1, 0.2, 0.3))
