"""The robot: its body in the true world, its estimate, its map and its records (§2.1).

The vehicle is the only place where truth and belief meet: it moves the true
body through the true world and hands the strategy nothing but the estimate,
the map, and the bumper. Its time steps are in `simulator.motion`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from dataset.errors import RoomsegError
from dataset.topomap import Obstacles, Path
from simulator import motion, steering
from simulator.graph import MapGraph
from simulator.gridmap import GridMap
from simulator.laser import SensorSpec
from simulator.localisation import Trust
from simulator.motion import Body, Log, Machine, Settings
from simulator.robot import RobotSpec, wheel_slip
from simulator.steering import Ended, Line
from simulator.world import World

__all__ = ["Vehicle"]

Floats = NDArray[np.float64]

_ROWS = 256
"""So many rows of every record are kept free: more than a time step can fill."""
_TURN_STEPS = 200
"""A turn takes no more steps."""


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
        self.lane = -1
        self._world = world
        self._rng = rng
        self._slip = wheel_slip(robot, rng)
        true = np.array(pose, dtype=np.float64)
        self._body = Body(true, true.copy(), np.zeros(3), np.zeros(1), np.zeros(1))
        rows = [np.zeros((2 * _ROWS, *shape)) for shape in ((8,), (4,), (2, 3))]
        self._log = Log(rows[0], rows[1], rows[2], np.zeros(3, np.int64))
        settings = vars(sensor) | vars(robot)
        self._settings = Settings(*(settings[name] for name in Settings._fields))
        self._bearings, self._look = sensor.bearings(), sensor.look()
        self._trust = Trust(*(float(getattr(robot, name)) for name in Trust._fields))
        self.step(0.0, 0.0)

    @property
    def estimate(self) -> Floats:
        """Where the robot believes to be, (3,) m, m, rad."""
        return self._body.estimate.copy()

    @property
    def contact(self) -> float:
        """Where the bumper was last pressed, rad from the heading."""
        return float(self._body.contact[0])

    @property
    def time(self) -> float:
        """Since the start, s."""
        return float(self._body.clock[motion.NOW])

    def step(self, speed: float, turn_rate: float, steps: int = 1) -> bool:
        """Drive for some time steps, or until the bumper is pressed; returns whether it was."""
        end = self.time + steps * self.robot.time_step
        return self._run(steering.drive, speed, turn_rate, end).why == steering.CONTACT

    def turn_to(self, heading: float) -> None:
        """Turn on the spot, the shorter way."""
        self._run(steering.turn, heading, _TURN_STEPS)

    def follow(self, line: Line, *, careful: bool, watch: bool) -> Ended:
        """Drive along a line until something happens; see `simulator.steering.follow`."""
        return self._run(steering.follow, line, careful, watch)

    def is_covered_ahead(self) -> bool:
        """Whether older nodes already cover what lies one node spacing ahead."""
        nodes = self.graph.table(self.lane)
        return steering.is_covered_ahead(nodes, self._body.estimate, self._settings)

    def add_node(self, part: int, lane: int) -> int:
        """Make a node where the robot stands."""
        return self.graph.add_node(self._body.estimate, self._body.true, part, lane, self.time)

    def tilt(self) -> Floats:
        """True roll and pitch at all nodes, shape (n, 2), rad; for the record only."""
        covers, robot = self._world.covers, self.robot
        return covers.tilt(self.graph.true_pose, robot.wheel_base, robot.castor)

    def obstacles(self) -> Obstacles:
        """All laser points so far."""
        rows = self._log.points[: self._log.used[motion.POINTS]].copy()
        return Obstacles(rows[:, :2], rows[:, 2], rows[:, 3].astype(np.uint8))

    def path(self) -> Path:
        """The driven path so far."""
        rows = self._rows().copy()
        return Path(rows[:, 0], rows[:, 1:4], rows[:, 4:7], rows[:, 7].astype(np.int32))

    def trail(self) -> Floats:
        """The estimates along the last few minutes of the way, shape (t, 2), m."""
        return self._rows()[-4000:, 4:6].copy()

    def _rows(self) -> Floats:
        return self._log.path[: self._log.used[motion.PATH]]

    def _run(self, steps: Callable[..., Ended], *settings: object) -> Ended:
        """Run compiled steps, again as long as they end for want of room."""
        while True:
            self._make_room()
            before = int(self._log.used[motion.PATH])
            ended = steps(self._machine(), *settings, self._rng)
            rows = self._rows()[before:]
            self.graph.visit(rows[:, 4:6], rows[:, 0], self.robot.visit_radius)
            if ended.why != steering.NO_ROOM:
                return ended

    def _machine(self) -> Machine:
        return Machine(
            self._body,
            self._slip,
            self._world.touched,
            self._world.seen,
            self.grid.table,
            self.graph.table(self.lane),
            self._log,
            self.lane,
            self._settings,
            self._bearings,
            self._look,
            self._trust,
        )

    def _make_room(self) -> None:
        """For more steps, in the grid and in the records.

        Raises
        ------
        RoomsegError
            If the run takes longer than ``robot.time_limit``.
        """
        if self.time > self.robot.time_limit:
            raise RoomsegError(
                f"time_limit: the run is not done after {self.time:.0f} s of simulated time"
            )
        self.grid.hold(self._body.estimate, motion.margin(self._look))
        used, log = self._log.used, self._log
        self._log = Log(
            _with_room(log.path, used[motion.PATH]),
            _with_room(log.points, used[motion.POINTS]),
            _with_room(log.marks, used[motion.MARKS]),
            used,
        )


def _with_room(rows: Floats, used: int) -> Floats:
    """The same rows, or twice as many where almost all are used."""
    return rows if len(rows) - used >= _ROWS else np.concatenate([rows, np.zeros_like(rows)])
