"""The equidistant fisheye model against values worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dataset.camera import SIMULATED_CAMERA, FisheyeCamera

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
    ],
)
def test_impossible_cameras_are_refused(field):
    with pytest.raises(ValueError, match=next(iter(field))):
        FisheyeCamera(**field)
