"""From a sketch on a grid to rooms and walls of real thickness.

Grid lines become wall centre lines, stretched until the clear floor has the
area asked for. Walls to the outside are thicker than those between rooms.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from scenes.apartment import RoomKind
from scenes.generator.programme import HABITABLE, LEAST_SIDE
from scenes.generator.sketch import Sketch

__all__ = ["OUTSIDE", "FloorPlan", "Stretch", "lay_out", "rectangles"]

OUTSIDE = -1


@dataclass(frozen=True)
class Stretch:
    """A straight piece of wall between the same two rooms, along its centre line.

    ``upright``: along y at x = ``line``, else along x at y = ``line``; from
    ``low`` to ``high``, m. ``first`` is the room left of it or below,
    ``second`` right or above (`OUTSIDE` for none).
    """

    upright: bool
    line: float
    low: float
    high: float
    first: int
    second: int

    @property
    def is_outer(self) -> bool:
        """Whether one side of it is outside."""
        return OUTSIDE in (self.first, self.second)

    def point(self, along: float) -> tuple[float, float]:
        """The point of the centre line there, m."""
        return (self.line, along) if self.upright else (along, self.line)


@dataclass(frozen=True)
class FloorPlan:
    """Clear floors of the rooms, the stretches of wall around them, and wall thicknesses, m."""

    kinds: tuple[RoomKind, ...]
    rooms: tuple[Polygon, ...]
    stretches: tuple[Stretch, ...]
    links: tuple[tuple[int, int], ...]
    hub: int
    outer: float
    inner: float

    def between(self, a: int, b: int) -> list[Stretch]:
        """Stretches of wall between two rooms, or a room and `OUTSIDE`."""
        return [s for s in self.stretches if {s.first, s.second} == {a, b}]

    def thickness(self, stretch: Stretch) -> float:
        """Thickness of a stretch of wall, m."""
        return self.outer if stretch.is_outer else self.inner

    def walls(self) -> Iterator[tuple[tuple[float, float], tuple[float, float], float]]:
        """Centre lines and thicknesses, m: stretches in line joined to one wall."""
        lines: dict[tuple[bool, float, float], list[Stretch]] = defaultdict(list)
        for stretch in self.stretches:
            lines[stretch.upright, stretch.line, self.thickness(stretch)].append(stretch)
        for (_, _, thickness), unsorted in lines.items():
            parts = sorted(unsorted, key=lambda part: part.low)
            start, end = parts[0].low, parts[0].high
            for part in parts[1:]:
                if part.low > end:
                    yield parts[0].point(start), parts[0].point(end), thickness
                    start = part.low
                end = part.high
            yield parts[0].point(start), parts[0].point(end), thickness


def lay_out(rng: np.random.Generator, sketch: Sketch, area: float) -> FloorPlan | None:
    """Rooms of that clear floor area (m²) in all; None if one is too narrow or too long."""
    outer = float(rng.choice([0.28, 0.3, 0.32, 0.36]))
    inner = float(rng.choice([0.1, 0.12, 0.12, 0.14]))
    module = float(np.sqrt(1.13 * area / np.count_nonzero(sketch.labels != OUTSIDE)))
    if not all(_promising(sketch, index, module, inner) for index in range(len(sketch.kinds))):
        return None
    for attempt in range(6):
        plan = _trace(sketch, module, outer, inner)
        clear = float(shapely.area(plan.rooms).sum())
        if clear < 0.3 * area:
            return None
        # Shapes hardly change after the second step; most plans end here.
        if attempt == 1 and not (all(map(_livable, plan.kinds, plan.rooms)) and _lit(plan)):
            return None
        if attempt > 1 and abs(clear - area) <= 0.005 * area:
            break
        module *= float(np.sqrt(area / clear))
    met = abs(clear - area) <= 0.02 * area
    return plan if met and all(map(_livable, plan.kinds, plan.rooms)) and _lit(plan) else None


def _promising(sketch: Sketch, index: int, module: float, inner: float) -> bool:
    """Whether the bounds of a room are wide and square enough to be worth tracing."""
    rows, columns = np.nonzero(sketch.labels == index)
    if not len(rows):
        return False
    short, long = np.sort(module * np.array([np.ptp(rows), np.ptp(columns)]) + module - inner)
    kind = sketch.kinds[index]
    return bool(short > LEAST_SIDE[kind] - 0.1 and (kind == "corridor" or long < 2.6 * short))


def _livable(kind: RoomKind, shape: Polygon) -> bool:
    """Whether a room is in one piece, wide enough everywhere, and no tube."""
    if shape.geom_type != "Polygon" or shape.interiors:
        return False
    reach = LEAST_SIDE[kind] / 2 - 1e-3
    parts = rectangles(shape)
    # Arms of living rooms and bedrooms may be narrower than the room itself.
    if len(parts) > 1:
        reach = min(reach, 0.9 if kind == "living_room" else 0.7)
        x0, y0, x1, y1 = parts[0]
        if min(x1 - x0, y1 - y0) < LEAST_SIDE[kind] - 0.2:
            return False
    opened = shape.buffer(-reach, join_style="mitre")
    if opened.geom_type != "Polygon" or opened.is_empty:
        return False
    if opened.buffer(reach, join_style="mitre").area < 0.93 * shape.area:
        return False
    x0, y0, x1, y1 = shape.bounds
    short, long = sorted((x1 - x0, y1 - y0))
    return kind == "corridor" or long <= 2.5 * short


def _lit(plan: FloorPlan) -> bool:
    """Whether every habitable room has an outer wall that is long enough for a window."""
    return all(
        any(s.high - s.low > 1.4 + plan.outer for s in plan.between(index, OUTSIDE))
        for index, kind in enumerate(plan.kinds)
        if kind in HABITABLE
    )


def rectangles(shape: Polygon) -> list[tuple[float, float, float, float]]:
    """Cut a rectilinear polygon into boxes (x0, y0, x1, y1), the largest first."""
    xs, ys, inside = _cells(shape)
    boxes = []
    while inside.any():
        j0, i0, j1, i1 = _largest(inside, xs, ys)
        inside[j0:j1, i0:i1] = False
        boxes.append((float(xs[i0]), float(ys[j0]), float(xs[i1]), float(ys[j1])))
    return boxes


def _cells(shape: Polygon) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Grid through all corners, and which of its cells lie inside."""
    corners = shapely.get_coordinates(shape)
    xs, ys = np.unique(corners[:, 0]), np.unique(corners[:, 1])
    mid_x, mid_y = np.meshgrid((xs[:-1] + xs[1:]) / 2, (ys[:-1] + ys[1:]) / 2)
    return xs, ys, shapely.contains_xy(shape, mid_x, mid_y)


