"""A topo-metric map of one cleaning run as plain arrays (§2.1, Appendix A).

A run is a few arrays in frozen dataclasses rather than thousands of objects.
Every array is checked when the map is made, so later stages need not.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dataset.camera import FisheyeCamera
from dataset.errors import FormatError

__all__ = ["GroundTruth", "Nodes", "Obstacles", "Path", "Settings", "TopoMap", "Visits"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Settings = Mapping[str, bool | int | float | str | tuple[float, ...]]
"""What a robot or its sensors are set to: names and values, SI units."""


def _check(name: str, array: Any, dtype: Any, shape: tuple[int | None, ...]) -> NDArray[Any]:
    """Return ``array`` as ``dtype``; refuse other shapes (None = any) and non-finite values."""
    checked: NDArray[Any] = np.asarray(array, dtype=dtype)
    if checked.ndim != len(shape) or any(
        want is not None and want != got for want, got in zip(shape, checked.shape, strict=True)
    ):
        raise FormatError(f"{name}: shape {checked.shape}, expected {shape}")
    if checked.dtype.kind == "f" and not np.isfinite(checked).all():
        raise FormatError(f"{name}: has values that are not finite")
    return checked


def _check_settings(name: str, settings: Settings) -> None:
    """Refuse settings that are no finite number, text, or tuple of finite numbers."""
    for setting, value in settings.items():
        numbers = value if isinstance(value, tuple) else (value,)
        good = all(isinstance(n, int | float) and math.isfinite(n) for n in numbers)
        if setting == "unit" or not (good or isinstance(value, str)):
            expected = "finite numbers, texts and tuples of numbers, none called unit"
            raise FormatError(f"{name}: {setting} is {value!r}, expected {expected}")


@dataclass(frozen=True)
class Nodes:
    """Map nodes, in order of creation.

    position (n, 2) m and heading (n,) rad are the robot's own estimates;
    part and lane (n,) are the indices of Algorithm 1, from 0; true_pose (n, 3) m, m,
    rad is where the camera really was, and tilt (n, 2) rad how it leaned: roll (left
    side up) and pitch (front down). None for a real robot.
    """

    position: Floats
    heading: Floats
    part: Ints
    lane: Ints
    true_pose: Floats | None = None
    tilt: Floats | None = None

    def __post_init__(self) -> None:
        n = len(self.position)
        put = object.__setattr__
        put(self, "position", _check("nodes/position", self.position, np.float64, (n, 2)))
        put(self, "heading", _check("nodes/heading", self.heading, np.float64, (n,)))
        put(self, "part", _check("nodes/part", self.part, np.int32, (n,)))
        put(self, "lane", _check("nodes/lane", self.lane, np.int32, (n,)))
        for name, index in (("part", self.part), ("lane", self.lane)):
            if n and index.min() < 0:
                raise FormatError(f"nodes/{name}: {index.min()}, expected >= 0")
        if self.true_pose is not None:
            put(self, "true_pose", _check("nodes/true_pose", self.true_pose, np.float64, (n, 3)))
        if self.tilt is not None:
            put(self, "tilt", _check("nodes/tilt", self.tilt, np.float64, (n, 2)))

    def __len__(self) -> int:
        return len(self.position)

    @property
    def camera_pose(self) -> Floats | None:
        """True pose and tilt, (n, 5) m, m, rad, rad, rad; None for a real robot."""
        if self.true_pose is None:
            return None
        tilt = np.zeros((len(self), 2)) if self.tilt is None else self.tilt
        return np.hstack([self.true_pose, tilt])


@dataclass(frozen=True)
class Visits:
    """Times of creation and revisits, T_k of Eq. A1: node (v,), time (v,) s, by time."""

    node: Ints
    time: Floats

    def __post_init__(self) -> None:
        v = len(self.node)
        object.__setattr__(self, "node", _check("visits/node", self.node, np.int32, (v,)))
        object.__setattr__(self, "time", _check("visits/time", self.time, np.float64, (v,)))


@dataclass(frozen=True)
class Obstacles:
    """Laser points: position (k, 2) m in the estimate's frame, time (k,) s, beam (k,)."""

    position: Floats
    time: Floats
    beam: NDArray[np.uint8]

    def __post_init__(self) -> None:
        k = len(self.position)
        put = object.__setattr__
        put(self, "position", _check("obstacles/position", self.position, np.float64, (k, 2)))
        put(self, "time", _check("obstacles/time", self.time, np.float64, (k,)))
        put(self, "beam", _check("obstacles/beam", self.beam, np.uint8, (k,)))


@dataclass(frozen=True)
class Path:
    """The driven path for looking and replaying.

    time (t,) s; true_pose and estimate (t, 3) m, m, rad; lane (t,) is the
    running number of the lane being driven, -1 between lanes.
    """

    time: Floats
    true_pose: Floats
    estimate: Floats
    lane: Ints

    def __post_init__(self) -> None:
        t = len(self.time)
        put = object.__setattr__
        put(self, "time", _check("path/time", self.time, np.float64, (t,)))
        put(self, "true_pose", _check("path/true_pose", self.true_pose, np.float64, (t, 3)))
        put(self, "estimate", _check("path/estimate", self.estimate, np.float64, (t, 3)))
        put(self, "lane", _check("path/lane", self.lane, np.int32, (t,)))


