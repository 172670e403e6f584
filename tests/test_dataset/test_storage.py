from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as stn
from sample_maps import assert_same, images_of, two_rooms

from dataset import (
    CameraFlaws,
    FisheyeCamera,
    FormatError,
    GroundTruth,
    MapFile,
    Nodes,
    Obstacles,
    RoomsegError,
    TopoMap,
    Visits,
    problems,
    read_map,
    write_map,
    write_rooms,
)
from dataset import Path as DrivenPath
from dataset.atomic import locked, replacing, write_text

finite = st.floats(allow_nan=False, allow_infinity=False)
texts = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=20)
names = texts.filter(bool)
integers = st.integers(-(2**31), 2**31 - 1)


def floats(*shape: int) -> st.SearchStrategy[np.ndarray]:
    return stn.arrays(np.float64, shape, elements=finite)


def ints(*shape: int) -> st.SearchStrategy[np.ndarray]:
    return stn.arrays(np.int32, shape, elements=integers)


def indices(count: int, most: int = 2**31 - 1) -> st.SearchStrategy[np.ndarray]:
    return stn.arrays(np.int32, count, elements=st.integers(0, most))


def robots(radius: float) -> st.SearchStrategy[dict[str, object] | None]:
    value = st.booleans() | integers | finite | texts | st.lists(finite, max_size=4).map(tuple)
    settings = st.dictionaries(names.filter(lambda name: name not in ("unit", "radius")), value)
    return st.none() | st.tuples(settings, st.booleans()).map(
        lambda drawn: drawn[0] | ({"radius": radius} if drawn[1] else {})
    )


@st.composite
def maps(draw: st.DrawFn) -> TopoMap:
    n, v, k, t, b = (draw(st.integers(low, 6)) for low in (1, 0, 0, 0, 0))
    pairs = [(i, j) for j in range(n) for i in range(j)]
    chosen = draw(st.lists(st.sampled_from(pairs), unique=True)) if pairs else []
    edges = np.array(sorted(chosen), np.int32).reshape(-1, 2)
    truth = GroundTruth(
        borders=draw(floats(b, 2, 2)),
        frame=draw(st.sampled_from(["scene", "map"])),
        edge_is_border=draw(stn.arrays(np.bool_, len(edges))),
        room_count=draw(st.integers(1, 1000)),
        room=draw(st.none() | ints(n)),
    )
    rows, columns = draw(st.tuples(st.integers(1, 999), st.integers(1, 999)))
    camera = FisheyeCamera(
        field_of_view=draw(st.floats(0.1, 6.2)),
        disc_diameter=draw(st.floats(1.0, 1e4)),
        image_size=(rows, columns),
        disc_centre=draw(st.tuples(st.floats(0.0, rows), st.floats(0.0, columns))),
        height=draw(st.floats(0.01, 2.0)),
        flaws=CameraFlaws(*draw(st.tuples(*[st.floats(0.0, 1.0)] * 2, *[st.floats(0.1, 1e6)] * 2))),
    )
    radius = draw(st.floats(0.01, 1.0))
    return TopoMap(
        environment=draw(names),
        run=draw(names),
        seed=draw(st.integers(0, 2**63 - 1)),
        created=draw(texts),
        software=draw(texts),
        nodes=Nodes(
            draw(floats(n, 2)),
            draw(floats(n)),
            draw(indices(n)),
            draw(indices(n)),
            draw(st.none() | floats(n, 3)),
        ),
        edges=edges,
        visits=Visits(draw(indices(v, n - 1)), draw(floats(v))),
        obstacles=Obstacles(draw(floats(k, 2)), draw(floats(k)), draw(stn.arrays(np.uint8, k))),
        robot_radius=radius,
        path=draw(
            st.none() | st.builds(DrivenPath, floats(t), floats(t, 3), floats(t, 3), ints(t))
        ),
        ground_truth=draw(st.none() | st.just(truth)),
        camera=camera,
        scene=draw(st.none() | texts),
        robot=draw(robots(radius)),
        sensor=draw(robots(radius)),
    )


