"""The denoiser takes the noise and leaves the edges."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from dataset.errors import RoomsegError
from render.open_image_denoise import Denoiser


@pytest.fixture(scope="module")
def blender() -> Any:
    """What tells where Blender is, without loading it."""
    found = find_spec("bpy")
    assert found is not None and found.origin is not None
    return at(Path(found.origin).parent)


def at(folder: Path) -> Any:
    return SimpleNamespace(utils=SimpleNamespace(resource_path=lambda _: str(folder / "5.0")))


@pytest.fixture(scope="module")
def step() -> np.ndarray:
    """Bright left, dark right."""
    picture = np.full((64, 96, 3), 0.1, dtype=np.float32)
    picture[:, :48] = 30.0
    return picture


@pytest.fixture(scope="module")
def grainy(step: np.ndarray) -> np.ndarray:
    grain = np.random.default_rng(0).gamma(4.0, 0.25, step.shape[:2])
    return (step * grain[..., None]).astype(np.float32)


@pytest.mark.parametrize("quality", ["fast", "high"])
def test_grain_goes_and_the_edge_stays(blender, step, grainy, quality) -> None:
    made = Denoiser(blender, 1)(grainy, quality=quality)
    error = np.abs(made / step - 1.0)
    assert np.abs(grainy / step - 1.0).mean() > 0.3
    assert error.mean() < 0.1
    assert made[:, 47].min() > 10.0 * made[:, 49].max()


def test_guides_tell_surfaces_of_one_brightness_apart(blender) -> None:
    """Two greys that differ less than the grain, side by side in different charts."""
    even = np.full((64, 96, 3), 1.0, dtype=np.float32)
    even[:, 48:] = 1.3
    grain = np.random.default_rng(1).gamma(4.0, 0.25, even.shape[:2])
    picture = (even * grain[..., None]).astype(np.float32)
    albedo = np.full_like(even, 0.2)
    albedo[:, 48:] = 0.8
    normal = np.zeros_like(even)
    normal[..., 2] = 1.0
    made = Denoiser(blender, 1)(picture, {"albedo": albedo, "normal": normal})
    assert made[:, 49:52].mean() - made[:, 44:47].mean() > 0.15


def test_the_same_whatever_the_threads(blender, grainy) -> None:
    one, two = (Denoiser(blender, threads)(grainy) for threads in (1, 2))
    np.testing.assert_array_equal(one, two)


def test_a_missing_library_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(RoomsegError, match="OpenImageDenoise: not found in") as caught:
        Denoiser(at(tmp_path))
    assert "\n" not in str(caught.value)
