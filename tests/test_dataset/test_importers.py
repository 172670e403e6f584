"""Runs of robots as maps: nodes, lanes, parts and edges of a track; Valetudo and ROS files."""

from __future__ import annotations

import copy
import json
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dataset import (
    RoomsegError,
    borders_between,
    crosses_border,
    problems,
    read_map,
    write_map,
)
from dataset.importers.edges import adjacent_pairs, connected_drive
from dataset.importers.rosbag import read_rosbag
from dataset.importers.track import Track, drive_of
from dataset.importers.valetudo import read_valetudo


def track_of(*strokes, speed=0.2):
    """A track along the corners of each stroke."""
    position = np.array([p for stroke in strokes for p in stroke], dtype=float)
    number = np.repeat(np.arange(len(strokes)), [len(stroke) for stroke in strokes])
    step = np.r_[0.0, np.hypot(*np.diff(position, axis=0).T)]
    heading = np.zeros(len(position))
    return Track(np.cumsum(step) / speed, position, heading, number)


def meander(lanes, length=2.0, spacing=0.3):
    corners = []
    for k in range(lanes):
        ends = [(0.0, k * spacing), (length, k * spacing)]
        corners += ends[:: -1 if k % 2 else 1]
    return corners


def test_nodes_come_every_ten_centimetres():
    drive = drive_of(track_of([(0, 0), (1, 0)]))
    np.testing.assert_allclose(drive.nodes.position[:, 0], np.arange(11) * 0.1, atol=1e-6)
    np.testing.assert_allclose(drive.visits.time, np.arange(11) * 0.5, atol=1e-6)
    assert drive.driven.tolist() == [[k, k + 1] for k in range(10)]


def test_a_meander_is_one_part_with_its_lanes_in_order():
    drive = drive_of(track_of(meander(4)))
    nodes = drive.nodes
    assert set(nodes.part.tolist()) == {0}
    assert sorted(set(nodes.lane.tolist())) == [0, 1, 2, 3]
    inside = (nodes.position[:, 0] > 0.15) & (nodes.position[:, 0] < 1.85)
    np.testing.assert_array_equal(nodes.lane[inside], np.rint(nodes.position[inside, 1] / 0.3))


def test_a_lane_across_begins_a_part():
    drive = drive_of(track_of([*meander(3), (2.0, 3.0)]))
    x, y = drive.nodes.position.T
    assert set(drive.nodes.part[y < 0.65][x[y < 0.65] < 1.9].tolist()) == {0}
    assert set(drive.nodes.part[y > 0.65].tolist()) == {1}


def test_a_circle_is_lanes_of_its_own():
    angle = np.linspace(0, 2 * np.pi, 60)[:-4]
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1) * 0.3
    nodes = drive_of(track_of(circle)).nodes
    lanes = np.unique(np.stack([nodes.part, nodes.lane]), axis=1).shape[1]
    assert lanes == 2
    assert len(nodes) == pytest.approx(2 * np.pi * 0.3 / 0.1, abs=3)


def test_the_way_back_visits_what_is_there():
    drive = drive_of(track_of([(0, 0), (1, 0), (0, 0)]))
    assert len(drive.nodes) == 11
    assert len(drive.visits.node) == 21
    assert (np.bincount(drive.visits.node) == [2] * 10 + [1]).all()


def test_edges_join_lanes_where_nothing_is_between():
    drive = drive_of(track_of(meander(2)))
    free = {tuple(e) for e in adjacent_pairs(drive, np.empty((0, 2))).tolist()}
    x = np.arange(0.5, 1.5, 0.02)
    wall = np.stack([x, np.full_like(x, 0.15)], axis=1)
    barred = {tuple(e) for e in adjacent_pairs(drive, wall).tolist()}
    position = drive.nodes.position
    assert barred < free
    for a, b in free - barred:
        middle = position[[a, b]].mean(axis=0)
        assert 0.35 < middle[0] < 1.65
    across = [(a, b) for a, b in barred if drive.nodes.lane[a] != drive.nodes.lane[b]]
    assert not [e for e in across if 0.55 < position[list(e), 0].mean() < 1.45]
    # Within a lane, only those that follow each other, wall or not.
    assert {tuple(e) for e in drive.driven.tolist()} <= barred
    same = [(a, b) for a, b in free if drive.nodes.lane[a] == drive.nodes.lane[b]]
    assert all(b == a + 1 for a, b in same)
    lengths = [np.hypot(*(position[a] - position[b])) for a, b in free]
    assert max(lengths) <= 0.40 + 1e-9 and max(lengths) > 0.3


