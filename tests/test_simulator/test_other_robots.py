"""The robots of docs/robot.md, and what each setting of robot and sensors does to a run."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import shapely

from dataset import TopoMap
from scenes import load_apartment, obstacles
from simulator import RobotSpec, SensorSpec, coverage_report, read_specs, simulate
from simulator.vehicle import Vehicle
from simulator.world import World

from .plans import two_rooms

PAGE = (Path(__file__).parents[2] / "docs" / "robot.md").read_text(encoding="utf-8")
ROBOTS = [
    text for part in PAGE.split("```toml")[1:] if "[camera]" not in (text := part.split("```")[0])
]
NAMES = ("wide", "around", "ahead")


def specs_of(text: str, tmp_path: Path) -> tuple[RobotSpec, SensorSpec]:
    path = tmp_path / "robot.toml"
    path.write_text(text)
    return read_specs(path)


def test_the_page_names_settings_that_there_are():
    table = PAGE.split("| what | settings |")[1].split("\n\n")[0]
    named = set(re.findall(r"`(\w+)`", table))
    known = {*RobotSpec.__dataclass_fields__, *SensorSpec.__dataclass_fields__}
    assert named <= known
    assert set(SensorSpec.__dataclass_fields__) <= named


def assert_cleaned(topomap: TopoMap, robot: RobotSpec, apartment) -> None:
    report = coverage_report(topomap, apartment)
    assert report.coverage >= 0.98
    assert report.connected
    assert report.from_home < 0.3
    places = shapely.points(topomap.path.true_pose[:, :2])
    apart = shapely.distance(obstacles(apartment, high=robot.height), places)
    assert apart.min() >= robot.radius - 0.001


@pytest.mark.parametrize("text", ROBOTS, ids=NAMES)
def test_the_robots_of_the_page_clean_to_the_end(text, tmp_path):
    robot, sensor = specs_of(text, tmp_path)
    assert (robot, sensor) != (RobotSpec(), SensorSpec())
    topomap = simulate(two_rooms(), seed=2, robot=robot, sensor=sensor)
    assert_cleaned(topomap, robot, two_rooms())
    assert topomap.obstacles.beam.max() == sensor.beams - 1


@pytest.mark.parametrize("text", ROBOTS, ids=NAMES)
@pytest.mark.parametrize(("name", "seed"), [("sim4", 3), ("demo1", 4)])
def test_they_clean_reference_places(name, seed, text, tmp_path):
    robot, sensor = specs_of(text, tmp_path)
    place = load_apartment(name)
    assert_cleaned(simulate(place, seed=seed, robot=robot, sensor=sensor), robot, place)


def test_odometry_knows_nothing_of_slip_and_has_no_gyro():
    """Without correction the estimate is what was commanded, whatever the body did."""
    robot = RobotSpec(slip_bias=0.02, slip_noise=0.0, correction_gain=0.0)
    world = World(shapely.box(-9, -9, 9, 9).difference(shapely.box(-8, -8, 8, 8)))
    vehicle = Vehicle(world, np.zeros(3), robot, SensorSpec(), np.random.default_rng(1))
    for _ in range(200):
        vehicle.step(robot.speed, 0.0)
    path = vehicle.path()
    way = 200 * robot.speed * robot.time_step
    assert path.estimate[-1] == pytest.approx([way, 0.0, 0.0], abs=1e-9)
    # The heading turns by what the right wheel rolls further than the left, over the base.
    assert abs(path.true_pose[-1, 2]) > 0.01
    half = path.true_pose[len(path.time) // 2, 2]
    assert path.true_pose[-1, 2] == pytest.approx(2.0 * half, rel=0.02)
