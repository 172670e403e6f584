"""Grid maps as apartments: the rules of map_server, faults, round trips."""

import tempfile
from pathlib import Path

import cv2
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import ndimage
from shapely import Point, Polygon

from scenes import check, floor_area, floor_region, load_apartment, obstacles, save_apartment
from scenes.errors import SceneError
from scenes.exporters.ros_map import FREE, OCCUPIED, UNKNOWN, draw_grid_map, write_ros_map
from scenes.importers.ros_map import read_ros_map
from scenes.passages import ROBOT_RADIUS, free_region

from .grids import pgm, two_rooms, write_map

CELL = 0.05


def free_floor(apartment):
    return floor_region(apartment).difference(obstacles(apartment))


def test_cells_become_floor_walls_and_a_block(tmp_path):
    apartment = read_ros_map(write_map(tmp_path, two_rooms())).apartment
    assert list(check(apartment)) == []
    free = (two_rooms() == 254).sum() * CELL**2
    assert free_floor(apartment).area == pytest.approx(free, abs=1e-6)
    assert obstacles(apartment).contains(Point(10.5 * CELL, 9.5 * CELL))
    assert free_floor(apartment).bounds == pytest.approx((2 * CELL, 2 * CELL, 58 * CELL, 38 * CELL))
    assert apartment.name == "map"


def test_an_imported_map_is_saved_and_loaded(tmp_path):
    apartment = read_ros_map(write_map(tmp_path, two_rooms())).apartment
    save_apartment(apartment, tmp_path / "home.json")
    assert load_apartment(tmp_path / "home.json") == apartment


def test_origin_and_yaw_place_the_map(tmp_path):
    plain = read_ros_map(write_map(tmp_path, two_rooms())).apartment
    turned = read_ros_map(
        write_map(tmp_path, two_rooms(), origin="[-3.0, 2.0, 0.5]"), start=(-1.9, 3.5)
    ).apartment
    c, s = np.cos(0.5), np.sin(0.5)
    expected = shapely.transform(
        free_floor(plain), lambda p: p @ np.array([[c, s], [-s, c]]) + [-3.0, 2.0]
    )
    assert free_floor(turned).symmetric_difference(expected).area < 1e-3
    assert turned.start.position == (-1.9, 3.5)


@pytest.mark.parametrize(
    ("fields", "free"),
    [
        ({}, [254]),
        ({"negate": "1"}, [0]),
        ({"negate": "true"}, [0]),
        ({"free_thresh": "0.25", "occupied_thresh": "0.3"}, [205, 254]),
        ({"mode": "scale"}, [254]),
        ({"mode": "raw"}, [0]),
        ({"free_thresh": "2e-1"}, [205, 254]),
    ],
)
def test_what_is_free_is_what_map_server_says(tmp_path, fields, free):
    columns = np.repeat([0, 100, 205, 254], 20)
    cells = np.tile(columns, (20, 1))
    apartment = read_ros_map(write_map(tmp_path, cells, **fields)).apartment
    expected = np.isin(columns, free).sum() * 20 * CELL**2
    assert floor_area(apartment) == pytest.approx(expected)


def test_unknown_beside_free_is_told_and_closed(tmp_path):
    cells = np.full((20, 20), 254)
    result = read_ros_map(write_map(tmp_path, cells))
    assert result.notes == ("4.0 m of the free cells' edge meet unknown ones: closed by a wall",)
    assert floor_area(result.apartment) == pytest.approx(1.0)


def test_free_cells_apart_are_left_out_and_told(tmp_path):
    cells = np.full((40, 80), 0)
    cells[5:35, 5:35] = 254
    cells[5:26, 45:64] = 254
    cells[30:32, 70:72] = 254
    result = read_ros_map(write_map(tmp_path, cells))
    assert floor_area(result.apartment) == pytest.approx(2.25)
    assert result.notes == (
        "free area of 1.0 m² about (2.73, 1.23): not connected with the rest; left out",
        "1 small free areas, 0.01 m² in all: not connected with the rest; left out",
    )
    other = read_ros_map(tmp_path / "map.yaml", start=(2.6, 1.2)).apartment
    assert floor_area(other) == pytest.approx(0.9975)


