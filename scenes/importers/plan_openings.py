"""Doors and windows of a drawing as openings in walls.

A drawn opening is a line, seldom just on a wall. Across its middle the floor of
the rooms shows where the wall is: between the faces of the two rooms (a
passage) or beyond the face of one (a window, a closed door). An opening that
lies in a drawn wall stays in it; for any other a short wall of just the depth
found carries it.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from scenes.apartment import Frame, Passage, Wall, Window
from scenes.importers.drawing import PlanOpening, PlanRoom
from scenes.openings import LINING
from scenes.solids import GAP
from scenes.wall_checks import is_thick

__all__ = ["LEAST_WIDTH", "Openings", "place_openings"]

Floats = NDArray[np.float64]

REACH = 1.0
"""How far across an opening rooms are looked for, m."""
THINNEST = 0.005
"""Floors nearer to one another have no wall between, m."""
DEEPEST = 0.8
"""The thickest wall with an opening, m."""
OFF = 0.35
"""How far beside its wall an opening may be drawn, m."""
LEAST_WIDTH = 0.35
"""The narrowest door that is worth an open passage, m."""
LEAST_WINDOW = 0.25
CARRIED = 0.005
"""How far a wall that carries an opening goes on beside it, m."""
PARALLEL = np.cos(np.radians(8.0))


@dataclass
class Openings:
    """What became of the openings: they, the walls that carry them, and notes.

    ``passage_labels`` and ``window_labels`` say which drawn opening each of them was.
    """

    passages: list[Passage]
    windows: list[Window]
    carriers: list[Wall]
    passage_labels: list[str]
    window_labels: list[str]
    notes: list[str]


@dataclass(frozen=True)
class _Site:
    """A gap between floors across an opening: its middle, directions, depth, rooms.

    ``low`` and ``high`` are indices of rooms on the -across and +across side.
    """

    centre: Floats
    along: Floats
    across: Floats
    depth: float
    low: int | None
    high: int | None


@dataclass(frozen=True)
class _Plan:
    """What openings are placed in; ``lintel_height`` and ``frame`` are the doors' defaults."""

    rooms: Sequence[PlanRoom]
    walls: Sequence[Wall]
    solid: shapely.Geometry
    lintel_height: float | None
    ceiling_height: float
    frame: Frame | None

    def names(self, site: _Site) -> list[str]:
        """Names of the rooms at an opening."""
        return [self.rooms[i].name for i in (site.low, site.high) if i is not None]


def place_openings(
    openings: Sequence[PlanOpening],
    rooms: Sequence[PlanRoom],
    walls: Sequence[Wall],
    solid: shapely.Geometry,
    *,
    lintel_height: float | None,
    ceiling_height: float,
    frame: Frame | None,
) -> Openings:
    """Passages and windows for the openings of a drawing.

    Parameters
    ----------
    solid : geometry
        Footprint of all walls, openings filled, m.
    lintel_height : float or None
        Of doors that do not say theirs, m.
    frame : Frame or None
        Of doors that do not say theirs.
    """
    plan = _Plan(rooms, walls, solid, lintel_height, ceiling_height, frame)
    found = Openings([], [], [], [], [], [])
    for opening in openings:
        if problem := _place(found, opening, plan):
            found.notes.append(f"{opening.label}: {problem}; left out")
    return found


def _place(found: Openings, opening: PlanOpening, plan: _Plan) -> str | None:
    """Add one opening, or say why not."""
    if _length(opening) < 1e-3:
        return "has no length"
    site = _site(opening, _direction(opening, plan.rooms, plan.walls), plan.rooms, plan.solid)
    if isinstance(site, str):
        return site
    inner = plan.names(site)
    if opening.kind == "door" and len(inner) == 2:
        return _add_passage(found, opening, site, plan)
    if len(inner) == 2:
        return f"lies between two rooms, {inner[0]!r} and {inner[1]!r}; expected an outer wall"
    if opening.kind == "window" or opening.outside == "window":
        return _add_window(found, opening, site, plan)
    shut = replace(opening, fields={**opening.fields, "closed": True})
    problem = _add_passage(found, shut, site, plan)
    if problem is None and not opening.fields.get("closed"):
        found.notes.append(f"{opening.label}: joins {inner[0]!r} and no other room; made closed")
    return problem


def _middle(opening: PlanOpening) -> Floats:
    middle: Floats = (np.array(opening.start) + np.array(opening.end)) / 2.0
    return middle


def _length(opening: PlanOpening) -> float:
    return float(np.hypot(*np.subtract(opening.end, opening.start)))


