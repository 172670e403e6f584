"""The commands at work, on flats that were cleaned without the simulator."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from cleaned_flat import cleaned_flat, fisheye_image

from dataset import FisheyeCamera, FrameJournal, MapFile, Obstacles, TopoMap, read_map, write_map
from roomseg.classifier import load_model
from roomseg.cli.main import main
from roomseg.cli.simulate import reference_runs
from roomseg.evaluation import train_on
from roomseg.features import SUBSETS, EdgeFeatures, edge_features
from roomseg.labelled_map import LabelledMap
from roomseg.segmentation import segment
from roomseg.shipped import shipped_model

CAMERA = FisheyeCamera().resized(116)


def flat(name: str, seed: int) -> TopoMap:
    """A cleaned flat without obstacle points, which take most of the time."""
    none = Obstacles(np.empty((0, 2)), np.empty(0), np.empty(0))
    topomap = cleaned_flat(name, seed)
    return dataclasses.replace(topomap, obstacles=none, camera=CAMERA)


@pytest.fixture(scope="module")
def flats(tmp_path_factory) -> dict[str, bytes]:
    """Maps of two places: a lintel over the nodes in and near the doors."""
    folder = tmp_path_factory.mktemp("flats")
    plain, lintel = fisheye_image(CAMERA, 0), fisheye_image(CAMERA, 1)
    plain = cv2.GaussianBlur(plain, (0, 0), 8.0)
    for seed, name in enumerate(("north", "south")):
        topomap = flat(name, seed)
        assert topomap.ground_truth is not None
        near = np.unique(topomap.edges[topomap.ground_truth.edge_is_border])
        images = [lintel if node in near else plain for node in range(len(topomap.nodes))]
        write_map(folder / f"{name}.h5", topomap, images)
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def folder(tmp_path, monkeypatch, flats) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, content in flats.items():
        (tmp_path / name).write_bytes(content)
    return tmp_path


def succeed(*arguments: str) -> None:
    assert main(arguments) == 0


def test_train_segment_view_inspect(folder, capsys):
    succeed("train", "north.h5", "-o", "model.skops", "--json", "train.json")
    trained = json.loads(Path("train.json").read_text())
    assert trained["maps"] == ["north.h5"]
    assert trained["features"] == ["length", "passageway_width", "passageway", "d_c", "d_s"]
    assert 0 < trained["border_edges_found"] <= trained["border_edges"] < trained["edges"]
    assert trained["parameters"] == {"C": 0.125, "gamma": 0.125, "class_weight": 40.0, "rho": 60.0}

    succeed("segment", "south.h5", "--model", "model.skops", "--json", "rooms.json")
    figures = json.loads(Path("rooms.json").read_text())
    with MapFile("south.h5") as file:
        assert file.rooms is not None
        found, truth = file.rooms.label, file.topomap.ground_truth.room
        assert (file.rooms.model, file.rooms.count) == ("model.skops", 3)
        assert file.image_count == len(found)
    assert figures["rooms"] == 3
    # Impurity by its definition: nodes outside the main room of their cluster.
    outside = sum((found == c).sum() - np.bincount(truth[found == c]).max() for c in range(3))
    assert figures["impurity"] == pytest.approx(outside / len(found))

    capsys.readouterr()
    succeed("inspect", "south.h5", "--json", "south.json")
    assert "rooms found   by model.skops" in capsys.readouterr().out
    assert json.loads(Path("south.json").read_text())["segmented_by"] == "model.skops"
    succeed("view", "south.h5", "-o", "south.png", "--dpi", "40")
    every = cv2.imread("south.png")
    succeed("view", "south.h5", "-o", "rooms.png", "--dpi", "40", "--show", "rooms")
    rooms = cv2.imread("rooms.png")
    succeed("view", "south.h5", "-o", "graph.svg", "--show", "graph")
    assert "border edge" in Path("graph.svg").read_text()
    assert every.shape[0] > 2 * rooms.shape[0]
    assert every.shape[1] > 2 * rooms.shape[1]
    assert len(np.unique(rooms.reshape(-1, 3), axis=0)) > 10
    succeed("validate", "north.h5", "south.h5")


def test_training_gives_the_same_bytes_in_another_process(folder):
    arguments = ["train", "north.h5", "--features", "no-camera", "-o"]
    succeed(*arguments, "a.skops")
    command = [sys.executable, "-m", "roomseg.cli", *arguments, "b.skops"]
    subprocess.run(command, check=True, capture_output=True)
    assert Path("a.skops").read_bytes() == Path("b.skops").read_bytes()
    plain = train_on([LabelledMap.of(read_map("north.h5"), features_without_images("north.h5"))])
    loaded = load_model("a.skops")
    features = features_without_images("south.h5")
    np.testing.assert_array_equal(loaded.predict(features), plain.predict(features))
    assert loaded.parameters == plain.parameters
    succeed("segment", "south.h5", "--model", "b.skops")


def features_without_images(name: str) -> EdgeFeatures:
    with MapFile(name) as file:
        return edge_features(file, SUBSETS["no-camera"])


def test_segment_gives_the_same_bytes_again(folder):
    arguments = ["north.h5", "--model", "uniform", "--rooms", "4", "--seed", "5"]
    succeed("segment", *arguments)
    first = Path("north.h5").read_bytes()
    succeed("segment", *arguments)
    assert Path("north.h5").read_bytes() == first
    with MapFile("north.h5") as file:
        assert file.rooms is not None
        assert file.rooms.model == "uniform weights"
        assert sorted(set(file.rooms.label.tolist())) == [0, 1, 2, 3]


def test_without_a_model_that_of_roomseg_is_used(folder, monkeypatch):
    succeed("segment", "north.h5")
    with MapFile("north.h5") as file:
        assert file.rooms is not None
        assert file.rooms.model == "uniform weights"  # its discs are too small
    monkeypatch.setattr("roomseg.shipped.DISC_DIAMETER", 116.0)
    succeed("segment", "north.h5")
    with MapFile("north.h5") as file:
        assert file.rooms is not None
        assert file.rooms.model == "reference.skops"
        features, model = edge_features(file), shipped_model()
        rng, rho = np.random.default_rng(0), model.parameters.rho
        expected = segment(features.graph, model.predict(features), 3, rng, rho)
        np.testing.assert_array_equal(file.rooms.label, expected)


def test_a_feature_set_trains_and_is_judged_as_its_maps(folder):
    succeed("features", "north.h5", "south.h5", "-o", "both.h5")
    maps = ["north.h5", "south.h5"]
    for name, sources in (("maps", maps), ("set", ["both.h5"])):
        succeed("train", *sources, "-o", f"{name}.skops", "--json", f"{name}-train.json")
        succeed("evaluate", *sources, "--json", f"{name}.json")
    one, other = (json.loads(Path(f"{name}.json").read_text()) for name in ("maps", "set"))
    assert [item["map"] for item in other["maps"]] == ["both.h5", "both.h5"]
    assert [item["run"] for item in one["maps"]] == [item["run"] for item in other["maps"]]
    assert one["mean_impurity"] == other["mean_impurity"]
    one, other = (load_model(f"{name}.skops") for name in ("maps", "set"))
    assert one.trained_on == other.trained_on
    np.testing.assert_allclose(one.mean, other.mean, rtol=1e-6)


def test_evaluate_reports_every_map_beside_uniform_weights(folder, capsys):
    succeed("evaluate", "north.h5", "south.h5", "--features", "no-camera", "--json", "f.json")
    figures = json.loads(Path("f.json").read_text())
    assert [item["map"] for item in figures["maps"]] == ["north.h5", "south.h5"]
    impurity = [item["segmentation"]["impurity"] for item in figures["maps"]]
    uniform = [item["uniform"]["impurity"] for item in figures["maps"]]
    assert figures["mean_impurity"] == pytest.approx(np.mean(impurity))
    assert figures["median_impurity"] == pytest.approx(np.median(impurity))
    assert figures["uniform_mean_impurity"] == pytest.approx(np.mean(uniform))
    table = capsys.readouterr().out
    for row, value in zip(("north run1", "south run1"), impurity, strict=True):
        line = next(line for line in table.splitlines() if row in line)
        assert f"{100 * value:.2f}" in line


def test_failed_training_leaves_the_old_model(folder, capsys):
    Path("model.skops").write_text("old")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("skops.io.dump", _write_half_and_fail)
        code = main(["train", "north.h5", "--features", "no-camera"])
    assert code == 2
    assert Path("model.skops").read_text() == "old"
    assert sorted(path.name for path in folder.iterdir()) == ["model.skops", "north.h5", "south.h5"]


def _write_half_and_fail(content: object, file: str | Path) -> None:
    Path(file).write_text("half")
    raise OSError(28, "No space left on device", str(file))


def test_generate_is_repeatable(folder):
    for name in ("a.json", "b.json"):
        succeed("generate", "--seed", "3", "--rooms", "2", "-o", name)
    succeed("generate", "--seed", "4", "--rooms", "2", "-o", "c.json")
    assert Path("a.json").read_bytes() == Path("b.json").read_bytes()
    assert Path("a.json").read_bytes() != Path("c.json").read_bytes()
    assert len(json.loads(Path("a.json").read_text())["rooms"]) == 2


def test_render_passes_its_options_and_discards_by_force(folder, monkeypatch, capsys):
    calls = []

    def fake(path, *, on_progress, **options):
        with FrameJournal(path, preset=options["preset"].name) as journal:
            calls.append((str(path), options["preset"].name, options["limit"], len(journal.done)))
        on_progress(1, 2)
        return 1

    monkeypatch.setattr("render.render_map", fake)
    n = len(read_map("north.h5").nodes)
    succeed("render", "north.h5", "south.h5", "--preset", "draft", "--limit", "4")
    succeed("render", "north.h5", "--preset", "preview", "--force")
    assert calls == [
        ("north.h5", "draft", 4, n),
        ("south.h5", "draft", 4, n),
        ("north.h5", "preview", None, 0),
    ]
    assert "north.h5: 1 new images" in capsys.readouterr().out


def test_render_refuses_another_preset_before_it_begins(folder, monkeypatch, capsys):
    with FrameJournal("south.h5", preset="draft") as journal:
        journal.append(0, np.ones(CAMERA.image_size, np.uint8), 1.0)
        journal.pack()
    monkeypatch.setattr("render.render_map", lambda *_, **__: pytest.fail("must not begin"))
    assert main(["render", "north.h5", "south.h5"]) == 2
    assert "south.h5: holds frames of preset 'draft', not 'fast'" in capsys.readouterr().err


def test_inspect_an_apartment(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    succeed("inspect", "demo1", "--json", "demo1.json")
    shown = capsys.readouterr().out
    figures = json.loads(Path("demo1.json").read_text())
    assert f"{len(figures['rooms'])} on {figures['floor_area']:.1f} m²" in shown
    for room in figures["rooms"]:
        assert room["name"] in shown
    for kind, count in figures["pieces"].items():
        assert f"{count} {kind}" in shown


def test_the_reference_set_says_all_of_its_runs(folder, capsys):
    for more in (["sim3"], ["--runs", "2"], ["--seed", "1"]):
        assert main(["simulate", "--reference-set", *more, "-o", "maps"]) == 2
        assert "does not go with --reference-set" in capsys.readouterr().err
    assert not Path("maps").exists()
    runs = reference_runs(Path("maps"), "1970-01-01T00:00:00Z")
    assert len({run.output for run in runs}) == 31 + 5 + 5
    first = next(run for run in runs if run.output.name == "sim5-run1.h5")
    assert first.start == pytest.approx((5.5, 7.7, -np.pi / 2))
