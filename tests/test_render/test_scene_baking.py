"""Baked light of a scene that is not ours, beside path tracing of the same scene."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from dataset.camera import FisheyeCamera
from render.charts import GUTTER

HERE = Path(__file__).parent
CAMERA = FisheyeCamera().resized(96)
INSIDE = CAMERA.pixel_zenith() < np.radians(85.0)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What `scene_probe` found."""
    folder = tmp_path_factory.mktemp("scene")
    done = subprocess.run(
        [sys.executable, str(HERE / "scene_probe.py"), str(folder)],
        env={**os.environ, "PYTHONPATH": str(HERE.parent.parent)},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert (folder / "scene.npz").exists(), done.stderr[-3000:]
    with np.load(folder / "scene.npz") as stored:
        return dict(stored)


@pytest.mark.parametrize("room", ["bright", "dark"])
def test_both_sides_of_a_wall_have_their_own_light(scene: dict[str, Any], room: str) -> None:
    # The other room is a hundred times as bright, or as dark.
    traced, baked = scene[f"traced_{room}"][INSIDE], scene[f"baked_{room}"][INSIDE]
    ratio = baked / traced
    assert np.median(ratio) == pytest.approx(1.0, abs=0.03)
    assert np.median(np.abs(ratio - 1.0)) < 0.05
    assert np.quantile(ratio, 0.99) < 1.5
    assert np.quantile(ratio, 0.01) > 0.7


def test_glass_and_what_glows_are_left_to_the_path_tracer(scene: dict[str, Any]) -> None:
    assert scene["not_matte"].tolist() == ["paint of pane"]
    assert {"paint of crate", "paint of turned", "plain"} <= set(scene["matte"].tolist())


def test_a_scene_without_anything_matte_is_refused_in_one_line(scene: dict[str, Any]) -> None:
    said = str(scene["refused"])
    assert said.startswith("glass-1.blend: nothing in it is matte")
    assert said.endswith("expected the preset 'reference'")


@pytest.mark.parametrize(
    ("shape", "count"), [("cube", 6), ("mirrored", 6), ("row", 1), ("apart", 2), ("ball", 6)]
)
def test_a_piece_hangs_together_and_looks_one_way(
    scene: dict[str, Any], shape: str, count: int
) -> None:
    assert scene[f"pieces_{shape}"] == count
    assert (scene[f"facing_{shape}"] > 0.0).all()


@pytest.mark.parametrize("shape", ["cube", "mirrored", "ball"])
def test_the_front_is_outside_also_of_what_is_mirrored(scene: dict[str, Any], shape: str) -> None:
    assert (scene[f"outward_{shape}"] > 0.0).all()


def test_a_floor_is_cut_at_the_wall_that_stands_on_it_and_where_the_wall_ends(
    scene: dict[str, Any],
) -> None:
    # A wall over half of a square's width: two parts beside it, and what goes on past its end.
    assert sorted(scene["cut_areas"].round(3)) == [1.0, 1.0, 1.0, 1.0]
    assert scene["cut_pieces"] == 1
    assert scene["walled_pieces"] == 2


def test_what_rays_never_met_gets_few_texels(scene: dict[str, Any]) -> None:
    boxes, shape = scene["cube_boxes"], scene["cube_shape"]
    texels = (boxes[:, 2:] - 2 * GUTTER).prod(axis=1)
    front, back = texels[0::2], texels[1::2]
    # Sides of 1 m in texels of 6 cm, what looks down of 4 cm, what looks up as few as may be.
    assert sorted(front) == [49, 289, 289, 289, 289, 625]
    assert (back <= 36).all()
    picture = np.zeros(shape, dtype=int)
    for row, column, rows, columns in boxes.tolist():
        picture[row : row + rows, column : column + columns] += 1
    assert picture.max() == 1


def test_corners_lie_in_the_charts_of_their_sides(scene: dict[str, Any]) -> None:
    for side, uv in enumerate(scene["cube_uv"]):
        low, size = scene["cube_boxes"][side::2, 1::-1], scene["cube_boxes"][side::2, :1:-1]
        inside = (uv[:, None] >= low + GUTTER - 1e-9) & (uv[:, None] <= low + size - GUTTER + 1e-9)
        assert (inside.all(axis=2).sum(axis=1) == 1).all()


def test_receivers_float_before_both_sides(scene: dict[str, Any]) -> None:
    found = np.unique(scene["cube_receivers"].round(6))
    assert found.tolist() == pytest.approx([-0.001, 0.0, 0.001, 0.999, 1.0, 1.001])
