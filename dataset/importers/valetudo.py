"""A Valetudo map with its path as a topo-metric map.

The file has walls and segments as pixels, and the path in centimetres, without times.
The robot is taken to have driven at the prototype's speed, with the prototype's eight
beams: an obstacle point is where a beam met a wall's pixel. The map frame's origin is the
middle of the file's picture, y up. Segments, which a person can correct, are the
ground truth; what the robot did not drive on has no nodes, so its segment is no room.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field, ValidationError
from scipy.spatial import KDTree

from dataset.borders import borders_between, crosses_border
from dataset.errors import FormatError
from dataset.importers import ImportedRun
from dataset.importers.edges import adjacent_pairs, connected_drive
from dataset.importers.track import Track, drive_of
from dataset.topomap import GroundTruth, Nodes, Obstacles, TopoMap

__all__ = ["read_valetudo"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

LARGEST_FILE = 50_000_000
MOST_PIXELS = 16_000_000
LONGEST_NAME = 60
LONGEST_PATH = 20_000.0
"""m."""
SPEED = 0.16
"""Of the prototype in the simulator, m/s: visits and points are as far apart in time."""
PAUSE = 60.0
"""Between two pieces of the path, s."""
BEAMS = 8
BEAM_RANGE = 1.0
"""m (§2.2.2)."""
BEAM_STEP = 0.05
"""Beams are looked at every so often along the path, m."""

Pixel = Annotated[int, Field(ge=0, le=100_000)]
Centimetre = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False)]


class _Meta(BaseModel):
    segmentId: str | int | None = None  # noqa: N815  # the file's own name
    name: str | None = None


class _Layer(BaseModel):
    type: str
    metaData: _Meta = _Meta()  # noqa: N815
    pixels: list[Pixel] = []
    compressedPixels: list[Pixel] = []  # noqa: N815


class _Entity(BaseModel):
    type: str
    points: list[Centimetre] = []


class _Size(BaseModel):
    x: Centimetre
    y: Centimetre


class _File(BaseModel):
    kind: str = Field(alias="__class")
    size: _Size
    pixelSize: Annotated[int, Field(ge=1, le=100)]  # noqa: N815
    layers: list[_Layer]
    entities: list[_Entity]


@dataclass(frozen=True)
class _Picture:
    """Pixels as cells, x right, y up: ``wall`` (w, 2); the segments' names, and cells of each."""

    pixel: float
    wall: Integers
    names: tuple[str, ...]
    segments: tuple[Integers, ...]


def read_valetudo(
    path: str | Path, *, name: str | None = None, robot_radius: float = 0.17
) -> ImportedRun:
    """Read a Valetudo map.

    Parameters
    ----------
    path : path
        JSON, as Valetudo exports it.
    name : str, optional
        Of the environment; that of the file by default.
    robot_radius : float
        m.

    Raises
    ------
    FormatError
        If it is no Valetudo map, has no path, or is too large; one line.
    """
    path = Path(path)
    data = _file(path)
    half = np.array([data.size.x, data.size.y]) / 2
    picture = _picture(path, data, half)
    track = _track(path, data, half)
    drive = drive_of(track)
    edges = adjacent_pairs(drive, (picture.wall + 0.5) * picture.pixel)
    drive, edges, notes = connected_drive(drive, edges)
    truth, told = _truth(drive.nodes, edges, picture)
    topomap = TopoMap(
        environment=name or path.stem,
        run=path.stem,
        seed=0,
        created="",
        software="Valetudo",
        nodes=drive.nodes,
        edges=edges.astype(np.int32),
        visits=drive.visits,
        obstacles=_obstacles(track, picture),
        robot_radius=robot_radius,
        ground_truth=truth,
    )
    return ImportedRun(topomap, (*notes, *told))


def _file(path: Path) -> _File:
    """Read and check the file's fields."""
    size = path.stat().st_size
    if size > LARGEST_FILE:
        raise FormatError(
            f"{path}: {size / 1e6:.0f} MB, expected a Valetudo map of at most "
            f"{LARGEST_FILE // 1_000_000} MB"
        )
    try:
        data = _File.model_validate_json(path.read_bytes())
    except ValidationError as error:
        fault = error.errors(include_url=False, include_context=False)[0]
        if fault["type"] == "json_invalid" and "EOF while parsing" in fault["msg"]:
            raise FormatError(
                f"{path}: the JSON ends in the middle: the file is damaged or cut off; expected "
                "all of it"
            ) from None
        where = ".".join(str(place) for place in fault["loc"])
        value = "" if where == "" or isinstance(fault["input"], dict | list | bytes) else (
            f"{str(fault['input'])[:60]!r}, "
        )  # fmt: skip
        raise FormatError(
            f"{path}: {where + ': ' if where else ''}{value}{fault['msg']}; expected a Valetudo map"
        ) from None
    if data.kind != "ValetudoMap":
        raise FormatError(f"{path}: __class: {data.kind!r}, expected 'ValetudoMap'")
    return data


