"""The child process that renders: ``python -m render.worker``, driven by `render.process`.

bpy stays out of the calling process: after a render ``fork`` hangs, SIGINT is
swallowed, and the interpreter may hang at its end. The child therefore only
renders, and ends without the interpreter's shutdown.

Requests come as lines of JSON on standard input: first the job, then one line per
frame. Answers go to the original standard output: a line of JSON, followed by the
frame's float32 pixels. Blender's own chatter is kept out of it by pointing file
descriptor 1 elsewhere. The end of the input ends the process.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any, BinaryIO

import numpy as np

from dataset.errors import RoomsegError
from render.blender import build_scene
from render.cycles import FrameSource, configure, select_device
from render.libraries import load_bpy
from render.process import Job
from scenes.errors import SceneError

__all__ = ["main"]


def _prepare(line: str) -> tuple[FrameSource, str]:
    """Build the job's scene; the frame source and the device it uses."""
    job = Job.from_json(line)
    bpy = load_bpy()
    scene = build_scene(bpy, job.apartment, job.camera)
    configure(scene, job.preset, job.threads)
    used = select_device(bpy, scene, job.device)
    return FrameSource(bpy, scene, job.camera, job.seed), used


def _answer(channel: BinaryIO, head: dict[str, Any], data: bytes = b"") -> None:
    channel.write(json.dumps({**head, "bytes": len(data)}).encode() + b"\n" + data)
    channel.flush()


def _serve(channel: BinaryIO) -> None:
    """Answer the job, then every frame asked for, until the input ends."""
    source, device = _prepare(sys.stdin.readline())
    _answer(channel, {"device": device})
    for line in sys.stdin:
        request = json.loads(line)
        pose, index = np.array(request["pose"]), request["index"]
        radiance = source.radiance(pose, index)
        _answer(channel, {"index": index}, radiance.astype("<f4").tobytes())


def main() -> None:
    """Serve one job; leaves the process without the interpreter's shutdown."""
    channel = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    status = 0
    try:
        _serve(channel)
    except (RoomsegError, SceneError) as error:
        _answer(channel, {"error": str(error)})
        status = 2
    except BrokenPipeError:
        status = 1
    sys.stderr.flush()
    os._exit(status)


if __name__ == "__main__":
    main()