def _direction(opening: PlanOpening, rooms: Sequence[PlanRoom], walls: Sequence[Wall]) -> Floats:
    """Unit vector along the wall of an opening: that of a wall or room side nearly parallel."""
    drawn: Floats = np.subtract(opening.end, opening.start) / _length(opening)
    sides = [shapely.get_coordinates(room.shape.exterior) for room in rooms]
    lines = [np.array([(wall.start, wall.end) for wall in walls]).reshape(-1, 2, 2)]
    lines += [np.stack([ring[:-1], ring[1:]], axis=1) for ring in sides]
    every = np.concatenate(lines)
    vectors = every[:, 1] - every[:, 0]
    length = np.hypot(*vectors.T)
    every, vectors = every[length > 0.05], vectors[length > 0.05] / length[length > 0.05, None]
    near = np.abs(vectors @ drawn) > PARALLEL
    if not near.any():
        return drawn
    distance = shapely.distance(shapely.linestrings(every[near]), shapely.Point(_middle(opening)))
    if distance.min() > OFF:
        return drawn
    found: Floats = vectors[near][int(np.argmin(distance))]
    return found if found @ drawn > 0 else -found


def _site(
    opening: PlanOpening, along: Floats, rooms: Sequence[PlanRoom], solid: shapely.Geometry
) -> _Site | str:
    """Where the wall of an opening is, or why there is none."""
    across = np.array([-along[1], along[0]])
    middle, reason = _middle(opening), "no room within reach"
    for share in (0.0, -0.25, 0.25):
        point = middle + share * _length(opening) * along
        spans = _spans(point, across, rooms)
        gap = _gap(spans)
        if gap is None:
            continue
        low, high, below, above = gap
        if below is not None and above is not None:
            if high - low < THINNEST:
                reason = "no wall there, the rooms are open to one another"
                continue
        else:
            depth = _outer_depth(point, across, (low, high), below is None, solid)
            if depth is None:
                reason = "no outside within reach behind its wall"
                continue
            low, high = (high - depth, high) if below is None else (low, low + depth)
        centre = middle + across * (low + high) / 2.0
        return _Site(centre, along, across, high - low, below, above)
    return reason


def _spans(
    point: Floats, across: Floats, rooms: Sequence[PlanRoom]
) -> list[tuple[float, float, int]]:
    """Where the line across an opening runs over the floor of rooms, in its direction."""
    line = shapely.LineString([point - REACH * across, point + REACH * across])
    spans = []
    for index, room in enumerate(rooms):
        for part in shapely.get_parts(line.intersection(room.shape)):
            if part.length > 0.02:
                ends = (shapely.get_coordinates(part) - point) @ across
                spans.append((float(ends.min()), float(ends.max()), index))
    return sorted(spans)


def _gap(
    spans: list[tuple[float, float, int]],
) -> tuple[float, float, int | None, int | None] | None:
    """The gap between floors nearest to 0: its ends and the rooms below and above."""
    if not spans:
        return None
    gaps: list[tuple[float, float, int | None, int | None]] = [
        (-np.inf, spans[0][0], None, spans[0][2]),
        (spans[-1][1], np.inf, spans[-1][2], None),
    ]
    for (_, end, below), (start, _, above) in itertools.pairwise(spans):
        if start - end > DEEPEST:
            gaps += [(end, np.inf, below, None), (-np.inf, start, None, above)]
        else:
            gaps.append((end, start, below, above))
    if spans[0][0] <= -REACH + 1e-6:
        gaps = gaps[1:]
    if spans[-1][1] >= REACH - 1e-6:
        gaps = [gap for gap in gaps if gap[0] != spans[-1][1]]

    def off(gap: tuple[float, float, int | None, int | None]) -> float:
        # Of an outer wall only the face is known: the opening is near to it.
        if gap[2] is None:
            return abs(gap[1] - 0.1)
        if gap[3] is None:
            return abs(gap[0] + 0.1)
        return max(gap[0], -gap[1], 0.0)

    best = min(gaps, key=off, default=None)
    return best if best is not None and off(best) <= OFF else None


def _outer_depth(
    point: Floats,
    across: Floats,
    face: tuple[float, float],
    downwards: bool,
    solid: shapely.Geometry,
) -> float | None:
    """Thickness of the wall behind the face of a room, m; None if it has no other side."""
    start, sign = (face[1], -1.0) if downwards else (face[0], 1.0)
    first = point + across * start
    line = shapely.LineString([first, first + sign * across * 2.0 * DEEPEST])
    for part in shapely.get_parts(line.intersection(solid)):
        if part.geom_type == "LineString" and part.distance(shapely.Point(first)) < GAP:
            ends = sign * ((shapely.get_coordinates(part) - first) @ across)
            return float(ends.max()) if 0.02 < ends.max() <= DEEPEST else None
    return None


