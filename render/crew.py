"""What a Dask worker does for `render.pool`: it renders chunks of nodes.

A worker keeps Blender with the built apartment between chunks, also of another run in
the same apartment, and closes it when it had nothing to do for a while or is sent to
another apartment. Frames are developed and packed here: only what is stored travels.

Nothing here is read from files that others made: parcels come from the command that renders, and
Dask workers trust whoever reaches their scheduler.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, field
from importlib.metadata import version
from threading import Lock, Timer
from typing import Any

import numpy as np
from distributed import WorkerPlugin, get_worker
from numpy.typing import NDArray

from dataset.errors import RoomsegError
from dataset.frames import Frame
from render.develop import develop
from render.process import DeadProcessError, Job, RenderProcess

__all__ = ["Crew", "Parcel", "Rendered", "render_chunk", "software", "stop_crew"]

IDLE_S = 60.0
"""How long a worker keeps an apartment for which there is nothing to do."""


def software() -> dict[str, str]:
    """What has to be the same on all machines for the same bytes."""
    return {name: version(name) for name in ("roomseg", "bpy", "numpy")}


@dataclass(frozen=True)
class Parcel:
    """All that a worker has to know of a map.

    Attributes
    ----------
    job : Job
    place : str
        The same for maps that can be rendered by one process: the job but its seed.
    poses : array, shape (n, 3) or (n, 5)
        Of all nodes.
    keep_radiance : bool
    files : dict of str to bytes or None
        Baked light and 3D scene, for a worker that cannot reach the map's folder.
    software : dict
        See `software`.
    """

    job: Job
    place: str
    poses: NDArray[np.float64]
    keep_radiance: bool
    files: dict[str, bytes] | None = None
    software: dict[str, str] = field(default_factory=software)


@dataclass(frozen=True)
class Rendered:
    """What comes back: packed frames, the time they took, and what rendered."""

    frames: list[Frame]
    seconds: float
    device: str


def render_chunk(parcel: Parcel, crew: str, nodes: list[int]) -> Rendered:
    """Render some nodes of a map; a task of Dask."""
    worker = get_worker()
    member: Crew = worker.plugins[crew]
    if (here := software()) != parcel.software:
        raise RoomsegError(
            f"worker {worker.address}: has {_listed(here)}; expected {_listed(parcel.software)}"
        )
    return member.render(parcel, nodes)


def stop_crew(crew: str, dask_worker: Any = None) -> None:
    """Make a worker hand back at once what it has rendered so far; run by `Client.run`."""
    if crew in dask_worker.plugins:
        dask_worker.plugins[crew].stop()


def _listed(versions: dict[str, str]) -> str:
    return ", ".join(f"{name} {number}" for name, number in versions.items())


class Crew(WorkerPlugin):  # type: ignore[misc]
    """The rendering processes of one worker, for one command."""

    def __init__(self, name: str) -> None:
        self.name = name

    def setup(self, worker: Any) -> None:
        """Begin on a worker."""
        self._lock = Lock()
        self._idle: dict[str, list[RenderProcess]] = {}
        self._busy: list[RenderProcess] = []
        self._stopped = False
        self._timer: Timer | None = None

    def teardown(self, worker: Any) -> None:
        """The command has ended, or the worker does."""
        self.stop()
        self._close_idle()

    def stop(self) -> None:
        """End what is being rendered, without waiting for the frame."""
        with self._lock:
            self._stopped = True
            for process in self._busy:
                process.stop()

    def render(self, parcel: Parcel, nodes: Sequence[int]) -> Rendered:
        """Render nodes; fewer of them if it is stopped meanwhile."""
        frames: list[Frame] = []
        if self._stopped:
            return Rendered(frames, 0.0, "")
        process = self._take(parcel)
        begun = time.perf_counter()
        try:
            self._render(process, parcel, list(nodes), frames)
        except BaseException as error:
            self._let_go(process)
            if not (self._stopped and isinstance(error, DeadProcessError)):
                raise
        else:
            self._keep(parcel.place, process)
        return Rendered(frames, time.perf_counter() - begun, process.device)

    def _render(
        self, process: RenderProcess, parcel: Parcel, nodes: list[int], frames: list[Frame]
    ) -> None:
        """Add the frames of nodes to ``frames``, one by one."""
        job, keep = parcel.job, parcel.keep_radiance
        with closing(process.frames(nodes, parcel.poses, job.seed)) as stream:
            for node, light in stream:
                frames.append(develop(node, light, job.camera, job.seed, keep_radiance=keep))

    def _take(self, parcel: Parcel) -> RenderProcess:
        """A process with the apartment built; those that idle in others make room."""
        with self._lock:
            if self._timer is not None:
                self._timer.cancel()
            here = self._idle.get(parcel.place)
            process = here.pop() if here else None
        if process is None:
            self._close_idle()
            process = RenderProcess(parcel.job, files=parcel.files)
        with self._lock:
            self._busy.append(process)
            if self._stopped:
                process.stop()
        return process

    def _keep(self, place: str, process: RenderProcess) -> None:
        with self._lock:
            self._busy.remove(process)
            self._idle.setdefault(place, []).append(process)
            if self._timer is not None:
                self._timer.cancel()
            self._timer = Timer(IDLE_S, self._close_idle)
            self._timer.daemon = True
            self._timer.start()

    def _let_go(self, process: RenderProcess) -> None:
        with self._lock:
            self._busy.remove(process)
        process.close()

    def _close_idle(self) -> None:
        with self._lock:
            idle = [process for here in self._idle.values() for process in here]
            self._idle.clear()
        for process in idle:
            process.close()
