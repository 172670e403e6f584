"""Apartments as GeoJSON and back."""

import json

import numpy as np
import pytest
import shapely
from shapely import Polygon

from scenes import (
    apartment_from_json,
    apartment_to_json,
    generate_apartment,
    load_apartment,
    obstacles,
    reference_names,
    room_borders,
)
from scenes.apartment import Block
from scenes.errors import SceneError
from scenes.exporters.geojson import apartment_geojson, write_geojson
from scenes.importers.geojson import read_geojson
from test_scenes.places import turned, two_rooms

CENTIMETRE = 0.01


def back(apartment, tmp_path):
    path = tmp_path / "home.geojson"
    write_geojson(apartment, path)
    result = read_geojson(path)
    assert result.notes == ()
    return result.apartment


def assert_same_place(found, expected, tolerance):
    assert [r.name for r in found.rooms] == [r.name for r in expected.rooms]
    for a, b in zip(found.rooms, expected.rooms, strict=True):
        assert Polygon(a.polygon).hausdorff_distance(Polygon(b.polygon)) <= tolerance
    np.testing.assert_allclose(room_borders(found), room_borders(expected), atol=tolerance)
    there, here = obstacles(found), obstacles(expected)
    assert there.difference(here.buffer(tolerance)).is_empty
    assert here.difference(there.buffer(tolerance)).is_empty


@pytest.mark.parametrize("name", reference_names())
def test_reference_places_come_back_as_they_were(name, tmp_path):
    place = load_apartment(name)
    found = back(place, tmp_path)
    assert_same_place(found, place, CENTIMETRE)
    # Not only the outlines: materials, frames, lamps, light and furniture too.
    for field in ("passages", "windows", "furniture", "lamps", "materials", "lighting", "start"):
        assert getattr(found, field) == getattr(place, field), field
    for a, b in zip(found.rooms, place.rooms, strict=True):
        assert a.model_dump(exclude={"polygon"}) == b.model_dump(exclude={"polygon"})


@pytest.mark.parametrize("seed", [1, 5, 8])
def test_generated_apartments_come_back(seed, tmp_path):
    place = generate_apartment(seed)
    assert_same_place(back(place, tmp_path), place, CENTIMETRE)


def test_a_turned_place_comes_back_within_a_centimetre(tmp_path):
    place = turned(two_rooms(), 33.0, (2.0, -1.0))
    assert_same_place(back(place, tmp_path), place, CENTIMETRE)


def test_layers_are_valid_geojson():
    block = Block(polygon=((1, 1), (2, 1), (2, 2), (1, 2)), bottom=2.0, material="wood")
    place = two_rooms().model_copy(update={"blocks": (block,), "description": "ä <b>"})
    data = json.loads(json.dumps(apartment_geojson(place)))
    assert data["type"] == "FeatureCollection"
    assert data["apartment"]["description"] == "ä <b>"
    layers = [f["properties"]["layer"] for f in data["features"]]
    assert layers == ["room"] * 2 + ["wall"] * 5 + ["block", "door", "start"]
    for item in data["features"]:
        shape = shapely.from_geojson(json.dumps(item["geometry"]))
        assert shape.is_valid
        if shape.geom_type == "Polygon":
            assert shape.exterior.is_ccw  # RFC 7946
    door = data["features"][-2]
    np.testing.assert_allclose(sorted(door["geometry"]["coordinates"]), [[4.05, 1.1], [4.05, 1.9]])


def test_the_writer_is_deterministic_and_leaves_no_half_file(tmp_path):
    place = apartment_from_json(apartment_to_json(two_rooms()))
    for name in ("a", "b"):
        write_geojson(place, tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    with pytest.raises(SceneError, match="cannot be written"):
        write_geojson(place, tmp_path / "no" / "folder.geojson")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a", "b"]
