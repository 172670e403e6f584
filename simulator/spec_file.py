"""Robots as TOML files, and as the settings that a map keeps.

A file says what differs from the defaults of `RobotSpec` and `SensorSpec`:

[robot]
radius = 0.17
lane_spacing = 0.25

[sensor]
beams = 3
bearings_deg = [0.0, 30.0, -30.0]

A third table, [camera], is that of `simulator.camera_file`.
"""

from __future__ import annotations

import difflib
import sys
import tomllib
from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, TypeVar

from dataset.errors import FormatError
from dataset.topomap import Settings
from simulator.laser import SensorSpec
from simulator.robot import RobotSpec

__all__ = ["read_specs", "read_tables", "settings_of", "specs_of"]

TABLES = ("robot", "sensor", "camera")

Spec = TypeVar("Spec", RobotSpec, SensorSpec)


def read_specs(path: str | Path) -> tuple[RobotSpec, SensorSpec]:
    """Read a robot and its sensors; what the file leaves out has its default.

    Raises
    ------
    FormatError
        If the file cannot be read, is no TOML, or has an unknown or impossible
        setting; one line.
    """
    data = read_tables(path)
    try:
        return specs_of(data)
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from error


def read_tables(path: str | Path) -> dict[str, Any]:
    """Read the tables of a robot's file; FormatError if it is none, or has others."""
    try:
        data = tomllib.loads(Path(path).read_bytes().decode("utf-8"))
    except OSError as error:
        raise FormatError(f"{path}: cannot be read: {error.strerror or error}") from error
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise FormatError(f"{path}: not a TOML text file: {error}") from error
    for table in data:
        if table not in TABLES:
            raise FormatError(f"{path}: [{table}]: unknown, expected one of {', '.join(TABLES)}")
    return data


def specs_of(data: Mapping[str, Any]) -> tuple[RobotSpec, SensorSpec]:
    """A robot and its sensors from the tables ``robot`` and ``sensor``, if they are there.

    Raises
    ------
    FormatError
        If a setting is unknown or impossible; one line that begins with its name.
    """
    robot = _spec(RobotSpec, data.get("robot", {}), "robot")
    return robot, _spec(SensorSpec, data.get("sensor", {}), "sensor")


def settings_of(spec: RobotSpec | SensorSpec) -> Settings:
    """All settings by their names, as they are kept in a map; without those that are None."""
    return {name: value for name, value in asdict(spec).items() if value is not None}


def _spec(kind: type[Spec], settings: Any, place: str) -> Spec:
    """One specification from its table."""
    if not isinstance(settings, dict):
        raise FormatError(f"{place}: {settings!r}, expected a table of settings")
    defaults = {setting.name: setting.default for setting in fields(kind)}
    given = {}
    for name, value in settings.items():
        if name not in defaults:
            close = difflib.get_close_matches(name, defaults, n=1)
            hint = f"did you mean {close[0]}" if close else f"expected one of {', '.join(defaults)}"
            raise FormatError(f"{place}.{name}: unknown setting; {hint}")
        given[name] = _value(value, defaults[name], f"{place}.{name}")
    try:
        return kind(**given)
    except ValueError as error:
        raise FormatError(f"{place}.{error}") from error


def _value(value: Any, default: Any, place: str) -> Any:
    """A value of the default's type."""
    if isinstance(default, bool):
        if isinstance(value, bool):
            return value
        raise FormatError(f"{place}: {value!r}, expected true or false")
    if default is None:
        if isinstance(value, list) and all(_is_number(item) for item in value):
            return tuple(float(item) for item in value)
        raise FormatError(f"{place}: {value!r}, expected a list of numbers")
    if isinstance(default, int):
        if isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**31:
            return value
        raise FormatError(f"{place}: {value!r}, expected a whole number")
    if _is_number(value):
        return float(value)
    raise FormatError(f"{place}: {value!r}, expected a number")


def _is_number(value: Any) -> bool:
    """Whether a value is a number that a float can hold: TOML's integers may be longer."""
    if isinstance(value, int):
        return not isinstance(value, bool) and abs(value) <= sys.float_info.max
    return isinstance(value, float)
