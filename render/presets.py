"""How much light is traced for an image: from the reference to a quick preview.

Raw path tracing is useless for the lintel search, whose Scharr operator takes
noise for edges (a thousand times at 16 samples); every preset therefore denoises.
The figures behind the choice are in ``docs/render.md``.
"""

from __future__ import annotations

from dataclasses import dataclass

from dataset.camera import FisheyeCamera
from dataset.errors import RoomsegError

__all__ = ["PRESETS", "Preset", "preset_named"]


@dataclass(frozen=True)
class Preset:
    """Settings of the path tracer.

    Attributes
    ----------
    name : str
    samples : int
        Paths per pixel.
    denoise : bool
        Run OpenImageDenoise, guided by albedo and normals.
    disc_diameter : int or None
        Diameter of the image disc, px; None keeps the map's own camera.
    max_bounces : int
        Longest path; also bounds diffuse bounces.
    glossy_bounces : int
        Mirror-like reflections within a path.
    """

    name: str
    samples: int
    denoise: bool = True
    disc_diameter: int | None = None
    max_bounces: int = 8
    diffuse_bounces: int = 4
    glossy_bounces: int = 4

    def camera(self, camera: FisheyeCamera) -> FisheyeCamera:
        """The camera that this preset renders for a map with ``camera``."""
        return camera if self.disc_diameter is None else camera.resized(self.disc_diameter)


PRESETS: dict[str, Preset] = {
    preset.name: preset
    for preset in (
        Preset("reference", samples=16),
        Preset("draft", samples=4),
        Preset("quick", samples=2),
        Preset("preview", samples=4, disc_diameter=232),
    )
}
"""The presets by name."""


def preset_named(name: str) -> Preset:
    """The preset of that name.

    Raises
    ------
    RoomsegError
        If there is none.
    """
    if name not in PRESETS:
        raise RoomsegError(f"preset: {name!r}, expected one of {', '.join(PRESETS)}")
    return PRESETS[name]
