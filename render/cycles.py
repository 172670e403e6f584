"""Blender Cycles: settings, device, and the capture of linear float pixels.

`bpy.ops.render.render` offers no pixels in background mode, and files cost time.
The capture therefore wraps the ``render`` method of the Cycles engine class and
reads the finished 'Combined' pass from memory; where that is not possible it reads a
float EXR from a temporary folder. A render that Blender gave up (a swallowed SIGINT
still reports FINISHED) leaves no pixels, and is an error here.

Same scene, settings and seed give the same bytes on one machine and device.
"""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from dataset.camera import FisheyeCamera
from dataset.errors import RoomsegError
from render.blender import place_camera, render_window
from render.open_image_denoise import Denoiser
from render.presets import Preset

__all__ = [
    "Device",
    "FrameSource",
    "Frames",
    "configure",
    "luminance",
    "render_through_file",
    "select_device",
]

Device = Literal["auto", "cpu", "gpu"]
LUMINANCE = np.array([0.2126, 0.7152, 0.0722], dtype=np.float32)
"""Rec. 709 weights: the eye's, standing in for the monochrome sensor's response."""
COMBINED = "Combined"
SHINING = ("Emission", "Environment")
"""Passes of what shines towards the camera by itself."""
GPU_KINDS = ("OPTIX", "CUDA", "HIP", "ONEAPI", "METAL")


def configure(
    scene: Any, preset: Preset, threads: int | None = None, *, glass: bool = False
) -> None:
    """Set Cycles up for ``preset`` on ``threads`` threads (all, if None).

    ``glass``: there is glass that refracts. Our own panes are transparent instead; frosted
    ones pass light on as often as matte surfaces do (`render.shading`).
    """
    scene.render.engine = "CYCLES"
    _configure_sampling(scene.cycles, preset)
    scene.cycles.transmission_bounces = (
        preset.max_bounces if glass else scene.cycles.diffuse_bounces
    )
    scene.cycles.caustics_refractive = glass
    _configure_denoising(scene, preset)
    render = scene.render
    render.use_persistent_data = True
    render.use_compositing = False
    render.use_sequencer = False
    render.dither_intensity = 0.0
    render.film_transparent = False
    render.threads_mode = "FIXED"
    render.threads = threads or len(os.sched_getaffinity(0))


def _configure_sampling(cycles: Any, preset: Preset) -> None:
    """Path tracing without the options that bias or only cost (docs/render.md)."""
    cycles.shading_system = False  # no scripts as shaders
    cycles.samples = preset.samples
    cycles.use_adaptive_sampling = False
    cycles.time_limit = 0.0
    # Only gloss sees the lights beside baked light: the tree is not worth its price.
    cycles.use_light_tree = preset.bake is None
    cycles.use_auto_tile = False
    cycles.max_bounces = preset.max_bounces
    cycles.diffuse_bounces = min(preset.diffuse_bounces, preset.max_bounces)
    cycles.glossy_bounces = min(preset.glossy_bounces, preset.max_bounces)
    cycles.transparent_max_bounces = 16  # two for every pane in a row
    cycles.volume_bounces = 0
    cycles.caustics_reflective = False
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1.0
    cycles.film_exposure = 1.0
    cycles.use_fast_gi = False
    cycles.sample_clamp_direct = 0.0
    cycles.sample_clamp_indirect = 0.0


def _configure_denoising(scene: Any, preset: Preset) -> None:
    """OpenImageDenoise on the image, guided by albedo and normals; baked light: see `Frames`."""
    cycles = scene.cycles
    cycles.use_denoising = preset.denoise and preset.bake is None
    for layer in scene.view_layers:
        layer.use_pass_emit = layer.use_pass_environment = preset.bake is not None
    if cycles.use_denoising:
        cycles.denoiser = "OPENIMAGEDENOISE"
        cycles.denoising_input_passes = "RGB_ALBEDO_NORMAL"
        cycles.denoising_prefilter = "NONE"  # keeps more lintel edges than FAST (docs/render.md)
        cycles.denoising_quality = "HIGH"
        cycles.denoising_use_gpu = False