def test_png_and_ascii_pgm_say_the_same(tmp_path):
    cells = two_rooms().astype(np.uint8)
    path = write_map(tmp_path, cells)
    expected = read_ros_map(path)
    cv2.imwrite(str(tmp_path / "map.png"), cells)
    cv2.imwrite(str(tmp_path / "rgb.png"), cv2.cvtColor(cells, cv2.COLOR_GRAY2BGR))
    body = "\n".join(" ".join(map(str, row)) for row in cells)
    (tmp_path / "ascii.pgm").write_text(f"P2 # old\n60 40\n255\n{body}\n", encoding="ascii")
    wide = (cells.astype(">u2") * 257).tobytes()
    (tmp_path / "wide.pgm").write_bytes(b"P5 60 40 65535\n" + wide)
    for name in ("map.png", "rgb.png", "ascii.pgm", "wide.pgm"):
        assert read_ros_map(write_map(tmp_path, cells, image=name)) == expected


def test_transparent_is_unknown(tmp_path):
    cells = np.full((20, 40, 4), 254, dtype=np.uint8)
    cells[:, 20:, 3] = 0
    cv2.imwrite(str(tmp_path / "map.png"), cells)
    apartment = read_ros_map(write_map(tmp_path, cells[..., 0], image="map.png")).apartment
    assert floor_area(apartment) == pytest.approx(1.0)


def test_research_grid_needs_a_scale(tmp_path):
    cells = np.where(two_rooms() == 254, 255, 0)
    (tmp_path / "grid.pgm").write_bytes(pgm(cells))
    with pytest.raises(SceneError) as error:
        read_ros_map(tmp_path / "grid.pgm")
    assert str(error.value) == (
        f"{tmp_path}/grid.pgm: a picture has no scale; expected --scale, metres per pixel "
        "(0.05 is usual)"
    )
    apartment = read_ros_map(tmp_path / "grid.pgm", scale=0.1).apartment
    assert free_floor(apartment).area == pytest.approx((cells == 255).sum() * 0.01, abs=1e-6)


# ---- rooms ----------------------------------------------------------------------------------


def test_borders_part_the_floor_and_get_a_lintel(tmp_path):
    path = write_map(tmp_path, two_rooms())
    (tmp_path / "borders.csv").write_text("x0,y0,x1,y1\n1.5,0.65,1.5,1.35\n", encoding="utf-8")
    (tmp_path / "borders.json").write_text('[{"x0": 1.5, "y0": 0.65, "x1": 1.5, "y1": 1.35}]')
    result = read_ros_map(path, borders=tmp_path / "borders.csv")
    apartment = result.apartment
    assert read_ros_map(path, borders=tmp_path / "borders.json") == result
    assert list(check(apartment)) == []
    assert [room.name for room in apartment.rooms] == ["room_1", "room_2"]
    assert apartment.borders == (((1.5, 1.4), (1.5, 0.6)),)
    lintels = [block for block in apartment.blocks if block.bottom == 2.0]
    assert len(lintels) == 1
    assert Polygon(lintels[0].polygon).contains(Point(1.5, 1.0))


def test_rooms_by_colour_or_grey_with_a_table(tmp_path):
    path = write_map(tmp_path, two_rooms())
    labels = np.zeros((40, 60, 3), dtype=np.uint8)
    labels[:, :29] = (10, 20, 30)
    labels[:, 31:] = (0, 0, 200)
    cv2.imwrite(str(tmp_path / "rooms.png"), labels)
    table = "value,name,kind,r,g,b\n1,Living room,living_room,30,20,10\n2,bath,bathroom,200,0,0\n"
    (tmp_path / "rooms.csv").write_text(table, encoding="utf-8")
    apartment = read_ros_map(
        path, labels=tmp_path / "rooms.png", label_table=tmp_path / "rooms.csv"
    ).apartment
    assert list(check(apartment)) == []
    names = {room.name: room.kind for room in apartment.rooms}
    assert names == {"Living_room": "living_room", "bath": "bathroom"}
    # The door has no label: its cells go to the nearer room.
    assert np.mean(np.array(apartment.borders)[..., 0]) == pytest.approx(1.5, abs=CELL)
    grey = np.zeros((40, 60), dtype=np.uint8)
    grey[:, :29], grey[:, 31:] = 1, 2
    cv2.imwrite(str(tmp_path / "grey.png"), grey)
    again = read_ros_map(path, labels=tmp_path / "grey.png", label_table=tmp_path / "rooms.csv")
    assert again.apartment == apartment


