"""Settings, capture and repeatability of Cycles."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from dataset.camera import FisheyeCamera
from dataset.errors import RoomsegError
from render.cycles import FrameSource, luminance


def test_same_pose_and_index_give_the_same_pixels(probed: dict[str, Any]) -> None:
    np.testing.assert_array_equal(probed["room"], probed["room_again"])


def test_another_index_is_sampled_anew(probed: dict[str, Any]) -> None:
    assert (probed["room"] != probed["room_other_index"]).mean() > 0.5


def test_memory_and_file_hold_the_same_pixels(probed: dict[str, Any]) -> None:
    np.testing.assert_array_equal(probed["room"], probed["room_through_file"])


def test_radiance_in_a_glowing_box_is_the_radiance_asked_for(probed: dict[str, Any]) -> None:
    image = probed["furnace"]
    inside = FisheyeCamera().resized(32).pixel_zenith() < np.radians(85.0)
    # A black body's colour has unit luminance only roughly.
    assert image[inside] == pytest.approx(3.0, rel=0.05)


def test_settings_reach_blender(probed: dict[str, Any]) -> None:
    assert probed["samples"] == 3
    assert probed["diffuse_bounces"] == 2
    assert probed["threads"] == 1


def test_the_device_is_said(probed: dict[str, Any]) -> None:
    assert (str(probed["device"]) == "CPU") == (str(probed["cycles_device"]) == "CPU")


def test_luminance_by_hand() -> None:
    colour = np.array([[[1.0, 0.0, 0.0, 9.0], [0.5, 1.0, 2.0, 9.0]]], dtype=np.float32)
    assert luminance(colour) == pytest.approx(np.array([[0.2126, 0.1063 + 0.7152 + 0.1444]]))


class _Engine:
    def render(self, depsgraph: object) -> None:
        raise AssertionError("not reached: the render is cut short")


class CyclesRender(_Engine):
    pass


def test_a_render_that_ends_without_a_frame_is_an_error() -> None:
    """As Blender does after a SIGINT: FINISHED, and no pixels."""
    bpy: Any = SimpleNamespace(
        types=SimpleNamespace(RenderEngine=_Engine),
        ops=SimpleNamespace(render=SimpleNamespace(render=lambda: {"FINISHED"})),
    )
    scene: Any = SimpleNamespace(
        camera=SimpleNamespace(), cycles=SimpleNamespace(), update_tag=lambda: None
    )
    source = FrameSource(bpy, scene, FisheyeCamera().resized(16))
    with pytest.raises(RoomsegError, match="without a frame"):
        source.radiance(np.zeros(3))
