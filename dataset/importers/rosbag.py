"""A ROS bag as a topo-metric map; ROS itself is not needed (package ``rosbags``).

A small TOML file names the topics: poses, ranges and camera. Times are those of the
recording. Poses need to be consistent over a few metres only (§2.1); odometry that is
corrected as the robot goes is better than wheels alone.
"""

from __future__ import annotations

import importlib
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from scipy.spatial import KDTree

from dataset.camera import FisheyeCamera
from dataset.errors import FormatError, RoomsegError
from dataset.importers import ImportedRun
from dataset.importers.edges import adjacent_pairs, connected_drive
from dataset.importers.images import grey_image
from dataset.importers.track import Track, drive_of
from dataset.topomap import Obstacles, TopoMap

__all__ = ["read_rosbag"]

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]

SCAN_PERIOD = 0.5
"""Of scans that come more often one in so many seconds counts."""
JUMP = 0.5
"""A longer step between two poses is no way that was driven, m."""
FARTHEST = 10_000.0
"""Of a pose from the origin, m."""
TOLERANCE = 0.5
"""An image is a node's if it was taken so near to its creation, s."""
LARGEST_TEXT = 100_000

POSES = ("Odometry", "PoseStamped", "PoseWithCovarianceStamped")
RANGES = ("LaserScan", "Range")
IMAGES = ("Image", "CompressedImage")

Positive = Annotated[float, Field(gt=0, le=1000, allow_inf_nan=False)]
Metres = Annotated[float, Field(ge=-10, le=10, allow_inf_nan=False)]
Degrees = Annotated[float, Field(ge=-360, le=360, allow_inf_nan=False)]


class _Fields(BaseModel):
    model_config = ConfigDict(extra="forbid")


class _Robot(_Fields):
    radius: Annotated[float, Field(gt=0, le=1)] = 0.17


class _Odometry(_Fields):
    topic: str


class _Range(_Fields):
    """One sensor: where it sits on the robot (x ahead, y left), and what of it counts."""

    topic: str
    position: tuple[Metres, Metres] = (0.0, 0.0)
    heading_deg: Degrees = 0.0
    maximum_range: Positive = 1.0
    beams: Annotated[int, Field(ge=1, le=255)] = 16


class _Camera(_Fields):
    topic: str
    field_of_view_deg: Annotated[float, Field(gt=0, le=360)]
    disc_diameter: Positive | None = None
    disc_centre: tuple[float, float] | None = None
    height: Positive = 0.10
    turn_deg: Literal[0, 90, 180, 270] = 0


class _Topics(_Fields):
    odometry: _Odometry
    robot: _Robot = _Robot()
    range: list[_Range] = []
    camera: _Camera | None = None


def read_rosbag(path: str | Path, *, topics: str | Path, name: str | None = None) -> ImportedRun:
    """Read a bag: a ROS 1 file, or the folder of a ROS 2 bag.

    Parameters
    ----------
    path : path
    topics : path
        TOML: which topics, and where sensors sit (docs/import.md).
    name : str, optional
        Of the environment; that of the bag by default.

    Raises
    ------
    RoomsegError
        If ``rosbags`` is not installed, or a file cannot be read or lacks a topic.
    """
    path = Path(path)
    bag, wanted = _Bag(path), _topics(Path(topics))
    track, begin = _track(bag, wanted.odometry.topic)
    points = _obstacles(bag, wanted.range, track, begin)
    drive = drive_of(track)
    edges = adjacent_pairs(drive, _clusters(points.position))
    drive, edges, notes = connected_drive(drive, edges)
    camera, images = FisheyeCamera(), None
    if wanted.camera is not None:
        created = drive.visits.time[np.unique(drive.visits.node, return_index=True)[1]]
        pictures = _Pictures.of(bag, wanted.camera, created + begin)
        camera, images = _camera(path, wanted.camera, pictures.size), pictures
        if missing := int((pictures.message < 0).sum()):
            notes = (*notes, f"{missing} of {len(created)} nodes have no image")
    topomap = TopoMap(
        environment=name or path.stem,
        run=path.stem,
        seed=0,
        created="",
        software="ROS",
        nodes=drive.nodes,
        edges=edges.astype(np.int32),
        visits=drive.visits,
        obstacles=points,
        robot_radius=wanted.robot.radius,
        camera=camera,
    )
    if not wanted.range:
        notes = (*notes, "no range topics: obstacles are unknown")
    return ImportedRun(topomap, notes, images)


