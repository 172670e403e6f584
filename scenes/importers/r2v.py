"""Floor plans of the R2V (raster-to-vector) data set: lines of tab-separated text.

Each line is ``x0 y0 x1 y1 type a b`` in pixels of a drawing, y down, without a
scale. ``wall`` and ``door`` lines follow centre lines; everything else is the box of
a symbol or a word: a room's label or a fixture. What is read:

- Rooms are what the walls enclose; the labels inside say what a room is. Several
  labels in one room (living room and kitchen in one) name one room, the most
  lived-in first.
- Balconies, stairs and pipe shafts (PS) are no rooms for a robot and left out.
- A door to the outside is a window, as most of them are, but for the one nearest to
  a label ``entrance``. Doors to pipe shafts and closets that are left out are closed.
- Walls are 12 cm thick; the data set says nothing of it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from scenes.apartment import Point, RoomKind, Wall
from scenes.errors import SceneError
from scenes.importers import Imported
from scenes.importers.drawing import PlanDrawing, PlanFixture, PlanOpening, PlanRoom
from scenes.importers.plan import PlanOptions
from scenes.importers.plan_file import ask_for_scale, built, check_extent, check_scale
from scenes.importers.reading import read_text

__all__ = ["read_r2v"]

Floats = NDArray[np.float64]

FORMAT = "R2V text, lines of x0 y0 x1 y1 type a b"
KINDS: dict[str, RoomKind] = {
    "living_room": "living_room",
    "kitchen": "kitchen",
    "bedroom": "bedroom",
    "bathroom": "bathroom",
    "restroom": "bathroom",
    "washing_room": "bathroom",
    "corridor": "corridor",
    "entrance": "corridor",
    "closet": "storage",
}
"""Kinds by label; of several labels in one room the first of these names it."""
OUTSIDE = ("balcony", "stairs", "PS")
FIXTURES = {"bathtub": "bath", "toilet": "toilet", "cooking_counter": "kitchen_counter"}
THICKNESS = 0.12
"""Of the walls, m."""
MOST_LINES = 5000
DOOR_WIDTH, DOOR_QUANTILE = 0.75, 0.25
"""At the right scale a quarter of the doors (closets' and windows included) is narrower, m."""
OPEN_AIR = ("balcony", "stairs")
ACROSS, SEEN = 0.4, 0.05
"""How far across a door rooms are looked for, and how much must be seen of one, m."""
WIDEST_DOOR = 1.3
"""Wider ones are no front doors, m."""


@dataclass(frozen=True)
class _Line:
    """One line of the file: its number, its ends (2, 2) with y up, and its type."""

    number: int
    ends: Floats
    type: str

    @property
    def label(self) -> str:
        return f"line {self.number} ({self.type})"

    @property
    def middle(self) -> shapely.Point:
        return shapely.Point(self.ends.mean(axis=0))

    @property
    def box(self) -> Polygon:
        return shapely.box(*self.ends.min(axis=0), *self.ends.max(axis=0))


def read_r2v(
    path: str | Path,
    *,
    scale: float | None = None,
    name: str | None = None,
    start: Point | None = None,
    ceiling_height: float = 2.5,
    furnish: bool = True,
    add_doors: bool = False,
) -> Imported:
    """Read a floor plan of R2V; the module's docstring says how.

    Parameters
    ----------
    path : path
    scale : float
        Metres per pixel.
    name : str, optional
        Of the apartment; the file's stem if absent.
    start, ceiling_height, furnish, add_doors
        `PlanOptions`.

    Raises
    ------
    SceneError
        One line: the file, the line, its value, what would be right. Without a
        scale it says at which a quarter of the doors would be narrower than 0.75 m.
    """
    check_scale(path, scale)
    lines = _lines(path)
    if scale is None:
        doors = [float(np.hypot(*np.diff(d.ends, axis=0)[0])) for d in lines if d.type == "door"]
        raise ask_for_scale(path, doors, DOOR_WIDTH, DOOR_QUANTILE)
    lines = [replace(line, ends=line.ends * scale) for line in lines]
    ends = [line.ends for line in lines if line.type == "wall"]
    if not ends:
        raise SceneError(f"{path}: no wall in it; expected {FORMAT}")
    check_extent(path, list(shapely.linestrings(ends)), scale)
    walls = _walls(ends)
    options = PlanOptions(ceiling_height, furnish=furnish, add_doors=add_doors, start=start)
    return built(path, _drawing(lines, walls), name, options)


def _lines(path: str | Path) -> list[_Line]:
    """The lines of a file, y up, the corner of the walls at the origin."""
    lines = []
    texts = read_text(path, FORMAT).splitlines()
    if len(texts) > MOST_LINES:
        raise SceneError(f"{path}: {len(texts)} lines; expected {FORMAT}, at most {MOST_LINES}")
    for number, text in enumerate(texts, start=1):
        if not text.strip():
            continue
        fields = text.split()
        try:
            ends = np.array(fields[:4], dtype=float).reshape(2, 2)
            kind = fields[4]
            if not np.isfinite(ends).all():
                raise ValueError
        except (ValueError, IndexError):
            raise SceneError(
                f"{path}: line {number}: {text.strip()!r:.60}; expected {FORMAT}"
            ) from None
        lines.append(_Line(number, ends * (1.0, -1.0), kind[:40]))
    walls = [line.ends.min(axis=0) for line in lines if line.type == "wall"]
    corner = np.min(walls or [(0.0, 0.0)], axis=0)
    return [replace(line, ends=line.ends - corner) for line in lines]


def _walls(lines: Iterable[Floats]) -> list[Wall]:
    """Walls along centre lines; upright and level ones that touch in a row become one."""
    rows: dict[tuple[int, float], list[tuple[float, float]]] = {}
    walls = []
    for ends in lines:
        level = [axis for axis in (0, 1) if ends[0, 1 - axis] == ends[1, 1 - axis]]
        if len(level) == 1:
            axis = level[0]
            span = sorted(ends[:, axis].tolist())
            rows.setdefault((axis, float(ends[0, 1 - axis])), []).append((span[0], span[1]))
        elif not level:
            walls.append(_wall(*ends.tolist()))
    for (axis, offset), spans in sorted(rows.items()):
        for low, high in _joined(spans):
            points = [(low, offset), (high, offset)]
            walls.append(_wall(*(point if axis == 0 else point[::-1] for point in points)))
    return walls


def _wall(start: Iterable[float], end: Iterable[float]) -> Wall:
    a, b = (tuple(np.round(list(point), 4).tolist()) for point in (start, end))
    return Wall(start=a, end=b, thickness=THICKNESS)


def _joined(spans: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Spans that touch made one."""
    joined: list[tuple[float, float]] = []
    for low, high in sorted(spans):
        if joined and low <= joined[-1][1] + THICKNESS / 2:
            joined[-1] = (joined[-1][0], max(high, joined[-1][1]))
        else:
            joined.append((low, high))
    return joined


def _drawing(lines: list[_Line], walls: list[Wall]) -> PlanDrawing:
    notes: list[str] = []
    faces = _enclosed(walls)
    rooms = _rooms(lines, faces, notes)
    doors = [line for line in lines if line.type == "door"]
    indoors = _indoors(lines, rooms, faces)
    outer = [door for door in doors if _leads_out(door, indoors)]
    entrances = [line.middle for line in lines if line.type == "entrance"]
    front = {_front_door(spot, outer).number for spot in entrances if outer}
    glazed = {door.number for door in outer} - front
    known = {"wall", "door", *KINDS, *OUTSIDE, *FIXTURES, "washing_basin"}
    notes += [f"{x.label}: not used; left out" for x in lines if x.type not in known]
    return PlanDrawing(
        tuple(rooms),
        tuple(walls),
        openings=tuple(_opening(door, door.number in glazed) for door in doors),
        fixtures=tuple(_fixtures(lines, rooms)),
        notes=tuple(notes),
    )


def _indoors(lines: list[_Line], rooms: list[PlanRoom], faces: list[Polygon]) -> list[Polygon]:
    """The faces that are no balcony and no stairs: rooms and pipe shafts."""
    shapes = [room.shape for room in rooms]
    air = shapely.union_all([line.middle for line in lines if line.type in OPEN_AIR])
    return [*shapes, *(face for face in faces if face not in shapes and not face.intersects(air))]


def _leads_out(door: _Line, indoors: list[Polygon]) -> bool:
    """Whether a door is between a room and the outside."""
    start, end = door.ends
    length = float(np.hypot(*(end - start)))
    if length == 0.0:
        return False
    across = np.array([start[1] - end[1], end[0] - start[0]]) / length * ACROSS
    middle = (start + end) / 2
    line = shapely.LineString([middle - across, middle + across])
    return sum(bool(line.intersection(face).length > SEEN) for face in indoors) == 1


def _front_door(spot: shapely.Point, doors: list[_Line]) -> _Line:
    """The outer door nearest to a label ``entrance``, one of a door's width if there is any."""
    narrow = [door for door in doors if np.abs(np.diff(door.ends, axis=0)).max() < WIDEST_DOOR]
    return min(narrow or doors, key=lambda door: float(spot.distance(door.middle)))


def _enclosed(walls: list[Wall]) -> list[Polygon]:
    """What the walls enclose; ends that miss each other by less than a wall's half meet."""
    bands = [
        shapely.LineString([wall.start, wall.end]).buffer(
            THICKNESS / 2, cap_style="square", join_style="mitre"
        )
        for wall in walls
    ]
    mass = shapely.union_all(bands)
    faces = [Polygon(ring) for part in shapely.get_parts(mass) for ring in part.interiors]
    return [face for face in faces if face.buffer(-THICKNESS / 2).area > 0.0]


def _rooms(lines: list[_Line], faces: list[Polygon], notes: list[str]) -> list[PlanRoom]:
    """Rooms of the faces, named by the labels in them."""
    rooms = []
    order = [*KINDS, *OUTSIDE]
    used: set[int] = set()
    for face in sorted(faces, key=lambda face: (-face.area, face.bounds)):
        inside = [x for x in lines if x.type in order and face.intersects(x.middle)]
        inside.sort(key=lambda line: (order.index(line.type), line.number))
        used.update(line.number for line in inside)
        if not inside:
            rooms.append(
                PlanRoom(f"an unlabelled room of {face.area:.1f} m²", "room", "other", face)
            )
            continue
        first, *others = inside
        if first.type in OUTSIDE:
            notes.append(f"{first.label}: no room for a robot; left out")
            continue
        notes += [
            f"{x.label}: in one room with {first.label}" for x in others if x.type != first.type
        ]
        rooms.append(PlanRoom(first.label, first.type, KINDS[first.type], face))
    notes += [
        f"{x.label}: in no room that walls enclose; left out"
        for x in lines
        if x.type in order and x.number not in used
    ]
    return rooms


def _opening(door: _Line, glazed: bool) -> PlanOpening:
    start, end = (tuple(point) for point in np.round(door.ends, 4).tolist())
    return PlanOpening(door.label, "door", start, end, "window" if glazed else "closed")


def _fixtures(lines: list[_Line], rooms: list[PlanRoom]) -> Iterable[PlanFixture]:
    for line in lines:
        if line.type in FIXTURES:
            yield PlanFixture(line.label, FIXTURES[line.type], line.box)
        elif line.type == "washing_basin":
            # The data set draws kitchen sinks with the same symbol.
            home = next((r for r in rooms if r.shape.intersects(line.middle)), None)
            bath = home is None or home.kind not in ("kitchen", "living_room")
            yield PlanFixture(line.label, "basin" if bath else "kitchen_sink", line.box)
