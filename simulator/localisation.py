"""Correcting the position estimate against nearby nodes (§2.1, [23]).

The paper's robot relates its camera image to those of nearby nodes. Here that
relation is a noisy measurement of where the robot stands *in the node's frame*;
put at the node's own estimate it says where the robot is in the map. The robot
takes over a share of the mean difference. So neighbours stay consistent, while
the map as a whole drifts with the odometry, as the paper's does.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.robot import RobotSpec, wrap

__all__ = ["corrected_estimate"]

Floats = NDArray[np.float64]


def _rotate(vectors: Floats, angle: Floats) -> Floats:
    """Rotate (n, 2) vectors by (n,) angles, rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack(
        [c * vectors[:, 0] - s * vectors[:, 1], s * vectors[:, 0] + c * vectors[:, 1]], axis=1
    )


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
    relative = _rotate(true_pose[:2] - node_true_poses[:, :2], -node_true_poses[:, 2])
    relative += rng.normal(0.0, spec.correction_position_noise, (k, 2))
    turned = true_pose[2] - node_true_poses[:, 2]
    turned += rng.normal(0.0, spec.correction_heading_noise, k)
    position = node_estimates[:, :2] + _rotate(relative, node_estimates[:, 2])
    heading = node_estimates[:, 2] + turned - estimate[2]
    heading = (heading + np.pi) % (2.0 * np.pi) - np.pi
    gain = spec.correction_gain
    shift = gain * (position.mean(axis=0) - estimate[:2])
    return np.array([*(estimate[:2] + shift), wrap(estimate[2] + gain * float(heading.mean()))])
