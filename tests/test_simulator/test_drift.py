"""The estimate as §2.1 has it: right relative to nearby nodes, wrong across the map.

And T_k of Appendix A, which says when a node's obstacles were seen.
"""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from scipy.spatial import KDTree

from scenes import load_apartment
from simulator import REFERENCE_RUNS, simulate
from simulator.reference_set import STAND_IN_ROBOT

from .plans import two_rooms

RUNS = {run.file_name: run for run in REFERENCE_RUNS}


def run_of(file_name, seed=None, **changes):
    run = RUNS[file_name]
    return simulate(
        load_apartment(run.place),
        seed=run.seed if seed is None else seed,
        start=(*run.start[:2], radians(run.start[2])),
        robot=replace(run.robot, **changes),
        sensor=run.sensor,
    )


@pytest.fixture(scope="module")
def drifted():
    """A run through a stand-in, which drifts more than the simulated places."""
    return run_of("real3-run1.h5")


def relative_errors(topomap, first, second):
    """How far off the second node lies in the first one's own frame, m."""
    nodes = topomap.nodes

    def seen(place, heading):
        gap = place[second] - place[first]
        c, s = np.cos(heading[first]), np.sin(heading[first])
        return np.stack([c * gap[:, 0] + s * gap[:, 1], c * gap[:, 1] - s * gap[:, 0]], axis=1)

    truth = seen(nodes.true_pose[:, :2], nodes.true_pose[:, 2])
    return np.linalg.norm(seen(nodes.position, nodes.heading) - truth, axis=1)


def near(topomap):
    """Errors of all pairs of nodes that are truly at most half a metre apart, m."""
    pairs = KDTree(topomap.nodes.true_pose[:, :2]).query_pairs(0.5, output_type="ndarray")
    return relative_errors(topomap, *pairs.T)


def far(topomap):
    """Errors of pairs of nodes that are at least four metres apart, m."""
    first, second = np.random.default_rng(0).integers(0, len(topomap.nodes), (2, 20000))
    place = topomap.nodes.true_pose[:, :2]
    apart = np.hypot(*(place[first] - place[second]).T) > 4.0
    return relative_errors(topomap, first[apart], second[apart])


@pytest.mark.parametrize("seed", [1, 2])
def test_near_nodes_agree_and_far_ones_do_not(seed):
    topomap = run_of("real3-run1.h5", seed)
    errors = near(topomap)
    assert np.quantile(errors, 0.95) < 0.06
    assert errors.max() < 0.25  # on either side of a wall, or before a part's end was found again
    assert np.median(far(topomap)) > 4.0 * np.median(errors)


def test_edges_are_true_to_centimetres(drifted):
    """What the method measures, at the nodes that it compares."""
    errors = relative_errors(drifted, *drifted.edges.T)
    assert np.quantile(errors, 0.99) < 0.08
    true = np.hypot(*np.diff(drifted.nodes.true_pose[drifted.edges][..., :2], axis=1)[:, 0].T)
    assert np.quantile(np.abs(drifted.edge_lengths() - true), 0.99) < 0.07


def test_without_images_near_nodes_disagree():
    """It is the correction that keeps the map together, not a gentle odometry."""
    seeing, blind = (
        simulate(two_rooms(), seed=2, robot=replace(STAND_IN_ROBOT, correction_gain=gain))
        for gain in (0.3, 0.0)
    )
    assert np.quantile(near(blind), 0.95) > 2.0 * np.quantile(near(seeing), 0.95)


def test_the_stand_ins_drift_more_than_the_simulated_robot(drifted):
    mild = run_of("real3-run1.h5", **vars(RUNS["sim1-run1.h5"].robot))
    assert np.median(near(drifted)) > 1.5 * np.median(near(mild))


def test_visits_contain_the_creation(drifted):
    """T_k begins when the robot stood where node k is."""
    path, visits, nodes = drifted.path, drifted.visits, drifted.nodes
    for k in range(len(nodes)):
        times = visits.time[visits.node == k]
        made = np.flatnonzero((np.abs(path.true_pose - nodes.true_pose[k]) < 1e-9).all(axis=1))
        assert len(made), k
        # After a contact it may have stood there before.
        assert np.isclose(path.time[made], times.min()).any()
