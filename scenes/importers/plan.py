"""From a drawn floor plan to an apartment with walls, doorways and furniture.

One builder for all plan formats. Decisions, all told in the notes where they
touch an element:

- Of two rooms that overlap the smaller keeps the shared floor; walls take theirs
  from the rooms.
- Rooms that touch (up to 6 cm apart) with no wall between are open to each other
  and get a border. In a drawing that has no walls at all the rooms meet in the
  middle of walls that nobody drew.
- Sides of rooms that nothing closes are walled up.
- A door between two rooms becomes a passage with a lintel; a door to the outside
  a closed one. Windows need an outside.
- A room that a robot of 15 cm cannot reach is left out (what was its floor is then
  outside), or gets a door to a neighbour where that is asked for.
- A drawing without lamps, and without a word on light, gets ceiling lamps.
- An opening, a lamp or a fixture that the checks of `scenes.checks` refuse is left out.
"""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from pydantic import ValidationError
from shapely import Polygon

from scenes.apartment import Apartment, Block, Frame, Point, Room, Start
from scenes.checks import check, check_blocks, check_lamps
from scenes.errors import SceneError
from scenes.faults import value_fault
from scenes.importers import Imported
from scenes.importers.drawing import (
    PlanDrawing,
    PlanOpening,
    PlanRoom,
    free_name,
    renamed,
)
from scenes.importers.plan_fixtures import furnished, reached
from scenes.importers.plan_openings import LEAST_WIDTH, Openings, place_openings
from scenes.importers.plan_rooms import (
    borders_between,
    closing_masonry,
    corners,
    fit_rooms,
    solid_shapes,
    wall_mass,
    with_islands,
)
from scenes.importers.room_lamps import with_room_lamps
from scenes.passages import ROBOT_RADIUS, free_region
from scenes.solids import polygons
from scenes.wall_checks import check_openings, check_shared_openings

__all__ = ["PlanOptions", "build_apartment"]

FLOORS = {
    "bathroom": ("tiles_white", "tiles_white"),
    "kitchen": ("tiles_grey", "white_plaster"),
    "storage": ("laminate", "white_plaster"),
    "bedroom": ("carpet_beige", "cream_plaster"),
}
"""Floor and walls of a room that does not say them, by its kind."""
DOOR = 0.8
"""Width of a door that is added, m."""
NARROWER, NARROWINGS = 0.05, 4
"""By how much, m, and how often openings become narrower so that they do not overlap."""
_FAULT = re.compile(r"(passages|windows|furniture|lamps)\[(\d+)\][^:]*: (.*)")
_OPENING = re.compile(r"(passages|windows)\[(\d+)\]")
MOST_ROOMS = 300
MOST_RENAMED = 3
"""Notes on names; of more one tells for all."""
OUTERMOST = 500.0
"""A home has no point further than this from the origin, m."""


@dataclass(frozen=True)
class PlanOptions:
    """What a drawing does not say.

    Attributes
    ----------
    ceiling_height, lintel_height : float
        m; a ``lintel_height`` of None: doorways open up to the ceiling.
    wall_thickness : float
        Of walls that are not drawn, m.
    frames : bool
        Whether doorways have frames.
    furnish : bool
        Whether fixtures become pieces.
    add_doors : bool
        Whether a room without a door gets one.
    start : tuple of float, optional
        Where the robot starts, m; the widest spot of the largest room if absent.
    """

    ceiling_height: float = 2.5
    lintel_height: float | None = 2.0
    wall_thickness: float = 0.12
    frames: bool = True
    furnish: bool = True
    add_doors: bool = False
    start: Point | None = None


