"""A map's images: complete, resumable, one writer, one camera."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from probe import boxed_room

import render.job
from dataset import FormatError, FrameJournal, MapFile, RoomsegError, read_map, write_map
from dataset.camera import CameraFlaws, FisheyeCamera
from dataset.topomap import Nodes, Obstacles, TopoMap, Visits
from render import Preset, render_map
from render.lighting import missing_light
from render.presets import Bake
from render.process import Job, RenderProcess
from scenes import Apartment

TINY = Preset("tiny", samples=1)
N = 4


def make_map(
    path: Path,
    scene: str | None = None,
    poses: bool = True,
    camera: FisheyeCamera | None = None,
) -> Path:
    """A map of N nodes on a line through the boxed room, with a 32-pixel disc."""
    pose = np.column_stack([np.linspace(-1.0, 1.0, N), np.zeros(N), np.linspace(0.0, 1.0, N)])
    nodes = Nodes(
        pose[:, :2], pose[:, 2], np.zeros(N, int), np.zeros(N, int), pose if poses else None
    )
    nothing = np.zeros(0)
    topomap = TopoMap(
        environment="box",
        run="run1",
        seed=3,
        created="2025-01-01T00:00:00Z",
        software="test",
        nodes=nodes,
        edges=np.zeros((0, 2), int),
        visits=Visits(nothing.astype(int), nothing),
        obstacles=Obstacles(np.zeros((0, 2)), nothing, nothing.astype(np.uint8)),
        camera=camera or FisheyeCamera().resized(32),
        scene=boxed_room((0.0, 2.1)).model_dump_json() if scene is None else scene,
    )
    write_map(path, topomap)
    return path


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A map rendered in one go."""
    path = make_map(tmp_path_factory.mktemp("whole") / "map.h5")
    seen: list[tuple[int, int]] = []
    devices: list[str] = []
    count = render_map(
        path, preset=TINY, on_progress=lambda *a: seen.append(a), on_device=devices.append
    )
    assert count == N
    assert seen == [(i, N) for i in range(N + 1)]
    assert len(devices) == 1
    return path


def images(path: Path) -> list[tuple[bytes, float]]:
    with MapFile(path) as file:
        assert file.done.all()
        return [(file.image(i).tobytes(), file.gain(i)) for i in range(N)]


def test_every_node_has_an_exposed_image(whole: Path) -> None:
    assert len(set(images(whole))) == N
    with MapFile(whole) as file:
        for i in range(N):
            assert file.image(i).shape == (32, 32)
            assert file.gain(i) > 0.0
            assert 60 < file.image(i).mean() < 160
    assert "bpy" not in sys.modules


def test_in_pieces_equals_in_one_go(whole: Path, tmp_path: Path) -> None:
    path = make_map(tmp_path / "map.h5")
    seen: list[tuple[int, int]] = []
    assert render_map(path, preset=TINY, limit=2, on_progress=lambda *a: seen.append(a)) == 2
    assert seen == [(0, 2), (1, 2), (2, 2)]
    with MapFile(path) as file:
        assert file.done.tolist() == [True, True, False, False]
    assert render_map(path, preset=TINY, limit=9) == N - 2
    assert images(path) == images(whole)
    assert path.read_bytes() == whole.read_bytes()


def test_only_the_nodes_that_are_wanted(whole: Path, tmp_path: Path) -> None:
    path = make_map(tmp_path / "map.h5")
    seen: list[tuple[int, int]] = []
    progress = lambda *a: seen.append(a)  # noqa: E731
    assert render_map(path, preset=TINY, nodes=[3, 1, 3], on_progress=progress) == 2
    assert seen == [(0, 2), (1, 2), (2, 2)]
    with MapFile(path) as some, MapFile(whole) as every:
        assert some.done.tolist() == [False, True, False, True]
        assert some.image(3).tobytes() == every.image(3).tobytes()
    assert render_map(path, preset=TINY, nodes=[1]) == 0