@settings(max_examples=60, deadline=None)
@given(maps())
def test_what_is_written_is_read(topomap):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.h5"
        write_map(path, topomap)
        assert_same(read_map(path), topomap)


def test_settings_are_plain_attributes(tmp_path, topomap):
    path = tmp_path / "map.h5"
    told = {"radius": 0.15, "nodes": 4, "aligned": True, "bearings_deg": (0.0, 30.0), "name": "X1"}
    write_map(path, dataclasses.replace(topomap, robot=told))
    with h5py.File(path) as file:
        attributes = dict(file["robot"].attrs)
        assert "sensor" not in file
    assert "SI" in attributes.pop("unit")
    assert attributes.keys() == told.keys()
    assert attributes["radius"] == 0.15
    assert attributes["name"] == "X1"
    assert attributes["bearings_deg"].tolist() == [0.0, 30.0]
    found = read_map(path).robot
    assert found == told
    assert [type(found[name]) for name in told] == [type(value) for value in told.values()]


@pytest.mark.parametrize(
    ("robot", "said"),
    [
        ({"radius": 0.2}, "robot: radius is 0.2, expected robot_radius 0.15"),
        ({"speed": float("nan")}, "robot: speed is nan, expected finite numbers"),
        ({"speed": None}, "robot: speed is None, expected finite numbers"),
        ({"unit": "m"}, "robot: unit is 'm', expected"),
    ],
)
def test_settings_that_say_nothing_are_refused(topomap, robot, said):
    with pytest.raises(FormatError) as caught:
        dataclasses.replace(topomap, robot=robot)
    assert said in str(caught.value)


def test_long_arrays_survive_compression(tmp_path, topomap):
    rng = np.random.default_rng(1)
    obstacles = Obstacles(
        rng.normal(size=(9000, 2)), rng.random(9000), rng.integers(0, 8, 9000, dtype=np.uint8)
    )
    big = dataclasses.replace(topomap, obstacles=obstacles)
    write_map(tmp_path / "big.h5", big)
    assert_same(read_map(tmp_path / "big.h5"), big)


def test_equal_maps_give_equal_bytes_in_any_process(tmp_path, topomap):
    write_map(tmp_path / "a.h5", topomap, images_of(topomap))
    code = (
        "import sys; from sample_maps import two_rooms, images_of; from dataset import write_map;"
        "m = two_rooms(); write_map(sys.argv[1], m, images_of(m))"
    )
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parent)}
    command = [sys.executable, "-c", code, str(tmp_path / "b.h5")]
    subprocess.run(command, check=True, env=environment)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


def test_layout_is_the_documented_one(full_path):
    found = {}
    with h5py.File(full_path) as file:
        file.visititems(lambda name, item: found.update({name: item}) and None)
        arrays = {k: (v.shape, str(v.dtype)) for k, v in found.items() if hasattr(v, "shape")}
        assert arrays == {
            "edges": ((10, 2), "int32"),
            "ground_truth/borders": ((1, 2, 2), "float64"),
            "ground_truth/edge_is_border": ((10,), "bool"),
            "ground_truth/room": ((8,), "int32"),
            "images/done": ((8,), "bool"),
            "images/gain": ((8,), "float64"),
            "images/pixels": ((8, 16, 16), "uint8"),
            "nodes/heading": ((8,), "float64"),
            "nodes/lane": ((8,), "int32"),
            "nodes/part": ((8,), "int32"),
            "nodes/position": ((8, 2), "float64"),
            "nodes/true_pose": ((8, 3), "float64"),
            "obstacles/beam": ((2,), "uint8"),
            "obstacles/position": ((2, 2), "float64"),
            "obstacles/time": ((2,), "float64"),
            "path/estimate": ((10, 3), "float64"),
            "path/lane": ((10,), "int32"),
            "path/time": ((10,), "float64"),
            "path/true_pose": ((10, 3), "float64"),
            "rooms/label": ((8,), "int32"),
            "scene": ((), "object"),
            "visits": ((10,), "[('node', '<i4'), ('time', '<f8')]"),
        }
        assert file["images/pixels"].chunks == (1, 16, 16)
        assert file["nodes/position"].attrs["unit"] == "m"
        assert file["nodes/heading"].attrs["unit"] == "rad"
        assert file["visits"].attrs["unit"] == "time: s"
        assert file["ground_truth/borders"].attrs["frame"] == "scene"
        assert file["ground_truth"].attrs["room_count"] == 2
        assert file.attrs["format"] == "roomseg-map"
        assert file.attrs["format_version"] == 1
        assert file["camera"].attrs["image_size"].tolist() == [16, 16]


