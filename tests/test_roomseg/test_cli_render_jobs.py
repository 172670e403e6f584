"""`roomseg render --jobs`: what a user sees when something goes wrong, and that nothing is lost."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

import roomseg
from dataset import MapFile, read_map, write_map
from dataset.camera import FisheyeCamera
from dataset.journal import journal_path
from dataset.topomap import Nodes, Obstacles, TopoMap, Visits
from roomseg.cli.main import main
from scenes import load_apartment

ROOT = Path(roomseg.__file__).parent.parent
NODES = 12


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A map in demo3 with a 48-pixel disc: the robot turns where it starts."""
    path = tmp_path_factory.mktemp("bare") / "map.h5"
    place, count = load_apartment("demo3"), 2 * NODES + 6
    heading = np.linspace(0.0, 6.0, count)
    pose = np.column_stack([np.tile(place.start.position, (count, 1)), heading])
    zeros, nothing = np.zeros(count, int), np.zeros(0)
    topomap = TopoMap(
        environment="demo3",
        run="run1",
        seed=1,
        created="1970-01-01T00:00:00Z",
        software="test",
        nodes=Nodes(pose[:, :2], heading, zeros, zeros, pose),
        edges=np.zeros((0, 2), int),
        visits=Visits(nothing.astype(int), nothing),
        obstacles=Obstacles(np.zeros((0, 2)), nothing, nothing.astype(np.uint8)),
        camera=FisheyeCamera().resized(48),
        scene=place.model_dump_json(),
    )
    write_map(path, topomap)
    return path


@pytest.fixture
def path(bare: Path, tmp_path: Path) -> Path:
    copy = tmp_path / "map.h5"
    copy.write_bytes(bare.read_bytes())
    return copy


def begin(path: Path, *options: str, size: int | None = None) -> subprocess.Popen[str]:
    """Render some nodes with two workers; no file may grow larger than ``size``."""

    def limit() -> None:
        if size is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        signal.signal(signal.SIGINT, signal.default_int_handler)

    command = [sys.executable, "-m", "roomseg.cli", "render", str(path), "--preset", "quick"]
    command += ["--jobs", "2", "--limit", str(NODES), *options]
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=env,
        preexec_fn=limit,  # noqa: PLW1509
        start_new_session=True,
    )


def images(path: Path) -> list[bytes]:
    with MapFile(path) as file:
        return [file.image(int(i)).tobytes() for i in file.done.nonzero()[0]]


def errors(stderr: str) -> list[str]:
    """What is said, but for the bar and the device."""
    return [line for line in stderr.splitlines() if line.startswith("roomseg: ")]


@pytest.fixture(scope="module")
def undisturbed(bare: Path, tmp_path_factory: pytest.TempPathFactory) -> list[bytes]:
    copy = tmp_path_factory.mktemp("whole") / "map.h5"
    copy.write_bytes(bare.read_bytes())
    assert main(["render", str(copy), "--preset", "quick", "--limit", str(NODES)]) == 0
    return images(copy)


def finish(path: Path, undisturbed: list[bytes]) -> None:
    """Render what is missing of the first nodes; the images must be those of an undisturbed job."""
    left = NODES - len(images(path))
    if left:
        command = ["render", str(path), "--preset", "quick", "--limit", str(left)]
        assert main(command) == 0
    assert set(undisturbed) <= set(images(path))


def test_a_full_disk_is_one_line_and_loses_nothing(path: Path, undisturbed: list[bytes]) -> None:
    before = path.read_bytes()
    process = begin(path, size=4000)
    _, err = process.communicate(timeout=300)
    assert process.returncode == 2, err
    assert len(errors(err)) == 1
    assert "cannot be written: File too large" in errors(err)[0]
    assert "Traceback" not in err
    assert path.read_bytes() == before
    assert journal_path(path).stat().st_size > 1000
    finish(path, undisturbed)


def test_a_map_opened_by_someone_else_is_one_line(path: Path, undisturbed: list[bytes]) -> None:
    process = begin(path)
    while not journal_path(path).exists():
        assert process.poll() is None
        time.sleep(0.02)
    with h5py.File(path, "r+"):
        _, err = process.communicate(timeout=300)
        assert process.returncode == 2, err
        assert len(errors(err)) == 1 and "map.h5" in errors(err)[0]
        assert "Traceback" not in err
        # From outside: one process may open a file twice.
        again = begin(path)
        _, err = again.communicate(timeout=300)
        assert again.returncode == 2 and len(errors(err)) == 1, err
    finish(path, undisturbed)


def test_ctrl_c_packs_what_there_is(path: Path, undisturbed: list[bytes]) -> None:
    process = begin(path, "--threads", "1")
    while not journal_path(path).exists():
        assert process.poll() is None
        time.sleep(0.02)
    begun = time.monotonic()
    # As a terminal does: to everyone of the foreground.
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=120)
    assert process.returncode == 130, err
    assert errors(err) == ["roomseg: stopped; call it again to go on"]
    assert "Traceback" not in err
    assert time.monotonic() - begun < 60.0
    assert not journal_path(path).exists()
    assert images(path)
    finish(path, undisturbed)


def test_two_ways_at_once_are_refused(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", str(path), "--jobs", "2", "--scheduler", "tcp://127.0.0.1:9"]) == 2
    assert "--scheduler" in capsys.readouterr().err
    assert len(read_map(path).nodes) > NODES
