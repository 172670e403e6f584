"""Driving one lane: nodes every 10 cm, edges to what is adjacent (§2.1, Figs. 3, 4).

A lane ends at an obstacle or where older nodes cover what lies ahead. After a
glancing contact it is moved aside a little rather than ended, so that a chair
leg does not cut it in two. A lane that nothing joins to the map is forgotten:
the map stays connected.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulator.frontier import free_run
from simulator.gridcells import Discs
from simulator.pilot import End, Pilot, direction
from simulator.robot import wrap

__all__ = ["Lane", "LaneDriver"]

Floats = NDArray[np.float64]

_FAR = 100.0
"""Longer than any lane, m."""
_DODGE = 0.03
"""A lane may be pushed aside that far by glancing contacts, m."""


@dataclass(frozen=True)
class Lane:
    """A driven lane: nodes first..last, its part, and the heading it was driven in."""

    first: int
    last: int
    part: int
    heading: float


class LaneDriver:
    """Drives lanes and adds their nodes and edges to the map.

    Attributes
    ----------
    headings : list of float
        Heading of every finished lane, by its running number, rad.
    forgotten : array, shape (f, 2)
        Where the nodes of forgotten lanes were, m: there is no use in trying again.
    """

    def __init__(self, pilot: Pilot, progress: Callable[[int, float], None] | None) -> None:
        self.pilot = pilot
        self.robot = pilot.robot
        self.headings: list[float] = []
        self.forgotten: Floats = np.zeros((0, 2))
        self._vehicle = pilot.vehicle
        self._progress = progress

    def lane_through(self, point: Floats, heading: float, part: int) -> Lane | None:
        """Complete a lane: on along ``heading`` without nodes, then back with nodes."""
        along = direction(heading)
        start = point + float(((self.pilot.position - point) * along).sum()) * along
        self.pilot.turn_to(heading)
        covered = self._vehicle.is_covered_ahead
        self.pilot.follow(heading, _FAR, start=start, stop=covered, dodge=_DODGE)
        self.pilot.turn_to(heading + np.pi)
        return self.lane_from_here(wrap(heading + np.pi), part, line=point)

    def lane_from_here(
        self,
        heading: float,
        part: int,
        *,
        line: Floats | None = None,
        opening: float | None = None,
    ) -> Lane | None:
        """Drive a lane from where the robot stands, facing ``heading``.

        Parameters
        ----------
        heading : float
            rad.
        part : int
        line : array, shape (2,), optional
            A point that the lane leads through; default: the robot's position.
        opening : float, optional
            For a piercing lane: the clearance, m, that the centre needs; the
            lane ends where there is room to either side.

        Returns
        -------
        Lane or None
            None if nothing joins the lane to the map.
        """
        vehicle = self._vehicle
        first = len(vehicle.graph)
        vehicle.lane = len(self.headings)
        start, along = self.pilot.position.copy(), direction(heading)
        self._make_node(part)

        def stop() -> bool:
            progress = float(((self.pilot.position - start) * along).sum())
            made = len(vehicle.graph) - first
            if progress >= made * self.robot.node_spacing - 0.005:
                self._make_node(part)
                return opening is not None and self._has_opened(heading, opening)
            return self._vehicle.is_covered_ahead()

        base = start if line is None else line + float(((start - line) * along).sum()) * along
        end = self.pilot.follow(heading, _FAR, start=base, stop=stop, dodge=_DODGE)
        if end is End.CONTACT:
            self.pilot.back_off()
        vehicle.lane = -1
        return self._finished(first, part, heading)

    def _finished(self, first: int, part: int, heading: float) -> Lane | None:
        """Join the lane to the map, or forget it if nothing joins it."""
        graph = self._vehicle.graph
        joined = first == 0 or graph.joins(first)
        if not joined and not self._join(first):
            self.forgotten = np.vstack([self.forgotten, graph.position[first:]])
            graph.remove_from(first)
            return None
        self.headings.append(heading)
        if self._progress is not None:
            self._progress(len(graph), self._vehicle.time)
        return Lane(first, len(graph) - 1, part, heading)

    def _join(self, first: int) -> bool:
        """Add the shortest direct edge between older nodes and those from ``first`` on."""
        graph = self._vehicle.graph
        pairs = [
            (float(np.hypot(*(graph.position[old] - graph.position[new]))), int(old), new)
            for new in range(first, len(graph))
            for old in graph.within(graph.position[new], 2.0 * self.robot.lane_spacing)
            if old < first
        ]
        for _, old, new in sorted(pairs):
            here, there = graph.position[old], graph.position[new]
            if self.pilot.can_drive(here, there, self.robot.edge_clearance):
                graph.add_edge(old, new)
                return True
        return False

    def _make_node(self, part: int) -> None:
        """A node where the robot stands, with edges to all adjacent nodes (Fig. 4).

        Within a lane only consecutive nodes are joined: Algorithm 1 removes
        nothing there, so longer edges would survive it.
        """
        graph, lane = self._vehicle.graph, self._vehicle.lane
        node = self._vehicle.add_node(part, lane)
        here = graph.position[node]
        near = graph.within(here, self.robot.edge_radius).tolist()
        others = [k for k in near if k != node and (graph.lane[k] != lane or k == node - 1)]
        there = graph.position[others]
        clear = self._vehicle.grid.are_clear(here, there, self.robot.edge_clearance)
        for other, is_free in zip(others, clear, strict=True):
            if is_free or graph.lane[other] == lane:
                graph.add_edge(other, node)

    def _has_opened(self, heading: float, clearance: float) -> bool:
        """Whether a piercing lane has come out of the narrow passage."""
        nothing = Discs(self._vehicle.graph.table(), 0.0)
        here = self.pilot.position[None]
        room = [
            free_run(self._vehicle.grid, nothing, here, heading + turn, clearance)[0]
            for turn in (0.5 * np.pi, -0.5 * np.pi)
        ]
        return bool(min(room) >= self.robot.piercing_opening)
