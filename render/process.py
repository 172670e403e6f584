"""The caller's end of the rendering child process (`render.worker`), and what it is told."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Generator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from dataset.camera import FisheyeCamera
from dataset.closing import Closing
from dataset.errors import RoomsegError
from render.cycles import Device
from render.presets import Preset, preset_from
from scenes.apartment import Apartment

__all__ = ["DeadProcessError", "Job", "LightProcess", "RenderProcess", "start_child"]

PATIENCE_S = 10.0


@dataclass(frozen=True)
class Job:
    """What the child is to render, in the first line that it reads.

    ``threads`` None means all cores; frame i is sampled with ``seed`` + i, unless another
    seed is asked for with it. The
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


class DeadProcessError(RoomsegError):
    """The rendering process ended without a word; another may do better."""


class _Child(Closing):
    """A process of `render.worker` that has been told its job."""

    def __init__(
        self, job: Job, files: Mapping[str, bytes] | None = None, *, only_light: bool = False
    ) -> None:
        # Here, so that it goes even if the child is killed.
        self._folder = tempfile.TemporaryDirectory(prefix="roomseg-render-")
        if files is not None:
            job = replace(job, folder=str(_unpack(files, Path(self._folder.name))))
        self._log: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115  (closed by _end)
        self._child = start_child("render.worker", self._log)
        request = {"job": job.to_json(), "folder": self._folder.name, "only_light": only_light}
        self._send(json.dumps(request))

    def stop(self) -> None:
        """End the child at once, from any thread; whoever waits for it gets `DeadProcessError`."""
        self._child.kill()

    def _first_answer(self, on_bake: Callable[[], None] | None) -> dict[str, Any]:
        """What the child says when it is ready."""
        ready, _ = self._receive()
        if "baking" in ready:
            if on_bake is not None:
                on_bake()
            ready, _ = self._receive()
        return ready

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
            raise DeadProcessError(self._last_words())
        head = json.loads(line)
        if "error" in head:
            raise RoomsegError(head["error"])
        data = self._child.stdout.read(head["bytes"])
        if len(data) != head["bytes"]:
            raise DeadProcessError(self._last_words())
        return head, data

    def _last_words(self) -> str:
        """One line on a child that died."""
        status = self._child.wait()
        self._log.seek(0)
        lines = self._log.read().decode(errors="replace").strip().splitlines()
        return f"Blender: the rendering process ended with {status}: {' '.join(lines[-1:])}"

    def close(self) -> None:
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


class RenderProcess(_Child):
    """Renders an apartment in a process of its own. Use it as a context manager.

    Parameters
    ----------
    job : Job
    on_bake : callable, optional
        Called if the light has to be baked first, which takes minutes.
    files : mapping of str to bytes, optional
        What stands in for ``job.folder`` where that cannot be reached: names relative to it.

    Attributes
    ----------
    device : str
        What renders: 'CPU', or the graphics cards' names.

    Raises
    ------
    RoomsegError
        If Blender cannot be loaded, or the device asked for is not there.
    """

    def __init__(
        self,
        job: Job,
        on_bake: Callable[[], None] | None = None,
        files: Mapping[str, bytes] | None = None,
    ) -> None:
        super().__init__(job, files)
        self._size, self._seed = job.camera.image_size, job.seed
        try:
            self.device = str(self._first_answer(on_bake)["device"])
        except BaseException:
            self.close()
            raise

    def frames(
        self, indices: list[int], poses: NDArray[np.float64], seed: int | None = None
    ) -> Generator[tuple[int, NDArray[np.float32]], None, None]:
        """Render the nodes ``indices``; the child works one frame ahead of the caller.

        Parameters
        ----------
        indices : list of int
        poses : array, shape (n, 3) or (n, 5)
            True poses of all nodes: m, m, rad, and how they lean; see `place_camera`.
        seed : int, optional
            Of the run, if it is another than the job's.

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
            self._ask(ahead, poses, seed)
        for here, index in enumerate(indices):
            for ahead in indices[here + 1 : here + 2]:
                self._ask(ahead, poses, seed)
            head, data = self._receive()
            assert head["index"] == index
            yield index, np.frombuffer(data, dtype="<f4").reshape(self._size)

    def _ask(self, index: int, poses: NDArray[np.float64], seed: int | None = None) -> None:
        pose = [float(value) for value in poses[index]]
        seed = self._seed if seed is None else seed
        self._send(json.dumps({"index": int(index), "pose": pose, "seed": int(seed)}))


class LightProcess(_Child):
    """Finds an apartment's baked light, or bakes it, in a process of its own.

    Parameters
    ----------
    job : Job
        With a preset that bakes.
    """

    def __init__(self, job: Job) -> None:
        super().__init__(job, only_light=True)

    def find(self, on_bake: Callable[[], None] | None = None) -> Path:
        """Wait for the light, and say in which file it is.

        Raises
        ------
        RoomsegError
            If it can be neither found nor baked.
        """
        try:
            return Path(self._first_answer(on_bake)["light"])
        finally:
            self.close()


def _unpack(files: Mapping[str, bytes], folder: Path) -> Path:
    """Write files into a new folder within ``folder``, which is returned."""
    for name, content in files.items():
        path = folder / "files" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return folder / "files"


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
