"""The robot's time steps, as machine code: roll, touch, measure, correct, record (§2.1).

Here truth and belief meet: the true body moves through the true plan, and the estimate
and the robot's own map learn of it what wheels, bumper, lasers and camera tell.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simulator import gridcells
from simulator.compiled import compiled
from simulator.graph import Table, nearest_first, sort_by
from simulator.gridcells import Cells
from simulator.laser import Look, measure
from simulator.localisation import Trust, corrected_estimate
from simulator.robot import WheelSlip, arc, roll, wrap
from simulator.trigonometry import sine_cosine
from simulator.world import Walls, nearest, spots

__all__ = ["Body", "Log", "Machine", "Settings", "has_room", "margin", "step"]

Floats = NDArray[np.float64]

NOW, NEXT_SCAN, NEXT_CORRECTION = 0, 1, 2
"""Entries of `Body.clock`."""
PATH, POINTS, MARKS = 0, 1, 2
"""Entries of `Log.used`."""
LANE = 7
"""Column of `Log.path`."""

_FREE_WITHOUT_SPOT = 0.6
"""A beam without a spot counts as free only so far, m: the spot may be missing."""
_MARK_SPACING = 0.25
"""m."""
_RECENT = 5
"""The last nodes of the running lane say nothing new about the position."""
_MARGIN = 0.3
"""The grid reaches so much further than beams and body, m."""


class Body(NamedTuple):
    """What a time step changes.

    ``true``, ``estimate`` (3,): poses, m, m, rad. ``clock`` (3,): now, the next scan and the
    next correction, s. ``gap`` (1,): the body is free so far around, m. ``contact`` (1,):
    where the bumper was last pressed, rad from the heading.
    """

    true: Floats
    estimate: Floats
    clock: Floats
    gap: Floats
    contact: Floats


class Log(NamedTuple):
    """Records; the first ``used`` (3,) rows of each are in use.

    ``path`` (t, 8): time, true pose, estimate, lane. ``points`` (p, 4): laser point (x, y),
    time, beam. ``marks`` (m, 2, 3): estimate and true pose.
    """

    path: Floats
    points: Floats
    marks: Floats
    used: NDArray[np.int64]


class Settings(NamedTuple):
    """Of `simulator.robot.RobotSpec` and `simulator.laser.SensorSpec`."""

    radius: float
    wheel_base: float
    speed: float
    turn_rate: float
    time_step: float
    node_spacing: float
    overlap_radius: float
    correction_period: float
    correction_radius: float
    correction_nodes: int
    period: float
    bumper_noise: float


class Machine(NamedTuple):
    """All that a time step reads and changes; ``lane`` is -1 between lanes."""

    body: Body
    slip: WheelSlip
    touched: Walls
    seen: Walls
    grid: Cells
    nodes: Table
    log: Log
    lane: int
    settings: Settings
    bearings: Floats
    look: Look
    trust: Trust


@compiled
def margin(look: Look) -> float:
    """The grid has to reach so far around the estimate before a step, m."""
    return max(1.0, look.maximum_range) + _MARGIN


@compiled
def has_room(machine: Machine) -> bool:
    """Whether grid and records have room for another step."""
    used, log = machine.log.used, machine.log
    return (
        used[PATH] < len(log.path)
        and used[POINTS] + len(machine.bearings) <= len(log.points)
        and used[MARKS] < len(log.marks)
        and gridcells.holds(machine.grid, machine.body.estimate, margin(machine.look))
    )


@compiled
def step(machine: Machine, speed: float, turn_rate: float, rng: np.random.Generator) -> bool:
    """Drive for one time step; returns whether the bumper was pressed.

    There must be room for it (`has_room`).
    """
    body, settings = machine.body, machine.settings
    dt, half = settings.time_step, 0.5 * turn_rate * settings.wheel_base
    left, right = (speed - half) * dt, (speed + half) * dt
    share, bearing = _move(machine, left, right, rng)
    body.estimate[:] = arc(body.estimate, share * left, share * right, settings.wheel_base)
    body.clock[NOW] += dt
    pressed = not math.isnan(bearing)
    if pressed:
        body.contact[0] = wrap(bearing + rng.normal(0.0, settings.bumper_noise))
        gridcells.feel(machine.grid, body.estimate, body.contact[0], settings.radius)
    if body.clock[NOW] >= body.clock[NEXT_SCAN] - 1e-9:
        body.clock[NEXT_SCAN] = body.clock[NOW] + settings.period
        _scan(machine, rng)
    if body.clock[NOW] >= body.clock[NEXT_CORRECTION] - 1e-9:
        body.clock[NEXT_CORRECTION] = body.clock[NOW] + settings.correction_period
        images = _images(machine)
        body.estimate[:] = corrected_estimate(body.estimate, body.true, images, machine.trust, rng)
    _record(machine)
    return pressed


@compiled
def _move(
    machine: Machine, left: float, right: float, rng: np.random.Generator
) -> tuple[float, float]:
    """Move the true body; the share of the step that was free, and the contact's bearing.

    The bearing is ``nan`` without a contact.
    """
    body, base, radius = machine.body, machine.settings.wheel_base, machine.settings.radius
    rolled_left, rolled_right = roll(machine.slip, left, right, rng)
    target = arc(body.true, rolled_left, rolled_right, base)
    # No need to look again while the way since the last look was shorter than the gap.
    body.gap[0] -= abs(left) + abs(right)
    if body.gap[0] < radius:
        body.gap[0] = nearest(machine.touched, target[0], target[1])[0]
    if body.gap[0] >= radius:
        body.true[:] = target
        return 1.0, math.nan
    low, high = 0.0, 1.0
    for _ in range(10):
        share = 0.5 * (low + high)
        tried = arc(body.true, share * rolled_left, share * rolled_right, base)
        free = nearest(machine.touched, tried[0], tried[1])[0] >= radius
        low, high = (share, high) if free else (low, share)
    direction = nearest(machine.touched, target[0], target[1])[1]
    body.true[:] = arc(body.true, low * rolled_left, low * rolled_right, base)
    return low, direction - body.true[2]


@compiled
def _scan(machine: Machine, rng: np.random.Generator) -> None:
    """Measure the beams; enter them, and the body's place, into grid and records."""
    grid, log, pose = machine.grid, machine.log, machine.body.estimate
    ranges = measure(spots(machine.seen, machine.body.true, machine.bearings), machine.look, rng)
    angles = pose[2] + machine.bearings
    free = min(_FREE_WITHOUT_SPOT, machine.look.maximum_range)
    gridcells.stand(grid, pose, machine.settings.radius)
    gridcells.pass_beams(grid, pose, angles, ranges, free)
    gridcells.hit(grid, pose, angles, ranges)
    for beam in range(len(ranges)):
        if not math.isnan(ranges[beam]):
            point = log.points[log.used[POINTS]]
            along_y, along_x = sine_cosine(angles[beam])
            point[0] = pose[0] + ranges[beam] * along_x
            point[1] = pose[1] + ranges[beam] * along_y
            point[2], point[3] = machine.body.clock[NOW], beam
            log.used[POINTS] += 1


