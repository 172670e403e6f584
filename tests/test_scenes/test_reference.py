"""The reference places against Table 8 and against what homes are like."""

from __future__ import annotations

import json
from importlib import resources

import numpy as np
import pytest
import shapely
from scipy import ndimage
from shapely import Polygon

from scenes.apartment import Apartment
from scenes.checks import check
from scenes.materials import resolve
from scenes.passages import passage_rooms
from scenes.solids import building_region, floor_region, obstacles
from scenes.storage import apartment_from_json, apartment_to_json, load_apartment, reference_names

# name: rooms, area (m²), tolerance, map nodes, contrast, lighting (Table 8; demos: their brief)
PLACES = {
    "sim3": (5, 51.0, 0.02, 787, "low", "exterior"),
    "sim4": (5, 46.0, 0.02, 783, "medium", "exterior"),
    "real3": (2, 40.0, 0.05, 649, "high", "exterior"),
    "demo1": (3, 16.0, 0.15, 240, "medium", "exterior"),
    "demo2": (4, 16.0, 0.16, 240, "high", "interior"),
    "demo3": (3, 16.0, 0.15, 240, "low", "mixed"),
}
NODE_AREA = 0.1 * 0.3
RADIUS = 0.15


@pytest.fixture(params=sorted(PLACES))
def place(request: pytest.FixtureRequest) -> Apartment:
    return load_apartment(request.param)


def text_of(name: str) -> str:
    file = resources.files("scenes").joinpath("reference", f"{name}.json")
    return file.read_text(encoding="utf-8")


def driven_floor(apartment: Apartment, radius: float = RADIUS, step: float = 0.02):
    """Cells that the robot's centre reaches, by distance transform and flood fill."""
    floor = floor_region(apartment)
    x0, y0, x1, y1 = floor.bounds
    xs, ys = np.arange(x0, x1 + step, step), np.arange(y0, y1 + step, step)
    x, y = np.meshgrid(xs, ys)
    solid = shapely.union_all([*obstacles(apartment).geoms])
    free = shapely.contains_xy(floor, x, y) & ~shapely.contains_xy(solid, x, y)
    wide = ndimage.distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1] * step >= radius
    labels, _ = ndimage.label(wide, structure=np.ones((3, 3)))
    spot = np.argmin(np.hypot(x - apartment.start.position[0], y - apartment.start.position[1]))
    assert labels.flat[spot] > 0, "the start is not free"
    return x, y, labels == labels.flat[spot]


def luminance(apartment: Apartment, name: str) -> float:
    return float(np.dot(resolve(apartment, name).colour, (0.2126, 0.7152, 0.0722)))


def test_the_promised_places_are_there() -> None:
    assert set(PLACES) <= set(reference_names())


@pytest.mark.parametrize("name", reference_names())
def test_every_file_is_a_valid_apartment_of_its_name(name: str) -> None:
    apartment = load_apartment(name)
    assert apartment.name == name
    assert apartment.description
    assert list(check(apartment)) == []


@pytest.mark.parametrize("name", reference_names())
def test_files_are_canonical(name: str) -> None:
    text = text_of(name)
    apartment = apartment_from_json(text, origin=name)
    assert apartment_from_json(apartment_to_json(apartment)) == apartment
    data = json.loads(text)
    assert list(data) == [field for field in Apartment.model_fields if field in data]
    assert text.endswith("}\n")
    assert not text.endswith("\n\n")
    lines = {line.strip().rstrip(",") for line in text.splitlines()}
    for field in ("rooms", "walls", "passages", "windows", "furniture", "lamps"):
        for item in data.get(field, []):
            assert json.dumps(item, ensure_ascii=False) in lines, "one thing per line"


def test_table_8(place: Apartment) -> None:
    rooms, area, tolerance, _, contrast, lighting = PLACES[place.name]
    assert len(place.rooms) == rooms
    total = sum(Polygon(room.polygon).area for room in place.rooms)
    assert total == pytest.approx(area, rel=tolerance)
    assert place.passageway_contrast == contrast
    assert place.lighting.source == lighting


def test_floor_to_drive_gives_about_the_papers_nodes(place: Apartment) -> None:
    nodes = PLACES[place.name][3]
    _, _, driven = driven_floor(place)
    assert driven.sum() * 0.02**2 / NODE_AREA == pytest.approx(nodes, rel=0.2)


def test_every_room_has_floor_to_drive(place: Apartment) -> None:
    x, y, driven = driven_floor(place)
    for room in place.rooms:
        inside = shapely.contains_xy(Polygon(room.polygon), x, y) & driven
        assert inside.sum() * 0.02**2 > 0.4, room.name


def test_passages_are_half_a_metre_clear(place: Apartment) -> None:
    x, y, driven = driven_floor(place, radius=0.25)
    for room in place.rooms:
        assert (shapely.contains_xy(Polygon(room.polygon), x, y) & driven).any(), room.name


