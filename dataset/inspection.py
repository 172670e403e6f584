"""What a map file holds, in a few figures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dataset.journal import journal_path
from dataset.storage import MapFile
from dataset.topomap import Settings, TopoMap

__all__ = ["Summary", "summarise"]


@dataclass(frozen=True)
class Summary:
    """The figures of one map file.

    Lengths in m, times in s, ``file_size`` in bytes. ``part_count`` and
    ``lane_count`` are parts of the map and lanes over all parts (§2.1).
    ``images_done`` are in the file; ``journal`` says whether more wait beside it. A map
    without images, and without a plan to render them from, has no camera.
    What the file does not have is None.
    """

    file: str
    file_size: int
    environment: str
    run: str
    seed: int
    created: str
    software: str
    node_count: int
    edge_count: int
    visit_count: int
    obstacle_count: int
    part_count: int
    lane_count: int
    median_edge_length: float | None
    duration: float
    path_length: float | None
    has_scene: bool
    robot_radius: float
    robot: Settings | None
    sensor: Settings | None
    image_size: tuple[int, int] | None
    disc_diameter: float | None
    images_done: int
    preset: str
    keeps_radiance: bool
    journal: bool
    room_count: int | None
    border_edge_count: int | None
    nodes_labelled: bool
    segmented_by: str | None


def summarise(path: str | Path) -> Summary:
    """Read the figures of a map file.

    Raises
    ------
    FormatError
        If the file is missing, cut off or no map.
    """
    path = Path(path)
    with MapFile(path) as file:
        topomap, rooms = file.topomap, file.rooms
        images, preset, radiance = file.image_count, file.preset, file.keeps_radiance
    journal = journal_path(path).exists()
    # A map takes a camera as given; nobody sees by it without images or a plan to render.
    sees = images > 0 or journal or topomap.scene is not None
    camera = topomap.camera if sees else None
    nodes, truth = topomap.nodes, topomap.ground_truth
    lengths = topomap.edge_lengths()
    return Summary(
        file=str(path),
        file_size=path.stat().st_size,
        environment=topomap.environment,
        run=topomap.run,
        seed=topomap.seed,
        created=topomap.created,
        software=topomap.software,
        node_count=len(nodes),
        edge_count=len(topomap.edges),
        visit_count=len(topomap.visits.node),
        obstacle_count=len(topomap.obstacles.time),
        part_count=len(np.unique(nodes.part)),
        lane_count=len(np.unique(np.stack([nodes.part, nodes.lane]), axis=1).T),
        median_edge_length=float(np.median(lengths)) if len(lengths) else None,
        duration=_duration(topomap),
        path_length=_path_length(topomap),
        has_scene=topomap.scene is not None,
        robot_radius=topomap.robot_radius,
        robot=topomap.robot,
        sensor=topomap.sensor,
        image_size=None if camera is None else camera.image_size,
        disc_diameter=None if camera is None else camera.disc_diameter,
        images_done=images,
        preset=preset,
        keeps_radiance=radiance,
        journal=journal,
        room_count=None if truth is None else truth.room_count,
        border_edge_count=None if truth is None else int(truth.edge_is_border.sum()),
        nodes_labelled=truth is not None and truth.room is not None,
        segmented_by=None if rooms is None else rooms.model,
    )


def _duration(topomap: TopoMap) -> float:
    """From the first to the last moment that the map knows of, s."""
    known = [topomap.visits.time, topomap.obstacles.time]
    known += [] if topomap.path is None else [topomap.path.time]
    times = np.concatenate(known)
    return float(np.ptp(times)) if len(times) else 0.0


def _path_length(topomap: TopoMap) -> float | None:
    """Length of the driven path, m."""
    if topomap.path is None:
        return None
    steps = np.diff(topomap.path.true_pose[:, :2], axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())
