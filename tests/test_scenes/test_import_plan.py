"""Floor plans of every format as apartments: what is made of them, and what is said."""

import json
from pathlib import Path

import numpy as np
import pytest
import shapely
from shapely import Point, Polygon

from scenes import SceneError, check, floor_area, room_borders
from scenes.importers.cubicasa import read_cubicasa
from scenes.importers.geojson import read_geojson
from scenes.importers.houseexpo import read_houseexpo
from scenes.importers.r2v import read_r2v
from scenes.importers.resplan import read_resplan
from scenes.passages import ROBOT_RADIUS, free_region, passage_rooms

DATA = Path(__file__).parent / "data"
SHARED = Path(__file__).parents[3] / "shared" / "data"

FORMATS = {
    "geojson": (read_geojson, DATA / "flat.geojson", None),
    "cubicasa": (read_cubicasa, DATA / "flat_cubicasa.svg", 0.0095),
    "houseexpo": (read_houseexpo, DATA / "flat_houseexpo.json", None),
    "r2v": (read_r2v, DATA / "flat_r2v.txt", 0.02),
}


def area_of(apartment, name):
    return Polygon(next(r.polygon for r in apartment.rooms if r.name == name)).area


def joined(apartment):
    """Pairs of room names that the open passages join."""
    pairs = set()
    for passage in apartment.passages:
        sides = passage_rooms(apartment, passage)
        if not passage.closed:
            pairs.add(frozenset(apartment.rooms[i].name for i in sides))
    return pairs


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_gives_a_place_that_the_robot_can_clean(name):
    reader, path, scale = FORMATS[name]
    apartment = reader(path, scale=scale).apartment
    assert list(check(apartment)) == []
    spot = Point(apartment.start.position)
    free = shapely.get_parts(free_region(apartment, ROBOT_RADIUS))
    home = next(part for part in free if part.intersects(spot))
    assert all(home.intersects(Polygon(room.polygon)) for room in apartment.rooms)


def test_every_room_has_a_lamp_where_the_plan_has_none():
    apartment = read_r2v(DATA / "flat_r2v.txt", scale=0.02).apartment
    assert apartment.lighting.source == "mixed"
    for room in apartment.rooms:
        assert any(Polygon(room.polygon).contains(Point(x.position)) for x in apartment.lamps)
    assert read_houseexpo(DATA / "flat_houseexpo.json").apartment.lighting.source == "interior"


# ---- GeoJSON --------------------------------------------------------------------------------


def test_geojson_flat():
    result = read_geojson(DATA / "flat.geojson")
    apartment = result.apartment
    assert apartment.name == "flat"
    # The kitchen lies in the living room's polygon: the smaller keeps the floor.
    assert area_of(apartment, "living") == pytest.approx(4 * 3)
    assert area_of(apartment, "kitchen") == pytest.approx(4 * 2)
    assert [room.name for room in apartment.rooms] == ["living", "kitchen", "bath"]
    assert apartment.rooms[1].floor == "tiles_white"
    assert apartment.rooms[2].ceiling_height == 2.3
    # They are open to one another.
    np.testing.assert_allclose(sorted(apartment.borders[0]), [(0, 3), (4, 3)], atol=1e-6)
    assert joined(apartment) == {frozenset({"living", "bath"})}
    door = next(p for p in apartment.passages if not p.closed)
    assert (door.width, door.lintel_height) == (0.8, 2.0)
    np.testing.assert_allclose(door.position, (4.05, 1.4), atol=1e-3)
    assert sum(p.closed for p in apartment.passages) == 1
    assert [w.sill_height for w in apartment.windows] == [0.8]
    assert [p.kind for p in apartment.furniture] == ["bath"]
    assert apartment.furniture[0].size[:2] == pytest.approx((1.7, 0.775), abs=0.02)
    assert apartment.furniture[0].rotation_deg % 360 == 0  # its back at the wall above it
    assert apartment.start.position == (1, 1)
    assert apartment.start.heading_deg == 90


def test_geojson_says_what_it_left_out():
    notes = "\n".join(read_geojson(DATA / "flat.geojson").notes)
    assert "features[1] (room) 'kitchen'" not in notes
    assert "'living' overlaps 'kitchen' by 8 m²" in notes
    assert "features[10] (furniture): 'spaceship' is no kind of furniture; left out" in notes
    assert "features[11]: layer 'garden'; expected one of room, wall" in notes
    assert "features[3] (room) 'cellar': no open way for a robot of 0.15 m radius" in notes
    assert "features[7] (door): joins 'living' and no other room; made closed" in notes