def test_rooms_are_joined_by_passages_only(place: Apartment) -> None:
    shapes = [Polygon(room.polygon) for room in place.rooms]
    for k, shape in enumerate(shapes):
        for other in shapes[:k]:
            assert shape.distance(other) >= 0.1 - 1e-9
    joined = [set(passage_rooms(place, p)) for p in place.passages if not p.closed]
    reached = {0}
    for _ in shapes:
        reached |= {room for pair in joined if pair & reached for room in pair}
    assert reached == set(range(len(shapes)))
    assert len(joined) == len(shapes) - 1


def test_no_bathroom_is_a_way_through(place: Apartment) -> None:
    pairs = [passage_rooms(place, p) for p in place.passages if not p.closed]
    for index, room in enumerate(place.rooms):
        if room.kind == "bathroom":
            assert sum(index in pair for pair in pairs) == 1


def test_measures_are_those_of_homes(place: Apartment) -> None:
    assert {wall.thickness <= 0.15 or 0.25 <= wall.thickness <= 0.3 for wall in place.walls} == {
        True
    }
    assert all(wall.thickness >= 0.1 for wall in place.walls)
    for passage in place.passages:
        assert passage.frame is not None
        assert 0.75 <= passage.width <= 0.95
        if not passage.closed:
            assert passage.lintel_height is not None
            assert 1.98 <= passage.lintel_height <= 2.05
    assert all(2.45 <= room.ceiling_height <= 2.7 for room in place.rooms)
    assert sum(passage.closed for passage in place.passages) == 1


def test_bathrooms_and_kitchens_are_fitted(place: Apartment) -> None:
    for room in place.rooms:
        shape = Polygon(room.polygon)
        kinds = [p.kind for p in place.furniture if shape.covers(shapely.Point(p.position))]
        if room.kind == "bathroom":
            assert {"toilet", "basin"} <= set(kinds)
            assert {"bath", "shower_tray"} & set(kinds)
        if room.kind == "bedroom":
            assert {"bed", "wardrobe"} <= set(kinds)
    fitted = {piece.kind for piece in place.furniture}
    assert "kitchen_counter" in fitted or place.name == "demo2"


def test_light_reaches_every_room(place: Apartment) -> None:
    windows = [shapely.Point(window.position) for window in place.windows]
    outline = shapely.union_all(
        [part.exterior for part in shapely.get_parts(building_region(place))]
    )
    for room in place.rooms:
        shape = Polygon(room.polygon)
        assert any(shape.covers(shapely.Point(lamp.position)) for lamp in place.lamps), room.name
        facade = outline.intersection(shape.buffer(0.32, cap_style="flat", join_style="mitre"))
        if facade.length > 2.2:
            assert any(shape.distance(window) < 0.2 for window in windows), room.name


def test_frames_stand_out_as_the_contrast_says(place: Apartment) -> None:
    differences = []
    for passage in place.passages:
        assert passage.frame is not None
        for index in passage_rooms(place, passage):
            if index is not None:
                wall = luminance(place, place.rooms[index].walls)
                differences.append(abs(luminance(place, passage.frame.material) - wall))
    low, high = {"low": (0.0, 0.05), "medium": (0.08, 0.35), "high": (0.4, 1.0)}[
        place.passageway_contrast
    ]
    assert low <= np.median(differences) <= high


def test_floors_and_walls_differ_between_places() -> None:
    looks = set()
    for name in PLACES:
        apartment = load_apartment(name)
        assert len({room.floor for room in apartment.rooms}) >= 2
        assert len({room.walls for room in apartment.rooms}) >= 2
        looks.add(tuple(sorted((r.floor, r.walls, r.ceiling) for r in apartment.rooms)))
    assert len(looks) == len(PLACES)


def test_sim4_has_a_narrow_opening_beside_a_chair_in_its_largest_room() -> None:
    """Fig. 24: the lower-left room nearly falls into two at a chair."""
    place = load_apartment("sim4")
    largest = max(place.rooms, key=lambda room: Polygon(room.polygon).area)
    shape = Polygon(largest.polygon)
    assert shape.bounds[:2] == building_floor_corner(place)
    free = shape.difference(obstacles(place))

    def parts(radius: float) -> int:
        pieces = shapely.get_parts(free.buffer(-radius))
        return sum(piece.area > 0.5 for piece in pieces)

    assert parts(0.26) == 1
    assert parts(0.35) == 2
    chair = next(p for p in place.furniture if p.kind == "armchair")
    assert chair.size is not None
    gap = shape.bounds[2] - chair.position[0] - chair.size[0] / 2
    assert 0.5 <= gap <= 0.7


def building_floor_corner(place: Apartment) -> tuple[float, float]:
    x0, y0, _, _ = floor_region(place).bounds
    return x0, y0


def test_sim4_has_a_small_room_near_the_top() -> None:
    place = load_apartment("sim4")
    top = floor_region(place).bounds[3]
    areas = {room.name: Polygon(room.polygon).area for room in place.rooms}
    uppermost = [room for room in place.rooms if Polygon(room.polygon).bounds[3] > top - 0.1]
    assert any(areas[room.name] < 0.15 * sum(areas.values()) for room in uppermost)
