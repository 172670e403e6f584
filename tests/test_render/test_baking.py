"""Baked light beside path tracing of the same room."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from dataset.camera import FisheyeCamera

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
