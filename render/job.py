"""Images for the nodes of a map file, resumable (§3.1).

A child process renders (`render.process`); this one exposes the images and is the
map's one writer. Every finished frame goes to the journal beside the map at once
and is packed into the map when the job ends, also by an error or Ctrl-C, so that at
most the image in the making is lost. Frame i depends on the map's seed, the node's
pose and i alone: a map rendered in pieces equals one rendered in one go.

Radiance is rounded to float16 before it is exposed, kept or not: `expose_map` then makes
of what was kept the very images that rendering made.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dataset.camera import CameraFlaws, FisheyeCamera
from dataset.errors import FormatError
from dataset.frames import Radiance
from dataset.journal import FrameJournal
from dataset.storage import read_map
from dataset.topomap import TopoMap
from render.blender import render_window
from render.cycles import Device
from render.exposure import expose
from render.lighting import missing_light
from render.presets import PRESETS, Preset
from render.process import Job, RenderProcess
from scenes.apartment import Apartment
from scenes.errors import SceneError
from scenes.storage import apartment_from_json

__all__ = ["expose_map", "render_map", "suited_preset"]

NOISE = 0x5E45
"""Tells the noise of the images from whatever else is drawn from the run's seed."""


def render_map(
    path: str | Path,
    *,
    preset: Preset,
    nodes: Iterable[int] | None = None,
    limit: int | None = None,
    threads: int | None = None,
    device: Device = "auto",
    hdr: bool = False,
    on_device: Callable[[str], None] | None = None,
    on_bake: Callable[[], None] | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> int:
    """Render the images that a map still lacks, at the nodes' true poses.

    Parameters
    ----------
    path : path
        Map file with ``/scene`` and ``/nodes/true_pose``.
    preset : Preset
        See `suited_preset`.
    nodes : iterable of int, optional
        The nodes whose images are wanted; all if absent.
    limit : int, optional
        Render that many images at most.
    threads : int, optional
        All cores if absent.
    device : {'auto', 'cpu', 'gpu'}
    hdr : bool
        Keep the radiance of the images, too, for `expose_map`.
    on_device : callable, optional
        Called once with the name of what renders.
    on_bake : callable, optional
        Called if the apartment's light has to be baked first.
    on_progress : callable, optional
        Called with (images that are there, how many there will be), at first and after
        every image.

    Returns
    -------
    int
        How many images were rendered.

    Raises
    ------
    FormatError
        If the file is no map, has no scene, poses or light, or holds images of
        another preset or camera, or without the radiance to be kept.
    RoomsegError
        If another process writes to the map, or Blender fails.
    """
    topomap = read_map(path)
    apartment = _apartment(path, topomap)
    preset = _suited(apartment, preset)
    camera = _camera(path, topomap, preset)
    with FrameJournal(path, camera, preset.name, keep_radiance=hdr) as journal:
        try:
            wanted = range(len(topomap.nodes)) if nodes is None else sorted(set(nodes))
            missing = [i for i in wanted if i not in journal.done][:limit]
            if on_progress is not None:
                on_progress(len(journal.done), len(journal.done) + len(missing))
            if not missing:
                return 0
            folder = str(Path(path).resolve().parent)
            job = Job(apartment, camera, preset, threads, device, topomap.seed, folder)
            with RenderProcess(job, on_bake) as process:
                if on_device is not None:
                    on_device(process.device)
                return _render(process, journal, topomap, missing, on_progress)
        finally:
            journal.pack()


def suited_preset(path: str | Path, preset: Preset) -> Preset:
    """The preset that `render_map` takes for a map if it is asked for ``preset``.

    The light of a 3D scene of another make cannot be baked; `reference` traces it.

    Raises
    ------
    FormatError
        If the file is no map, or cannot be rendered.
    """
    return _suited(_apartment(path, read_map(path)), preset)


def _suited(apartment: Apartment, preset: Preset) -> Preset:
    baked = preset.bake is not None and apartment.scene_file is not None
    return PRESETS["reference"] if baked else preset


def _render(
    process: RenderProcess,
    journal: FrameJournal,
    topomap: TopoMap,
    missing: list[int],
    on_progress: Callable[[int, int], None] | None,
) -> int:
    """Expose and journal the frames of the nodes ``missing``."""
    poses = topomap.nodes.camera_pose
    assert poses is not None
    count, total = 0, len(journal.done) + len(missing)
    with closing(process.frames(missing, poses)) as frames:
        for index, light in frames:
            radiance = Radiance.of(light)
            rng = _noise_of(topomap.seed, index)
            image, gain = expose(radiance.light, journal.camera, rng)
            journal.append(index, image, gain, radiance)
            count += 1
            if on_progress is not None:
                on_progress(len(journal.done), total)
    return count


def expose_map(
    path: str | Path,
    flaws: CameraFlaws | None = None,
    *,
    on_progress: Callable[[int, int], None] | None = None,
) -> int:
    """Expose the images of a map anew, from the radiance that `render_map` kept.

    Parameters
    ----------
    path : path
    flaws : CameraFlaws, optional
        Of the map's camera, from now on; as they are if absent.
    on_progress : callable, optional
        Called with (images done, how many there will be).

    Returns
    -------
    int
        How many images were exposed.

    Raises
    ------
    FormatError
        If the file is no map, or keeps no radiance.
    RoomsegError
        If another process writes to the map.
    """
    topomap, count = read_map(path), 0
    camera = topomap.camera if flaws is None else replace(topomap.camera, flaws=flaws)

    def develop(index: int, light: NDArray[np.float32]) -> tuple[NDArray[np.uint8], float]:
        nonlocal count
        developed = expose(light, camera, _noise_of(topomap.seed, index))
        count += 1
        if on_progress is not None:
            on_progress(count, len(journal.done))
        return developed

    with FrameJournal(path) as journal:
        return journal.expose(camera, develop)


def _noise_of(seed: int, node: int) -> np.random.Generator:
    """The generator of a node's noise, whoever renders it and when."""
    return np.random.default_rng(np.random.SeedSequence([seed % 2**64, node, NOISE]))


def _camera(path: str | Path, topomap: TopoMap, preset: Preset) -> FisheyeCamera:
    """The camera to render; FormatError if Blender cannot place its disc."""
    camera = preset.camera(topomap.camera)
    try:
        render_window(camera)
    except ValueError as error:
        raise FormatError(f"{path}: /camera: {error}") from error
    return camera


def _apartment(path: str | Path, topomap: TopoMap) -> Apartment:
    """The map's own apartment; FormatError if the map cannot be rendered."""
    if topomap.scene is None:
        raise FormatError(f"{path}: /scene: missing, only simulated maps can be rendered")
    if topomap.nodes.true_pose is None:
        raise FormatError(f"{path}: /nodes/true_pose: missing, only simulated maps can be rendered")
    try:
        apartment = apartment_from_json(topomap.scene, origin=f"{path}: /scene")
    except SceneError as error:
        raise FormatError(str(error)) from error
    if apartment.scene_file is None and (missing := missing_light(apartment)) is not None:
        source = apartment.lighting.source
        raise FormatError(
            f"{path}: /scene: lighting.source {source!r}: nothing gives light; expected {missing}"
        )
    return apartment