def test_images_are_read_one_by_one(full_path, topomap):
    images = images_of(topomap)
    with MapFile(full_path) as file:
        assert file.image_count == 8
        assert file.done.tolist() == [True] * 8
        np.testing.assert_array_equal(file.image(5), images[5])
        np.testing.assert_array_equal(file.images[[6, 1]], images[[6, 1]])
        np.testing.assert_array_equal(file.images[:], images)
        assert file.gain(7) == 2.0
        assert file.topomap is file.topomap


def test_plain_hdf5_reads_the_deflated_images(full_path, topomap):
    with h5py.File(full_path) as file:
        np.testing.assert_array_equal(file["images/pixels"][()], images_of(topomap))


def test_nodes_without_image(tmp_path, topomap):
    images = list(images_of(topomap))
    images[2] = None
    write_map(tmp_path / "some.h5", topomap, images)
    with MapFile(tmp_path / "some.h5") as file:
        assert np.flatnonzero(~file.done).tolist() == [2]
        np.testing.assert_array_equal(file.image(3), images[3])
        with pytest.raises(FormatError, match=r"some\.h5: node 2 has no image; `roomseg render"):
            file.image(2)
        with pytest.raises(FormatError, match=r"node 8, expected 0\.\.7"):
            file.image(8)


def test_map_without_images(map_path):
    with MapFile(map_path) as file:
        assert file.image_count == 0
        assert not file.done.any()
        assert file.images[[]].shape == (0, 16, 16)
        assert file.rooms is None


@pytest.mark.parametrize(
    ("part", "field", "value", "message"),
    [
        ("nodes", "part", np.full(8, -1), "nodes/part: -1, expected >= 0"),
        ("nodes", "lane", np.full(8, -2), "nodes/lane: -2, expected >= 0"),
        ("visits", "node", np.full(10, 8), r"visits/node: node index 8, expected 0\.\.7"),
        ("visits", "node", np.full(10, -1), r"visits/node: node index -1, expected 0\.\.7"),
    ],
)
def test_impossible_indices_are_refused(topomap, part, field, value, message):
    with pytest.raises(FormatError, match=message):
        dataclasses.replace(
            topomap, **{part: dataclasses.replace(getattr(topomap, part), **{field: value})}
        )


def test_impossible_edge_is_named(topomap):
    with pytest.raises(FormatError, match=r"edges: node index -1, expected 0\.\.7"):
        dataclasses.replace(topomap, edges=np.array([[-1, 2]]), ground_truth=None)


@pytest.mark.parametrize(
    ("images", "message"),
    [
        (np.zeros((8, 16, 15), np.uint8), r"an image of uint8 \(16, 15\), expected uint8 \(16, 16"),
        (np.zeros((8, 16, 16), np.uint16), r"an image of uint16"),
        (np.zeros((7, 16, 16), np.uint8), "7 images, expected 8"),
        (np.zeros((9, 16, 16), np.uint8), "9 images, expected 8"),
    ],
)
def test_wrong_images_write_nothing(tmp_path, topomap, images, message):
    with pytest.raises(FormatError, match=message):
        write_map(tmp_path / "map.h5", topomap, images)
    assert list(tmp_path.iterdir()) == []