def test_missing_doors_are_added_only_if_asked_for():
    result = read_geojson(DATA / "flat.geojson", add_doors=True)
    assert "cellar" in [room.name for room in result.apartment.rooms]
    assert any("a door to 'cellar': added" in note for note in result.notes)
    assert list(check(result.apartment)) == []


def test_furniture_is_optional_and_start_can_be_chosen():
    result = read_geojson(DATA / "flat.geojson", furnish=False, start=(5, 1), ceiling_height=2.8)
    assert result.apartment.furniture == ()
    assert result.apartment.start.position == (5, 1)
    assert result.apartment.rooms[0].ceiling_height == 2.8


def feature(layer, shape, coordinates, **properties):
    return {
        "type": "Feature",
        "properties": {"layer": layer, **properties},
        "geometry": {"type": shape, "coordinates": coordinates},
    }


def box(x0, y0, x1, y1):
    return [[[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]]]


def collection(tmp_path, *features, **members):
    import json

    path = tmp_path / "plan.geojson"
    data = {"type": "FeatureCollection", "features": list(features), **members}
    path.write_text(json.dumps(data))
    return path


def test_touching_rooms_without_any_wall_meet_in_the_middle_of_one(tmp_path):
    path = collection(
        tmp_path,
        feature("room", "Polygon", box(0, 0, 3, 3), name="a"),
        feature("room", "Polygon", box(3, 0, 6, 3), name="b"),
        feature("door", "LineString", [[3, 1], [3, 1.9]]),
    )
    apartment = read_geojson(path).apartment
    assert apartment.borders == ()
    # 12 cm of wall, half from each.
    assert area_of(apartment, "a") == pytest.approx((3 - 0.06) * 3, abs=0.01)
    assert joined(apartment) == {frozenset({"a", "b"})}


def test_rooms_a_few_centimetres_apart_are_open_to_each_other(tmp_path):
    path = collection(
        tmp_path,
        feature("room", "Polygon", box(0, 0, 3, 3), name="a"),
        feature("room", "Polygon", box(3.04, 0, 6, 3), name="b"),
        feature("wall", "LineString", [[-0.1, -0.1], [6.1, -0.1]], thickness=0.2),
    )
    apartment = read_geojson(path).apartment
    assert len(room_borders(apartment)) == 1
    assert floor_area(apartment) == pytest.approx(18)
    assert free_region(apartment, ROBOT_RADIUS).geom_type == "Polygon"


def test_a_room_around_another_is_cut_and_an_island_is_masonry(tmp_path):
    path = collection(
        tmp_path,
        feature("room", "Polygon", [*box(0, 0, 8, 8), *box(1, 5, 1.5, 5.5)], name="hall"),
        feature("room", "Polygon", box(3, 3, 5, 5), name="pod"),
        feature("wall", "Polygon", [*box(2.9, 2.9, 5.1, 5.1), *box(3, 3, 5, 5)]),
        feature("door", "LineString", [[3.5, 2.95], [4.3, 2.95]]),
    )
    result = read_geojson(path)
    assert sorted(r.name for r in result.apartment.rooms) == ["hall", "hall_2", "pod"]
    expected = 64 - 0.25 - (2.2**2 - 2.0**2)
    assert floor_area(result.apartment) == pytest.approx(expected, abs=0.01)
    assert any("a second part of 'hall'" in note for note in result.notes)


def test_slanted_plan(tmp_path):
    turn = np.array([[np.cos(0.3), np.sin(0.3)], [-np.sin(0.3), np.cos(0.3)]])

    def turned(points):
        return (np.array(points, dtype=float) @ turn).tolist()

    path = collection(
        tmp_path,
        feature("room", "Polygon", [turned(box(0, 0, 3, 3)[0])], name="a"),
        feature("room", "Polygon", [turned(box(3, 1, 6, 2.5)[0])], name="b"),
        feature("room", "Polygon", [turned(box(6.1, 1, 9, 2.5)[0])], name="c"),
        feature("wall", "LineString", turned([[6.05, 1], [6.05, 2.5]]), thickness=0.1),
        feature("door", "LineString", turned([[6.05, 1.2], [6.05, 2.0]])),
    )
    apartment = read_geojson(path).apartment
    assert [room.name for room in apartment.rooms] == ["a", "b", "c"]
    assert list(check(apartment)) == []
    assert floor_area(apartment) == pytest.approx(9 + 4.5 + 2.9 * 1.5, abs=0.02)


