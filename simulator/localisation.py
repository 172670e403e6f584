"""Correcting the position estimate against nearby nodes (§2.1, [23]).

The paper's robot relates its camera image to those of nearby nodes. Here that
relation is a noisy measurement of where the robot stands *in the node's frame*;
put at the node's own estimate it says where the robot is in the map. The robot
takes over a share of the mean difference. So neighbours stay consistent, while
the map as a whole drifts with the odometry, as the paper's does.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import compiled
from simulator.robot import RobotSpec, wrap
from simulator.trigonometry import sine_cosine

__all__ = ["corrected_estimate"]

Floats = NDArray[np.float64]


def corrected_estimate(
    estimate: Floats,
    true_pose: Floats,
    node_estimates: Floats,
    node_true_poses: Floats,
    *,
    spec: RobotSpec,
    rng: np.random.Generator,
) -> Floats:
    """The estimate after relating the image to those of nearby nodes.

    Parameters
    ----------
    estimate, true_pose : array, shape (3,)
        Of the robot; the true pose only makes the measurement.
    node_estimates, node_true_poses : array, shape (k, 3)
        Of the nodes that the image is related to.

    Returns
    -------
    array, shape (3,)
    """
    k = len(node_estimates)
    if k == 0:
        return estimate
    noise = rng.standard_normal((k, 3)) * (
        spec.correction_position_noise,
        spec.correction_position_noise,
        spec.correction_heading_noise,
    )
    shift = _mean_difference(estimate, true_pose, node_estimates, node_true_poses, noise)
    corrected = estimate + spec.correction_gain * shift
    return np.array([corrected[0], corrected[1], wrap(corrected[2])])


@compiled
def _mean_difference(
    estimate: Floats,
    true_pose: Floats,
    node_estimates: Floats,
    node_true_poses: Floats,
    noise: Floats,
) -> Floats:
    """From the estimate to the mean of noisy relative measurements, (3,) m, m, rad."""
    shift = np.zeros(3)
    for k in range(len(noise)):
        there, here = node_true_poses[k], node_estimates[k]
        gap_x, gap_y = true_pose[0] - there[0], true_pose[1] - there[1]
        s, c = sine_cosine(there[2])
        seen_x, seen_y = c * gap_x + s * gap_y + noise[k, 0], c * gap_y - s * gap_x + noise[k, 1]
        s, c = sine_cosine(here[2])
        shift[0] += here[0] + c * seen_x - s * seen_y - estimate[0]
        shift[1] += here[1] + s * seen_x + c * seen_y - estimate[1]
        turned = here[2] + true_pose[2] - there[2] + noise[k, 2] - estimate[2]
        shift[2] += (turned + math.pi) % (2.0 * math.pi) - math.pi
    return shift / len(noise)