def test_near_pieces_are_joined_and_far_ones_left_out():
    near = drive_of(track_of([(0, 0), (1, 0)], [(1.8, 0), (2.5, 0)], [(9, 9), (9.5, 9)]))
    drive, edges, notes = connected_drive(near, adjacent_pairs(near, np.empty((0, 2))))
    assert len(drive.nodes) == 11 + 8
    assert drive.nodes.position[:, 0].max() < 3
    assert set(drive.visits.node.tolist()) == set(range(19))
    assert [10, 11] in edges.tolist()
    assert edges.max() == 18
    assert len(notes) == 2 and "0.80 m apart" in notes[0] and "6 nodes" in notes[1]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(3, 60), st.integers(1, 4))
def test_borders_part_the_rooms_of_any_graph(seed, n, rooms):
    """Every edge between rooms crosses a border; without borders the rooms fall apart."""
    rng = np.random.default_rng(seed)
    position = rng.uniform(0, 3, (n, 2))
    a, b = np.triu_indices(n, 1)
    near = np.hypot(*(position[a] - position[b]).T) < 0.8
    edges = np.stack([a[near], b[near]], axis=1).astype(np.int32)
    room = rng.integers(0, rooms, n).astype(np.int32)
    borders = borders_between(position, edges, room)
    crossed = crosses_border(position, edges, borders)
    assert crossed[room[edges[:, 0]] != room[edges[:, 1]]].all()
    assert borders.shape[1:] == (2, 2)
    if rooms == 1:
        assert not len(borders)


def valetudo(path=(200, 200, 400, 200, 400, 230, 200, 230, 200, 260, 400, 260), **changes):
    """Two rooms of 1 m beside each other, open to each other, walls around: cm, pixels of 5."""

    def layer(kind, runs, **meta):
        return {"type": kind, "metaData": meta, "pixels": [], "compressedPixels": runs}

    rows = range(36, 58)
    walls = [34, 34, 53, 34, 60, 53] + [v for y in rows for x in (34, 86) for v in (x, y, 1)]
    data = {
        "__class": "ValetudoMap",
        "metaData": {"version": 2},
        "size": {"x": 600, "y": 600},
        "pixelSize": 5,
        "layers": [
            layer("wall", walls),
            layer("segment", [v for y in rows for v in (35, y, 25)], segmentId="1", name="Bad"),
            layer("segment", [v for y in rows for v in (60, y, 26)], segmentId=2),
            layer("segment", [90, 10, 5], segmentId="7"),
        ],
        "entities": [
            {"type": "path", "metaData": {}, "points": list(path)},
            {"type": "robot_position", "metaData": {"angle": 3}, "points": [200, 200]},
        ],
    }
    return data | changes


def read_data(tmp_path, data):
    file = tmp_path / "run.json"
    file.write_text(json.dumps(data), encoding="utf-8")
    return read_valetudo(file)


