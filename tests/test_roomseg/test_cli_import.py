"""``roomseg import`` and ``roomseg export``: formats found, notes told, faults in one line."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest

from dataset import read_map
from roomseg.cli.main import main
from scenes import load_apartment

HEADER = """\
image: map.pgm
resolution: 0.05
origin: [0, 0, 0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a grid map of one room of 2 m x 1 m, open on one side."""
    monkeypatch.chdir(tmp_path)
    cells = np.zeros((24, 44), dtype=np.uint8)
    cells[2:22, 2:42] = 254
    cells[2:22, 42:] = 205
    (tmp_path / "map.pgm").write_bytes(b"P5 44 24 255\n" + cells.tobytes())
    (tmp_path / "map.yaml").write_text(HEADER, encoding="utf-8")
    cv2.imwrite("grid.png", np.where(cells == 254, 255, 0))
    return tmp_path


def said(capsys, *arguments):
    """Exit code, standard output, and the lines of standard error."""
    code = main(list(arguments))
    out, err = capsys.readouterr()
    return code, out, err.splitlines()


def test_a_ros_map_is_imported_with_its_notes_on_standard_error(folder, capsys):
    code, out, err = said(capsys, "import", "map.yaml", "-o", "home.json", "--name", "flat")
    assert code == 0
    assert out == "home.json: 1 room, 2.0 m², 0 walls, 1 block, 0 pieces, 1 note\n"
    assert err == ["map.yaml: 1.0 m of the free cells' edge meet unknown ones: closed by a wall"]
    assert load_apartment(folder / "home.json").name == "flat"


def test_a_bare_picture_takes_scale_or_resolution(folder, capsys):
    assert said(capsys, "import", "grid.png", "-o", "a.json", "--scale", "0.05")[0] == 0
    assert said(capsys, "import", "grid.png", "-o", "b.json", "--resolution", "0.05")[0] == 0
    assert (folder / "a.json").read_bytes() == (folder / "b.json").read_bytes()


def test_start_and_ceiling_reach_the_reader(folder, capsys):
    options = ("--start", "0.6,0.5", "--ceiling", "3")
    assert said(capsys, "import", "map.yaml", "-o", "home.json", *options)[0] == 0
    home = load_apartment(folder / "home.json")
    assert home.start.position == (0.6, 0.5)
    assert home.rooms[0].ceiling_height == 3.0


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (
            ["grid.png"],
            "grid.png: a picture has no scale; expected --scale, metres per pixel (0.05 is usual)",
        ),
        (
            ["map.yaml", "--scale", "0.1"],
            "map.yaml: has a resolution, 0.05 m per cell; expected no --scale",
        ),
        (
            ["map.yaml", "--start", "9,9"],
            "map.yaml: start: (9, 9) has no free floor for a robot of 0.15 m radius; expected a "
            "free place, such as (1.95, 0.95)",
        ),
        (
            ["map.yaml", "--start", "here"],
            "Invalid value for '--start': 'here'; expected two numbers, such as 1.5,2; see "
            "`roomseg import --help`",
        ),
        (
            ["map.yaml", "--name", "a b"],
            "Invalid value for '--name': 'a b'; expected letters, digits, '_', '.', '-', at most "
            "64; see `roomseg import --help`",
        ),
        (
            ["map.yaml", "--furnish"],
            "--furnish: has no meaning for the format grid; see `roomseg import --help`",
        ),
        (
            ["map.yaml", "--ceiling", "0"],
            "Invalid value for '--ceiling': 0.0 is not in the range 1<=x<=20; see "
            "`roomseg import --help`",
        ),
        (
            ["cut.pgm", "--scale", "0.05"],
            "cut.pgm: cut short: 5 of 4 x 4 pixels; expected all of them",
        ),
        (
            ["map.yaml", "--label-table", "map.yaml"],
            "--label-table: says what --labels shows; expected --labels, too; see "
            "`roomseg import --help`",
        ),
        (
            ["flat.glb", "--up", "Z"],
            "--up: flat.glb has its own axes; expected it for .obj, .ply, .stl only; see "
            "`roomseg import --help`",
        ),
        (["home.json"], "home.json: is an apartment already; nothing to import"),
        (["noise.json"], "noise.json: byte 0 is not text; expected a floor plan or a robot's map"),
    ],
)
def test_faults_are_one_line_and_nothing_is_written(folder, capsys, arguments, line):
    (folder / "cut.pgm").write_bytes(b"P5 4 4 255\n12345")
    (folder / "home.json").write_text('{"format": "roomseg-apartment"}', encoding="utf-8")
    (folder / "flat.glb").write_bytes(b"glTF")
    (folder / "noise.json").write_bytes(b"\xff\x00\xfe")
    code, out, err = said(capsys, "import", *arguments, "-o", "out.json")
    assert (code, out, err) == (2, "", [f"roomseg: error: {line}"])
    assert not (folder / "out.json").exists()


def test_an_unknown_suffix_names_those_known(folder, capsys):
    (folder / "plan.dwg").write_bytes(b"AC1027")
    code, _, err = said(capsys, "import", "plan.dwg", "-o", "out.json")
    assert code == 2
    assert len(err) == 1
    assert err[0].startswith("roomseg: error: plan.dwg: its suffix says nothing; expected one of ")
    assert all(suffix in err[0] for suffix in (".yaml", ".svg", ".glb", "--format"))


def test_json_plans_are_told_apart_by_what_is_in_them(folder, capsys):
    outline = [[0, 0], [3, 0], [3, 2], [0, 2]]
    (folder / "expo.json").write_text(
        json.dumps({"verts": outline, "room_category": {}, "id": "x"}), encoding="utf-8"
    )
    ring = [*outline, outline[0]]
    room = {
        "type": "Feature",
        "properties": {"layer": "room", "name": "a"},
        "geometry": {"type": "Polygon", "coordinates": [ring]},
    }
    (folder / "plan.json").write_text(
        json.dumps({"type": "FeatureCollection", "features": [room]}), encoding="utf-8"
    )
    for name in ("expo.json", "plan.json"):
        code, out, _ = said(capsys, "import", name, "-o", "out.json")
        assert code == 0
        assert "1 room, 6.0 m²" in out


def test_an_exported_map_comes_back_by_the_command(folder, capsys):
    code, out, err = said(capsys, "export", "sim4", "-o", "sim4.yaml", "-o", "sim4.geojson")
    assert (code, err) == (0, [])
    names = ["sim4.yaml", "sim4.pgm", "sim4_rooms.png", "sim4_rooms.csv", "sim4.geojson"]
    assert out == "".join(f"{name}: written\n" for name in names)
    rooms = ("--labels", "sim4_rooms.png", "--label-table", "sim4_rooms.csv")
    assert said(capsys, "import", "sim4.yaml", "-o", "back.json", *rooms)[0] == 0
    before, after = load_apartment("sim4"), load_apartment(folder / "back.json")
    assert {r.name: r.kind for r in after.rooms} == {r.name: r.kind for r in before.rooms}


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (
            ["-o", "a.xyz"],
            "a.xyz: expected a suffix of .blend, .glb, .geojson, .svg, .yaml, .rrd, .graphml, "
            ".json, .csv, or --format",
        ),
        (["-o", "a.geojson", "--resolution", "0.1"], "--resolution: has no meaning for geojson"),
        (
            ["-o", "gone/a.yaml"],
            "Invalid value for '-o' / '--output': gone/a.yaml: the folder gone does not exist",
        ),
    ],
)
def test_faults_of_export_are_one_line(folder, capsys, arguments, line):
    code, out, err = said(capsys, "export", "sim4", *arguments)
    assert (code, out) == (2, "")
    assert err == [f"roomseg: error: {line}; see `roomseg export --help`"]


def test_numbers_that_are_none_are_one_line(folder, capsys):
    for option in ("--scale", "--ceiling"):
        code, _, err = said(capsys, "import", "grid.png", "-o", "a.json", option, "nan")
        assert (code, len(err)) == (2, 1)
        assert "nan is not a finite number" in err[0]
    code, _, err = said(capsys, "export", "sim4", "-o", "a.yaml", "--resolution", "nan")
    assert (code, len(err)) == (2, 1)


def test_a_map_of_an_odd_name_comes_back(folder, capsys):
    name = "my #1: home.yaml"
    assert said(capsys, "export", "demo1", "-o", name)[0] == 0
    assert said(capsys, "import", name, "-o", "back.json")[0] == 0


def test_an_imported_map_with_borders_can_be_cleaned(folder, capsys):
    cells = np.zeros((44, 84), dtype=np.uint8)
    cells[2:42, 2:40] = cells[2:42, 44:82] = cells[12:30, 40:44] = 254
    (folder / "map.pgm").write_bytes(b"P5 84 44 255\n" + cells.tobytes())
    (folder / "lines.csv").write_text("x0,y0,x1,y1\n2.1,0.7,2.1,1.6\n", encoding="utf-8")
    assert said(capsys, "import", "map.yaml", "-o", "home.json", "--borders", "lines.csv")[0] == 0
    code, out, _ = said(capsys, "simulate", "home.json", "-o", "maps")
    assert code == 0
    assert float(out.split(" nodes, ")[1].split(" % covered")[0]) > 95.0
    truth = read_map(folder / "maps" / "map-run1.h5").ground_truth
    assert truth is not None
    assert truth.room_count == 2
    assert truth.edge_is_border.any()


@pytest.mark.parametrize(
    ("arguments", "said_of_it"),
    [
        (["a.png", "--samples", "4"], "--samples: an option of --cutaway only"),
        (["a.png", "--size", "500"], "--size: an option of --cutaway only"),
        (["a.png", "--cutaway", "--dpi", "90"], "--dpi: an option of a drawing, not of --cutaway"),
    ],
)
def test_options_of_the_other_kind_of_picture_are_refused(folder, capsys, arguments, said_of_it):
    code, out, err = said(capsys, "view", "demo1", "-o", *arguments)
    assert (code, out) == (2, "")
    assert err == [f"roomseg: error: {said_of_it}; see `roomseg view --help`"]
    assert not (folder / "a.png").exists()
