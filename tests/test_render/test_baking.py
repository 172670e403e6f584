"""Baked light beside path tracing of the same room."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from probe import boxed_room

from dataset.camera import FisheyeCamera
from render.baking import lay_out_apartment
from render.presets import Bake
from scenes.mesh import apartment_mesh

INSIDE = FisheyeCamera().resized(64).pixel_zenith() < np.radians(90.0)


@pytest.mark.parametrize("source", ["interior", "exterior"])
def test_images_from_baked_light_are_those_of_path_tracing(
    probed: dict[str, Any], source: str
) -> None:
    traced, baked = probed[f"traced_{source}"][INSIDE], probed[f"baked_{source}"][INSIDE]
    matte = traced < np.quantile(traced, 0.95)  # without lamps and windows, and what they edge
    assert baked[matte].mean() == pytest.approx(traced[matte].mean(), rel=0.03)
    assert np.median(np.abs(baked / traced - 1.0)) < 0.05


@pytest.mark.parametrize("source", ["interior", "exterior"])
def test_images_come_through_files_where_memory_cannot_be_read(
    probed: dict[str, Any], source: str
) -> None:
    memory, file = probed[f"baked_{source}"][INSIDE], probed[f"baked_file_{source}"][INSIDE]
    assert np.median(np.abs(file / memory - 1.0)) < 0.02


def test_a_bake_depends_on_no_number_of_threads(probed: dict[str, Any]) -> None:
    np.testing.assert_array_equal(probed["light_exterior"], probed["light_again"])


def test_baked_light_is_finite_and_nowhere_negative(probed: dict[str, Any]) -> None:
    for source in ("interior", "exterior"):
        light = probed[f"light_{source}"]
        assert np.isfinite(light).all()
        assert light.min() >= -1e-6
        assert light.max() > 0.0


def test_texels_are_fine_within_windows_and_not_on_the_wall_about_them() -> None:
    room = boxed_room((0.0, 2.1))
    plain = lay_out_apartment(room, Bake(opening=0.03))
    fine = lay_out_apartment(room, Bake(opening=0.01))
    mesh = apartment_mesh(room)
    corners = mesh.vertices[mesh.triangles]
    middle = corners.mean(axis=1)
    level = np.ptp(corners[..., 2], axis=1) < 1e-6
    reveal = (np.abs(middle[:, 0]) < 0.7) & (np.abs(middle[:, 1] - 2.1) < 0.09) & level
    reveal &= (middle[:, 2] > 0.5) & (middle[:, 2] < 2.3)
    wall = np.abs(corners[..., 1] - 2.0).max(axis=1) < 1e-6
    assert reveal.sum() >= 4 and wall.sum() >= 4
    size = [texels_per_metre(atlas.uv, corners) for atlas in (plain, fine)]
    assert np.median(size[0][reveal]) < 40.0
    assert size[1][reveal].min() > 90.0
    np.testing.assert_allclose(size[1][wall], size[0][wall], rtol=0.05)


def texels_per_metre(uv: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Square root of texels per square metre of triangles."""
    one, two = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    texels = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
    sides = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.sqrt(texels / np.linalg.norm(np.cross(*sides), axis=1))
