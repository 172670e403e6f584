"""Presets and the camera they render."""

from __future__ import annotations

import json
from dataclasses import asdict

import pytest

from dataset.camera import FisheyeCamera
from dataset.errors import RoomsegError
from render.presets import PRESETS, Bake, Preset, preset_from, preset_named


def test_full_size_presets_keep_the_maps_camera() -> None:
    camera = FisheyeCamera(3.2, 450.0, (512, 640), (256.0, 320.0), 0.08)
    assert PRESETS["reference"].camera(camera) is camera
    assert PRESETS["draft"].camera(camera) is camera


def test_preview_shrinks_the_disc_and_keeps_lens_and_height() -> None:
    camera = PRESETS["preview"].camera(FisheyeCamera(3.2, 450.0, (512, 640), (256.0, 320.0), 0.08))
    assert camera.image_size == (camera.disc_diameter, camera.disc_diameter)
    assert camera.disc_diameter < 300
    assert (camera.field_of_view, camera.height) == (3.2, 0.08)


def test_names() -> None:
    assert all(preset_named(name).name == name for name in PRESETS)
    with pytest.raises(
        RoomsegError, match="expected one of reference, fast, draft, quick, preview"
    ):
        preset_named("quickest")


@pytest.mark.parametrize("preset", PRESETS.values(), ids=lambda preset: preset.name)
def test_presets_survive_json(preset: Preset) -> None:
    assert preset_from(json.loads(json.dumps(asdict(preset)))) == preset


def test_a_scaled_bake_has_larger_texels_and_the_same_samples() -> None:
    bake = Bake(samples=7, overhead=0.01, upright=0.02, floor=0.03, opening=0.04)
    assert bake.scaled(2.0) == Bake(7, 0.02, 0.04, 0.06, 0.08)
