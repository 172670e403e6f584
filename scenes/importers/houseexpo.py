"""Floor plans of the HouseExpo data set: JSON with one outline in metres, and boxes of rooms.

``verts`` is the outline of all free floor: walls are what it runs around, doorways are
gaps between their ends. ``room_category`` gives boxes, with a margin, that overlap and
need not cover the floor. What a room is here:

1. The floor is cut across its doorways: from the end of a wall to another corner up to
   2.0 m away, or to a wall up to 1.8 m away. What results are the rooms.
2. A room is called what the box says that covers most of it and little else. Two
   categories with one box (Toilet, Bathroom) name one room.
3. A room of several boxes, none of which covers 80 % of it (living and dining room in
   one), is cut along their sides; of overlapping boxes the smaller keeps the floor.

Rooms that no box names are ``room``. The file says nothing of windows or furniture;
the doorways get lintels.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from scenes.apartment import Point, RoomKind
from scenes.errors import SceneError
from scenes.faults import shape_fault
from scenes.importers import Imported
from scenes.importers.drawing import free_name, renamed
from scenes.importers.free_space import free_space_apartment
from scenes.importers.plan_file import check_extent, check_scale
from scenes.importers.reading import read_json
from scenes.importers.room_lamps import with_room_lamps
from scenes.solids import polygons

__all__ = ["read_houseexpo"]

Floats = NDArray[np.float64]

FORMAT = "HouseExpo JSON"
WIDEST, WIDEST_AT_WALL = 2.0, 1.8
"""Of doorways from a wall end to another corner, and to a wall, m."""
BEHIND = 0.4
"""So far behind its end there is still wall, m."""
MOST_CORNERS = 3000
"""Of an outline; the largest of the data set have a few hundred."""
LEAST_WIDTH = 0.3
"""Of a doorway, m."""
THICKEST = 0.35
"""Of a wall with an end, m."""
LEAST_ROOM = 1.0
"""Cuts that would leave less are not made, m²."""
WALLS = 0.12
"""Thickness of the outer walls, m; inner ones are as the outline has them."""
CATEGORIES: dict[str, RoomKind] = {
    "bathroom": "bathroom",
    "toilet": "bathroom",
    "kitchen": "kitchen",
    "living_room": "living_room",
    "bedroom": "bedroom",
    "child_room": "bedroom",
    "guest_room": "bedroom",
    "office": "office",
    "hallway": "corridor",
    "hall": "corridor",
    "corridor": "corridor",
    "lobby": "corridor",
    "entryway": "corridor",
    "dining_room": "other",
    "storage": "storage",
    "wardrobe": "storage",
}
"""Kinds by category; of several with one box the first of these names the room."""


@dataclass(frozen=True)
class _Box:
    """A box of rooms: its categories in lower case, its label in notes, its shape."""

    names: tuple[str, ...]
    label: str
    shape: Polygon


def read_houseexpo(
    path: str | Path,
    *,
    scale: float | None = None,
    name: str | None = None,
    start: Point | None = None,
    ceiling_height: float = 2.5,
) -> Imported:
    """Read a floor plan of HouseExpo; the module's docstring says how.

    Parameters
    ----------
    path : path
    scale : float, optional
        Metres per unit; 1 if absent, for that is what the data set has.
    name : str, optional
        Of the apartment; the file's stem if absent.
    start : tuple of float, optional
        Where the robot starts, m.
    ceiling_height : float
        m.

    Raises
    ------
    SceneError
        One line: the file, the element, its value, what would be right.
    """
    check_scale(path, scale)
    data = read_json(path, FORMAT)
    if not isinstance(data, dict) or "verts" not in data:
        raise SceneError(f"{path}: no verts; expected {FORMAT}")
    metres = 1.0 if scale is None else scale
    floor = _floor(path, data["verts"], scale)
    boxes = _boxes(path, data.get("room_category") or {}, metres)
    rooms, notes = _rooms(floor, boxes)
    imported = free_space_apartment(
        floor,
        name=name or free_name(Path(path).stem, ()),
        start=start,
        rooms=rooms,
        ceiling_height=ceiling_height,
        wall_thickness=WALLS,
    )
    return Imported(with_room_lamps(imported.apartment), (*notes, *imported.notes))


def _floor(path: str | Path, verts: Any, scale: float | None) -> Polygon:
    """The outline in metres."""
    try:
        points = np.array(verts, dtype=float).reshape(-1, 2)
        if len(points) < 3 or not np.isfinite(points).all():
            raise ValueError
    except (TypeError, ValueError):
        raise SceneError(f"{path}: verts: {verts!r:.60}; expected at least three x, y") from None
    if len(points) > MOST_CORNERS:
        raise SceneError(f"{path}: verts: {len(points)} corners; expected at most {MOST_CORNERS}")
    floor = Polygon(points * (1.0 if scale is None else scale))
    check_extent(path, [floor], scale)
    if not floor.is_valid:
        raise SceneError(f"{path}: verts: {shape_fault(floor)}; expected a simple outline")
    return floor


def _boxes(path: str | Path, categories: Any, metres: float) -> list[_Box]:
    """Boxes, each once with all its categories."""
    if not isinstance(categories, dict):
        raise SceneError(f"{path}: room_category: {categories!r:.40}; expected boxes by category")
    found: dict[tuple[float, ...], list[tuple[str, str]]] = {}
    for category, boxes in categories.items():
        for index, box in enumerate(boxes if isinstance(boxes, list) else [boxes]):
            label = f"room_category {category}[{index}]"
            try:
                x0, y0, x1, y1 = (float(value) * metres for value in box)
                if not (x0 < x1 and y0 < y1 and np.isfinite([x0, y0, x1, y1]).all()):
                    raise ValueError
            except (TypeError, ValueError):
                raise SceneError(
                    f"{path}: {label}: {box!r:.60}; expected x0, y0, x1, y1 of a box"
                ) from None
            found.setdefault((x0, y0, x1, y1), []).append((category.lower(), label))
    return [
        _Box(tuple(n for n, _ in given), " and ".join(t for _, t in given), shapely.box(*box))
        for box, given in found.items()
    ]


def _rooms(
    floor: Polygon, boxes: list[_Box]
) -> tuple[list[tuple[str, RoomKind, Polygon]], list[str]]:
    """Rooms with their names and kinds, and notes on the boxes that name none."""
    cells = [
        part for cell in _split(floor, _doorways(floor)) for part in _cut_by_boxes(cell, boxes)
    ]
    rooms: list[tuple[str, RoomKind, Polygon]] = []
    named: set[str] = set()
    notes: list[str] = []
    for cell in sorted(cells, key=lambda cell: (-cell.area, cell.bounds)):
        box = _best_box(cell, boxes)
        taken = [room[0] for room in rooms]
        if box is None:
            rooms.append((free_name("room", taken), "other", cell))
            continue
        named.add(box.label)
        known = [category for category in CATEGORIES if category in box.names]
        category = known[0] if known else box.names[0]
        kind = CATEGORIES.get(category, "other")
        name = free_name(category, taken)
        rooms.append((name, kind, cell))
        if free_name(category, ()) != category:
            notes.append(renamed(box.label, category, name))
    notes += [f"{box.label}: names no room; left out" for box in boxes if box.label not in named]
    return rooms, notes


def _doorways(floor: Polygon) -> list[shapely.LineString]:
    """Lines across the gaps at wall ends, the shortest first.

    From a wall end, on in the wall's direction, to another corner or to the wall
    opposite, such that the circle about the line is free: the line is the narrowest
    place thereabouts.
    """
    ring = shapely.get_coordinates(shapely.orient_polygons(floor).exterior)[:-1]
    sides = shapely.linestrings(np.stack([ring, np.roll(ring, -1, axis=0)], axis=1))
    corners, ends = _corners(ring)
    lines: list[shapely.LineString] = []
    for a in ends:
        feet = shapely.line_interpolate_point(
            sides, shapely.line_locate_point(sides, shapely.Point(a))
        )
        for others, widest in ((corners, WIDEST), (shapely.get_coordinates(feet), WIDEST_AT_WALL)):
            length = np.hypot(*(others - a).T)
            fits = (length > LEAST_WIDTH) & (length <= widest)
            lines.extend(_longer(a, b) for b in others[fits] if _is_neck(floor, a, b))
    return sorted(lines, key=lambda line: (round(line.length, 6), line.wkt))


def _corners(ring: Floats) -> tuple[Floats, Floats]:
    """Corners of walls in the outline (n, 2) of a floor, and those at the ends of walls.

    At a wall's end the outline turns about it by 180° within the wall's thickness.
    """
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turn = np.degrees(np.arctan2(-cross, (before * after).sum(axis=1)))
    corners, turn = ring[turn > 1.0], turn[turn > 1.0]
    near = np.hypot(*(corners[:, None] - corners[None]).transpose(2, 0, 1)) <= THICKEST
    return corners, corners[(near * turn).sum(axis=1) >= 150.0]


def _is_neck(floor: Polygon, a: Floats, b: Floats) -> bool:
    """Whether a line goes on from a wall's end at ``a``, and the circle about it is free floor."""
    length = float(np.hypot(*(b - a)))
    middle, behind = shapely.Point((a + b) / 2), shapely.Point(a - (b - a) / length * BEHIND)
    clearance = length / 2 - 0.02
    return bool(
        not floor.intersects(behind)
        and floor.contains(middle)
        and floor.exterior.distance(middle) >= clearance
    )