# ---- CubiCasa, HouseExpo, ResPlan, R2V -------------------------------------------------------


def test_cubicasa_flat():
    result = read_cubicasa(DATA / "flat_cubicasa.svg", scale=0.01, name="svg")
    apartment = result.apartment
    assert {r.name: r.kind for r in apartment.rooms} == {
        "living_room": "living_room",
        "kitchen": "kitchen",
        "bath": "bathroom",
        "entry": "corridor",
    }
    assert area_of(apartment, "bath") == pytest.approx(3.88 * 2.2, abs=0.01)
    assert joined(apartment) == {frozenset({"living_room", "entry"}), frozenset({"entry", "bath"})}
    pieces = {p.kind: p for p in apartment.furniture}
    # Two transforms and the flip of y: 5.2 m down the page is y = 0.
    np.testing.assert_allclose(pieces["toilet"].position, (4.6, 6 - 0.54), atol=0.01)
    assert pieces["toilet"].rotation_deg % 360 == pytest.approx(0)
    assert any("Space Outdoor" in note and "left out" in note for note in result.notes)
    assert any("Railing 1: not used" in note for note in result.notes)


def test_cubicasa_transforms(tmp_path):
    text = (DATA / "flat_cubicasa.svg").read_text()
    moved = text.replace('class="Model v1-1"', 'transform="matrix(0,2,-2,0,7,9) scale(.5 .5)"')
    path = tmp_path / "flat.svg"
    path.write_text(moved)
    plain = read_cubicasa(DATA / "flat_cubicasa.svg", scale=0.01).apartment
    turned = read_cubicasa(path, scale=0.01).apartment
    assert floor_area(turned) == pytest.approx(floor_area(plain), abs=0.02)
    path.write_text(text.replace('class="Model v1-1"', 'transform="skewX(10)"'))
    with pytest.raises(SceneError, match=r"transform 'skewX\(10\)'; expected matrix"):
        read_cubicasa(path, scale=0.01)


def test_cubicasa_fixtures_without_a_boundary(tmp_path):
    sink = """<g class="FixedFurniture ElectricalAppliance WashingMachine"
        transform="translate(20 400)">
        <g class="Part"><rect x="10" y="5" width="30" height="60"/></g>
        <g class="Part"><rect x="20" width="50" height="20"/></g></g>"""
    path = tmp_path / "flat.svg"
    text = (DATA / "flat_cubicasa.svg").read_text()
    path.write_text(text.replace('<g class="Railing">', sink + '<g class="Railing">'))
    pieces = read_cubicasa(path, scale=0.01).apartment.furniture
    machine = next(piece for piece in pieces if piece.kind == "washing_machine")
    # The box around both parts: 10 to 70 by 0 to 65 px, pushed to the wall 10 px to its left.
    np.testing.assert_allclose(sorted(machine.size[:2]), (0.6, 0.65), atol=0.01)
    np.testing.assert_allclose(machine.position, (0.505, 6 - 4.325), atol=0.01)


def test_houseexpo_rooms_are_cut_at_doorways_and_by_boxes():
    result = read_houseexpo(DATA / "flat_houseexpo.json")
    apartment = result.apartment
    assert {r.name: r.kind for r in apartment.rooms} == {
        "bathroom": "bathroom",
        "kitchen": "kitchen",
        "living_room": "living_room",
    }
    # The doorway is in the wall at x = 3.9 to 4.0; the kitchen's box is the smaller.
    assert area_of(apartment, "bathroom") == pytest.approx(3.9 * 4, abs=0.1)
    assert area_of(apartment, "kitchen") == pytest.approx(2.0 * 4, abs=0.1)
    assert result.notes == ("room_category Garage[0]: names no room; left out",)
    over_doorway = [b for b in apartment.blocks if b.bottom == 2.0]
    assert len(over_doorway) == 1


