"""``roomseg import`` of robots' runs: the map is written, and its rooms are found."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from cleaned_flat import cleaned_flat
from scipy.spatial import KDTree

from dataset import problems, read_map, write_map
from roomseg.cli.main import main
from roomseg.metrics import impurity


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the flat's run as a Valetudo map."""
    monkeypatch.chdir(tmp_path)
    write_map("flat.h5", replace(cleaned_flat(), path=None))
    assert main(["export", "flat.h5", "-o", "run.json", "--format", "valetudo"]) == 0
    return tmp_path


def said(capsys, *arguments):
    """Exit code, standard output, and the lines of standard error."""
    capsys.readouterr()
    code = main(list(arguments))
    out, err = capsys.readouterr()
    return code, out, err.splitlines()


def test_a_valetudo_map_goes_there_and_back(folder, capsys):
    code, out, err = said(capsys, "import", "run.json", "--name", "home", "-o", "back.h5")
    assert code == 0
    assert out.startswith("back.h5: ") and out.endswith(", 3 rooms\n")
    assert err[-1].startswith("run.json: rooms by segment: 1 'room-1' (")
    assert list(problems("back.h5")) == []
    before, after = read_map("flat.h5"), read_map("back.h5")
    assert (after.environment, after.run) == ("home", "run")
    gap, near = KDTree(after.nodes.position).query(before.nodes.position)
    assert gap.max() < 0.12
    same = after.ground_truth.room[near] == before.ground_truth.room
    assert same.mean() > 0.98


def test_an_imported_map_has_no_camera_and_no_date(folder, capsys):
    assert main(["import", "run.json", "-o", "back.h5"]) == 0
    code, out, _ = said(capsys, "inspect", "back.h5", "--json", "figures.json")
    facts = dict((line[:14].strip(), line[14:]) for line in out.splitlines())
    assert (code, facts["made"], facts["camera"]) == (0, "by Valetudo", "no")
    assert "images" not in facts
    figures = json.loads((folder / "figures.json").read_text(encoding="utf-8"))
    assert (figures["image_size"], figures["disc_diameter"]) == (None, None)


def test_names_of_rooms_go_there_and_back(folder):
    flat = replace(cleaned_flat(), path=None)
    truth = replace(flat.ground_truth, room_names=("Küche", "", "living room"))
    write_map("flat.h5", replace(flat, ground_truth=truth))
    assert main(["export", "flat.h5", "-o", "named.json", "--format", "valetudo"]) == 0
    assert main(["import", "named.json", "-o", "back.h5"]) == 0
    assert read_map("back.h5").ground_truth.room_names == ("Küche", "room-2", "living room")


def test_the_rooms_of_an_imported_run_are_found_without_images(folder, capsys):
    model = ("--features", "no-camera", "-o", "plain.skops")
    assert said(capsys, "train", "flat.h5", *model)[0] == 0
    assert said(capsys, "import", "run.json", "-o", "back.h5")[0] == 0
    code, out, _ = said(capsys, "segment", "back.h5", "--model", "plain.skops", "--json", "f.json")
    assert code == 0 and "3 rooms by plain.skops" in out
    with open("f.json", encoding="utf-8") as stream:  # noqa: PTH123
        figures = json.load(stream)
    assert figures["impurity"] < 0.1
    truth = read_map("back.h5").ground_truth.room
    assert figures["impurity"] < impurity(np.zeros(len(truth), np.int32), truth)


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["run.json", "-o", "a.json"], "a.json: run.json is a run, expected a name with .h5"),
        (["home.yaml", "-o", "a.h5"], "home.yaml is an apartment, expected a name with .json"),
        (["run.json", "-o", "flat.h5"], "flat.h5 is a map and would be lost"),
        (["run.json", "-o", "a.h5", "--ceiling", "3"], "--ceiling: has no meaning for the format"),
        (["run.bag", "-o", "a.h5"], "--topics: missing, expected a TOML file"),
        (["run.bag", "--topics", "run.json", "-o", "a.h5"], "run.json: "),
        (["run.bag", "--topics", "t.toml", "-o", "a.h5"], "run.bag: damaged bag"),
        ([".", "-o", "a.h5"], ".: is a folder without metadata.yaml, expected a ROS 2 bag"),
        (["cut.json", "-o", "a.h5", "--format", "valetudo"], "cut.json: the JSON ends in the mid"),
        (["cut.json", "-o", "a.h5"], "in line 1: the file is damaged or cut off"),
        (["home.yaml", "-o", "a.h5", "--format", "valetudo"], "home.yaml: Invalid JSON: "),
    ],
)  # fmt: skip
def test_faults_are_one_line_and_nothing_is_written(folder, capsys, arguments, line):
    pytest.importorskip("rosbags")
    (folder / "home.yaml").write_text("image: a.pgm", encoding="utf-8")
    (folder / "run.bag").write_bytes(b"#ROSBAG V2.0\nxyz")
    (folder / "t.toml").write_text('[odometry]\ntopic = "/odom"\n', encoding="utf-8")
    (folder / "cut.json").write_bytes((folder / "run.json").read_bytes()[:500])
    code, out, err = said(capsys, "import", *arguments)
    assert (code, out, len(err)) == (2, "", 1)
    assert err[0].startswith("roomseg: error: ") and line in err[0]
    assert not (folder / "a.h5").exists() and not (folder / "a.json").exists()