def test_a_valetudo_map_is_a_sound_map(tmp_path):
    run = read_data(tmp_path, valetudo())
    write_map(tmp_path / "run.h5", run.topomap)
    assert list(problems(tmp_path / "run.h5")) == []
    m = read_map(tmp_path / "run.h5")
    assert (m.environment, m.run, m.robot_radius) == ("run", "run", 0.17)
    # Three lanes of 2 m; y is up, the picture's middle the origin.
    assert m.nodes.position[0].tolist() == pytest.approx([-1.0, 1.0])
    assert m.nodes.position[:, 1].min() == pytest.approx(0.4)
    assert sorted(set(m.nodes.lane.tolist())) == [0, 1, 2]
    assert m.nodes.heading[3] == pytest.approx(0.0)
    truth = m.ground_truth
    assert truth.room_count == 2 and truth.frame == "map"
    # The segments meet at pixel 60, which is x = 0.
    x = m.nodes.position[:, 0]
    clear = np.abs(x) > 0.01
    np.testing.assert_array_equal(truth.room[clear], x[clear] > 0)
    different = truth.room[m.edges[:, 0]] != truth.room[m.edges[:, 1]]
    np.testing.assert_array_equal(truth.edge_is_border, different)
    assert truth.room_names == ("Bad", "segment 2")
    assert "segment: 1 'Bad' (" in run.notes[0] and ", 2 'segment 2' (" in run.notes[0]
    assert run.notes[1] == "no path in 'segment 7': no rooms of the map"


def test_segments_of_one_name_stay_rooms_and_names_are_one_line(tmp_path):
    data = valetudo()
    for layer, name in zip(data["layers"][1:], ("Bad", "Bad", " "), strict=True):
        layer["metaData"]["name"] = name
    run = read_data(tmp_path, data)
    assert run.topomap.ground_truth.room_names == ("Bad", "Bad")
    assert run.notes[1] == "no path in 'segment 7': no rooms of the map"
    data["layers"][1]["metaData"]["name"] = "Bad\n\0 oben \u202e" + "x" * 100
    name = read_data(tmp_path, data).topomap.ground_truth.room_names[0]
    assert name == ("Bad oben " + "x" * 100)[:60]


def test_obstacle_points_lie_on_wall_pixels_in_reach(tmp_path):
    m = read_data(tmp_path, valetudo()).topomap
    points = m.obstacles.position
    assert len(points) > 50
    # The upper wall's pixels end at y = 600/2 - 35 * 5 = 125 cm.
    upper = points[:, 1] > 1.2
    assert upper.any() and points[upper, 1] == pytest.approx(1.25, abs=0.011)
    lower = points[:, 1] < 0.01
    assert lower.any() and points[lower, 1] == pytest.approx(0.0, abs=0.011)
    assert np.abs(points[~upper & ~lower, 0]).min() > 1.24
    order = np.argsort(m.visits.time)
    at = [np.interp(m.obstacles.time, m.visits.time[order], m.nodes.position[m.visits.node[order], k]) for k in (0, 1)]  # noqa: E501  # fmt: skip
    assert np.hypot(*(points - np.transpose(at)).T).max() < 1.2
    assert set(m.obstacles.beam.tolist()) <= set(range(8))


def test_a_thin_wall_keeps_lanes_apart(tmp_path):
    walls = {"type": "wall", "metaData": {}, "pixels": [], "compressedPixels": [45, 43, 30]}
    data = valetudo()
    plain = read_data(tmp_path, data).topomap
    data["layers"].append(walls)
    parted = read_data(tmp_path, data).topomap
    across = [abs(t.nodes.position[t.edges, 1] - 0.85).max(axis=1) < 0.3 for t in (plain, parted)]
    middle = [
        int((np.ptp(t.nodes.position[t.edges, 1], axis=1) > 0.1)[a].sum())
        for t, a in zip((plain, parted), across, strict=True)
    ]
    assert middle[1] < middle[0] / 2