def test_resplan_flat():
    path = DATA / "flat_resplan.json"
    with pytest.raises(SceneError, match="has 2 plans; expected --plan with one of 3, 4"):
        read_resplan(path)
    with pytest.raises(SceneError, match=r"such as 0.04 \(doors would be 0.80 m wide\)"):
        read_resplan(path, plan="3")
    result = read_resplan(path, plan="3", scale=0.05)
    apartment = result.apartment
    assert apartment.name == "flat_resplan_3"
    assert area_of(apartment, "kitchen") == pytest.approx(4 * 2)
    assert area_of(apartment, "living") == pytest.approx(4 * 3)
    assert joined(apartment) == {frozenset({"living", "bedroom"})}
    assert [p.closed for p in apartment.passages] == [False, True]
    assert apartment.windows[0].width == pytest.approx(1.5)
    assert any("balcony[0]: outside" in note for note in result.notes)
    assert list(check(apartment)) == []


def test_r2v_flat():
    result = read_r2v(DATA / "flat_r2v.txt", scale=0.02)
    apartment = result.apartment
    assert {r.name: r.kind for r in apartment.rooms} == {
        "bedroom": "bedroom",
        "bathroom": "bathroom",
        "corridor": "corridor",
    }
    # Centre lines 4 by 6 m apart, walls of 12 cm.
    assert area_of(apartment, "bedroom") == pytest.approx(3.88 * 5.88, abs=1e-3)
    assert joined(apartment) == {
        frozenset({"bedroom", "corridor"}),
        frozenset({"corridor", "bathroom"}),
    }
    assert [p.kind for p in apartment.furniture] == ["bath", "toilet", "basin"]
    assert len(apartment.windows) == 1
    assert sum(p.closed for p in apartment.passages) == 1  # the door at the entrance
    notes = "\n".join(result.notes)
    assert "line 15 (entrance): in one room with line 14 (corridor)" in notes
    assert "line 19 (balcony): in no room that walls enclose; left out" in notes
    assert "line 20 (special): not used; left out" in notes


R2V = """
10 10 410 10 wall
410 10 410 310 wall
10 310 410 310 wall
10 10 10 310 wall
10 150 410 150 wall
370 10 370 50 wall
370 50 410 50 wall
200 150 240 150 door
300 10 345 10 door
60 310 140 310 door
370 15 370 45 door
200 130 240 148 entrance
100 200 140 215 bedroom
"""


def test_r2v_the_outer_door_nearest_to_the_entrance_is_closed(tmp_path):
    path = tmp_path / "plan.txt"
    path.write_text(R2V.strip())
    result = read_r2v(path, scale=0.02)
    apartment = result.apartment
    assert joined(apartment) == {frozenset({"entrance", "bedroom"})}
    # 310 px down is y = 0: the front door is in the wall at the top.
    doors = [p.position for p in apartment.passages if p.closed and p.position[1] > 5.9]
    np.testing.assert_allclose(doors, [(6.25, 6.0)], atol=0.02)
    # The door of the closet, too small for a room, is no window.
    assert [w.position for w in apartment.windows] == [pytest.approx((1.8, 0.0), abs=0.02)]
    assert sum("an unlabelled room" in note for note in result.notes) == 1


def test_openings_are_called_as_in_the_file(tmp_path):
    path = tmp_path / "plan.txt"
    path.write_text(R2V.strip() + "\n210 150 235 150 door")
    notes = read_r2v(path, scale=0.02).notes
    assert "line 14 (door): the opening overlaps line 8 (door); expected wall between them; " in (
        "\n".join(notes)
    )
    assert not any("passages[" in note for note in notes)


def test_names_that_no_room_can_have_are_told(tmp_path):
    room = feature("room", "Polygon", box(0, 0, 4, 4), name="Küche 1")
    result = read_geojson(collection(tmp_path, room))
    assert [r.name for r in result.apartment.rooms] == ["K_che_1"]
    said = "features[0] (room) 'Küche 1': 'Küche 1' is no name for a room; called 'K_che_1'"
    assert said in result.notes
    path = tmp_path / "expo.json"
    path.write_text('{"verts": [[0,0],[4,0],[4,3],[0,3]], "room_category": {"Küche": [[0,0,4,3]]}}')
    said = "room_category Küche[0]: 'küche' is no name for a room; called 'k_che'"
    assert said in read_houseexpo(path).notes


def test_a_room_without_a_door_names_the_remedy(tmp_path):
    rooms = [feature("room", "Polygon", box(*b)) for b in ((0, 0, 4, 4), (4.1, 0, 6.1, 3))]
    far = feature("room", "Polygon", box(20, 0, 22, 3))
    wall = feature("wall", "LineString", [[4.05, 0], [4.05, 4]], thickness=0.1)
    path = collection(tmp_path, *rooms, far, wall)
    remedy = [
        n for n in read_geojson(path).notes if n.endswith("(--add-doors would open a door to it)")
    ]
    assert [note.split(" ")[0] for note in remedy] == ["features[1]"]
    apart = [n for n in read_geojson(path, add_doors=True).notes if "--add-doors" in n]
    assert apart == []


