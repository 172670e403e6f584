"""Random apartments: plan, openings, furniture, lamps and surfaces from one seed.

The plan comes from `scenes.floorplan` (a slice-and-dice treemap around a hub,
after Marson and Musse 2010), furniture from `scenes.furnishing`, surfaces and
light from `scenes.palettes`. A draw that fails `scenes.checks.check` or leaves
a room that the robot cannot reach is thrown away and drawn again from the next
sub-seed, so that a seed always gives the same apartment.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from shapely import Polygon

from scenes.apartment import Apartment, Lamp, Passage, Room, RoomKind, Start, Wall, Window
from scenes.checks import check
from scenes.errors import SceneError
from scenes.floorplan import INNER, OUTER, Door, FloorPlan, draw_plan
from scenes.furnishing import Site, furnish
from scenes.palettes import Contrast, Palette, Source, draw_lighting, draw_palette
from scenes.passages import ROBOT_RADIUS, free_region

__all__ = ["generate_apartment"]

ATTEMPTS = 1000
MAX_ROOMS = 12
AREA_PER_ROOM = (5.0, 30.0)
"""Clear floor area per room that may be asked for, m²; below 9 not every plan is found."""
LEAST_DRIVEN = 0.25
"""Floor that the robot's centre must have in every room, m²."""


def generate_apartment(
    seed: int,
    *,
    rooms: int = 4,
    area: float = 50.0,
    contrast: Contrast = "medium",
    lighting: Source = "exterior",
) -> Apartment:
    """Draw a furnished apartment in which a robot reaches every room.

    Parameters
    ----------
    seed : int
        The same values and seed give the same apartment.
    rooms : int
        Number of rooms, 1 to 12, the corridor included.
    area : float
        Clear floor area of all rooms together, m², met within 2 %.
    contrast : {"low", "medium", "high"}
        How far door frames stand out from the walls (Table 8).
    lighting : {"interior", "exterior", "mixed"}
        Lamps, sun and sky, or both (Table 8).

    Returns
    -------
    Apartment

    Raises
    ------
    SceneError
        If a value is outside its range, or no valid apartment was found.
    """
    _require(seed, rooms, area, contrast, lighting)
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([seed, attempt])
        plan = draw_plan(rng, rooms, area)
        if plan is None:
            continue
        apartment = _assemble(rng, plan, f"home-{seed}", contrast, lighting)
        if apartment is not None and not any(check(apartment)) and _all_driven(apartment):
            return apartment
    raise SceneError(
        f"rooms, area: no floor plan of {rooms} rooms on {area:g} m² found for seed {seed}; "
        f"expected another seed or about {12 * rooms} m²"
    )


def _require(seed: int, rooms: int, area: float, contrast: str, lighting: str) -> None:
    """Refuse values outside their ranges.

    Raises
    ------
    SceneError
        One line: the field, its value and what would be right.
    """
    for name, value, low, high in (("seed", seed, 0, 2**63 - 1), ("rooms", rooms, 1, MAX_ROOMS)):
        whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
        if not whole or not low <= value <= high:
            raise SceneError(f"{name}: {value!r}; expected a whole number from {low} to {high}")
    least, most = AREA_PER_ROOM[0] * rooms, AREA_PER_ROOM[1] * rooms
    if not isinstance(area, int | float) or isinstance(area, bool) or not least <= area <= most:
        raise SceneError(f"area: {area!r}; expected {least:g} to {most:g} m² for rooms: {rooms}")
    if contrast not in ("low", "medium", "high"):
        raise SceneError(f"contrast: {contrast!r}; expected low, medium or high")
    if lighting not in ("interior", "exterior", "mixed"):
        raise SceneError(f"lighting: {lighting!r}; expected interior, exterior or mixed")