def test_rooms_are_written_back_and_nothing_else_changes(map_path, topomap):
    for model, label in (("first", np.zeros(8)), ("second", np.arange(8))):
        write_rooms(map_path, label, model=model, rooms=8)
        with MapFile(map_path) as file:
            assert file.rooms is not None
            assert (file.rooms.model, file.rooms.count) == (model, 8)
            np.testing.assert_array_equal(file.rooms.label, label)
    assert_same(read_map(map_path), topomap)


def test_rooms_of_another_map_are_refused(map_path):
    before = map_path.read_bytes()
    with pytest.raises(FormatError, match=r"rooms/label: shape \(7,\), expected \(8,\)"):
        write_rooms(map_path, np.zeros(7), model="m", rooms=1)
    assert map_path.read_bytes() == before
    assert [p.name for p in map_path.parent.iterdir()] == [map_path.name]


def test_what_others_put_into_the_file_stays(map_path):
    with h5py.File(map_path, "r+") as file:
        file["weather/rain"] = [1.0, 2.0]
        file.attrs["owner"] = "ours"
    write_rooms(map_path, np.zeros(8), model="m", rooms=1)
    with h5py.File(map_path) as file:
        assert file["weather/rain"][()].tolist() == [1.0, 2.0]
        assert file.attrs["owner"] == "ours"


def test_a_failed_write_leaves_the_old_file(map_path, topomap):
    before = map_path.read_bytes()

    def images():
        yield np.zeros((16, 16), np.uint8)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_map(map_path, topomap, images())
    assert map_path.read_bytes() == before
    assert [p.name for p in map_path.parent.iterdir()] == [map_path.name]


def test_parts_of_killed_writers_are_swept(map_path, topomap):
    part = map_path.with_name(f".{map_path.name}.1234567.part")
    part.write_bytes(b"half")
    write_map(map_path, topomap)
    assert not part.exists()


def test_a_second_writer_is_refused(map_path, topomap):
    with (
        locked(map_path),
        pytest.raises(RoomsegError, match=r"flat-run1\.h5: another process is writing to it"),
    ):
        write_map(map_path, topomap)
    write_map(map_path, topomap)


def test_a_lock_file_left_by_a_crash_locks_nobody_out(map_path, topomap):
    Path(f"{map_path}.lock").touch()
    write_map(map_path, topomap)
    assert not Path(f"{map_path}.lock").exists()


def test_a_link_to_a_map_stays_a_link(tmp_path, map_path, topomap):
    link = tmp_path / "link.h5"
    link.symlink_to(map_path)
    with locked(map_path), pytest.raises(RoomsegError, match="another process"):
        write_map(link, topomap)
    write_rooms(link, np.zeros(8), model="m", rooms=1)
    assert link.is_symlink()
    with MapFile(map_path) as file:
        assert file.rooms is not None


def test_replacing_needs_the_whole_body(tmp_path):
    target = tmp_path / "file.txt"
    target.write_text("old")
    with pytest.raises(ZeroDivisionError), replacing(target) as part:
        part.write_text("new")
        1 / 0  # noqa: B018
    assert target.read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 1


def test_what_is_no_file_is_not_replaced_and_a_link_stays(tmp_path):
    pipe, link, file = tmp_path / "pipe", tmp_path / "link", tmp_path / "file"
    os.mkfifo(pipe)
    with pytest.raises(RoomsegError, match="pipe: is no regular file"):
        write_text(pipe, "new")
    assert pipe.is_fifo()
    file.write_text("old")
    link.symlink_to(file)
    write_text(link, "new")
    assert link.is_symlink()
    assert file.read_text() == "new"
    assert len(list(tmp_path.iterdir())) == 3


