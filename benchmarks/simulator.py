"""How fast is a cleaning run? Beside ir-sim on the same plan, and against the floor area.

The peer gets the apartment's obstacles as lines, a round robot with a diff drive, a
2D lidar with the same number of beams and range, the same time step, and the very
speeds that our robot drove; it moves, casts and checks for collisions. Our run does
the same and also builds the map, corrects its position and decides where to drive; its
laser is set to scan in every step, as the peer's does, for the comparison only.

    pip install ir-sim -c constraints.txt
    python benchmarks/simulator.py
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path
from typing import Any

# Some files here have the names of packages, which Python would find first.
sys.path[:] = [folder for folder in sys.path if Path(folder) != Path(__file__).resolve().parent]

import click
import numpy as np
import yaml

from roomseg.cli.output import write_table
from scenes import Apartment, load_apartment, obstacles
from scenes.generator import generate_apartment
from scenes.solids import floor_area
from simulator import RobotSpec, SensorSpec, simulate


def seconds(apartment: Apartment, **settings: Any) -> tuple[float, Any]:
    """CPU seconds of one run, and its map."""
    begin = time.process_time()
    topomap = simulate(apartment, **settings)
    return time.process_time() - begin, topomap


def peer_world(apartment: Apartment, robot: RobotSpec, sensor: SensorSpec) -> dict[str, Any]:
    """The same plan and robot for ir-sim."""
    plan = obstacles(apartment, high=robot.height)
    rings = [ring for part in plan.geoms for ring in (part.exterior, *part.interiors)]
    lines = [[[float(x), float(y)] for x, y in ring.coords] for ring in rings]
    low = np.array(plan.bounds[:2]) - 1.0
    size = np.array(plan.bounds[2:]) + 1.0 - low
    lidar = {
        "name": "lidar2d",
        "range_max": sensor.maximum_range,
        "angle_range": 2.0 * np.pi * (1.0 - 1.0 / sensor.beams),
        "number": sensor.beams,
        "noise": True,
        "std": sensor.range_noise,
    }
    body = {
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": robot.radius},
        "state": [*apartment.start.position, float(np.radians(apartment.start.heading_deg))],
        "goal": [float(size[0]), float(size[1]), 0.0],
        "vel_min": [-1.0, -4.0],
        "vel_max": [1.0, 4.0],
        "sensors": [lidar],
    }
    world = {
        "width": float(size[0]),
        "height": float(size[1]),
        "offset": low.tolist(),
        "step_time": robot.time_step,
        "sample_time": robot.time_step,
        "collision_mode": "unobstructed",
    }
    shapes = [
        {"shape": {"name": "linestring", "vertices": line}, "state": [0.0, 0.0, 0.0]}
        for line in lines
    ]
    return {"world": world, "robot": [body], "obstacle": shapes}


def peer_steps_per_second(world: dict[str, Any], drive: np.ndarray) -> float:
    """Steps in a second of CPU time, without plots."""
    import irsim

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "world.yaml"
        path.write_text(yaml.safe_dump(world))
        environment = irsim.make(str(path), headless=True, log_level="ERROR")
        begin = time.process_time()
        for speeds in drive:
            environment.step(speeds[:, None])
            environment.get_lidar_scan()
        spent = time.process_time() - begin
        environment.end()
    return len(drive) / spent


def driven_speeds(topomap: Any, steps: int) -> np.ndarray:
    """Speed (m/s) and turn rate (rad/s) of the first steps of a run, (steps, 2)."""
    path = topomap.path
    pose = path.true_pose[: steps + 1]
    change, dt = np.diff(pose, axis=0), np.diff(path.time[: steps + 1])
    ahead = change[:, 0] * np.cos(pose[:-1, 2]) + change[:, 1] * np.sin(pose[:-1, 2])
    turn = (change[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    return np.stack([ahead / dt, turn / dt], axis=1)


@click.command()
@click.option("--place", default="sim1", show_default=True)
@click.option("--steps", default=2000, show_default=True, help="Steps of the peer.")
def main(place: str, steps: int) -> None:
    apartment = load_apartment(place)
    simulate(load_apartment("demo1"))  # compiles, or loads what is compiled
    spent, topomap = seconds(apartment)
    driven = topomap.path.time[-1]
    rows = [
        (f"{place}: CPU seconds of a run", f"{spent:.2f}"),
        ("map nodes", str(len(topomap.nodes))),
        ("robot-seconds per second", f"{driven / spent:,.0f}"),
    ]
    robot = RobotSpec()
    sensor = SensorSpec(period=robot.time_step)
    spent, topomap = seconds(apartment, sensor=sensor)
    own = len(topomap.path.time) / spent
    rows.append(("steps per second, a scan in each", f"{own:,.0f}"))
    try:
        peer = peer_steps_per_second(
            peer_world(apartment, robot, sensor), driven_speeds(topomap, steps)
        )
        rows += [
            ("ir-sim: steps per second", f"{peer:,.0f}"),
            ("ratio", f"{own / peer:.1f}"),
        ]
    except ImportError:
        rows.append(("ir-sim", "not installed"))
    write_table("Speed of a cleaning run", ("", "measured"), rows)
    homes = [(home, seconds(home)[0]) for home in sized_homes()]
    areas = np.array([floor_area(home) for home, _ in homes])
    times = np.array([spent for _, spent in homes])
    slope = np.polyfit(np.log(areas), np.log(times), 1)[0]
    table = [(f"{area:.0f}", f"{spent:.2f}") for area, spent in zip(areas, times, strict=True)]
    write_table("CPU seconds against floor area", ("m²", "s"), table)
    print(f"log-log slope {slope:.2f}")


def sized_homes() -> list[Apartment]:
    """Made-up homes from 25 to 280 m²."""
    sizes = ((2, 25.0), (3, 40.0), (5, 65.0), (7, 100.0), (9, 150.0), (12, 220.0), (12, 280.0))
    return [
        generate_apartment(seed, rooms=rooms, area=area) for rooms, area in sizes for seed in (1, 2)
    ]


if __name__ == "__main__":
    main()