def _longer(a: Floats, b: Floats) -> shapely.LineString:
    """A line that reaches a little into the walls at its ends."""
    along = (b - a) / np.hypot(*(b - a)) * 0.02
    return shapely.LineString([a - along, b + along])


def _split(region: Polygon, lines: list[shapely.LineString]) -> list[Polygon]:
    """Parts of a region between lines; a line that would cut off next to nothing is ignored."""
    parts = [region]
    for line in lines:
        cut: list[Polygon] = []
        for part in parts:
            pieces = polygons(shapely.polygonize([shapely.union_all([part.boundary, line])]))
            pieces = [p for p in pieces if part.intersects(p.representative_point())]
            good = len(pieces) > 1 and min(p.area for p in pieces) >= LEAST_ROOM
            cut.extend(pieces if good else [part])
        parts = cut
    return parts


def _cut_by_boxes(cell: Polygon, boxes: list[_Box]) -> Iterator[Polygon]:
    """A room of several boxes cut along their sides, the smaller boxes first."""
    shares = [float(cell.intersection(box.shape).area / cell.area) for box in boxes]
    several = [box for box, share in zip(boxes, shares, strict=True) if share >= 0.25]
    rest: shapely.Geometry = cell
    if len(several) > 1 and max(shares) < 0.8:
        for box in sorted(several, key=lambda box: float(box.shape.area))[:-1]:
            taken = polygons(rest.intersection(box.shape), LEAST_ROOM)
            left = polygons(rest.difference(box.shape), LEAST_ROOM)
            if taken and left:
                largest = max(taken, key=lambda part: float(part.area))
                rest = rest.difference(largest)
                yield largest
    yield from polygons(rest, smallest=1e-3)


def _best_box(cell: Polygon, boxes: list[_Box]) -> _Box | None:
    """The box that covers most of a room and has least beside it; None if none covers half."""
    fits = [(box, float(cell.intersection(box.shape).area)) for box in boxes]
    fits = [(box, area) for box, area in fits if area > 0.5 * cell.area]
    if not fits:
        return None
    return max(fits, key=lambda fit: fit[1] / float(fit[0].shape.union(cell).area))[0]
