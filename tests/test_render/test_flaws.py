"""Vignetting, blur and noise against what they are by definition."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dataset.camera import CameraFlaws, FisheyeCamera
from render.exposure import expose, unfolded_mean
from render.flaws import sensed, through_lens

CAMERA = FisheyeCamera().resized(96)


def flawed(**flaws: float) -> FisheyeCamera:
    return replace(CAMERA, flaws=CameraFlaws(**flaws))


def test_a_camera_without_flaws_changes_nothing() -> None:
    light = np.random.default_rng(0).random(CAMERA.image_size).astype(np.float32)
    assert through_lens(light, CAMERA) is light


def test_the_loss_grows_with_the_square_of_the_zenith() -> None:
    seen = through_lens(np.ones(CAMERA.image_size, np.float32), flawed(vignetting=0.4))
    # On the middle row, pixel centres half a pixel off the middle.
    for column in (48, 60, 84, 95):
        share = np.hypot(column + 0.5 - 48.0, 0.5) / 48.0
        assert seen[48, column] == pytest.approx(1.0 - 0.4 * share**2, rel=1e-5)
    assert seen[0, 0] == pytest.approx(0.6)  # outside of the disc


def test_blur_spreads_a_point_as_a_gaussian() -> None:
    light = np.zeros(CAMERA.image_size, np.float32)
    light[40, 50] = 1000.0
    seen = through_lens(light, flawed(blur=1.2)).astype(float)
    rows, columns = np.indices(light.shape)
    assert seen.sum() == pytest.approx(1000.0, rel=1e-4)
    assert (seen * rows).sum() / seen.sum() == pytest.approx(40.0, abs=1e-3)
    assert (seen * (columns - 50) ** 2).sum() / seen.sum() == pytest.approx(1.44, rel=0.03)


@pytest.mark.parametrize("level", [2.0, 20.0, 128.0, 240.0])
def test_photon_transfer(level: float) -> None:
    """Variance over mean, as EMVA 1288 measures a camera: shot, read and rounding noise."""
    flaws = CameraFlaws(full_well=5000.0, read_noise=20.0)
    exposed = np.full((400, 400), level, np.float32)
    image = sensed(exposed, flaws, np.random.default_rng(1)).astype(float)
    unit = 255.0 / 5000.0
    variance = level * unit + (20.0 * unit) ** 2 + 1.0 / 12.0
    if level > 10.0:  # in the dark, negative values are cut off
        assert image.var() == pytest.approx(variance, rel=0.03)
    assert image.mean() == pytest.approx(level, abs=0.15)


def test_a_full_pixel_stays_full() -> None:
    flaws = CameraFlaws(full_well=5000.0)
    exposed = np.array([[400.0, 1e5, 1e30, 0.0]], np.float32)
    assert sensed(exposed, flaws, np.random.default_rng(0)).tolist() == [[255, 255, 255, 0]]


def test_the_gain_makes_up_for_vignetting_and_does_not_see_the_noise() -> None:
    light = np.random.default_rng(2).lognormal(0.0, 1.0, CAMERA.image_size).astype(np.float32)
    camera = flawed(vignetting=0.4, full_well=9000.0, read_noise=20.0)
    image, gain = expose(light, camera, np.random.default_rng(0))
    assert gain > expose(light, CAMERA)[1]
    other, same = expose(light, camera, np.random.default_rng(1))
    assert same == gain
    assert (image != other).mean() > 0.5
    assert unfolded_mean(image.astype(np.float32), camera) == pytest.approx(127.5, abs=1.5)


def test_bright_and_dark_rooms_are_equally_noisy() -> None:
    """The control sets the time of exposure: the same grey level is as many electrons."""
    camera = flawed(full_well=2000.0)
    light = np.ones(CAMERA.image_size, np.float32)
    dark, bright = (
        expose(light * unit, camera, np.random.default_rng(3), tolerance=1e-6)[0]
        for unit in (2.0**-10, 2.0**10)
    )
    np.testing.assert_array_equal(dark, bright)
    assert bright.std() == pytest.approx(np.sqrt(127.5 * 255.0 / 2000.0), rel=0.05)


def test_noise_needs_a_generator() -> None:
    with pytest.raises(ValueError, match="rng: missing"):
        expose(np.ones(CAMERA.image_size, np.float32), flawed(full_well=100.0))