@compiled
def _images(machine: Machine) -> Floats:
    """Estimates and true poses, (k, 2, 3), that the robot relates its image to.

    Those of nearby nodes, or of marks where there are no nodes.
    """
    nodes, most = machine.nodes, machine.settings.correction_nodes
    x, y = machine.body.estimate[0], machine.body.estimate[1]
    near = nearest_first(nodes, x, y, machine.settings.correction_radius)
    if machine.lane >= 0:
        near = near[near < nodes.total - _RECENT]
    if len(near) == 0:
        return _near_marks(machine)
    images = np.empty((min(len(near), most), 2, 3))
    for k in range(len(images)):
        images[k, 0] = nodes.estimate[near[k]]
        images[k, 1] = nodes.true_pose[near[k]]
    return images


@compiled
def _near_marks(machine: Machine) -> Floats:
    """Estimates and true poses of nearby marks, (k, 2, 3); sets one where none is near.

    Away from its map the robot keeps images of its way, about four a metre,
    so that it finds back. They are no part of the map.
    """
    log, body, settings = machine.log, machine.body, machine.settings
    count = log.used[MARKS]
    away, near = np.empty(count), np.empty(count, np.int64)
    nearest_away, found = np.inf, 0
    for k in range(count):
        gap_x = log.marks[k, 0, 0] - body.estimate[0]
        gap_y = log.marks[k, 0, 1] - body.estimate[1]
        gap = math.sqrt(gap_x * gap_x + gap_y * gap_y)
        nearest_away = min(nearest_away, gap)
        if gap <= settings.correction_radius:
            away[found], near[found] = gap, k
            found += 1
    sort_by(away[:found], near[:found])
    if machine.lane < 0 and nearest_away > _MARK_SPACING:
        log.marks[count, 0], log.marks[count, 1] = body.estimate, body.true
        log.used[MARKS] += 1
    kept = near[: min(found, settings.correction_nodes)]
    return np.asarray(log.marks[kept])


@compiled
def _record(machine: Machine) -> None:
    """Add where the robot is to the path."""
    row = machine.log.path[machine.log.used[PATH]]
    row[0] = machine.body.clock[NOW]
    row[1:4] = machine.body.true
    row[4:7] = machine.body.estimate
    row[LANE] = machine.lane
    machine.log.used[PATH] += 1