def test_pieces_of_a_path_and_no_segments(tmp_path):
    data = valetudo()
    data["layers"] = data["layers"][:1]
    data["entities"].append({"type": "path", "points": [450, 200, 480, 200]})
    data["entities"].append({"type": "predicted_path", "points": [0, 0, 9, 9]})
    run = read_data(tmp_path, data)
    assert run.topomap.ground_truth is None
    assert run.notes == (
        "two pieces of the path, 0.50 m apart, are joined",
        "has no segments: the map has no ground truth",
    )


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"__class": "Map"}, "__class: 'Map', expected 'ValetudoMap'"),
        ({"entities": []}, "entities: no path, expected one with points; save the map after a run"),
        (
            {"pixelSize": 0},
            "pixelSize: '0', Input should be greater than or equal to 1; expected a Valetudo map",
        ),
        ({"layers": 3}, "layers: '3', Input should be a valid array; expected a Valetudo map"),
        ({"size": {"x": 1}}, "size.y: Field required; expected a Valetudo map"),
        (
            {"layers": [{"type": "wall", "compressedPixels": [1, 2]}]},
            "layers.0.compressedPixels: 2 numbers, expected runs of x, y, length",
        ),
        (
            {"layers": [{"type": "wall", "pixels": [1]}]},
            "layers.0.pixels: 1 numbers, expected pairs x, y",
        ),
        (
            {"layers": [{"type": "wall", "compressedPixels": [1, 1, 100000] * 200}]},
            "layers.0.compressedPixels: 20000000 pixels, expected fewer",
        ),
        (
            {"entities": [{"type": "path", "points": [1, 2, 3]}]},
            "entities.0.points: 3 numbers, expected pairs x, y",
        ),
        (
            {"entities": [{"type": "path", "points": [0, 0, 1e6, 1e6, 0, 0]}]},
            "entities: a path of 28294 m, expected at most 20000 m",
        ),
    ],
)  # fmt: skip
def test_faults_of_valetudo_files_are_one_line(tmp_path, change, line):
    with pytest.raises(RoomsegError) as error:
        read_data(tmp_path, valetudo(**change))
    assert str(error.value) == f"{tmp_path / 'run.json'}: {line}"


LEAVES = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=5),
    st.lists(st.integers(-10, 200_000), max_size=4), st.just({}), st.just(1e308), st.just(10**400),
)  # fmt: skip


def places(data, at=()):
    """Every place of a JSON value, as keys."""
    yield at
    items = data.items() if isinstance(data, dict) else enumerate(data)
    for key, value in items:
        if isinstance(value, dict | list) and len(value) < 60:
            yield from places(value, (*at, key))
        else:
            yield (*at, key)


@settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.data())
def test_damaged_json_is_one_line_or_a_sound_map(tmp_path, data):
    whole = valetudo()
    at = data.draw(st.sampled_from(sorted(set(places(whole)) - {()}, key=str)))
    damaged = copy.deepcopy(whole)
    parent = damaged
    for key in at[:-1]:
        parent = parent[key]
    if data.draw(st.booleans()):
        parent[at[-1]] = data.draw(LEAVES)
    else:
        del parent[at[-1]]
    text = json.dumps(damaged)
    if data.draw(st.booleans()):
        text = text[: data.draw(st.integers(0, len(text)))]
    file = tmp_path / "run.json"
    file.write_text(text, encoding="utf-8")
    try:
        run = read_valetudo(file)
    except RoomsegError as error:
        assert str(error).startswith(f"{file}: ") and "\n" not in str(error)
    else:
        write_map(tmp_path / "run.h5", run.topomap)
        assert list(problems(tmp_path / "run.h5")) == []


# ---- ROS ------------------------------------------------------------------------------------

TOPICS = """
[robot]
radius = 0.2

[odometry]
topic = "/odom"

[[range]]
topic = "/scan"
heading_deg = 90.0
beams = 5

[[range]]
topic = "/sonar"
position = [0.1, 0.0]

[camera]
topic = "/camera"
field_of_view_deg = 180
turn_deg = 90
"""


def drive_through(seconds=40):
    """Poses at 10 Hz: 2 m ahead, a turn, 0.3 m aside, and back."""
    corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 0.3), (0.0, 0.3)]
    poses = []
    for (x0, y0), (x1, y1) in pairwise(corners):
        heading = np.arctan2(y1 - y0, x1 - x0)
        for s in np.linspace(0, 1, int(np.hypot(x1 - x0, y1 - y0) / 0.02), endpoint=False):
            poses.append((x0 + s * (x1 - x0), y0 + s * (y1 - y0), heading))
    return poses


