"""Robots from TOML files: what is read, and one line for every mistake."""

from __future__ import annotations

import pytest

from dataset import FormatError
from simulator import RobotSpec, SensorSpec, read_specs


def written(tmp_path, text):
    path = tmp_path / "robot.toml"
    path.write_text(text)
    return path


def test_what_is_left_out_has_its_default(tmp_path):
    path = written(
        tmp_path,
        "[robot]\nradius = 0.17\nlane_spacing = 0.3\nalign_to_walls = false\ncorrection_nodes = 2\n"
        "[sensor]\nbeams = 3\nbearings_deg = [0, 30.0, -30.0]\n",
    )
    robot, sensor = read_specs(path)
    assert robot == RobotSpec(radius=0.17, align_to_walls=False, correction_nodes=2)
    assert sensor == SensorSpec(beams=3, bearings_deg=(0.0, 30.0, -30.0))
    assert read_specs(written(tmp_path, "")) == (RobotSpec(), SensorSpec())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[robot]\nradus = 0.2", "robot.radus: unknown setting; did you mean radius"),
        ("[robot]\nradius = -1", "robot.radius: -1.0, expected a finite number >= 0"),
        ("[robot]\nradius = 'wide'", "robot.radius: 'wide', expected a number"),
        ("[robot]\nalign_to_walls = 1", "robot.align_to_walls: 1, expected true or false"),
        ("[sensor]\nbeams = 2.5", "sensor.beams: 2.5, expected a whole number"),
        ("[sensor]\nbearings_deg = 3", "sensor.bearings_deg: 3, expected a list of numbers"),
        ("[sensor]\nbearings_deg = [1]", "sensor.bearings_deg: 1 bearings, expected beams = 8"),
        ("[sensor]\nbearings_deg = [nan]\nbeams = 1", "sensor.bearings_deg: (nan,), expected fin"),
        ("[sensor]\nmaximum_range = 1e9", "sensor.maximum_range: 1000000000.0, expected at most"),
        ("[robot]\nradius = 0.6", "robot.radius: 0.6, expected at most 0.3 m"),
        (f"[robot]\nradius = 1{400 * '0'}", "expected a number"),
        (f"[robot]\ncorrection_nodes = 1{40 * '0'}", "expected a whole number"),
        ("[wheels]\nn = 3", "[wheels]: unknown, expected one of robot, sensor, camera"),
        ("robot = 3", "robot: 3, expected a table of settings"),
        ("[robot", "not a TOML text file"),
    ],
)
def test_mistakes_are_told_in_one_line(tmp_path, text, said):
    with pytest.raises(FormatError) as caught:
        read_specs(written(tmp_path, text))
    message = str(caught.value)
    assert said in message
    assert message.startswith(str(tmp_path))
    assert "\n" not in message


def test_a_missing_file(tmp_path):
    with pytest.raises(FormatError, match="cannot be read: No such file"):
        read_specs(tmp_path / "none.toml")
