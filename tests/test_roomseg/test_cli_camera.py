"""Cameras on the command line: a robot's camera, exposing again, contact sheets."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from cleaned_flat import cleaned_flat, fisheye_image

from dataset import (
    CameraFlaws,
    FisheyeCamera,
    FrameJournal,
    MapFile,
    Radiance,
    RoomsegError,
    read_map,
    write_map,
)
from roomseg.cli.main import main
from roomseg.cli.runs import Run, recognise
from roomseg.cli.simulate import _camera
from simulator import RobotSpec, SensorSpec, simulate

CAMERA = FisheyeCamera(np.radians(185.0), 90.0, (100, 128), (50.0, 64.0))
TOML = "[camera]\nfull_well = 900.0\nread_noise = 9.0\nblur = 2.0\n"


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """A map whose images keep their radiance, but for the last nodes."""
    monkeypatch.chdir(tmp_path)
    topomap = cleaned_flat("flat")
    write_map("flat.h5", topomap.__class__(**(vars(topomap) | {"camera": CAMERA})))
    image = fisheye_image(CAMERA, 1)
    with FrameJournal("flat.h5", preset="draft", keep_radiance=True) as journal:
        for node in range(20):
            light = Radiance.of(image.astype(np.float32) / 1000.0 * (node + 1))
            journal.append(node, image, 1.0, light)
        journal.pack()
    return tmp_path


def test_expose_with_another_robots_camera(folder, capsys):
    Path("noisy.toml").write_text(TOML)
    assert main(["expose", "flat.h5"]) == 0
    assert "flat.h5: 20 images exposed" in capsys.readouterr().out
    with MapFile("flat.h5") as file:
        quiet, gain = file.image(3), file.gain(3)
        assert gain == pytest.approx(2.0 * file.gain(7), rel=0.01)
        assert file.preset == "draft"
    assert main(["expose", "flat.h5", "--robot", "noisy.toml"]) == 0
    with MapFile("flat.h5") as file:
        flaws = file.topomap.camera.flaws
        assert (file.image(3) != quiet).mean() > 0.3
    # The same angle in fewer pixels.
    scale = CAMERA.pixels_per_radian / FisheyeCamera().pixels_per_radian
    assert flaws == CameraFlaws(0.0, 2.0 * scale, 900.0, 9.0)


def test_expose_tells_what_is_missing(folder, capsys):
    write_map("bare.h5", cleaned_flat("bare"))
    assert main(["expose", "flat.h5", "bare.h5"]) == 2
    assert "bare.h5: /images/radiance: missing" in capsys.readouterr().err
    assert main(["expose", "flat.h5", "--robot", "none.toml"]) == 2
    assert "none.toml: cannot be read" in capsys.readouterr().err


def test_contact_sheet_of_a_map_that_is_rendered(folder, monkeypatch, capsys):
    monkeypatch.setattr("render.render_map", lambda *_, **__: 0)
    assert main(["render", "flat.h5", "--preset", "draft", "--contact-sheet"]) == 0
    assert "flat.png" in capsys.readouterr().out
    picture = cv2.imread("flat.png", cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    assert min(picture.shape) > 800


def test_a_robots_camera_is_checked_before_the_run(tmp_path):
    path = tmp_path / "robot.toml"
    path.write_text(TOML)
    assert _camera(path).flaws == CameraFlaws(0.0, 2.0, 900.0, 9.0)
    path.write_text("[camera]\ndisc_centre = [232.25, 232.0]\n")
    with pytest.raises(RoomsegError, match=r"robot.toml: camera.disc_centre: .* whole"):
        _camera(path)


def test_a_map_of_another_camera_is_not_taken_for_the_one_that_is_wanted(tmp_path):
    from scenes import load_apartment

    path = tmp_path / "map.h5"
    topomap = simulate(load_apartment("demo1"), run="run1", seed=1)
    write_map(path, topomap)

    def problem(camera: FisheyeCamera) -> str | None:
        run = Run("demo1", "run1", 1, topomap.created, path, RobotSpec(), SensorSpec(), camera)
        return recognise(run, judged=False).problem

    assert problem(FisheyeCamera()) is None
    assert "of another camera" in str(problem(CAMERA))
    # Rendered small, it is still the map of its own camera.
    with FrameJournal(path, FisheyeCamera().resized(16)) as journal:
        journal.append(0, np.ones((16, 16), np.uint8), 1.0)
        journal.pack()
    assert read_map(path).camera.disc_diameter == 16.0
    assert problem(FisheyeCamera()) is None
