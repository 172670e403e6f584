"""The cleaning strategy: lanes, parts, piercing lanes, and home (§2.1).

What the paper says: drive along parallel lanes; after each lane try to add a
parallel one in the opposite direction; when none can be added, begin a new part
with a lane along the boundary of what is covered; pierce narrow passages; use
the map to get to the next lane and home.

What we chose: a part grows to one side of its first lane, so that lane k - 1
is always the neighbour of lane k (Algorithm 1); the other side becomes a part
of its own. The next lane begins beside the old lane's end. Where free floor is
seen beyond, the robot first drives on there without making nodes, so that the
lane is complete. A lane ends at an obstacle or where the floor ahead is covered.
Places that could not be reached are remembered as tried and not tried again:
every attempt adds a node or uses up a place, so the run ends.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from simulator.alignment import wall_heading
from simulator.frontier import (
    Entrance,
    Frontier,
    find_frontiers,
    free_run,
    outlook,
    propose_entrance,
)
from simulator.gridcells import Discs
from simulator.lanes import Lane, LaneDriver
from simulator.outlook import Outlook
from simulator.pilot import Pilot, direction
from simulator.robot import RobotSpec, wrap
from simulator.vehicle import Vehicle

__all__ = ["CoverageStrategy"]

Floats = NDArray[np.float64]

_SECOND_CHANCES = 30
"""So often in a run a place is not given up because the robot was stuck on its way."""

_ROUNDS = 3
"""So often in a run all places that were not reached are tried again."""
_BETWEEN_BEAMS = 0.1
"""When nothing else is left, floor that narrow between two beams counts as seen, too, m."""
_BOLD = 2.0
"""A place that only a bold plan reaches counts as so much farther away, m."""


@dataclass(frozen=True)
class _Neighbour:
    """Where the next lane of a part begins: leave ``node``, enter at ``point``."""

    node: int
    point: Floats


def _nowhere() -> Floats:
    return np.zeros((0, 2))


@dataclass
class _Plan:
    """How boldly the robot plans.

    ``clearance`` that its centre needs, m; ``toll``: its places count as so much farther
    away, m; ``tries`` to drive to a place: a tight gap is often missed at first;
    ``view`` of what is left to cover so; ``tried`` (t, 2) m: places that are not entered
    again; ``unreached`` (u, 2) m: those that could not be reached.
    """

    clearance: float
    toll: float
    tries: int
    view: Outlook
    tried: Floats = field(default_factory=_nowhere)
    unreached: Floats = field(default_factory=_nowhere)


def _plan(robot: RobotSpec, caution: float, toll: float, tries: int) -> _Plan:
    """Plan ``caution`` m nearer to obstacles than the radius."""
    clearance = robot.radius - caution
    return _Plan(clearance, toll, tries, outlook(robot, clearance))


class CoverageStrategy:
    """Decides from the map what to drive next.

    Parameters
    ----------
    vehicle : Vehicle
        Standing at the base.
    progress : callable, optional
        Called with (nodes, simulated seconds) after every lane.
    """

    def __init__(
        self, vehicle: Vehicle, progress: Callable[[int, float], None] | None = None
    ) -> None:
        self.vehicle = vehicle
        self.pilot = Pilot(vehicle)
        self.robot = vehicle.robot
        self.lanes = LaneDriver(self.pilot, progress)
        self._usual = _plan(vehicle.robot, vehicle.robot.caution, 0.0, tries=1)
        self._bold = _plan(vehicle.robot, vehicle.robot.last_caution, _BOLD, tries=3)
        self._plan = self._usual
        self._parts = 0
        self._second_chances = _SECOND_CHANCES
        self._rounds = _ROUNDS

    def run(self) -> None:
        """Cover everything that can be reached, then return to the base."""
        lane = self._first_lane()
        while lane is not None:
            self._meander(lane)
            lane = self._new_part()
        self.pilot.travel(0)

    def _first_lane(self) -> Lane | None:
        """Look around, then drive a lane from the base along the walls in sight."""
        self.pilot.spin()
        heading = float(self.vehicle.estimate[2])
        if self.robot.align_to_walls:
            heading = wall_heading(self.vehicle.obstacles().position, heading)
        self.pilot.turn_to(heading)
        self._parts = 1
        return self.lanes.lane_from_here(heading, part=0)

    # -- lanes of one part ---------------------------------------------------------------

    def _meander(self, lane: Lane) -> None:
        """Add parallel lanes on one side until none can be added."""
        left = self._neighbour(lane, +1)
        right = self._neighbour(lane, -1)
        if left is None and right is None:
            return
        side = 1 if right is None else -1
        if left is not None and right is not None:
            side = self._wider_side(lane, left, right)
        while True:
            found = self._neighbour(lane, side)
            if found is None:
                return
            following = self._add_parallel(lane, found)
            if following is not None:
                # Driven the other way, the same side of the floor is the other hand.
                side = -side if abs(wrap(following.heading - lane.heading)) > 1.0 else side
                lane = following

    def _wider_side(self, lane: Lane, left: _Neighbour, right: _Neighbour) -> int:
        """+1 if there is more seen free floor to the left of the lane, else -1."""
        runs = [
            self._free_run(start.point, lane.heading + side * 0.5 * np.pi)
            for start, side in ((left, 1), (right, -1))
        ]
        return 1 if runs[0] >= runs[1] else -1

    def _neighbour(self, lane: Lane, side: int) -> _Neighbour | None:
        """The best start beside a lane, at its left (+1) or right (-1)."""
        nominal, tight = self.robot.lane_spacing, self.robot.squeeze_spacing
        for spacing in (nominal, 0.5 * (nominal + tight), tight):
            found = self._neighbour_at(lane, side, spacing)
            if found is not None:
                return found
        return None

    def _neighbour_at(self, lane: Lane, side: int, spacing: float) -> _Neighbour | None:
        along = direction(lane.heading)
        normal = side * np.array([-along[1], along[0]])
        nodes = np.arange(lane.first, lane.last + 1)
        old = self.vehicle.graph.position[nodes]
        # One straight line, not a copy of the old lane's wobble.
        across = float((old * normal).sum(axis=1).mean()) + spacing
        points = (old * along).sum(axis=1)[:, None] * along + across * normal
        valid = self._is_uncovered(points, spacing)
        for k in np.flatnonzero(valid)[::-1]:
            if not self.pilot.can_drive(old[k], points[k], self._plan.clearance):
                continue
            if self._length_through(points[k], lane.heading) >= self.robot.minimum_lane:
                return _Neighbour(int(nodes[k]), points[k])
        return None

    def _is_uncovered(self, points: Floats, spacing: float) -> NDArray[np.bool_]:
        """Open for the centre, away from nodes, and not tried before."""
        valid = self.vehicle.grid.is_open(points, self._plan.clearance)
        limit = min(self.robot.cover_radius, spacing - 0.05)
        valid &= self.vehicle.graph.distances(points) > limit
        tried = self._tried(self._plan)
        low, high = points.min(axis=0) - 0.2, points.max(axis=0) + 0.2
        gap = points[:, None] - tried[((tried > low) & (tried < high)).all(axis=1)]
        return np.asarray(valid & (np.hypot(gap[..., 0], gap[..., 1]) > 0.1).all(axis=1))

    def _length_through(self, point: Floats, heading: float) -> float:
        """Seen free length of a lane through a point, m."""
        return self._free_run(point, heading) + self._free_run(point, heading + np.pi)

    def _free_run(self, point: Floats, heading: float) -> float:
        """Seen free length from a point along a heading, m."""
        covered = Discs(self.vehicle.graph.table(), self.robot.overlap_radius)
        run = free_run(self.vehicle.grid, covered, point[None], heading, self._plan.clearance)
        return float(run[0])

    def _add_parallel(self, lane: Lane, start: _Neighbour) -> Lane | None:
        """Drive the lane beside ``lane``; None if it could not be begun."""
        if not self._enter(start.node, start.point):
            return None
        following = self.lanes.lane_through(start.point, lane.heading, lane.part)
        self._give_up_if_uncovered(start.point)
        return following

    # -- new parts -----------------------------------------------------------------------

    def _new_part(self) -> Lane | None:
        """Begin a part at the nearest frontier; None if there is none left."""
        while True:
            entrance = self._nearest_entrance()
            if entrance is None:
                return None
            lane = None
            if self._enter(entrance.node, entrance.point):
                lane = self._begin_part(entrance)
                self._give_up_if_uncovered(entrance.point)
            self._plan = self._usual
            if lane is not None:
                self._parts += 1
                return lane

    def _begin_part(self, entrance: Entrance) -> Lane | None:
        if entrance.piercing:
            self.pilot.turn_to(entrance.heading)
            return self.lanes.lane_from_here(
                entrance.heading, self._parts, opening=self._plan.clearance
            )
        return self.lanes.lane_through(entrance.point, entrance.heading, self._parts)

    def _nearest_entrance(self) -> Entrance | None:
        """The entrance to the frontier that is nearest by the map's paths, and its plan."""
        while True:
            found = self._frontiers()
            if not found:
                self._look_again()
                found = self._frontiers()
            if not found:
                return None
            for _, plan, frontier in found:
                entrance = self._entrance(frontier, plan)
                if entrance is not None:
                    self._plan = plan
                    return entrance
                plan.tried = np.vstack([plan.tried, frontier.points[::4]])

    def _look_again(self) -> None:
        """Before going home: count more as seen, and try once more what was not reached."""
        self.vehicle.grid.bridge_seen(_BETWEEN_BEAMS)
        if self._rounds > 0:
            self._rounds -= 1
            self.lanes.forgotten = _nowhere()
            for plan in (self._usual, self._bold):
                plan.unreached = _nowhere()

    def _frontiers(self) -> list[tuple[float, _Plan, Frontier]]:
        """What either plan could reach, the nearest first, with its way and toll, m."""
        grid, graph = self.vehicle.grid, self.vehicle.graph
        length, _ = graph.routes(self.pilot.current_node())
        found: list[tuple[float, _Plan, Frontier]] = []
        for plan in (self._usual, self._bold):
            nearer = [place for place in found if place[0] <= plan.toll]
            if nearer:
                # No place of this plan can come before them: no need to look.
                return sorted(nearer, key=itemgetter(0))
            found += [
                (plan.toll + self._way(frontier, length), plan, frontier)
                for frontier in find_frontiers(
                    grid, graph.position, self._tried(plan), self.robot, plan.view
                )
            ]
        return sorted(found, key=itemgetter(0))

    def _tried(self, plan: _Plan) -> Floats:
        """Places that are not tried again, (t, 2) m."""
        return np.vstack([plan.tried, plan.unreached, self.lanes.forgotten])

    def _entrance(self, frontier: Frontier, plan: _Plan) -> Entrance | None:
        graph = self.vehicle.graph
        return propose_entrance(
            self.vehicle.grid,
            graph,
            frontier,
            self.lanes.headings[graph.lane[frontier.node[0]]],
            spec=self.robot,
            clearance=plan.clearance,
        )

    @staticmethod
    def _way(frontier: Frontier, length: Floats) -> float:
        return float((length[frontier.node] + frontier.distance).min())

    # -- leaving the map -----------------------------------------------------------------

    def _enter(self, node: int, point: Floats) -> bool:
        """Leave the map at ``node`` and drive to ``point``; remember a failure."""
        pilot = self.pilot
        direct = float(np.hypot(*(point - pilot.position))) < 2.0 * self.robot.lane_spacing
        direct = direct and pilot.can_drive(pilot.position, point, self.robot.radius)
        if direct and pilot.drive_to(point):
            return True
        if pilot.travel(node) and (
            pilot.drive_to(point, self._plan.tries) or pilot.drive_around(point)
        ):
            return True
        if float(np.hypot(*(point - pilot.position))) < 0.1:
            return True
        if pilot.was_stuck and self._second_chances > 0:
            # The place is not to blame, and is worth another try from elsewhere.
            self._second_chances -= 1
        else:
            self._plan.unreached = np.vstack([self._plan.unreached, point])
        return False

    def _give_up_if_uncovered(self, point: Floats) -> None:
        """Remember a place that was entered but that the lane did not cover."""
        if self.vehicle.graph.distances(point[None])[0] > self.robot.cover_radius:
            self._plan.tried = np.vstack([self._plan.tried, point])
