"""A run as a Rerun recording, read back by Rerun's own reader."""

from __future__ import annotations

import sys
from dataclasses import replace

import cv2
import numpy as np
import pytest
from cleaned_flat import cleaned_flat, fisheye_image, obstacles

from dataset import Visits, write_map
from roomseg.cli.main import main
from roomseg.recording import recording_bytes
from scenes import Start, load_apartment
from simulator import coverage_report, simulate
from simulator.progress import coverage_progress


@pytest.fixture(scope="module")
def flat():
    return cleaned_flat()


@pytest.fixture(scope="module")
def sim4():
    place = load_apartment("sim4")
    return place, simulate(place, seed=1)


@pytest.fixture(scope="module")
def read_back(flat, tmp_path_factory):
    """Makes a recording of the flat, and gives a reader of its rows."""
    rr = pytest.importorskip("rerun")

    def make(topomap=flat, **what):
        path = tmp_path_factory.mktemp("run") / "run.rrd"
        path.write_bytes(recording_bytes(topomap, **what))
        recording = rr.dataframe.load_recording(path)

        def rows(entity, component):
            """Times, s, and values of a component."""
            name = f"/{entity}:{component}"
            view = recording.view(index="time", contents=f"/{entity}")
            table = view.select("time", name).read_all()
            times = table["time"].cast("int64").to_numpy() / 1e9
            return times, table[name].to_pylist()

        return recording, rows

    return make


def entities(recording):
    return {column.entity_path for column in recording.schema().component_columns()}


def test_nodes_edges_and_points_come_at_their_times(flat, read_back):
    _, rows = read_back()
    times, positions = rows("map/nodes", "Position2D")
    np.testing.assert_allclose(times, flat.visits.time, atol=1e-6)
    np.testing.assert_allclose(np.concatenate(positions), flat.nodes.position, atol=1e-5)
    times, strips = rows("map/edges", "LineStrip2D")
    ends = np.concatenate([np.array(row) for row in strips])
    assert len(ends) == len(flat.edges)
    # Nodes are made in their order: an edge is there when its later node is.
    made = np.repeat(times, [len(row) for row in strips])
    np.testing.assert_allclose(made, np.sort(flat.visits.time[flat.edges[:, 1]]), atol=1e-6)
    times, points = rows("map/points", "Position2D")
    np.testing.assert_allclose(np.concatenate(points), flat.obstacles.position, atol=1e-5)
    seen = np.repeat(times, [len(row) for row in points])
    assert ((seen - flat.obstacles.time >= -1e-6) & (seen - flat.obstacles.time < 4.0)).all()


def test_the_robot_is_where_the_path_says_truly_and_as_it_believes(flat, read_back):
    _, rows = read_back()
    for frame, pose in (("scene", flat.path.true_pose), ("map", flat.path.estimate)):
        times, body = rows(f"{frame}/robot/body", "Position2D")
        at = np.interp(times, flat.path.time, np.arange(len(flat.path.time))).round().astype(int)
        np.testing.assert_allclose(np.array(body)[:, 0], pose[at, :2], atol=1e-5)
        assert times[-1] == pytest.approx(flat.path.time[-1])


def test_the_pieces_of_the_covered_floor_make_up_the_whole_way(flat, read_back):
    _, rows = read_back()
    _, pieces = rows("scene/covered", "LineStrip2D")
    length = sum(
        np.hypot(*np.diff(np.array(strip), axis=0).T).sum() for row in pieces for strip in row
    )
    driven = np.hypot(*np.diff(flat.path.true_pose[:, :2], axis=0).T).sum()
    assert length == pytest.approx(driven, rel=1e-4)
    _, radius = rows("scene/covered", "Radius")
    assert radius[0] == pytest.approx([flat.robot_radius])


def test_lanes_have_the_colour_of_their_nodes(sim4, read_back):
    _, topomap = sim4
    _, rows = read_back(topomap)
    times, node_colours = rows("map/nodes", "Color")
    at = dict(zip(np.round(times, 3), [row[0] for row in node_colours], strict=True))
    # There are 27 colours to tell apart.
    assert len(set(at.values())) == min(27, len(np.unique(topomap.nodes.part)))
    times, lane_colours = rows("map/lanes", "Color")
    right = [
        at[now] == row[0]
        for now, row in zip(np.round(times, 3), lane_colours, strict=True)
        if now in at
    ]
    assert len(right) > 20 and np.mean(right) > 0.95