def build_apartment(
    drawing: PlanDrawing, *, name: str, options: PlanOptions | None = None
) -> Imported:
    """An apartment of a drawing, and what of it could not be used.

    Raises
    ------
    SceneError
        If a room crosses itself, there are too many, nothing is left that a robot can
        live in, or the drawing is so far off that the result is no possible apartment.
    """
    options = options or PlanOptions()
    if len(drawing.rooms) > MOST_ROOMS:
        raise SceneError(f"{len(drawing.rooms)} rooms; expected a home of at most {MOST_ROOMS}")
    drawing, notes = _named(drawing)
    drawing = replace(drawing, wall_shapes=solid_shapes(drawing.wall_shapes))
    fitted = fit_rooms(drawing, options.wall_thickness)
    if not fitted.rooms:
        raise SceneError("no room in it; expected at least one polygon of a room")
    _check_extent(fitted.rooms)
    drawing = with_islands(drawing, fitted.islands)
    shell, openings, left_out = _reachable(drawing, fitted.rooms, name, options)
    notes = [*drawing.notes, *notes, *fitted.notes, *left_out]
    drawn = drawing.fields.get("start")
    if drawn and not options.start and drawn.position != shell.start.position:
        x, y = shell.start.position
        notes.append(f"start: its place is not free; moved to ({x:g}, {y:g})")
    apartment, more = _finished(shell, openings, drawing, options)
    return Imported(apartment, tuple(dict.fromkeys([*notes, *more])))


def _finished(
    apartment: Apartment, openings: Openings, drawing: PlanDrawing, options: PlanOptions
) -> tuple[Apartment, list[str]]:
    """The apartment with furniture and light, without what the checks refuse, and notes."""
    labels = {"passages": openings.passage_labels, "windows": openings.window_labels}
    notes: list[str] = []
    if options.furnish and drawing.fixtures:
        free = free_region(apartment, ROBOT_RADIUS)
        pieces, labels["furniture"], notes = furnished(apartment, drawing.fixtures, free)
        apartment = apartment.model_copy(update={"furniture": tuple(pieces)})
    if not drawing.fields.get("lamps") and "lighting" not in drawing.fields:
        apartment = with_room_lamps(apartment)
    while problems := list(check(apartment)):
        apartment, note = _without(apartment, labels, problems[0])
        notes.append(note)
    return apartment, notes


def _check_extent(rooms: Sequence[PlanRoom]) -> None:
    bounds = shapely.total_bounds([room.shape for room in rooms])
    if np.abs(bounds).max() > OUTERMOST:
        raise SceneError(
            f"coordinates up to {np.abs(bounds).max():.4g} m; expected a home within "
            f"{OUTERMOST:g} m of the origin"
        )


def _reachable(
    drawing: PlanDrawing, rooms: list[PlanRoom], name: str, options: PlanOptions
) -> tuple[Apartment, Openings, list[str]]:
    """The unfurnished apartment of the rooms that the robot reaches, and notes on the others."""
    notes: list[str] = []
    added: list[PlanOpening] = []
    drawn = list(drawing.openings)
    while True:
        shell, openings = _shell(drawing, rooms, [*drawn, *added], name, options)
        notes.extend(openings.notes)
        free = polygons(free_region(shell, ROBOT_RADIUS))
        start = _start(rooms, free, drawing, options)
        shell = shell.model_copy(
            update={"start": shell.start.model_copy(update={"position": start})}
        )
        inside = reached(
            shapely.multipolygons(free), shapely.Point(start), [room.shape for room in rooms]
        )
        if all(inside):
            return shell, openings, notes
        door = _missing_door(rooms, inside) if options.add_doors else None
        if door is not None and door.label not in {other.label for other in added}:
            added.append(door)
            notes.append(f"{door.label}: added")
            continue
        near = [room for room, is_in in zip(rooms, inside, strict=True) if is_in]
        notes.extend(
            f"{room.label}: no open way for a robot of {ROBOT_RADIUS:g} m radius to "
            f"{room.name!r} ({room.shape.area:.3g} m²); left out{_remedy(near, room, options)}"
            for room, is_in in zip(rooms, inside, strict=True)
            if not is_in
        )
        rooms = near
        # Doors to rooms that are left out are no windows.
        joining = set(openings.passage_labels)
        drawn = [replace(o, outside="closed") if o.label in joining else o for o in drawn]