def test_geojson_without_layers(tmp_path):
    plain = {"type": "Feature", "properties": {"name": "a"}, "geometry": None}
    line = fails(read_geojson, collection(tmp_path, plain, {**plain, "properties": None}))
    assert "no feature has a property 'layer'; expected one in each" in line
    assert "room, wall, door" in line
    good = feature("room", "Polygon", box(0, 0, 4, 4))
    notes = read_geojson(collection(tmp_path, good, plain)).notes
    assert notes[0].startswith("features[1]: no property 'layer'; expected one of room, wall")


def test_what_only_maps_have_is_passed_over(tmp_path):
    """Rooms as `roomseg export` writes them of a map, with the ground truth's borders."""
    own = {"name": "hall", "room": 0, "nodes": 9, "area": 16.0}
    room = feature("room", "Polygon", box(0, 0, 4, 4), **own)
    drawn = feature("drawn_border", "LineString", [[0, 0], [1, 1]])
    path = collection(tmp_path, room, *[drawn] * 5)
    notes = read_geojson(path).notes
    assert [note for note in notes if "drawn_border" in note] == [
        "features[1], features[2], features[3] and 2 more: layer 'drawn_border'; expected one of "
        "room, wall, door, window, furniture, block, border, lamp, start; left out"
    ]
    assert any("unknown properties 'room', 'nodes', 'area'" in note for note in notes)
    data = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps(data | {"map": {"environment": "x"}}), encoding="utf-8")
    assert [n for n in read_geojson(path).notes if "drawn_border" in n or "unknown" in n] == []


def test_many_names_that_cannot_be_are_one_line(tmp_path):
    rooms = [
        feature("room", "Polygon", box(4 * k, 0, 4 * k + 4, 4), name=f"segment {k}")
        for k in range(5)
    ]
    few, many = (read_geojson(collection(tmp_path, *rooms[:n])).notes for n in (3, 5))
    assert len([note for note in few if "is no name for a room" in note]) == 3
    assert [note for note in many if "is no name for a room" in note] == [
        "features[0] (room) 'segment 0': 'segment 0' is no name for a room; called 'segment_0'; "
        "4 more likewise"
    ]


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ('{"features": [{"type": "Fea', "in line 1: the file is damaged or cut off"),
        ('{"features": [\n{"a": 1.', "in line 2: the file is damaged or cut off"),
        ('{"features": [\n\ntr', "in line 3: the file is damaged or cut off"),
        ('{"features": [\n', "in line 1: the file is damaged or cut off"),
        ('{"features": [}', "line 1, column 15: not JSON: Expecting value; expected a GeoJSON"),
        ("hello", "line 1, column 1: not JSON: Expecting value; expected a GeoJSON"),
    ],
)
def test_json_that_was_cut_off_is_told_from_what_is_none(tmp_path, text, line):
    path = tmp_path / "plan.geojson"
    path.write_text(text, encoding="utf-8")
    told = fails(read_geojson, path)
    assert line in told and ("expected a GeoJSON" in told) == ("not JSON" in told)


def test_json_is_known_as_cut_off_wherever_it_was_cut(tmp_path):
    whole = '{"a": [true, null, -1.5e-3, 2E+7], "b\\u00fc": {"c\\n": "d", "e": false}}'
    json.loads(whole)
    path = tmp_path / "plan.geojson"
    for end in range(1, len(whole)):
        path.write_text(whole[:end], encoding="utf-8")
        assert "damaged or cut off" in fails(read_geojson, path), whole[:end]


def test_our_own_svg_is_not_for_reading(tmp_path):
    from scenes import load_apartment
    from scenes.exporters.svg import write_svg

    path = tmp_path / "home.svg"
    write_svg(load_apartment("demo1"), path)
    line = fails(read_cubicasa, path, scale=0.01)
    assert "SVG plans are for looking at only; expected a .geojson" in line


# ---- one clear line -------------------------------------------------------------------------

SCALE_ASKED = {
    "flat_cubicasa.svg": (read_cubicasa, r"such as 0.00941 \(doors would be 0.80 m wide\)"),
    "flat_r2v.txt": (read_r2v, r"such as 0.0187 \(most doors would be 0.80 m wide\)"),
}


