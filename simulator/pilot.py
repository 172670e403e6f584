"""Driving: turning, straight lines, and paths over the robot's own map (§2.1)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np
from numpy.typing import NDArray

from simulator import steering
from simulator.detour import plan_detour
from simulator.robot import wrap
from simulator.steering import Line
from simulator.trigonometry import arctangent, sine_cosine
from simulator.vehicle import Vehicle

__all__ = ["End", "Pilot", "direction"]

Floats = NDArray[np.float64]

_ATTEMPTS = 4
"""Plans that are tried for one journey."""

_GLANCING = 0.2
"""A contact more than 11° off the direction of travel can be dodged, rad, ..."""
_SIDESTEP = 0.012
"""... by moving aside so far, m."""
_STUCK = 0.1
"""A journey that ended so near to its beginning, m, got stuck, ..."""
_FORGET = 0.4
"""... and the contacts so far around, m, are then forgotten."""
_BARRED = 0.1
"""The map's edges so near to where a journey failed, m, are avoided from then on."""
_RETRACE = 0.05
"""Spacing of the points of the way back, m."""
_PASSED = 0.1
"""So far behind, m, a contact says nothing about the way ahead."""
_MOST_MOVES = 12
"""A line that has been moved aside so often is given up."""
_NARROWEST = 0.003
"""Contacts on both sides so near to each other, m, leave no gap."""
_TOLERANCE = 0.03
"""The map may place an obstacle that much too near, m: noise and cell size."""


class End(Enum):
    """Why a straight drive ended."""

    ARRIVED = auto()
    CONTACT = auto()
    BLOCKED = auto()
    STOPPED = auto()


def direction(heading: float) -> Floats:
    """Unit vector of a heading, shape (2,)."""
    sine, cosine = sine_cosine(heading)
    return np.array([cosine, sine])


@dataclass
class _Aside:
    """How far a line is moved aside after contacts, to the left, m.

    One contact moves it a step away; between contacts on either side it is halved,
    so that the robot finds through a gap that is hardly wider than its body.
    """

    limit: float
    offset: float = 0.0
    low: float = -math.inf
    high: float = math.inf
    last: float = -math.inf
    moves: int = 0

    def move(self, progress: float, cross: float, on_left: bool) -> bool:
        """Take in a contact at ``progress`` along and ``cross`` beside the line, m.

        False if the line cannot be moved further.
        """
        self.moves += 1
        if progress > self.last + _PASSED:
            self.low, self.high = -math.inf, math.inf
        self.last = progress
        if on_left:
            self.high = min(self.high, cross)
        else:
            self.low = max(self.low, cross)
        if math.isfinite(self.low + self.high):
            self.offset = 0.5 * (self.low + self.high)
        else:
            self.offset = cross + (-_SIDESTEP if on_left else _SIDESTEP)
        possible = abs(self.offset) <= self.limit and self.high - self.low > _NARROWEST
        return possible and self.moves <= _MOST_MOVES