def test_rooms_parted_by_dark_lines_as_in_research_data(tmp_path):
    cells = np.where(two_rooms() == 254, 255, 0)
    (tmp_path / "grid.pgm").write_bytes(pgm(cells))
    truth = cells.copy()
    truth[:, 30] = 0
    (tmp_path / "truth.pgm").write_bytes(pgm(truth))
    apartment = read_ros_map(
        tmp_path / "grid.pgm", scale=0.05, labels=tmp_path / "truth.pgm"
    ).apartment
    assert list(check(apartment)) == []
    assert len(apartment.rooms) == 2
    assert free_floor(apartment).area == pytest.approx((cells == 255).sum() * CELL**2, abs=1e-6)


def test_a_picture_with_as_many_colours_as_pixels(tmp_path):
    # 600 x 600 cells: the left half one room, every cell of the right half a colour of its own.
    size = 600
    cells = np.zeros((size, size), dtype=np.uint8)
    cells[1:-1, 1:-1] = 254
    colour = np.arange(size * size).reshape(size, size) + 1
    labels = np.stack([colour % 256, colour // 256 % 256, colour // 65536], axis=2)
    labels[:, : size // 2] = (0, 0, 255)
    cv2.imwrite(str(tmp_path / "rooms.png"), labels.astype(np.uint8))
    result = read_ros_map(write_map(tmp_path, cells), labels=tmp_path / "rooms.png")
    assert list(check(result.apartment)) == []
    areas = [Polygon(room.polygon).area for room in result.apartment.rooms]
    assert areas == pytest.approx([299 * 598 * CELL**2] * 2)
    assert "1 parts of the floor without a label: rooms of their own" in result.notes[-1]


def test_rooms_of_a_map_have_lamps(tmp_path):
    apartment = read_ros_map(write_map(tmp_path, two_rooms())).apartment
    assert apartment.lighting.source == "interior"
    assert len(apartment.lamps) >= len(apartment.rooms)


def test_labels_that_cannot_be_used(tmp_path):
    path = write_map(tmp_path, two_rooms())
    rooms, table = tmp_path / "rooms.png", tmp_path / "rooms.csv"

    def said(labels, text):
        cv2.imwrite(str(rooms), labels)
        table.write_text(text, encoding="utf-8")
        with pytest.raises(SceneError) as error:
            read_ros_map(path, labels=rooms, label_table=table)
        return str(error.value)

    good, head = np.ones((40, 60), dtype=np.uint8), "value,name,kind\n"
    assert said(good[:-1], head) == f"{rooms}: 60 x 39 pixels; expected those of the map, 60 x 40"
    assert said(good, head).startswith(f"{table}: no row, or no line of column names first; ")
    assert said(0 * good, head + "1,a,other\n") == (
        f"{rooms}: no room on any free cell; expected rooms that are not black"
    )
    assert said(good, head + "1,a,cave\n").startswith(
        f"{table}: row 1: kind: 'cave'; expected one of bathroom, bedroom, "
    )
    assert said(good, head + "x,a,other\n") == (
        f"{table}: row 1: value: 'x'; expected a whole number, 0 to 255"
    )
    assert said(good, head + "1,a,other\n1,b,other\n") == (
        f"{table}: row 2: the label is that of an earlier row; expected another"
    )
    cv2.imwrite(str(rooms), good)
    table.write_text(head + "1,a,other\n9,b,other\n", encoding="utf-8")
    notes = read_ros_map(path, labels=rooms, label_table=table).notes
    table.write_text(head + "1,Küche 1,other\n9,b,other\n", encoding="utf-8")
    notes = read_ros_map(path, labels=rooms, label_table=table).notes
    assert f"{table}: row 1: 'Küche 1' is no name for a room; called 'K_che_1'" in notes
    assert f"{table}: 'b': labels less than 0.5 m² of free floor; left out" in notes


# ---- faults ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fields", "line"),
    [
        ({"image": None}, "image: missing; expected a value"),
        ({"resolution": None}, "resolution: missing; expected a value"),
        ({"origin": None}, "origin: missing; expected a value"),
        ({"resolution": "0.0"}, "resolution: 0.0; expected above 0"),
        ({"resolution": "-0.05"}, "resolution: -0.05; expected above 0"),
        ({"resolution": ".nan"}, "resolution: nan; expected a finite number"),
        (
            {"resolution": "five"},
            "resolution: 'five'; expected a number",
        ),
        ({"origin": "[0, 0]"}, "origin[2]: missing; expected a value"),
        ({"origin": "here"}, "origin: 'here'; expected a list"),
        (
            {"mode": "grey"},
            "mode: 'grey'; expected 'trinary', 'scale' or 'raw'",
        ),
        (
            {"occupied_thresh": "65"},
            "occupied_thresh: 65; expected at most 1",
        ),
        (
            {"free_thresh": "0.7"},
            "free_thresh: 0.7; expected below occupied_thresh, 0.65",
        ),
        (
            {"image": "../map.pgm"},
            "image: '../map.pgm' leads out of the folder; expected a file in it",
        ),
        (
            {"image": "/etc/passwd"},
            "image: '/etc/passwd' leads out of the folder; expected a file in it",
        ),
    ],
)
def test_faults_of_the_yaml_are_one_line(tmp_path, fields, line):
    path = write_map(tmp_path, two_rooms(), **fields)
    with pytest.raises(SceneError) as error:
        read_ros_map(path)
    assert str(error.value) == f"{path}: {line}"


def test_a_link_does_not_lead_out_of_the_folder(tmp_path):
    folder = tmp_path / "maps"
    folder.mkdir()
    path = write_map(folder, two_rooms())
    (tmp_path / "secret.pgm").write_bytes(pgm(two_rooms()))
    (folder / "map.pgm").unlink()
    (folder / "map.pgm").symlink_to(tmp_path / "secret.pgm")
    with pytest.raises(SceneError, match="leads out of the folder"):
        read_ros_map(path)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("image: [\n", "line 2: not YAML: expected the node content, but found '<stream end>'"),
        ("", "no fields; expected the YAML of a ROS map: image, resolution, origin, …"),
        ("[1, 2]", "no fields; expected the YAML of a ROS map: image, resolution, origin, …"),
        ("[" * 5000, "not YAML: no text, or nested too deeply"),
        (
            "!!python/object/apply:os.system ['false']",
            "line 1: not YAML: could not determine a constructor for the tag "
            "'tag:yaml.org,2002:python/object/apply:os.system'",
        ),
    ],
)
def test_what_is_no_yaml_is_told(tmp_path, text, line):
    path = tmp_path / "map.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(SceneError) as error:
        read_ros_map(path)
    assert str(error.value) == f"{path}: {line}"


