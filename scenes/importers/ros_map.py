"""Grid maps: ROS ``map_server`` YAML with its picture, and bare research grids.

What ``map_server`` calls free is floor, all else (occupied or unknown) is solid. The
outline of the floor is traced exactly along the borders of the cells and then
simplified by at most one cell.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import shapely
import yaml
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from shapely import affinity

from scenes.apartment import Point
from scenes.errors import SceneError
from scenes.faults import value_fault
from scenes.importers import Imported
from scenes.importers.free_space import free_space_apartment
from scenes.importers.label_image import LabelledRoom, read_label_image
from scenes.importers.pictures import is_picture, read_picture
from scenes.importers.reading import read_bytes
from scenes.importers.room_lamps import with_room_lamps
from scenes.importers.tables import read_borders

__all__ = ["cell_region", "read_ros_map"]

Cells = NDArray[np.bool_]

YAML_BYTES = 100_000
SIMPLIFIED = 1.001
"""Tolerance of the outlines, cells: a single ragged cell goes, whatever rounding says."""
MOST_RUNS = 400_000
"""Pieces of rows of free cells in one map; noise has more."""
FREE_ABOVE = 250
"""Research grids: whiter is free."""

Number = Annotated[float, Field(ge=-1e6, le=1e6)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]


class MapFile(BaseModel):
    """The YAML file of ``map_server``; the defaults are those of its successor in ROS 2."""

    model_config = ConfigDict(extra="ignore", frozen=True, allow_inf_nan=False)

    image: Annotated[str, Field(min_length=1, max_length=255)]
    resolution: Annotated[float, Field(gt=0.0, le=10.0)]
    origin: tuple[Number, Number, Number]
    negate: bool = False
    occupied_thresh: Share = 0.65
    free_thresh: Share = 0.25
    mode: Literal["trinary", "scale", "raw"] = "trinary"


@dataclass(frozen=True)
class Grid:
    """Cells of a map, and where they lie.

    ``free``, ``occupied`` (rows, columns), row 0 at the top; what is neither is
    unknown. ``resolution`` m per cell; ``origin`` x m, y m, yaw rad of the lower left
    corner.
    """

    free: Cells
    occupied: Cells
    resolution: float
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def placed(self, shape: shapely.Geometry) -> shapely.Geometry:
        """A shape in cells (x right, y up, from the lower left corner), in metres."""
        x, y, yaw = self.origin
        a, b = self.resolution * np.cos(yaw), self.resolution * np.sin(yaw)
        return affinity.affine_transform(shape, [a, -b, b, a, x, y])


def read_ros_map(
    path: str | Path,
    *,
    scale: float | None = None,
    name: str | None = None,
    start: Point | None = None,
    borders: str | Path | None = None,
    labels: str | Path | None = None,
    label_table: str | Path | None = None,
    ceiling_height: float = 2.5,
) -> Imported:
    """Read a grid map.

    Parameters
    ----------
    path : path
        The YAML file of ``map_server``, whose picture must lie in its folder or below,
        or a bare picture, PGM or PNG, in which white (over 250) is free.
    scale : float, optional
        m per pixel of a bare picture; its lower left corner is the origin.
    name : str, optional
        Of the apartment; that of the file if absent.
    start : tuple of float, optional
        Where the robot starts, m, in the map's frame.
    borders : path, optional
        Segments between rooms, m, in the map's frame: see `read_borders`.
    labels, label_table : path, optional
        Picture of the rooms and what its values mean: see `read_label_image`.
    ceiling_height : float
        m.

    Returns
    -------
    Imported

    Raises
    ------
    SceneError
        If a file is missing, cut short or says what it must not, a picture has no
        scale, or the floor is nowhere wide enough for the robot.
    """
    path = Path(path)
    grid = _read_grid(path, scale)
    if not grid.free.any():
        raise SceneError(f"{path}: no free cell; expected floor (check negate and free_thresh)")
    region = grid.placed(cell_region(grid.free, str(path)))
    rooms, notes = None, _bare_edge(grid)
    if labels is not None:
        found = read_label_image(Path(labels), label_table, grid.free, grid.resolution)
        notes += found.notes
        rooms = [
            (room.name, room.kind, grid.placed(_room_region(room, grid, str(labels))))
            for room in found.rooms
        ]
    result = free_space_apartment(
        region,
        name=name or _name_of(path),
        start=start,
        borders=None if borders is None else read_borders(Path(borders)),
        rooms=rooms,
        ceiling_height=ceiling_height,
        tolerance=SIMPLIFIED * grid.resolution,
        origin=str(path),
    )
    return Imported(with_room_lamps(result.apartment), notes + result.notes)


def cell_region(cells: Cells, origin: str) -> shapely.Geometry:
    """The region that cells cover, exactly, in cells; x right, y up.

    Parameters
    ----------
    cells : array of bool, shape (rows, columns)
        Row 0 at the top.
    origin : str
        What an error calls the cells: their file.

    Raises
    ------
    SceneError
        If the cells are noise.
    """
    rows, _ = cells.shape
    padded = np.zeros((rows, cells.shape[1] + 2), dtype=np.int8)
    padded[:, 1:-1] = cells
    change = np.diff(padded, axis=1)
    row, left = np.nonzero(change > 0)
    right = np.nonzero(change < 0)[1]
    if len(row) > MOST_RUNS:
        raise SceneError(
            f"{origin}: the free cells are in {len(row)} pieces; expected at most {MOST_RUNS}: "
            f"a map, not noise"
        )
    top = (rows - row).astype(float)
    union = shapely.union_all(shapely.box(left, top - 1.0, right, top))
    # Corners in the middle of a side go; nothing moves.
    return shapely.normalize(union).simplify(0.0)


def _room_region(room: LabelledRoom, grid: Grid, origin: str) -> shapely.Geometry:
    """The region of a labelled room, in cells; x right, y up."""
    top, left = room.corner
    below = len(grid.free) - top - len(room.cells)
    return affinity.translate(cell_region(room.cells, origin), left, below)


# ---- the files ------------------------------------------------------------------------------


def _read_grid(path: Path, scale: float | None) -> Grid:
    """Cells of a map: YAML with a picture, or a bare picture."""
    if is_picture(path):
        return _bare_grid(path, scale)
    header = _read_header(path)
    if scale is not None:
        raise SceneError(
            f"{path}: has a resolution, {header.resolution:g} m per cell; expected no --scale"
        )
    free, occupied = _occupancy(read_picture(_beside(path, header.image)), header)
    return Grid(free, occupied, header.resolution, header.origin)


def _bare_grid(path: Path, scale: float | None) -> Grid:
    """A research grid."""
    if scale is None:
        raise SceneError(
            f"{path}: a picture has no scale; expected --scale, metres per pixel (0.05 is usual)"
        )
    if not 0.0 < scale <= 10.0:
        raise SceneError(f"{path}: scale: {scale:g} m per pixel; expected above 0, at most 10")
    grey = _grey(read_picture(path))
    return Grid(grey > FREE_ABOVE, grey < 128, scale)


def _read_header(path: Path) -> MapFile:
    """Read the YAML file; every fault is one line."""
    text = read_bytes(path, YAML_BYTES, "the YAML of a ROS map")
    try:
        fields = yaml.safe_load(text)
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError, ValueError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f"line {mark.line + 1}: " if mark is not None else ""
        reason = getattr(error, "problem", None) or "no text, or nested too deeply"
        raise SceneError(f"{path}: {where}not YAML: {reason}") from None
    if not isinstance(fields, dict):
        raise SceneError(
            f"{path}: no fields; expected the YAML of a ROS map: image, resolution, origin, …"
        )
    try:
        header = MapFile.model_validate(fields)
    except ValidationError as error:
        raise SceneError(f"{path}: {_fault(error)}") from None
    if header.free_thresh >= header.occupied_thresh:
        raise SceneError(
            f"{path}: free_thresh: {header.free_thresh:g}; expected below occupied_thresh, "
            f"{header.occupied_thresh:g}"
        )
    return header


def _fault(error: ValidationError) -> str:
    """The first fault of the YAML file."""
    first = error.errors(include_url=False)[0]
    field = "".join(f"[{part}]" if isinstance(part, int) else part for part in first["loc"])
    if first["type"] == "missing":
        return f"{field}: missing; expected a value"
    value = first["input"]
    shown = repr(value)[:60] if isinstance(value, str | int | float) else type(value).__name__
    return f"{field}: {shown}; {value_fault(first)}"


def _beside(path: Path, name: str) -> Path:
    """A file that another one names, which must lie in its folder or below."""
    folder = path.parent.resolve()
    try:
        target = (folder / name).resolve()
    except (OSError, ValueError, RuntimeError):
        target = Path("/")
    if not target.is_relative_to(folder):
        raise SceneError(f"{path}: image: {name!r} leads out of the folder; expected a file in it")
    return path.parent / name


# ---- cells ----------------------------------------------------------------------------------


def _grey(picture: NDArray[np.uint8]) -> NDArray[Any]:
    """Mean of the colours, as ``map_server`` has it; transparent is mid-grey: unknown."""
    if picture.ndim == 2:
        return picture
    colours = picture.shape[2] - (picture.shape[2] in (2, 4))
    grey = picture[..., :colours].mean(axis=2)
    if colours < picture.shape[2]:
        grey = np.where(picture[..., -1] < 128, 127.0, grey)
    return np.asarray(grey)


def _occupancy(picture: NDArray[np.uint8], header: MapFile) -> tuple[Cells, Cells]:
    """Free and occupied cells by the rules of ``map_server``."""
    grey = _grey(picture)
    if header.mode == "raw":
        free = grey <= 100.0 * header.free_thresh
        occupied = (grey >= 100.0 * header.occupied_thresh) & (grey <= 100)
        return free, occupied
    shade = grey if header.negate else 255 - grey
    return shade < 255.0 * header.free_thresh, shade > 255.0 * header.occupied_thresh


def _name_of(path: Path) -> str:
    """A name for the apartment from that of its file."""
    return re.sub(r"[^A-Za-z0-9_.-]+", "_", path.stem).lstrip("_.-")[:64] or "map"


def _bare_edge(grid: Grid) -> tuple[str, ...]:
    """How much of the free cells' outline has no wall in the map."""
    unknown = np.pad(~(grid.free | grid.occupied), 1, constant_values=True)
    free = np.pad(grid.free, 1)
    sides = sum(
        int((free & np.roll(unknown, step, axis)).sum()) for axis in (0, 1) for step in (-1, 1)
    )
    length = sides * grid.resolution
    if sides == 0:
        return ()
    return (f"{length:.1f} m of the free cells' edge meet unknown ones: closed by a wall",)
