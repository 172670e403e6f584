"""Materials as Blender holds them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from dataset.camera import FisheyeCamera


def test_tiles_have_their_size_in_metres(probed: dict[str, Any]) -> None:
    assert probed["tile"] == pytest.approx([0.3, 0.3])


def test_every_pattern_makes_a_surface(probed: dict[str, Any]) -> None:
    assert probed["patterns_linked"].all()
    assert len(probed["patterns_linked"]) == 11 + 4  # and the motifs of wallpapers


def test_wallpaper_repeats_after_its_size(probed: dict[str, Any]) -> None:
    assert probed["repeats"] == pytest.approx([4.0, 4.0, 1.0])


def test_a_seed_moves_the_pattern(probed: dict[str, Any]) -> None:
    across, along, out = probed["seed_shift"]
    assert 0.0 < across < 50.0 and 0.0 < along < 50.0 and across != along and out == 0.0


def test_a_pane_tints_once_and_mirrors_by_fresnel(probed: dict[str, Any]) -> None:
    straight_up = probed["pane"][14:18, 14:18].mean()
    # 4 % are mirrored off glass of index 1.5; the dark below the pane has no light to mirror.
    assert straight_up == pytest.approx(3.0 * 0.96 * 0.5, rel=0.02)


def test_a_frosted_pane_lets_light_through(probed: dict[str, Any]) -> None:
    straight_up = probed["frosted_pane"][14:18, 14:18].mean()
    assert 0.8 < straight_up < 3.0 * 0.5
    # As well what is only reflected from behind it: or it would look black from a lit room.
    assert probed["transmission_bounces"] == probed["diffuse_bounces"] > 0


def test_smoothed_joints_are_nearer_to_what_many_samples_show(probed: dict[str, Any]) -> None:
    camera = FisheyeCamera().resized(96)
    above = camera.pixel_zenith() < np.radians(35.0)
    many, plain, smooth = (probed[f"joints_{n}"][above] for n in ("many", "plain", "smooth"))
    assert many.std() > 0.02 * many.mean()  # there are joints to be seen
    assert np.abs(smooth - many).std() < 0.6 * np.abs(plain - many).std()
    assert smooth.mean() == pytest.approx(many.mean(), rel=0.02)
