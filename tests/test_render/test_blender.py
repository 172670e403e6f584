"""The fisheye of Blender is the one of `dataset.camera`, pixel by pixel."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from probe import CAMERAS, LEANING, POSE
from scipy.spatial.transform import Rotation

from dataset.camera import FisheyeCamera
from render.blender import render_window, surface_coordinates


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


def test_markers_appear_where_they_are_projected(probed: dict[str, Any]) -> None:
    camera = CAMERAS["simulated"]
    image = probed["markers"]
    rows, columns = np.indices(image.shape) + 0.5
    centres = camera.project(probed["marker_azimuth"], probed["marker_zenith"])
    for row, column in centres:
        weight = np.where(np.hypot(rows - row, columns - column) < 8.0, image, 0.0)
        assert weight.sum() > 0.0
        found = np.array([(weight * rows).sum(), (weight * columns).sum()]) / weight.sum()
        assert np.hypot(*(found - (row, column))) < 0.5


def test_left_of_the_robot_is_at_the_bottom(probed: dict[str, Any]) -> None:
    # The third marker is at azimuth +90 degrees, 25 degrees from the axis.
    image = probed["markers"]
    radius = 25.0 / 95.0 * 232.0
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
