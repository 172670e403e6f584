"""Contrast of passageways against reflectances worked out by hand."""

from __future__ import annotations

import pytest

from scenes.apartment import Material
from scenes.contrast import contrast_level, passageway_contrast, reflectance
from test_scenes.places import framed, two_rooms

GREYS = {f"grey{k}": {"colour": [k / 100] * 3} for k in (10, 20, 40, 80)}


def place(walls, frame):
    data = two_rooms(
        materials=GREYS, passages=framed(frame={"material": frame}) if frame else framed(frame=None)
    ).model_dump(mode="json")
    for room, name in zip(data["rooms"], walls, strict=True):
        room["walls"] = name
    return type(two_rooms()).model_validate(data)


@pytest.mark.parametrize(
    "walls, frame, expected",
    [
        (("grey80", "grey80"), "grey80", 0.0),
        (("grey80", "grey80"), "grey40", 0.5),
        (("grey40", "grey40"), "grey80", 0.5),
        (("grey80", "grey20"), "grey10", (0.875 + 0.5) / 2),
        (("grey80", "grey80"), None, 0.0),
    ],
)
def test_contrast_is_relative_to_the_brighter_of_frame_and_wall(walls, frame, expected):
    assert passageway_contrast(place(walls, frame)) == pytest.approx(expected)


def test_most_passages_decide():
    passages = [*framed(frame={"material": "grey10"}), *framed(frame=None), *framed(frame=None)]
    dark_once = place(("grey80", "grey80"), "grey10").model_copy(
        update={"passages": two_rooms(materials=GREYS, passages=passages).passages}
    )
    assert passageway_contrast(dark_once) == 0.0


def test_entrance_doors_do_not_count():
    closed = framed(frame={"material": "grey10"}, closed=True)
    assert passageway_contrast(two_rooms(materials=GREYS, passages=closed)) == 0.0


@pytest.mark.parametrize(
    "value, level", [(0.0, "low"), (0.14, "low"), (0.2, "medium"), (0.59, "medium"), (0.6, "high")]
)
def test_levels(value, level):
    assert contrast_level(value) == level


def test_reflectance_is_luminance_of_the_mean_colour():
    assert reflectance(Material(colour=(1.0, 0.0, 0.0))) == pytest.approx(0.2126)
    halves = Material(pattern="wood", colour=(0.2, 0.2, 0.2), second_colour=(0.4, 0.4, 0.4))
    assert reflectance(halves) == pytest.approx(0.3)