def _topics(path: Path) -> _Topics:
    """The TOML file; one line for what is wrong with it."""
    try:
        if path.stat().st_size > LARGEST_TEXT:
            raise FormatError(f"{path}: too large, expected a small TOML file")
        return _Topics.model_validate(tomllib.loads(path.read_text(encoding="utf-8")))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FormatError(f"{path}: {error}; expected TOML") from None
    except ValidationError as error:
        fault = error.errors(include_url=False, include_context=False)[0]
        where = ".".join(str(place) for place in fault["loc"])
        raise FormatError(f"{path}: {where}: {fault['msg']} (see docs/import.md)") from None


@dataclass(frozen=True)
class _Bag:
    """Messages of a bag by topic."""

    path: Path

    def messages(self, topic: str, kinds: tuple[str, ...]) -> Iterator[tuple[float, Any]]:
        """Times, s, and functions that unpack the message."""
        with self._reader() as reader:
            chosen = [c for c in reader.connections if c.topic == topic]
            if not chosen:
                known = ", ".join(sorted({c.topic for c in reader.connections})) or "none"
                raise FormatError(f"{self.path}: no topic {topic}, expected one of: {known}")
            kind = chosen[0].msgtype.rsplit("/", 1)[-1]
            if kind not in kinds:
                raise FormatError(
                    f"{self.path}: {topic}: is {chosen[0].msgtype}, expected {' or '.join(kinds)}"
                )
            for connection, time, data in reader.messages(chosen):

                def unpack(data: bytes = data, kind: str = connection.msgtype) -> Any:
                    return reader.deserialize(data, kind)

                yield time * 1e-9, unpack

    @contextmanager
    def _reader(self) -> Iterator[Any]:
        try:
            highlevel = importlib.import_module("rosbags.highlevel")
            typesys = importlib.import_module("rosbags.typesys")
        except ImportError as error:
            raise RoomsegError(
                f"{self.path}: a ROS bag needs the package rosbags ({error}): "
                "pip install 'roomseg[ros]'"
            ) from error
        if self.path.is_file() and self.path.suffix != ".bag":
            raise FormatError(f"{self.path}: expected a .bag file, or the folder of a ROS 2 bag")
        try:
            store = typesys.get_typestore(typesys.Stores.LATEST)
            with highlevel.AnyReader([self.path], default_typestore=store) as reader:
                yield reader
        except RoomsegError:
            raise
        except Exception as error:  # of the reader, its database, or its decompression
            reason = " ".join(str(error).split()) or type(error).__name__
            raise FormatError(f"{self.path}: damaged bag ({reason})") from error


def _track(bag: _Bag, topic: str) -> tuple[Track, float]:
    """The poses, and the time of recording, s, at which theirs begin."""
    rows = []
    for time, unpack in bag.messages(topic, POSES):
        message = unpack()
        pose = message.pose.pose if hasattr(message.pose, "pose") else message.pose
        q = pose.orientation
        yaw = np.arctan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))
        rows.append((time, pose.position.x, pose.position.y, yaw))
    if not rows:
        raise FormatError(f"{bag.path}: {topic}: no messages, expected poses")
    table = np.array(rows, dtype=np.float64)
    if not (np.isfinite(table).all() and np.abs(table[:, 1:3]).max() < FARTHEST):
        raise FormatError(f"{bag.path}: {topic}: a pose is not finite, or beyond {FARTHEST:g} m")
    table = table[np.argsort(table[:, 0], kind="stable")]
    step = np.hypot(*np.diff(table[:, 1:3], axis=0).T)
    stroke = np.concatenate([[0], np.cumsum(step > JUMP)])
    begin = float(table[0, 0])
    return Track(table[:, 0] - begin, table[:, 1:3], table[:, 3], stroke), begin


def _obstacles(bag: _Bag, sensors: list[_Range], track: Track, begin: float) -> Obstacles:
    """Where ranges end, in the frame of the poses."""
    points, times = [np.empty((0, 2))], [np.empty(0)]
    beams = [np.empty(0, np.int64)]
    for number, sensor in enumerate(sensors):
        last = -np.inf
        for time, unpack in bag.messages(sensor.topic, RANGES):
            at = time - begin
            if at - last < SCAN_PERIOD - 1e-3 or not 0.0 <= at <= track.time[-1]:
                continue
            last = at
            ends = _ends(unpack(), sensor)
            points.append(_in_map(ends, track, at))
            times.append(np.full(len(ends), at))
            beams.append((number + np.arange(len(ends))) % 256)
    when = np.concatenate(times)
    order = np.argsort(when, kind="stable")
    beam = np.concatenate(beams)[order].astype(np.uint8)
    return Obstacles(np.concatenate(points)[order], when[order], beam)