def _free_stretch(
    site: _Site, rooms: Sequence[PlanRoom], length: float, middle: Floats, margin: float
) -> tuple[float, float]:
    """What of an opening all its rooms see, through a wall as thick as in its middle.

    From, to along the wall about the site's centre. The wall goes on for ``margin`` m.
    """
    spot, reach = shapely.Point(middle), length + 2.0 * (DEEPEST + margin)
    near = [room.shape for room in rooms if room.shape.dwithin(spot, reach)]
    shift = float((middle - site.centre) @ site.along)
    low, high = shift - length / 2, shift + length / 2
    wall = shapely.box(-100.0, -100.0, 100.0, 100.0).difference(
        shapely.union_all([_local(shape, site) for shape in near])
    )
    for side, index in ((-1.0, site.low), (1.0, site.high)):
        if index is None:
            continue
        before = side * (site.depth / 2 + GAP + 0.015)
        low, high = _longest(_local(rooms[index].shape, site), before, low, high)
        within = side * max(site.depth / 2 - 0.015, 0.0)
        low, high = _longest(wall, within, low - margin, high + margin)
        low, high = low + margin, high - margin
    return low, high


def _local(shape: shapely.Geometry, site: _Site) -> shapely.Geometry:
    """A shape in the frame of an opening, (along, across)."""
    axes = np.array([site.along, site.across])
    return shapely.transform(shape, lambda points: (points - site.centre) @ axes.T)


def _longest(
    region: shapely.Geometry, offset: float, low: float, high: float
) -> tuple[float, float]:
    """The longest part in a region of the line along an opening at an offset across it."""
    if high <= low:
        return 0.0, 0.0
    seen = shapely.LineString([(low, offset), (high, offset)]).intersection(region)
    parts = [part for part in shapely.get_parts(seen) if part.length > 0.0]
    if not parts:
        return 0.0, 0.0
    x0, _, x1, _ = max(parts, key=lambda part: float(part.length)).bounds
    return float(x0), float(x1)


def _fitted(
    found: Openings, opening: PlanOpening, site: _Site, plan: _Plan, lining: float
) -> tuple[tuple[float, float], float] | str:
    """Position and width of an opening in a wall that carries it, or why it does not fit."""
    length = _length(opening)
    margin = lining + CARRIED
    low, high = _free_stretch(site, plan.rooms, length, _middle(opening), margin)
    least = LEAST_WIDTH if opening.kind == "door" else LEAST_WINDOW
    width = length if high - low > length - 1e-4 else high - low - 2e-3
    names = " and ".join(repr(name) for name in plan.names(site))
    if width < min(least, length - 1e-3):
        return f"only {max(width, 0.0):.2g} m of its {length:.2g} m are before {names}"
    if width < length - 0.05:
        found.notes.append(
            f"{opening.label}: {length:.2f} m wide, narrowed to the {width:.2f} m before {names}"
        )
    centre = site.centre + (low + high) / 2 * site.along
    wall = _own_wall(plan.walls, centre, width / 2 + lining, site)
    if wall is None:
        half = (width / 2 + margin) * site.along
        start, end = (tuple(np.round(centre + side * half, 6).tolist()) for side in (-1.0, 1.0))
        wall = Wall(start=start, end=end, thickness=round(site.depth, 6))
        band = shapely.LineString([start, end]).buffer(site.depth / 2, cap_style="flat")
        if any(
            band.intersects(room.shape) and is_thick(band.intersection(room.shape))
            for room in plan.rooms
        ):
            return "lies askew in its wall"
        found.carriers.append(wall)
    line = shapely.LineString([wall.start, wall.end])
    on_line = line.interpolate(line.project(shapely.Point(centre)))
    return (round(on_line.x, 6), round(on_line.y, 6)), round(width, 6)


def _own_wall(walls: Sequence[Wall], centre: Floats, half: float, site: _Site) -> Wall | None:
    """The drawn wall that holds the whole opening, if there is one."""
    for wall in walls:
        start, end = np.array(wall.start), np.array(wall.end)
        along = (end - start) / np.hypot(*(end - start))
        ends = sorted(float((p - centre) @ along) for p in (start, end))
        beside = abs(float((start - centre) @ np.array([-along[1], along[0]])))
        if (
            abs(along @ site.along) > 0.9999
            and beside <= GAP
            and abs(wall.thickness - site.depth) <= 2 * GAP
            and ends[0] <= -half
            and half <= ends[1]
        ):
            return wall
    return None


def _add_passage(found: Openings, opening: PlanOpening, site: _Site, plan: _Plan) -> str | None:
    fields = {"lintel_height": plan.lintel_height, "frame": plan.frame, **opening.fields}
    lining = LINING if fields["frame"] is not None else 0.0
    fitted = _fitted(found, opening, site, plan, lining)
    if isinstance(fitted, str):
        return fitted
    found.passages.append(Passage(position=fitted[0], width=fitted[1], **fields))
    found.passage_labels.append(opening.label)
    return None


def _add_window(found: Openings, opening: PlanOpening, site: _Site, plan: _Plan) -> str | None:
    fields = dict(opening.fields) if opening.kind == "window" else {}
    fitted = _fitted(found, opening, site, plan, 0.0)
    if isinstance(fitted, str):
        return fitted
    fields.setdefault("head_height", min(2.1, plan.ceiling_height))
    found.windows.append(Window(position=fitted[0], width=fitted[1], **fields))
    found.window_labels.append(opening.label)
    return None
