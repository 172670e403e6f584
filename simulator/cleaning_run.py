"""One cleaning run: from an apartment to a topo-metric map with its ground truth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version

import numpy as np
import shapely
from numpy.typing import NDArray

from dataset.borders import crosses_border
from dataset.camera import SIMULATED_CAMERA, FisheyeCamera
from dataset.errors import RoomsegError
from dataset.interrupts import interrupts_held
from dataset.topomap import GroundTruth, Nodes, TopoMap, Visits
from scenes.apartment import Apartment
from scenes.passages import room_borders
from scenes.rooms import room_shapes
from scenes.solids import apartment_solids, floor_region, standing
from simulator.coverage import CoverageStrategy
from simulator.laser import SensorSpec
from simulator.robot import RobotSpec
from simulator.spec_file import settings_of
from simulator.start import base_pose
from simulator.surfaces import floor_covers, seen_surfaces
from simulator.vehicle import Vehicle
from simulator.world import World

__all__ = ["simulate"]

Floats = NDArray[np.float64]


def simulate(
    apartment: Apartment,
    *,
    run: str = "run1",
    seed: int = 0,
    start: tuple[float, float, float] | None = None,
    robot: RobotSpec | None = None,
    sensor: SensorSpec | None = None,
    camera: FisheyeCamera = SIMULATED_CAMERA,
    created: str = "1970-01-01T00:00:00Z",
    progress: Callable[[int, float], None] | None = None,
) -> TopoMap:
    """Clean an apartment once and return the map (§2.1, §3.1).

    Parameters
    ----------
    apartment : Apartment
    run : str
        Name of the run in the map.
    seed : int
        Of all noise; the same seed gives the same map.
    start : tuple of float, optional
        x m, y m, heading rad of the base; default: the apartment's.
    robot, sensor : optional
        Settings.
    camera : FisheyeCamera
        With which the images of the map are to be rendered, at ``sensor.camera_height``.
    created : str
        ISO date to write into the map. Fixed by default, as a clock would make
        the same seed give different bytes.
    progress : callable, optional
        Called with (nodes, simulated seconds) after every lane.

    Returns
    -------
    TopoMap
        With ground truth, driven path and scene; without images.

    Raises
    ------
    RoomsegError
        If the base does not fit where it is put, or the run is not done within
        ``robot.time_limit``.
    """
    robot, sensor = robot or RobotSpec(), sensor or SensorSpec()
    solids = apartment_solids(apartment)
    world = World(
        standing(solids, high=robot.height),
        seen_surfaces(apartment, solids, sensor.height),
        floor_covers(solids),
        maximum_range=sensor.maximum_range,
    )
    pose = np.array(base_pose(apartment, robot) if start is None else start, dtype=np.float64)
    if not floor_region(apartment).covers(shapely.Point(pose[:2])):
        raise RoomsegError(
            f"{apartment.name}: start.position ({pose[0]:g}, {pose[1]:g}) lies outside the rooms, "
            "expected free floor"
        )
    if not world.is_free(pose[:2], robot.radius):
        raise RoomsegError(
            f"{apartment.name}: start.position ({pose[0]:g}, {pose[1]:g}) is nearer than "
            f"{robot.radius:g} m to an obstacle, expected free floor"
        )
    with interrupts_held() as interrupt:
        vehicle = Vehicle(world, pose, robot, sensor, np.random.default_rng(seed))
        CoverageStrategy(vehicle, _stopped_by(interrupt, progress)).run()
    camera = replace(camera, height=sensor.camera_height)
    return _as_map(apartment, vehicle, camera, run=run, seed=seed, created=created)


def _stopped_by(
    interrupt: Callable[[], None], progress: Callable[[int, float], None] | None
) -> Callable[[int, float], None]:
    """What is called after every lane: first for Ctrl-C."""

    def show(nodes: int, seconds: float) -> None:
        interrupt()
        if progress is not None:
            progress(nodes, seconds)

    return show


def _as_map(
    apartment: Apartment,
    vehicle: Vehicle,
    camera: FisheyeCamera,
    *,
    run: str,
    seed: int,
    created: str,
) -> TopoMap:
    graph = vehicle.graph
    edges = np.unique(graph.edges, axis=0)
    visits = sorted(graph.visits)
    truth = graph.true_pose.copy()
    return TopoMap(
        environment=apartment.name,
        run=run,
        seed=seed,
        created=created,
        software=_software(),
        nodes=Nodes(
            position=graph.position.copy(),
            heading=graph.estimate[:, 2].copy(),
            part=np.array(graph.part, dtype=np.int32),
            lane=np.array(graph.lane, dtype=np.int32),
            true_pose=truth,
            tilt=vehicle.tilt(),
        ),
        edges=edges,
        visits=Visits(
            node=np.array([node for _, node in visits], dtype=np.int32),
            time=np.array([time for time, _ in visits]),
        ),
        obstacles=vehicle.obstacles(),
        robot_radius=vehicle.robot.radius,
        path=vehicle.path(),
        ground_truth=_ground_truth(apartment, truth[:, :2], edges),
        camera=camera,
        scene=apartment.model_dump_json(),
        robot=settings_of(vehicle.robot),
        sensor=settings_of(vehicle.sensor),
    )


def _ground_truth(apartment: Apartment, positions: Floats, edges: NDArray[np.int32]) -> GroundTruth:
    """Borders of the plan, the edges that cross them, and how many rooms have nodes."""
    borders = np.asarray(room_borders(apartment), dtype=np.float64).reshape(-1, 2, 2)
    points = shapely.points(positions)
    visited = [bool(shapely.contains(room, points).any()) for room in room_shapes(apartment)]
    return GroundTruth(
        borders=borders,
        frame="scene",
        edge_is_border=crosses_border(positions, edges, borders),
        room_count=max(1, sum(visited)),
    )


def _software() -> str:
    try:
        return f"roomseg {version('roomseg')}"
    except PackageNotFoundError:
        return "roomseg"
