"""Runs of time steps, as machine code: turning, and following a straight line (§2.1).

They read nothing but the robot's estimate and its own map, and end where the pilot has
to decide.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import compiled, is_kept
from simulator.graph import Table, distance_at
from simulator.gridcells import is_blocked_ahead
from simulator.motion import NOW, Machine, Settings, has_room, step
from simulator.robot import wrap
from simulator.trigonometry import arctangent, sine_cosine

__all__ = ["ASK", "Ended", "Line", "drive", "follow", "is_covered_ahead", "turn"]

Floats = NDArray[np.float64]

ARRIVED, BLOCKED, CONTACT, ASK, NO_ROOM = range(5)
"""Why a run ended; ASK: a node may be due; NO_ROOM: the records or the grid are full."""

_AHEAD = 0.01
"""A drive stops when the body is this near to a known obstacle, m, ..."""
_FRONTAL = 0.7
"""... that lies within 45° of the direction of travel (cosine)."""
_DUE_EARLY = 0.005 + 1e-9
"""A lane's node may be due so much before the node spacing is driven, m."""


class Line(NamedTuple):
    """A straight line: ``start`` (2,) m, ``heading`` rad, ``length`` m.

    It is driven ``aside`` m to its left.
    """

    start: Floats
    heading: float
    length: float
    aside: float


class Ended(NamedTuple):
    """Why a run of time steps ended, and where along and beside the line its last step began, m."""

    why: int
    progress: float = 0.0
    cross: float = 0.0


def is_compiled() -> bool:
    """Tell whether a run can begin at once, without compiling the time steps first."""
    return is_kept(turn)


@compiled
def drive(
    machine: Machine, speed: float, turn_rate: float, end: float, rng: np.random.Generator
) -> Ended:
    """Drive at a speed, m/s, and a turn rate, rad/s, until the time ``end``, s."""
    while machine.body.clock[NOW] < end - 0.5 * machine.settings.time_step:
        if not has_room(machine):
            return Ended(NO_ROOM)
        if step(machine, speed, turn_rate, rng):
            return Ended(CONTACT)
    return Ended(ARRIVED)


@compiled
def turn(machine: Machine, heading: float, steps: int, rng: np.random.Generator) -> Ended:
    """Turn on the spot, the shorter way; given up after so many ``steps``."""
    dt = machine.settings.time_step
    most = machine.settings.turn_rate * dt
    for _ in range(steps):
        error = wrap(heading - machine.body.estimate[2])
        if abs(error) < 0.01:
            break
        if not has_room(machine):
            return Ended(NO_ROOM)
        step(machine, 0.0, min(max(error, -most), most) / dt, rng)
    return Ended(ARRIVED)


@compiled
def follow(
    machine: Machine, line: Line, careful: bool, watch: bool, rng: np.random.Generator
) -> Ended:
    """Drive along a line until something happens.

    Parameters
    ----------
    careful : bool
        Stop before known obstacles rather than at the bumper.
    watch : bool
        Stop also where the next node of the lane is due, or older nodes cover what lies
        ahead (`is_covered_ahead`).
    """
    estimate, settings = machine.body.estimate, machine.settings
    made = machine.nodes.total - machine.nodes.older
    while True:
        progress, cross = _along(line, estimate)
        if line.length - progress < 0.004:
            return Ended(ARRIVED, progress, cross)
        distance = settings.radius + _AHEAD
        if careful and is_blocked_ahead(machine.grid, estimate, distance, _FRONTAL):
            return Ended(BLOCKED, progress, cross)
        if not has_room(machine):
            return Ended(NO_ROOM, progress, cross)
        speed, turn_rate = _steering(machine, line, progress, cross)
        if step(machine, speed, turn_rate, rng):
            return Ended(CONTACT, progress, cross)
        if watch:
            due = made * settings.node_spacing - _DUE_EARLY
            if machine.lane >= 0 and _along(line, estimate)[0] >= due:
                return Ended(ASK, progress, cross)
            if is_covered_ahead(machine.nodes, estimate, settings):
                return Ended(ASK, progress, cross)


@compiled
def is_covered_ahead(nodes: Table, pose: Floats, settings: Settings) -> bool:
    """Whether nodes of other lanes already cover what lies one node spacing ahead."""
    ahead_y, ahead_x = sine_cosine(pose[2])
    x, y = pose[0] + settings.node_spacing * ahead_x, pose[1] + settings.node_spacing * ahead_y
    limit = settings.overlap_radius
    then = distance_at(nodes, x, y, limit)
    return then < limit and then < distance_at(nodes, pose[0], pose[1], limit)


@compiled
def _along(line: Line, pose: Floats) -> tuple[float, float]:
    """Where a pose is along and beside a line, m."""
    x, y = pose[0] - line.start[0], pose[1] - line.start[1]
    along_y, along_x = sine_cosine(line.heading)
    return x * along_x + y * along_y, along_x * y - along_y * x


@compiled
def _steering(machine: Machine, line: Line, progress: float, cross: float) -> tuple[float, float]:
    """Speed and turn rate that lead back to the line."""
    settings = machine.settings
    off = arctangent(4.0 * (cross - line.aside), 1.0)
    error = wrap(line.heading - off - machine.body.estimate[2])
    turn_rate = min(max(3.0 * error, -settings.turn_rate), settings.turn_rate)
    speed = min(settings.speed, (line.length - progress) / settings.time_step)
    return speed * max(sine_cosine(error)[1], 0.1), turn_rate