def test_a_body_that_cannot_read_is_not_one_that_cannot_write(tmp_path):
    with pytest.raises(FileNotFoundError), replacing(tmp_path / "a") as part:
        part.write_text((tmp_path / "b").read_text())
    with pytest.raises(RoomsegError, match=r"no/a: cannot be written: No such file"):
        write_text(tmp_path / "no" / "a", "new")


CRAMPED = """
import resource, sys
import numpy as np
from dataset import RoomsegError, read_map, write_map, write_rooms
path, limit, what = sys.argv[1], int(sys.argv[2]), sys.argv[3]
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
try:
    if what == "write":
        write_map(path, read_map(path))
    else:
        write_rooms(path, np.zeros(8), model="m", rooms=1)
except RoomsegError as error:
    print(error)
"""


@pytest.mark.parametrize("limit", [0, 1000, 4096, 8000])
@pytest.mark.parametrize("what", ["write", "rooms"])
def test_a_full_disk_is_one_line_and_nothing_is_lost(map_path, what, limit):
    before = map_path.read_bytes()
    assert len(before) > 8000
    done = subprocess.run(
        [sys.executable, "-c", CRAMPED, str(map_path), str(limit), what],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == f"{map_path}: cannot be written: File too large\n"
    assert map_path.read_bytes() == before
    assert list(map_path.parent.iterdir()) == [map_path]


def all_readers(path):
    """Whatever a user can do with a file that should be a map."""
    yield lambda: read_map(path)
    yield lambda: MapFile(path).close()
    yield lambda: write_rooms(path, np.zeros(8), model="m", rooms=1)


def assert_refused_in_one_line(path, *, message=""):
    for read in all_readers(path):
        with pytest.raises(FormatError) as caught:
            read()
        assert str(path) in str(caught.value)
        assert "\n" not in str(caught.value)
        assert message in str(caught.value)
    assert len(list(problems(path))) == 1


def test_every_truncation_is_refused_in_one_line(tmp_path, full_path):
    whole = full_path.read_bytes()
    cut = tmp_path / "cut.h5"
    lengths = sorted({*range(0, 64), *range(64, len(whole), 97), len(whole) - 1})
    for length in lengths:
        cut.write_bytes(whole[:length])
        assert_refused_in_one_line(cut)


def test_spoilt_bytes_never_give_another_error(tmp_path, full_path):
    whole = full_path.read_bytes()
    bad = tmp_path / "bad.h5"
    rng = np.random.default_rng(5)
    for _ in range(150):
        data = bytearray(whole)
        start = int(rng.integers(len(data)))
        data[start : start + 8] = rng.bytes(8)
        bad.write_bytes(data[: len(whole)])
        list(problems(bad))
        try:
            read_map(bad)
        except FormatError as error:
            assert "\n" not in str(error)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "not an HDF5 file"),
        (b"{}", "not an HDF5 file"),
        (b"\x89HDF\r\n\x1a\n", "cut off or damaged"),
        (b"\x89HDF\r\n\x1a\n" + bytes(4096), "cut off or damaged"),
    ],
)
def test_other_files_are_refused(tmp_path, content, message):
    path = tmp_path / "other.h5"
    path.write_bytes(content)
    assert_refused_in_one_line(path, message=message)


def test_missing_file_and_folder(tmp_path):
    assert_refused_in_one_line(tmp_path / "none.h5", message="no such file, expected a map file")
    assert_refused_in_one_line(tmp_path, message="is a folder, expected a map file")


def test_foreign_hdf5_and_other_versions(tmp_path, map_path):
    with h5py.File(tmp_path / "foreign.h5", "w") as file:
        file["x"] = 1
    assert_refused_in_one_line(tmp_path / "foreign.h5", message="not a roomseg map")
    with h5py.File(map_path, "r+") as file:
        file.attrs["format_version"] = 2
    assert_refused_in_one_line(map_path, message="format_version: 2, expected 1")


def test_camera_of_the_paper_is_the_default():
    assert two_rooms(FisheyeCamera()).camera.image_size == (464, 464)
