"""Recipes: the one in the docs, what they mean, and what is refused on which line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from small_flats import write_rooms

from dataset import REAL_CAMERA, SIMULATED_CAMERA, RoomsegError
from roomseg.cli.recipe import read_recipe
from scenes.generator import Wishes, apartment_name
from simulator import RobotSpec, SensorSpec

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(text: str, name: str = "recipe.toml") -> str:
    Path(name).write_text(text)
    return name


def test_the_recipe_of_the_docs():
    assert (DOCS / "recipe.toml").read_text() in (DOCS / "build.md").read_text()
    recipe = read_recipe(DOCS / "recipe.toml")
    assert recipe.robot == RobotSpec(lane_spacing=0.28)
    assert recipe.sensor == SensorSpec(beams=12)
    assert recipe.preset.name == "fast"
    assert recipe.camera.field_of_view == pytest.approx(np.radians(185.0))
    assert (recipe.camera.image_size, recipe.camera.disc_centre) == ((232, 232), (116.0, 116.0))
    wishes = Wishes(rooms=(1, 3), area=(10.0, 25.0), lighting="mixed")
    homes = [(place.name, place.split, place.runs, place.starts) for place in recipe.places[:5]]
    assert homes == [
        (apartment_name(seed, wishes), "train" if seed < 4 else "validation", 2, "random")
        for seed in range(5)
    ]
    tested = [(place.name, place.split, place.runs, place.starts) for place in recipe.places[5:]]
    assert tested == [("demo1", "test", 1, "own"), ("demo2", "test", 1, "own")]


def test_the_least_recipe_has_the_defaults_of_the_commands(folder):
    text = 'preset = "draft"\n[[places]]\nsplit = "test"\nseeds = 5\n'
    recipe = read_recipe(write(text, "least.toml"))
    assert (recipe.name, recipe.seed, recipe.text) == ("least", 0, text)
    assert (recipe.robot, recipe.sensor) == (RobotSpec(), SensorSpec())
    assert recipe.camera == SIMULATED_CAMERA
    (place,) = recipe.places
    assert (place.name, place.runs, place.starts, place.origin) == ("home-5", 1, "own", "seed 5")


def test_robots_cameras_and_files(folder):
    Path("robots").mkdir()
    Path("robots/wide.toml").write_text(
        "[robot]\nradius = 0.17\n[sensor]\nbeams = 4\n[camera]\nblur = 0.6\n"
    )
    write_rooms("two")
    Path("broken.json").write_text("{")
    recipe = read_recipe(
        write(
            'preset = "draft"\nrobot = "robots/wide.toml"\ncamera = "real"\n'
            'created = 2026-01-31T12:00:00Z\n[[places]]\nsplit = "train"\n'
            'files = ["two.json", "broken.json"]\n'
        )
    )
    assert (recipe.robot.radius, recipe.sensor.beams) == (0.17, 4)
    assert recipe.camera == REAL_CAMERA
    assert recipe.created.startswith("2026-01-31")
    # What is wrong with an apartment is told when it is made: the others go on.
    assert [place.name for place in recipe.places] == ["two", "broken"]
    text = 'preset = "draft"\nhdr = true\nrobot = "robots/wide.toml"\n[[places]]\nsplit = "train"\n'
    own = read_recipe(write(f"{text}seeds = 1\n"))
    assert (own.camera.flaws.blur, own.hdr) == (0.6, True)
    Path("robots/wide.toml").write_text("[camera]\ndisc_centre = [100.3, 100]\n")
    with pytest.raises(RoomsegError, match=r"line 3: robot: .*robots/wide.toml: camera.disc_cen"):
        read_recipe(write(f"{text}seeds = 1\n"))
    wide = read_recipe(
        write(
            'preset = "draft"\n[camera]\ndisc_diameter = 450\nimage_size = [512, 640]\n'
            '[[places]]\nsplit = "train"\nseeds = 1\n'
        )
    )
    assert wide.camera.disc_centre == (256.0, 320.0)


GOOD = """preset = "draft"
runs = 1
robot = { radius = 0.15 }
[sensor]
beams = 8

