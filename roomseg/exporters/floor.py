"""The floor of a map: as a grid and as areas, each place in the room of its nearest node.

Free is what the body has passed, or would on its way along an edge, which is direct
travel (§2.1). Occupied is where obstacle points are, unless the body has been there;
fewer than three points within 10 cm are false measurements (§2.2.2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import KDTree

from dataset.errors import RoomsegError
from dataset.topomap import TopoMap

__all__ = [
    "FREE",
    "OCCUPIED",
    "UNKNOWN",
    "FloorGrid",
    "driven_lines",
    "floor_grid",
    "room_areas",
    "room_name",
]

Floats = NDArray[np.float64]
Rooms = NDArray[np.int32]

OCCUPIED, UNKNOWN, FREE = 0, 205, 254
"""Greys of ``map_saver``."""
MARGIN = 5
"""Unknown cells around the map."""
LEAST_AREA = 0.01
"""Of a piece of a room, m²."""
MOST_CELLS = 4_000_000
LONGEST_STEP = 0.5
"""A longer step of the estimate is a correction, not a way, m."""


@dataclass(frozen=True)
class FloorGrid:
    """A grid map in the map frame; row 0 at the top.

    Attributes
    ----------
    cells : array, shape (rows, columns), uint8
        `OCCUPIED`, `FREE` or `UNKNOWN`.
    rooms : array, shape (rows, columns), int32
        Room of free cells, from 1 on; 0 for all else, or where rooms are unknown.
    resolution : float
        m per cell.
    origin : tuple of float
        x, y of the lower left corner, m; multiples of the resolution.
    """

    cells: NDArray[np.uint8]
    rooms: Rooms
    resolution: float
    origin: tuple[float, float]


def driven_lines(topomap: TopoMap) -> Floats:
    """Ways of the robot's centre, shape (s, 2, 2), m: along the path, or from node to node."""
    nodes, path = topomap.nodes, topomap.path
    if path is not None and len(path.estimate) > 1:
        points = path.estimate[:, :2]
        follows = np.ones(len(points) - 1, dtype=bool)
    else:
        points = nodes.position
        follows = (np.diff(nodes.part) == 0) & (np.diff(nodes.lane) == 0)
    lines = np.stack([points[:-1], points[1:]], axis=1)
    kept: Floats = lines[follows & (_lengths(lines) <= LONGEST_STEP)]
    return kept


def _lengths(lines: Floats) -> Floats:
    return np.asarray(np.hypot(*(lines[:, 1] - lines[:, 0]).T))


def floor_grid(topomap: TopoMap, room: Rooms | None, resolution: float = 0.05) -> FloorGrid:
    """Draw the map as a grid.

    Parameters
    ----------
    topomap : TopoMap
    room : array, shape (n,), optional
        Room of each node, from 0.
    resolution : float
        m per cell.

    Raises
    ------
    RoomsegError
        If it would have too many cells.
    """
    position, radius = topomap.nodes.position, topomap.robot_radius
    driven = np.concatenate([position, _samples(driven_lines(topomap), resolution)])
    passable = np.concatenate([driven, _samples(position[topomap.edges], resolution)])
    points = _clusters(topomap.obstacles.position)
    low, shape = _extent(np.concatenate([passable, points]), radius, resolution)
    middles = _middles(low, shape, resolution)
    cells = np.full(shape, UNKNOWN, dtype=np.uint8)
    free = _near(passable, middles, radius)
    cells.ravel()[free] = FREE
    column, row = (np.floor(points / resolution + 1e-9).astype(np.int64) - low).T
    cells[shape[0] - 1 - row, column] = OCCUPIED
    # Where the body has been, points are false; at its rim they are what it drove along.
    cells.ravel()[_near(driven, middles, radius - resolution)] = FREE
    rooms = np.zeros(shape, dtype=np.int32)
    if room is not None:
        floor = np.flatnonzero(cells.ravel() == FREE)
        rooms.ravel()[floor] = room[KDTree(position).query(middles[floor])[1]] + 1
    x, y = (round(float(cell) * resolution, 9) for cell in low)
    return FloorGrid(cells, rooms, resolution, (x, y))


