"""Fixtures of a drawing as pieces of furniture that stand on free floor.

A fixture is drawn as an outline. Its box gives width, depth and turn, its back
is the side nearest to the walls; what of it lies in a wall is cut off, and a small
gap behind it closed. It is placed only if the robot still reaches every room afterwards.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from scenes.apartment import Apartment, Piece
from scenes.checks import piece_faults
from scenes.errors import SceneError
from scenes.importers.drawing import PlanFixture
from scenes.passages import ROBOT_RADIUS
from scenes.pieces import KINDS, piece_parts
from scenes.rooms import room_shapes
from scenes.solids import obstacles, polygons, rooms_region

__all__ = ["furnished", "reached"]

Floats = NDArray[np.float64]

LOW, HIGH = 0.01, 0.10
"""Between these heights a piece is in the robot's way, m."""
LEAST = (0.5, 0.35)
"""The shorter and the longer side of a footprint, as shares of its kind's usual ones."""
NEAR = 0.2
"""Pieces drawn within this of the wall behind them stand at it, m."""
INSET = 0.005
"""Pieces stand off the walls by this much, m."""


def reached(free: shapely.Geometry, start: shapely.Point, rooms: Sequence[Polygon]) -> list[bool]:
    """Which rooms the robot enters from its start; ``free`` is where its centre can be."""
    home = next((part for part in polygons(free) if part.intersects(start)), None)
    if home is None:
        return [False] * len(rooms)
    return [bool(home.intersection(room).area >= 1e-3) for room in rooms]


def furnished(
    apartment: Apartment, fixtures: Sequence[PlanFixture], free: shapely.Geometry
) -> tuple[list[Piece], list[str], list[str]]:
    """Pieces for the fixtures that fit, their labels, and notes on those that do not.

    Parameters
    ----------
    apartment : Apartment
        Without these pieces.
    free : geometry
        Where the robot's centre can be without them.

    Raises
    ------
    SceneError
        If a fixture is of no kind that there is.
    """
    floor = rooms_region(apartment).difference(obstacles(apartment))
    rooms = list(room_shapes(apartment))
    start = shapely.Point(apartment.start.position)
    pieces: list[Piece] = []
    labels: list[str] = []
    notes: list[str] = []
    for fixture in fixtures:
        if fixture.kind not in KINDS:
            raise SceneError(f"{fixture.label}: {fixture.kind!r} is no kind of furniture")
        piece = fixture.piece or _piece(fixture, floor)
        fault = piece if isinstance(piece, str) else next(piece_faults(piece), None)
        if fault is not None or isinstance(piece, str):
            notes.append(f"{fixture.label}: {fault}; left out")
            continue
        left = free.difference(_in_the_way(piece))
        if not all(reached(left, start, rooms)):
            notes.append(
                f"{fixture.label}: a {fixture.kind} there keeps a robot of {ROBOT_RADIUS:g} m "
                f"radius from a room or from its start; left out"
            )
            continue
        pieces.append(piece)
        labels.append(fixture.label)
        free = left
        if fixture.piece is None:
            floor = floor.difference(_footprint(piece))
    return pieces, labels, notes


def _in_the_way(piece: Piece) -> shapely.Geometry:
    """Where the robot's centre cannot be because of a piece."""
    parts = [p.footprint for p in piece_parts(piece) if p.bottom < HIGH and p.top > LOW]
    # A little more, so that rounding does not decide what the checks find.
    return shapely.union_all(parts).buffer(ROBOT_RADIUS + 2e-3, quad_segs=16)


def _footprint(piece: Piece) -> shapely.Geometry:
    return shapely.union_all([part.footprint for part in piece_parts(piece)])


def _piece(fixture: PlanFixture, floor: shapely.Geometry) -> Piece | str:
    """A piece of the fixture's kind on the floor where it is drawn, or why there is none."""
    outline = shapely.minimum_rotated_rectangle(fixture.shape)
    if outline.geom_type != "Polygon" or outline.area < 1e-3:
        return f"{outline.area:.2g} m² is no outline of a {fixture.kind}"
    axes = _axes(outline)
    inside = outline.intersection(floor.buffer(-INSET, join_style="mitre"))
    spots = polygons(inside, 0.3 * outline.area)
    if not spots:
        return f"no free floor for a {fixture.kind} there"
    spot = max(spots, key=lambda part: float(part.area))
    low, high = _extent(spot, axes)
    if not floor.buffer(1e-3).covers(_box(low, high, axes)):
        low, high = _largest_box(spot, axes)
    back = _back(low, high, axes, floor)
    low, high = _pushed(low, high, axes, back, floor)
    return _sized(fixture.kind, low, high, axes, back)


