"""How light is found for an image: traced for each, or baked once for all.

Raw path tracing is useless for the lintel search, whose Scharr operator takes
noise for edges (a thousand times at 16 samples); every preset therefore denoises.
The figures behind the choice are in ``docs/render.md``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from dataset.camera import FisheyeCamera
from dataset.errors import RoomsegError

__all__ = ["PRESETS", "Bake", "Preset", "preset_from", "preset_named"]


@dataclass(frozen=True)
class Bake:
    """How finely the light of an apartment is baked (`render.baking`).

    Attributes
    ----------
    samples : int
        Paths per texel.
    overhead, upright, floor, opening : float
        Side of a texel on what looks down (ceilings), sideways, on floors, and on the
        lintels, reveals and frames of openings, m.
    """

    samples: int = 64
    overhead: float = 0.02
    upright: float = 0.03
    floor: float = 0.05
    opening: float = 0.012

    def scaled(self, factor: float) -> Bake:
        """The same with texels ``factor`` times as large."""
        sizes = (self.overhead, self.upright, self.floor, self.opening)
        return Bake(self.samples, *(factor * size for size in sizes))


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
    bake : Bake or None
        The light of matte surfaces is baked, and only the rest traced.
    """

    name: str
    samples: int
    denoise: bool = True
    disc_diameter: int | None = None
    max_bounces: int = 8
    diffuse_bounces: int = 4
    glossy_bounces: int = 4
    bake: Bake | None = None

    def camera(self, camera: FisheyeCamera) -> FisheyeCamera:
        """The camera that this preset renders for a map with ``camera``."""
        return camera if self.disc_diameter is None else camera.resized(self.disc_diameter)


FAST = Preset("fast", 2, max_bounces=2, diffuse_bounces=0, glossy_bounces=2, bake=Bake())
"""The default."""
PRESETS: dict[str, Preset] = {
    preset.name: preset
    for preset in (
        Preset("reference", samples=16),
        FAST,
        Preset("draft", samples=4),
        Preset("quick", samples=2),
        replace(FAST, name="preview", samples=4, disc_diameter=232, bake=Bake().scaled(2.0)),
    )
}
"""The presets by name."""


def preset_from(fields: dict[str, Any]) -> Preset:
    """The preset whose `dataclasses.asdict` is ``fields``."""
    bake = fields.pop("bake")
    return Preset(**fields, bake=None if bake is None else Bake(**bake))


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
