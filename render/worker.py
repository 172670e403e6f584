"""The child process that renders: ``python -m render.worker``, driven by `render.process`.

bpy stays out of the calling process: after a render ``fork`` hangs, SIGINT is
swallowed, and the interpreter may hang at its end. The child therefore only
renders, and ends without the interpreter's shutdown.

Requests come as lines of JSON on standard input: first the job and a folder for what
is temporary, then one line per frame. Answers go to the original standard output: a
line of JSON, followed by the frame's float32 pixels. Blender's own chatter is kept out
of it by pointing file descriptor 1 elsewhere. The end of the input ends the process at
once, also in the middle of a frame: the caller has gone, be it by SIGKILL.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import traceback
from collections.abc import Callable
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from threading import Thread
from typing import Any, BinaryIO, NoReturn

import numpy as np
from numpy.typing import NDArray

from dataset.errors import RoomsegError
from render.baked_scene import build_baked_scene
from render.baking import bake, lay_out_apartment
from render.blender import add_camera, build_scene
from render.cycles import FrameSource, configure, select_device
from render.libraries import load_bpy
from render.light_store import bake_path, stored_light
from render.open_image_denoise import Denoiser
from render.own_scene import open_own_scene
from render.presets import Bake
from render.process import Job
from render.scene_baking import BakedScene, traced_rest
from scenes.errors import SceneError

__all__ = ["leave", "main", "read_lines"]

Picture = NDArray[np.float32]
Baker = Callable[[], Picture]


def _prepare(line: str, on_bake: Callable[[], None]) -> tuple[FrameSource, str]:
    """Build the job's scene; the frame source and the device it uses."""
    job = Job.from_json(line)
    bpy = load_bpy()
    own, preset = job.apartment.scene_file is not None, job.preset
    denoiser = Denoiser(bpy, job.threads) if preset.bake is not None else None
    if own:
        scene = _own_scene(bpy, job, on_bake)
        add_camera(bpy, scene, job.camera)
        preset = preset if preset.bake is None else traced_rest(preset)
    elif preset.bake is not None:
        atlas = lay_out_apartment(job.apartment, preset.bake)
        light = _light(bpy, job, atlas.shape, _baker(bpy, job, preset.bake), on_bake)[0]
        scene = build_baked_scene(bpy, job.apartment, job.camera, atlas, light)
    else:
        scene = build_scene(bpy, job.apartment, job.camera)
    configure(scene, preset, job.threads, glass=own)
    used = select_device(bpy, scene, job.device)
    return FrameSource(bpy, scene, job.camera, denoiser=denoiser), used


def _own_scene(bpy: Any, job: Job, on_bake: Callable[[], None]) -> Any:
    """The apartment's own scene, with its light baked if the preset does so."""
    settings = job.preset.bake
    if settings is None:
        return open_own_scene(bpy, job.apartment, job.folder)
    baked = BakedScene(bpy, job.apartment, job.folder, settings)
    bake_now = partial(baked.bake, job.threads, job.device)
    light, _ = _light(bpy, job, baked.atlas.shape, bake_now, on_bake)
    return baked.show(light)


def _light(
    bpy: Any, job: Job, shape: tuple[int, int], make: Baker, on_bake: Callable[[], None]
) -> tuple[Picture, Path]:
    """The light of a job's apartment, baked now or by an earlier job; the file it is in."""
    assert job.preset.bake is not None
    path = bake_path(job.apartment, job.preset.bake, job.folder, bpy.app.version_string)

    def told() -> Picture:
        on_bake()
        return make()

    return stored_light(path, shape, told), path


def _baker(bpy: Any, job: Job, settings: Bake) -> Baker:
    return partial(bake, bpy, job.apartment, settings, threads=job.threads, device=job.device)


def _find_light(line: str, on_bake: Callable[[], None]) -> Path:
    """See to it that the light of a job's apartment is baked; the file that it is in."""
    job = Job.from_json(line)
    settings = job.preset.bake
    assert settings is not None
    bpy = load_bpy()
    if job.apartment.scene_file is None:
        shape = lay_out_apartment(job.apartment, settings).shape
        return _light(bpy, job, shape, _baker(bpy, job, settings), on_bake)[1]
    baked = BakedScene(bpy, job.apartment, job.folder, settings)
    bake_now = partial(baked.bake, job.threads, job.device)
    return _light(bpy, job, baked.atlas.shape, bake_now, on_bake)[1]


def _answer(channel: BinaryIO, head: dict[str, Any], data: bytes = b"") -> None:
    channel.write(json.dumps({**head, "bytes": len(data)}).encode() + b"\n" + data)
    channel.flush()


def leave(folder: str, status: int) -> NoReturn:
    """End the process at once, but for what Blender keeps in ``folder``."""
    shutil.rmtree(folder, ignore_errors=True)
    sys.stderr.flush()
    os._exit(status)


def read_lines(lines: SimpleQueue[str], folder: str) -> None:
    """Hand on what is asked for; end the process when the input does."""
    for line in sys.stdin:
        lines.put(line)
    leave(folder, 0)


def _serve(channel: BinaryIO, request: dict[str, Any], lines: SimpleQueue[str]) -> None:
    """Answer the job, then every frame asked for; `read_lines` ends this."""

    def on_bake() -> None:
        _answer(channel, {"baking": True})

    if request["only_light"]:
        _answer(channel, {"light": str(_find_light(request["job"], on_bake))})
        return
    source, device = _prepare(request["job"], on_bake)
    _answer(channel, {"device": device})
    while True:
        frame = json.loads(lines.get())
        pose, index = np.array(frame["pose"]), frame["index"]
        # The source's own seed is 0: maps of one apartment share it.
        radiance = source.radiance(pose, frame["seed"] + index)
        _answer(channel, {"index": index}, radiance.astype("<f4").tobytes())


def main() -> None:
    """Serve one job; leaves the process without the interpreter's shutdown."""
    channel = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    request = json.loads(sys.stdin.readline())
    folder = os.environ["TMPDIR"] = request["folder"]
    lines: SimpleQueue[str] = SimpleQueue()
    Thread(target=read_lines, args=(lines, folder), daemon=True).start()
    try:
        try:
            _serve(channel, request, lines)
        except (RoomsegError, SceneError) as error:
            _answer(channel, {"error": str(error)})
        except OSError as error:
            _answer(channel, {"error": f"Blender: {error.strerror or error}"})
    except BaseException:
        # A shutdown that hangs would keep the caller waiting for the reason, too.
        traceback.print_exc()
    leave(folder, 1)


if __name__ == "__main__":
    main()
