"""The caller's end of the rendering child process (`render.worker`), and what it is told."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Generator
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from dataset.camera import FisheyeCamera
from dataset.errors import RoomsegError
from render.cycles import Device
from render.presets import Preset, preset_from
from scenes.apartment import Apartment

__all__ = ["Job", "RenderProcess", "start_child"]

PATIENCE_S = 10.0


@dataclass(frozen=True)
class Job:
    """What the child is to render, in the first line that it reads.

    ``threads`` None means all cores; frame i is sampled with ``seed`` + i. The
    apartment's scene file, if it has one, is in ``folder``.
    """

    apartment: Apartment
    camera: FisheyeCamera
    preset: Preset
    threads: int | None = None
    device: Device = "auto"
    seed: int = 0
    folder: str = "."

    def to_json(self) -> str:
        """One line of JSON."""
        fields = {
            "apartment": self.apartment.model_dump(mode="json"),
            "camera": asdict(self.camera),
            "preset": asdict(self.preset),
            "threads": self.threads,
            "device": self.device,
            "seed": self.seed,
            "folder": self.folder,
        }
        return json.dumps(fields)

    @classmethod
    def from_json(cls, line: str) -> Job:
        """The job of `to_json`."""
        fields = json.loads(line)
        return cls(
            apartment=Apartment.model_validate(fields.pop("apartment")),
            camera=FisheyeCamera.of(fields.pop("camera")),
            preset=preset_from(fields.pop("preset")),
            **fields,
        )


class RenderProcess:
    """Renders an apartment in a process of its own. Use it as a context manager.

    Parameters
    ----------
    job : Job
    on_bake : callable, optional
        Called if the light has to be baked first, which takes minutes.

    Attributes
    ----------
    device : str
        What renders: 'CPU', or the graphics cards' names.

    Raises
    ------
    RoomsegError
        If Blender cannot be loaded, or the device asked for is not there.
    """

    def __init__(self, job: Job, on_bake: Callable[[], None] | None = None) -> None:
        self._size = job.camera.image_size
        # Here, so that it goes even if the child is killed.
        self._folder = tempfile.TemporaryDirectory(prefix="roomseg-render-")
        self._log: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115  (closed by _end)
        self._child = start_child("render.worker", self._log)
        try:
            self._send(json.dumps({"job": job.to_json(), "folder": self._folder.name}))
            ready, _ = self._receive()
            if "baking" in ready:
                if on_bake is not None:
                    on_bake()
                ready, _ = self._receive()
            self.device = str(ready["device"])
        except BaseException:
            self._end()
            raise

    def __enter__(self) -> RenderProcess:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._end()

    def frames(
        self, indices: list[int], poses: NDArray[np.float64]
    ) -> Generator[tuple[int, NDArray[np.float32]], None, None]:
        """Render the nodes ``indices``; the child works one frame ahead of the caller.

        Parameters
        ----------
        indices : list of int
        poses : array, shape (n, 3) or (n, 5)
            True poses of all nodes: m, m, rad, and how they lean; see `place_camera`.

        Yields
        ------
        index : int
        radiance : array, shape ``camera.image_size``, float32

        Raises
        ------
        RoomsegError
            If a frame could not be rendered.
        """
        for ahead in indices[:1]:
            self._ask(ahead, poses)
        for here, index in enumerate(indices):
            for ahead in indices[here + 1 : here + 2]:
                self._ask(ahead, poses)
            head, data = self._receive()
            assert head["index"] == index
            yield index, np.frombuffer(data, dtype="<f4").reshape(self._size)

    def _ask(self, index: int, poses: NDArray[np.float64]) -> None:
        pose = [float(value) for value in poses[index]]
        self._send(json.dumps({"index": int(index), "pose": pose}))

    def _send(self, line: str) -> None:
        assert self._child.stdin is not None
        try:
            self._child.stdin.write(line.encode() + b"\n")
            self._child.stdin.flush()
        except BrokenPipeError:
            return  # the child is gone; why is said when its answer is read

    def _receive(self) -> tuple[dict[str, Any], bytes]:
        assert self._child.stdout is not None
        line = self._child.stdout.readline()
        if not line:
            raise RoomsegError(self._last_words())
        head = json.loads(line)
        if "error" in head:
            raise RoomsegError(head["error"])
        data = self._child.stdout.read(head["bytes"])
        if len(data) != head["bytes"]:
            raise RoomsegError(self._last_words())
        return head, data

    def _last_words(self) -> str:
        """One line on a child that died."""
        status = self._child.wait()
        self._log.seek(0)
        lines = self._log.read().decode(errors="replace").strip().splitlines()
        return f"Blender: the rendering process ended with {status}: {' '.join(lines[-1:])}"

    def _end(self) -> None:
        """End the child by closing its input; kill it if it does not end."""
        assert self._child.stdin is not None and self._child.stdout is not None
        with suppress(BrokenPipeError):
            self._child.stdin.close()
        try:
            self._child.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._child.kill()
            self._child.wait()
        self._child.stdout.close()
        self._log.close()
        self._folder.cleanup()


def start_child(module: str, log: IO[bytes]) -> subprocess.Popen[bytes]:
    """Start ``module`` in a session of its own, so that Ctrl-C reaches only the caller."""
    root = str(Path(__file__).resolve().parent.parent)
    path = os.pathsep.join(filter(None, [root, os.environ.get("PYTHONPATH")]))
    return subprocess.Popen(
        # -P: a dataset.py or render.py in the working directory is not ours.
        [sys.executable, "-P", "-m", module],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=log,
        env={**os.environ, "PYTHONPATH": path},
        start_new_session=True,
    )
