"""A ROS map of an apartment: YAML and PGM as ``map_server`` has them, and its rooms.

Free is the clear floor, occupied what the robot can bump into, unknown all else.
Beside the map lie a picture of the rooms, ``NAME_rooms.png``, whose grey is the number
of the room, and ``NAME_rooms.csv``, which says what the numbers mean.
"""

from __future__ import annotations

import colorsys
import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import shapely
import yaml
from numpy.typing import NDArray
from shapely import Polygon

from scenes.apartment import Apartment
from scenes.errors import SceneError
from scenes.solids import building_region, floor_region, obstacles
from scenes.storage import save_bytes, save_text

__all__ = ["GridMap", "draw_grid_map", "save_grid_map", "write_ros_map"]

Bytes = NDArray[np.uint8]

OCCUPIED, UNKNOWN, FREE = 0, 205, 254
"""Greys of ``map_saver``."""
MARGIN = 5
"""Unknown cells around the building."""
MOST_CELLS = 64_000_000
MOST_ROOMS = 255
THRESHOLDS = {"negate": 0, "occupied_thresh": 0.65, "free_thresh": 0.196, "mode": "trinary"}


@dataclass(frozen=True)
class GridMap:
    """A grid map; ``cells`` and ``rooms`` (rows, columns), row 0 at the top.

    ``cells`` `OCCUPIED`, `FREE` or `UNKNOWN`; ``rooms`` the number of the room, from 1
    on, or 0; ``resolution`` m per cell; ``origin`` m, the lower left corner.
    """

    cells: Bytes
    rooms: Bytes
    resolution: float
    origin: tuple[float, float]


def draw_grid_map(apartment: Apartment, resolution: float = 0.05) -> GridMap:
    """Draw an apartment as a grid map.

    A cell is occupied if its middle is in an obstacle; obstacles thinner than a cell
    (legs of chairs, panels) take every cell whose middle is within half a cell.

    Parameters
    ----------
    apartment : Apartment
    resolution : float
        m per cell.

    Returns
    -------
    GridMap

    Raises
    ------
    SceneError
        If it would have too many cells, or rooms.
    """
    if len(apartment.rooms) > MOST_ROOMS:
        raise SceneError(
            f"{apartment.name}: {len(apartment.rooms)} rooms; expected at most {MOST_ROOMS} for "
            f"a picture of the rooms"
        )
    solid, floor = obstacles(apartment), floor_region(apartment)
    building = shapely.union_all([building_region(apartment), solid, floor])
    low, shape = _extent(building, resolution, apartment.name)
    cells = np.full(shape, UNKNOWN, dtype=np.uint8)
    # What of the building is no floor is wall, also the niche before a closed door.
    cells[_covered(building, low, shape, resolution)] = OCCUPIED
    cells[_covered(floor, low, shape, resolution)] = FREE
    cells[_covered(_thickened(solid, resolution), low, shape, resolution)] = OCCUPIED
    rooms = np.zeros(shape, dtype=np.uint8)
    for index, room in enumerate(apartment.rooms):
        rooms[_covered(Polygon(room.polygon), low, shape, resolution)] = index + 1
    x, y = (round(float(cell) * resolution, 9) for cell in low)
    return GridMap(cells, rooms, resolution, (x, y))


def write_ros_map(
    apartment: Apartment, path: str | Path, *, resolution: float = 0.05
) -> tuple[Path, ...]:
    """Write a ROS map and its rooms.

    Parameters
    ----------
    apartment : Apartment
    path : path
        The YAML file; the pictures and the table go beside it.
    resolution : float
        m per cell.

    Returns
    -------
    tuple of Path
        The files, the YAML, which is written last, first.

    Raises
    ------
    SceneError
        If a file cannot be written, or the map would be too large.
    """
    rooms = [(room.name, room.kind) for room in apartment.rooms]
    return save_grid_map(draw_grid_map(apartment, resolution), rooms, path)


