"""``roomseg simulate``: many apartments and runs, what fails, and going on."""

from __future__ import annotations

import dataclasses
import itertools
import json
import os
import signal
import subprocess
import sys
import time
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from cleaned_flat import cleaned_flat
from small_flats import write_rooms

import roomseg.cli.runs
from dataset import read_map, write_map
from roomseg.cli.main import main
from roomseg.cli.runs import run_seed
from scenes import apartment_from_json, load_apartment, reachable_positions
from simulator import CoverageReport, settings_of


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def succeed(*arguments: str) -> None:
    assert main(arguments) == 0


def errors(shown: str) -> list[str]:
    """The lines on what went wrong, without those on the progress."""
    return [line for line in shown.splitlines() if line.startswith("roomseg:")]


def test_seeds_of_runs_differ_and_do_not_depend_on_their_number():
    wanted = [*itertools.product(range(20), ("sim1", "sim2"), range(1, 11))]
    seeds = [run_seed(*one) for one in wanted]
    assert len(set(seeds)) == 400
    assert [run_seed(*one) for one in wanted] == seeds


def test_a_folder_that_is_named_like_a_file_is_refused(folder, capsys):
    assert main(["simulate", "demo1", "-o", "demo1.h5"]) == 2
    assert "demo1.h5 is the name of a file, expected a folder" in capsys.readouterr().err
    assert not Path("demo1.h5").exists()


def test_simulate_keeps_maps_that_are_there(folder, monkeypatch, capsys):
    calls = []

    def fake(run, show):
        calls.append(run.name)
        scene = load_apartment(run.apartment).model_dump_json()
        robot, sensor = settings_of(run.robot), settings_of(run.sensor)
        made = dataclasses.replace(
            cleaned_flat("x", 0), seed=run.seed, scene=scene, robot=robot, sensor=sensor, path=None
        )
        run.output.parent.mkdir(exist_ok=True)
        write_map(run.output, made)
        return CoverageReport(1, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0, True, 0.0, 0.0)

    monkeypatch.setattr("roomseg.cli.runs._simulate", fake)
    succeed("simulate", "demo1", "--runs", "2", "-o", "maps")
    succeed("simulate", "demo1", "--runs", "3", "-o", "maps")
    assert calls == ["run1", "run2", "run3"]
    assert "demo1-run2.h5: already there" in capsys.readouterr().out
    succeed("simulate", "demo1", "--runs", "3", "-o", "maps", "--force")
    assert calls[3:] == ["run1", "run2", "run3"]

    # What is there must be what would be made.
    assert main(["simulate", "demo1", "--seed", "1", "-o", "maps"]) == 2
    assert "run1.h5: already there, but of another seed" in capsys.readouterr().err
    place = json.loads(Path(str(files("scenes") / "reference" / "demo1.json")).read_text())
    place["lighting"] = {"source": "mixed"}
    Path("other.json").write_text(json.dumps(place))
    assert main(["simulate", "other.json", "-o", "maps"]) == 2
    assert "run1.h5: already there, but of another apartment" in capsys.readouterr().err
    assert len(calls) == 6


def test_simulated_maps_are_right_whatever_the_number_of_jobs(folder, capsys):
    write_rooms()
    succeed("simulate", "two.json", "--runs", "2", "--seed", "9", "-o", "a", "--json", "a.json")
    succeed("simulate", "two.json", "--runs", "2", "--seed", "9", "-o", "b", "--jobs", "2")
    names = ["two-run1.h5", "two-run2.h5"]
    assert sorted(path.name for path in Path("b").iterdir()) == names
    contents = [Path("a", name).read_bytes() for name in names]
    assert contents == [Path("b", name).read_bytes() for name in names]
    assert contents[0] != contents[1]
    succeed("validate", *(f"a/{name}" for name in names))
    figures = json.loads(Path("a.json").read_text())
    for name, figure in zip(names, figures["maps"], strict=True):
        topomap = read_map(Path("a", name))
        assert figure["map"] == f"a/{name}"
        assert figure["nodes"] == len(topomap.nodes)
        assert topomap.environment == "two"
        assert topomap.ground_truth is not None and topomap.ground_truth.room is not None
        # The labels are the rooms in which the nodes truly lie, but for the doorway.
        x = topomap.nodes.true_pose[:, 0]
        left, right = (set(topomap.ground_truth.room[side]) for side in (x < 1.5, x > 1.82))
        assert len(left) == len(right) == 1
        assert left != right


def test_another_robot_cleans(folder, capsys):
    Path("wide.toml").write_text("[robot]\nradius = 0.17\n[sensor]\nbeams = 4\n")
    succeed("simulate", "demo1", "--robot", "wide.toml", "-o", "wide")
    topomap = read_map("wide/demo1-run1.h5")
    assert topomap.robot_radius == topomap.robot["radius"] == 0.17
    assert (topomap.robot["lane_spacing"], topomap.sensor["beams"]) == (0.3, 4)
    assert topomap.obstacles.beam.max() == 3
    capsys.readouterr()
    assert main(["simulate", "demo1", "-o", "wide"]) == 2
    assert "already there, but of another robot;" in capsys.readouterr().err
    Path("other.toml").write_text("[robot]\nradius = 0.17\n[sensor]\nbeams = 5\n")
    assert main(["simulate", "demo1", "--robot", "other.toml", "-o", "wide"]) == 2
    assert "already there, but of another robot's sensors;" in capsys.readouterr().err
    succeed("inspect", "wide/demo1-run1.h5")
    shown = capsys.readouterr().out
    assert "radius 0.17 m; else as the prototype\n" in shown
    assert "unlike the prototype: beams 4\n" in shown


