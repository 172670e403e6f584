"""The equidistant fisheye model against values worked out by hand."""

from __future__ import annotations

import json
from dataclasses import asdict

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dataset.camera import SIMULATED_CAMERA, CameraFlaws, FisheyeCamera

REAL = FisheyeCamera(np.radians(185), 450.0, (512, 640), (256.0, 320.0), 0.09)


def test_axis_and_rim_of_the_simulated_camera():
    centre = SIMULATED_CAMERA.project(np.array(0.3), np.array(0.0))
    rim = SIMULATED_CAMERA.project(np.array(0.0), np.radians(95.0))
    np.testing.assert_allclose(centre, [232.0, 232.0])
    np.testing.assert_allclose(rim, [232.0, 464.0])


def test_left_of_the_robot_is_at_the_bottom():
    row, column = SIMULATED_CAMERA.project(np.radians(90.0), np.radians(95.0))
    np.testing.assert_allclose([row, column], [464.0, 232.0])


@given(
    st.sampled_from([SIMULATED_CAMERA, REAL]),
    st.floats(-np.pi, np.pi, exclude_min=True),
    st.floats(1e-3, np.radians(92)),
)
def test_project_and_unproject_invert_each_other(camera, azimuth, zenith):
    back_azimuth, back_zenith = camera.unproject(
        camera.project(np.array(azimuth), np.array(zenith))
    )
    assert back_zenith == pytest.approx(zenith, abs=1e-9)
    assert np.cos(back_azimuth - azimuth) == pytest.approx(1.0, abs=1e-9)


def test_panorama_map_has_elevation_down_and_azimuth_across():
    map_x, map_y = REAL.panorama_map()
    assert map_x.shape == map_y.shape == (48, 288)
    points = np.stack([map_y, map_x], axis=-1).astype(float) + 0.5
    azimuth, zenith = REAL.unproject(points)
    np.testing.assert_allclose(
        np.degrees(np.pi / 2 - zenith[:, 0]), 75 * (1 - (np.arange(48) + 0.5) / 48), atol=1e-3
    )
    turns = np.mod(azimuth[20], 2 * np.pi) / (2 * np.pi)
    np.testing.assert_allclose(turns, (np.arange(288) + 0.5) / 288, atol=1e-5)


def test_smaller_disc_sees_the_same_angles():
    small = SIMULATED_CAMERA.resized(200)
    assert small.field_of_view == SIMULATED_CAMERA.field_of_view
    np.testing.assert_allclose(small.project(np.array(0.0), np.radians(95.0)), [100.0, 200.0])
    assert small.pixel_zenith().shape == (200, 200)


@pytest.mark.parametrize(
    "field",
    [
        {"field_of_view": 0.0},
        {"field_of_view": 7.0},
        {"disc_diameter": -1.0},
        {"image_size": (0, 464)},
        {"height": 0.0},
        {"disc_diameter": np.inf},
        {"disc_centre": (232.0, 465.0)},
        {"disc_centre": (np.nan, 232.0)},
    ],
)
def test_impossible_cameras_are_refused(field):
    with pytest.raises(ValueError, match=next(iter(field))):
        FisheyeCamera(**field)


FLAWED = FisheyeCamera(
    np.radians(200.0), 560.0, (512, 640), (250.0, 330.0), flaws=CameraFlaws(0.3, 0.8, 9000.0, 15.0)
)


def test_a_disc_larger_than_its_image_and_off_its_middle() -> None:
    """Pixel by pixel, against the projection written out."""
    zenith = np.degrees(FLAWED.pixel_zenith())
    assert zenith.shape == (512, 640)
    for row, column in ((0, 0), (511, 0), (0, 639), (250, 330), (400, 17)):
        radius = np.sqrt((row + 0.5 - 250.0) ** 2 + (column + 0.5 - 330.0) ** 2)
        assert zenith[row, column] == pytest.approx(radius * 200.0 / 560.0)


@pytest.mark.parametrize("degrees", [160.0, 185.0, 220.0])
def test_what_a_camera_shows_of_the_panorama(degrees: float) -> None:
    camera = FisheyeCamera(np.radians(degrees), 300.0, (200, 400), (90.0, 210.0))
    shown = camera.shows(*camera.panorama_map())
    for row, column in np.ndindex(48, 288):
        elevation = 75.0 * (1.0 - (row + 0.5) / 48.0)
        azimuth = np.radians((column + 0.5) * 360.0 / 288.0)
        radius = (90.0 - elevation) * 300.0 / degrees
        at = 90.0 + radius * np.sin(azimuth), 210.0 + radius * np.cos(azimuth)
        seen = 0.0 <= at[0] <= 200.0 and 0.0 <= at[1] <= 400.0 and 90.0 - elevation <= degrees / 2
        assert shown[row, column] == seen
    assert shown.any()
    assert not shown.all()


def test_a_camera_survives_json() -> None:
    assert FisheyeCamera.of(json.loads(json.dumps(asdict(FLAWED)))) == FLAWED
    plain = asdict(SIMULATED_CAMERA)
    del plain["flaws"]  # as written before there were any
    assert FisheyeCamera.of(plain) == SIMULATED_CAMERA


def test_the_blur_shrinks_with_the_disc() -> None:
    assert FLAWED.resized(280).flaws == CameraFlaws(0.3, 0.4, 9000.0, 15.0)
    assert FLAWED.resized(280).resized(280) == FLAWED.resized(280)


@pytest.mark.parametrize(
    ("flaws", "message"),
    [
        ({"vignetting": 1.5}, "vignetting: 1.5, expected 0..1"),
        ({"blur": -1.0}, "blur: -1.0, expected a finite number >= 0"),
        ({"full_well": np.inf}, "full_well: inf, expected a finite number"),
        ({"read_noise": 5.0}, "read_noise: 5.0 electrons without full_well"),
    ],
)
def test_impossible_flaws_are_refused(flaws, message) -> None:
    with pytest.raises(ValueError, match=message):
        CameraFlaws(**flaws)
