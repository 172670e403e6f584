"""Panoramas and their distances against loops over all rotations."""

from __future__ import annotations

import numpy as np
import pytest

from dataset.camera import SIMULATED_CAMERA, FisheyeCamera
from roomseg.panorama import (
    PanoramaParameters,
    Unfolding,
    compass_distances,
    signature_distances,
    signatures,
)

PAPER = PanoramaParameters()
UNFOLD = Unfolding.of(SIMULATED_CAMERA, PAPER)


def random_panoramas(count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (count, 48, 288), dtype=np.uint8)


def scene_image(heading: float, seed: int = 0, camera: FisheyeCamera = SIMULATED_CAMERA):
    """A smooth scene of azimuth and elevation, seen with this heading."""
    rng = np.random.default_rng(seed)
    rows, columns = np.indices(camera.image_size) + 0.5
    azimuth, zenith = camera.unproject(np.stack([rows, columns], axis=-1))
    grey = np.full(camera.image_size, 128.0)
    for order in range(1, 6):
        amplitude, phase, tilt = rng.uniform(5, 20), rng.uniform(0, 6), rng.uniform(-3, 3)
        grey += amplitude * np.sin(order * (azimuth + heading) + tilt * zenith + phase)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def test_compass_distance_is_the_minimum_over_all_rotations() -> None:
    panoramas = random_panoramas(3)
    edges = np.array([[0, 1], [1, 2], [0, 0]])
    for distance, (k, m) in zip(compass_distances(panoramas, edges), edges, strict=True):
        differences = [
            np.linalg.norm(panoramas[k].astype(float) - np.roll(panoramas[m], -delta, axis=1))
            for delta in range(288)
        ]
        assert distance == pytest.approx(min(differences), rel=1e-12)


def test_batches_do_not_matter() -> None:
    panoramas = random_panoramas(9)
    edges = np.stack(np.triu_indices(9, 1), axis=1)
    whole = compass_distances(panoramas, edges, batch=1000)
    assert (compass_distances(panoramas, edges, batch=5) == whole).all()


@pytest.mark.parametrize("turn", [0, 1, 100, 287])
def test_rolled_panorama_is_at_distance_zero(turn: int) -> None:
    panorama = random_panoramas(1)[0]
    pair = np.stack([panorama, np.roll(panorama, turn, axis=1)])
    edge = np.array([[0, 1]])
    assert compass_distances(pair, edge) == 0.0
    assert signature_distances(pair, edge) == pytest.approx(0.0, abs=1e-6)


def test_signature_by_definition() -> None:
    """Eight segments of six rows, averaged, twelve coefficients summed one by one."""
    panoramas = random_panoramas(2)
    angle = 2 * np.pi * np.arange(288) / 288
    expected = []
    for panorama in panoramas.astype(float):
        for segment in range(8):
            row = panorama[6 * segment : 6 * segment + 6].mean(axis=0)
            for order in range(12):
                expected.append(
                    np.hypot(
                        (row * np.cos(order * angle)).sum(), (row * np.sin(order * angle)).sum()
                    )
                )
    expected = np.reshape(expected, (2, 96))
    assert signatures(panoramas) == pytest.approx(expected)
    distance = signature_distances(panoramas, np.array([[0, 1]]))
    assert distance == pytest.approx(np.linalg.norm(expected[0] - expected[1]))


def test_shape_and_equalisation() -> None:
    panorama = UNFOLD(scene_image(0.0))
    assert panorama.shape == (48, 288)
    assert panorama.dtype == np.uint8
    # Equalised: each quarter of the grey levels holds about a quarter of the pixels.
    quarters = np.histogram(panorama, bins=[0, 64, 128, 192, 256])[0] / panorama.size
    assert quarters == pytest.approx(np.full(4, 0.25), abs=0.03)


def test_brightness_does_not_matter() -> None:
    image = scene_image(0.0)
    pair = np.stack([UNFOLD(image), UNFOLD(image // 2 + 20)])
    other = np.stack([UNFOLD(image), UNFOLD(scene_image(0.0, seed=1))])
    edge = np.array([[0, 1]])
    assert compass_distances(pair, edge) < 0.1 * compass_distances(other, edge)


@pytest.mark.parametrize("heading", [np.pi / 2, 1.0, -2.5])
def test_turned_robot_sees_the_same(heading: float) -> None:
    images = [scene_image(0.0), scene_image(heading), scene_image(0.0, seed=1)]
    panoramas = np.stack([UNFOLD(image) for image in images])
    for distances in (compass_distances, signature_distances):
        turned, elsewhere = distances(panoramas, np.array([[0, 1], [0, 2]]))
        assert turned < 0.1 * elsewhere


def test_horizon_is_the_bottom_row() -> None:
    zenith = np.degrees(SIMULATED_CAMERA.pixel_zenith())
    image = np.clip(np.rint(2 * zenith), 0, 255).astype(np.uint8)  # darkest overhead
    panorama = UNFOLD(image)
    assert (np.diff(panorama.astype(int).mean(axis=1)) > 0).all()


@pytest.mark.parametrize(("disc", "mask"), [(464, 7), (232, 3), (64, 1), (928, 13)])
def test_mask_scales_with_the_disc(disc: int, mask: int) -> None:
    assert Unfolding.of(SIMULATED_CAMERA.resized(disc), PAPER).mask == mask


def test_preview_disc_gives_a_similar_panorama() -> None:
    small = SIMULATED_CAMERA.resized(232)
    pair = np.stack(
        [UNFOLD(scene_image(0.0)), Unfolding.of(small, PAPER)(scene_image(0.0, camera=small))]
    )
    other = np.stack([pair[0], UNFOLD(scene_image(0.0, seed=1))])
    edge = np.array([[0, 1]])
    assert compass_distances(pair, edge) < 0.1 * compass_distances(other, edge)


@pytest.mark.parametrize(
    ("degrees", "diameter", "size", "centre"),
    [
        (185.0, 450.0, (512, 640), (256.0, 320.0)),
        (220.0, 400.0, (512, 640), (205.5, 371.5)),
        (200.0, 600.0, (512, 640), (250.0, 330.0)),
    ],
    ids=["real", "off the middle", "larger than the image"],
)
def test_a_lamp_unfolds_to_its_azimuth_and_elevation(degrees, diameter, size, centre) -> None:
    """The lamp is drawn with the projection written out, for every camera on its own."""
    camera = FisheyeCamera(np.radians(degrees), diameter, size, centre)
    unfold = Unfolding.of(camera, PAPER)
    rows, columns = np.indices(size) + 0.5
    for azimuth, elevation in ((20.0, 60.0), (170.0, 35.0), (345.0, 15.0)):
        radius = (90.0 - elevation) * diameter / degrees
        row = centre[0] + radius * np.sin(np.radians(azimuth))
        column = centre[1] + radius * np.cos(np.radians(azimuth))
        lamp = np.uint8(255 * (np.hypot(rows - row, columns - column) < 5.0))
        panorama = unfold(lamp).astype(float)
        down, across = np.indices(panorama.shape) + 0.5
        # The mean direction, as azimuths go around.
        angle = np.angle((panorama * np.exp(2j * np.pi * across / 288)).sum()) % (2 * np.pi)
        assert angle / (2 * np.pi) * 288 == pytest.approx(azimuth * 288 / 360, abs=0.5)
        wanted = (75.0 - elevation) / 75.0 * 48
        assert (panorama * down).sum() / panorama.sum() == pytest.approx(wanted, abs=0.5)