def _ends(message: Any, sensor: _Range) -> Floats:
    """Ends of a message's ranges that count, (k, 2) m, x ahead and y left of the robot."""
    if hasattr(message, "ranges"):
        ranges = np.asarray(message.ranges, dtype=np.float64)
        chosen = np.unique(np.linspace(0, max(len(ranges) - 1, 0), sensor.beams).astype(np.int64))
        chosen = chosen[chosen < len(ranges)]
        bearing = message.angle_min + message.angle_increment * chosen
        ranges, low, high = ranges[chosen], message.range_min, message.range_max
    else:
        ranges, bearing = np.array([message.range], dtype=np.float64), np.zeros(1)
        low, high = message.min_range, message.max_range
    # At their maximum, and as infinity, sensors say that there is nothing.
    good = np.isfinite(ranges) & np.isfinite(bearing) & (ranges >= low) & (ranges < high)
    good &= ranges <= sensor.maximum_range
    angle = bearing[good] + np.radians(sensor.heading_deg)
    ends = ranges[good, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.asarray(ends + np.array(sensor.position))


def _in_map(points: Floats, track: Track, time: float) -> Floats:
    x, y = (np.interp(time, track.time, column) for column in track.position.T)
    heading = np.interp(time, track.time, np.unwrap(track.heading))
    cos, sin = np.cos(heading), np.sin(heading)
    return np.asarray(points @ np.array([[cos, sin], [-sin, cos]]) + (x, y))


def _clusters(points: Floats) -> Floats:
    """Points without false measurements: fewer than three within 10 cm (§2.2.2)."""
    if not len(points):
        return points
    near = KDTree(points).query_ball_point(points, 0.10, return_length=True)
    return np.asarray(points[near >= 3])


@dataclass(frozen=True)
class _Pictures:
    """Images of the nodes, read from the bag one after the other.

    ``message`` (n,): the number of the message of each node, ascending, -1 for none;
    ``size`` rows and columns.
    """

    bag: _Bag
    camera: _Camera
    message: NDArray[np.int64]
    size: tuple[int, int]

    @classmethod
    def of(cls, bag: _Bag, camera: _Camera, created: Floats) -> _Pictures:
        """Choose the image nearest in time to the creation of each node, s of recording."""
        times: list[float] = []
        rows, columns = 0, 0
        for time, unpack in bag.messages(camera.topic, IMAGES):
            if not times:
                rows, columns = cls._image(bag, camera, unpack).shape
            times.append(time)
        if not times:
            raise FormatError(f"{bag.path}: {camera.topic}: no messages, expected images")
        taken = np.maximum.accumulate(times)
        after = np.searchsorted(taken, created).clip(1, max(len(taken) - 1, 1))
        after = np.minimum(after, len(taken) - 1)
        before = np.maximum(after - 1, 0)
        nearer = np.abs(taken[before] - created) <= np.abs(taken[after] - created)
        nearest = np.where(nearer, before, after)
        near = np.abs(taken[nearest] - created) <= TOLERANCE
        return cls(bag, camera, np.where(near, nearest, -1), (rows, columns))

    @staticmethod
    def _image(bag: _Bag, camera: _Camera, unpack: Any) -> Image:
        return grey_image(unpack(), camera.turn_deg, f"{bag.path}: {camera.topic}")

    def __len__(self) -> int:
        return len(self.message)

    def __iter__(self) -> Iterator[Image | None]:
        messages = enumerate(self.bag.messages(self.camera.topic, IMAGES))
        number, image = -1, None
        for wanted in self.message.tolist():
            while number < wanted:
                number, (_, unpack) = next(messages)
                image = None
            if wanted >= 0 and image is None:
                image = self._image(self.bag, self.camera, unpack)
                if image.shape != self.size:
                    raise FormatError(
                        f"{self.bag.path}: {self.camera.topic}: an image of {image.shape} px, "
                        f"expected {self.size} as the first"
                    )
            yield image if wanted >= 0 else None


def _camera(where: Path, fields: _Camera, size: tuple[int, int]) -> FisheyeCamera:
    rows, columns = size
    try:
        return FisheyeCamera(
            field_of_view=float(np.radians(fields.field_of_view_deg)),
            disc_diameter=fields.disc_diameter or float(min(size)),
            image_size=size,
            disc_centre=fields.disc_centre or (rows / 2, columns / 2),
            height=fields.height,
        )
    except ValueError as error:
        raise FormatError(f"{where}: camera: {error}") from None
