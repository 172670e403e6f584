"""Scenes of our own and of any other make become apartments; what is in them never runs."""

from __future__ import annotations

import hashlib
import os
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scene_makers
import shapely
import trimesh
from scene_makers import read_contents
from shapely import Polygon, affinity

from dataset import RoomsegError
from dataset.camera import FisheyeCamera
from render import Preset
from render.process import Job, RenderProcess
from render.scene_export import write_scene
from render.scene_import import read_scene
from scenes import Apartment, SceneError, check, floor_region, load_apartment, obstacles
from scenes.solids import building_region, polygons

SMALL = FisheyeCamera().resized(48)
CENTIMETRE = 0.01


@pytest.fixture(scope="module")
def foreign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of `scene_makers`."""
    folder = tmp_path_factory.mktemp("foreign")
    scene_makers.run(folder)
    return folder


def free_of(apartment: Apartment) -> shapely.Geometry:
    return floor_region(apartment).difference(obstacles(apartment))


def around_start(region: shapely.Geometry, apartment: Apartment) -> shapely.Polygon:
    start = shapely.Point(apartment.start.position)
    return next(part for part in polygons(region) if part.intersects(start))


def is_near(first: shapely.Geometry, second: shapely.Geometry, reach: float) -> bool:
    """Whether no point of either region's outline is farther than ``reach`` from the other's."""
    return float(first.boundary.hausdorff_distance(second.boundary)) <= reach


def picture(
    apartment: Apartment,
    folder: Path,
    pose: tuple[float, float, float],
    camera: FisheyeCamera = SMALL,
    samples: int = 4,
) -> np.ndarray:
    job = Job(apartment, camera, Preset("test", samples=samples), 2, "cpu", 0, str(folder))
    with RenderProcess(job) as process:
        return next(process.frames([0], np.array([pose])))[1]


# ---- our own --------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def returned(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, Apartment]]:
    """Places that were exported and imported again: the folder, and what came back."""
    made = {}
    for name, suffix in (("sim3", ".blend"), ("sim4", ".glb")):
        folder, place = tmp_path_factory.mktemp(name), load_apartment(name)
        write_scene(place, folder / f"{name}{suffix}")
        found = read_scene(folder / f"{name}{suffix}", folder, start=place.start.position)
        made[name] = (folder, found.apartment)
    return made


@pytest.mark.parametrize("name", ["sim3", "sim4"])
def test_a_round_trip_keeps_the_obstacles(
    name: str, returned: dict[str, tuple[Path, Apartment]]
) -> None:
    place, found = load_apartment(name), returned[name][1]
    assert not list(check(found))
    # The recess before a closed door is no floor of ours, but nothing stands there either.
    # Where ours touch each other, rounding leaves slits that are no wider than that.
    ours = building_region(place).difference(obstacles(place))
    ours = around_start(shapely.set_precision(ours, 1e-6), place)
    assert is_near(ours, around_start(free_of(found), place), CENTIMETRE)
    assert found.rooms[0].ceiling_height in {room.ceiling_height for room in place.rooms}


def test_a_scene_that_went_to_blender_and_back_looks_the_same(
    returned: dict[str, tuple[Path, Apartment]],
) -> None:
    place, (folder, found) = load_apartment("sim3"), returned["sim3"]
    pose = (6.5, 1.5, 0.3)
    camera = FisheyeCamera().resized(64)
    first, second = (
        np.log(picture(each, folder, pose, camera, 16) + 1e-3) for each in (place, found)
    )
    inside = camera.pixel_zenith() < 1.6
    # Two seeds of one scene differ by as much: 0.07 and 0.98 with twice as many pixels.
    assert np.median(np.abs(first - second)[inside]) < 0.12
    assert np.corrcoef(first[inside], second[inside])[0, 1] > 0.94


# ---- of any make ----------------------------------------------------------------------------


def house_floor() -> shapely.Geometry:
    """Free floor of the house, from the measures that it was built by."""
    width, depth = scene_makers.SIZE
    half = scene_makers.WALL_THICKNESS / 2
    x = scene_makers.WALL_X
    solid = [
        shapely.box(x - half, low, x + half, high)
        for low, high in ((0.0, scene_makers.DOOR[0]), (scene_makers.DOOR[1], depth))
    ]
    place, (w, d), turn = scene_makers.WARDROBE
    solid.append(put(shapely.box(-w / 2, -d / 2, w / 2, d / 2), *place, turn))
    place, radius = scene_makers.COLUMN
    solid.append(shapely.Point(place).buffer(radius, quad_segs=12))
    half = scene_makers.LEG / 2
    for chair in scene_makers.CHAIRS:
        for x, y in scene_makers.LEGS:
            solid.append(put(shapely.box(x - half, y - half, x + half, y + half), *chair))
    return shapely.box(0.0, 0.0, width, depth).difference(shapely.union_all(solid))


def put(shape: shapely.Geometry, x: float, y: float, turn: float) -> shapely.Geometry:
    return affinity.translate(affinity.rotate(shape, turn, origin=(0, 0)), x, y)


@pytest.mark.parametrize(
    ("file", "scale", "lamps"),
    [
        ("house.blend", None, 0),
        ("house.gltf", None, 4),
        ("house.obj", 0.001, 4),
        ("house.usdc", None, 0),
    ],
)
def test_a_house_of_loose_planes_and_instances(
    foreign: Path, tmp_path: Path, file: str, scale: float | None, lamps: int
) -> None:
    found = read_scene(foreign / "scenes" / file, tmp_path, scale=scale)
    place = found.apartment
    assert not list(check(place))
    assert is_near(free_of(place), house_floor(), CENTIMETRE)
    # Under a pitched roof, from 2.2 m at the eaves to 3.2 m.
    assert 2.5 < place.rooms[0].ceiling_height < 2.9
    assert bool(place.lamps) == bool(lamps)
    assert any("no light" in note for note in found.notes) == bool(lamps)
    assert place.scene_file is not None
    assert [item.name for item in tmp_path.iterdir()] == [place.scene_file.file]
    assert place.scene_file.file == f"house-{place.scene_file.sha256[:8]}.blend"


def test_copies_by_nodes_mirrored_and_sheared_solids_and_curves(
    foreign: Path, tmp_path: Path
) -> None:
    found = read_scene(foreign / "scenes" / "workshop.blend", tmp_path).apartment
    half = 0.2 * np.sqrt(2.0)
    solid = [
        *(shapely.box(x - 0.1, 0.9, x + 0.1, 1.1) for x in (1, 2, 3)),
        Polygon([(5 - 2 * half, 4), (5, 4 - half), (5 + 2 * half, 4), (5, 4 + half)]),
        shapely.box(7.0, 1.0, 7.5, 1.3),
        shapely.box(2.0, 2.98, 3.0, 3.02),
    ]
    wanted = shapely.box(0, 0, 8, 6).difference(shapely.union_all(solid))
    assert is_near(free_of(found), wanted, CENTIMETRE)


def test_what_cannot_be_used_is_said(foreign: Path, tmp_path: Path) -> None:
    found = read_scene(foreign / "scenes" / "odd.blend", tmp_path, name="my-house")
    assert found.apartment.name == "my-house"
    assert found.apartment.scene_file is not None
    assert found.apartment.scene_file.file.startswith("my-house-")
    notes = "\n".join(found.notes)
    for name, why in {
        "mesh 'hidden'": "hidden",
        "curve 'line'": "no surface",
        "empty 'nothing'": "nothing to see",
        "volume 'smoke'": "left out",
        "image 'gone'": "is missing",
        "image 'outside'": "outside of the scene's folder",
        "image 'tiles'": "outside of the scene's folder",
    }.items():
        assert any(line.startswith(name) and why in line for line in notes.splitlines()), notes
    assert is_near(free_of(found.apartment), house_floor(), CENTIMETRE)


def test_the_unit_is_asked_for_with_a_proposal(foreign: Path, tmp_path: Path) -> None:
    with pytest.raises(RoomsegError, match=r"does not say its unit; expected --scale") as caught:
        read_scene(foreign / "scenes" / "house.obj", tmp_path)
    assert "such as 0.001 for mm (the scene would be 3.2 m high)" in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_a_glb_in_millimetres_is_found_out(tmp_path: Path) -> None:
    box = trimesh.creation.box(bounds=[(0, 0, 0), (5000, 2500, 4000)])
    trimesh.Scene(box).export(tmp_path / "mm.glb")
    with pytest.raises(RoomsegError, match=r"would be 2.5e\+03 m high; expected --scale.*0.001"):
        read_scene(tmp_path / "mm.glb", tmp_path)
    found = read_scene(tmp_path / "mm.glb", tmp_path, scale=0.001).apartment
    assert is_near(free_of(found), shapely.box(0, -4, 5, 0), CENTIMETRE)
    assert len(found.lamps) > 0


def test_start_floor_and_slab_are_choices(foreign: Path, tmp_path: Path) -> None:
    house = foreign / "scenes" / "house.blend"
    found = read_scene(house, tmp_path, start=(7.0, 2.5), floor_clearance=0.43, robot_height=0.45)
    assert found.apartment.start.position == (7.0, 2.5)
    x, y, _ = scene_makers.CHAIRS[0]
    assert not free_of(found.apartment).intersects(shapely.Point(x, y))
    with pytest.raises(SceneError, match=r"start: \(1.2, 3.6\) has no free floor"):
        read_scene(house, tmp_path, start=scene_makers.WARDROBE[0])
    with pytest.raises(SceneError, match="nowhere: cannot be written: No such file"):
        read_scene(house, tmp_path / "nowhere")
    with pytest.raises(SceneError, match="expected 0 <= floor clearance < robot height"):
        read_scene(house, tmp_path, floor_clearance=0.2)


# ---- nothing runs ---------------------------------------------------------------------------


def test_scripts_in_a_scene_never_run(foreign: Path, tmp_path: Path) -> None:
    marker = foreign / "marker"
    evil = foreign / "scenes" / "evil.blend"
    # They do run where they are trusted, or this test would show nothing.
    assert not marker.exists()
    scene_makers.run(foreign, "trust", evil)
    assert marker.exists()
    marker.unlink()

    found = read_scene(evil, tmp_path)
    assert not marker.exists()
    notes = "\n".join(found.notes)
    assert "text 'startup.py': scripts are never run" in notes
    assert notes.count("drivers are not run") == 5
    assert "node 'Script' runs code" in notes
    assert is_near(free_of(found.apartment), house_floor(), CENTIMETRE)

    image = picture(found.apartment, tmp_path, (2.5, 2.5, 0.0))
    assert image.max() > 0.0
    assert not marker.exists()

    assert found.apartment.scene_file is not None
    kept = tmp_path / found.apartment.scene_file.file
    content = read_contents(foreign, kept)
    assert not content["texts"]
    assert content["drivers"] == 0
    assert "ShaderNodeScript" not in content["nodes"]
    scene_makers.run(foreign, "trust", kept)
    assert not marker.exists()


@contextmanager
def listening(pipe: Path) -> Iterator[list[str]]:
    """A named pipe; the list says whether anybody opened it, and nobody hangs on it."""
    os.mkfifo(pipe)
    readers: list[str] = []
    done = threading.Event()

    def watch() -> None:
        while not done.wait(0.01):
            with suppress(OSError):  # as long as nobody reads
                os.close(os.open(pipe, os.O_WRONLY | os.O_NONBLOCK))
                readers.append("somebody")

    thread = threading.Thread(target=watch)
    thread.start()
    try:
        yield readers
    finally:
        done.set()
        thread.join()
        pipe.unlink()


def test_other_files_are_not_read_while_a_scene_is_opened(foreign: Path, tmp_path: Path) -> None:
    nosy = foreign / "scenes" / "nosy.blend"
    with listening(foreign / "pipe") as readers:
        scene_makers.run(foreign, "trust", nosy)
        assert readers  # or this test would show nothing
        readers.clear()
        found = read_scene(nosy, tmp_path)
        place = named_by(nosy, tmp_path)
        assert picture(place, tmp_path, (2.5, 2.5, 0.0)).max() > 0.0
        assert not readers
    assert is_near(free_of(found.apartment), house_floor(), CENTIMETRE)
    notes = "\n".join(found.notes)
    for said in ("scene 'a second'", "modifier 'cache'", "'Import OBJ'", "image 'noise'"):
        assert said in notes


def named_by(scene: Path, folder: Path) -> Apartment:
    """An apartment whose file names a scene of somebody else, copied to ``folder``."""
    (folder / scene.name).write_bytes(scene.read_bytes())
    digest = hashlib.sha256(scene.read_bytes()).hexdigest()
    fields: dict[str, Any] = load_apartment("sim3").model_dump(mode="json")
    fields["scene_file"] = {"file": scene.name, "sha256": digest}
    return Apartment.model_validate(fields)


def test_the_evil_scene_itself_is_rendered_without_running_it(
    foreign: Path, tmp_path: Path
) -> None:
    """As from a map that names a file of somebody else."""
    place = named_by(foreign / "scenes" / "evil.blend", tmp_path)
    assert picture(place, tmp_path, (2.5, 2.5, 0.0)).max() > 0.0
    assert not (foreign / "marker").exists()


def test_data_of_other_files_is_refused(foreign: Path, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"links data of other files \(.*house.blend\)"):
        read_scene(foreign / "scenes" / "linking.blend", tmp_path)
    place = named_by(foreign / "scenes" / "linking.blend", tmp_path)
    with pytest.raises(RoomsegError, match=r"links data of other files \(.*house.blend\)"):
        picture(place, tmp_path, (2.5, 2.5, 0.0))


# ---- nonsense -------------------------------------------------------------------------------


def refused(path: Path, folder: Path) -> str:
    """The one line that a file is refused with; nothing is left behind."""
    before = sorted(folder.iterdir())
    with pytest.raises((SceneError, RoomsegError)) as caught:
        read_scene(path, folder, scale=1.0)
    assert sorted(folder.iterdir()) == before
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(str(path))
    return line


@pytest.mark.parametrize("suffix", [".blend", ".glb", ".gltf", ".obj", ".usd", ".usdz", ".stl"])
def test_nonsense_is_one_line(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"nonsense{suffix}"
    path.write_bytes(os.urandom(50_000_000 if suffix in (".blend", ".glb") else 100_000))
    refused(path, tmp_path)


@pytest.mark.parametrize("file", ["house.blend", "house.usdc", "house.glb"])
def test_a_file_that_is_cut_short_is_one_line(foreign: Path, tmp_path: Path, file: str) -> None:
    whole = foreign / "scenes" / file
    if file == "house.glb":
        trimesh.Scene(trimesh.creation.box((4, 4, 3))).export(whole)
    path = tmp_path / file
    path.write_bytes(whole.read_bytes()[: whole.stat().st_size * 2 // 3])
    assert "cut short" in refused(path, tmp_path)


def test_a_sound_head_with_nonsense_behind_it_is_one_line(foreign: Path, tmp_path: Path) -> None:
    data = bytearray(trimesh.Scene(trimesh.creation.box((4, 4, 3))).export(file_type="glb"))
    data[-40:] = os.urandom(40)
    start = data.index(b'"bufferViews"')
    data[start : start + 13] = b'"bufferVoews"'
    (tmp_path / "odd.glb").write_bytes(data)
    assert "Blender cannot read it" in refused(tmp_path / "odd.glb", tmp_path)


@pytest.mark.parametrize(
    ("death", "status"), [("raise RuntimeError('no')", 1), ("os.kill(os.getpid(), 9)", -9)]
)
def test_a_child_that_dies_is_one_line_and_leaves_nothing(
    foreign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, death: str, status: int
) -> None:
    (tmp_path / "bpy.py").write_text(f"import os, tempfile\ntempfile.mkstemp()\n{death}")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    with pytest.raises(RoomsegError, match=f"the process ended with {status}"):
        read_scene(foreign / "scenes" / "house.blend", tmp_path)
    assert not list(folder.iterdir())
    assert sorted(item.suffix for item in tmp_path.iterdir()) == ["", ".py"]