def test_beams_go_out_when_nothing_is_seen(flat, read_back):
    _, rows = read_back()
    times, beams = rows("map/beams", "LineStrip2D")
    assert sum(len(row) for row in beams) == len(flat.obstacles.time)
    for (now, row), after in zip(zip(times[:-1], beams[:-1], strict=True), times[1:], strict=True):
        assert not row or after - now < 0.61


def test_plan_images_and_curve(flat, read_back):
    image = fisheye_image()
    curve = (np.array([0.0, 5.0]), np.array([0.25, 0.5]))
    plans = {"walls": obstacles(), "furniture": []}
    recording, rows = read_back(plans=plans, covered=curve, images=[(3, image)])
    assert {"/scene/walls", "/camera", "/run/covered", "/run/drift"} <= entities(recording)
    times, values = rows("run/covered", "Scalar")
    assert (times.tolist(), values) == ([0.0, 5.0], [[25.0], [50.0]])
    times, jpeg = rows("camera", "Blob")
    assert times == pytest.approx([flat.visits.time[3]])
    shown = cv2.imdecode(np.array(jpeg[0][0], np.uint8), cv2.IMREAD_GRAYSCALE)
    assert np.abs(shown.astype(int) - image).mean() < 4.0


def test_the_recording_of_a_map_always_has_the_same_name(flat, read_back):
    first, second = read_back()[0], read_back()[0]
    other = read_back(replace(flat, seed=flat.seed + 1))[0]
    assert first.recording_id() == second.recording_id() != other.recording_id()


def test_a_real_robots_map_has_no_truth(read_back):
    recording, rows = read_back(cleaned_flat(real=True))
    assert not [name for name in entities(recording) if name.startswith("/scene/robot")]
    assert len(rows("map/robot/body", "Position2D")[0])


def test_nodes_without_a_visit_are_there_from_the_beginning(read_back):
    flat = cleaned_flat(real=True)
    bare = replace(flat, visits=Visits(np.zeros(0, np.int32), np.zeros(0)))
    times, _ = read_back(bare)[1]("map/nodes", "Position2D")
    assert len(times) and not times.any()


def test_progress_ends_at_the_reported_coverage(sim4):
    place, topomap = sim4
    times = np.linspace(0.0, topomap.path.time[-1], 40)
    share = coverage_progress(topomap.path, place, times)
    assert (np.diff(share) >= 0.0).all() and share[0] < 0.1
    assert share[-1] == pytest.approx(coverage_report(topomap, place).coverage, abs=1e-9)


def test_progress_counts_from_where_the_run_began(sim4):
    """Not from the apartment's start, where another robot may not even fit."""
    place, topomap = sim4
    times = topomap.path.time[-1:]
    elsewhere = place.model_copy(update={"start": Start(position=place.walls[0].start)})
    share = coverage_progress(topomap.path, elsewhere, times)
    assert share == coverage_progress(topomap.path, place, times)


@pytest.fixture
def run_file(tmp_path):
    path = tmp_path / "run.h5"
    write_map(path, cleaned_flat())
    return path


def test_command_writes_beside_the_map_or_by_name(run_file, capsys):
    pytest.importorskip("rerun")
    assert main(["export", str(run_file), "--rerun"]) == 0
    assert main(["export", str(run_file), "-o", str(run_file.with_name("a.rrd"))]) == 0
    assert run_file.with_suffix(".rrd").read_bytes()[:4] == b"RRF2"
    assert run_file.with_name("a.rrd").exists()
    assert capsys.readouterr().out.count("written") == 2


def test_without_rerun_one_line_says_what_to_install(run_file, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "rerun", None)
    assert main(["export", str(run_file), "-o", str(run_file.with_name("a.rrd"))]) == 2
    told = capsys.readouterr().err
    assert "pip install 'roomseg[rerun]'" in told and told.count("\n") == 1
    assert not run_file.with_name("a.rrd").exists()


def test_an_apartment_has_no_run(tmp_path, capsys):
    assert main(["export", "sim4", "-o", str(tmp_path / "a.rrd")]) == 2
    assert "is made of a map, not of an apartment" in capsys.readouterr().err


def test_something_must_be_asked_for(capsys):
    assert main(["export", "sim4"]) == 2
    assert "-o/--output: missing" in capsys.readouterr().err


@pytest.mark.parametrize("source", ["", ".", "sim4", "nothing.h5"])
def test_a_recording_is_put_beside_a_file_only(source, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["export", source, "--rerun"]) == 2
    assert "no such file, expected a map for --rerun" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