def _assemble(
    rng: np.random.Generator, plan: FloorPlan, name: str, contrast: Contrast, lighting: Source
) -> Apartment | None:
    """Furnish and light a plan; None if the robot has no place to start."""
    kinds = tuple(cell.kind for cell in plan.cells)
    palette = draw_palette(rng, kinds, contrast)
    ceiling = round(float(rng.uniform(2.45, 2.7)), 2)
    lintel = round(float(rng.uniform(1.98, 2.05)), 2)
    windows = tuple(
        window for index in range(len(kinds)) for window in _windows(plan, index, palette)
    )
    sites = [_site(plan, index, ceiling, windows) for index in range(len(kinds))]
    bare = Apartment(
        name=name,
        description=f"Generated: {len(kinds)} rooms, {plan.clear_area():.1f} m².",
        rooms=_rooms(plan, palette, ceiling),
        walls=_walls(plan),
        passages=tuple(_passage(door, palette, lintel) for door in plan.doors),
        windows=windows,
        furniture=tuple(piece for site in sites for piece in furnish(rng, site)),
        lamps=tuple(lamp for site in sites for lamp in _lamps(rng, site)),
        materials=palette.materials,
        lighting=draw_lighting(rng, lighting),
        passageway_contrast=contrast,
        start=Start(position=_middle(plan.clear(plan.hub))),
    )
    start = _start(bare, plan)
    return None if start is None else bare.model_copy(update={"start": start})


def _rooms(plan: FloorPlan, palette: Palette, ceiling: float) -> tuple[Room, ...]:
    """Clear floors, named after their kinds."""
    rooms = []
    for index, cell in enumerate(plan.cells):
        x0, y0, x1, y1 = plan.clear(index)
        rooms.append(
            Room(
                name=_name(plan, index),
                kind=cell.kind,
                polygon=((x0, y0), (x1, y0), (x1, y1), (x0, y1)),
                ceiling_height=ceiling,
                floor=palette.floors[cell.kind],
                walls=palette.walls[cell.kind],
                ceiling=palette.ceiling,
            )
        )
    return tuple(rooms)


def _name(plan: FloorPlan, index: int) -> str:
    """Kind of a room, numbered where there are several of it."""
    kind = plan.cells[index].kind
    same = [i for i, cell in enumerate(plan.cells) if cell.kind == kind]
    return kind if len(same) == 1 else f"{kind}_{same.index(index) + 1}"


def _walls(plan: FloorPlan) -> tuple[Wall, ...]:
    """Four outer walls and the inner ones."""
    width, depth = plan.size
    corners = [(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)]
    outer = [Wall(start=corners[k], end=corners[(k + 1) % 4], thickness=OUTER) for k in range(4)]
    return (*outer, *(Wall(start=a, end=b, thickness=INNER) for a, b in plan.walls))


def _passage(door: Door, palette: Palette, lintel: float) -> Passage:
    return Passage(
        position=door.position,
        width=door.width,
        lintel_height=lintel,
        frame=palette.frame,
        closed=door.second < 0,
    )


def _sides(plan: FloorPlan, index: int) -> Iterator[tuple[bool, float, float, float]]:
    """Outer walls of a room: whether upright, the centre line, and the clear span, m."""
    cell, (x0, y0, x1, y1) = plan.cells[index], plan.clear(index)
    for line, limit in ((cell.x0, 0.0), (cell.x1, plan.size[0])):
        if line == limit:
            yield True, line, y0, y1
    for line, limit in ((cell.y0, 0.0), (cell.y1, plan.size[1])):
        if line == limit:
            yield False, line, x0, x1


_WINDOWS: dict[RoomKind, tuple[float, float, float]] = {
    "bathroom": (0.6, 1.3, 2.05),
    "kitchen": (1.1, 1.05, 2.1),
    "corridor": (0.7, 0.95, 2.1),
    "storage": (0.5, 1.4, 2.0),
}
"""Width, sill and head height, m; other rooms have large windows."""


def _windows(plan: FloorPlan, index: int, palette: Palette) -> Iterator[Window]:
    """Windows in every outer wall that is long enough, one for about 2.8 m of wall."""
    width, sill, head = _WINDOWS.get(plan.cells[index].kind, (1.4, 0.85, 2.15))
    entrance = plan.doors[-1]
    for upright, line, low, high in _sides(plan, index):
        count = max(1, int((high - low) / 2.8)) if high - low > 1.0 else 0
        for k in range(count):
            along = round(low + (high - low) * (k + 0.5) / count, 2)
            position = (line, along) if upright else (along, line)
            wide = round(min(width, (high - low) / count - 0.5), 2)
            gap = float(np.hypot(*np.subtract(position, entrance.position)))
            if gap > (wide + entrance.width) / 2 + 0.3:
                yield Window(
                    position=position,
                    width=wide,
                    sill_height=sill,
                    head_height=head,
                    frame=palette.window,
                )