@pytest.fixture(params=["ros1", "ros2"])
def bag(request, tmp_path):
    """A bag of a robot that sees a wall at y = -0.5 to its right and 0.6 m ahead."""
    pytest.importorskip("rosbags")
    return write_bag(tmp_path, request.param)


def write_bag(tmp_path, kind, topics=TOPICS):  # noqa: C901  # one maker a message
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    first = kind == "ros1"
    store = get_typestore(Stores.ROS1_NOETIC if first else Stores.ROS2_HUMBLE)
    t = {name.rsplit("/", 1)[-1]: cls for name, cls in store.types.items()}
    path = tmp_path / ("run.bag" if first else "run")

    def header(k):
        stamp = store.types["builtin_interfaces/msg/Time"](sec=k // 10, nanosec=0)
        return t["Header"](stamp=stamp, frame_id="base", **({"seq": k} if first else {}))

    def odometry(k, x, y, yaw):
        q = t["Quaternion"](x=0.0, y=0.0, z=np.sin(yaw / 2), w=np.cos(yaw / 2))
        pose = t["Pose"](position=t["Point"](x=x, y=y, z=0.0), orientation=q)
        zero = t["Vector3"](x=0.0, y=0.0, z=0.0)
        twist = t["Twist"](linear=zero, angular=zero)
        return t["Odometry"](
            header=header(k),
            child_frame_id="base",
            pose=t["PoseWithCovariance"](pose=pose, covariance=np.zeros(36)),
            twist=t["TwistWithCovariance"](twist=twist, covariance=np.zeros(36)),
        )

    def scan(k, y, yaw):
        # The sensor looks left (heading_deg 90): what is at y = -0.5 is behind it.
        bearing = np.linspace(-np.pi, np.pi, 5)
        direction = bearing + np.pi / 2 + yaw
        with np.errstate(divide="ignore"):
            ranges = (-0.5 - y) / np.sin(direction)
        ranges[(ranges <= 0) | (ranges > 3)] = np.inf
        return t["LaserScan"](
            header=header(k), angle_min=-np.pi, angle_max=np.pi, angle_increment=np.pi / 2,
            time_increment=0.0, scan_time=0.1, range_min=0.05, range_max=3.0,
            ranges=ranges.astype(np.float32), intensities=np.zeros(0, np.float32),
        )  # fmt: skip

    def sonar(k):
        return t["Range"](
            header=header(k), radiation_type=0, field_of_view=0.1, min_range=0.02, max_range=2.0,
            range=0.5,
        )  # fmt: skip

    def image(k):
        picture = np.zeros((6, 8, 3), np.uint8)
        picture[0, :, :] = k % 200 + 50
        return t["Image"](
            header=header(k), height=6, width=8, encoding="rgb8", is_bigendian=0, step=24,
            data=picture.ravel(),
        )  # fmt: skip

    with Writer1(path) if first else Writer2(path, version=9) as writer:
        names = {
            "/odom": "nav_msgs/msg/Odometry", "/scan": "sensor_msgs/msg/LaserScan",
            "/sonar": "sensor_msgs/msg/Range", "/camera": "sensor_msgs/msg/Image",
        }  # fmt: skip
        connections = {k: writer.add_connection(k, v, typestore=store) for k, v in names.items()}
        pack = store.serialize_ros1 if first else store.serialize_cdr

        def write(topic, time, message):
            writer.write(connections[topic], int(1e9 * time), bytes(pack(message, names[topic])))

        for k, (x, y, yaw) in enumerate(drive_through()):
            time = 1000.0 + k / 10
            write("/odom", time, odometry(k, x, y, yaw))
            if k % 2 == 0:
                write("/scan", time, scan(k, y, yaw))
            if k % 5 == 0:
                write("/camera", time, image(k))
            if k == 50:
                write("/sonar", time, sonar(k))
    (tmp_path / "topics.toml").write_text(topics, encoding="utf-8")
    return path


def test_a_bag_is_a_sound_map_with_images(bag, tmp_path):
    run = read_rosbag(bag, topics=tmp_path / "topics.toml", name="lab")
    write_map(tmp_path / "run.h5", run.topomap, run.images)
    assert list(problems(tmp_path / "run.h5")) == []
    m = run.topomap
    assert (m.environment, m.run, m.robot_radius) == ("lab", "run", 0.2)
    assert len(m.nodes) == pytest.approx(44, abs=2)
    assert set(m.nodes.part.tolist()) == {0} and set(m.nodes.lane.tolist()) == {0, 1}
    # The wall to the right, and what the sonar saw once: 0.6 m ahead of x = 1.0.
    points = m.obstacles.position
    once = points[:, 1] > -0.4
    assert points[~once, 1] == pytest.approx(-0.5, abs=1e-5) and (~once).sum() > 10
    assert points[once] == pytest.approx(np.array([[1.6, 0.0]]), abs=1e-5)
    # Rows become columns by the turn; the first image is the first node's.
    images = list(run.images)
    assert m.camera.image_size == images[0].shape == (8, 6)
    assert (images[0][:, 0] == 50).all() and not images[0][:, 1:].any()
    created = m.visits.time[np.unique(m.visits.node, return_index=True)[1]]
    shown = np.array([image.max() for image in images], dtype=float)
    nearest = np.minimum(5 * np.rint(created * 2), 5 * ((len(drive_through()) - 1) // 5))
    assert np.abs(shown - (nearest % 200 + 50)).max() <= 5


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ('"/odom"', '"/pose"', ": no topic /pose, expected one of: /camera, /odom, /scan, /sonar"),
        ('"/odom"', '"/scan"', ": /scan: is sensor_msgs/msg/LaserScan, expected Odometry or"),
        ("beams = 5", "beams = 0", "range.0.beams: Input should be greater than or equal to 1"),
        ("beams = 5", "beam = 5", "range.0.beam: Extra inputs are not permitted"),
        ("turn_deg = 90", "turn_deg = 45", "camera.turn_deg: Input should be 0, 90, 180 or 270"),
        ("[robot]", "[robot", "; expected TOML"),
        ("field_of_view_deg = 180", "", "camera.field_of_view_deg: Field required"),
        ("turn_deg", "disc_centre = [99.0, 1.0]\nturn_deg", "camera: disc_centre: (99.0, 1.0)"),
    ],
)
def test_faults_of_topics_are_one_line(tmp_path, old, new, line):
    pytest.importorskip("rosbags")
    bag = write_bag(tmp_path, "ros2", TOPICS.replace(old, new))
    with pytest.raises(RoomsegError) as error:
        read_rosbag(bag, topics=tmp_path / "topics.toml")
    assert line in str(error.value) and "\n" not in str(error.value)


def test_damaged_bags_are_one_line(bag, tmp_path):
    files = [bag] if bag.is_file() else [bag / "run.db3", bag / "metadata.yaml"]
    rng = np.random.default_rng(1)
    for file in files:
        whole = file.read_bytes()
        for cut in rng.integers(0, len(whole) // 2, 5).tolist():
            file.write_bytes(whole[:cut])
            with pytest.raises(RoomsegError) as error:
                list(read_rosbag(bag, topics=tmp_path / "topics.toml").images)
            assert str(error.value).startswith(f"{bag}: ") and "\n" not in str(error.value)
        file.write_bytes(whole)


def test_a_bag_reads_nothing_outside_its_folder(tmp_path):
    pytest.importorskip("rosbags")
    bag = write_bag(tmp_path, "ros2")
    (bag / "run.db3").rename(tmp_path / "run.db3")
    metadata = bag / "metadata.yaml"
    text = metadata.read_text(encoding="utf-8")
    assert "run.db3" in text
    metadata.write_text(text.replace("run.db3", "../run.db3"), encoding="utf-8")
    with pytest.raises(RoomsegError, match="damaged bag"):
        read_rosbag(bag, topics=tmp_path / "topics.toml")
