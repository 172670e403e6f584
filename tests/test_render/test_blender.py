"""The fisheye of Blender is the one of `dataset.camera`, pixel by pixel."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from probe import CAMERAS, LEANING, MARKER_CAMERAS, POSE
from scipy.spatial.transform import Rotation

from dataset.camera import FisheyeCamera
from render.blender import render_window, surface_coordinates
from roomseg.panorama import PanoramaParameters, Unfolding


def expected_directions(camera: FisheyeCamera) -> tuple[np.ndarray, np.ndarray]:
    """World directions (h, w, 3) of the pixel centres at POSE, and their zenith angles."""
    rows, columns = np.indices(camera.image_size)
    azimuth, zenith = camera.unproject(np.stack([rows + 0.5, columns + 0.5], axis=-1))
    bearing = azimuth + POSE[2]
    sine = np.sin(zenith)
    return np.stack([sine * np.cos(bearing), sine * np.sin(bearing), np.cos(zenith)], -1), zenith


@pytest.mark.parametrize("name", CAMERAS)
def test_every_pixel_sees_the_direction_that_the_camera_model_says(
    probed: dict[str, Any], name: str
) -> None:
    camera = CAMERAS[name]
    seen = 2.0 * probed[f"directions_{name}"].astype(float) - 1.0
    wanted, zenith = expected_directions(camera)
    inside = zenith < 0.5 * camera.field_of_view - 1.5 / camera.pixels_per_radian
    seen /= np.linalg.norm(seen, axis=-1, keepdims=True)
    angle = np.arccos(np.clip((seen * wanted).sum(axis=-1), -1.0, 1.0))[inside]
    assert angle.max() * camera.pixels_per_radian < 0.5
    assert np.sqrt((angle**2).mean()) * camera.pixels_per_radian < 0.1


def test_a_leaning_robot_sees_leaning_directions(probed: dict[str, Any]) -> None:
    camera = CAMERAS["small"]
    level, _ = expected_directions(camera)
    heading, roll, pitch = LEANING[2:]
    # About the robot's own axes: to the left first, then ahead.
    about = Rotation.from_euler("Z", heading)
    lean = about * Rotation.from_euler("Y", pitch) * Rotation.from_euler("X", roll) * about.inv()
    wanted = lean.apply(level.reshape(-1, 3)).reshape(level.shape)
    seen = 2.0 * probed["directions_leaning"].astype(float) - 1.0
    seen /= np.linalg.norm(seen, axis=-1, keepdims=True)
    inside = camera.pixel_zenith() < np.radians(85.0)
    angle = np.arccos(np.clip((seen * wanted).sum(axis=-1), -1.0, 1.0))[inside]
    assert angle.max() * camera.pixels_per_radian < 0.5
    # Left side up: what was straight above is now to the right.
    up = wanted[camera.image_size[0] // 2, camera.image_size[1] // 2]
    right = np.array([np.sin(heading), -np.cos(heading), 0.0])
    assert up @ right > 0.03


@pytest.mark.parametrize("name", CAMERAS)
def test_outside_the_disc_is_exactly_black(probed: dict[str, Any], name: str) -> None:
    camera = CAMERAS[name]
    image = probed[f"directions_{name}"]
    assert image.shape == (*camera.image_size, 3)
    outside = camera.pixel_zenith() > 0.5 * camera.field_of_view
    assert not image[outside].any()
    assert image[~outside].any(axis=-1).all()


def glow(image: np.ndarray, row: float, column: float) -> np.ndarray:
    """What glows within 8 px of a point, as an image."""
    rows, columns = np.indices(image.shape) + 0.5
    return np.where(np.hypot(rows - row, columns - column) < 8.0, image, 0.0)


@pytest.mark.parametrize("name", MARKER_CAMERAS)
def test_markers_have_the_radius_of_their_zenith_angle(probed: dict[str, Any], name: str) -> None:
    camera, _ = MARKER_CAMERAS[name]
    middle = np.array(camera.disc_centre)
    # By hand, not by `FisheyeCamera.project`: diameter over field of view.
    scale = {"simulated": 464 / 190, "real": 450 / 185, "wide": 560 / 220}[name]
    off = []
    for azimuth, zenith in probed[f"marker_angles_{name}"]:
        wanted = np.degrees(zenith) * scale * np.array([np.sin(azimuth), np.cos(azimuth)])
        spot = glow(probed[f"markers_{name}"], *(middle + wanted))
        rows, columns = np.indices(spot.shape) + 0.5
        found = np.array([(spot * rows).sum(), (spot * columns).sum()]) / spot.sum() - middle
        off.append((np.hypot(*found) - np.hypot(*wanted), np.hypot(*(found - wanted))))
    radial, both = np.abs(off).max(axis=0)
    assert radial < 0.1
    assert both < 0.15


@pytest.mark.parametrize("name", MARKER_CAMERAS)
def test_unfolding_inverts_rendering(probed: dict[str, Any], name: str) -> None:
    """A lamp of known azimuth and elevation lies there in the panorama, to half a pixel."""
    camera, _ = MARKER_CAMERAS[name]
    unfold = Unfolding.of(camera, PanoramaParameters())
    for azimuth, zenith in probed[f"marker_angles_{name}"]:
        elevation = 90.0 - np.degrees(zenith)
        if not 8.0 < elevation < 67.0:
            continue
        row, column = camera.project(azimuth, zenith)
        spot = glow(probed[f"markers_{name}"], float(row), float(column))
        panorama = unfold(np.uint8(200.0 * spot / spot.max())).astype(float)
        wanted = (azimuth % (2 * np.pi)) / (2 * np.pi) * 288
        # Turned to the middle, so that it is not cut in two by the seam.
        turn = 144 - round(wanted)
        rows, columns = np.indices(panorama.shape) + 0.5
        panorama = np.roll(panorama, turn, axis=1)
        assert (panorama * columns).sum() / panorama.sum() - turn == pytest.approx(wanted, abs=0.5)
        found = (panorama * rows).sum() / panorama.sum()
        assert found == pytest.approx((75.0 - elevation) / 75.0 * 48, abs=0.5)


def test_left_of_the_robot_is_at_the_bottom(probed: dict[str, Any]) -> None:
    # The sixth marker is at azimuth +90 degrees.
    image = probed["markers_simulated"]
    radius = 5 * 93.0 / 19 * 464 / 190
    assert image[round(232 + radius), 232] > 0.0
    assert image[round(232 - radius), 232] == 0.0


def test_a_window_at_plus_y_is_at_the_bottom_and_turns_with_the_robot(
    probed: dict[str, Any],
) -> None:
    for name, wanted in (("room", (1, 0)), ("room_turned", (0, 1))):
        image = probed[name]
        rows, columns = np.indices(image.shape) + 0.5 - image.shape[0] / 2
        bright = image > 0.8 * image.max()
        middle = np.array([rows[bright].mean(), columns[bright].mean()])
        middle /= np.linalg.norm(middle)
        assert middle @ wanted > 0.99


def test_a_lamp_ahead_lights_the_room(probed: dict[str, Any]) -> None:
    image = probed["lamp"]
    row, column = np.unravel_index(int(image.argmax()), image.shape)
    assert abs(row - 31.5) <= 2.0
    assert 37 <= column <= 42  # 1 m ahead, 2.3 m up: 22.6 degrees, 7.6 px
    assert np.median(image[FisheyeCamera().resized(64).pixel_zenith() < 1.5]) > 0.1


def test_camera_state(probed: dict[str, Any]) -> None:
    assert probed["fov"] == pytest.approx(np.radians(190.0))


def test_surface_coordinates_are_metres_along_the_surface() -> None:
    vertices = np.array([[0, 0, 0], [3, 4, 0], [3, 4, 2], [0, 5, 0]], dtype=float)
    triangles = np.array([[0, 1, 2], [0, 1, 3]], dtype=np.int32)
    wall, floor = surface_coordinates(vertices, triangles)
    # The wall from (0, 0) to (3, 4) is 5 m long and 2 m high.
    assert abs(wall[1, 0] - wall[0, 0]) == pytest.approx(5.0)
    assert wall[2] == pytest.approx([wall[1, 0], 2.0])
    assert floor == pytest.approx(vertices[[0, 1, 3], :2])


@pytest.mark.parametrize(
    ("diameter", "centre", "side", "origin"),
    [
        (464.0, (232.0, 232.0), 464, (0, 0)),
        (450.0, (256.0, 320.0), 450, (31, 95)),
        (450.0, (250.5, 320.5), 451, (25, 95)),
        (449.3, (101.0, 320.0), 450, (-124, 95)),
    ],
)
def test_render_window_by_hand(
    diameter: float, centre: tuple[float, float], side: int, origin: tuple[int, int]
) -> None:
    camera = FisheyeCamera(disc_diameter=diameter, disc_centre=centre, image_size=(512, 640))
    assert render_window(camera) == ((side, side), origin)


@pytest.mark.parametrize("centre", [(232.25, 232.0), (232.0, 232.5)])
def test_a_disc_centre_off_the_half_pixel_grid_is_refused(centre: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="disc_centre"):
        render_window(FisheyeCamera(disc_centre=centre))
