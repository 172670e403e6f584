"""Clean one apartment with the paper's robot and with another, and compare them.

Change `ROBOT`, `SENSOR` and `CAMERA`; docs/robot.md lists the settings.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from dataset import FisheyeCamera, write_map
from roomseg.ground_truth import label_rooms
from scenes import load_apartment
from simulator import RobotSpec, SensorSpec, coverage_report, simulate

ROBOT = RobotSpec(radius=0.17, lane_spacing=0.25, wheel_base=0.26, castor=0.12)
SENSOR = SensorSpec(beams=16, maximum_range=2.0)
CAMERA = FisheyeCamera(
    field_of_view=float(np.radians(185.0)),
    disc_diameter=450.0,
    image_size=(512, 640),
    disc_centre=(256.0, 320.0),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--place", default="demo1", help="a reference place or an apartment's file")
    parser.add_argument("-o", "--output", type=Path, default=Path("robots"))
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    place = load_apartment(arguments.place)
    runs = {
        "paper": simulate(place, seed=1, run="paper"),
        "other": simulate(place, seed=1, run="other", robot=ROBOT, sensor=SENSOR, camera=CAMERA),
    }
    for name, topomap in runs.items():
        write_map(arguments.output / f"{place.name}-{name}.h5", label_rooms(topomap))
        report = coverage_report(topomap, place)
        print(
            f"{name}: radius {topomap.robot_radius} m, {report.nodes} nodes, "
            f"{100 * report.coverage:.1f} % covered, {report.path_length:.0f} m driven"
        )


if __name__ == "__main__":
    main()
