"""Where the names of rooms find room on a plan."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

__all__ = ["Label", "place_label"]

LETTER = 0.66
"""Mean width of a letter, in font sizes."""
LINE = 1.3
"""Distance of two lines, in font sizes."""
POINT = 1.0 / 72.0
GRID = 40
"""Places tried along the longer side of a room."""


@dataclass(frozen=True)
class Label:
    """Middle of a text, m; its font size, pt; its rotation, 0 or 90 degrees."""

    x: float
    y: float
    size: float
    rotation: int


def place_label(floor: Any, taken: Any, lines: list[str], inches: float) -> Label:
    """Choose place, size and rotation of a room's label.

    On free floor if there is enough of it, else across the furniture, at last too
    large for the room: a name is never left out.

    Parameters
    ----------
    floor, taken : shapely geometry
        The room's floor, and what stands on it, m.
    lines : list of str
        The text.
    inches : float
        What 1 m measures on paper.
    """
    free = floor.difference(taken)
    for region, size, rotation in _attempts(floor, free):
        width = LETTER * max(len(line) for line in lines) * size * POINT / inches
        height = LINE * len(lines) * size * POINT / inches
        spot = _spot(region, (height, width) if rotation else (width, height))
        if spot is not None:
            return Label(float(spot[0]), float(spot[1]), size, rotation)
    point = floor.representative_point()
    return Label(point.x, point.y, 4.0, 0)


def _attempts(floor: Any, free: Any) -> Iterator[tuple[Any, float, int]]:
    """What to try, the best first: region, font size, rotation."""
    for size in (9.0, 8.0, 7.0):
        yield free, size, 0
    yield free, 7.0, 90
    for size in (8.0, 7.0, 6.0):
        yield floor, size, 0
        yield floor, size, 90
    for size in (5.0, 4.0):
        yield floor, size, 0
        yield floor, size, 90


def _spot(region: Any, size: tuple[float, float]) -> NDArray[np.float64] | None:
    """Middle of a box of that size (m) inside a region, the nearest to the region's."""
    if region.is_empty:
        return None
    x0, y0, x1, y1 = region.bounds
    step = max(x1 - x0, y1 - y0) / GRID
    x, y = np.meshgrid(np.arange(x0, x1, step), np.arange(y0, y1, step))
    middle = np.column_stack([x.ravel(), y.ravel()])
    low, high = middle - np.array(size) / 2.0, middle + np.array(size) / 2.0
    boxes = shapely.box(*low.T, *high.T)
    shapely.prepare(region)
    fits = middle[shapely.covers(region, boxes)]
    if not len(fits):
        return None
    centre = shapely.get_coordinates(region.centroid)
    found: NDArray[np.float64] = fits[np.argmin(np.linalg.norm(fits - centre, axis=1))]
    return found