def _largest(
    inside: NDArray[np.bool_], xs: NDArray[np.float64], ys: NDArray[np.float64]
) -> tuple[int, int, int, int]:
    """Rows and columns of the largest full rectangle of a small grid."""
    ny, nx = inside.shape
    full = [
        (j0, i0, j1, i1)
        for j0 in range(ny)
        for i0 in range(nx)
        if inside[j0, i0]
        for j1 in range(j0 + 1, ny + 1)
        for i1 in range(i0 + 1, nx + 1)
        if inside[j0:j1, i0:i1].all()
    ]
    return max(full, key=lambda box: (ys[box[2]] - ys[box[0]]) * (xs[box[3]] - xs[box[1]]))


# ---- tracing ----------------------------------------------------------------------------------


def _trace(sketch: Sketch, module: float, outer: float, inner: float) -> FloorPlan:
    """Stretches and clear floors of a sketch whose cells are ``module`` m wide."""
    labels = np.pad(sketch.labels, 1, constant_values=OUTSIDE)
    ix = np.flatnonzero((np.diff(labels, axis=1) != 0).any(axis=0))
    iy = np.flatnonzero((np.diff(labels, axis=0) != 0).any(axis=1))
    xs, ys = np.round(ix * module, 2), np.round(iy * module, 2)
    # One row and column for each strip between two lines, and the outside around.
    small = labels[np.ix_([0, *(iy + 1)], [0, *(ix + 1)])]
    stretches = (*_stretches(small, xs, ys, True), *_stretches(small.T, ys, xs, False))
    plan = FloorPlan(sketch.kinds, (), stretches, sketch.links, sketch.hub, outer, inner)
    rooms = tuple(_clear(plan, small, xs, ys, index) for index in range(len(sketch.kinds)))
    return FloorPlan(sketch.kinds, rooms, stretches, sketch.links, sketch.hub, outer, inner)


def _stretches(
    small: NDArray[np.int64],
    lines: NDArray[np.float64],
    levels: NDArray[np.float64],
    upright: bool,
) -> Iterator[Stretch]:
    """Borders between unlike cells side by side, those between the same two joined."""
    for i, line in enumerate(lines):
        run: Stretch | None = None
        for j in range(len(levels) - 1):
            first, second = int(small[j + 1, i]), int(small[j + 1, i + 1])
            low, high = float(levels[j]), float(levels[j + 1])
            if run is not None and (run.first, run.second) == (first, second):
                run = Stretch(upright, run.line, run.low, high, first, second)
                continue
            if run is not None and run.first != run.second:
                yield run
            run = Stretch(upright, float(line), low, high, first, second)
        if run is not None and run.first != run.second:
            yield run


def _clear(
    plan: FloorPlan,
    small: NDArray[np.int64],
    xs: NDArray[np.float64],
    ys: NDArray[np.float64],
    index: int,
) -> Polygon:
    """A room's cells without the half of each wall that stands on them."""
    own = np.argwhere(small[1:-1, 1:-1] == index)
    cells = [shapely.box(xs[i], ys[j], xs[i + 1], ys[j + 1]) for j, i in own]
    bands = [_band(s, plan.thickness(s)) for s in plan.stretches if index in (s.first, s.second)]
    corners = _corners(plan, small, xs, ys, index)
    clear = shapely.union_all(cells).difference(shapely.union_all([*bands, *corners]))
    return shapely.set_precision(clear, 1e-3).simplify(1e-6).normalize()


def _band(stretch: Stretch, thickness: float) -> Polygon:
    half = thickness / 2
    if stretch.upright:
        return shapely.box(stretch.line - half, stretch.low, stretch.line + half, stretch.high)
    return shapely.box(stretch.low, stretch.line - half, stretch.high, stretch.line + half)


def _corners(
    plan: FloorPlan,
    small: NDArray[np.int64],
    xs: NDArray[np.float64],
    ys: NDArray[np.float64],
    index: int,
) -> Sequence[Polygon]:
    """What two walls take where they meet at a corner that juts into the room."""
    mine = small == index
    around = mine[:-1, :-1].astype(int) + mine[1:, :-1] + mine[:-1, 1:] + mine[1:, 1:]
    corners = []
    for j, i in np.argwhere(around == 3):
        four = small[j : j + 2, i : i + 2]
        half = (plan.outer if OUTSIDE in four else plan.inner) / 2
        corners.append(shapely.box(xs[i] - half, ys[j] - half, xs[i] + half, ys[j] + half))
    return corners