def _picture(path: Path, data: _File, half: Floats) -> _Picture:
    """The pixels of walls and segments, as cells about the middle."""
    middle = np.floor(half / data.pixelSize).astype(np.int64)
    walls = [np.empty((0, 2), np.int64)]
    names, segments = [], []
    total = 0
    for number, layer in enumerate(data.layers):
        cells = _cells(f"{path}: layers.{number}", layer)
        total += len(cells)
        if total > MOST_PIXELS:
            raise FormatError(
                f"{path}: layers.{number}: more than {MOST_PIXELS // 1_000_000} million pixels in "
                "all; expected fewer"
            )
        upright = (cells - middle) * (1, -1) - (0, 1)
        if layer.type == "wall":
            walls.append(upright)
        elif layer.type == "segment":
            names.append(_name(layer.metaData, number))
            segments.append(upright)
    return _Picture(data.pixelSize / 100, np.concatenate(walls), tuple(names), tuple(segments))


def _name(meta: _Meta, number: int) -> str:
    """What a segment is called, on one line; by its id, or its layer, if nobody has named it."""
    by_id = number if meta.segmentId in (None, "") else meta.segmentId
    return _plain(meta.name or "") or _plain(f"segment {by_id}")


def _plain(name: str) -> str:
    """A name without characters that nobody sees."""
    seen = "".join(c for c in name if c.isprintable() or c.isspace())
    return " ".join(seen.split())[:LONGEST_NAME].rstrip()


def _cells(where: str, layer: _Layer) -> Integers:
    """Pixels (p, 2) as x, y: those given one by one, and runs of x, y, length."""
    if len(layer.pixels) % 2:
        raise FormatError(f"{where}.pixels: {len(layer.pixels)} numbers, expected pairs x, y")
    if len(layer.compressedPixels) % 3:
        raise FormatError(
            f"{where}.compressedPixels: {len(layer.compressedPixels)} numbers, expected runs of "
            "x, y, length"
        )
    runs = np.array(layer.compressedPixels, dtype=np.int64).reshape(-1, 3)
    length = runs[:, 2]
    if length.sum() > MOST_PIXELS:
        raise FormatError(f"{where}.compressedPixels: {length.sum()} pixels, expected fewer")
    cells = np.repeat(runs[:, :2], length, axis=0)
    cells[:, 0] += np.arange(len(cells)) - np.repeat(np.cumsum(length) - length, length)
    return np.concatenate([np.array(layer.pixels, dtype=np.int64).reshape(-1, 2), cells])


def _track(path: Path, data: _File, half: Floats) -> Track:
    """All pieces of the path, timed as if driven at `SPEED`, heading ahead."""
    pieces = []
    for number, entity in enumerate(data.entities):
        if entity.type != "path" or not entity.points:
            continue
        if len(entity.points) % 2:
            raise FormatError(
                f"{path}: entities.{number}.points: {len(entity.points)} numbers, "
                "expected pairs x, y"
            )
        points = (np.array(entity.points).reshape(-1, 2) - half) * (0.01, -0.01)
        fresh = np.r_[True, (np.diff(points, axis=0) != 0.0).any(axis=1)]
        pieces.append(points[fresh])
    if not pieces:
        raise FormatError(
            f"{path}: entities: no path, expected one with points; save the map after a run"
        )
    return _timed(path, pieces)


def _timed(path: Path, pieces: list[Floats]) -> Track:
    times, headings, start = [], [], 0.0
    pieces = [_straights(points) for points in pieces]
    for points in pieces:
        step = np.diff(points, axis=0)
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*step.T))])
        ahead = np.arctan2(step[::2, 1], step[::2, 0])
        times.append(start + along / SPEED)
        headings.append(np.repeat(ahead, 2))
        start = float(times[-1][-1]) + PAUSE
    if start * SPEED > LONGEST_PATH:
        raise FormatError(
            f"{path}: entities: a path of {start * SPEED:.0f} m, expected at most "
            f"{LONGEST_PATH:.0f} m"
        )
    stroke = np.repeat(np.arange(len(pieces)), [len(points) for points in pieces])
    return Track(np.concatenate(times), np.concatenate(pieces), np.concatenate(headings), stroke)