def save_grid_map(
    grid: GridMap, rooms: Sequence[tuple[str, str]], path: str | Path
) -> tuple[Path, ...]:
    """Write a grid map as ``map_server`` reads it, and its rooms by name and kind.

    Returns
    -------
    tuple of Path
        The files, the YAML, which is written last, first; without rooms there is no
        picture of them, and no table.

    Raises
    ------
    SceneError
        If a file cannot be written.
    """
    path = Path(path)
    image, labels, table = (
        path.with_name(f"{path.stem}{end}") for end in (".pgm", "_rooms.png", "_rooms.csv")
    )
    rows, columns = grid.cells.shape
    header = f"P5\n# {grid.resolution:g} m per pixel\n{columns} {rows}\n255\n"
    save_bytes(header.encode() + grid.cells.tobytes(), image)
    if rooms:
        save_bytes(cv2.imencode(".png", grid.rooms)[1].tobytes(), labels)
        save_text(_room_table(rooms), table)
    fields = {"image": image.name, "resolution": grid.resolution, "origin": [*grid.origin, 0.0]}
    text = yaml.safe_dump(fields | THRESHOLDS, sort_keys=False, default_flow_style=None)
    save_text(text, path)
    return (path, image, labels, table) if rooms else (path, image)


def _extent(
    region: shapely.Geometry, resolution: float, name: str
) -> tuple[NDArray[np.int64], tuple[int, int]]:
    """Lower left cell, and rows and columns; cell corners are multiples of the resolution."""
    bounds = np.array(region.bounds).reshape(2, 2) / resolution
    low = np.floor(bounds[0] + 1e-6).astype(int) - MARGIN
    columns, rows = np.ceil(bounds[1] - 1e-6).astype(int) + MARGIN - low
    if rows * columns > MOST_CELLS:
        raise SceneError(
            f"{name}: {columns} x {rows} cells of {resolution:g} m; expected at most "
            f"{MOST_CELLS // 1_000_000} million; choose a coarser resolution"
        )
    return low, (int(rows), int(columns))


def _covered(
    region: shapely.Geometry, low: NDArray[np.int64], shape: tuple[int, int], resolution: float
) -> NDArray[np.bool_]:
    """Cells whose middle is in a region."""
    rows, columns = shape
    x = (low[0] + np.arange(columns) + 0.5) * resolution
    y = (low[1] + np.arange(rows)[::-1] + 0.5) * resolution
    covered = np.zeros(shape, dtype=bool)
    for part in shapely.get_parts(region):
        left, bottom, right, top = part.bounds
        across = np.flatnonzero((x >= left) & (x <= right))
        down = np.flatnonzero((y >= bottom) & (y <= top))
        if len(across) and len(down):
            shapely.prepare(part)
            window = np.ix_(down, across)
            inside = shapely.contains_xy(part, *np.meshgrid(x[across], y[down]))
            covered[window] |= inside
    return covered


def _thickened(solid: shapely.Geometry, resolution: float) -> shapely.Geometry:
    """A region whose parts thinner than a cell are half a cell larger all around."""
    half = resolution / 2
    thick = solid.buffer(-half, join_style="mitre").buffer(half, join_style="mitre")
    # Corners that this opening took away are near the rest; they are not thin.
    thin = solid.difference(thick.buffer(half))
    return solid.union(thin.buffer(half, join_style="mitre"))


def _room_table(rooms: Sequence[tuple[str, str]]) -> str:
    """What the greys of the rooms mean, with a colour to draw each in."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["value", "name", "kind", "r", "g", "b"])
    for index, (name, kind) in enumerate(rooms):
        # Hues a golden section apart: neighbours in the list are easy to tell apart.
        colour = colorsys.hsv_to_rgb(index * 0.618034 % 1.0, 0.5, 0.95)
        table.writerow([index + 1, name, kind, *(round(255 * c) for c in colour)])
    return text.getvalue()
