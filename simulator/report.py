"""How good a cleaning run was: coverage, path, overlap, drift."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from dataset.errors import RoomsegError
from dataset.topomap import Path, TopoMap
from scenes.apartment import Apartment
from scenes.passages import reachable_positions
from scenes.solids import floor_area

__all__ = ["CoverageReport", "coverage_report", "reachable_from", "track_line"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class CoverageReport:
    """Figures of one run.

    Attributes
    ----------
    nodes : int
    nodes_per_m2 : float
        Nodes per m² of the rooms' total floor area, as in Table 8.
    coverage : float
        Share of the positions that the robot's centre can reach from its base which lie
        within ``near`` m of the driven path, 0..1.
    path_length, path_per_m2 : float
        m, and m per m² of total floor area.
    shortest_path : float
        Bound from below, m: free area over lane spacing. The free area is what the
        body can sweep: all within its radius of a position that its centre can reach.
    turns : float
        Full turns (360°) made in all.
    overlap : float
        Share of the driven path along which the floor under the centre had
        been passed within 0.1 m at least 10 s before, 0..1.
    duration : float
        s of simulated time.
    connected : bool
        Whether the map graph is one component.
    drift : float
        Largest distance between estimate and truth along the path, m.
    from_home : float
        Where the run ended, as true distance from the base, m.
    """

    nodes: int
    nodes_per_m2: float
    coverage: float
    path_length: float
    path_per_m2: float
    shortest_path: float
    turns: float
    overlap: float
    duration: float
    connected: bool
    drift: float
    from_home: float


def coverage_report(
    topomap: TopoMap,
    apartment: Apartment,
    *,
    near: float = 0.2,
    spacing: float = 0.05,
    lane_spacing: float = 0.30,
) -> CoverageReport:
    """Judge a simulated run by the plan that it was made in.

    Parameters
    ----------
    topomap : TopoMap
        With its driven path.
    apartment : Apartment
    near : float
        A position is covered if the driven path is this near, m.
    spacing : float
        Grid spacing of the positions, m.
    lane_spacing : float
        Of the robot, for the shortest possible path, m.

    Returns
    -------
    CoverageReport

    Raises
    ------
    RoomsegError
        If the map has no driven path.
    SceneError
        If the run does not begin where the robot fits.
    """
    if topomap.path is None or len(topomap.path.time) == 0:
        raise RoomsegError(f"{topomap.environment}: path: absent, expected a simulated run")
    path = topomap.path
    track = path.true_pose[:, :2]
    steps = np.hypot(*np.diff(track, axis=0).T)
    turned = np.diff(np.unwrap(path.true_pose[:, 2]))
    area = floor_area(apartment)
    reachable = reachable_from(track, apartment, topomap.robot_radius, spacing)
    return CoverageReport(
        nodes=len(topomap.nodes),
        nodes_per_m2=len(topomap.nodes) / area,
        coverage=_coverage(track, reachable, near),
        path_length=float(steps.sum()),
        path_per_m2=float(steps.sum()) / area,
        shortest_path=_swept_area(reachable, topomap.robot_radius, spacing) / lane_spacing,
        turns=float(np.abs(turned).sum() / (2.0 * np.pi)),
        overlap=_overlap(path, np.append(steps, 0.0)),
        duration=float(path.time[-1]),
        connected=_is_connected(topomap),
        drift=float(np.hypot(*(track - path.estimate[:, :2]).T).max()),
        from_home=float(np.hypot(*(track[-1] - track[0]))),
    )


def reachable_from(track: Floats, apartment: Apartment, radius: float, spacing: float) -> Floats:
    """Grid points (p, 2), m, that the robot can reach from where a driven path (t, 2) begins."""
    begin = (float(track[0, 0]), float(track[0, 1]))
    return reachable_positions(apartment, radius, spacing, begin)


def track_line(track: Floats) -> shapely.Geometry:
    """A driven path (t, 2), m, as a line; of one place a point."""
    return shapely.linestrings(track) if len(track) > 1 else shapely.Point(track[0])


def _coverage(track: Floats, reachable: Floats, near: float) -> float:
    line = track_line(track)
    shapely.prepare(line)
    return float(shapely.dwithin(line, shapely.points(reachable), near).mean())


def _swept_area(reachable: Floats, radius: float, spacing: float) -> float:
    """Area within ``radius`` m of the reachable grid points, m²."""
    cells = np.round((reachable - reachable.min(axis=0)) / spacing).astype(np.int64)
    margin = int(np.ceil(radius / spacing)) + 1
    mask = np.ones(cells.max(axis=0) + 2 * margin + 1, np.uint8)
    mask[tuple((cells + margin).T)] = 0
    away = cv2.distanceTransform(mask, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * spacing
    return float((away <= radius).sum()) * spacing**2


def _overlap(path: Path, steps: Floats, near: float = 0.1, pause: float = 10.0) -> float:
    """Share of the path length that passes where the robot has been before.

    By cells of a quarter of ``near``, m, all of which must be near: memory must not grow with
    how often the robot passes.
    """
    track = path.true_pose[:, :2]
    size = near / 4.0
    cell = np.floor((track - track.min(axis=0)) / size).astype(np.int64)
    earliest = np.full(cell.max(axis=0) + 1, np.inf)
    np.minimum.at(earliest, tuple(cell.T), path.time)
    offset = np.hypot(*(np.indices((9, 9)) - 4.0))
    around = ndimage.minimum_filter(
        earliest, footprint=(offset + 1.0) * size <= near, mode="constant", cval=np.inf
    )
    again = around[tuple(cell.T)] < path.time - pause
    return float(steps[again].sum() / max(steps.sum(), 1e-9))


def _is_connected(topomap: TopoMap) -> bool:
    n = len(topomap.nodes)
    a, b = topomap.edges.T
    graph = csr_array((np.ones(len(a)), (a, b)), shape=(n, n))
    return bool(connected_components(graph, directed=False)[0] == 1)
