"""The exposure control of §3.1 against hand-computed cases."""

from __future__ import annotations

import numpy as np
import pytest

from dataset.camera import FisheyeCamera
from render.exposure import expose, unfolded_mean

CAMERA = FisheyeCamera().resized(96)


def sectors(low: float, high: float, share: float) -> np.ndarray:
    """``high`` in that share of the azimuths, ``low`` elsewhere."""
    rows, columns = np.indices(CAMERA.image_size) + 0.5
    azimuth, _ = CAMERA.unproject(np.stack([rows, columns], axis=-1))
    return np.where(azimuth % (2 * np.pi) < share * 2 * np.pi, high, low).astype(np.float32)


def oracle_mean(image: np.ndarray, camera: FisheyeCamera) -> float:
    """Mean filter, unfolding and mean, with loops instead of OpenCV."""
    half = camera.averaging_mask() // 2
    total, count = 0.0, 0
    for row in range(48):
        for column in range(288):
            azimuth = (column + 0.5) / 288 * 2 * np.pi
            elevation = np.radians(75.0) * (1 - (row + 0.5) / 48)
            y, x = camera.project(np.array(azimuth), np.array(np.pi / 2 - elevation)) - 0.5
            r, c = int(np.floor(y)), int(np.floor(x))
            for dr, wr in ((0, 1 - (y - r)), (1, y - r)):
                for dc, wc in ((0, 1 - (x - c)), (1, x - c)):
                    patch = image[
                        r + dr - half : r + dr + half + 1, c + dc - half : c + dc + half + 1
                    ]
                    total += wr * wc * patch.mean()
            count += 1
    return total / count


def test_unfolded_mean_against_loops() -> None:
    image = np.random.default_rng(1).random(CAMERA.image_size).astype(np.float32) ** 4
    image *= np.linspace(0.1, 3.0, 96, dtype=np.float32)
    # cv2.remap rounds coordinates to 1/32 px.
    assert unfolded_mean(image, CAMERA) == pytest.approx(oracle_mean(image, CAMERA), rel=2e-3)


def test_the_mask_of_7_px_scales_with_the_disc() -> None:
    assert FisheyeCamera().averaging_mask() == 7
    assert FisheyeCamera(disc_diameter=450.0).averaging_mask() == 7
    assert FisheyeCamera().resized(232).averaging_mask() == 3
    assert FisheyeCamera().resized(40).averaging_mask() == 1
    # 464 px for 95° show everything twice as large.
    assert FisheyeCamera(field_of_view=np.radians(95.0)).averaging_mask() == 13


@pytest.mark.parametrize(
    "camera",
    [
        FisheyeCamera(np.radians(160.0), 96.0, (96, 96), (48.0, 48.0)),
        FisheyeCamera(np.radians(190.0), 96.0, (60, 96), (25.0, 50.0)),
    ],
    ids=["no horizon", "cropped"],
)
def test_what_is_not_seen_does_not_count(camera: FisheyeCamera) -> None:
    light = np.where(camera.pixel_zenith() <= 0.5 * camera.field_of_view, 0.3, 0.0)
    _, gain = expose(light.astype(np.float32), camera)
    # Only the rim is darkened by the mask of the mean.
    assert gain == pytest.approx(127.5 / 0.3, rel=0.03)


def test_a_camera_that_sees_nothing_of_the_panorama_keeps_gain_one() -> None:
    narrow = FisheyeCamera(np.radians(20.0), 32.0, (32, 32), (16.0, 16.0))
    assert expose(np.ones((32, 32), dtype=np.float32), narrow)[1] == 1.0


def test_an_even_image_becomes_half_grey_in_one_step() -> None:
    image, gain = expose(np.full(CAMERA.image_size, 0.3, dtype=np.float32), CAMERA)
    assert gain == pytest.approx(127.5 / 0.3, rel=1e-5)
    assert set(np.unique(image)) <= {127, 128}


def test_unsaturated_gain_is_the_ratio_of_means() -> None:
    light = sectors(1.0, 1.5, 0.5)
    _, gain = expose(light, CAMERA)
    assert gain == pytest.approx(127.5 / 1.25, rel=5e-3)


def test_saturated_sectors_by_hand() -> None:
    # A quarter shines and saturates: 255/4 + 3/4 x = 127.5 gives x = 85 in the rest.
    image, gain = expose(sectors(1.0, 50.0, 0.25), CAMERA, tolerance=0.05)
    assert gain == pytest.approx(85.0, rel=0.01)
    assert set(np.unique(image)) == {85, 255}


def test_a_fixed_point_is_a_mean_of_half_the_range() -> None:
    light = np.random.default_rng(2).lognormal(0.0, 2.0, CAMERA.image_size).astype(np.float32)
    image, gain = expose(light, CAMERA)
    assert unfolded_mean(np.minimum(gain * light, 255.0), CAMERA) == pytest.approx(127.5, abs=0.5)
    np.testing.assert_array_equal(image, np.rint(np.minimum(np.float32(gain) * light, 255.0)))


def test_gain_undoes_the_unit_of_light() -> None:
    light = np.random.default_rng(3).lognormal(0.0, 1.0, CAMERA.image_size).astype(np.float32)
    first, gain = expose(light, CAMERA, tolerance=1e-3)
    second, scaled = expose(1024.0 * light, CAMERA, tolerance=1e-3)
    assert gain == pytest.approx(1024.0 * scaled, rel=1e-4)
    assert np.abs(first.astype(int) - second).max() <= 1


def test_a_black_image_keeps_gain_one() -> None:
    image, gain = expose(np.zeros(CAMERA.image_size, dtype=np.float32), CAMERA)
    assert gain == 1.0
    assert not image.any()


def test_mostly_black_images_end_with_all_light_saturated() -> None:
    # Only a tenth of the panorama shines: no gain can reach half of 255.
    image, gain = expose(sectors(0.0, 1e-3, 0.1), CAMERA)
    assert np.isfinite(gain)
    assert set(np.unique(image)) == {0, 255}


def test_iterations_are_bounded() -> None:
    light = sectors(1.0, 50.0, 0.49)
    _, gain = expose(light, CAMERA, max_iterations=1)
    assert gain == pytest.approx(0.5 * 255.0 / unfolded_mean(light, CAMERA))


def test_light_that_saturates_everything_at_first() -> None:
    _, gain = expose(np.full(CAMERA.image_size, 1e6, dtype=np.float32), CAMERA)
    assert gain == pytest.approx(127.5e-6, rel=5e-3)


def test_negative_light_counts_as_none() -> None:
    light = np.full(CAMERA.image_size, 0.5, dtype=np.float32)
    light[48, 48] = -1.0
    image, _ = expose(light, CAMERA)
    assert image[48, 48] == 0


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_finite_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match="not finite"):
        expose(np.full(CAMERA.image_size, value, dtype=np.float32), CAMERA)


def test_another_shape_is_refused() -> None:
    with pytest.raises(ValueError, match=r"shape \(4, 4\)"):
        expose(np.zeros((4, 4), dtype=np.float32), CAMERA)