@pytest.mark.parametrize("file", SCALE_ASKED)
def test_a_scale_is_asked_for(file):
    reader, hint = SCALE_ASKED[file]
    with pytest.raises(SceneError, match=rf"{file}: has no scale; expected --scale .*{hint}"):
        reader(DATA / file)


def fails(reader, path, **options):
    """The line that a reader ends in; it is one line and names the file."""
    with pytest.raises(SceneError) as error:
        reader(path, **options)
    line = str(error.value)
    assert "\n" not in line
    assert line.startswith(str(path))
    return line


READERS = [read_geojson, read_cubicasa, read_houseexpo, read_r2v, read_resplan]


@pytest.mark.parametrize("reader", READERS)
def test_nonsense_is_one_line(tmp_path, reader):
    path = tmp_path / "nonsense"
    assert "cannot be read" in fails(reader, path, scale=0.01)
    path.write_bytes(b"")
    assert "empty" in fails(reader, path, scale=0.01)
    path.write_bytes(b"\xff\xfe" + bytes(range(256)) * 40)
    assert "byte 0 is not text" in fails(reader, path, scale=0.01)
    path.write_text("[1, 2, {]")
    fails(reader, path, scale=0.01)
    path.write_text('{"features": 7, "verts": "x"}')
    fails(reader, path, scale=0.01)
    path.write_text("[" * 100_000)
    fails(reader, path, scale=0.01)
    with path.open("wb") as file:
        file.truncate(50_000_000)
    assert "50.0 MB" in fails(reader, path, scale=0.01)
    assert "scale -1" in fails(reader, path, scale=-1.0)


def test_a_plan_in_millimetres_or_degrees(tmp_path):
    path = collection(tmp_path, feature("room", "Polygon", box(0, 0, 7000, 5000)))
    line = fails(read_geojson, path)
    assert "such as 0.001 if it is in millimetres (7 m wide)" in line
    assert floor_area(read_geojson(path, scale=0.001).apartment) == pytest.approx(35, abs=0.01)
    path = collection(tmp_path, feature("room", "Polygon", box(8.5, 52.0, 8.5001, 52.0001)))
    assert "degrees" in fails(read_geojson, path)
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}
    path = collection(tmp_path, feature("room", "Polygon", box(0, 0, 7, 5)), crs=crs)
    assert "crs: degrees" in fails(read_geojson, path)


def test_a_plan_in_the_coordinates_of_a_country_is_moved(tmp_path):
    room = feature("room", "Polygon", box(500_000.25, 5_700_000, 500_007.25, 5_700_005))
    result = read_geojson(collection(tmp_path, room))
    assert result.apartment.rooms[0].polygon[0] in {(0.25, 0), (0.25, 5), (7.25, 0), (7.25, 5)}
    assert result.notes == ("all coordinates: moved by (-500000, -5700000) m to the origin",)


def test_a_drawn_start_that_is_not_free_is_moved(tmp_path):
    room = feature("room", "Polygon", box(-2, -2, 4, 5))
    start = feature("start", "Point", [-1.95, 0])
    result = read_geojson(collection(tmp_path, room, start))
    assert result.apartment.start.position == pytest.approx((1, 1.5), abs=0.6)
    assert result.notes[0].startswith("start: its place is not free; moved to (")
    without = read_geojson(collection(tmp_path, room)).apartment
    assert without.start == result.apartment.start


def test_a_bad_member_apartment_is_one_line(tmp_path):
    room = feature("room", "Polygon", box(0, 0, 4, 4))
    path = collection(tmp_path, room, apartment={"lighting": {"source": "candles"}})
    assert "lighting.source: 'candles'" in fails(read_geojson, path)
    path = collection(tmp_path, room, apartment={"name": "a b"})
    assert "name: 'a b'" in fails(read_geojson, path)


def test_a_scale_that_makes_a_home_of_kilometres():
    assert "400 m wide at 1 m per unit" in fails(read_r2v, DATA / "flat_r2v.txt", scale=1.0)


