"""Cameras from TOML files: what is read, and one line for every mistake."""

from __future__ import annotations

import numpy as np
import pytest

from dataset import REAL_CAMERA, SIMULATED_CAMERA, CameraFlaws, FisheyeCamera, FormatError
from simulator.camera_file import read_camera


def written(tmp_path, text):
    path = tmp_path / "robot.toml"
    path.write_text(text)
    return path


def test_a_file_without_camera_means_the_simulated_one(tmp_path):
    assert read_camera(written(tmp_path, "[robot]\nradius = 0.17\n")) == SIMULATED_CAMERA


def test_all_settings(tmp_path):
    text = (
        "[camera]\nfield_of_view_deg = 185\ndisc_diameter = 450.0\nimage_size = [512, 640]\n"
        "disc_centre = [256, 320.0]\nvignetting = 0.4\nblur = 0.5\nfull_well = 8000\n"
        "read_noise = 12.0\n"
    )
    camera = read_camera(written(tmp_path, text))
    assert camera.flaws == CameraFlaws(0.4, 0.5, 8000.0, 12.0)
    assert camera.field_of_view == pytest.approx(REAL_CAMERA.field_of_view)
    assert camera.image_size == REAL_CAMERA.image_size
    assert camera.disc_centre == REAL_CAMERA.disc_centre


def test_image_and_centre_follow_the_disc(tmp_path):
    camera = read_camera(written(tmp_path, "[camera]\ndisc_diameter = 300\n"))
    assert (camera.image_size, camera.disc_centre) == ((300, 300), (150.0, 150.0))
    camera = read_camera(written(tmp_path, "[camera]\nimage_size = [401, 500]\n"))
    assert camera == FisheyeCamera(np.radians(190.0), 464.0, (401, 500), (200.0, 250.0))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[camera]\nvigneting = 0.2", "camera.vigneting: unknown setting; did you mean vignetting"),
        ("[camera]\nfield_of_view = 3", "did you mean field_of_view_deg"),
        ("[camera]\nblur = 'much'", "camera.blur: 'much', expected a number"),
        ("[camera]\nblur = true", "camera.blur: True, expected a number"),
        (f"[camera]\nblur = 1{400 * '0'}", "expected a number"),
        ("[camera]\nblur = -1", "camera.blur: -1.0, expected a finite number >= 0"),
        ("[camera]\nimage_size = [512.0, 640]", "expected two whole numbers: rows, columns"),
        ("[camera]\nimage_size = [0, 640]", "camera.image_size: (0, 640), expected at least"),
        ("[camera]\ndisc_centre = [1]", "camera.disc_centre: [1], expected two numbers"),
        ("[camera]\ndisc_centre = [500, 0]", "camera.disc_centre: (500.0, 0.0), expected"),
        ("[camera]\ndisc_diameter = inf", "camera.disc_diameter: inf, expected > 0 px"),
        ("[camera]\nread_noise = 3", "camera.read_noise: 3.0 electrons without full_well"),
        ("camera = 3", "camera: 3, expected a table of settings"),
        ("[lens]\na = 3", "[lens]: unknown, expected one of robot, sensor, camera"),
    ],
)
def test_mistakes_are_told_in_one_line(tmp_path, text, said):
    path = written(tmp_path, text)
    with pytest.raises(FormatError) as caught:
        read_camera(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert said in message
    assert "\n" not in message
