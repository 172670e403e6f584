"""Single time steps: rolling, touching, measuring, correcting, recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from simulator.motion import MARKS, PATH, POINTS, has_room, step
from simulator.robot import RobotSpec

from .machines import EXACT, ROOM, SHARP, machine_at

DT = EXACT.time_step
RNG = np.random.default_rng(0)


def scan_times(machine):
    return np.unique(machine.log.points[: machine.log.used[POINTS], 2])


@pytest.mark.parametrize(
    ("speed", "rate"), [(0.16, 0.0), (0.16, 0.5), (0.1, -1.2), (0.0, 1.2), (-0.08, 0.3)]
)
def test_without_slip_the_body_draws_a_circle(speed, rate):
    machine = machine_at([2.0, 1.5, 0.4])
    for _ in range(20):
        assert not step(machine, speed, rate, RNG)
    turned = 20 * DT * rate
    if rate:
        radius = speed / rate
        x = 2.0 + radius * (np.sin(0.4 + turned) - np.sin(0.4))
        y = 1.5 - radius * (np.cos(0.4 + turned) - np.cos(0.4))
    else:
        x, y = np.array([2.0, 1.5]) + 20 * DT * speed * np.array([np.cos(0.4), np.sin(0.4)])
    heading = (0.4 + turned + np.pi) % (2.0 * np.pi) - np.pi
    np.testing.assert_allclose(machine.body.true, [x, y, heading], atol=1e-9)
    np.testing.assert_allclose(machine.body.estimate, machine.body.true, atol=1e-9)


def test_slip_moves_the_body_and_not_the_odometry():
    robot = replace(EXACT, slip_bias=0.05, correction_gain=0.0)
    machine = machine_at([1.0, 1.5, 0.0], robot=robot)
    for _ in range(80):
        step(machine, robot.speed, 0.0, RNG)
    np.testing.assert_allclose(machine.body.estimate, [2.6, 1.5, 0.0], atol=1e-9)
    slip = 1.0 + machine.slip.bias
    assert (slip != 1.0).all()
    turned = 1.6 * (slip[1] - slip[0]) / robot.wheel_base
    assert machine.body.true[2] == pytest.approx(turned, abs=1e-9)
    chord = 1.6 * slip.mean() * np.sin(0.5 * turned) / (0.5 * turned)
    driven = np.hypot(*(machine.body.true[:2] - [1.0, 1.5]))
    assert driven == pytest.approx(chord, abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_contact_is_found_before_the_body_overlaps(seed):
    rng = np.random.default_rng(seed)
    legs = [shapely.Point(place).buffer(0.02) for place in rng.uniform(0.8, 2.8, (6, 2))]
    solid = shapely.union_all([ROOM, *legs])
    machine = machine_at([0.4, 0.4, rng.uniform(0.0, 1.5)], solid=solid)
    pressed = 0
    for _ in range(400):
        before = machine.body.true.copy()
        hit = step(machine, EXACT.speed, rng.uniform(-0.5, 0.5), rng)
        place = shapely.Point(machine.body.true[:2])
        gap = shapely.distance(solid, place) - EXACT.radius
        assert gap >= -1e-9
        np.testing.assert_allclose(machine.body.estimate, machine.body.true, atol=1e-9)
        driven = np.hypot(*(machine.body.true[:2] - before[:2]))
        if not hit:
            assert driven == pytest.approx(EXACT.speed * DT, rel=1e-2)
            continue
        pressed += 1
        # Halving the step ten times leaves a thousandth of it.
        assert gap < EXACT.speed * DT * 2.0**-9
        touched = shapely.get_coordinates(shapely.shortest_line(place, solid))[1]
        angle = np.arctan2(*(touched - machine.body.true[:2])[::-1]) - machine.body.true[2]
        assert abs((machine.body.contact[0] - angle + np.pi) % (2.0 * np.pi) - np.pi) < 0.15
        for turn in rng.uniform(1.0, 2.0) * np.ones(8):
            step(machine, 0.0, turn, rng)
    assert pressed > 3


def test_what_was_felt_is_in_the_map():
    machine = machine_at([0.2, 1.5, np.pi])
    while not step(machine, EXACT.speed, 0.0, RNG):
        pass
    felt = np.argwhere(machine.grid.evidence == 100)
    assert len(felt) == 1
    place = machine.grid.corner + (felt[0] + 0.5) * 0.025
    np.testing.assert_allclose(place, [0.0, 1.5], atol=0.02)


@pytest.mark.parametrize(("period", "steps"), [(0.5, 4), (0.125, 1), (0.3, 3), (1.0, 8)])
def test_a_scan_exactly_each_period(period, steps):
    """And where the period is no whole number of steps, in the first step after it."""
    machine = machine_at([0.5, 0.5, 0.2], sensor=replace(SHARP, period=period))
    for _ in range(60):
        step(machine, 0.0, 0.1, RNG)
    np.testing.assert_allclose(scan_times(machine), DT * np.arange(1, 61, steps), atol=1e-9)


def test_points_lie_where_the_beams_end():
    machine = machine_at([0.5, 0.5, 0.2])
    for _ in range(40):
        step(machine, 0.1, 0.4, RNG)
    rows = machine.log.points[: machine.log.used[POINTS]]
    walls = shapely.boundary(ROOM)
    assert shapely.distance(walls, shapely.points(rows[:, :2])).max() < 1e-9
    path = machine.log.path[: machine.log.used[PATH]]
    for x, y, now, beam in rows:
        at = path[np.flatnonzero(path[:, 0] == now)[0]]
        angle = np.arctan2(y - at[2], x - at[1]) - at[3] - machine.bearings[int(beam)]
        assert abs((angle + np.pi) % (2.0 * np.pi) - np.pi) < 1e-9
        assert np.hypot(x - at[1], y - at[2]) <= SHARP.maximum_range


def test_corrections_come_in_their_period_and_take_their_share():
    """A lie about the position shrinks to 0.7 of it every half second."""
    machine = machine_at([2.0, 1.5, 0.0], nodes=[(2.1, 1.5, 1.0), (2.0, 1.7, -2.0)])
    lie = np.array([0.05, -0.03, 0.04])
    machine.body.estimate[:] += lie
    for k in range(1, 18):
        step(machine, 0.0, 0.0, RNG)
        taken = 1 + (k - 1) // 4
        left = machine.body.estimate - machine.body.true
        np.testing.assert_allclose(left, 0.7**taken * lie, atol=1e-9)


@pytest.mark.parametrize(("count", "share"), [(5, 1.0), (6, 0.7)])
def test_the_last_nodes_of_the_running_lane_say_nothing(count, share):
    nodes = [(2.0 - 0.05 * k, 1.5, 0.0) for k in range(count)]
    machine = machine_at([2.0, 1.5, 0.0], nodes=nodes, lane=3)
    machine.body.estimate[0] += 0.05
    step(machine, 0.0, 0.0, RNG)
    assert machine.body.estimate[0] - 2.0 == pytest.approx(0.05 * share)


def test_away_from_the_map_the_robot_remembers_its_way():
    """About four marks a metre, none on a lane."""
    machine = machine_at([0.5, 1.5, 0.0])
    on_lane = machine_at([0.5, 1.5, 0.0], lane=0)
    for _ in range(120):
        step(machine, EXACT.speed, 0.0, RNG)
        step(on_lane, EXACT.speed, 0.0, RNG)
    marks = machine.log.marks[: machine.log.used[MARKS]]
    apart = np.diff(marks[:, 0, 0])
    assert len(marks) >= 7 and on_lane.log.used[MARKS] == 0
    assert apart.min() > 0.25 and apart.max() < 0.25 + EXACT.speed * EXACT.correction_period + 1e-9
    np.testing.assert_allclose(marks[:, 0], marks[:, 1], atol=1e-9)


def test_every_step_is_recorded():
    machine = machine_at([2.0, 1.5, 0.0], robot=RobotSpec(), lane=7)
    for k in range(30):
        step(machine, 0.1, 0.2, RNG)
        row = machine.log.path[k]
        assert machine.log.used[PATH] == k + 1
        assert row[0] == pytest.approx(DT * (k + 1))
        np.testing.assert_array_equal(row[1:4], machine.body.true)
        np.testing.assert_array_equal(row[4:7], machine.body.estimate)
        assert row[7] == 7


def test_room_for_a_step():
    """In the records and in the grid."""
    machine = machine_at([2.0, 1.5, 0.0], rows=12)
    for _ in range(12):
        assert has_room(machine)
        step(machine, 0.0, 0.0, RNG)
    assert not has_room(machine)
    edge = machine_at([2.0, 1.5, 0.0])
    edge.body.estimate[0] = edge.grid.corner[0] + 1.2
    assert not has_room(edge)
    edge.body.estimate[0] = edge.grid.corner[0] + 1.4
    assert has_room(edge)
