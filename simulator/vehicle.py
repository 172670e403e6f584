"""One time step of the robot: roll, touch, measure, correct, remember (§2.1).

The vehicle is the only place where truth and belief meet: it moves the true
body through the true world and hands the strategy nothing but the estimate,
the map, and the bumper.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dataset.topomap import Obstacles, Path
from simulator.graph import MapGraph
from simulator.gridmap import GridMap
from simulator.laser import SensorSpec, measure
from simulator.localisation import corrected_estimate
from simulator.robot import RobotSpec, WheelSlip, arc, wrap
from simulator.trigonometry import sine_cosine
from simulator.world import World

__all__ = ["Vehicle"]

Floats = NDArray[np.float64]

_FREE_WITHOUT_SPOT = 0.6
"""A beam without a spot counts as free only so far, m: the spot may be missing."""

_MARK_SPACING = 0.25
"""m."""

_RECENT = 5
"""The last nodes of the running lane say nothing new about the position."""


class Vehicle:
    """The body in the world, with its estimate, its map and its records."""

    def __init__(
        self,
        world: World,
        pose: Floats,
        robot: RobotSpec,
        sensor: SensorSpec,
        rng: np.random.Generator,
    ) -> None:
        self.robot = robot
        self.sensor = sensor
        self.graph = MapGraph()
        self.grid = GridMap(pose)
        self.estimate: Floats = np.array(pose, dtype=np.float64)
        self.time = 0.0
        self.lane = -1
        self.contact = 0.0
        """Where the bumper was last pressed, rad from the heading."""
        self._world = world
        self._rng = rng
        self._slip = WheelSlip(robot, rng)
        self._true = self.estimate.copy()
        self._bearings = sensor.bearings()
        self._gap = 0.0
        self._marks: list[Floats] = []
        self._next_scan = 0.0
        self._next_correction = 0.0
        self._points: list[Floats] = []
        self._rows: list[tuple[float, ...]] = []
        self.step(0.0, 0.0)

    def step(self, speed: float, turn_rate: float) -> bool:
        """Drive for one time step; returns whether the bumper was pressed."""
        dt, half = self.robot.time_step, 0.5 * turn_rate * self.robot.wheel_base
        left, right = (speed - half) * dt, (speed + half) * dt
        share, bearing = self._roll(left, right)
        base = self.robot.wheel_base
        self.estimate = arc(self.estimate, share * left, share * right, base)
        self.time += dt
        if bearing is not None:
            noise = float(self._rng.normal(0.0, self.sensor.bumper_noise))
            self.contact = wrap(bearing + noise)
            self.grid.add_contact(self.estimate, self.contact, self.robot.radius)
        self._sense()
        self.graph.visit(self.estimate, self.time, self.robot.visit_radius)
        self._rows.append((self.time, *self._true.tolist(), *self.estimate.tolist(), self.lane))
        return bearing is not None

    def add_node(self, part: int, lane: int) -> int:
        """Make a node where the robot stands."""
        tilt = self._world.covers.tilt(self._true, self.robot.wheel_base, self.robot.castor)
        pose = np.array([*self._true, *tilt])
        return self.graph.add_node(self.estimate, pose, part, lane, self.time)

    def obstacles(self) -> Obstacles:
        """All laser points so far."""
        rows = np.concatenate(self._points) if self._points else np.zeros((0, 4))
        return Obstacles(rows[:, :2], rows[:, 2], rows[:, 3].astype(np.uint8))

    def path(self) -> Path:
        """The driven path so far."""
        rows = np.array(self._rows)
        return Path(rows[:, 0], rows[:, 1:4], rows[:, 4:7], rows[:, 7].astype(np.int32))

    def trail(self) -> Floats:
        """The estimates along the last few minutes of the way, shape (t, 2), m."""
        return np.array([row[4:6] for row in self._rows[-4000:]])

    def _roll(self, left: float, right: float) -> tuple[float, float | None]:
        """Move the true body; the share of the step that was free and the contact's bearing."""
        rolled = self._slip.roll(left, right)
        base, radius = self.robot.wheel_base, self.robot.radius
        target = arc(self._true, *rolled, base)
        # No need to look again while the way since the last look was shorter than the gap.
        self._gap -= abs(left) + abs(right)
        if self._gap < radius:
            self._gap = self._world.nearest(target[0], target[1])[0]
        if self._gap >= radius:
            self._true = target
            return 1.0, None
        low, high = 0.0, 1.0
        for _ in range(10):
            share = 0.5 * (low + high)
            tried = arc(self._true, share * rolled[0], share * rolled[1], base)
            free = self._world.nearest(tried[0], tried[1])[0] >= radius
            low, high = (share, high) if free else (low, share)
        direction = self._world.nearest(target[0], target[1])[1]
        self._true = arc(self._true, low * rolled[0], low * rolled[1], base)
        return low, direction - self._true[2]

    def _sense(self) -> None:
        if self.time >= self._next_scan - 1e-9:
            self._next_scan = self.time + self.sensor.period
            self._scan()
        if self.time >= self._next_correction - 1e-9:
            self._next_correction = self.time + self.robot.correction_period
            self._correct()

    def _scan(self) -> None:
        reach = self.sensor.maximum_range
        ranges = measure(self._world.spots(self._true, self._bearings), self.sensor, self._rng)
        angles = self.estimate[2] + self._bearings
        self.grid.add_body(self.estimate, self.robot.radius)
        self.grid.add_scan(self.estimate, angles, ranges, min(_FREE_WITHOUT_SPOT, reach))
        beam = np.flatnonzero(np.isfinite(ranges))
        direction = np.array([sine_cosine(angle) for angle in angles[beam].tolist()]).reshape(-1, 2)
        points = self.estimate[:2] + ranges[beam, None] * direction[:, ::-1]
        self._points.append(np.column_stack([points, np.full(len(beam), self.time), beam]))

    def _correct(self) -> None:
        """Relate the image to those of nearby nodes, or of marks where there are no nodes."""
        nodes = self.graph.within(self.estimate, self.robot.correction_radius)
        if self.lane >= 0:
            nodes = nodes[nodes < len(self.graph) - _RECENT]
        nodes = nodes[: self.robot.correction_nodes]
        estimates, poses = self.graph.estimate[nodes], self.graph.true_pose[nodes]
        if len(nodes) == 0:
            estimates, poses = self._near_marks()
        self.estimate = corrected_estimate(
            self.estimate, self._true, estimates, poses, spec=self.robot, rng=self._rng
        )

    def _near_marks(self) -> tuple[Floats, Floats]:
        """Estimates and true poses of nearby marks, (k, 3) each; sets one where none is near.

        Away from its map the robot keeps images of its way, about four a metre,
        so that it finds back. They are no part of the map.
        """
        marks = np.array(self._marks).reshape(-1, 2, 3)
        away = np.hypot(*(marks[:, 0, :2] - self.estimate[:2]).T)
        if self.lane < 0 and (len(away) == 0 or away.min() > _MARK_SPACING):
            self._marks.append(np.stack([self.estimate, self._true]))
        near = np.argsort(away, kind="stable")[: self.robot.correction_nodes]
        near = near[away[near] <= self.robot.correction_radius]
        return marks[near, 0], marks[near, 1]
