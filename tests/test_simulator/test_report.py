"""The coverage report against hand-made paths."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dataset.errors import RoomsegError
from dataset.topomap import Path
from simulator import coverage_report, simulate

from .plans import two_rooms


def with_track(topomap, track):
    """The map with another driven path of one point per second."""
    heading = np.zeros((len(track), 1))
    pose = np.hstack([np.asarray(track, dtype=float), heading])
    lane = np.full(len(track), -1)
    return replace(topomap, path=Path(np.arange(len(track)) * 1.0, pose, pose, lane))


def test_a_line_through_one_room(two_rooms_map):
    """1 m of track covers about (1 m + caps) x 0.4 m of the reachable positions."""
    track = np.column_stack([np.linspace(0.5, 1.5, 101), np.full(101, 1.0)])
    report = coverage_report(with_track(two_rooms_map, track), two_rooms())
    assert report.path_length == pytest.approx(1.0)
    assert report.duration == 100.0
    assert report.turns == 0.0 and report.drift == 0.0
    free = 2 * (2.0 - 0.3) * (2.2 - 0.3) + 0.2
    assert report.coverage == pytest.approx((0.4 + np.pi * 0.04) / free, rel=0.1)


def test_driving_back_overlaps_half(two_rooms_map):
    x = np.concatenate([np.linspace(0.4, 1.6, 121), np.linspace(1.6, 0.4, 121)])
    track = np.column_stack([x, np.full(len(x), 1.0)])
    report = coverage_report(with_track(two_rooms_map, track), two_rooms())
    assert report.overlap == pytest.approx(0.5, abs=0.06)


def test_a_whole_run(two_rooms_map):
    report = coverage_report(two_rooms_map, two_rooms())
    assert report.nodes == len(two_rooms_map.nodes)
    assert report.nodes_per_m2 == pytest.approx(report.nodes / 8.8)
    assert report.connected
    assert 0.0 < report.overlap < 0.8
    assert report.turns > 4


def test_what_counts_is_what_can_be_reached_from_the_base_of_the_run():
    """Through a doorway of 25 cm nobody comes: the run in the other room is complete."""
    plan = two_rooms(door=0.25)
    topomap = simulate(plan, start=(3.4, 1.8, 0.0))
    report = coverage_report(topomap, plan)
    assert topomap.ground_truth.room_count == 1
    assert report.coverage >= 0.98


def test_a_map_without_path_is_refused(two_rooms_map):
    with pytest.raises(RoomsegError, match="path"):
        coverage_report(replace(two_rooms_map, path=None), two_rooms())