class Pilot:
    """Drives the vehicle by its estimate and its own map.

    Attributes
    ----------
    was_stuck : bool
        Whether the last journey had to `escape` from somewhere.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        self.vehicle = vehicle
        self.robot = vehicle.robot
        self.was_stuck = False

    @property
    def position(self) -> Floats:
        """Estimate of the position, shape (2,), m."""
        return self.vehicle.estimate[:2]

    def turn_to(self, heading: float) -> None:
        """Turn on the spot, the shorter way."""
        self.vehicle.turn_to(heading)

    def spin(self) -> None:
        """Look around once."""
        start = self.vehicle.estimate[2]
        for quarter in range(1, 5):
            self.turn_to(start + 0.5 * np.pi * quarter)

    def follow(
        self,
        heading: float,
        length: float,
        *,
        start: Floats | None = None,
        stop: Callable[[], bool] | None = None,
        careful: bool = True,
        dodge: float = 0.0,
    ) -> End:
        """Drive along a line until its end, an obstacle, or ``stop``.

        Parameters
        ----------
        heading : float
            Of the line, rad; the robot should face it already.
        length : float
            m from ``start``.
        start : array, shape (2,), optional
            A point of the line; default: where the robot is.
        stop : callable, optional
            Whether to stop; asked where the lane's next node is due or older nodes cover
            what lies ahead, and after every contact.
        careful : bool
            Stop before known obstacles rather than at the bumper.
        dodge : float
            After a glancing contact the line is moved aside, by so much in all, m.
        """
        line = Line(self.position if start is None else start, heading, length, 0.0)
        aside = _Aside(dodge)
        while True:
            why, progress, cross = self.vehicle.follow(
                line._replace(aside=aside.offset), careful=careful, watch=stop is not None
            )
            if why not in (steering.CONTACT, steering.ASK):
                return End.ARRIVED if why == steering.ARRIVED else End.BLOCKED
            if why == steering.CONTACT:
                bearing = wrap(self.vehicle.estimate[2] + self.vehicle.contact - heading)
                if abs(bearing) <= _GLANCING or not aside.move(progress, cross, bearing > 0.0):
                    return End.CONTACT
                self._sidestep(heading, aside.offset - cross)
            if stop is not None and stop():
                return End.STOPPED

    def _sidestep(self, heading: float, distance: float) -> None:
        """Back off and step aside, to the left if ``distance`` is positive, m."""
        aside = heading + math.copysign(0.5 * math.pi, distance)
        self.back_off(_SIDESTEP)
        self.turn_to(aside)
        self.follow(aside, abs(distance), careful=False)
        self.turn_to(heading)

    def back_off(self, distance: float = 0.03) -> None:
        """Reverse a little, so that the next turn is free."""
        speed = 0.5 * self.robot.speed
        steps = int(np.ceil(distance / (speed * self.robot.time_step)))
        self.vehicle.step(-speed, 0.0, steps)

    def drive_to(self, point: Floats, tries: int = 1) -> bool:
        """Turn towards a point (2,), m, and drive there; False if something is in the way.

        With more ``tries`` the robot also works its way past more than a graze.
        """
        for _ in range(tries):
            gap = point - self.position
            length = float(np.hypot(*gap))
            if length < 0.015:
                return True
            heading = arctangent(gap[1], gap[0])
            self.turn_to(heading)
            if self.follow(heading, length, careful=False, dodge=0.03 * tries) is End.CONTACT:
                self.back_off()
        return float(np.hypot(*(point - self.position))) < 0.05

    def drive_around(self, point: Floats) -> bool:
        """Drive to a point (2,), m, by the best way on the local grid; False if there is none."""
        radius = self.robot.radius
        for clearance in (radius + 0.02, radius - self.robot.caution, radius - 0.04):
            way = plan_detour(self.vehicle.grid, self.position, point, clearance)
            if len(way):
                return all(self.drive_to(place) for place in self._shortcut(way))
        return False

    def current_node(self) -> int:
        """The nearest node that the robot can drive to directly.

        Where there is none the robot has left its map: it first drives back
        the way it came.
        """
        node = self._node_in_reach()
        if node is None:
            self._retrace()
            node = self._node_in_reach()
        return int(self.vehicle.graph.within(self.position, np.inf)[0]) if node is None else node

    def _node_in_reach(self) -> int | None:
        graph = self.vehicle.graph
        limit = self.robot.radius - 2.0 * _TOLERANCE
        for node in graph.within(self.position, 0.5)[:20]:
            if self.can_drive(self.position, graph.position[node], limit):
                return int(node)
        return None

    def _retrace(self) -> None:
        """Drive back along the driven path until a node is near."""
        trail = self.vehicle.trail()
        spacing = self.robot.node_spacing
        aim = self.position
        for point in trail[::-1]:
            if float(np.hypot(*(point - aim))) < spacing:
                continue
            aim = point
            self.drive_to(aim)
            if self._node_in_reach() is not None:
                return

    def can_drive(self, start: Floats, end: Floats, clearance: float) -> bool:
        """Whether no known obstacle is nearer than ``clearance`` m to the straight way."""
        return self.vehicle.grid.is_clear(start, end, clearance)

    def travel(self, node: int) -> bool:
        """Drive to a node by the shortest path over the map (Dijkstra); False if that fails."""
        graph = self.vehicle.graph
        self.was_stuck = False
        for attempt in range(_ATTEMPTS):
            route = self._route(node)
            if not route:
                return False
            points = graph.position[route]
            if attempt == 0:
                points = self._shortcut(points)
            begin = self.position.copy()
            if self._drive_along(points):
                return True
            if float(np.hypot(*(self.position - begin))) < _STUCK:
                self.was_stuck = True
                self.escape()
            else:
                self.back_off()
        return False

    def _drive_along(self, points: Floats) -> bool:
        """Drive to way points (k, 2), m; what is in the way bars the map's edges there."""
        for point in points:
            if not (self.drive_to(point) or self.drive_around(point)):
                gap = point - self.position
                ahead = self.robot.radius * gap / max(float(np.hypot(*gap)), 1e-9)
                self.vehicle.graph.bar(self.position + ahead, _BARRED)
                return False
        return True

    def escape(self) -> bool:
        """Leave a place from which nothing can be reached: the way it came, or any way.

        What was felt there is forgotten: put into the map a little wrong, it may
        bar the way out. False if the robot cannot get away.
        """
        self.vehicle.grid.forget_contacts(self.position, _FORGET)
        begin = self.position.copy()
        for point in self._way_back(begin):
            if not self.drive_to(point, tries=3):
                break
        behind = self.vehicle.estimate[2] + self.vehicle.contact + np.pi
        for turn in (0.0, 0.25, -0.25, 0.5, -0.5, 0.75, -0.75, 1.0):
            if float(np.hypot(*(self.position - begin))) >= _STUCK:
                return True
            heading = wrap(behind + turn * np.pi)
            self.turn_to(heading)
            self.follow(heading, 2.0 * _STUCK, careful=False)
        return float(np.hypot(*(self.position - begin))) >= _STUCK

    def _way_back(self, begin: Floats) -> Floats:
        """The way that led here, backwards and without its loops, about 1 m of it, (k, 2) m."""
        way = [begin]
        for point in self.vehicle.trail()[::-1]:
            gap = np.array(way) - point
            if (gap * gap).sum(axis=1).min() > _RETRACE**2:
                way.append(point)
                if len(way) * _RETRACE > 1.0:
                    break
        return np.array(way[1:]).reshape(-1, 2)

    def _route(self, goal: int) -> list[int]:
        """Nodes from the current one to ``goal``; empty if there is no path."""
        node = self.current_node()
        route: list[int] = []
        _, previous = self.vehicle.graph.routes(goal, node)
        while node != goal:
            route.append(node)
            node = int(previous[node])
            if node < 0:
                return []
        return [*route, goal]

    def _shortcut(self, points: Floats) -> Floats:
        """Drop way points while the straight line stays free and the way stays near nodes."""
        kept, here, k = [], self.position, 0
        while k < len(points):
            best = k
            for ahead in range(k + 1, min(k + 12, len(points))):
                if self.can_drive(here, points[ahead], self.robot.radius):
                    best = ahead
            kept.append(points[best])
            here, k = points[best], best + 1
        return np.array(kept)
