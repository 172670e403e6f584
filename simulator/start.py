"""Where a run may begin: a random pose that the robot can reach."""

from __future__ import annotations

import numpy as np
import shapely

from dataset.errors import RoomsegError
from scenes.apartment import Apartment
from scenes.passages import reachable_positions
from scenes.solids import obstacles
from simulator.robot import RobotSpec

__all__ = ["random_start"]


def random_start(
    apartment: Apartment, robot: RobotSpec, rng: np.random.Generator
) -> tuple[float, float, float]:
    """A pose that the robot can reach from the apartment's start, all equally likely.

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
    places = reachable_positions(apartment, robot.radius)
    # Grid points on the very limit may touch by rounding.
    places = places[~shapely.dwithin(solid, shapely.points(places), robot.radius + 1e-6)]
    if len(places) == 0:
        raise RoomsegError(
            f"{apartment.name}: start.position {apartment.start.position}: expected free floor "
            f"around it, where a robot of {robot.radius:g} m radius can move"
        )
    x, y = places[rng.integers(len(places))].tolist()
    return x, y, float(rng.uniform(-np.pi, np.pi))
