"""Correcting the position estimate against nearby nodes (§2.1, [23]).

The paper's robot relates its camera image to those of nearby nodes. Here that
relation is a noisy measurement of where the robot stands *in the node's frame*;
put at the node's own estimate it says where the robot is in the map. The robot
takes over a share of the mean difference. So neighbours stay consistent, while
the map as a whole drifts with the odometry, as the paper's does.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import compiled
from simulator.robot import wrap
from simulator.trigonometry import sine_cosine

__all__ = ["Trust", "corrected_estimate"]

Floats = NDArray[np.float64]


class Trust(NamedTuple):
    """How the robot corrects its position; see `simulator.robot.RobotSpec`."""

    correction_gain: float
    correction_position_noise: float
    correction_heading_noise: float


@compiled
def corrected_estimate(
    estimate: Floats, true_pose: Floats, images: Floats, trust: Trust, rng: np.random.Generator
) -> Floats:
    """The estimate after relating the image to those of nearby places.

    Parameters
    ----------
    estimate, true_pose : array, shape (3,)
        Of the robot; the true pose only makes the measurement.
    images : array, shape (k, 2, 3)
        Estimate and true pose of each place, m, m, rad.

    Returns
    -------
    array, shape (3,)
    """
    if len(images) == 0:
        return estimate.copy()
    shift = np.zeros(3)
    for k in range(len(images)):
        here, there = images[k, 0], images[k, 1]
        noise_x = rng.standard_normal() * trust.correction_position_noise
        noise_y = rng.standard_normal() * trust.correction_position_noise
        noise_turn = rng.standard_normal() * trust.correction_heading_noise
        gap_x, gap_y = true_pose[0] - there[0], true_pose[1] - there[1]
        s, c = sine_cosine(there[2])
        seen_x, seen_y = c * gap_x + s * gap_y + noise_x, c * gap_y - s * gap_x + noise_y
        s, c = sine_cosine(here[2])
        shift[0] += here[0] + c * seen_x - s * seen_y - estimate[0]
        shift[1] += here[1] + s * seen_x + c * seen_y - estimate[1]
        shift[2] += wrap(here[2] + true_pose[2] - there[2] + noise_turn - estimate[2])
    corrected = estimate + trust.correction_gain * (shift / len(images))
    corrected[2] = wrap(corrected[2])
    return corrected