def test_pictures_cut_short_or_damaged_are_told(tmp_path):
    cells = two_rooms().astype(np.uint8)
    path, image = write_map(tmp_path, cells), tmp_path / "map.pgm"
    png = cv2.imencode(".png", cells)[1].tobytes()

    def said(data):
        image.write_bytes(data)
        with pytest.raises(SceneError) as error:
            read_ros_map(path)
        return str(error.value).removeprefix(f"{image}: ")

    whole = pgm(cells)
    assert said(whole[:-100]) == ("cut short: 2300 of 60 x 40 pixels; expected all of them")
    assert said(b"P2 60 40 255 0 0 0") == "cut short: 3 of 60 x 40 pixels; expected all of them"
    assert said(b"P2 2 2 255 0 0 0 x") == "not all pixels are whole numbers; damaged?"
    assert said(b"P2 2 2 255 0 0 0 -1") == "pixel beyond the maximum 255 of its header; damaged?"
    assert said(b"P5 2 2 3 \1\1\1\4") == "pixel beyond the maximum 3 of its header; damaged?"
    assert said(b"P5 60") == ("damaged PGM header; expected P5 or P2, width, height, maximum")
    assert said(b"P5 99999 99999 255\n").startswith(
        "99999 x 99999 pixels; expected 1 to 64 million"
    )
    assert said(b"P5 0 40 255\n").startswith("0 x 40 pixels")
    assert said(b"P5 2 2 99999\n\0\0\0\0") == "PGM maximum 99999; expected 1 to 65535"
    assert said(b"GIF89a") == "begins with b'GIF89a'; expected a PGM (P2, P5) or PNG picture"
    assert said(png[:-30]) == "cut short: the PNG has no end; expected the whole file"
    assert said(png[:60] + b"xx" + png[62:]).startswith("damaged PNG: wrong checksum at byte ")
    image.unlink()
    with pytest.raises(SceneError, match="cannot be read: No such file"):
        read_ros_map(path)


def test_fifty_megabytes_of_nonsense_are_one_line(tmp_path):
    noise = np.random.default_rng(0).integers(0, 256, 50_000_000, dtype=np.uint8).tobytes()
    (tmp_path / "map.yaml").write_bytes(noise)
    with pytest.raises(SceneError) as error:
        read_ros_map(tmp_path / "map.yaml")
    assert str(error.value) == (
        f"{tmp_path}/map.yaml: 50.0 MB; expected the YAML of a ROS map, at most 0.1 MB"
    )
    (tmp_path / "map.pgm").write_bytes(noise)
    with pytest.raises(SceneError, match=r"expected a PGM \(P2, P5\) or PNG picture"):
        read_ros_map(tmp_path / "map.pgm", scale=0.05)


