"""A robot's machine in a plan, without a pilot, and exact unless told otherwise."""

from __future__ import annotations

import numpy as np
import shapely

from simulator.graph import MapGraph
from simulator.gridmap import GridMap
from simulator.laser import SensorSpec
from simulator.localisation import Trust
from simulator.motion import Body, Log, Machine, Settings
from simulator.robot import RobotSpec, wheel_slip
from simulator.world import World

EXACT = RobotSpec(
    slip_bias=0.0,
    slip_noise=0.0,
    correction_position_noise=0.0,
    correction_heading_noise=0.0,
)
SHARP = SensorSpec(
    range_noise=0.0,
    range_noise_quadratic=0.0,
    range_noise_slant=0.0,
    dropout=0.0,
    false_rate=0.0,
    least_reflectance=1e-6,
    bumper_noise=0.0,
)
ROOM = shapely.box(-0.1, -0.1, 4.1, 3.1).difference(shapely.box(0.0, 0.0, 4.0, 3.0))


def machine_at(
    pose, *, robot=EXACT, sensor=SHARP, solid=ROOM, nodes=(), lane=-1, older=None, rows=2000
):
    """At a pose that it believes in; ``nodes``: poses that the map and the truth agree on.

    ``older``: so many of them belong to other lanes than the running one; default: all.
    """
    world = World(solid, maximum_range=sensor.maximum_range)
    true, graph, grid = np.array(pose, dtype=np.float64), MapGraph(), GridMap(np.array(pose))
    grid.hold(true, 6.0)
    for k, node in enumerate(nodes):
        place = np.array(node, dtype=np.float64)
        graph.add_node(place, place, 0, 0 if older is None or k < older else lane, 0.0)
    settings = vars(sensor) | vars(robot)
    shapes = ((rows, 8), (rows * sensor.beams, 4), (rows, 2, 3))
    return Machine(
        Body(true, true.copy(), np.zeros(3), np.zeros(1), np.zeros(1)),
        wheel_slip(robot, np.random.default_rng(0)),
        world.touched,
        world.seen,
        grid.table,
        graph.table(lane),
        Log(*(np.zeros(shape) for shape in shapes), np.zeros(3, np.int64)),
        lane,
        Settings(*(settings[name] for name in Settings._fields)),
        sensor.bearings(),
        sensor.look(),
        Trust(*(float(getattr(robot, name)) for name in Trust._fields)),
    )


def seen_square(grid, centre, half):
    """A square of the grid counts as seen, ``half`` m each way."""
    grid.hold(centre, half)
    low, high = grid.cells(np.stack([centre - half, centre + half]))
    grid.seen[low[0] : high[0] + 1, low[1] : high[1] + 1] = True