def _straights(points: Floats) -> Floats:
    """Both ends of every straight of a path: the robot turns where one ends, at once."""
    ends = points if len(points) > 1 else np.repeat(points, 2, axis=0)
    return np.asarray(np.stack([ends[:-1], ends[1:]], axis=1).reshape(-1, 2))


def _obstacles(track: Track, picture: _Picture) -> Obstacles:
    """Where the beams of a robot on the track meet walls."""
    time, pose = _beam_poses(track)
    if not len(picture.wall):
        return Obstacles(np.empty((0, 2)), np.empty(0), np.empty(0, np.uint8))
    low = picture.wall.min(axis=0) - 1
    grid = np.zeros(picture.wall.max(axis=0) - low + 2, dtype=bool)
    grid[tuple((picture.wall - low).T)] = True
    bearing = np.arange(BEAMS) * 2 * np.pi / BEAMS
    ranges = np.arange(0.0, BEAM_RANGE, picture.pixel / 5)
    points, when, beam = [], [], []
    for number in range(BEAMS):
        angle = pose[:, 2] + bearing[number]
        ahead = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        places = pose[:, None, :2] + ranges[None, :, None] * ahead[:, None]
        cell = np.floor(places / picture.pixel).astype(np.int64) - low
        inside = ((cell >= 0) & (cell < grid.shape)).all(axis=2)
        cell[~inside] = 0  # a margin without walls
        met = grid[cell[..., 0], cell[..., 1]]
        seen = met.any(axis=1)
        points.append(places[seen, met.argmax(axis=1)[seen]])
        when.append(time[seen])
        beam.append(np.full(int(seen.sum()), number))
    order = np.argsort(np.concatenate(when), kind="stable")
    return Obstacles(
        np.concatenate(points)[order], np.concatenate(when)[order], np.concatenate(beam)[order]
    )


def _beam_poses(track: Track) -> tuple[Floats, Floats]:
    """Times (b,) and poses (b, 3) at which beams are looked at."""
    times, poses = [], []
    for stroke in np.unique(track.stroke):
        own = track.stroke == stroke
        time = track.time[own]
        # Half a step on: no beam is looked at just where the path bends.
        at = np.arange(time[0], time[-1], BEAM_STEP / SPEED) + BEAM_STEP / SPEED / 2
        at = np.minimum(at, time[-1])
        x, y = (np.interp(at, time, column) for column in track.position[own].T)
        heading = track.heading[own][np.searchsorted(time, at, side="right").clip(1) - 1]
        times.append(at)
        poses.append(np.stack([x, y, heading], axis=1))
    return np.concatenate(times), np.concatenate(poses)


def _truth(
    nodes: Nodes, edges: Integers, picture: _Picture
) -> tuple[GroundTruth | None, tuple[str, ...]]:
    """Rooms of the nodes by segments and called as they are; a note tells them, from 1 on."""
    if not picture.segments:
        return None, ("has no segments: the map has no ground truth",)
    names = picture.names
    cells = np.concatenate(picture.segments)
    owner = np.repeat(np.arange(len(names)), [len(c) for c in picture.segments])
    if not len(cells):
        return None, ("its segments are empty: the map has no ground truth",)
    nearest = KDTree((cells + 0.5) * picture.pixel).query(nodes.position)[1]
    used, room = np.unique(owner[nearest], return_inverse=True)
    room = room.reshape(-1).astype(np.int32)
    pairs = edges.astype(np.int32)
    borders = borders_between(nodes.position, pairs, room)
    crossed = crosses_border(nodes.position, pairs, borders)
    counts = np.bincount(room)
    called = tuple(names[segment] for segment in used.tolist())
    listed = ", ".join(
        f"{k} {name!r} ({count} node{'s' * (count != 1)})"
        for k, (name, count) in enumerate(zip(called, counts.tolist(), strict=True), start=1)
    )
    notes = [f"rooms by segment: {listed}"]
    if missing := [name for k, name in enumerate(names) if k not in used]:
        notes.append(f"no path in {', '.join(map(repr, missing))}: no rooms of the map")
    return GroundTruth(borders, "map", crossed, len(used), room, called), tuple(notes)