BAD_FEATURES = {
    "crosses itself at (2, 2); expected a simple polygon": feature(
        "room", "Polygon", [[[0, 0], [4, 4], [4, 0], [0, 4], [0, 0]]]
    ),
    "a Point; expected a Polygon": feature("room", "Point", [0, 0]),
    "coordinates: 0": feature("room", "Polygon", {"0": 1}),
    "has a hole outside of it at (5e+03, 0)": feature(
        "room", "Polygon", [box(0, 0, 4, 4)[0], [[5000, 0], [5001, 0], [5000, 1], [5000, 0]]]
    ),
    "geometry 'Blob'": feature("room", "Blob", [0, 0]),
    "coordinates: ": feature("room", "Polygon", [[["a", 0], [1, 1], [2, 2]]]),
    "kind: 'attic'": feature("room", "Polygon", box(0, 0, 4, 4), kind="attic"),
    "thickness: -1; expected above 0": feature(
        "wall", "LineString", [[0, 0], [1, 1]], thickness=-1
    ),
}


@pytest.mark.parametrize("said", BAD_FEATURES)
def test_bad_features_are_named(tmp_path, said):
    good = feature("room", "Polygon", box(0, 5, 4, 9))
    line = fails(read_geojson, collection(tmp_path, good, BAD_FEATURES[said]))
    assert "features[1]" in line
    assert said in line


def test_furniture_of_no_kind_is_told(tmp_path):
    room = feature("room", "Polygon", box(0, 0, 4, 4))
    odd = [feature("furniture", "Point", [1, 1], kind=kind) for kind in ("throne", {}, None)]
    notes = read_geojson(collection(tmp_path, room, *odd)).notes
    assert [note.split(": ")[1] for note in notes] == [
        f"{kind} is no kind of furniture; left out" for kind in ("'throne'", "{}", "None")
    ]


IMPOSSIBLE = {
    "lamp 1: 3 m in 'a'; expected 0 to 2.49 m under its ceiling; left out": feature(
        "lamp", "Point", [1, 1], height=3.0
    ),
    "lamp 1: (9, 9) is in no room; expected inside one; left out": feature("lamp", "Point", [9, 9]),
    "features[2] (start): there is a start already; left out": feature("start", "Point", [1, 1]),
    "features[2] (furniture) 'bed': size: (0.001, 0.001, 0.001) is too small for a bed": feature(
        "furniture", "Point", [1, 1], kind="bed", size=[0.001, 0.001, 0.001]
    ),
    "features[2] (furniture) 'bed': materials: a bed has no slot 'nope'; expected": feature(
        "furniture", "Point", [1, 1], kind="bed", materials={"nope": "oak"}
    ),
}


@pytest.mark.parametrize("said", IMPOSSIBLE)
def test_what_no_apartment_can_have_is_left_out_and_told(tmp_path, said):
    room = feature("room", "Polygon", box(0, 0, 4, 4), name="a")
    start = feature("start", "Point", [2, 2])
    result = read_geojson(collection(tmp_path, room, start, IMPOSSIBLE[said]))
    assert list(check(result.apartment)) == []
    assert result.apartment.furniture == ()
    assert result.apartment.start.position == (2, 2)
    assert result.notes[0].startswith(said)


CROSSING = [[1, 1], [2, 2], [2, 1], [1, 2], [1, 1]]


@pytest.mark.parametrize(
    ("odd", "said"),
    [
        (
            feature("block", "Polygon", [CROSSING]),
            "features[1] (block): crosses itself at (1.5, 1.5)",
        ),
        (
            feature("wall", "Polygon", [CROSSING]),
            "features[1] (wall): crosses itself at (1.5, 1.5)",
        ),
        (
            feature("room", "Polygon", [box(0, 0, 4, 4)[0], CROSSING]),
            "features[1] (room): crosses itself at (1.5, 1.5)",
        ),
        (
            feature("block", "Polygon", box(1, 1, 2, 2), bottom=1, top=0.5),
            "blocks[0].top: 0.5 m; expected above the bottom at 1 m",
        ),
    ],
)
def test_impossible_solids_are_refused(tmp_path, odd, said):
    good = feature("room", "Polygon", box(0, 5, 4, 9))
    assert said in fails(read_geojson, collection(tmp_path, good, odd))


def test_a_collection_without_a_room(tmp_path):
    path = collection(tmp_path, feature("wall", "LineString", [[0, 0], [4, 0]]))
    assert "no room in it" in fails(read_geojson, path)


