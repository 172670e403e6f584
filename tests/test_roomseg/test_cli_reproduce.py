"""``roomseg features`` and ``roomseg reproduce`` at work."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import pytest
from cleaned_flat import cleaned_flat, fisheye_image
from made_up_features import map_features

import roomseg.experiments
from dataset import FisheyeCamera, FrameJournal, MapFile, read_map, write_map
from roomseg.cli.main import main
from roomseg.experiments import Settings
from roomseg.experiments.grids import Grid
from roomseg.feature_set import add_to_feature_set, keys_in, read_feature_set

CAMERA = FisheyeCamera().resized(116)
ONE = {"one": Grid((-3.0,), (-3.0,), (40.0,), (60.0,))}
TINY = Settings(ONE, dict.fromkeys(("no-camera", "no-pano", "no-ceiling", "no-obst"), ONE))


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def succeed(*arguments: str) -> None:
    assert main(arguments) == 0


def write_flat(name: str, seed: int, images: int | None = None) -> None:
    topomap = dataclasses.replace(cleaned_flat(name, seed), camera=CAMERA)
    count = len(topomap.nodes) if images is None else images
    write_map(f"{name}.h5", topomap)
    with FrameJournal(f"{name}.h5", CAMERA) as journal:
        for node in range(count):
            journal.append(node, fisheye_image(CAMERA, node % 5), 1.0)
        journal.pack()


def test_features_go_on_where_they_were(folder, capsys):
    write_flat("north", 1)
    write_flat("south", 2)
    succeed("features", "north.h5", "-o", "set.h5")
    assert "set.h5: 1 map, 1 of them new, 0." in capsys.readouterr().out
    first = keys_in("set.h5")
    succeed("features", "north.h5", "south.h5", "-o", "set.h5")
    assert "2 maps, 1 of them new" in capsys.readouterr().out
    assert first < keys_in("set.h5")
    complete = Path("set.h5").read_bytes()
    succeed("features", "south.h5", "north.h5", "-o", "set.h5")
    assert Path("set.h5").read_bytes() == complete
    with MapFile("south.h5") as file:
        nodes = len(file.done)
    names = {item.labelled.name: item.labelled for item in read_feature_set("set.h5")}
    assert names["south/run1"].features.graph.node_count == nodes


def test_features_refuse_before_they_begin(folder, capsys):
    write_flat("north", 1)
    write_flat("half", 2, images=10)
    before = Path("north.h5").read_bytes()
    for output, words in (("set.h5", "half.h5: 10 of"), ("north.h5", "is one of the maps")):
        assert main(["features", "north.h5", "half.h5", "-o", output]) == 2
        assert words in capsys.readouterr().err
    assert not Path("set.h5").exists()
    Path("other.h5").write_bytes(before)
    assert main(["features", "north.h5", "-o", "other.h5"]) == 2
    assert "expected 'roomseg-features'" in capsys.readouterr().err
    assert Path("north.h5").read_bytes() == Path("other.h5").read_bytes() == before


def test_reproduce_from_features(folder, capsys, monkeypatch):
    monkeypatch.setattr(roomseg.experiments, "QUICK_SETTINGS", TINY)
    maps = [map_features("a", 1), map_features("b", 2), map_features("b", 3, "new1")]
    add_to_feature_set("set.h5", maps)
    succeed("reproduce", "--quick", "--from-features", "set.h5", "-o", "out")
    printed = capsys.readouterr().out
    assert "(paper 3.13)" in printed
    assert str(Path("out/report/index.html").resolve()) in printed
    page = Path("out/report/index.html").read_text()
    assert "Table 10" in page
    assert "b/new1" in page
    assert not Path("out/maps").exists()
    tables = {path.name: path.read_text() for path in Path("out/report/tables").iterdir()}
    kept = sorted(path.name for path in Path("out/cache").iterdir())
    succeed("reproduce", "--quick", "--from-features", "set.h5", "-o", "out")
    assert tables == {path.name: path.read_text() for path in Path("out/report/tables").iterdir()}
    assert kept == sorted(path.name for path in Path("out/cache").iterdir())


def test_reproduce_refuses_in_one_line(folder, capsys):
    for arguments, words in (
        (["--from-features", "none.h5"], "none.h5: no such file, expected a feature set"),
        (["--quick", "--preset", "nice"], "nice"),
    ):
        assert main(["reproduce", *arguments, "-o", "out"]) == 2
        error = capsys.readouterr().err
        assert words in error
        assert error.count("\n") == 1
    add_to_feature_set("one.h5", [map_features("a", 1)])
    assert main(["reproduce", "--from-features", "one.h5", "-o", "out"]) == 2
    assert "1 environments, expected at least 2" in capsys.readouterr().err
    assert not Path("out/maps").exists()


def test_the_score_sheet_in_json_and_in_tables(folder, capsys):
    for seed, name in enumerate(("north", "south")):
        write_flat(name, seed, images=0)
    succeed("evaluate", "north.h5", "south.h5", "--features", "no-camera", "--json", "f.json")
    figures = json.loads(Path("f.json").read_text())
    printed = capsys.readouterr().out
    answers = {"method", "uniform", "one room"}
    assert set(figures["overall"]) == answers
    for measure, of in figures["overall"]["method"].items():
        values = [item["scores"]["method"][measure] for item in figures["maps"]]
        assert of["mean"] == pytest.approx(sum(values) / 2)
        assert of["interval"] == pytest.approx([min(values), max(values)])
    assert figures["places"]["north"]["uniform"] == figures["maps"][0]["scores"]["uniform"]
    for heading in ("By place", "All maps", "mean IoU", "room F1", "south, one room"):
        assert heading in printed


def test_quick_goes_from_plans_to_the_report(folder, capsys, monkeypatch):
    """All but the renderer, which takes minutes."""
    rendered = []

    def fake(path, *, preset, on_progress, **_):
        camera = preset.camera(read_map(path).camera)
        images = [fisheye_image(camera, seed) for seed in range(5)]
        with FrameJournal(path, camera, preset.name) as journal:
            todo = [n for n in range(len(read_map(path).nodes)) if n not in journal.done]
            rendered.append((Path(path).name, preset.name, bool(todo)))
            for node in todo:
                journal.append(node, images[node % 5], 1.0)
            journal.pack()
        return len(todo)

    monkeypatch.setattr("render.render_map", fake)
    monkeypatch.setattr(roomseg.experiments, "QUICK_SETTINGS", TINY)
    succeed("reproduce", "--quick", "-o", "out")
    names = ["demo1-run1.h5", "demo2-run1.h5", "demo3-run1.h5", "demo1-new1.h5"]
    assert rendered == [(name, "preview", True) for name in names]
    stored = [item.labelled for item in read_feature_set("out/features.h5")]
    assert [item.name for item in stored] == [
        "demo1/new1",
        "demo1/run1",
        "demo2/run1",
        "demo3/run1",
    ]
    page = Path("out/report/index.html").read_text()
    for words in ("Table 1,", "Table 10", "Fig. 11", "Fig. 26", "demo1/new1"):
        assert words in page
    before = Path("out/features.h5").read_bytes()
    capsys.readouterr()
    succeed("reproduce", "--quick", "-o", "out")
    assert rendered[4:] == [(name, "preview", False) for name in names]
    assert capsys.readouterr().out.count("already there") == 4
    assert Path("out/features.h5").read_bytes() == before
    with_maps = Path("out/report/tables/table10.csv").read_bytes()
    succeed("reproduce", "--quick", "--from-features", "out/features.h5", "-o", "other")
    assert Path("other/report/tables/table10.csv").read_bytes() == with_maps


@pytest.mark.slow
def test_quick_from_nothing(folder, capsys):
    succeed("reproduce", "--quick", "-o", "out")
    assert len(read_feature_set("out/features.h5")) == 4
    page = Path("out/report/index.html").read_text()
    for words in ("Table 1,", "Table 10", "Fig. 11", "Fig. 26", "demo1/new1"):
        assert words in page
    made = {path: path.stat().st_mtime_ns for path in Path("out/maps").glob("*.h5")}
    capsys.readouterr()
    succeed("reproduce", "--quick", "-o", "out")
    assert {path: path.stat().st_mtime_ns for path in Path("out/maps").glob("*.h5")} == made