def test_maps_without_a_place_for_the_robot_are_told(tmp_path):
    def said(cells, **options):
        with pytest.raises(SceneError) as error:
            read_ros_map(write_map(tmp_path, cells), **options)
        return str(error.value)

    assert said(np.zeros((30, 30))) == (
        f"{tmp_path}/map.yaml: no free cell; expected floor (check negate and free_thresh)"
    )
    assert said(np.eye(30) * 254) == (
        f"{tmp_path}/map.yaml: the free floor is nowhere 0.3 m wide; expected a place for the "
        "robot; check the scale and what counts as free"
    )
    assert said(two_rooms(), start=(9.0, 9.0)) == (
        f"{tmp_path}/map.yaml: start: (9, 9) has no free floor for a robot of 0.15 m radius; "
        "expected a free place, such as (2.75, 1.75)"
    )
    noise = np.random.default_rng(0).integers(0, 2, (1800, 1800)) * 254
    assert "expected at most 400000: a map, not noise" in said(noise)


def test_a_map_far_away_is_told(tmp_path):
    path = write_map(tmp_path, two_rooms(), origin="[5000, 0, 0]")
    with pytest.raises(SceneError) as error:
        read_ros_map(path)
    assert str(error.value) == (
        f"{path}: the free floor reaches from (5e+03, 0.1) to (5e+03, 1.9) m; expected coordinates "
        "within ±1000 m; check the scale and the origin"
    )


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("x0,y0,x1\n1,2,3\n", "border 1: y1: missing; expected a number within ±1000 m"),
        ("x0,y0,x1,y1\n1,2,3,nan\n", "border 1: y1: 'nan'; expected a number within ±1000 m"),
        ('[{"x0": 1}]', "border 1: y0: missing; expected a number within ±1000 m"),
        (
            "[1, 2]",
            "expected border segments: columns x0,y0,x1,y1 in metres (CSV with that line first, "
            "or JSON)",
        ),
        (
            "[",
            "neither CSV nor JSON; expected border segments: columns x0,y0,x1,y1 in metres (CSV "
            "with that line first, or JSON)",
        ),
        (
            "1.5,0.65,1.5,1.35\n",
            "no row, or no line of column names first; expected border segments: columns "
            "x0,y0,x1,y1 in metres (CSV with that line first, or JSON)",
        ),
    ],
)
def test_faults_of_borders_are_one_line(tmp_path, text, line):
    borders = tmp_path / "borders.csv"
    borders.write_text(text, encoding="utf-8")
    with pytest.raises(SceneError) as error:
        read_ros_map(write_map(tmp_path, two_rooms()), borders=borders)
    assert str(error.value) == f"{borders}: {line}"


# ---- round trips ----------------------------------------------------------------------------


@settings(max_examples=40, deadline=None)
@given(arrays(bool, st.tuples(st.integers(1, 6), st.integers(1, 6)), elements=st.booleans()))
def test_free_cells_in_are_free_area_out(coarse):
    # Every coarse cell is 8 x 8 cells, wide enough for the robot; all outlines are exact.
    cells = np.kron(coarse, np.ones((8, 8))) * 254
    with tempfile.TemporaryDirectory() as folder:
        path = write_map(Path(folder), cells)
        if not coarse.any():
            with pytest.raises(SceneError):
                read_ros_map(path)
            return
        apartment = read_ros_map(path).apartment
    assert list(check(apartment)) == []
    parts, count = ndimage.label(coarse)
    sizes = np.bincount(parts.ravel(), minlength=count + 1)[1:]
    column, row = np.array(apartment.start.position) / (8 * CELL)
    home = parts[len(coarse) - 1 - int(row), int(column)]
    assert home > 0
    assert free_floor(apartment).area == pytest.approx(sizes[home - 1] * (8 * CELL) ** 2, abs=1e-6)