def select_device(bpy: Any, scene: Any, device: Device) -> str:
    """Choose where Cycles runs and say what it is.

    Returns
    -------
    str
        'CPU' or kind and name of the graphics cards used.

    Raises
    ------
    RoomsegError
        If ``device`` is 'gpu' and there is none.
    """
    scene.cycles.device = "CPU"
    if device == "cpu":
        return "CPU"
    preferences = bpy.context.preferences.addons["cycles"].preferences
    for kind in GPU_KINDS:
        names = _enable(preferences, kind)
        if names:
            scene.cycles.device = "GPU"
            scene.cycles.denoising_use_gpu = True
            return f"{kind}: {', '.join(names)}"
    if device == "gpu":
        raise RoomsegError("device: 'gpu', but Blender finds none here; expected 'auto' or 'cpu'")
    return "CPU"


def _enable(preferences: Any, kind: str) -> list[str]:
    """Names of the graphics cards of ``kind``, now enabled; with none, Blender lists CPUs only."""
    try:
        preferences.compute_device_type = kind
    except TypeError:
        return []
    preferences.get_devices()
    names = []
    for card in preferences.devices:
        card.use = card.type == kind
        if card.use:
            names.append(card.name)
    return names


def luminance(colour: NDArray[np.float32]) -> NDArray[np.float32]:
    """Monochrome intensity (h, w) of linear RGB or RGBA (h, w, 3 or more)."""
    return np.ascontiguousarray(colour[..., :3] @ LUMINANCE, dtype=np.float32)


@dataclass
class _Capture:
    """The last frame's passes (rows, columns, channels), top row first; none before a frame."""

    passes: dict[str, NDArray[np.float32]] = field(default_factory=dict)
    works: bool = True


class Frames:
    """What the camera of a scene sees, from memory where that is possible.

    Parameters
    ----------
    bpy : module
    scene : bpy.types.Scene
    denoiser : Denoiser, optional
        For a scene that shows baked light. Quietens what is traced, and leaves alone what
        shines by itself: a denoiser takes the joints of tiles for noise, and the grain of
        gloss for the texture of what it lies on.
    """

    def __init__(self, bpy: Any, scene: Any, denoiser: Denoiser | None = None) -> None:
        self._bpy = bpy
        self._scene = scene
        self._denoiser = denoiser
        self._capture = _Capture()
        _wrap_engine(bpy, self._capture)

    def render(self) -> NDArray[np.float32]:
        """Linear pixels (rows, columns, channels), top row first.

        Raises
        ------
        RoomsegError
            If Blender returned without a frame.
        """
        self._capture.passes.clear()
        if self._capture.works:
            self._bpy.ops.render.render()
            if self._capture.passes:
                return self._quiet(self._capture.passes)
            if self._capture.works:
                raise RoomsegError("Blender: the render ended without a frame (interrupted?)")
        return self._quiet({COMBINED: render_through_file(self._bpy, self._scene)})

    def _quiet(self, passes: dict[str, NDArray[np.float32]]) -> NDArray[np.float32]:
        if self._denoiser is None:
            return passes[COMBINED]
        colour = passes[COMBINED][..., :3]
        shining = [passes[name][..., :3] for name in SHINING if name in passes]
        shown = np.sum(shining, axis=0, dtype=np.float32) if shining else np.zeros_like(colour)
        return shown + self._denoiser(np.maximum(colour - shown, 0.0), quality="fast")


