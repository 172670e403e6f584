"""Images of many maps by many workers (`render.crew`), with one writer: this process.

All maps of a command share the workers. The unit is a chunk of nodes, about `CHUNK_S`
of work, smaller at the end so that no worker waits for another. A worker is given the
apartment that it has built as long as there is something to do in it, then the one with most to do
for each who is there. A chunk whose worker dies is done again; a worker that joins is given work.
Light is baked, or found, by a child of this process, while workers render other maps.

Frame i depends on the map's seed and i alone, and maps are packed in order of their
nodes, so that the files do not depend on who rendered what.
"""

from __future__ import annotations

import hashlib
import uuid
from collections import Counter
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import CancelledError
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import Any

from distributed import Client, KilledWorker

from dataset.errors import RoomsegError
from dataset.interrupts import interrupts_held
from render.cluster import crew_threads, workers_of
from render.crew import Crew, Parcel, Rendered, render_chunk, stop_crew
from render.map_work import MapWork, Outcome, Wanted
from render.process import DeadProcessError, Job, LightProcess
from scenes.errors import SceneError
from scenes.scene_file import find_scene_file

__all__ = ["render_maps"]

CHUNK_S, LEAST_S = 15.0, 2.0
FIRST = 2
"""Nodes of a map's first chunks, before it is known how long one takes."""
ATTEMPTS = 3
"""How often a chunk is tried whose rendering process died."""
BAKING = "baking the light, once per apartment"
POLL_S = 0.5
PATIENCE_S = 30.0
Problem = RoomsegError | SceneError | OSError


def render_maps(
    paths: Iterable[Path],
    wanted: Wanted,
    *,
    jobs: int = 1,
    scheduler: str | None = None,
    tell: Callable[[Path, str], None] = lambda path, line: None,
    show: Callable[[Path, int, int], None] = lambda path, done, total: None,
) -> Generator[Outcome, None, None]:
    """Render the images that maps lack, by several workers; see `render.render_map`.

    Stopped (also by closing the generator), it takes what the workers have rendered so
    far, and keeps it.

    Parameters
    ----------
    paths : iterable of Path
    wanted : Wanted
        ``threads``: of each worker; all cores shared if absent, one on a cluster.
    jobs : int
        How many workers to start here.
    scheduler : str, optional
        Address of a Dask scheduler whose workers are to render instead.
    tell : callable, optional
        Called with a map and a line about it.
    show : callable, optional
        Called with a map, the images that it has and those that it will have.

    Yields
    ------
    Outcome
        Of each map, when it is finished. After a problem the other maps go on.

    Raises
    ------
    RoomsegError
        If the scheduler does not answer, or is lost.
    """
    bakers = None if wanted.threads is None else wanted.threads * jobs
    wanted = replace(wanted, threads=wanted.threads or crew_threads(jobs, scheduler))
    with workers_of(jobs, scheduler) as client:
        remote = scheduler is not None
        pool = _Pool(client, wanted, bakers, remote=remote, tell=tell, show=show)
        try:
            yield from pool.run(list(paths))
        finally:
            pool.end()


@dataclass
class _Site:
    """A map in the making."""

    work: MapWork
    parcel: Parcel
    task: Any
    """The parcel as a task of Dask, which is sent to every worker once."""
    pace: float | None = None
    """Seconds per frame."""
    running: int = 0
    new: int = 0
    problem: Problem | None = None


@dataclass(frozen=True)
class _Chunk:
    site: _Site
    nodes: list[int]
    worker: str
    attempt: int = 1


