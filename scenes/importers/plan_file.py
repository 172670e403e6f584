"""Reading plan files: size and text checked first, one line for what is wrong."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from pydantic import ValidationError

from scenes.errors import SceneError
from scenes.importers import Imported
from scenes.importers.drawing import PlanDrawing, free_name
from scenes.importers.plan import PlanOptions, build_apartment

__all__ = ["ask_for_scale", "built", "check_extent", "check_scale", "read_json", "read_text"]

LARGEST_FILE = 20_000_000
"""Bytes; the largest plans of the data sets read here have a few hundred thousand."""
SMALLEST, LARGEST = 1.5, 300.0
"""The longer side of a home, m."""
UNITS = {0.001: "millimetres", 0.01: "centimetres", 0.0254: "inches", 0.3048: "feet"}


def read_text(path: str | Path, expected: str) -> str:
    """The text of a plan file.

    Raises
    ------
    SceneError
        If it cannot be read, is empty, too large, or no text.
    """
    try:
        size = Path(path).stat().st_size
        if size > LARGEST_FILE:
            raise SceneError(
                f"{path}: {size / 1e6:.0f} MB; expected {expected} of at most "
                f"{LARGEST_FILE / 1e6:.0f} MB"
            )
        data = Path(path).read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise SceneError(f"{path}: cannot be read: {reason}") from None
    if not data.strip():
        raise SceneError(f"{path}: the file is empty; expected {expected}")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError(f"{path}: byte {error.start} is not text; expected {expected}") from None


def read_json(path: str | Path, expected: str) -> Any:
    """The data of a JSON file; errors as `read_text`, and if it is no JSON."""

    def constant(name: str) -> Any:
        raise SceneError(f"{path}: {name} is not a JSON number; expected a finite one")

    text = read_text(path, expected)
    try:
        return json.loads(text, parse_constant=constant)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise SceneError(f"{path}: {where}: not JSON: {error.msg}; expected {expected}") from None
    except (RecursionError, ValueError):
        raise SceneError(
            f"{path}: nested too deeply or a number too long; expected {expected}"
        ) from None


def check_scale(path: str | Path, scale: float | None) -> None:
    """Refuse a scale that is no positive number.

    Raises
    ------
    SceneError
    """
    if scale is not None and not (np.isfinite(scale) and scale > 0.0):
        raise SceneError(f"{path}: scale {scale:g}; expected a positive number, metres per unit")


def ask_for_scale(
    path: str | Path, doors: Sequence[float], width: float, quantile: float = 0.5
) -> SceneError:
    """The line that asks for a scale, with one at which that quantile of doors has a width.

    Parameters
    ----------
    doors : sequence of float
        Widths of the doors in units of the file.
    width : float
        What the width of a door should be, m.
    """
    line = f"{path}: has no scale; expected --scale METRES_PER_UNIT"
    usable = [door for door in doors if door > 0.0]
    if usable:
        scale = width / float(np.quantile(usable, quantile))
        which = "doors" if quantile == 0.5 else "most doors"
        wide = float(np.quantile(usable, 0.5)) * scale
        line += f", such as {scale:.3g} ({which} would be {wide:.2f} m wide)"
    return SceneError(line)


def check_extent(path: str | Path, shapes: Sequence[shapely.Geometry], scale: float | None) -> None:
    """Refuse a plan that is too large or too small for a home, with a scale that may be meant.

    Raises
    ------
    SceneError
    """
    if not shapes:
        return
    west, south, east, north = shapely.total_bounds(shapes)
    size = max(east - west, north - south)
    if SMALLEST <= size <= LARGEST:
        return
    given = 1.0 if scale is None else scale
    line = f"{path}: {size:.4g} m wide at {given:g} m per unit; expected --scale METRES_PER_UNIT"
    fits = [unit for unit in UNITS if 3.0 <= size / given * unit <= 60.0]
    if fits:
        wide = size / given * fits[0]
        line += f", such as {fits[0]:g} if it is in {UNITS[fits[0]]} ({wide:.3g} m wide)"
    elif size < SMALLEST:
        line += "; degrees of longitude and latitude must be projected to metres first"
    raise SceneError(line)


def built(
    path: str | Path, drawing: PlanDrawing, name: str | None, options: PlanOptions | None
) -> Imported:
    """The apartment of a drawing, by default with the file's name.

    Raises
    ------
    SceneError
        Whose line begins with the file's name.
    """
    chosen = free_name(Path(path).stem, ()) if name is None else name
    try:
        return build_apartment(drawing, name=chosen, options=options)
    except SceneError as error:
        raise SceneError(f"{path}: {error}") from None
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        where = ".".join(str(item) for item in fault["loc"])
        message = " ".join(fault["msg"].split())
        raise SceneError(f"{path}: {where}: {fault['input']!r:.60}: {message}") from None