def _clusters(points: Floats) -> Floats:
    """Obstacle points without those that stand alone."""
    if not len(points):
        return points
    near = KDTree(points).query_ball_point(points, 0.10, return_length=True)
    return np.asarray(points[near >= 3])


def _samples(lines: Floats, resolution: float) -> Floats:
    """Points along lines (s, 2, 2), hardly more than half a cell apart."""
    counts = np.ceil(_lengths(lines) / resolution * 2).astype(np.int64)
    index = np.repeat(np.arange(len(lines)), counts)
    step = np.arange(len(index)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = ((step + 0.5) / np.maximum(counts, 1)[index])[:, None]
    return np.asarray(lines[index, 0] * (1 - share) + lines[index, 1] * share)


def _extent(
    points: Floats, radius: float, resolution: float
) -> tuple[NDArray[np.int64], tuple[int, int]]:
    """Lower left cell, and rows and columns; cell corners are multiples of the resolution."""
    low = np.floor((points.min(axis=0) - radius) / resolution) - MARGIN
    columns, rows = np.ceil((points.max(axis=0) + radius) / resolution) + MARGIN - low
    if not rows * columns <= MOST_CELLS:
        raise RoomsegError(
            f"{columns:.0f} x {rows:.0f} cells of {resolution:g} m, expected at most "
            f"{MOST_CELLS // 1_000_000} million; choose a coarser resolution"
        )
    return low.astype(np.int64), (int(rows), int(columns))


def _middles(low: NDArray[np.int64], shape: tuple[int, int], resolution: float) -> Floats:
    """Middles of all cells, row by row from the top, shape (rows * columns, 2), m."""
    rows, columns = shape
    x = (low[0] + np.arange(columns) + 0.5) * resolution
    y = (low[1] + np.arange(rows)[::-1] + 0.5) * resolution
    return np.asarray(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2))


def _near(points: Floats, middles: Floats, radius: float) -> NDArray[np.bool_]:
    """Which middles of cells are within ``radius`` m of a point."""
    distance = KDTree(points).query(middles, distance_upper_bound=max(radius, 0.0))[0]
    return np.asarray(np.isfinite(distance))


def room_areas(grid: FloorGrid) -> list[shapely.Geometry]:
    """Floor of each room as areas in the map frame, m.

    Returns
    -------
    list of shapely MultiPolygon
        By room, along the borders of cells; neighbours have the same corners.
    """
    lines = np.array(grid.origin) + grid.resolution * _borders_of_cells(grid.rooms)
    faces = shapely.get_parts(
        shapely.polygonize(shapely.get_parts(shapely.line_merge(shapely.multilinestrings(lines))))
    )
    inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    column, row = np.floor((inside - grid.origin) / grid.resolution).astype(np.int64).T
    label = grid.rooms[len(grid.rooms) - 1 - row, column]
    # A few cells apart from all others, seen through a gap, are no floor of a room.
    label[shapely.area(faces) < LEAST_AREA] = 0
    count = int(grid.rooms.max())
    return [shapely.multipolygons(faces[label == k + 1]) for k in range(count)]


def room_name(names: Sequence[str], label: int) -> str:
    """The name of the room with a label, from 0; ``room-1`` and so on where it has none."""
    return (names[label] if label < len(names) else "") or f"room-{label + 1}"


def _borders_of_cells(rooms: Rooms) -> Floats:
    """Sides between cells of different rooms, shape (s, 2, 2), in cells from the lower left."""
    down, right = np.eye(2, dtype=np.int64)
    upright = np.argwhere(np.diff(rooms, axis=1) != 0) + right
    level = np.argwhere(np.diff(rooms, axis=0) != 0) + down
    corners = np.concatenate([upright, level])
    ends = np.concatenate([upright + down, level + right])
    sides = np.stack([corners, ends], axis=1)[..., ::-1].astype(np.float64)
    sides[..., 1] = len(rooms) - sides[..., 1]
    return np.asarray(sides)