class _Pool:
    """The writer's side. Workers' results and baked light arrive in one queue."""

    def __init__(
        self,
        client: Client,
        wanted: Wanted,
        bakers: int | None,
        *,
        remote: bool,
        tell: Callable[[Path, str], None],
        show: Callable[[Path, int, int], None],
    ) -> None:
        self.client, self.wanted, self.remote = client, wanted, remote
        self.bakers = bakers
        """Threads that bake; all if None."""
        self.lights: dict[str, Path] = {}
        """Baked light by place."""
        self.tell, self.show = tell, show
        self.crew = f"roomseg-{uuid.uuid4().hex}"
        self.events: SimpleQueue[Callable[[], Iterable[Outcome]]] = SimpleQueue()
        self.waiting: list[Path] = []
        self.sites: list[_Site] = []
        self.running: dict[Any, _Chunk] = {}
        self.again: list[_Chunk] = []
        self.built: dict[str, str] = {}
        """The place that each worker has built last."""
        self.light: LightProcess | None = None
        self.preparing: MapWork | None = None
        self.devices: set[str] = set()
        try:
            client.register_plugin(Crew(self.crew), name=self.crew)
        except (ImportError, OSError) as error:
            raise RoomsegError(
                f"the workers of Dask: {error}; expected scheduler and "
                "workers that run in an environment with the same roomseg"
            ) from error

    def run(self, paths: list[Path]) -> Generator[Outcome, None, None]:
        """Render; outcomes as they come."""
        self.waiting = paths[::-1]
        told = False
        # Raised in the middle of Dask, a Ctrl-C may be lost: in a destructor, say.
        with interrupts_held() as interrupt:
            while self.waiting or self.preparing or self.sites:
                interrupt()
                workers = self._workers()
                if not workers and not told and self.sites:
                    self.tell(self.sites[0].work.path, "no worker is there; waiting for one")
                told = not workers
                yield from self._open_next(sum(workers.values()))
                self._give_out(workers)
                with suppress(Empty):
                    yield from self.events.get(timeout=POLL_S)()

    # ---- maps -------------------------------------------------------------------------

    def _open_next(self, slots: int) -> Generator[Outcome, None, None]:
        """Begin with maps until there are as many as workers, one at a time."""
        while self.waiting and self.preparing is None:
            if sum(bool(site.work.missing) for site in self.sites) >= max(1, slots):
                return
            path = self.waiting.pop()
            try:
                work = MapWork(path, self.wanted)
            except (RoomsegError, SceneError, OSError) as error:
                yield Outcome(path, 0, error)
                continue
            self.show(path, len(work.journal.done), work.total)
            light = self.lights.get(_place(work.job))
            if not work.missing:
                yield self._closed(work, 0, None)
            elif work.job.preset.bake is None or light is not None:
                yield from self._begin(work, light)
            else:
                self._find_light(work)

    def _find_light(self, work: MapWork) -> None:
        """Have the light of a map's apartment found or baked; `_light_is_there` goes on."""
        self.preparing = work
        self.light = light = LightProcess(replace(work.job, threads=self.bakers))

        def find() -> None:
            try:
                path = light.find(lambda: self.tell(work.path, BAKING))
            except (RoomsegError, OSError) as error:
                problem = error
                self.events.put(lambda: self._light_failed(work, problem))
            else:
                self.events.put(lambda: self._light_is_there(work, path))

        Thread(target=find, daemon=True).start()

    def _light_is_there(self, work: MapWork, path: Path) -> Iterable[Outcome]:
        self.light = self.preparing = None
        self.lights[_place(work.job)] = path
        yield from self._begin(work, path)

    def _light_failed(self, work: MapWork, problem: Problem) -> Iterable[Outcome]:
        self.light = self.preparing = None
        yield self._closed(work, 0, problem)

    def _begin(self, work: MapWork, light: Path | None) -> Iterable[Outcome]:
        """Let workers render a map."""
        try:
            files = self._files(work, light) if self.remote else None
        except (SceneError, OSError) as error:
            yield self._closed(work, 0, error)
            return
        # What is sent has everything: equal apartments of two folders are one place.
        place = _place(work.job if files is None else replace(work.job, folder=""))
        parcel = Parcel(work.job, place, work.poses, work.journal.keeps_radiance, files)
        task = self.client.submit(_same, parcel, pure=False)
        self.sites.append(_Site(work, parcel, task))

    @staticmethod
    def _files(work: MapWork, light: Path | None) -> dict[str, bytes]:
        """What a worker needs of a map's folder."""
        paths = [] if light is None else [light]
        if work.job.apartment.scene_file is not None:
            paths.append(find_scene_file(work.job.apartment, work.job.folder))
        folder = Path(work.job.folder)
        return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}

    def _closed(self, work: MapWork, count: int, problem: Problem | None) -> Outcome:
        """Pack a map; the first problem is what is told."""
        try:
            work.close()
        except (RoomsegError, OSError) as error:
            problem = problem or error
        return Outcome(work.path, count, problem)

    # ---- chunks -----------------------------------------------------------------------

    def _workers(self) -> dict[str, int]:
        """How many chunks each worker can render at once."""
        try:
            return dict(self.client.ncores())
        except (OSError, RuntimeError, TimeoutError) as error:
            raise self._lost() from error

    def _lost(self) -> RoomsegError:
        return RoomsegError("the scheduler of Dask is lost; call the command again to go on")

    def _give_out(self, workers: dict[str, int]) -> None:
        """Give every worker that has time a chunk."""
        busy = Counter(chunk.worker for chunk in self.running.values())
        # Dask gives the chunks of workers that died to others, as second ones.
        for worker, slots in sorted(workers.items(), key=lambda item: busy[item[0]]):
            for _ in range(slots - busy[worker]):
                chunk = self._next_chunk(worker, sum(workers.values()))
                if chunk is None:
                    return
                self._submit(chunk)

    def _next_chunk(self, worker: str, slots: int) -> _Chunk | None:
        if self.again:
            return replace(self.again.pop(), worker=worker)
        open_ = [site for site in self.sites if site.work.missing and site.problem is None]
        if not open_:
            return None
        there = Counter(self.built.values())
        here = [site for site in open_ if site.parcel.place == self.built.get(worker)]
        site = max(here or open_, key=lambda s: len(s.work.missing) / (1 + there[s.parcel.place]))
        self.built[worker] = site.parcel.place
        left = sum(len(item.work.missing) for item in open_)
        share = -(-left // (2 * slots))
        count = FIRST
        if site.pace is not None:
            least, most = (round(seconds / max(site.pace, 1e-3)) for seconds in (LEAST_S, CHUNK_S))
            count = max(1, min(most, max(least, share)))
        missing = site.work.missing
        return _Chunk(site, [missing.popleft() for _ in range(min(count, len(missing)))], worker)

    def _submit(self, chunk: _Chunk) -> None:
        chunk.site.running += 1
        future = self.client.submit(
            render_chunk,
            chunk.site.task,
            self.crew,
            chunk.nodes,
            workers=[chunk.worker],
            allow_other_workers=True,
            pure=False,
        )
        self.running[future] = chunk
        future.add_done_callback(lambda done: self.events.put(lambda: self._finished(done)))

    def _finished(self, future: Any) -> Iterable[Outcome]:
        """Keep what a worker rendered."""
        chunk = self.running.get(future)
        if chunk is None:
            return
        site = chunk.site
        try:
            self._keep(chunk, future.result())
        except (CancelledError, TimeoutError) as error:
            raise self._lost() from error
        except (DeadProcessError, KilledWorker) as error:
            self._try_again(chunk, error)
        except (RoomsegError, SceneError, OSError) as error:
            site.problem = site.problem or error
        # Only now: stopped before, it is asked again for what it has rendered.
        self.running.pop(future, None)
        site.running -= 1
        left = site.work.missing and site.problem is None
        if not site.running and not left and not any(c.site is site for c in self.again):
            self.sites.remove(site)
            yield self._closed(site.work, site.new, site.problem)

    def _keep(self, chunk: _Chunk, rendered: Rendered) -> None:
        site, work = chunk.site, chunk.site.work
        for frame in rendered.frames:
            if frame.index not in work.journal.done:
                work.journal.add(frame)
                site.new += 1
                self.show(work.path, len(work.journal.done), work.total)
        if rendered.frames:
            site.pace = rendered.seconds / len(rendered.frames)
        if rendered.device and rendered.device not in self.devices:
            self.devices.add(rendered.device)
            self.tell(work.path, f"rendering on {rendered.device}")

    def _try_again(self, chunk: _Chunk, error: Exception) -> None:
        """A chunk over which processes die again and again is its map's problem."""
        if chunk.attempt < ATTEMPTS:
            self.again.append(replace(chunk, attempt=chunk.attempt + 1))
        elif isinstance(error, RoomsegError):
            chunk.site.problem = chunk.site.problem or error
        else:
            first, last = chunk.nodes[0], chunk.nodes[-1]
            text = f"{chunk.site.work.path}: every worker died that rendered nodes {first}..{last}"
            chunk.site.problem = chunk.site.problem or RoomsegError(text)

    # ---- the end ----------------------------------------------------------------------

    def end(self) -> None:
        """Take what the workers have rendered so far, and close all maps."""
        problems = []
        try:
            if self.light is not None:
                self.light.stop()
            if self.running:
                self._collect()
        finally:
            works = [site.work for site in self.sites]
            works += [] if self.preparing is None else [self.preparing]
            self.sites, self.preparing = [], None
            problems = [self._closed(work, 0, None).problem for work in works]
            with suppress(Exception):
                self.client.unregister_worker_plugin(self.crew)
        for problem in problems:
            if problem is not None:
                raise problem

    def _collect(self) -> None:
        """Make workers hand back unfinished chunks, and keep what is in them."""
        with suppress(OSError, RuntimeError, TimeoutError):
            self.client.run(stop_crew, self.crew, on_error="ignore")
        for future, chunk in list(self.running.items()):
            with suppress(CancelledError, KilledWorker, RoomsegError, SceneError, OSError):
                self._keep(chunk, future.result(timeout=PATIENCE_S))
        self.running.clear()


def _place(job: Job) -> str:
    """The same for jobs that one process can do: all of a job but its seed."""
    return hashlib.sha256(replace(job, seed=0).to_json().encode()).hexdigest()


def _same(parcel: Parcel) -> Parcel:
    """Hand a parcel on; as a task, it outlives every worker."""
    return parcel