[camera]
disc_diameter = 32
[[places]]
split = "train"
seeds = [
  0,
  3,
]
options = { rooms = 2 }
[[places]]
split = "test"
reference = "demo1"
"""


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("runs", "rums", "line 2: rums: unknown key; did you mean 'runs'?"),
        ("runs = 1", "runs = 0", "line 2: runs: 0; expected at least 1"),
        ("runs = 1", 'runs = "one"', "line 2: runs: 'one'; expected a whole number"),
        ("draft", "drift", "line 1: preset: 'drift', expected one of "),
        ("runs = 1", "seed = -1", "line 2: seed: -1; expected at least 0"),
        ("runs = 1", 'starts = "far"', "line 2: starts: 'far'; expected 'own' or 'random'"),
        ("runs = 1", 'created = "now"', "line 2: created: 'now'; expected a date"),
        ("radius = 0.15", "radus = 1", "line 3: robot.radus: unknown setting; did you mean radius"),
        ("radius = 0.15", "radius = -1", "line 3: robot.radius: -1.0, expected a finite number"),
        ("radius = 0.15", 'radius = "a"', "line 3: robot.radius: 'a', expected a number"),
        ("robot = {", 'robot = "no.toml" #', "line 4: sensor: expected it in 'no.toml'"),
        ("beams = 8", "beams = 0", "line 5: sensor.beams: 0, expected"),
        ("disc_diameter = 32", "disk_diameter = 32", "line 8: camera.disk_diameter: unknown setti"),
        ("disc_diameter = 32", "disc_diameter = -32", "line 8: camera.disc_diameter: -32.0, exp"),
        ("disc_diameter = 32", 'disc_diameter = "w"', "line 8: camera.disc_diameter: 'w', exp"),
        ("disc_diameter = 32", "field_of_view_deg = 400", "line 8: camera.field_of_view_deg: 400,"),
        ("disc_diameter = 32", "disc_centre = [0.3, 1]", "line 8: camera.disc_centre: (0.3, 1.0)"),
        ("disc_diameter = 32", "height = 0.2", "line 8: camera.height: unknown setting; expect"),
        ("[camera]\ndisc", 'camera = "best"\n[a]\ndisc', "unknown key"),
        ('"train"', '"dev"', "line 10: places[0].split: 'dev'; expected 'train', 'validation' or"),
        ('split = "test"\n', "", "line 16: places[1].split: missing"),
        ("  3,\n", "  -3,\n", "line 11: places[0].seeds[1]: -3; expected at least 0"),
        ("  3,\n", "", "line 11: places[0].seeds"),
        ("  0,\n", "  9,\n", "line 11: places[0].seeds: 9, 3; expected the smaller one first"),
        ("rooms = 2", "rooms = 13", "line 15: places[0].options.rooms: 13; expected a whole"),
        ("rooms = 2", "room = 2", "line 15: places[0].options.room: unknown key; did you mean"),
        ("demo1", "demo9", "line 18: places[1].reference: 'demo9'; expected some of demo1, "),
        ("reference", "references", "line 18: places[1].references: unknown key; did you mean"),
        ('reference = "demo1"', 'files = "a/../../b.json"', "line 18: places[1].files: 'a/../../b"),
        ('reference = "demo1"', 'files = "../a.json"', "line 18: places[1].files: '../a.json'"),
        ('reference = "demo1"', 'files = "/a.json"', "expected a file in the recipe's folder"),
        ('reference = "demo1"', "", "line 16: places[1]: expected one of reference, files and"),
        ('"demo1"', '"demo1"\nseeds = 3', "line 16: places[1]: expected one of reference, files"),
        ('"demo1"', '"demo1"\noptions = {}', "line 19: places[1].options: say what to generate"),
        ('"demo1"', '["demo1", "demo1"]', "line 16: places[1]: 'demo1' is in places[1], test, alr"),
        (
            'reference = "demo1"',
            "seeds = [3, 4]\noptions.rooms = 2",
            "is in places[0], train, already; expected every place once",
        ),
        ("runs = 1", "runs = ", "not a TOML text file: Invalid value (at line 2, column 8)"),
    ],
)
def test_refused_in_one_line_with_its_number(folder, old, new, expected):
    assert old in GOOD
    with pytest.raises(RoomsegError) as caught:
        read_recipe(write(GOOD.replace(old, new, 1)))
    message = str(caught.value)
    assert message.startswith("recipe.toml: ") and "\n" not in message
    assert expected in message


def test_the_good_one_is_good(folder):
    assert len(read_recipe(write(GOOD)).places) == 5


def test_no_file(folder):
    with pytest.raises(RoomsegError, match=r"recipe.toml: cannot be read: No such file"):
        read_recipe("recipe.toml")
    Path("recipe.toml").write_bytes(b"\xff")
    with pytest.raises(RoomsegError, match="not a TOML text file"):
        read_recipe("recipe.toml")
    with pytest.raises(RoomsegError, match=r"line 2: places: empty; expected at least one"):
        read_recipe(write('preset = "draft"\nplaces = []\n'))