def test_what_fails_is_listed_and_the_others_go_on(folder, capsys):
    """A file that is none, a base in a wall, and one that is good, twice each."""
    Path("broken.json").write_text("{")
    stuck = write_rooms("stuck", start={"position": [0.02, 0.02]})
    arguments = ("simulate", "broken.json", stuck, write_rooms(), "--runs", "2", "-o", "maps")
    assert main(arguments) == 2
    shown = capsys.readouterr()
    lines = errors(shown.err)
    assert len(lines) == 2
    assert lines[0].startswith("roomseg: error: broken.json: line 1, column 2: not JSON")
    assert lines[1].startswith("roomseg: error: stuck.json: start.position: (0.02, 0.02)")
    assert "maps: 2 maps, 0 of them there before" in shown.out
    assert "shortest possible" in shown.out and "overlap" in shown.out and "turns" in shown.out
    assert sorted(path.name for path in Path("maps").iterdir()) == ["two-run1.h5", "two-run2.h5"]
    # Stopped and called again, the figures are those of all maps.
    assert main([*arguments, "--json", "all.json"]) == 2
    assert len(json.loads(Path("all.json").read_text())["maps"]) == 2


def test_a_run_without_end_and_a_bug_are_told(folder, capsys, monkeypatch):
    Path("hasty.toml").write_text("[robot]\ntime_limit = 20.0\n")
    assert main(["simulate", write_rooms(), "--robot", "hasty.toml"]) == 2
    (line,) = errors(capsys.readouterr().err)
    assert line.startswith("roomseg: error: two-run1.h5: time_limit: the run is not done")

    def fail(run, show):
        raise ZeroDivisionError("of nothing")

    monkeypatch.setattr(roomseg.cli.runs, "_simulate", fail)
    assert main(["simulate", "two.json", write_rooms("three")]) == 2
    shown = capsys.readouterr().err
    assert shown.count("Traceback") == 2
    lines = errors(shown)
    assert lines[0] == "roomseg: error: two-run1.h5: unexpected ZeroDivisionError: of nothing"
    assert lines[1].startswith("roomseg: error: three-run1.h5: unexpected ZeroDivisionError")


def test_apartments_of_one_name_are_refused(folder, capsys):
    write_rooms()
    Path("copy.json").write_bytes(Path("two.json").read_bytes())
    assert main(["simulate", "two.json", "copy.json", "-o", "maps"]) == 2
    assert "copy.json: name: 'two', as in two.json; expected" in capsys.readouterr().err
    assert not Path("maps").exists()


def test_a_robot_that_begins_beside_the_base_goes_on(folder, capsys):
    Path("wide.toml").write_text("[robot]\nradius = 0.2\n")
    home = write_rooms(start={"position": [0.5, 0.16]})
    succeed("simulate", home, "--robot", "wide.toml")
    begin = read_map("two-run1.h5").path.true_pose[0, :2]
    assert begin == pytest.approx([0.5, 0.201], abs=1e-3)
    succeed("simulate", home, "--robot", "wide.toml")
    assert "two-run1.h5: already there" in capsys.readouterr().out


def test_random_starts_are_reachable_and_repeatable(folder, capsys):
    write_rooms()
    arguments = ("simulate", "two.json", "--runs", "3", "--random-starts")
    succeed(*arguments, "-o", "a")
    succeed(*arguments, "-o", "b", "--jobs", "2")
    names = [f"two-run{number}.h5" for number in (1, 2, 3)]
    assert [Path("a", n).read_bytes() for n in names] == [Path("b", n).read_bytes() for n in names]
    poses = np.array([read_map(Path("a", name)).path.true_pose[0] for name in names])
    assert len(np.unique(poses, axis=0)) == 3
    places = reachable_positions(apartment_from_json(Path("two.json").read_text()))
    gap = np.hypot(*(poses[:, None, :2] - places).T).min(axis=0)
    assert gap.max() < 1e-9
    capsys.readouterr()
    assert main(["simulate", "two.json", "-o", "a"]) == 2
    assert "two-run1.h5: already there, but of another start" in capsys.readouterr().err


def test_a_run_that_began_with_another_heading_is_another_run(folder, capsys):
    write_rooms()
    place = apartment_from_json(Path("two.json").read_text())
    heading = place.start.heading_deg

    def pose(heading: float) -> list[str]:
        return [str(number) for number in (*place.start.position, heading)]

    succeed("simulate", "two.json", "--start", *pose(heading), "-o", "a")
    succeed("simulate", "two.json", "-o", "a")  # the same: the base's own pose
    succeed("simulate", "two.json", "--start", *pose(heading + 360), "-o", "a")
    wall = ("--start", "-3", "-3", "0")
    assert main(["simulate", "two.json", *wall, "-o", "b"]) == 2
    assert "start" in capsys.readouterr().err
    assert main(["simulate", "two.json", "--start", *pose(heading + 90), "-o", "a"]) == 2
    assert "two-run1.h5: already there, but of another start" in capsys.readouterr().err


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_ctrl_c_keeps_what_is_done(folder, jobs):
    write_rooms()
    # A background job of a shell is started with SIGINT ignored.
    code = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "import sys; from roomseg.cli.main import main\n"
        "arguments = ['simulate', 'two.json', '--runs', '99', '-o', 'maps', '--jobs']\n"
        f"sys.exit(main([*arguments, '{jobs}']))"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    deadline = time.monotonic() + 60.0
    while not list(folder.glob("maps/*.h5")) and time.monotonic() < deadline:
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGINT)
    _, error = process.communicate(timeout=60)
    assert process.returncode == 130
    assert error.strip() == "roomseg: stopped; call it again to go on"
    maps = list(folder.glob("maps/*.h5"))
    assert 1 <= len(maps) < 99
    for path in maps:
        assert len(read_map(path).nodes) > 0
