"""One cleaning run of `roomseg simulate`: simulate it, or recognise its map that is there."""

from __future__ import annotations

import os
import traceback
import zlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from dataset import FisheyeCamera, TopoMap
    from scenes import Apartment
    from simulator import CoverageReport, RobotSpec, SensorSpec

    Show = Callable[[int, float], None]
    """Told the nodes and the simulated seconds."""

__all__ = ["Outcome", "Run", "attempt", "lost", "recognise", "run_seed"]


@dataclass(frozen=True)
class Run:
    """One cleaning run to be simulated, as it is sent to another process.

    ``apartment`` is a file or the name of a reference place; ``start`` is x m, y m and the
    heading in rad, or "random": drawn from the seed; by default the apartment's own.
    """

    apartment: str
    name: str
    seed: int
    created: str
    output: Path
    robot: RobotSpec
    sensor: SensorSpec
    camera: FisheyeCamera
    start: tuple[float, float, float] | Literal["random"] | None = None


@dataclass(frozen=True)
class Outcome:
    """What became of a run: its report, or one line on why there is no map."""

    output: Path
    report: CoverageReport | None = None
    problem: str | None = None
    trace: str | None = None
    """Where in the program it happened, if the problem is not the user's."""


def run_seed(seed: int, name: str, number: int) -> int:
    """Seed of one run in the apartment of that name.

    Independent of the other runs, of how many there are, and of those in other apartments.
    """
    entropy = [seed, zlib.crc32(name.encode()), number]
    return int(np.random.SeedSequence(entropy).generate_state(1)[0])


def attempt(run: Run, show: Show | None = None) -> Outcome:
    """Simulate one run and write its map; whatever goes wrong must not stop the others."""
    return _outcome(run, lambda: _simulate(run, show))


def recognise(run: Run, *, judged: bool) -> Outcome:
    """Make sure that the map that is there is the one of the run; report on it if ``judged``."""

    def look() -> CoverageReport | None:
        from dataset import MapFile

        with MapFile(run.output) as file:
            topomap, camera = file.topomap, file.own_camera
        place = _place(run, checked=False)
        _check_same(run, topomap, place, camera)
        return _report(run, topomap, place) if judged else None

    return _outcome(run, look)


def _outcome(run: Run, work: Callable[[], CoverageReport | None]) -> Outcome:
    """Do some work; its report, or what was wrong."""
    from dataset import RoomsegError
    from scenes import SceneError

    try:
        return Outcome(run.output, work())
    except SceneError as error:
        return Outcome(run.output, problem=str(error))
    except OSError as error:
        return Outcome(run.output, problem=f"{error.filename or run.output}: {error.strerror}")
    except RoomsegError as error:
        named = str(error).startswith((f"{run.output}: ", f"{run.output.parent}: "))
        return Outcome(run.output, problem=str(error) if named else f"{run.output}: {error}")
    except Exception as error:
        problem = f"{run.output}: unexpected {type(error).__name__}: {error}"
        return Outcome(run.output, problem=problem, trace=traceback.format_exc())


def lost(run: Run) -> Outcome:
    """What became of a run over which a process died twice."""
    return Outcome(run.output, problem=f"{run.output}: its process died; is there enough memory?")


def _place(run: Run, *, checked: bool) -> Apartment:
    """The apartment of a run; its own 3D scene, if it has one, is put beside the maps."""
    from dataset import RoomsegError
    from scenes import load_apartment
    from scenes.scene_file import take_scene_file

    place, folder = load_apartment(run.apartment, checked=checked), run.output.parent
    folder.mkdir(parents=True, exist_ok=True)
    if not os.access(folder, os.W_OK):
        raise RoomsegError(f"{folder}: not writable, expected a folder for the maps")
    take_scene_file(place, Path(run.apartment).parent, folder)
    return place


def _simulate(run: Run, show: Show | None) -> CoverageReport:
    """Simulate one run, write its map, and report on it."""
    from dataset import discard_frames, write_map
    from dataset.journal import journal_path
    from roomseg.ground_truth import label_rooms
    from scenes.rooms import room_of_each
    from simulator import simulate

    place = _place(run, checked=True)
    topomap = simulate(
        place,
        run=run.name,
        seed=run.seed,
        start=_start(run, place),
        robot=run.robot,
        sensor=run.sensor,
        camera=run.camera,
        created=run.created,
        progress=show,
    )
    report = _report(run, topomap, place)
    assert topomap.nodes.true_pose is not None
    inside = room_of_each(place, topomap.nodes.true_pose[:, :2])
    topomap = label_rooms(topomap, room_of_node=inside)
    if journal_path(run.output).exists():
        # Frames of the map that is being replaced would not fit the new one.
        discard_frames(run.output)
    write_map(run.output, topomap)
    return report


def _start(run: Run, place: Apartment) -> tuple[float, float, float]:
    """The pose to begin at."""
    from simulator import base_pose, random_start

    if run.start is None:
        return base_pose(place, run.robot)
    if run.start != "random":
        return run.start
    return random_start(place, run.robot, np.random.default_rng([run.seed, 1]))


def _report(run: Run, topomap: TopoMap, place: Apartment) -> CoverageReport:
    from simulator import coverage_report

    return coverage_report(topomap, place, lane_spacing=run.robot.lane_spacing)


def _same_pose(a: Sequence[float], b: Sequence[float]) -> bool:
    """Whether two poses agree but for rounding; a full turn makes no difference."""
    turn = np.angle(np.exp(1j * (a[2] - b[2])))
    return bool(np.hypot(a[0] - b[0], a[1] - b[1]) < 1e-6 and abs(turn) < 1e-6)


def _check_same(run: Run, topomap: TopoMap, place: Apartment, camera: FisheyeCamera) -> None:
    """Refuse to take the map of another apartment or seed for the one that is wanted."""
    from dataset import RoomsegError
    from simulator import settings_of

    start = _start(run, place)
    begin = None if topomap.path is None else topomap.path.true_pose[0]
    same = {
        "apartment": topomap.scene == place.model_dump_json(),
        "seed": topomap.seed == run.seed,
        "robot": topomap.robot == settings_of(run.robot),
        "robot's sensors": topomap.sensor == settings_of(run.sensor),
        "camera": camera == replace(run.camera, height=run.sensor.camera_height),
        "start": begin is None or _same_pose(begin, start),
    }
    if not all(same.values()):
        what = next(name for name, agrees in same.items() if not agrees)
        raise RoomsegError(
            f"{run.output}: already there, but of another {what}; "
            "choose another folder, or simulate again (--force)"
        )
