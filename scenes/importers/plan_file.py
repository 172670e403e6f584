"""What all readers of plan files share: scale and extent checked, one line for what is wrong."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import shapely
from pydantic import ValidationError

from scenes.errors import SceneError
from scenes.faults import value_fault
from scenes.importers import Imported
from scenes.importers.drawing import PlanDrawing, free_name
from scenes.importers.plan import PlanOptions, build_apartment

__all__ = ["ask_for_scale", "built", "check_extent", "check_scale"]

SMALLEST, LARGEST = 1.5, 300.0
"""The longer side of a home, m."""
UNITS = {0.001: "millimetres", 0.01: "centimetres", 0.0254: "inches", 0.3048: "feet"}


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
        message = f"{path}: {where}: {fault['input']!r:.60}; {value_fault(fault)}"
        raise SceneError(message) from None
