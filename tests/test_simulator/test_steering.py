"""Runs of time steps: why they end, and how the robot keeps to its line."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from simulator import gridcells, steering
from simulator.motion import PATH
from simulator.steering import Line, drive, follow, is_covered_ahead, turn

from .machines import EXACT, ROOM, machine_at

DT = EXACT.time_step
STEP = EXACT.speed * DT
RNG = np.random.default_rng(0)


def line(length=2.0, start=(1.0, 1.5), heading=0.0, aside=0.0):
    return Line(np.array(start), heading, length, aside)


def steps_of(machine):
    return int(machine.log.used[PATH])


def off(angle):
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


@pytest.mark.parametrize(("begin", "aim"), [(0.0, 1.5), (0.3, -2.0), (3.0, -3.0), (-1.0, -1.005)])
def test_turning_the_shorter_way(begin, aim):
    machine = machine_at([2.0, 1.5, begin])
    assert turn(machine, aim, 200, RNG).why == steering.ARRIVED
    assert abs(off(aim - machine.body.true[2])) < 0.01
    np.testing.assert_allclose(machine.body.true[:2], [2.0, 1.5], atol=1e-9)
    most = EXACT.turn_rate * DT
    expected = np.ceil(max(abs(off(aim - begin)) - 0.01, 0.0) / most)
    assert steps_of(machine) == expected


def test_a_turn_is_given_up():
    machine = machine_at([2.0, 1.5, 0.0])
    assert turn(machine, 3.0, 5, RNG).why == steering.ARRIVED
    assert machine.body.true[2] == pytest.approx(5 * EXACT.turn_rate * DT)


def test_a_line_is_driven_to_its_end():
    machine = machine_at([1.0, 1.5, 0.0])
    why, progress, cross = follow(machine, line(), careful=False, watch=False, rng=RNG)
    assert why == steering.ARRIVED
    assert abs(progress - 2.0) < 0.004 and abs(cross) < 1e-6
    np.testing.assert_allclose(machine.body.true[:2], [3.0, 1.5], atol=0.004)
    assert steps_of(machine) == np.ceil(2.0 / STEP)


@pytest.mark.parametrize("aside", [0.0, 0.03, -0.03])
@pytest.mark.parametrize("heading", [0.0, 2.5, -1.2])
def test_the_robot_finds_back_to_its_line(heading, aside):
    """From 6 cm beside it and 0.3 rad off."""
    along = np.array([np.cos(heading), np.sin(heading)])
    left = np.array([-along[1], along[0]])
    start = np.array([2.0, 1.5]) - 0.6 * along
    machine = machine_at([*(start + 0.06 * left), heading + 0.3])
    ended = follow(machine, line(1.3, start, heading, aside), careful=False, watch=False, rng=RNG)
    assert ended.why == steering.ARRIVED
    assert ended.cross == pytest.approx(aside, abs=0.005)
    assert (machine.body.true[:2] - start) @ left == pytest.approx(ended.cross, abs=1e-6)
    path = machine.log.path[: steps_of(machine)]
    driven = np.hypot(*np.diff(path[:, 1:3], axis=0).T)
    turned = off(np.diff(path[:, 3]))
    assert driven.max() <= STEP + 1e-9 and np.abs(turned).max() <= EXACT.turn_rate * DT + 1e-9


def test_a_wall_ends_the_line_at_the_bumper():
    machine = machine_at([1.0, 1.5, 0.0])
    why, progress, _ = follow(machine, line(9.0), careful=False, watch=False, rng=RNG)
    assert why == steering.CONTACT
    assert shapely.distance(ROOM, shapely.Point(machine.body.true[:2])) >= EXACT.radius - 1e-9
    # Where the last step began, which the contact cut short.
    assert 0.0 <= machine.body.true[0] - 1.0 - progress <= STEP
    assert machine.body.true[0] == pytest.approx(4.0 - EXACT.radius, abs=STEP / 500)


def test_a_known_obstacle_is_not_touched():
    machine = machine_at([1.0, 1.5, 0.0])
    gridcells.feel(machine.grid, np.array([3.0, 1.5, 0.0]), 0.0, 0.0)
    why, progress, _ = follow(machine, line(9.0), careful=True, watch=False, rng=RNG)
    assert why == steering.BLOCKED
    gap = 3.0 - machine.body.true[0]
    cell = 0.5 * gridcells.CELL
    assert EXACT.radius + 0.01 - STEP - cell <= gap < EXACT.radius + 0.01 + cell
    assert progress == pytest.approx(machine.body.true[0] - 1.0)


def test_what_lies_beside_the_way_does_not_end_it():
    machine = machine_at([1.0, 1.5, 0.0])
    gridcells.feel(machine.grid, np.array([2.0, 1.64, 0.0]), 0.0, 0.0)
    assert follow(machine, line(), careful=True, watch=False, rng=RNG).why == steering.ARRIVED


def test_a_node_is_due_every_node_spacing():
    machine = machine_at([1.0, 1.5, 0.0], lane=2, nodes=[(1.0, 1.5, 0.0)], older=0)
    assert follow(machine, line(), careful=False, watch=True, rng=RNG).why == steering.ASK
    driven = machine.body.true[0] - 1.0
    assert EXACT.node_spacing - 0.005 - 1e-8 <= driven < EXACT.node_spacing - 0.005 + STEP
    between = machine_at([1.0, 1.5, 0.0], nodes=[(1.0, 2.9, 0.0)])
    assert follow(between, line(), careful=False, watch=True, rng=RNG).why == steering.ARRIVED


def test_covered_floor_ahead_is_reported():
    """An older node 1.01 m ahead; the place looked at is one node spacing ahead."""
    machine = machine_at([1.0, 1.5, 0.0], nodes=[(2.01, 1.5, 0.0)])
    assert follow(machine, line(), careful=False, watch=True, rng=RNG).why == steering.ASK
    limit = 1.01 - EXACT.node_spacing - EXACT.overlap_radius
    assert limit < machine.body.true[0] - 1.0 <= limit + STEP + 1e-9


def test_what_lies_behind_or_belongs_to_the_lane_covers_nothing():
    pose = np.array([1.0, 1.5, 0.0])
    for nodes, lane, older, covered in (
        ([(0.95, 1.5, 0.0)], -1, None, False),
        ([(1.15, 1.5, 0.0)], -1, None, True),
        ([(1.15, 1.5, 0.0)], 4, 0, False),
        ([(1.15, 1.75, 0.0)], -1, None, False),
    ):
        machine = machine_at(pose, nodes=nodes, lane=lane, older=older)
        assert is_covered_ahead(machine.nodes, pose, machine.settings) == covered


@pytest.mark.parametrize("run", ["drive", "turn", "follow"])
def test_full_records_end_every_run_and_it_goes_on_from_there(run):
    runs = {
        "drive": lambda machine: drive(machine, 0.1, 0.0, 4.0, RNG),
        "turn": lambda machine: turn(machine, 3.0, 200, RNG),
        "follow": lambda machine: follow(machine, line(), careful=False, watch=False, rng=RNG),
    }
    machine = machine_at([1.0, 1.5, 0.0], rows=6)
    while (ended := runs[run](machine)).why != steering.NO_ROOM:
        pass
    assert steps_of(machine) == 6
    before = machine.body.true.copy()
    assert runs[run](machine).why == steering.NO_ROOM
    np.testing.assert_array_equal(machine.body.true, before)
    assert ended.progress <= 6 * STEP + 1e-9
    machine.log.used[:] = 0
    assert runs[run](machine).why in (steering.ARRIVED, steering.NO_ROOM)
    assert (machine.body.true != before).any()


def test_a_drive_ends_in_time_or_at_the_bumper():
    machine = machine_at([3.0, 1.5, 0.0])
    assert drive(machine, 0.1, 0.0, 8 * DT, RNG).why == steering.ARRIVED
    assert steps_of(machine) == 8
    assert machine.body.true[0] == pytest.approx(3.0 + 8 * DT * 0.1)
    assert drive(machine, 0.1, 0.0, 9.0, RNG).why == steering.CONTACT
    now = machine.body.clock[0]
    assert drive(machine, -0.1, 0.0, now + DT, RNG).why == steering.ARRIVED
    assert machine.body.clock[0] == pytest.approx(now + DT)