def _shell(
    drawing: PlanDrawing,
    rooms: Sequence[PlanRoom],
    drawn: Sequence[PlanOpening],
    name: str,
    options: PlanOptions,
) -> tuple[Apartment, Openings]:
    """Rooms, walls and openings."""
    borders = borders_between(rooms, drawing.borders)
    masonry = closing_masonry(drawing, rooms, borders, options.wall_thickness)
    openings = place_openings(
        drawn,
        rooms,
        drawing.walls,
        shapely.union_all([wall_mass(drawing), *masonry]),
        lintel_height=options.lintel_height,
        ceiling_height=options.ceiling_height,
        frame=Frame() if options.frames else None,
    )
    blocks = tuple(
        Block(
            polygon=corners(shape.exterior), holes=tuple(corners(ring) for ring in shape.interiors)
        )
        for shape in masonry
    )
    fields = {"start": Start(position=(0.0, 0.0)), **drawing.fields}
    apartment = Apartment(
        name=name,
        rooms=tuple(_room(room, options.ceiling_height) for room in rooms),
        # Walls that carry openings come first: of two equally near the first is taken.
        walls=(*openings.carriers, *drawing.walls),
        blocks=(*drawing.blocks, *blocks),
        borders=borders,
        passages=tuple(openings.passages),
        windows=tuple(openings.windows),
        **fields,
    )
    if problem := next(check_blocks(apartment), None):
        raise SceneError(problem)
    return _possible(apartment, openings)


def _possible(apartment: Apartment, openings: Openings) -> tuple[Apartment, Openings]:
    """Without the openings and lamps that the checks refuse; openings that overlap narrowed."""
    labels = {
        "passages": openings.passage_labels,
        "windows": openings.window_labels,
        "lamps": [f"lamp {index + 1}" for index in range(len(apartment.lamps))],
    }
    for part in (check_shared_openings, check_openings, check_lamps):
        tried: Counter[str] = Counter()
        while problem := next(part(apartment), None):
            fault = _FAULT.match(problem)
            assert fault is not None
            field, index = fault[1], int(fault[2])
            label = labels[field][index]
            tried[label] += 1
            if part is check_shared_openings and tried[label] <= NARROWINGS:
                apartment = _narrowed(apartment, field, index)
                if tried[label] == 1:
                    openings.notes.append(f"{label}: narrowed, for it overlaps another opening")
            else:
                apartment, note = _without(apartment, labels, problem)
                openings.notes.append(note)
    return apartment, openings


def _narrowed(apartment: Apartment, field: str, index: int) -> Apartment:
    """With one opening a little narrower."""
    items = list(getattr(apartment, field))
    width = max(items[index].width - NARROWER, LEAST_WIDTH)
    items[index] = items[index].model_copy(update={"width": round(width, 6)})
    return apartment.model_copy(update={field: tuple(items)})


def _without(
    apartment: Apartment, labels: dict[str, list[str]], problem: str
) -> tuple[Apartment, str]:
    """The apartment without the element that a check refuses, and a note.

    Raises
    ------
    SceneError
        If it is no opening, lamp or piece.
    """
    fault = _FAULT.match(problem)
    if fault is None:
        raise SceneError(problem)
    field, index = fault[1], int(fault[2])
    items = list(getattr(apartment, field))
    del items[index]
    # What else the problem names is called as in the file, too.
    reason = _OPENING.sub(lambda found: labels[found[1]][int(found[2])], fault[3])
    note = f"{labels[field].pop(index)}: {reason}; left out"
    return apartment.model_copy(update={field: tuple(items)}), note


