"""What a press, a drag and a release of the mouse mean on the map.

A press near the end of a border takes that end, near its middle part the whole border,
anywhere else it begins a new one. A click selects what lies beneath it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from roomseg.annotation.drawing import Border, Segment

__all__ = ["Drag", "border_at", "line_at", "pressed"]

Floats = NDArray[np.float64]
Point = tuple[float, float]


@dataclass(frozen=True)
class Drag:
    """A drag in progress.

    Attributes
    ----------
    start : tuple of float
        Where the mouse was pressed, m.
    border : int or None
        The border that is moved; None: a new one is drawn.
    line : Segment
        Its ends before.
    ends : tuple of bool
        Which of its ends move.
    """

    start: Point
    border: int | None
    line: Segment
    ends: tuple[bool, bool]

    def to(self, x: float, y: float) -> Segment:
        """The line if the mouse were released here."""
        dx, dy = x - self.start[0], y - self.start[1]
        x0, y0, x1, y1 = self.line
        first, second = self.ends
        return x0 + dx * first, y0 + dy * first, x1 + dx * second, y1 + dy * second


def pressed(borders: Iterable[Border], x: float, y: float, tolerance: float) -> Drag:
    """Begin a drag; ``tolerance`` is how far off, m, the mouse still takes something."""
    found = tuple(borders)
    if found:
        ends = np.array([border.ends for border in found]).reshape(-1, 2, 2)
        off = np.linalg.norm(ends - (x, y), axis=2)
        index, end = np.unravel_index(off.argmin(), off.shape)
        if off[index, end] <= tolerance:
            taken = found[int(index)]
            return Drag((x, y), taken.id, taken.ends, (end == 0, end == 1))
        whole = border_at(found, x, y, tolerance)
        if whole is not None:
            return Drag((x, y), whole.id, whole.ends, (True, True))
    return Drag((x, y), None, (x, y, x, y), (False, True))


def border_at(borders: Iterable[Border], x: float, y: float, tolerance: float) -> Border | None:
    """The border nearest to a point, if it is near enough."""
    found = tuple(borders)
    index = line_at(np.array([border.ends for border in found]).reshape(-1, 2, 2), x, y, tolerance)
    return None if index is None else found[index]


def line_at(lines: Floats, x: float, y: float, tolerance: float) -> int | None:
    """Index of the line, of shape (k, 2, 2), nearest to a point, if it is near enough."""
    if not len(lines):
        return None
    distance = shapely.distance(shapely.linestrings(lines), shapely.Point(x, y))
    nearest = int(distance.argmin())
    return nearest if distance[nearest] <= tolerance else None