def _axes(outline: Polygon) -> Floats:
    """Unit vectors (2, 2) along the sides of a rectangle."""
    corners = shapely.get_coordinates(outline)
    along: Floats = corners[1] - corners[0]
    along = along / np.hypot(*along)
    # Quarter turns exactly, so that pieces stand parallel to the walls.
    along = np.round(along, 9)
    return np.array([along, (-along[1], along[0])])


def _extent(shape: shapely.Geometry, axes: Floats) -> tuple[Floats, Floats]:
    local = shapely.get_coordinates(shape) @ axes.T
    return local.min(axis=0), local.max(axis=0)


def _box(low: Floats, high: Floats, axes: Floats) -> Polygon:
    local = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    return Polygon(local @ axes)


def _largest_box(shape: Polygon, axes: Floats) -> tuple[Floats, Floats]:
    """The largest box in a shape that has an edge of the shape on each of its sides."""
    local = np.round(shapely.get_coordinates(shape) @ axes.T, 4)
    xs, ys = np.unique(local[:, 0]), np.unique(local[:, 1])
    # Shapes here are clipped rectangles: a handful of corners.
    xs, ys = xs[:: max(1, len(xs) // 8)], ys[:: max(1, len(ys) // 8)]
    wide = shape.buffer(2e-3)
    best, area = (local[0], local[0]), 0.0
    for a in range(len(xs)):
        for b in range(a + 1, len(xs)):
            for c in range(len(ys)):
                for d in range(c + 1, len(ys)):
                    size = float((xs[b] - xs[a]) * (ys[d] - ys[c]))
                    low, high = np.array([xs[a], ys[c]]), np.array([xs[b], ys[d]])
                    if size > area and wide.covers(_box(low, high, axes)):
                        best, area = (low, high), size
    return best


def _back(low: Floats, high: Floats, axes: Floats, floor: shapely.Geometry) -> int:
    """Which side is nearest to a wall: 0 +x, 1 +y, 2 -x, 3 -y of the box; long sides first."""
    middle, half = (low + high) / 2, (high - low) / 2
    edge = floor.boundary
    size = high - low
    distance = []
    for side in range(4):
        axis, sign = side % 2, 1 if side < 2 else -1
        point = middle.copy()
        point[axis] += sign * half[axis]
        gap = edge.distance(shapely.Point(point @ axes))
        # In a corner two sides are near: the longer is the back.
        distance.append(gap - 0.1 * size[1 - axis])
    return int(np.argmin(distance))


def _pushed(
    low: Floats, high: Floats, axes: Floats, back: int, floor: shapely.Geometry
) -> tuple[Floats, Floats]:
    """A box moved back to a wall near behind it, if the floor there is free."""
    step = np.zeros(2)
    step[back % 2] = 1.0 if back < 2 else -1.0
    along = np.array([1.0 - abs(step[0]), 1.0 - abs(step[1])])
    middle, half = (low + high) / 2, (high - low) / 2
    rear = middle + step * half
    side = shapely.LineString([(rear - along * half) @ axes, (rear + along * half) @ axes])
    gap = float(floor.boundary.distance(side)) - INSET
    if not 0.0 < gap <= NEAR:
        return low, high
    moved = low + gap * step, high + gap * step
    return moved if floor.buffer(1e-3).covers(_box(*moved, axes)) else (low, high)


def _sized(kind: str, low: Floats, high: Floats, axes: Floats, back: int) -> Piece | str:
    """The piece of a kind that fills a box, with its back to one side."""
    size = high - low
    width, depth = (size[1], size[0]) if back % 2 == 0 else (size[0], size[1])
    usual = KINDS[kind].size
    sides = zip(sorted((width, depth)), sorted(usual[:2]), LEAST, strict=True)
    if any(drawn < share * normal for drawn, normal, share in sides):
        return f"{width:.2f} x {depth:.2f} m is too small for a {kind}"
    outward = axes[back % 2] * (1 if back < 2 else -1)
    x, y = np.round((low + high) / 2 @ axes, 4).tolist()
    piece = Piece(
        kind=kind,
        position=(x, y),
        rotation_deg=round(float(np.degrees(np.arctan2(-outward[0], outward[1]))), 6),
        size=(round(float(width), 4), round(float(depth), 4), usual[2]),
    )
    try:
        parts = piece_parts(piece)
    except ValueError:
        return f"{width:.2f} x {depth:.2f} m is too small for a {kind}"
    if any(part.top <= part.bottom or part.footprint.area <= 0.0 for part in parts):
        return f"{width:.2f} x {depth:.2f} m is too small for a {kind}"
    return piece