def _room(room: PlanRoom, ceiling_height: float) -> Room:
    floor, walls = FLOORS.get(room.kind, ("parquet", "white_plaster"))
    fields = {"ceiling_height": ceiling_height, "floor": floor, "walls": walls, **room.fields}
    try:
        return Room(name=room.name, kind=room.kind, polygon=corners(room.shape.exterior), **fields)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        where = ".".join(str(item) for item in fault["loc"])
        message = f"{room.label}: {where}: {fault['input']!r:.60}; {value_fault(fault)}"
        raise SceneError(message) from None


def _start(
    rooms: Sequence[PlanRoom], free: Sequence[Polygon], drawing: PlanDrawing, options: PlanOptions
) -> Point:
    """Where the robot starts: as asked for, as drawn if that is free, else where it reaches most.

    Raises
    ------
    SceneError
        If the place asked for is not free, or nothing is.
    """
    if not free:
        raise SceneError(
            f"no room has free floor for a robot of {ROBOT_RADIUS:g} m radius; expected a plan "
            f"in metres"
        )
    drawn = drawing.fields.get("start")
    wanted: Point | None = options.start or (drawn and drawn.position)
    if wanted and any(part.covers(shapely.Point(wanted)) for part in free):
        return wanted
    if options.start:
        x, y = options.start
        raise SceneError(
            f"start ({x:g}, {y:g}): no free floor for a robot of "
            f"{ROBOT_RADIUS:g} m radius; expected a free place in a room"
        )
    home = max(free, key=lambda part: part.area)
    largest = max(rooms, key=lambda room: float(home.intersection(room.shape).area))
    floor = max(
        polygons(home.intersection(largest.shape), smallest=0.0), key=lambda part: part.area
    )
    x, y = shapely.get_coordinates(shapely.maximum_inscribed_circle(floor, tolerance=0.01))[0]
    return round(float(x), 3), round(float(y), 3)


def _missing_door(rooms: Sequence[PlanRoom], inside: Sequence[bool]) -> PlanOpening | None:
    """A door from a room that is reached to one that is not, where they share most wall."""
    best, length = None, DOOR + 0.2
    near = shapely.union_all(
        [room.shape for room, is_in in zip(rooms, inside, strict=True) if is_in]
    ).buffer(0.45, cap_style="flat", join_style="mitre")
    for room, is_in in zip(rooms, inside, strict=True):
        ring = shapely.get_coordinates(room.shape.exterior)
        for a, b in itertools.pairwise(ring):
            if is_in:
                break
            for part in shapely.get_parts(shapely.LineString([a, b]).intersection(near)):
                if part.length > length:
                    best, length = (room, part), part.length
    if best is None:
        return None
    room, line = best
    half, along = line.length / 2, DOOR / 2
    start, end = (tuple(line.interpolate(half + s * along).coords[0]) for s in (-1, 1))
    return PlanOpening(f"{room.label}: a door to {room.name!r}", "door", start, end)


def _remedy(near: Sequence[PlanRoom], room: PlanRoom, options: PlanOptions) -> str:
    """What would keep a room that cannot be reached: a door, where one can be added."""
    tried = options.add_doors or _missing_door([*near, room], [True] * len(near) + [False]) is None
    return "" if tried else " (--add-doors would open a door to it)"


def _named(drawing: PlanDrawing) -> tuple[PlanDrawing, list[str]]:
    """The drawing with names for its rooms that a file allows, each given once; notes on others."""
    taken: list[str] = []
    rooms, notes = [], []
    for room in drawing.rooms:
        taken.append(free_name(room.name, taken))
        rooms.append(replace(room, name=taken[-1]))
        if free_name(room.name, ()) != room.name:
            notes.append(renamed(room.label, room.name, taken[-1]))
    if len(notes) > MOST_RENAMED:
        notes = [f"{notes[0]}; {len(notes) - 1} more likewise"]
    return replace(drawing, rooms=tuple(rooms)), notes
