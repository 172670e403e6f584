"""The camera in a robot's TOML file.

Of the table [camera] everything may be left out:

[camera]
field_of_view_deg = 185.0
disc_diameter = 450.0
image_size = [512, 640]     # rows, columns
disc_centre = [256.0, 320.0]
vignetting = 0.38
blur = 0.6
full_well = 10000.0
read_noise = 20.0

Without an image size the image just holds the disc, without a centre the disc is in its
middle. The lens's height is the ``camera_height`` of [sensor].
"""

from __future__ import annotations

import difflib
import math
import sys
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from dataset.camera import SIMULATED_CAMERA, CameraFlaws, FisheyeCamera
from dataset.errors import FormatError
from simulator.spec_file import read_tables

__all__ = ["camera_of", "read_camera"]

FLAWS = tuple(field.name for field in fields(CameraFlaws))
NUMBERS = ("field_of_view_deg", "disc_diameter", *FLAWS)
PAIRS = ("image_size", "disc_centre")


def read_camera(path: str | Path) -> FisheyeCamera:
    """The camera of a robot's file; the simulated robot's, where it says nothing.

    Raises
    ------
    FormatError
        If the file cannot be read, is no TOML, or has an unknown or impossible
        setting; one line.
    """
    table = read_tables(path).get("camera", {})
    try:
        return camera_of(table)
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from error


def camera_of(table: Any) -> FisheyeCamera:
    """The camera of a table [camera]; FormatError that begins with the setting's name."""
    if not isinstance(table, dict):
        raise FormatError(f"camera: {table!r}, expected a table of settings")
    for name, value in table.items():
        _check(name, value)
    diameter = float(table.get("disc_diameter", SIMULATED_CAMERA.disc_diameter))
    side = math.ceil(diameter) if math.isfinite(diameter) else 1
    rows, columns = table.get("image_size", (side, side))
    # Whole pixels, so that the renderer can place the disc.
    row, column = table.get("disc_centre", (rows // 2, columns // 2))
    degrees = table.get("field_of_view_deg")
    if degrees is not None and not 0 < degrees <= 360:
        raise FormatError(f"camera.field_of_view_deg: {degrees}, expected 0 < degrees <= 360")
    field_of_view = SIMULATED_CAMERA.field_of_view if degrees is None else math.radians(degrees)
    try:
        return FisheyeCamera(
            field_of_view,
            diameter,
            (rows, columns),
            (float(row), float(column)),
            flaws=_flaws(table),
        )
    except ValueError as error:
        raise FormatError(f"camera.{error}") from error


def _flaws(table: Mapping[str, Any]) -> CameraFlaws:
    return CameraFlaws(**{name: float(table[name]) for name in FLAWS if name in table})


def _check(name: str, value: Any) -> None:
    """Refuse an unknown setting, and a value of another type."""
    known = (*NUMBERS[:2], *PAIRS, *FLAWS)
    if name not in known:
        close = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean {close[0]}" if close else f"expected one of {', '.join(known)}"
        raise FormatError(f"camera.{name}: unknown setting; {hint}")
    if name in NUMBERS:
        if not _is(value, int | float):
            raise FormatError(f"camera.{name}: {value!r}, expected a number")
        return
    kind, what = (int, "whole numbers") if name == "image_size" else (int | float, "numbers")
    if not (isinstance(value, list) and len(value) == 2 and all(_is(v, kind) for v in value)):
        raise FormatError(f"camera.{name}: {value!r}, expected two {what}: rows, columns")


def _is(value: Any, kind: Any) -> bool:
    """Whether it is of the kind, and a float can hold it: TOML's integers may be longer."""
    if not isinstance(value, kind) or isinstance(value, bool):
        return False
    return not isinstance(value, int) or abs(value) <= sys.float_info.max
