"""Whole runs: what §2.1 promises of a cleaning run and its map."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from dataset import crosses_border
from dataset.errors import RoomsegError
from scenes import load_apartment
from scenes.apartment import Block, Threshold
from scenes.solids import obstacles
from simulator import RobotSpec, SensorSpec, coverage_report, simulate

from .plans import box_room, slits, two_rooms


def lanes(topomap):
    """Node indices of each lane, in driving order."""
    for lane in np.unique(topomap.nodes.lane):
        yield np.flatnonzero(topomap.nodes.lane == lane)


def test_the_body_never_overlaps_an_obstacle(plan_and_map):
    plan, topomap = plan_and_map
    places = shapely.points(topomap.path.true_pose[:, :2])
    assert shapely.distance(obstacles(plan), places).min() >= 0.15 - 0.001


def test_motion_is_continuous(plan_and_map):
    _, topomap = plan_and_map
    steps = np.hypot(*np.diff(topomap.path.true_pose[:, :2], axis=0).T)
    assert steps.max() < 0.022
    assert (np.diff(topomap.path.time) > 0).all()


def test_coverage(plan_and_map):
    plan, topomap = plan_and_map
    assert coverage_report(topomap, plan).coverage >= 0.97


def test_the_robot_comes_home(plan_and_map):
    _, topomap = plan_and_map
    pose = topomap.path.true_pose
    assert np.hypot(*(pose[-1, :2] - pose[0, :2])) < 0.3


def test_a_threshold_tilts_the_nodes_on_it_and_changes_nothing_else(two_rooms_map):
    sill = Threshold(height=0.009, depth=0.1)
    topomap = simulate(two_rooms(threshold=sill), seed=1)
    tilt = topomap.nodes.tilt
    assert np.abs(tilt).max() == pytest.approx(np.arctan(0.009 / 0.10))
    leaning = np.hypot(*tilt.T) > 0.0
    # Wheels and castor reach 0.11 m from the robot's centre, the strip 0.05 m from x = 2.06.
    assert (np.abs(topomap.nodes.true_pose[leaning, 0] - 2.06) < 0.16).all()
    assert not two_rooms_map.nodes.tilt.any()
    same = ("position", "heading", "part", "lane", "true_pose")
    for name in same:
        found, expected = getattr(topomap.nodes, name), getattr(two_rooms_map.nodes, name)
        np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(topomap.obstacles.position, two_rooms_map.obstacles.position)
    np.testing.assert_array_equal(topomap.ground_truth.borders, two_rooms_map.ground_truth.borders)


def test_a_map_tells_robot_and_sensors():
    robot, sensor = RobotSpec(lane_spacing=0.28), SensorSpec(beams=4, camera_height=0.07)
    topomap = simulate(box_room(), robot=robot, sensor=sensor)
    assert topomap.camera.height == 0.07
    # All it takes to make the same robot again.
    assert RobotSpec(**topomap.robot) == robot
    assert SensorSpec(**topomap.sensor) == sensor


def test_the_graph_is_connected(plan_and_map):
    _, topomap = plan_and_map
    a, b = topomap.edges.T
    n = len(topomap.nodes)
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(n, n))
    assert connected_components(graph, directed=False)[0] == 1


def test_edges_cross_no_obstacle(plan_and_map):
    plan, topomap = plan_and_map
    lines = shapely.linestrings(topomap.nodes.true_pose[topomap.edges][:, :, :2])
    assert shapely.distance(obstacles(plan), lines).min() > 0.03


def test_edges_are_adjacent_pairs_and_never_skip_within_a_lane(plan_and_map):
    _, topomap = plan_and_map
    a, b = topomap.edges.T
    lane = topomap.nodes.lane
    assert (b[lane[a] == lane[b]] == a[lane[a] == lane[b]] + 1).all()
    assert np.median(topomap.edge_lengths()) < 0.4
    assert len(np.unique(topomap.edges, axis=0)) == len(topomap.edges)
    for nodes in lanes(topomap):
        pairs = {tuple(edge) for edge in topomap.edges.tolist()}
        assert all((k, k + 1) in pairs for k in nodes[:-1].tolist())


def test_nodes_lie_ten_centimetres_apart_on_straight_lanes(plan_and_map):
    _, topomap = plan_and_map
    position = topomap.nodes.true_pose[:, :2]
    gaps = np.concatenate(
        [np.hypot(*np.diff(position[nodes], axis=0).T) for nodes in lanes(topomap)]
    )
    assert np.median(gaps) == pytest.approx(0.10, abs=0.006)
    assert np.quantile(np.abs(gaps - 0.10), 0.9) < 0.03


def test_lanes_of_a_part_lie_thirty_centimetres_apart(plan_and_map):
    """Kept cross-lane neighbours: nodes of successive lanes of one part."""
    _, topomap = plan_and_map
    nodes, position = topomap.nodes, topomap.nodes.true_pose[:, :2]
    spacing = []
    for here in lanes(topomap):
        before = np.flatnonzero(
            (nodes.lane == nodes.lane[here[0]] - 1) & (nodes.part == nodes.part[here[0]])
        )
        if len(before) > 2 and len(here) > 2:
            line = shapely.linestrings(position[before])
            away = shapely.distance(line, shapely.points(position[here]))
            spacing.extend(away[away < 0.4])
    assert 0.25 < np.median(spacing) < 0.33


def test_lanes_are_numbered_as_algorithm_1_needs(plan_and_map):
    """Lane numbers of a part are consecutive; parts and lanes grow with time."""
    _, topomap = plan_and_map
    nodes = topomap.nodes
    assert (np.diff(nodes.lane) >= 0).all() and (np.diff(nodes.part) >= 0).all()
    for part in np.unique(nodes.part):
        numbers = np.unique(nodes.lane[nodes.part == part])
        np.testing.assert_array_equal(numbers, np.arange(numbers[0], numbers[-1] + 1))
    assert set(np.unique(topomap.path.lane)) == {-1, *np.unique(nodes.lane).tolist()}


def test_the_map_is_locally_consistent_and_drifts(plan_and_map):
    """Within half a metre, distances agree to centimetres; in all, the map is off."""
    _, topomap = plan_and_map
    estimate, truth = topomap.nodes.position, topomap.nodes.true_pose[:, :2]
    a, b = np.triu_indices(len(estimate), 1)
    true_length = np.hypot(*(truth[a] - truth[b]).T)
    near = true_length < 0.5
    error = np.hypot(*(estimate[a] - estimate[b]).T)[near] - true_length[near]
    assert np.quantile(np.abs(error), 0.95) < 0.06
    assert np.hypot(*(estimate - truth).T).max() > 0.005


def test_visits_begin_with_the_creation(plan_and_map):
    _, topomap = plan_and_map
    visits = topomap.visits
    assert (np.diff(visits.time) >= 0).all()
    assert set(visits.node.tolist()) == set(range(len(topomap.nodes)))
    first = [visits.time[visits.node == k].min() for k in range(len(topomap.nodes))]
    assert (np.diff(first) > 0).all()
    assert len(visits.node) > len(topomap.nodes)


def test_obstacle_points_lie_on_obstacles(plan_and_map):
    """Nearly all do, after taking the drift of their moment away."""
    plan, topomap = plan_and_map
    points, path = topomap.obstacles, topomap.path
    row = np.clip(np.searchsorted(path.time, points.time - 1e-9), 0, len(path.time) - 1)
    truth, estimate = path.true_pose[row], path.estimate[row]
    angle = truth[:, 2] - estimate[:, 2]
    x, y = (points.position - estimate[:, :2]).T
    c, s = np.cos(angle), np.sin(angle)
    placed = truth[:, :2] + np.column_stack([c * x - s * y, s * x + c * y])
    away = shapely.distance(obstacles(plan).boundary, shapely.points(placed))
    assert np.quantile(away, 0.9) < 0.04
    assert (away > 0.06).any(), "false measurements belong to the sensor"
    assert points.beam.max() <= 7


def test_rooms_and_borders_of_two_rooms(two_rooms_map):
    truth = two_rooms_map.ground_truth
    assert truth.frame == "scene" and truth.room is None
    assert truth.room_count == 2
    right = two_rooms_map.nodes.true_pose[:, 0] > 2.06
    a, b = two_rooms_map.edges.T
    assert truth.edge_is_border[right[a] != right[b]].all()
    assert 0.0 < truth.edge_is_border.mean() < 0.1


def test_same_seed_same_map_other_seed_another(two_rooms_map):
    again = simulate(two_rooms(), seed=1)
    for name in ("nodes", "visits", "obstacles", "path", "ground_truth"):
        one, two = getattr(two_rooms_map, name), getattr(again, name)
        for field in dataclasses.fields(one):
            np.testing.assert_array_equal(getattr(one, field.name), getattr(two, field.name))
    np.testing.assert_array_equal(two_rooms_map.edges, again.edges)
    assert two_rooms_map.scene == again.scene and two_rooms_map.created == again.created
    other = simulate(two_rooms(), seed=2)
    assert other.nodes.position.shape != again.nodes.position.shape or not np.array_equal(
        other.nodes.position, again.nodes.position
    )


@pytest.mark.parametrize("door", [0.42, 0.6, 1.2])
def test_narrow_and_wide_doorways_are_passed(door):
    plan = two_rooms(door=door)
    topomap = simulate(plan, seed=5)
    assert topomap.ground_truth.room_count == 2
    assert coverage_report(topomap, plan).coverage >= 0.97


def test_a_slit_that_is_too_tight_is_not_tried_for_ever():
    """Nodes on either side of a slit are joined, as the map may place its sides a little off."""
    plan = slits(0.295)
    report = coverage_report(simulate(plan, seed=0), plan)
    assert report.coverage >= 0.98 and report.from_home < 0.3
    assert report.path_length < 3.5 * report.shortest_path


def test_without_noise_the_estimate_is_the_truth():
    robot = RobotSpec(
        slip_bias=0.0, slip_noise=0.0, correction_position_noise=0.0, correction_heading_noise=0.0
    )
    topomap = simulate(box_room(), robot=robot, sensor=SensorSpec(false_rate=0.0))
    gap = topomap.path.true_pose[:, :2] - topomap.path.estimate[:, :2]
    assert np.hypot(*gap.T).max() < 1e-3


def test_a_long_corridor_is_cleaned_in_spite_of_bad_odometry():
    """Metres away from its map the robot still finds back to it."""
    plan = box_room(width=8.0, height=0.9, start=(4.0, 0.45))
    topomap = simulate(plan, seed=7, robot=RobotSpec(slip_bias=0.002, slip_noise=0.006))
    report = coverage_report(topomap, plan)
    assert report.coverage >= 0.97 and report.connected


def test_another_start_is_used():
    topomap = simulate(box_room(), start=(1.8, 1.2, np.pi))
    np.testing.assert_allclose(topomap.path.true_pose[0], [1.8, 1.2, -np.pi], atol=1e-6)


def test_a_base_in_the_wall_is_refused():
    with pytest.raises(RoomsegError, match=r"start\.position \(0\.05, 0\.6\).*0\.15"):
        simulate(box_room(), start=(0.05, 0.6, 0.0))


def test_a_run_that_does_not_end_is_given_up():
    with pytest.raises(RoomsegError, match="time_limit"):
        simulate(box_room(), robot=RobotSpec(time_limit=20.0))


def test_crossing_borders_by_hand():
    positions = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    edges = np.array([[0, 1], [1, 2], [0, 2]], dtype=np.int32)
    borders = np.array([[[1.5, -1.0], [1.5, 1.0]]])
    assert crosses_border(positions, edges, borders).tolist() == [False, True, True]
    assert not crosses_border(positions, edges, np.zeros((0, 2, 2))).any()


def test_a_base_outside_the_rooms_is_refused():
    with pytest.raises(RoomsegError, match="outside the rooms"):
        simulate(load_apartment("demo1"), start=(50.0, 50.0, 0.0))


def gap_edges(clearance: float) -> int:
    """Edges through a gap of 22 cm in a thin wall that ends in the room."""
    wall = ((0.0, 0.45), (0.67, 1.1))
    blocks = tuple(
        Block(polygon=((1.18, low), (1.22, low), (1.22, high), (1.18, high)), top=0.5)
        for low, high in wall
    )
    plan = box_room().model_copy(update={"blocks": blocks})
    topomap = simulate(plan, seed=1, robot=RobotSpec(edge_clearance=clearance))
    assert coverage_report(topomap, plan).coverage >= 0.97
    lines = shapely.linestrings(topomap.nodes.true_pose[topomap.edges, :2])
    return int(shapely.intersects(lines, shapely.LineString([(1.2, 0.3), (1.2, 0.9)])).sum())


def test_no_edge_leads_through_a_gap_that_the_body_cannot_pass():
    assert gap_edges(RobotSpec().edge_clearance) == 0
    assert gap_edges(0.05) > 0, "the gap is where edges could be"
