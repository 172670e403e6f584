"""Every script of `examples/` runs as it stands, on something small."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from dataset import MapFile, problems, write_map
from roomseg.ground_truth import label_rooms
from scenes import load_apartment
from simulator import simulate

ROOT = Path(__file__).resolve().parent.parent


def run(name: str, *arguments: object, folder: Path) -> str:
    """What a script prints."""
    done = subprocess.run(
        [sys.executable, str(ROOT / "examples" / name), *map(str, arguments)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


@pytest.fixture(scope="module")
def maps(tmp_path_factory):
    """Maps of two small places."""
    folder = tmp_path_factory.mktemp("maps")
    paths = []
    for name in ("demo1", "demo2"):
        paths.append(folder / f"{name}-run1.h5")
        write_map(paths[-1], label_rooms(simulate(load_apartment(name), seed=1)))
    return paths


def test_new_apartments(tmp_path):
    out = run("new_apartments.py", "-o", "homes", folder=tmp_path)
    assert "% covered" in out
    (path,) = (tmp_path / "homes").glob("*.h5")
    assert list(problems(path)) == []
    load_apartment(next((tmp_path / "homes").glob("*.json")))


def test_another_robot(tmp_path):
    out = run("another_robot.py", folder=tmp_path)
    assert "radius 0.15 m" in out and "radius 0.17 m" in out
    with MapFile(tmp_path / "robots" / "demo1-other.h5") as file:
        assert file.topomap.robot["lane_spacing"] == 0.25
        assert file.topomap.camera.image_size == (512, 640)


def test_render_many(tmp_path, maps):
    options = ("--preset", "quick", "--limit", 1, "--threads", 1)
    out = run("render_many.py", maps[0], *options, folder=tmp_path)
    assert out == f"{maps[0]}: 1 new images\n"


def test_train_and_test(tmp_path, maps):
    out = run("train_and_test.py", *maps, folder=tmp_path)
    assert "impurity" in out and (tmp_path / "model.skops").exists()
    with MapFile(maps[1]) as file:
        assert file.rooms is not None and file.rooms.model == "model.skops"


def test_own_robot(tmp_path):
    out = run("own_robot.py", folder=tmp_path)
    assert list(problems(tmp_path / "monday.h5")) == []
    with MapFile(tmp_path / "monday.h5") as file:
        truth, found = file.topomap.ground_truth, file.rooms
        assert truth is not None and truth.room is not None and found is not None
        right = file.topomap.nodes.position[:, 0] > 2.05
        assert (truth.room == (truth.room[right][0] if right[0] else right)).all()
    assert float(out.split()[-2]) < 2.0


def test_edge_feature(tmp_path, maps):
    out = run("edge_feature.py", *maps, folder=tmp_path)
    assert "length, passageway_width, obstacle_count: impurity" in out


def test_all_of_them_are_tested():
    scripts = {path.stem for path in (ROOT / "examples").glob("*.py")}
    assert {f"test_{name}" for name in scripts} <= set(globals())
