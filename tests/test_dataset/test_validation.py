"""Each check against a real file of which exactly one thing is wrong."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

from dataset import FormatError, MapFile, problems, read_map, summarise


def put(name, value):
    """Replace an array, keeping its attributes."""

    def spoil(file):
        attributes = dict(file[name].attrs)
        del file[name]
        file[name] = value
        file[name].attrs.update(attributes)

    return spoil


def change(name, where, value):
    """Change one value of an array."""

    def spoil(file):
        array = file[name][()]
        array[where] = value
        put(name, array)(file)

    return spoil


def visit(where, field, value):
    def spoil(file):
        rows = file["visits"][()]
        rows[field][where] = value
        put("visits", rows)(file)

    return spoil


def remove(name):
    def spoil(file):
        del file[name]

    return spoil


def attribute(group, name, value):
    def spoil(file):
        if value is None:
            del file[group].attrs[name]
        else:
            file[group].attrs[name] = value

    return spoil


def reorder_edges(file):
    edges = file["edges"][()]
    edges[[0, 1]] = edges[[1, 0]]
    put("edges", edges)(file)


def unsaved_image(file):
    done = file["images/done"][()]
    images = file["images/pixels"][()]
    del file["images/pixels"]
    pixels = file.create_dataset("images/pixels", (8, 16, 16), "u1", chunks=(1, 16, 16))
    pixels[:7] = images[:7]
    assert done.all()


def damaged_image(file):
    file["images/pixels"].id.write_direct_chunk((3, 0, 0), b"no deflated pixels")


def scene_frame_without_poses(file):
    del file["nodes/true_pose"]


def no_rooms_and_no_labels(file):
    del file["ground_truth/room"]
    file["ground_truth"].attrs["room_count"] = 0


CASES = {
    "missing array": (remove("edges"), "/edges: missing"),
    "missing group": (
        remove("obstacles"),
        "/obstacles/position: missing|/obstacles/time: missing|/obstacles/beam: missing",
    ),
    "missing visits": (remove("visits"), "/visits: missing"),
    "half an optional group": (remove("path/lane"), "/path/lane: missing"),
    "group for an array": (
        lambda file: (remove("edges")(file), file.create_group("edges")),
        "/edges: missing",
    ),
    "wrong type": (
        put("nodes/part", np.zeros(8)),
        "/nodes/part: type float64, expected int",
    ),
    "wrong rows": (
        put("visits", np.zeros((10, 2))),
        "/visits: type float64, expected (node, time) rows",
    ),
    "wrong length": (
        put("nodes/heading", np.zeros(7)),
        "/nodes/heading: shape (7,), expected (8,)",
    ),
    "wrong rank": (
        put("obstacles/position", np.zeros(4)),
        "/obstacles/position: shape (4,), expected ('k', 2)",
    ),
    "not finite": (
        change("nodes/position", (3, 1), np.nan),
        "/nodes/position: nan at (3, 1), expected finite numbers",
    ),
    "infinite": (
        change("obstacles/time", 1, np.inf),
        "/obstacles/time: inf at (1,), expected finite numbers",
    ),
    "part below zero": (
        change("nodes/part", 5, -1),
        "/nodes/part: node 5 has -1, expected >= 0",
    ),
    "lane below zero": (
        change("nodes/lane", 2, -2),
        "/nodes/lane: node 2 has -2, expected >= 0",
    ),
    "edge to nowhere": (
        change("edges", (9, 1), 8),
        "/edges: row 9 is [6, 8], expected nodes 0..7",
    ),
    "edge to node -1": (
        change("edges", (0, 0), -1),
        "/edges: row 0 is [-1, 1], expected nodes 0..7",
    ),
    "edge upside down": (
        change("edges", 5, (6, 2)),
        "/edges: row 5 is [6, 2], expected the smaller node first|/edges: row 6 is out of order",
    ),
    "edges out of order": (reorder_edges, "/edges: row 1 is out of order"),
    "edge twice": (
        change("edges", 1, (0, 1)),
        "/edges: row 1 repeats the edge [0, 1]",
    ),
    "graph in pieces": (
        lambda file: (
            put("edges", file["edges"][()][[0, 2, 4, 7, 8, 9]])(file),
            put("ground_truth/edge_is_border", np.array([0, 1, 0, 0, 1, 0], bool))(file),
        ),
        "/edges: the graph has 2 pieces, expected 1: node 4 is apart from node 0",
    ),
    "visit of no node": (visit(9, "node", 8), "/visits: row 9 names node 8, expected 0..7"),
    "visits out of order": (
        visit(4, "time", 9.5),
        "/visits: row 5 is earlier than the one before",
    ),
    "visit at no time": (visit(4, "time", np.nan), "/visits: row 4 has no finite time"),
    "node never created": (
        visit(5, "node", 4),
        "/visits: node 5 has none, expected its creation",
    ),
    "no environment": (
        attribute("/", "environment", None),
        "attribute environment of /: None, expected text",
    ),
    "seed is text": (
        attribute("/", "seed", "seven"),
        "attribute seed of /: seven, expected a number",
    ),
    "environment without a name": (
        attribute("/", "environment", ""),
        "attribute environment of /: empty, expected a name",
    ),
    "robot without size": (
        attribute("/", "robot_radius", 0.0),
        "attribute robot_radius of /: 0.0, expected > 0 m"
        "|attribute radius of /robot: 0.15, expected robot_radius of /, 0.0",
    ),
    "robot with two sizes in one": (
        attribute("/", "robot_radius", np.array([0.15, 0.2])),
        "attribute robot_radius of /: [0.15 0.2 ], expected a number"
        "|attribute radius of /robot: 0.15, expected robot_radius of /, [0.15 0.2 ]",
    ),
    "robot of two sizes": (
        attribute("robot", "radius", 0.2),
        "attribute radius of /robot: 0.2, expected robot_radius of /, 0.15",
    ),
    "robot setting that is no number": (
        attribute("robot", "lane_spacing", np.nan),
        "attribute lane_spacing of /robot: nan, expected a number",
    ),
    "sensors in an array": (
        lambda file: file.create_dataset("sensor", data=[1.0]),
        "/sensor: no group, expected one with attributes",
    ),
    "no camera": (
        remove("camera"),
        "/camera: missing, expected a group with the camera's attributes",
    ),
    "other camera model": (
        attribute("camera", "model", "pinhole"),
        "attribute model of /camera: 'pinhole', expected 'equidistant'",
    ),
    "camera without height": (
        attribute("camera", "height", 0.0),
        "/camera: height: 0.0, expected > 0 m",
    ),
    "disc outside the image": (
        attribute("camera", "disc_centre", [8.0, 9.0]),
        "/camera: a disc of 16 px around (8.0, 9.0) leaves an image of (16, 16) px, "
        "in which there is room for it",
    ),
    "images of another size": (
        attribute("camera", "image_size", [16, 17]),
        "/images/pixels: images of (16, 16) px, expected (16, 17)",
    ),
    "image marked, but not there": (
        unsaved_image,
        "/images/done: node 7 is marked done, but has no image",
    ),
    "damaged image": (damaged_image, "/images/pixels: the image of node 3 is damaged"),
    "wide pixels": (
        put("images/pixels", np.zeros((8, 16, 16), np.uint16)),
        "/images/pixels: type uint16, expected uint8",
    ),
    "no gain": (change("images/gain", 2, 0.0), "/images/gain: 0.0 of node 2, expected > 0"),
    "done of other nodes": (
        put("images/done", np.ones(9, bool)),
        "/images/done: shape (9,), expected (8,)",
    ),
    "image flags missing": (remove("images/done"), "/images/done: missing"),
    "unknown frame": (
        attribute("ground_truth/borders", "frame", "world"),
        "attribute frame of /ground_truth/borders: 'world', expected scene or map",
    ),
    "scene frame without poses": (
        scene_frame_without_poses,
        "/ground_truth/borders: frame is scene, but /nodes/true_pose is missing",
    ),
    "border edge not marked": (
        change("ground_truth/edge_is_border", 2, False),
        "/ground_truth/edge_is_border: edge 2 crosses a border, but is not marked",
    ),
    "inner edge marked": (
        change("ground_truth/edge_is_border", 0, True),
        "/ground_truth/edge_is_border: edge 0 is marked, but crosses no border",
    ),
    "no room count": (
        attribute("ground_truth", "room_count", None),
        "attribute room_count of /ground_truth: None, expected a number",
    ),
    "no rooms at all": (
        attribute("ground_truth", "room_count", 0),
        "attribute room_count of /ground_truth: 0, expected >= 1",
    ),
    "no rooms at all, not labelled": (
        no_rooms_and_no_labels,
        "attribute room_count of /ground_truth: 0, expected >= 1",
    ),
    "names of other rooms": (
        attribute("ground_truth", "room_names", np.array(["hall"], h5py.string_dtype())),
        "attribute room_names of /ground_truth: 1, expected 2",
    ),
    "names that are no texts": (
        attribute("ground_truth", "room_names", np.array([1, 2])),
        "attribute room_names of /ground_truth: array([1, 2]), expected texts",
    ),
    "more rooms than labels": (
        attribute("ground_truth", "room_count", 3),
        "/ground_truth/room: 2 rooms, expected room_count = 3",
    ),
    "room of no number": (
        change("ground_truth/room", 4, 2),
        "/ground_truth/room: node 4 has 2, expected 0..1",
    ),
    "segmentation of another map": (
        put("rooms/label", np.zeros(7, np.int32)),
        "/rooms/label: shape (7,), expected (8,)",
    ),
    "segmentation by nobody": (
        attribute("rooms", "model", None),
        "attribute model of /rooms: None, expected text",
    ),
    "scene is no JSON": (
        put("scene", "{"),
        "/scene: no JSON (Expecting property name enclosed in double quotes: "
        "line 1 column 2 (char 1))",
    ),
    "scene is a number": (put("scene", 1.0), "/scene: expected one JSON text"),
}


def test_a_right_map_has_no_problems(full_path, map_path):
    assert list(problems(full_path)) == []
    assert list(problems(map_path)) == []


@pytest.mark.parametrize("case", CASES)
def test_one_fault_gives_its_problem(full_path, case):
    spoil, expected = CASES[case]
    with h5py.File(full_path, "r+") as file:
        spoil(file)
    assert list(problems(full_path)) == expected.split("|")


def test_all_faults_are_told_at_once(full_path):
    with h5py.File(full_path, "r+") as file:
        visit(5, "node", 4)(file)
        change("images/gain", 2, 0.0)(file)
        remove("scene")(file)
        attribute("/", "run", 7)(file)
    assert list(problems(full_path)) == [
        "attribute run of /: 7, expected text",
        "/visits: node 5 has none, expected its creation",
        "/images/gain: 0.0 of node 2, expected > 0",
    ]


def test_a_real_robots_map_needs_no_scene(full_path):
    with h5py.File(full_path, "r+") as file:
        for name in ("scene", "path", "nodes/true_pose", "ground_truth", "images", "rooms"):
            del file[name]
    assert list(problems(full_path)) == []


def test_drawn_borders_are_crossed_by_estimates(full_path):
    with h5py.File(full_path, "r+") as file:
        pose = file["nodes/true_pose"][()] + 100.0
        put("nodes/true_pose", pose)(file)
        file["ground_truth/borders"].attrs["frame"] = "map"
    assert list(problems(full_path)) == []


@pytest.mark.parametrize("case", CASES)
def test_readers_refuse_or_read_what_is_wrong(full_path, case):
    spoil, _ = CASES[case]
    with h5py.File(full_path, "r+") as file:
        spoil(file)
    for read in (read_map, summarise, all_images):
        try:
            read(full_path)
        except FormatError as error:
            assert str(error).startswith(f"{full_path}: ")
            assert "\n" not in str(error)


def all_images(path):
    with MapFile(path) as file:
        file.images[:]
        return [file.gain(node) for node in range(8)], file.rooms, file.preset
