"""Many maps by many workers: the same bytes, whoever dies meanwhile."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from distributed import Client
from test_job import TINY, make_map

import render
from dataset import FrameJournal, MapFile, RoomsegError
from render import Preset, Wanted, render_map
from render.pool import render_maps
from render.presets import Bake

ROOT = Path(render.__file__).parent.parent
BAKED = Preset("baked", 1, max_bounces=2, diffuse_bounces=0, bake=Bake(2, 0.4, 0.4, 0.4, 0.4))


def is_running(pid: int) -> bool:
    """Whether a process is there and no zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def children(pid: int) -> list[int]:
    """The living children of a process."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, parent = stat.read_text().rpartition(")")[2].split()[:2]
        except OSError:
            continue
        if int(parent) == pid and state != "Z":
            found.append(int(stat.parent.name))
    return found


def workers(pid: int) -> list[int]:
    """The Dask workers of a process: what it has spawned and what has rendered."""
    found = []
    for child in children(pid):
        command = Path(f"/proc/{child}/cmdline").read_bytes()
        if b"spawn_main" in command:
            found.append(child)
    return found


@contextmanager
def cluster() -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """A scheduler and two workers in processes of their own, as a user starts them.

    Yields the scheduler's address and process.
    """
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    here = ["--host", "127.0.0.1", "--no-dashboard"]
    dask = [sys.executable, "-m", "dask"]
    scheduler = subprocess.Popen(
        [*dask, "scheduler", *here, "--port", "0"], stderr=subprocess.PIPE, text=True, env=env
    )
    assert scheduler.stderr is not None
    address = next(line.split()[-1] for line in scheduler.stderr if "Scheduler at:" in line)
    alone = ["--nthreads", "1", "--no-nanny", "--memory-limit", "0"]
    started = [
        subprocess.Popen(
            [*dask, "worker", address, *here, *alone], stderr=subprocess.DEVNULL, env=env
        )
        for _ in range(2)
    ]
    try:
        yield address, scheduler
    finally:
        for process in (*started, scheduler):
            process.kill()
            process.wait()
        scheduler.stderr.close()


@pytest.fixture
def usual_ctrl_c() -> Iterator[None]:
    """As in a terminal; a background job of a shell is started with SIGINT ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A map rendered in one go by one process."""
    path = make_map(tmp_path_factory.mktemp("whole") / "map.h5")
    render_map(path, preset=TINY)
    return path.read_bytes()


def test_two_workers_make_the_same_bytes_of_two_maps(whole: bytes, tmp_path: Path) -> None:
    paths = [make_map(tmp_path / f"{name}.h5") for name in "ab"]
    shown: dict[Path, list[tuple[int, int]]] = {path: [] for path in paths}
    show = lambda path, *counts: shown[path].append(counts)  # noqa: E731
    outcomes = list(render_maps(paths, Wanted(TINY), jobs=2, show=show))
    assert sorted((o.path, o.count, o.problem) for o in outcomes) == [(p, 4, None) for p in paths]
    assert all(counts == [(i, 4) for i in range(5)] for counts in shown.values())
    assert [path.read_bytes() for path in paths] == [whole, whole]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.h5", "b.h5"]


def test_a_cluster_bakes_once_and_makes_the_same_bytes(tmp_path: Path) -> None:
    here = make_map(tmp_path / "here.h5")
    render_map(here, preset=BAKED)
    folder = tmp_path / "other"
    folder.mkdir()
    there = make_map(folder / "there.h5")
    told: list[str] = []
    with cluster() as (address, _):
        wanted = Wanted(BAKED)
        outcomes = list(
            render_maps([there], wanted, scheduler=address, tell=lambda _, line: told.append(line))
        )
    assert [(o.count, o.problem) for o in outcomes] == [(4, None)]
    assert [line for line in told if "baking" in line] == ["baking the light, once per apartment"]
    assert there.read_bytes() == here.read_bytes()
    assert len(list((folder / "bakes").iterdir())) == 1


def test_killed_workers_cost_their_chunks_only(whole: bytes, tmp_path: Path) -> None:
    paths = [make_map(tmp_path / f"{name}.h5") for name in "abc"]
    killed = 0

    def kill(path: Path, done: int, total: int) -> None:
        nonlocal killed
        for pid in workers(os.getpid())[:1] if done in (1, 3) and killed < 4 else []:
            os.kill(pid, signal.SIGKILL)
            killed += 1

    outcomes = list(render_maps(paths, Wanted(TINY), jobs=2, show=kill))
    assert killed >= 3
    assert [(o.count, o.problem) for o in outcomes] == [(4, None)] * 3
    assert [path.read_bytes() for path in paths] == [whole] * 3


def test_a_map_with_a_problem_does_not_stop_the_others(whole: bytes, tmp_path: Path) -> None:
    good, bad, taken = (make_map(tmp_path / f"{name}.h5") for name in ("good", "bad", "taken"))
    bad.write_bytes(b"no map")
    with FrameJournal(taken):
        outcomes = {o.path: o for o in render_maps([bad, taken, good], Wanted(TINY), jobs=2)}
    assert outcomes[good].problem is None
    assert good.read_bytes() == whole
    assert "another process" in str(outcomes[taken].problem)
    assert "bad.h5" in str(outcomes[bad].problem)


def test_stopped_it_keeps_what_was_rendered_and_leaves_nobody(whole: bytes, tmp_path: Path) -> None:
    path = make_map(tmp_path / "map.h5")

    def stop(_: Path, done: int, __: int) -> None:
        if done == 1:
            raise KeyboardInterrupt

    with (
        pytest.raises(KeyboardInterrupt),
        closing(render_maps([path], Wanted(TINY), jobs=2, show=stop)) as outcomes,
    ):
        list(outcomes)
    assert not workers(os.getpid())
    with MapFile(path) as file:
        assert file.done.any()
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["map.h5"]
    render_map(path, preset=TINY)
    assert path.read_bytes() == whole


def test_ctrl_c_in_a_destructor_is_not_lost(tmp_path: Path, usual_ctrl_c: None) -> None:
    path = make_map(tmp_path / "map.h5")

    class Interrupting:
        """As those of Dask's futures, in which Python loses a KeyboardInterrupt."""

        def __del__(self) -> None:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.01)

    def show(_: Path, done: int, __: int) -> None:
        if done == 1:
            Interrupting()

    with pytest.raises(KeyboardInterrupt):
        list(render_maps([path], Wanted(TINY), jobs=2, show=show))
    with MapFile(path) as file:
        assert file.done.any()