@settings(max_examples=25, deadline=None)
@given(
    arrays(bool, (5, 5), elements=st.booleans()),
    st.integers(0, 2**32 - 1),
    st.sampled_from([0.01, 0.1, 0.2]),
    st.booleans(),
)
def test_ragged_maps_give_valid_apartments_within_a_cell(coarse, seed, noise, labelled):
    rng = np.random.default_rng(seed)
    free = np.kron(coarse, np.ones((10, 10))).astype(bool)
    free &= rng.random(free.shape) > noise
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        labels = None
        if labelled:
            labels = folder / "rooms.png"
            numbers = np.kron(rng.integers(1, 4, (5, 5)), np.ones((10, 10)))
            cv2.imwrite(str(labels), numbers.astype(np.uint8))
        try:
            result = read_ros_map(write_map(folder, free * 254), labels=labels)
        except SceneError as error:
            assert "robot" in str(error) or "no free cell" in str(error) or "no room" in str(error)
            return
    apartment = result.apartment
    assert list(check(apartment)) == []
    boxes = [shapely.box(c, 49 - r, c + 1, 50 - r) for r, c in np.argwhere(free)]
    drawn = shapely.transform(shapely.union_all(boxes), lambda points: points * CELL)
    reach = 1.01 * CELL
    assert free_floor(apartment).difference(drawn.buffer(reach)).area < 1e-6
    start = Point(apartment.start.position)
    wide = drawn.buffer(-ROBOT_RADIUS - reach)
    for part in shapely.get_parts(wide):
        if part.intersects(start):
            assert part.difference(free_region(apartment, ROBOT_RADIUS).buffer(1e-3)).area < 1e-6


@pytest.mark.parametrize("place", ["sim3", "sim4"])
@pytest.mark.parametrize("cell", [0.05, 0.02])
def test_a_place_comes_back_from_its_map(tmp_path, place, cell):
    before = load_apartment(place)
    path, _, labels, table = write_ros_map(before, tmp_path / f"{place}.yaml", resolution=cell)
    result = read_ros_map(path, labels=labels, label_table=table, start=before.start.position)
    after = result.apartment
    assert list(check(after)) == []
    kinds = {room.name: room.kind for room in before.rooms}
    assert {room.name: room.kind for room in after.rooms} == kinds
    floor = free_floor(before)
    wrong = floor.symmetric_difference(free_floor(after))
    # Slots between furniture that are hardly wider than a cell may close.
    beyond = wrong.difference(floor.boundary.buffer(cell))
    assert beyond.area < 1e-3 * floor.area
    assert wrong.difference(floor.boundary.buffer(1.5 * cell)).area < 1e-6
    robot = [free_region(home, ROBOT_RADIUS).area for home in (before, after)]
    assert robot[1] == pytest.approx(robot[0], rel=0.15)


def test_a_drawn_map_has_greys_of_map_server_and_numbers_of_rooms():
    apartment = load_apartment("sim4")
    grid = draw_grid_map(apartment, 0.05)
    assert set(np.unique(grid.cells)) == {OCCUPIED, UNKNOWN, FREE}
    assert (grid.cells == FREE).sum() * 0.0025 == pytest.approx(
        free_floor(apartment).area, rel=0.03
    )
    assert (grid.cells[0] == UNKNOWN).all()
    rows, _ = grid.cells.shape
    for index, room in enumerate(apartment.rooms):
        spot = Polygon(room.polygon).representative_point()
        column = int((spot.x - grid.origin[0]) / 0.05)
        row = rows - 1 - int((spot.y - grid.origin[1]) / 0.05)
        assert grid.rooms[row, column] == index + 1


def test_thin_things_are_in_the_map_and_walls_leak_nowhere():
    apartment = load_apartment("sim4")
    coarse = draw_grid_map(apartment, 0.1)
    # No free cell touches the unknown outside.
    outside = ndimage.binary_dilation(coarse.cells == UNKNOWN, np.ones((3, 3)))
    assert not (outside & (coarse.cells == FREE)).any()
    rows, _ = coarse.cells.shape
    legs = [part for part in shapely.get_parts(obstacles(apartment)) if part.area < 0.003]
    assert legs
    for leg in legs:
        x, y = leg.centroid.coords[0]
        column = int((x - coarse.origin[0]) / 0.1)
        row = rows - 1 - int((y - coarse.origin[1]) / 0.1)
        assert (coarse.cells[row - 1 : row + 2, column - 1 : column + 2] == OCCUPIED).any()


def test_a_map_with_too_many_cells_is_told():
    with pytest.raises(SceneError, match=r"^sim4: \d+ x \d+ cells of 0.0005 m; expected at most"):
        draw_grid_map(load_apartment("sim4"), 0.0005)