def _site(plan: FloorPlan, index: int, ceiling: float, windows: Sequence[Window]) -> Site:
    """Collect what furnishing must know of a room."""
    box = plan.clear(index)
    doors = [door for door in plan.doors if index in (door.first, door.second)]
    fronts = [_front(box, door.position, door.width + 0.24, 0.75, door.upright) for door in doors]
    entries = [_inside(box, door.position, 0.35) for door in doors]
    room = shapely.box(*box)
    panes = [window for window in windows if room.distance(shapely.Point(window.position)) < OUTER]
    upright = [window.position[0] in (0.0, plan.size[0]) for window in panes]
    return Site(
        kind=plan.cells[index].kind,
        box=box,
        ceiling=ceiling,
        doors=tuple(fronts),
        entries=tuple(entries),
        windows=tuple(
            _front(box, window.position, window.width, 0.5, side)
            for window, side in zip(panes, upright, strict=True)
        ),
        has_kitchen=any(cell.kind == "kitchen" for cell in plan.cells),
    )


def _inside(
    box: tuple[float, float, float, float], position: tuple[float, float], inset: float
) -> tuple[float, float]:
    """Find the point of a room that is ``inset`` m from all walls and nearest to a position."""
    room = shapely.box(*box).buffer(-inset, join_style="mitre")
    nearest = shapely.shortest_line(room, shapely.Point(position))
    x, y = shapely.get_coordinates(nearest)[0]
    return round(float(x), 3), round(float(y), 3)


def _front(
    box: tuple[float, float, float, float],
    position: tuple[float, float],
    width: float,
    depth: float,
    upright: bool,
) -> Polygon:
    """Floor before an opening: that wide, and that deep into the room, m."""
    x, y = position
    reach = depth + OUTER / 2
    half = (reach, width / 2) if upright else (width / 2, reach)
    zone = shapely.box(x - half[0], y - half[1], x + half[0], y + half[1])
    return zone.intersection(shapely.box(*box))


def _lamps(rng: np.random.Generator, site: Site) -> Iterator[Lamp]:
    """Ceiling lamps in the middle of a room, two in a large or long one."""
    x0, y0, x1, y1 = site.box
    area = (x1 - x0) * (y1 - y0)
    count = 2 if area > 16.0 or max(x1 - x0, y1 - y0) > 5.0 else 1
    temperature = float(rng.choice([2700.0, 3000.0, 4000.0]))
    radius = round(float(rng.uniform(0.12, 0.22)), 2)
    for k in range(count):
        share = (k + 0.5) / count
        x = x0 + (x1 - x0) * (share if x1 - x0 >= y1 - y0 else 0.5)
        y = y0 + (y1 - y0) * (share if x1 - x0 < y1 - y0 else 0.5)
        power = round(float(np.clip(3.2 * area / count, 20.0, 60.0)), 1)
        yield Lamp(
            position=(round(x, 2), round(y, 2)),
            radius=radius,
            power=power,
            temperature=temperature,
        )


def _middle(box: tuple[float, float, float, float]) -> tuple[float, float]:
    x0, y0, x1, y1 = box
    return round((x0 + x1) / 2, 3), round((y0 + y1) / 2, 3)


def _start(apartment: Apartment, plan: FloorPlan) -> Start | None:
    """Free floor of the hub nearest to the entrance; None if there is none."""
    hub = shapely.box(*plan.clear(plan.hub))
    free = free_region(apartment, ROBOT_RADIUS + 0.02).intersection(hub)
    if free.is_empty:
        return None
    door = shapely.Point(plan.doors[-1].position)
    x, y = shapely.get_coordinates(shapely.shortest_line(free, door))[0]
    return Start(position=(round(float(x), 3), round(float(y), 3)))


def _all_driven(apartment: Apartment) -> bool:
    """Whether the robot has some floor in every room that it reaches from the start."""
    start = shapely.Point(apartment.start.position)
    parts = shapely.get_parts(free_region(apartment, ROBOT_RADIUS))
    home = min(parts, key=start.distance)
    return all(
        home.intersection(Polygon(room.polygon)).area >= LEAST_DRIVEN for room in apartment.rooms
    )