def test_nobody_outlives_a_killed_writer_and_the_next_goes_on(whole: bytes, tmp_path: Path) -> None:
    path = make_map(tmp_path / "map.h5")
    code = (
        "import sys, time; from pathlib import Path\n"
        "from render import Preset, Wanted; from render.pool import render_maps\n"
        "def show(_, done, __):\n"
        "    if done == 2: print('two', flush=True); time.sleep(60)\n"
        "if __name__ == '__main__':\n"
        "    list(render_maps([Path(sys.argv[1])], Wanted(Preset('tiny', 1)), jobs=2, show=show))"
    )
    script = tmp_path / "script.py"
    script.write_text(code)
    writer = subprocess.Popen(
        [sys.executable, str(script), str(path)],
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert writer.stdout is not None
    assert writer.stdout.readline() == b"two\n"
    family = workers(writer.pid)
    family += [child for pid in family for child in children(pid)]
    assert len(family) >= 3
    writer.kill()
    writer.communicate()
    end = time.monotonic() + 20.0
    while any(map(is_running, family)) and time.monotonic() < end:
        time.sleep(0.1)
    assert not any(map(is_running, family))
    assert [(o.count, o.problem) for o in render_maps([path], Wanted(TINY), jobs=2)] == [(2, None)]
    assert path.read_bytes() == whole


def test_a_lost_scheduler_is_one_line_and_loses_nothing(whole: bytes, tmp_path: Path) -> None:
    path = make_map(tmp_path / "map.h5")
    with cluster() as (address, scheduler):

        def show(_: Path, done: int, __: int) -> None:
            if done == 1:
                scheduler.kill()

        with pytest.raises(RoomsegError, match="the scheduler of Dask is lost") as caught:
            list(render_maps([path], Wanted(TINY), scheduler=address, show=show))
    assert "\n" not in str(caught.value)
    with MapFile(path) as file:
        assert 1 <= file.done.sum() < 4
    render_map(path, preset=TINY)
    assert path.read_bytes() == whole


def test_no_scheduler_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("render.cluster.PATIENCE_S", 1)
    for address in ("tcp://127.0.0.1:9", "nowhere", "ftp://127.0.0.1:9"):
        with pytest.raises(RoomsegError, match="no scheduler of Dask answers") as caught:
            list(render_maps([], Wanted(TINY), scheduler=address))
        assert "\n" not in str(caught.value)
        clients = [thing for thing in gc.get_objects() if isinstance(thing, Client)]
        # Closed by the garbage collector, one may keep the next from starting.
        assert all(client.status == "closed" for client in clients)
