"""Where a run begins: at the base, or at a random pose that the robot can reach from there."""

from __future__ import annotations

import numpy as np
import shapely

from dataset.errors import RoomsegError
from scenes.apartment import Apartment
from scenes.passages import ROBOT_RADIUS, free_region, reachable_positions
from scenes.solids import obstacles
from simulator.robot import RobotSpec

__all__ = ["base_pose", "random_start"]

_BESIDE = 0.3
"""A robot too large for the base begins at most so far beside it, m."""


def base_pose(apartment: Apartment, robot: RobotSpec) -> tuple[float, float, float]:
    """Where a robot begins: x m, y m, heading rad.

    At the apartment's base, where the prototype fits. A larger robot that does not
    begins at the nearest place within 30 cm where it does; if there is none, the base
    stands.
    """
    base = apartment.start
    x, y = base.position
    own = shapely.Point(x, y)
    if robot.radius > ROBOT_RADIUS:
        # A little more than the body needs, as a place on the very limit may touch by rounding.
        free = free_region(apartment, robot.radius + 1e-3)
        near = [part for part in shapely.get_parts(free) if part.distance(own) <= _BESIDE]
        if near:
            x, y = shapely.shortest_line(max(near, key=shapely.area), own).coords[0]
    return x, y, float(np.radians(base.heading_deg))


def random_start(
    apartment: Apartment, robot: RobotSpec, rng: np.random.Generator
) -> tuple[float, float, float]:
    """A pose that the robot can reach from the base, all equally likely.

    Returns
    -------
    tuple of float
        x m, y m (on a grid of 5 cm), heading rad, -pi to pi.

    Raises
    ------
    SceneError, RoomsegError
        If the robot does not fit where the apartment says that it starts, or nowhere else.
    """
    solid = obstacles(apartment, high=robot.height)
    shapely.prepare(solid)
    places = reachable_positions(apartment, robot.radius, start=base_pose(apartment, robot)[:2])
    # Grid points on the very limit may touch by rounding.
    places = places[~shapely.dwithin(solid, shapely.points(places), robot.radius + 1e-6)]
    if len(places) == 0:
        raise RoomsegError(
            f"{apartment.name}: start.position {apartment.start.position}: expected free floor "
            f"around it, where a robot of {robot.radius:g} m radius can move"
        )
    x, y = places[rng.integers(len(places))].tolist()
    return x, y, float(rng.uniform(-np.pi, np.pi))
