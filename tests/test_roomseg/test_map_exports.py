"""Maps in other programs' formats, read back by those programs' own readers."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace

import cv2
import networkx as nx
import numpy as np
import pytest
import shapely
import yaml
from cleaned_flat import cleaned_flat, drift, fisheye_image, floor, obstacles

from dataset import FisheyeCamera, MapFile, TopoMap, write_map, write_rooms
from roomseg.cli.main import main
from roomseg.exporters.floor import FREE, OCCUPIED, UNKNOWN, floor_grid, room_areas
from roomseg.exporters.geojson import drawn_borders
from roomseg.exporters.graph import graph_of
from roomseg.panorama import PanoramaParameters, Unfolding
from scenes import load_apartment


@pytest.fixture(scope="module")
def flat() -> TopoMap:
    # Its path leads through walls from lane to lane.
    return replace(cleaned_flat(), path=None)


@pytest.fixture
def map_path(flat, tmp_path, monkeypatch):
    """The flat's map with a segmentation that knows two rooms, the working folder its own."""
    monkeypatch.chdir(tmp_path)
    write_map("flat.h5", flat)
    write_rooms("flat.h5", flat.ground_truth.room // 2, model="m", rooms=2)
    return tmp_path / "flat.h5"


def exported(*arguments):
    assert main(["export", "flat.h5", *arguments]) == 0


def assert_graph(graph, flat):
    """Every node and edge has the map's own values, as Python's types."""
    assert sorted(graph.nodes) == list(range(len(flat.nodes)))
    assert {tuple(sorted(edge)) for edge in graph.edges} == set(map(tuple, flat.edges.tolist()))
    position = np.array([[graph.nodes[k]["x"], graph.nodes[k]["y"]] for k in sorted(graph)])
    np.testing.assert_array_equal(position, flat.nodes.position)
    lengths = np.array([graph.edges[a, b]["length"] for a, b in flat.edges.tolist()])
    np.testing.assert_array_equal(lengths, flat.edge_lengths())
    border = [graph.edges[a, b]["border"] for a, b in flat.edges.tolist()]
    assert border == flat.ground_truth.edge_is_border.tolist()
    assert [graph.nodes[k]["room"] for k in sorted(graph)] == flat.ground_truth.room.tolist()
    assert [graph.nodes[k]["part"] for k in sorted(graph)] == flat.nodes.part.tolist()
    assert graph.nodes[5]["found_room"] == flat.ground_truth.room[5] // 2
    assert graph.nodes[5]["created"] == flat.visits.time[5]
    assert {type(v) for v in graph.nodes[5].values()} <= {int, float}
    assert graph.graph["environment"] == "flat"
    assert graph.graph["robot_radius"] == 0.15
    assert graph.graph["room_count"] == 3


def test_networkx_reads_the_graphml_back(map_path, flat):
    exported("-o", "g.graphml")
    assert_graph(nx.read_graphml("g.graphml", node_type=int), flat)


def test_networkx_reads_the_node_link_json_back(map_path, flat):
    exported("-o", "g.json")
    with open("g.json", encoding="utf-8") as stream:  # noqa: PTH123
        assert_graph(nx.node_link_graph(json.load(stream), edges="edges"), flat)


def test_names_that_xml_cannot_hold_are_written_all_the_same(flat, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_map("flat.h5", replace(flat, environment="a\x01<&höhe\U0001f600"))
    exported("-o", "g.graphml")
    assert nx.read_graphml("g.graphml").graph["environment"] == "a\ufffd<&höhe\U0001f600"


def test_a_node_that_was_never_visited_has_no_time(flat):
    visits = replace(flat.visits, node=flat.visits.node[1:], time=flat.visits.time[1:])
    graph = graph_of(replace(flat, visits=visits))
    assert "created" not in graph.nodes[0]
    assert graph.nodes[0]["visits"] == 0
    assert graph.nodes[1]["created"] == flat.visits.time[1]


def test_the_floor_is_where_the_body_can_be(flat):
    """Beside the plan itself, bent as the map is."""
    grid = floor_grid(flat, flat.ground_truth.room, 0.05)
    assert grid.cells.dtype == np.uint8 and set(np.unique(grid.cells)) == {OCCUPIED, UNKNOWN, FREE}
    rows, columns = grid.cells.shape
    x = grid.origin[0] + (np.arange(columns) + 0.5) * 0.05
    y = grid.origin[1] + (np.arange(rows)[::-1] + 0.5) * 0.05
    bend = shapely.transform(floor().difference(obstacles()), drift)
    deep = shapely.contains_xy(bend.buffer(-0.06), *np.meshgrid(x, y))
    outside = ~shapely.contains_xy(bend.buffer(0.06), *np.meshgrid(x, y))
    assert (grid.cells[deep] == FREE).mean() > 0.85
    assert not (grid.cells[outside] == FREE).any()
    assert ((grid.rooms > 0) == (grid.cells == FREE)).all()
    # Each node stands in its own room.
    column, row = np.floor((flat.nodes.position - grid.origin) / 0.05).astype(int).T
    assert (grid.rooms[rows - 1 - row, column] == flat.ground_truth.room + 1).all()


def test_lonely_points_are_no_obstacles_and_the_body_is_no_wall(flat):
    far = np.array([[20.0, 20.0], [-3.0, -3.0]])
    inside = flat.nodes.position[40] + np.array([[0.0, 0.0], [0.01, 0.0], [0.0, 0.01]])
    points = np.concatenate([far, inside])
    zero = np.zeros(len(points))
    seen = replace(flat.obstacles, position=points, time=zero, beam=zero)
    assert not (floor_grid(replace(flat, obstacles=seen), None).cells == OCCUPIED).any()


def test_areas_of_rooms_are_those_of_the_cells(flat):
    grid = floor_grid(flat, flat.ground_truth.room, 0.05)
    areas = room_areas(grid)
    cells = [int((grid.rooms == k + 1).sum()) * 0.05**2 for k in range(3)]
    assert [area.area for area in areas] == pytest.approx(cells, abs=0.05)
    assert all(area.is_valid for area in areas)
    assert shapely.coverage_is_valid(areas)


def read_map_server(path):
    """What map_server makes of a map: the cells as -1, 0 or 100, the lowest row first."""
    with open(path, encoding="utf-8") as stream:  # noqa: PTH123
        fields = yaml.safe_load(stream)
    picture = cv2.imread(str(path.parent / fields["image"]), cv2.IMREAD_UNCHANGED)
    occupied = (255 - picture.astype(float)) / 255
    assert fields["negate"] == 0 and fields["mode"] == "trinary"
    cells = np.full(picture.shape, -1)
    cells[occupied > fields["occupied_thresh"]] = 100
    cells[occupied < fields["free_thresh"]] = 0
    return cells[::-1], fields["resolution"], fields["origin"]


def test_the_ros_map_follows_map_server_and_has_its_rooms(map_path, flat):
    exported("-o", "r.yaml", "--resolution", "0.04")
    cells, resolution, origin = read_map_server(map_path.parent / "r.yaml")
    assert resolution == 0.04 and origin[2] == 0.0
    column, row = np.floor((flat.nodes.position - origin[:2]) / resolution).astype(int).T
    assert (cells[row, column] == 0).all()
    rooms = cv2.imread("r_rooms.png", cv2.IMREAD_UNCHANGED)[::-1]
    assert (rooms[row, column] == flat.ground_truth.room + 1).all()
    with open("r_rooms.csv", encoding="utf-8") as stream:  # noqa: PTH123
        table = list(csv.DictReader(stream))
    assert [line["value"] for line in table] == ["1", "2", "3"]
    assert len({(line["r"], line["g"], line["b"]) for line in table}) == 3


def test_the_ros_map_comes_back_as_an_apartment(map_path):
    flat = cleaned_flat()  # with its path: a lane alone is too narrow a door for a robot
    write_map("flat.h5", flat)
    exported("-o", "r.yaml")
    names = ("--labels", "r_rooms.png", "--label-table", "r_rooms.csv")
    assert main(["import", "r.yaml", *names, "-o", "home.json"]) == 0
    home = load_apartment("home.json")
    areas = [area.area for area in room_areas(floor_grid(flat, flat.ground_truth.room))]
    again = {room.name: shapely.Polygon(room.polygon).area for room in home.rooms}
    assert [again[f"room-{k}"] for k in (1, 2, 3)] == pytest.approx(areas, rel=0.1)


def features(path):
    with open(path, encoding="utf-8") as stream:  # noqa: PTH123
        data = json.load(stream)
    assert data["type"] == "FeatureCollection"
    found = {"room": [], "border": [], "drawn_border": []}
    for feature in data["features"]:
        properties = feature["properties"]
        shape = shapely.geometry.shape(feature["geometry"])
        found[properties["layer"]].append((properties, shape))
    return found


def test_geojson_has_rooms_and_borders_in_the_map_frame(map_path, flat):
    exported("-o", "r.geojson")
    found = features("r.geojson")
    rooms = [shape for _, shape in found["room"]]
    assert all(room.is_valid for room in rooms)
    assert sum(a.intersection(b).area for a in rooms for b in rooms if a is not b) < 1e-6
    for k, room in enumerate(rooms):
        inside = shapely.contains_xy(room.buffer(0.05), flat.nodes.position)
        assert inside[flat.ground_truth.room == k].all()
        assert found["room"][k][0]["nodes"] == (flat.ground_truth.room == k).sum()
    # The corridor, room 2, meets both others at the doors, whose middle is 2.0 m and 5.6 m.
    assert {tuple(p["rooms"]) for p, _ in found["border"]} == {(0, 2), (1, 2)}
    for properties, line in found["border"]:
        door = drift(np.array([[2.0 if properties["rooms"][0] == 0 else 5.6, 1.54]]))[0]
        assert line.distance(shapely.Point(door)) < 0.15
    assert len(found["drawn_border"]) == len(flat.ground_truth.borders)


def test_rooms_are_called_as_the_ground_truth_calls_them(map_path, flat):
    truth = replace(flat.ground_truth, room_names=("Küche", "", "hall"))
    write_map("flat.h5", replace(flat, ground_truth=truth))
    exported("-o", "r.geojson", "-o", "r.yaml")
    called = ["Küche", "room-2", "hall"]
    assert [properties["name"] for properties, _ in features("r.geojson")["room"]] == called
    with open("r_rooms.csv", encoding="utf-8") as stream:  # noqa: PTH123
        assert [line["name"] for line in csv.DictReader(stream)] == called
    write_rooms("flat.h5", flat.ground_truth.room // 2, model="m", rooms=2)
    exported("-o", "r.geojson", "--rooms", "found")
    found = [properties["name"] for properties, _ in features("r.geojson")["room"]]
    assert found == ["room-1", "room-2"]


def test_drawn_borders_follow_the_map(flat):
    """The scene's borders are bent as the map is, but for its noise."""
    bent = drift(flat.ground_truth.borders.reshape(-1, 2)).reshape(-1, 2, 2)
    np.testing.assert_allclose(drawn_borders(flat), bent, atol=0.06)
    real = cleaned_flat(real=True)
    np.testing.assert_array_equal(drawn_borders(real), real.ground_truth.borders)


def test_rooms_are_those_asked_for(map_path, capsys):
    exported("-o", "r.geojson")
    assert len(features("r.geojson")["room"]) == 3
    exported("-o", "r.geojson", "--rooms", "found")
    assert len(features("r.geojson")["room"]) == 2


def pixels_of(layer):
    runs = np.array(layer["compressedPixels"]).reshape(-1, 3)
    return {(x + k, y) for x, y, count in runs.tolist() for k in range(count)}


def test_valetudo_layers_are_the_grid_upside_down(map_path, flat):
    exported("-o", "v.json", "--format", "valetudo")
    with open("v.json", encoding="utf-8") as stream:  # noqa: PTH123
        data = json.load(stream)
    assert data["__class"] == "ValetudoMap" and data["pixelSize"] == 5
    middle = data["size"]["x"] // 2
    segments = {
        layer["metaData"]["segmentId"]: pixels_of(layer)
        for layer in data["layers"]
        if layer["type"] == "segment"
    }
    assert sorted(segments) == ["1", "2", "3"]
    for (x, y), room in zip(flat.nodes.position, flat.ground_truth.room, strict=True):
        pixel = (math.floor((middle + 100 * x) / 5), math.floor((middle - 100 * y) / 5))
        assert pixel in segments[str(room + 1)]
    for layer in data["layers"]:
        found = pixels_of(layer)
        assert layer["dimensions"]["pixelCount"] == len(found)
        assert layer["metaData"]["area"] == 25 * len(found)
        assert layer["dimensions"]["x"]["min"] == min(x for x, _ in found)
    path = next(item for item in data["entities"] if item["type"] == "path")
    points = (np.array(path["points"]).reshape(-1, 2) - middle) * (0.01, -0.01)
    assert np.abs(points[0] - flat.nodes.position[0]).max() <= 0.0051


def test_images_and_panoramas_with_a_table(flat, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    camera = FisheyeCamera().resized(96)
    few = replace(flat, camera=camera)
    seen = {3: fisheye_image(camera, 1), 7: fisheye_image(camera, 2)}
    write_map("flat.h5", few, [seen.get(k) for k in range(len(few.nodes))])
    exported("-o", "views.csv")
    exported("-o", "views.csv")  # replaces its own pictures
    with open("views.csv", encoding="utf-8", newline="") as stream:  # noqa: PTH123
        table = list(csv.DictReader(stream))
    assert len(table) == len(flat.nodes)
    assert [k for k, row in enumerate(table) if row["image"]] == [3, 7]
    assert float(table[7]["x"]) == flat.nodes.position[7, 0]
    assert int(table[7]["room"]) == flat.ground_truth.room[7]
    image = cv2.imread(table[7]["image"], cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(image, seen[7])
    panorama = cv2.imread(table[7]["panorama"], cv2.IMREAD_UNCHANGED)
    unfold = Unfolding.of(camera, PanoramaParameters())
    np.testing.assert_array_equal(panorama, unfold(seen[7]))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["flat.h5", "views", "views.csv"]
    assert len(list((tmp_path / "views").iterdir())) == 4


def test_a_folder_with_anything_else_is_not_replaced(flat, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    camera = FisheyeCamera().resized(16)
    image = np.zeros((16, 16), np.uint8)
    write_map("flat.h5", replace(flat, camera=camera), [image] + [None] * (len(flat.nodes) - 1))
    (tmp_path / "views").mkdir()
    (tmp_path / "views" / "mine.txt").write_text("x")
    assert main(["export", "flat.h5", "-o", "views.csv"]) == 2
    assert "views: holds mine.txt, which would be lost" in capsys.readouterr().err
    assert not (tmp_path / "views.csv").exists()


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (("-o", "i.csv"), "flat.h5: has no images; `roomseg render flat.h5` makes them"),
        (("-o", "g.svg"), "g.svg: is made of an apartment, not of a map (flat.h5)"),
        (("-o", "g.graphml", "--rooms", "found"), "--rooms: has no meaning for graphml"),
        (
            ("-o", "r.yaml", "--resolution", "0.001"),
            "m, expected at most 4 million; choose a coarser resolution",
        ),
        (("-o", "x.h5"), "x.h5: a name that ends in .h5 is a map's, expected another"),
    ],
)
def test_what_cannot_be_written_is_one_line(map_path, capsys, arguments, line):
    assert main(["export", "flat.h5", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and line in err


def test_a_map_without_rooms_is_told(flat, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_map("flat.h5", replace(flat, ground_truth=None))
    assert main(["export", "flat.h5", "-o", "r.geojson"]) == 2
    assert "flat.h5: has no rooms; `roomseg segment` finds them" in capsys.readouterr().err
    assert main(["export", "flat.h5", "-o", "r.yaml", "--rooms", "truth"]) == 2
    assert "flat.h5: has no ground truth" in capsys.readouterr().err
    exported("-o", "r.yaml")
    assert not (tmp_path / "r_rooms.png").exists()


def test_tables_are_what_the_arrays_are(map_path, flat):
    pandas = pytest.importorskip("pandas")
    with MapFile(map_path) as file:
        nodes, edges = file.nodes_table(), file.edges_table()
        points, visits = file.obstacles_table(), file.visits_table()
    assert isinstance(nodes, pandas.DataFrame) and nodes.index.name == "node"
    np.testing.assert_array_equal(nodes[["x", "y"]], flat.nodes.position)
    np.testing.assert_array_equal(nodes.room, flat.ground_truth.room)
    assert not nodes.image.any()
    # Border edges join different rooms here.
    different = nodes.room[edges["first"]].array != nodes.room[edges["second"]].array
    assert (different == edges.border).mean() > 0.95
    np.testing.assert_array_equal(points[["x", "y"]], flat.obstacles.position)
    np.testing.assert_array_equal(visits.time, flat.visits.time)
