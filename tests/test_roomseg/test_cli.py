"""Bad input ends in one clear line and exit code 2, and nothing is written."""

from __future__ import annotations

import itertools
import json
import os
import resource
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import click
import h5py
import numpy as np
import pytest
from cleaned_flat import cleaned_flat
from click.testing import CliRunner

from dataset import FisheyeCamera, MapFile, write_map
from roomseg.cli import main as command_line
from roomseg.cli.main import COMMANDS, cli, main
from roomseg.feature_set import add_to_feature_set
from roomseg.room_count import usual_room_count
from scenes import apartment_to_json, load_apartment

NAMES = list(COMMANDS)


@pytest.fixture(scope="module")
def map_bytes(tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("maps") / "flat.h5"
    write_map(path, cleaned_flat("flat"))
    return path.read_bytes()


@pytest.fixture
def folder(tmp_path, monkeypatch, map_bytes) -> Path:
    """The working folder of a user, with a map without images."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "flat.h5").write_bytes(map_bytes)
    return tmp_path


def square_room(name: str, left: float, width: float = 3.0) -> dict[str, object]:
    right = left + width
    return {"name": name, "polygon": [[left, 0], [right, 0], [right, 3], [left, 3]]}


def apartment() -> dict[str, object]:
    """Two rooms of 3 m x 3 m side by side, a doorway between them."""
    corners = [(-0.06, -0.06), (6.18, -0.06), (6.18, 3.06), (-0.06, 3.06), (-0.06, -0.06)]
    walls = [{"start": a, "end": b, "thickness": 0.12} for a, b in itertools.pairwise(corners)]
    walls.append({"start": (3.06, -0.06), "end": (3.06, 3.06), "thickness": 0.12})
    return {
        "name": "two",
        "rooms": [square_room("a", 0.0), square_room("b", 3.12)],
        "walls": walls,
        "passages": [{"position": [3.06, 1.5]}],
        "start": {"position": [1.0, 1.0]},
    }


def refused(capsys, *arguments: str) -> str:
    """Run a command that must fail; return its one line."""
    before = snapshot()
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("roomseg: error: ")
    assert captured.err.count("\n") == 1, captured.err
    assert "Traceback" not in captured.err + captured.out
    assert snapshot() == before
    return captured.err.removeprefix("roomseg: error: ").rstrip("\n")


def snapshot() -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in Path().rglob("*") if path.is_file()}


# ------------------------------------------------------------------ the group


@pytest.mark.parametrize("name", NAMES)
def test_every_command_explains_itself_with_an_example(name):
    result = CliRunner().invoke(cli, [name, "--help"])
    assert result.exit_code == 0
    assert "Example:\n" in result.output
    assert f"roomseg {name} " in result.output.split("Example:")[1]


def examples(name: str) -> list[list[str]]:
    """Command lines of the help of a command, or of the group, whatever shell is around them."""
    command = cli.get_command(click.Context(cli), name) if name else cli
    lines = command.epilog.replace("\\\n", " ").splitlines()
    found = [line[line.index("roomseg ") :] for line in lines if "roomseg " in line]
    return [shlex.split(line, comments=True)[1:] for line in found]


@pytest.mark.parametrize("name", ["", *NAMES])
def test_every_example_of_the_help_parses(folder, name):
    lines = examples(name)
    assert lines
    for first, *arguments in lines:
        for before, path in zip(["", *arguments], map(Path, arguments), strict=False):
            # What it reads is there, and so is the folder of what it writes.
            path.parent.mkdir(parents=True, exist_ok=True)
            if path.suffix and before != "-o":
                path.touch()
        command = cli.get_command(click.Context(cli), first)
        assert command is not None, first
        command.make_context(first, list(arguments)).close()


def test_help_lists_every_command_in_order():
    result = CliRunner().invoke(cli, ["--help"])
    assert result.exit_code == 0
    listed = result.output.split("Commands:")[1].split("Example:")[0].split("\n")
    assert [line.split()[0] for line in listed if line.strip()] == NAMES


def test_version():
    result = CliRunner().invoke(cli, ["--version"])
    assert result.output == "roomseg 0.1.0\n"


def test_help_imports_nothing_heavy():
    code = (
        "import sys; from roomseg.cli.main import main; code = main(['--help']);"
        "heavy = {'numpy', 'h5py', 'shapely', 'sklearn', 'cv2', 'matplotlib', 'bpy', 'dataset'};"
        "found = heavy & set(sys.modules); assert not found, found; sys.exit(code)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


def test_no_command_shows_the_help(capsys):
    assert main([]) == 2
    assert "Commands:" in capsys.readouterr().err


# ------------------------------------------------------------- bad arguments


def test_unknown_command_and_option(folder, capsys):
    assert refused(capsys, "paint") == "No such command 'paint'; see `roomseg --help`"
    assert "No such option" in refused(capsys, "inspect", "flat.h5", "--colour")
    assert "Missing argument 'MAP...'" in refused(capsys, "train")


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["generate", "-o", "none/a.json"], "none/a.json: the folder none does not exist"),
        (["generate", "-o", "."], ". is a folder, expected a file name"),
        (["generate", "-o", "a.json", "--rooms", "0"], "0 is not in the range"),
        (["generate", "-o", "a.json", "--seed", "-1"], "-1 is not in the range"),
        (["generate", "-o", "a.json", "--contrast", "loud"], "'loud' is not one of"),
        (["simulate", "sim4", "--runs", "0"], "0 is not in the range"),
        (["generate", "-o", "a.txt"], "a.txt: expected a name that ends in .json"),
        (["generate", "-o", "a.json", "--clutter", "nan"], "nan is not a finite number"),
        (["replay", "flat.h5", "-o", "a.gif", "--speed", "nan"], "nan is not a finite number"),
        (["train", "flat.h5", "--C", "nan"], "nan is not a finite number"),
        (["train", "flat.h5", "--C", "0"], "0.0 is not in the range"),
        (["train", "flat.h5", "-o", "none/m.skops"], "the folder none does not exist"),
        (["view"], "Missing argument 'MAP|APARTMENT|MODEL|FOLDER'"),
        (["view", "flat.h5", "-o", "a.png", "--show", "taste"], "'taste' is not one of"),
        (["inspect", "flat.h5", "--json", "none/a.json"], "the folder none does not exist"),
    ],
)
def test_bad_arguments(folder, capsys, arguments, line):
    assert line in refused(capsys, *arguments)


def test_output_into_a_folder_without_permission(folder, capsys):
    if os.geteuid() == 0:
        pytest.skip("root may write anywhere")
    Path("locked").mkdir(mode=0o500)
    assert "not writable" in refused(capsys, "generate", "-o", "locked/a.json")


# ------------------------------------------------------------- bad map files

READERS = [
    ["render"],
    ["train", "-o", "model.skops"],
    ["segment", "--rooms", "2"],
    ["evaluate"],
    ["inspect"],
    ["validate"],
    ["view", "-o", "map.png"],
    ["view", "-o", "map.html"],
]


@pytest.mark.parametrize("arguments", READERS, ids=lambda a: a[0])
def test_bad_map_files(folder, capsys, map_bytes, arguments):
    name, *options = arguments
    Path("cut.h5").write_bytes(map_bytes[: len(map_bytes) // 2])
    Path("text.h5").write_text("no map")
    with h5py.File("foreign.h5", "w") as file:
        file["x"] = 1
    for path, message in {
        "none.h5": "none.h5: no such file",
        "cut.h5": "cut.h5: cut off or damaged HDF5 file",
        "text.h5": "text.h5: not an HDF5 file",
        "foreign.h5": "foreign.h5: attribute format: None, expected 'roomseg-map'",
        ".": ".: is a folder",
    }.items():
        if name == "view" and path == ".":
            continue
        assert refused(capsys, name, path, *options).startswith(message)


def test_damaged_inside(folder, capsys):
    with h5py.File("flat.h5", "r+") as file:
        del file["edges"]
    for name, *options in READERS[:5]:
        assert refused(capsys, name, "flat.h5", *options).startswith("flat.h5: /edges: missing")


@pytest.mark.parametrize("name", ["train", "evaluate"])
def test_maps_without_images(folder, capsys, name):
    write_map("other.h5", cleaned_flat("other"))
    n = len(cleaned_flat().nodes)
    assert refused(capsys, name, "flat.h5", "other.h5") == (
        f"flat.h5: 0 of {n} nodes have an image, expected all; `roomseg render flat.h5` makes them"
    )


def test_maps_with_some_images(folder, capsys):
    topomap = cleaned_flat()
    small = FisheyeCamera().resized(8)
    topomap = topomap.__class__(**(vars(topomap) | {"camera": small}))
    images = [None, *np.zeros((len(topomap.nodes) - 1, 8, 8), np.uint8)]
    write_map("flat.h5", topomap, images)
    n = len(topomap.nodes)
    assert f"flat.h5: {n - 1} of {n} nodes have an image" in refused(capsys, "train", "flat.h5")


def test_maps_without_ground_truth(folder, capsys):
    with h5py.File("flat.h5", "r+") as file:
        del file["ground_truth"]
    line = refused(capsys, "train", "flat.h5", "--features", "no-camera")
    assert line.startswith("flat.h5: has no /ground_truth/room")
    assert main(["segment", "flat.h5"]) == 0
    said = capsys.readouterr()
    with MapFile("flat.h5") as file:
        assert file.rooms is not None and file.rooms.model == "uniform weights"
        count = usual_room_count(len(file.topomap.nodes))
        assert file.rooms.count == count
    assert said.err.startswith(f"{count} room") and "--rooms knows better" in said.err


def test_an_empty_feature_set_is_refused(folder, capsys):
    add_to_feature_set("empty.h5", [])
    for command in (["train"], ["evaluate"], ["train", "--search", "coarse"]):
        assert refused(capsys, *command, "empty.h5") == "empty.h5: has no maps, expected at least 1"


def test_one_environment_cannot_be_left_out(folder, capsys):
    line = refused(capsys, "evaluate", "flat.h5", "--features", "no-camera")
    assert line == (
        "maps: all of the environment 'flat', expected at least 2 environments to leave one out"
    )


def test_a_search_chooses_the_parameters_and_goes_on(folder, capsys):
    write_map("other.h5", cleaned_flat("other", 8))
    train = ["train", "flat.h5", "other.h5", "--features", "no-camera", "--search", "coarse"]
    line = refused(capsys, *train, "--w", "40")
    assert line == "--w: given, expected none where --search chooses it"
    assert main([*train, "-o", "a.skops", "--json", "a.json"]) == 0
    assert capsys.readouterr().out.startswith("best of 8: C = ")
    parts = {path: path.stat().st_mtime_ns for path in Path("a.search").iterdir()}
    assert len(parts) == 4  # two places, two γ
    assert main([*train, "-o", "a.skops", "--jobs", "2"]) == 0
    capsys.readouterr()
    assert {path: path.stat().st_mtime_ns for path in Path("a.search").iterdir()} == parts
    figures = json.loads(Path("a.json").read_text())
    assert figures["search"]["space"] == "coarse"
    assert figures["parameters"]["C"] in (0.125, 2.0)
    line = refused(capsys, "train", "flat.h5", "--features", "no-camera", "--search", "coarse")
    assert line.startswith("maps: all of the environment 'flat'")


def test_bad_models(folder, capsys):
    Path("model.skops").write_text("no model")
    assert "model.skops" in refused(capsys, "segment", "flat.h5", "--model", "model.skops")
    assert "no such file" in refused(capsys, "segment", "flat.h5", "--model", "none.skops")


def test_more_rooms_than_nodes(folder, capsys):
    line = refused(capsys, "segment", "flat.h5", "--rooms", "100000")
    assert "rooms: 100000, expected 1.." in line


def test_maps_without_scene_cannot_be_rendered(folder, capsys):
    line = refused(capsys, "render", "flat.h5", "--preset", "preview")
    assert "/scene: missing, only simulated maps can be rendered" in line
    assert "preset: 'golden'" in refused(capsys, "render", "flat.h5", "--preset", "golden")


def test_view_of_what_is_not_there(folder, capsys):
    line = refused(capsys, "view", "flat.h5", "-o", "a.png", "--show", "rooms")
    assert line.startswith(
        "flat.h5: has no rooms to draw (roomseg segment finds them), only run, obstacles, edges, "
    )
    line = refused(capsys, "view", "demo9", "-o", "a.png")
    assert line.startswith("demo9: no such file, nor a reference place (demo1,")
    line = refused(capsys, "view", "demo1", "-o", "a.png", "--show", "run")
    assert line.startswith("--show run: says what to draw of a map, of nothing else")
    Path("home.json").write_text('{"name": "home"}')
    assert refused(capsys, "view", "home.json", "-o", "a.png").startswith("home.json: rooms")
    line = refused(capsys, "view", "flat.h5", "--cutaway", "-o", "a.png")
    assert line == "flat.h5: the map does not say in which apartment it was recorded"
    assert not Path("a.png").exists()


# ------------------------------------------------------------- bad apartments


def unknown_field(place):
    place["rooms"][0]["colour"] = "blue"


def doorway_off_every_wall(place):
    place["passages"][0]["position"] = [1.5, 1.5]


def overlapping_rooms(place):
    place["rooms"][1] = square_room("b", 2.0)


def no_json(place):
    return "{"


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (unknown_field, ["colour"]),
        (doorway_off_every_wall, ["passages", "1.5"]),
        (overlapping_rooms, ["rooms", "overlap"]),
        (no_json, ["JSON"]),
    ],
)
def test_bad_apartments(folder, capsys, spoil, words):
    place = apartment()
    text = spoil(place) or json.dumps(place)
    Path("bad.json").write_text(text)
    line = refused(capsys, "simulate", "bad.json", "-o", "maps")
    assert line.startswith("bad.json")
    for word in words:
        assert word in line
    assert not Path("maps").exists()


def test_missing_apartment(folder, capsys):
    assert refused(capsys, "simulate", "none.json", "-o", "maps").startswith("none.json: no such")


# ------------------------------------------------------- the process as a whole


def run(*arguments: str, **options) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "roomseg.cli", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


def test_exit_codes_of_the_process(folder):
    good, bad = run("validate", "flat.h5"), run("inspect", "none.h5")
    assert (good.returncode, good.stdout, good.stderr) == (0, "flat.h5: good\n", "")
    assert (bad.returncode, bad.stdout) == (2, "")
    assert bad.stderr == ("roomseg: error: none.h5: no such file, expected a map file (.h5)\n")


def test_problems_give_exit_code_1_and_all_lines(folder):
    with h5py.File("flat.h5", "r+") as file:
        file["nodes/position"][3, 0] = np.nan
        file.attrs["run"] = 7
    result = run("validate", "flat.h5")
    assert result.returncode == 1
    assert result.stdout.splitlines() == [
        "flat.h5: attribute run of /: 7, expected text",
        "flat.h5: /nodes/position: nan at (3, 0), expected finite numbers",
    ]


def test_reader_that_has_had_enough(folder):
    process = subprocess.Popen(
        [sys.executable, "-m", "roomseg.cli", "inspect", "flat.h5"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout is not None and process.stderr is not None
    process.stdout.close()
    assert process.stderr.read() == b""
    process.wait()


def test_stopped_by_the_user_in_one_line(folder):
    # A background job of a shell is started with SIGINT ignored.
    code = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "import sys, time, roomseg.cli.inspect as i; from roomseg.cli.main import main\n"
        "def wait(**_): print('here', flush=True); time.sleep(60)\n"
        "i.command.callback = wait; sys.exit(main(['inspect', 'flat.h5']))"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "here\n"
    time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=30)
    assert process.returncode == 130
    assert error.strip() == "roomseg: stopped; call it again to go on"


def test_our_own_errors_keep_their_traceback(monkeypatch, folder):
    from roomseg.cli import inspect

    def fail(**_: object) -> None:
        raise AssertionError("a bug")

    monkeypatch.setattr(inspect.command, "callback", fail)
    with pytest.raises(AssertionError, match="a bug"):
        command_line.main(["inspect", "flat.h5"])


def test_full_disk_is_one_line(monkeypatch, folder, capsys):
    from roomseg.cli import inspect

    def fail(**_: object) -> None:
        raise OSError(28, "No space left on device", "flat.h5")

    monkeypatch.setattr(inspect.command, "callback", fail)
    assert refused(capsys, "inspect", "flat.h5") == "flat.h5: No space left on device"


def test_every_problem_of_an_apartment_is_told(folder):
    place = json.loads(apartment_to_json(load_apartment("demo1")))
    place["passages"][0]["position"] = [-3.0, 0.5]
    place["passages"][1]["position"] = [-4.0, 0.5]
    Path("home.json").write_text(json.dumps(place))
    result = run("validate", "home.json")
    assert result.returncode == 1
    lines = result.stdout.splitlines()
    assert all(line.startswith("home.json: ") for line in lines)
    assert any("passages[0]" in line for line in lines)
    assert any("passages[1]" in line for line in lines)
    del place["start"]
    place["rooms"][0]["colour"] = "blue"
    place["rooms"][1]["ceiling_height"] = -2.5
    Path("home.json").write_text(json.dumps(place))
    result = run("validate", "home.json")
    assert (result.returncode, result.stderr) == (1, "")
    fields = [line.split(": ")[1] for line in result.stdout.splitlines()]
    assert fields == ["rooms[0].colour", "rooms[1].ceiling_height", "start"]


@pytest.mark.parametrize(
    "arguments",
    [
        ("inspect", "flat.h5", "--json", "flat.h5"),
        ("view", "flat.h5", "-o", "flat.h5"),
        ("train", "flat.h5", "-o", "flat.h5"),
        ("inspect", "flat.h5", "--json", "map-by-another-name"),
    ],
)
def test_no_output_replaces_a_map(folder, capsys, arguments):
    before = Path("flat.h5").read_bytes()
    Path("map-by-another-name").write_bytes(before)
    assert "is a map and would be lost" in refused(capsys, *arguments)
    assert Path("flat.h5").read_bytes() == before
    assert Path("map-by-another-name").read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (("generate", "-o", "new.h5"), "new.h5: expected a name that ends in .json"),
        (("replay", "flat.h5", "-o", "new.h5"), "new.h5: expected a name that ends in "),
        (("view", "flat.h5", "-o", "new.h5"), "new.h5: a name that ends in .h5 is a map's"),
        (("inspect", "flat.h5", "--json", "new.h5"), "new.h5: a name that ends in .h5 is a map's"),
    ],
)
def test_a_new_file_is_not_called_as_a_map_is(folder, capsys, arguments, line):
    assert line in refused(capsys, *arguments)
    assert not Path("new.h5").exists()


@pytest.mark.parametrize(
    "arguments",
    [
        ("generate", "-o", "pipe.json"),
        ("view", "flat.h5", "-o", "pipe.json"),
        ("inspect", "flat.h5", "--json", "pipe.json"),
    ],
)
def test_no_output_replaces_a_pipe_or_device(folder, capsys, arguments):
    os.mkfifo("pipe.json")
    assert "pipe.json is no regular file" in refused(capsys, *arguments)
    assert Path("pipe.json").is_fifo()


def test_output_through_a_link_goes_where_it_leads(folder, capsys):
    Path("real").mkdir()
    Path("figures.json").symlink_to("real/figures.json")
    assert main(["inspect", "flat.h5", "--json", "figures.json"]) == 0
    assert Path("figures.json").is_symlink()
    assert json.loads(Path("real/figures.json").read_text())
    Path("astray.json").symlink_to("none/figures.json")
    capsys.readouterr()
    assert "none does not exist" in refused(capsys, "inspect", "flat.h5", "--json", "astray.json")


@pytest.mark.parametrize(
    "arguments",
    [
        ("generate", "--rooms", "2", "-o", "a.json"),
        ("view", "flat.h5", "-o", "a.png"),
        pytest.param(("view", "demo1", "--cutaway", "-o", "a.png"), marks=pytest.mark.slow),
        ("export", "demo1", "-o", "a.glb"),
        ("export", "demo1", "-o", "a.blend"),
        ("export", "demo1", "-o", "a.svg"),
    ],
    ids=lambda arguments: f"{arguments[0]} {arguments[-1]}",
)
def test_a_disk_that_is_full_in_the_middle_is_one_line(folder, arguments):
    def cramp():
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

    before = snapshot()
    done = run(*arguments, preexec_fn=cramp)
    assert done.returncode == 2
    # With the file's name as it was given, and no other.
    assert done.stderr.startswith(f"roomseg: error: {arguments[-1]}: cannot be written: ")
    assert done.stderr.count("\n") == 1
    assert "/" not in done.stderr
    assert snapshot() == before


def test_a_picture_has_a_pictures_name_and_a_date_is_iso(folder, capsys):
    line = refused(capsys, "view", "flat.h5", "-o", "flat.gif")
    assert (
        line
        == "flat.gif: not a picture's name, expected one that ends in .png or .svg or .pdf or .html"
    )
    assert ".png" in refused(capsys, "view", "demo1", "--cutaway", "-o", "demo1.svg")
    message = refused(capsys, "simulate", "demo1", "--created", "yesterday", "-o", "maps")
    assert "2026-01-31" in message
    assert not Path("maps").exists()


def test_a_damaged_file_does_not_hide_what_is_wrong_with_others(folder):
    Path("cut.h5").write_bytes(Path("flat.h5").read_bytes()[:500])
    result = run("validate", "cut.h5", "flat.h5")
    assert result.returncode == 2
    assert result.stdout == "flat.h5: good\n"
    assert result.stderr.startswith("roomseg: error: cut.h5: ")
    assert result.stderr.count("\n") == 1


def test_the_demo_refuses_an_unknown_preset_before_it_begins(folder, capsys):
    assert "fancy" in refused(capsys, "demo", "--preset", "fancy", "-o", "out")
    assert not Path("out").exists()
