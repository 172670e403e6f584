"""The SVG plan: well-formed, to scale, complete, the same every time."""

import re

import numpy as np
import pytest
from defusedxml import ElementTree
from shapely import Polygon

from scenes import floor_area, load_apartment
from scenes.exporters.svg import apartment_svg, write_svg
from test_scenes.places import OUTER, two_rooms

NAMES = {"svg": "http://www.w3.org/2000/svg"}


def paths(text, group):
    """Polygons (mm) of the paths in a group, by their outer rings."""
    root = ElementTree.fromstring(text.encode())
    found = []
    for item in root.findall(f"svg:g[@id='{group}']/svg:path", NAMES):
        rings = [
            np.array(re.findall(r"(-?[\d.]+),(-?[\d.]+)", ring), dtype=float)
            for ring in item.get("d").split("Z")
            if ring.strip()
        ]
        found.append(Polygon(rings[0], rings[1:]))
    return found


def test_rooms_and_walls_are_to_scale():
    text = apartment_svg(two_rooms())
    assert "Plan 1:50;" in text
    rooms = [room.area for room in paths(text, "rooms")]
    # 1:50: a metre is 20 mm.
    assert rooms == pytest.approx([12 * 400, 9 * 400])
    doorway = 0.1 * 0.8
    walls = sum(wall.area for wall in paths(text, "walls"))
    assert walls == pytest.approx((OUTER - 21 - doorway) * 400, rel=1e-3)
    root = ElementTree.fromstring(text.encode())
    assert root.get("width") == "166mm"  # 7.5 m and two margins of 8 mm
    assert root.get("viewBox").split()[2:] == ["166", root.get("height")[:-2]]


def test_y_is_up_in_the_apartment_and_down_on_paper():
    text = apartment_svg(two_rooms(rooms=two_rooms().model_dump()["rooms"]))
    left, right = paths(text, "rooms")
    assert left.bounds[0] == pytest.approx(8 + 0.2 * 20)
    assert right.bounds[0] == pytest.approx(8 + 4.3 * 20)


@pytest.mark.parametrize("name", ["sim4", "demo1"])
def test_everything_is_on_the_plan(name):
    place = load_apartment(name)
    text = apartment_svg(place)
    root = ElementTree.fromstring(text.encode())
    for group, count in (
        ("rooms", len(place.rooms)),
        ("furniture", len(place.furniture)),
        ("lamps", len(place.lamps)),
        ("windows", 2 * len(place.windows)),
        ("labels", len(place.rooms)),
    ):
        found = list(root.find(f"svg:g[@id='{group}']", NAMES))
        assert len(found) == count, group
    sills = [p for p in place.passages if p.threshold is not None]
    assert len(root.findall("svg:g[@id='doors']/svg:path[@class='threshold']", NAMES)) == len(sills)
    kinds = [i.get("data-kind") for i in root.findall("svg:g[@id='furniture']/svg:path", NAMES)]
    assert sorted(kinds) == sorted(piece.kind for piece in place.furniture)
    areas = re.findall(r"([\d.]+) m²", text)
    assert sum(map(float, areas)) == pytest.approx(floor_area(place), abs=0.05 * len(areas))


def test_large_places_get_a_smaller_scale():
    data = two_rooms().model_dump()
    rooms = [
        {"name": "a", "polygon": [[0, 0], [22, 0], [22, 3], [0, 3]]},
        {"name": "b", "polygon": [[22.1, 0], [30, 0], [30, 3], [22.1, 3]]},
    ]
    data["rooms"] = rooms
    assert "Plan 1:100;" in apartment_svg(two_rooms(rooms=rooms, passages=[]))


def test_names_are_escaped_and_bytes_are_the_same(tmp_path):
    place = load_apartment("sim4").model_copy(update={"name": "a.b-c"})
    for name in ("one.svg", "two.svg"):
        write_svg(place, tmp_path / name)
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()
    assert b"<title>a.b-c</title>" in (tmp_path / "one.svg").read_bytes()