def test_plans_larger_than_any_home(tmp_path):
    boxes = [box(x % 20 * 4, x // 20 * 4, x % 20 * 4 + 3, x // 20 * 4 + 3) for x in range(301)]
    path = collection(tmp_path, *(feature("room", "Polygon", ring) for ring in boxes))
    assert fails(read_geojson, path).endswith("301 rooms; expected a home of at most 300")
    angles = np.linspace(0.0, 6.28, 3001)
    path.write_text(f'{{"verts": {np.column_stack([np.cos(angles), np.sin(angles)]).tolist()}}}')
    assert "verts: 3001 corners; expected at most 3000" in fails(read_houseexpo, path)


@pytest.mark.parametrize("texts", ["7", "true", "[[1, [2]]]", '{"a": 1}', "[null]"])
def test_layers_of_resplan_that_are_no_texts(tmp_path, texts):
    path = tmp_path / "plan.json"
    path.write_text(f'{{"living": {texts}}}')
    assert "living[0]: " in fails(read_resplan, path, scale=1.0)


def test_an_svg_with_an_external_entity_reads_nothing(tmp_path):
    secret = tmp_path / "secret.txt"
    secret.write_text("0,0 1,0 1,1")
    path = tmp_path / "plan.svg"
    path.write_text(
        f'<?xml version="1.0"?><!DOCTYPE svg [<!ENTITY x SYSTEM "file://{secret}">]>'
        '<svg><g class="Space Bath"><polygon points="&x;"/></g></svg>'
    )
    assert "declares entities" in fails(read_cubicasa, path, scale=0.01)
    path.write_text('<svg><g class="Space Bath"><polygon points="0,0 1,1"/></g></svg>')
    assert "Space Bath 1: points '0,0 1,1'" in fails(read_cubicasa, path, scale=0.01)


def test_an_svg_far_out_of_bounds(tmp_path):
    path = tmp_path / "plan.svg"
    path.write_text(
        '<svg><g transform="scale(1e300)"><g class="Space Bath">'
        '<polygon points="0,0 9e200,0 9,9"/></g></g></svg>'
    )
    assert "Space Bath 1: points '0,0 9e200,0 9,9'" in fails(read_cubicasa, path, scale=0.01)


def test_self_crossing_outlines(tmp_path):
    path = tmp_path / "h.json"
    path.write_text('{"verts": [[0, 0], [4, 4], [4, 0], [0, 4]]}')
    assert "verts: crosses itself at (2, 2)" in fails(read_houseexpo, path)
    path.write_text('{"living": ["POLYGON ((0 0, 4 4, 4 0, 0 4, 0 0))"]}')
    assert "living[0]: crosses itself at (2, 2)" in fails(read_resplan, path, scale=1.0)
    path.write_text('{"living": ["POLYGO"]}')
    assert "living[0]: 'POLYGO'; expected a POLYGON as WKT" in fails(read_resplan, path)


def test_a_start_that_is_not_free(tmp_path):
    line = fails(read_geojson, DATA / "flat.geojson", start=(4.05, 4.0))
    assert "start (4.05, 4): no free floor" in line


# ---- the real files, where they lie beside the checkout --------------------------------------


def real_files(pattern):
    return [path for path in sorted(SHARED.glob(pattern)) if path.name != "LICENSE.txt"]


@pytest.mark.parametrize("path", real_files("houseexpo/*.json"), ids=lambda path: path.stem)
def test_real_houseexpo(path):
    assert list(check(read_houseexpo(path).apartment)) == []


@pytest.mark.parametrize("plan", ["0", "10", "50"])
def test_real_resplan(plan):
    path = SHARED / "resplan" / "resplan_samples.json"
    if not path.exists():
        pytest.skip("needs the files of the data set beside the checkout")
    scale = suggested(read_resplan, path, plan=plan)
    assert list(check(read_resplan(path, plan=plan, scale=scale).apartment)) == []


@pytest.mark.parametrize("path", real_files("r2v/*.txt")[::60], ids=lambda path: path.stem[:8])
def test_real_r2v(path):
    result = read_r2v(path, scale=suggested(read_r2v, path))
    assert list(check(result.apartment)) == []


def suggested(reader, path, **options):
    with pytest.raises(SceneError) as error:
        reader(path, **options)
    return float(str(error.value).split("such as ")[1].split(" ")[0])


@pytest.mark.parametrize("path", real_files("r2v/03-2d-489b*.txt"), ids=lambda path: path.stem[:8])
def test_real_entrance_is_a_door(path):
    apartment = read_r2v(path, scale=0.0144).apartment
    # Line 7, in the wall at the top: 464 px above the lowest one.
    (front,) = [p for p in apartment.passages if p.closed]
    np.testing.assert_allclose(front.position, (99 * 0.0144, 464 * 0.0144), atol=0.02)
