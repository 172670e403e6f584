"""Correction against nodes: exact without noise, local, and in the node's frame."""

from __future__ import annotations

import numpy as np

from simulator.localisation import Trust, corrected_estimate

EXACT = Trust(1.0, 0.0, 0.0)


def moved(pose, angle, shift):
    """A pose turned around the origin and shifted: a map that has drifted rigidly."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = np.array([[c, -s], [s, c]]) @ pose[:2] + shift
    return np.array([x, y, pose[2] + angle])


def test_a_drifted_map_pulls_the_robot_to_its_place_in_that_map():
    """With rigidly drifted nodes and no noise the robot drifts with them exactly."""
    rng = np.random.default_rng(0)
    truth = np.array([1.0, 2.0, 0.4])
    nodes = rng.uniform([0.7, 1.7, -3.0], [1.3, 2.3, 3.0], (5, 3))
    angle, shift = 0.2, np.array([0.5, -0.3])
    estimates = np.array([moved(node, angle, shift) for node in nodes])
    wrong = moved(truth, angle, shift) + np.array([0.05, -0.04, 0.1])
    images = np.stack([estimates, nodes], axis=1)
    corrected = corrected_estimate(wrong, truth, images, EXACT, rng)
    np.testing.assert_allclose(corrected, moved(truth, angle, shift), atol=1e-12)


def test_the_gain_is_the_share_that_is_taken_over():
    truth, estimate = np.array([0.3, 0.0, 0.0]), np.array([0.34, 0.08, 0.0])
    corrected = corrected_estimate(
        estimate, truth, np.zeros((1, 2, 3)), Trust(0.25, 0.0, 0.0), np.random.default_rng(0)
    )
    np.testing.assert_allclose(corrected, [0.33, 0.06, 0.0], atol=1e-12)


def test_without_nodes_nothing_changes():
    estimate = np.array([1.0, 2.0, 3.0])
    got = corrected_estimate(
        estimate, np.zeros(3), np.zeros((0, 2, 3)), EXACT, np.random.default_rng(0)
    )
    np.testing.assert_array_equal(got, estimate)