@dataclass(frozen=True)
class GroundTruth:
    """What a person says about the map (§3.1.1).

    borders (b, 2, 2) m: border segments in ``frame`` ('scene': crossed by
    true poses; 'map': crossed by estimates). edge_is_border (e,): edges that
    cross one. room (n,): room label of each node, or None before labelling.
    room_count: the number of rooms that the operator gives. room_names: what they
    are called, one for each label of ``room``, or None.
    """

    borders: Floats
    frame: str
    edge_is_border: NDArray[np.bool_]
    room_count: int
    room: Ints | None = None
    room_names: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "borders", _check("ground_truth/borders", self.borders, np.float64, (None, 2, 2)))
        put(
            self,
            "edge_is_border",
            _check("ground_truth/edge_is_border", self.edge_is_border, np.bool_, (None,)),
        )
        if self.frame not in ("scene", "map"):
            raise FormatError(f"ground_truth/borders frame: {self.frame!r}, expected scene or map")
        if self.room_count < 1:
            raise FormatError(f"ground_truth room_count: {self.room_count}, expected >= 1")
        if self.room is not None:
            put(self, "room", _check("ground_truth/room", self.room, np.int32, (None,)))
        if self.room_names is not None and len(self.room_names) != self.room_count:
            raise FormatError(
                f"ground_truth room_names: {len(self.room_names)} names, "
                f"expected {self.room_count}, one per room"
            )


@dataclass(frozen=True)
class TopoMap:
    """One cleaning run: everything in the map file but the images.

    Attributes
    ----------
    environment, run : str
        Name of the place (leave-one-environment-out groups by it) and of the run.
    seed : int
    created, software : str
        ISO date and software version.
    nodes, visits, obstacles : Nodes, Visits, Obstacles
    edges : array, shape (e, 2), int32
        Every adjacent, directly reachable pair, smaller index first (Fig. 4).
    robot_radius : float
        m.
    robot, sensor : Settings, optional
        Which robot made the map, and with what sensors; the simulator's settings, or
        whatever a real robot has to tell. A ``radius`` is ``robot_radius`` again.
    path, ground_truth, camera, scene : optional
        ``scene`` is the apartment's JSON text.
    """

    environment: str
    run: str
    seed: int
    created: str
    software: str
    nodes: Nodes
    edges: Ints
    visits: Visits
    obstacles: Obstacles
    robot_radius: float = 0.15
    path: Path | None = None
    ground_truth: GroundTruth | None = None
    camera: FisheyeCamera = field(default_factory=FisheyeCamera)
    scene: str | None = None
    robot: Settings | None = None
    sensor: Settings | None = None

    def __post_init__(self) -> None:
        _check_settings("robot", self.robot or {})
        _check_settings("sensor", self.sensor or {})
        radius = (self.robot or {}).get("radius", self.robot_radius)
        if radius != self.robot_radius:
            raise FormatError(
                f"robot: radius is {radius}, expected robot_radius {self.robot_radius}"
            )
        for name in ("environment", "run"):
            if not getattr(self, name):
                raise FormatError(f"{name}: empty, expected a name")
        edges = _check("edges", self.edges, np.int32, (None, 2))
        object.__setattr__(self, "edges", edges)
        n = len(self.nodes)
        for name, index in (("edges", edges), ("visits/node", self.visits.node)):
            outside = index[(index < 0) | (index >= n)]
            if len(outside):
                raise FormatError(f"{name}: node index {outside[0]}, expected 0..{n - 1}")
        if (edges[:, 0] >= edges[:, 1]).any():
            raise FormatError("edges: a pair is not (smaller, larger) node index")
        truth = self.ground_truth
        if truth is not None and len(truth.edge_is_border) != len(edges):
            raise FormatError(
                f"ground_truth/edge_is_border: {len(truth.edge_is_border)} values, "
                f"expected {len(edges)}, one per edge"
            )
        if truth is not None and truth.room is not None and len(truth.room) != n:
            raise FormatError(f"ground_truth/room: {len(truth.room)} values, expected {n}")

    @property
    def title(self) -> str:
        """Environment and run, once if they are the same."""
        same = self.environment == self.run
        return self.environment if same else f"{self.environment}, {self.run}"

    def edge_lengths(self) -> Floats:
        """Edge length l from the position estimates, m, shape (e,) (§2.2.1)."""
        position = self.nodes.position
        difference = position[self.edges[:, 0]] - position[self.edges[:, 1]]
        length: Floats = np.linalg.norm(difference, axis=1)
        return length

    def with_ground_truth(self, ground_truth: GroundTruth) -> TopoMap:
        """The same map with another ground truth."""
        return replace(self, ground_truth=ground_truth)
