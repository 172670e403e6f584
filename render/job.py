"""Images for the nodes of a map file, resumable (§3.1).

A child process renders (`render.process`); this one exposes the images and is the
map's one writer. Every finished frame goes to the journal beside the map at once
and is packed into the map when the job ends, also by an error or Ctrl-C, so that at
most the image in the making is lost. Frame i depends on the map's seed, the node's
pose and i alone: a map rendered in pieces equals one rendered in one go.

Several maps at once, by several workers: `render.pool`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dataset.camera import CameraFlaws
from dataset.journal import FrameJournal
from dataset.storage import read_map
from render.cycles import Device
from render.develop import develop, noise_of
from render.exposure import expose
from render.map_work import MapWork, Wanted
from render.presets import Preset
from render.process import RenderProcess

__all__ = ["expose_map", "render_map"]


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
    wanted = Wanted(preset, limit, threads, device, hdr)
    with MapWork(path, wanted, nodes) as work:
        if on_progress is not None:
            on_progress(len(work.journal.done), work.total)
        if not work.missing:
            return 0
        with RenderProcess(work.job, on_bake) as process:
            if on_device is not None:
                on_device(process.device)
            return _render(process, work, on_progress)


def _render(
    process: RenderProcess, work: MapWork, on_progress: Callable[[int, int], None] | None
) -> int:
    """Develop and journal the frames that a map lacks."""
    journal, job = work.journal, work.job
    missing = list(work.missing)
    with closing(process.frames(missing, work.poses)) as frames:
        for node, light in frames:
            keep = journal.keeps_radiance
            journal.add(develop(node, light, journal.camera, job.seed, keep_radiance=keep))
            if on_progress is not None:
                on_progress(len(journal.done), work.total)
    return len(missing)


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
        developed = expose(light, camera, noise_of(topomap.seed, index))
        count += 1
        if on_progress is not None:
            on_progress(count, len(journal.done))
        return developed

    with FrameJournal(path) as journal:
        return journal.expose(camera, develop)