def test_a_finished_map_starts_no_blender(whole: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(render.job, "RenderProcess", None)
    assert render_map(whole, preset=TINY) == 0


def test_another_preset_or_disc_is_refused(whole: Path) -> None:
    with pytest.raises(FormatError, match="tiny"):
        render_map(whole, preset=Preset("other", samples=1))
    with pytest.raises(FormatError, match="32 px disc"):
        render_map(whole, preset=Preset("tiny", samples=1, disc_diameter=48))


def test_a_preset_with_a_disc_of_its_own_changes_the_maps_camera(tmp_path: Path) -> None:
    path = make_map(tmp_path / "map.h5")
    assert render_map(path, preset=Preset("tiny", samples=1, disc_diameter=24), limit=1) == 1
    assert read_map(path).camera == FisheyeCamera().resized(24)
    with MapFile(path) as file:
        assert file.image(0).shape == (24, 24)


def test_a_second_writer_is_refused(tmp_path: Path) -> None:
    path = make_map(tmp_path / "map.h5")
    with FrameJournal(path), pytest.raises(RoomsegError, match="another process"):
        render_map(path, preset=TINY)


class _Fake:
    """Stands in for the child process; fails at the third frame."""

    device = "CPU"

    def __init__(self, job: Job, on_bake: object = None) -> None:
        self.size = job.camera.image_size

    def __enter__(self) -> _Fake:
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def frames(self, indices: list[int], poses: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
        for index in indices[:2]:
            yield index, np.full(self.size, 1.0, dtype=np.float32)
        raise KeyboardInterrupt


def test_an_interrupt_keeps_what_is_finished(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = make_map(tmp_path / "map.h5")
    monkeypatch.setattr(render.job, "RenderProcess", _Fake)
    with pytest.raises(KeyboardInterrupt):
        render_map(path, preset=TINY)
    with MapFile(path) as file:
        assert file.done.tolist() == [True, True, False, False]
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["map.h5"]


def test_sigint_in_the_middle_then_resume(whole: Path, tmp_path: Path) -> None:
    path = make_map(tmp_path / "map.h5")
    # A background job of a shell is started with SIGINT ignored.
    code = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "import sys, time; from render import Preset, render_map\n"
        "def wait(done, total):\n"
        "    print(done, flush=True)\n"
        "    if done == 1: time.sleep(60)\n"
        "render_map(sys.argv[1], preset=Preset('tiny', samples=1), on_progress=wait)"
    )
    root = str(Path(render.__file__).parent.parent)
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": root},
    )
    assert process.stdout is not None
    assert process.stdout.readline() == b"0\n"
    assert process.stdout.readline() == b"1\n"
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert b"KeyboardInterrupt" in errors
    with MapFile(path) as file:
        assert file.done.tolist() == [True, False, False, False]
    render_map(path, preset=TINY)
    assert images(path) == images(whole)


def is_running(pid: int) -> bool:
    """Whether a process is there and no zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_the_child_does_not_outlive_a_killed_caller(tmp_path: Path) -> None:
    room, camera, slow = boxed_room((0.0, 2.1)), FisheyeCamera(), Preset("slow", samples=4000)
    code = (
        "import numpy as np, sys, time; from render.process import Job, RenderProcess\n"
        "process = RenderProcess(Job.from_json(sys.argv[1]))\n"
        "process._ask(0, np.zeros((1, 3)))\n"
        "print(process._child.pid, flush=True); time.sleep(60)"
    )
    root = str(Path(render.__file__).parent.parent)
    caller = subprocess.Popen(
        [sys.executable, "-c", code, Job(room, camera, slow, 1).to_json()],
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": root, "TMPDIR": str(tmp_path)},
    )
    assert caller.stdout is not None
    child = int(caller.stdout.readline())
    caller.kill()
    caller.communicate()
    end = time.monotonic() + 10.0
    while is_running(child) and time.monotonic() < end:
        time.sleep(0.05)
    assert not is_running(child)
    assert not list(tmp_path.iterdir())


def test_a_killed_child_leaves_no_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with RenderProcess(Job(boxed_room((0.0, 2.1)), FisheyeCamera().resized(16), TINY)) as process:
        assert [path.name[:15] for path in tmp_path.iterdir()] == ["roomseg-render-"]
        process._child.kill()
        with pytest.raises(RoomsegError, match="ended with -9"):
            list(process.frames([0], np.zeros((1, 3))))
    assert not list(tmp_path.iterdir())


def test_baked_light_is_shared_and_may_be_deleted(tmp_path: Path) -> None:
    preset = Preset("tiny", 1, max_bounces=2, diffuse_bounces=0, bake=Bake(2, 0.4, 0.4, 0.4, 0.4))
    path, other = make_map(tmp_path / "map.h5"), make_map(tmp_path / "other.h5")
    told: list[str] = []
    assert render_map(path, preset=preset, limit=2, on_bake=lambda: told.append("once")) == 2
    (stored,) = (tmp_path / "bakes").iterdir()
    light, made = stored.read_bytes(), stored.stat().st_mtime_ns
    assert render_map(other, preset=preset, on_bake=lambda: told.append("twice")) == N
    assert told == ["once"]
    assert stored.stat().st_mtime_ns == made
    stored.unlink()
    assert render_map(path, preset=preset) == N - 2
    assert stored.read_bytes() == light
    assert images(path) == images(other)


def test_maps_without_scene_or_poses_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"/nodes/true_pose: missing"):
        render_map(make_map(tmp_path / "a.h5", poses=False), preset=TINY)
    with pytest.raises(FormatError, match="/scene: name: missing"):
        render_map(make_map(tmp_path / "b.h5", scene="{}"), preset=TINY)


def lit(
    windows: bool = True,
    lamps: bool = True,
    source: str = "exterior",
    sky: float = 1,
    sun: float = 0,
) -> Apartment:
    """The boxed room in another light."""
    place = boxed_room((0.0, 2.1), source).model_dump()
    place["lighting"] |= {"sky_strength": float(sky), "sun_strength": float(sun)}
    for field, kept in (("windows", windows), ("lamps", lamps)):
        place[field] = place[field] if kept else ()
    return Apartment.model_validate(place)


@pytest.mark.parametrize(
    ("place", "right"),
    [
        (lit(windows=False), "'exterior': nothing gives light; expected `windows`.* or `lamps`"),
        (lit(windows=False, lamps=False), "expected `windows` to the outside; or `lamps`"),
        (lit(windows=False, lamps=False, source="mixed"), "expected `lamps` or `windows`"),
        (lit(lamps=False, source="interior"), "expected `lamps`; or `windows`"),
        (lit(sky=0), "expected a `sky_strength` above 0, or a sun"),
    ],
)
def test_the_dark_is_refused(tmp_path: Path, place: Apartment, right: str) -> None:
    path = make_map(tmp_path / "map.h5", scene=place.model_dump_json())
    with pytest.raises(FormatError, match=rf"map.h5: /scene: lighting.source .*{right}") as dark:
        render_map(path, preset=TINY)
    assert "\n" not in str(dark.value)


def test_one_light_is_enough() -> None:
    assert missing_light(lit(windows=False, source="interior")) is None
    assert missing_light(lit(windows=False, source="mixed")) is None
    assert missing_light(lit(lamps=False)) is None
    assert missing_light(lit(lamps=False, sky=0, sun=1)) is None


def test_a_disc_between_pixels_is_refused(tmp_path: Path) -> None:
    path = make_map(tmp_path / "map.h5", camera=FisheyeCamera(disc_centre=(232.3, 232.0)))
    with pytest.raises(FormatError, match="/camera: disc_centre"):
        render_map(path, preset=TINY)


def test_an_unknown_material_is_one_line(tmp_path: Path) -> None:
    room = boxed_room((0.0, 2.1))
    odd = room.rooms[0].model_copy(update={"floor": "moss"})
    scene = room.model_copy(update={"rooms": (odd,)}).model_dump_json()
    with pytest.raises(RoomsegError, match="'moss'") as caught:
        render_map(make_map(tmp_path / "map.h5", scene=scene), preset=TINY)
    assert "\n" not in str(caught.value)


def test_an_error_in_the_child_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    job = Job(boxed_room((0.0, 2.1)), FisheyeCamera().resized(16), TINY, device="gpu")
    with pytest.raises(RoomsegError) as caught:
        RenderProcess(job)
    assert "\n" not in str(caught.value)


def test_a_child_that_dies_is_an_error(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "bpy.py").write_text("raise ImportError('libXi.so.6: cannot open shared object')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("PYTHONSAFEPATH", "1")
    job = Job(boxed_room((0.0, 2.1)), FisheyeCamera().resized(16), TINY)
    with pytest.raises(RoomsegError, match="libxi6"):
        RenderProcess(job)


def test_a_job_survives_its_line() -> None:
    flaws = CameraFlaws(0.3, 0.5, 9000.0, 15.0)
    camera = FisheyeCamera(3.2, 450.0, (512, 640), (256.0, 320.0), 0.08, flaws)
    job = Job(boxed_room((0.0, 2.1)), camera, TINY, 2, "cpu", 9)
    assert Job.from_json(job.to_json()) == job
    assert "\n" not in job.to_json()
