"""``roomseg build``: a dataset from a recipe, stopped and continued, and what fails in it."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from small_flats import two_rooms, write_rooms

import roomseg.cli.runs
from dataset import MapFile, read_map
from roomseg.cli.main import main
from scenes import load_apartment

RECIPE = """name = "Two flats"
description = "For a test."
seed = 4
preset = "draft"
starts = "random"
[camera]
disc_diameter = 12
[[places]]
split = "train"
files = "two.json"
runs = 2
[[places]]
split = "test"
files = "other.json"
"""


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """Two flats and their recipe; the second has no lintel over its doorway."""
    monkeypatch.chdir(tmp_path)
    write_rooms("two")
    write_rooms("other", passages=[{"position": [1.66, 0.8], "lintel_height": None}])
    Path("recipe.toml").write_text(RECIPE)
    return tmp_path


def build(*arguments: str, output: str = "homes") -> int:
    return main(["build", "recipe.toml", "--no-images", "-o", output, *arguments])


def contents(place: str) -> dict[str, bytes]:
    files = sorted(path for path in Path(place).rglob("*") if path.is_file())
    return {str(path.relative_to(place)): path.read_bytes() for path in files}


def test_a_dataset_and_its_figures(folder, capsys):
    assert build() == 0
    made = contents("homes")
    maps = ["test/other-run1.h5", "train/two-run1.h5", "train/two-run2.h5"]
    others = ["README.md", "apartments/other.json", "apartments/two.json", "manifest.json"]
    others.append("overview.png")
    assert sorted(made) == sorted([*others, "recipe.toml", *maps])
    assert made["recipe.toml"].decode() == RECIPE
    manifest = json.loads(made["manifest.json"])
    assert [item["file"] for item in manifest["maps"]] == [*maps[1:], maps[0]]
    for item in (*manifest["maps"], *manifest["places"]):
        data = made[item["file"]]
        assert (item["bytes"], item["sha256"]) == (len(data), hashlib.sha256(data).hexdigest())
    for item in manifest["maps"]:
        topomap = read_map(Path("homes", item["file"]))
        assert item["nodes"] == len(topomap.nodes)
        assert item["edge_count"] == len(topomap.edges)
        assert item["border_edge_count"] == topomap.ground_truth.edge_is_border.sum() > 0
        assert (item["place"], item["seed"]) == (topomap.environment, topomap.seed)
        assert topomap.camera.image_size == (12, 12)
        assert 0.9 < item["coverage"] <= 1.0
    train, test = (manifest["splits"][name] for name in ("train", "test"))
    total = manifest["total"]
    nodes = [item["nodes"] for item in manifest["maps"]]
    assert (train["nodes"], test["nodes"], total["nodes"]) == (sum(nodes[:2]), nodes[2], sum(nodes))
    assert (train["places"], train["maps"], total["rooms"]) == (1, 2, 4)
    assert total["floor_area"] == pytest.approx(4 * 1.6 * 1.6)
    assert (manifest["complete"], manifest["problems"]) == (False, [])
    starts = {tuple(read_map(Path("homes", name)).path.true_pose[0]) for name in maps}
    assert len(starts) == 3
    card = made["README.md"].decode()
    assert card.startswith("# Two flats\n\nFor a test.\n")
    assert f"| nodes | {train['nodes']} | {test['nodes']} | {total['nodes']} |" in card
    assert "| other | test | other.json | 2 | 5.1 | exterior |" in card


def test_called_again_it_goes_on_whatever_the_number_of_jobs(folder, capsys, monkeypatch):
    assert build(output="whole") == 0
    real, made = roomseg.cli.runs._simulate, []

    def stopping(run, show):
        if made:
            raise KeyboardInterrupt
        made.append(run.name)
        return real(run, show)

    monkeypatch.setattr("roomseg.cli.runs._simulate", stopping)
    assert build() == 130
    monkeypatch.undo()
    monkeypatch.chdir(folder)
    assert len(list(Path("homes").glob("*/*.h5"))) == 1
    assert not Path("homes/manifest.json").exists()
    capsys.readouterr()
    assert build("--dry-run") == 0
    shown = capsys.readouterr().out
    assert "1 of 1 │ 1 of 2 │" in shown and "1 of 1 │ 0 of 1 │" in shown
    before = {path: path.stat().st_mtime_ns for path in Path("homes").rglob("*.h5")}
    assert build("--jobs", "2") == 0
    assert contents("homes") == contents("whole")
    assert all(path.stat().st_mtime_ns == then for path, then in before.items())
    # Without images it is not complete; the next one looks again and finds all of it.
    capsys.readouterr()
    assert build() == 0
    assert "homes: missing: nothing but the manifest\n" in capsys.readouterr().out
    assert contents("homes") == contents("whole")


def test_what_is_missing_is_told_and_made(folder, capsys):
    assert build() == 0
    before = contents("homes")
    Path("homes/train/two-run2.h5").unlink()
    Path("homes/apartments/other.json").unlink()
    # What killed processes leave.
    Path("homes/train/.two-run2.h5.123.part").write_bytes(b"half")
    Path("homes/apartments/.other.json.x1y2").write_bytes(b"{")
    Path("homes/.hidden").write_bytes(b"not ours")
    capsys.readouterr()
    expected = "missing: 1 apartment (apartments/other.json), 1 map (train/two-run2.h5)"
    assert build("--dry-run") == 0
    assert expected in capsys.readouterr().out
    assert build() == 0
    assert f"homes: {expected}\n" in capsys.readouterr().out
    assert contents("homes") == before | {".hidden": b"not ours"}


def test_a_bad_place_is_listed_and_the_others_go_on(folder, capsys):
    Path("broken.json").write_text("{")
    write_rooms("stuck", start={"position": [0.02, 0.02]})
    text = RECIPE.replace('"two.json"', '["two.json", "broken.json", "stuck.json"]')
    Path("recipe.toml").write_text(text.replace('starts = "random"', ""))
    assert main(["build", str(folder / "recipe.toml"), "--no-images", "-o", "homes"]) == 2
    error = capsys.readouterr().err
    assert f"roomseg: error: {folder}/broken.json: line 1" in error
    assert "stuck.json: start.position: (0.02, 0.02)" in error
    manifest = json.loads(Path("homes/manifest.json").read_text())
    assert [item["place"] for item in manifest["maps"]] == ["two", "two", "other"]
    first, second = manifest["problems"]
    assert first.startswith("broken.json: ") and second.startswith("stuck.json: ")
    assert manifest["splits"]["train"]["maps_wanted"] == 6
    assert manifest["problems"][0] in Path("homes/README.md").read_text()
    assert main(["inspect", "homes"]) == 0
    assert "problem       broken.json: line 1" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("seed = 4", "seed = 5", "train/two-run1.h5: already there, but of another seed"),
        ("= 12", "= 13", "train/two-run1.h5: already there, but of another camera"),
        ('"draft"', '"draft"\nrobot.radius = 0.14', "but of another robot"),
        ('"test"', '"train"', "homes/test/other-run1.h5: not of this recipe, as it is now; remove"),
        ("runs = 2", "runs = 1", "two-run2.h5: not of this recipe, as it is now; remove it or"),
    ],
)
def test_what_is_there_must_be_what_the_recipe_says(folder, capsys, old, new, expected):
    assert build() == 0
    before = contents("homes")
    Path("recipe.toml").write_text(RECIPE.replace(old, new))
    assert build() == 2
    assert expected in capsys.readouterr().err
    now = contents("homes")
    assert all(now[name] == data for name, data in before.items() if name.endswith(".h5"))


def test_another_apartment_of_the_name(folder, capsys):
    assert build() == 0
    write_rooms("two", lighting={"source": "mixed"})
    assert build() == 2
    assert "apartments/two.json: already there, but not as in two.json" in capsys.readouterr().err


def test_no_apartment_is_in_two_splits_by_another_name(folder, capsys):
    Path("other.json").write_text(json.dumps(two_rooms("other", description="quite another")))
    assert build() == 2
    error = capsys.readouterr().err
    assert "the apartment of 'two' by another name; expected it in one split" in error
    assert not list(Path("homes").rglob("*.h5"))
    Path("recipe.toml").write_text(RECIPE.replace('"test"', '"train"'))
    assert build() == 0


def test_generated_and_reference_places(folder, capsys):
    Path("recipe.toml").write_text(
        'preset = "draft"\n[[places]]\nsplit = "train"\nseeds = 3\n'
        "options = { rooms = 1, area = 9.0, clutter = 0.0 }\n"
        '[[places]]\nsplit = "validation"\nreference = "demo2"\n'
    )
    assert build() == 0
    manifest = json.loads(Path("homes/manifest.json").read_text())
    home, demo = manifest["places"]
    assert (home["from"], home["rooms"], demo["from"]) == ("seed 3", 1, "demo2")
    assert home["floor_area"] == pytest.approx(9.0, rel=0.02)
    assert load_apartment(Path("homes", demo["file"])) == load_apartment("demo2")


def test_inspect_sums_up_and_draws(folder, capsys):
    assert main(["inspect", "."]) == 2
    assert (
        ".: is a folder without manifest.json; expected that of a finished"
        in capsys.readouterr().err
    )
    assert build() == 0
    capsys.readouterr()
    assert main(["inspect", "homes", "-o", "sheet.png", "--json", "all.json"]) == 0
    shown = capsys.readouterr().out
    assert "maps          3 of 3" in shown and "files         all there" in shown
    assert Path("all.json").read_text().split() == Path("homes/manifest.json").read_text().split()
    picture = cv2.imread("sheet.png")
    assert picture is not None and (picture < 128).any()
    Path("homes/apartments/two.json").unlink()
    assert main(["inspect", "homes"]) == 0
    assert "apartments/two.json" in capsys.readouterr().out
    manifest = json.loads(Path("homes/manifest.json").read_text())
    for change, fault in [
        ({"splits": 3}, "splits: expected"),
        ({"maps": [{**manifest["maps"][0], "bytes": "x"}]}, "maps[0].bytes: expected a whole"),
        ({"places": [{**manifest["places"][0], "file": "../two.json"}]}, "places[0].file: "),
        ({"places": [{**manifest["places"][0], "file": "/etc/passwd"}]}, "places[0].file: "),
    ]:
        Path("homes/manifest.json").write_text(json.dumps(manifest | change))
        assert main(["inspect", "homes"]) == 2
        error = capsys.readouterr().err
        assert f"homes/manifest.json: {fault}" in error and error.count("\n") == 1
    Path("homes/manifest.json").write_text("{}")
    assert main(["inspect", "homes"]) == 2
    assert (
        "manifest.json: format: missing; not the manifest of a dataset" in capsys.readouterr().err
    )
    assert main(["inspect", "two.json", "-o", "sheet.png"]) == 2
    assert "`roomseg view` draws" in capsys.readouterr().err


def test_the_page_of_a_dataset(folder):
    assert build() == 0
    made = contents("homes")
    assert main(["view", "homes", "-o", "homes.html"]) == 0
    page = Path("homes.html").read_text(encoding="utf-8")
    for name in ("apartments/two.json", "train/two-run2.h5", "test/other-run1.h5"):
        assert page.count(name) > 1, "as a card and in the table"
    assert "manifest.json" not in page
    assert "3 of 3, " in page, "what inspect tells of the maps"
    assert contents("homes") == made


def test_images_are_made_and_kept(folder, capsys):
    lamps = [{"position": [0.8, 0.8]}, {"position": [2.5, 0.8]}]
    write_rooms("two", lamps=lamps, lighting={"source": "interior"})
    text = RECIPE[: RECIPE.index("runs = 2")].replace('"draft"', '"quick"')
    Path("recipe.toml").write_text(text)
    assert main(["build", "recipe.toml", "--threads", "1", "--device", "cpu", "-o", "homes"]) == 0
    manifest = json.loads(Path("homes/manifest.json").read_text())
    assert manifest["complete"]
    (item,) = manifest["maps"]
    assert item["images_done"] == item["nodes"] > 20
    with MapFile(Path("homes", item["file"])) as file:
        assert file.preset == "quick"
        means = file.images[:].mean(axis=(1, 2))
    assert np.all(means > 20)
    before = contents("homes")
    capsys.readouterr()
    times = {path: path.stat().st_mtime_ns for path in Path("homes").rglob("*")}
    assert main(["build", "recipe.toml", "-o", "homes"]) == 0
    assert capsys.readouterr().out == "homes: nothing is missing\n"
    assert {path: path.stat().st_mtime_ns for path in Path("homes").rglob("*")} == times
    Path("homes/README.md").unlink()
    assert main(["build", "recipe.toml", "-o", "homes"]) == 0
    assert "nothing but the manifest" in capsys.readouterr().out
    assert contents("homes") == before
    Path("recipe.toml").write_text(text.replace('"quick"', '"draft"'))
    assert main(["build", "recipe.toml", "-o", "homes"]) == 2
    assert "preset" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("starts", "start", "line 5: start: unknown key; did you mean 'starts'?"),
        ("= 12", "= -12", "line 7: camera.disc_diameter: -12.0, expected > 0 px"),
        ("runs = 2", 'runs = "two"', "line 11: places[0].runs: 'two'; expected a whole number"),
        ('"other.json"', '"two.json"', "line 12: places[1]: 'two' is in places[0], train, already"),
        ('files = "other.json"', "seeds = [9, 3]", "line 14: places[1].seeds: 9, 3; expected the"),
    ],
)
def test_a_broken_recipe_is_one_line_and_nothing_is_made(folder, capsys, old, new, expected):
    Path("recipe.toml").write_text(RECIPE.replace(old, new))
    assert build() == 2
    shown = capsys.readouterr()
    assert shown.err.startswith(f"roomseg: error: recipe.toml: {expected}")
    assert (shown.out, shown.err.count("\n")) == ("", 1)
    assert not Path("homes").exists()