class FrameSource:
    """Renders frames of one prepared scene.

    Parameters
    ----------
    bpy : module
    scene : bpy.types.Scene
        With the camera of `render.blender.add_camera`; see `configure`.
    camera : FisheyeCamera
    seed : int
        Frame i is sampled with seed + i, so that noise does not repeat between images.
    denoiser : Denoiser, optional
        See `Frames`.
    """

    def __init__(
        self,
        bpy: Any,
        scene: Any,
        camera: FisheyeCamera,
        seed: int = 0,
        denoiser: Denoiser | None = None,
    ) -> None:
        self._bpy = bpy
        self._scene = scene
        self._camera = camera
        self._seed = seed
        self._outside = camera.pixel_zenith() > 0.5 * camera.field_of_view
        self._frames = Frames(bpy, scene, denoiser)

    def colour(self, pose: NDArray[np.float64], index: int = 0) -> NDArray[np.float32]:
        """Linear RGB (h, w, 3) at ``pose`` (`render.blender.place_camera`); 0 outside the disc.

        Raises
        ------
        RoomsegError
            If Blender returned without a frame.
        """
        place_camera(self._scene.camera, pose, self._camera.height)
        self._scene.cycles.seed = (self._seed + index) % 2**31
        self._scene.update_tag()
        square = self._frames.render()
        return self._in_image(square)

    def radiance(self, pose: NDArray[np.float64], index: int = 0) -> NDArray[np.float32]:
        """Monochrome linear image (h, w) at ``pose``; see `colour`."""
        return luminance(self.colour(pose, index))

    def _in_image(self, square: NDArray[np.float32]) -> NDArray[np.float32]:
        """The rendered square at its place in the camera image; black elsewhere."""
        (side, _), origin = render_window(self._camera)
        image = np.zeros((*self._camera.image_size, 3), dtype=np.float32)
        first = [max(0, value) for value in origin]
        last = [
            min(size, value + side)
            for size, value in zip(self._camera.image_size, origin, strict=True)
        ]
        image[first[0] : last[0], first[1] : last[1]] = square[
            first[0] - origin[0] : last[0] - origin[0],
            first[1] - origin[1] : last[1] - origin[1],
            :3,
        ]
        image[self._outside] = 0.0
        return image


def render_through_file(bpy: Any, scene: Any) -> NDArray[np.float32]:
    """Linear pixels (rows, columns, channels) of the scene's camera, through a float EXR.

    Raises
    ------
    RoomsegError
        If Blender returned without a picture.
    OSError
        If the picture was not stored whole.
    """
    render = scene.render
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "frame.exr"
        render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        if not path.exists():
            raise RoomsegError("Blender: the render ended without a frame (interrupted?)")
        image = bpy.data.images.load(str(path))
        width, height = image.size
        if not image.has_data and not width * height:
            raise OSError("no room for temporary files")
        flat = np.empty(width * height * image.channels, dtype=np.float32)
        image.pixels.foreach_get(flat)
        channels = image.channels
        bpy.data.images.remove(image)
    return flat.reshape(height, width, channels)[::-1]


def _wrap_engine(bpy: Any, capture: _Capture) -> None:
    """Make the Cycles engine hand its finished pixels to ``capture``."""
    engine = next(
        c for c in bpy.types.RenderEngine.__subclasses__() if c.__name__ == "CyclesRender"
    )
    original = getattr(engine, "uncaptured_render", engine.render)
    engine.uncaptured_render = original

    def render(self: Any, depsgraph: Any) -> None:
        original(self, depsgraph)
        try:
            capture.passes = _passes(self)
        except (AttributeError, IndexError, KeyError, TypeError):
            capture.works = False

    engine.render = render


def _passes(engine: Any) -> dict[str, NDArray[np.float32]]:
    """Pixels (rows, columns, channels) of the engine's passes, top row first."""
    result = engine.get_result()
    width, height = result.resolution_x, result.resolution_y
    found = {}
    for item in result.layers[0].passes:
        if item.name in (COMBINED, *SHINING):
            flat = np.empty(width * height * item.channels, dtype=np.float32)
            item.rect.foreach_get(flat)
            found[item.name] = flat.reshape(height, width, item.channels)[::-1]
    found[COMBINED] = found[COMBINED].copy()
    return found
