"""From a plan with its doorways to a furnished and lit apartment."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from shapely import Polygon

from scenes.apartment import (
    Apartment,
    Block,
    Lamp,
    Passage,
    Piece,
    Room,
    Skirting,
    Start,
    Threshold,
    Wall,
    Window,
)
from scenes.generator.doorways import Doorway, Pane, draw_panes, draw_threshold
from scenes.generator.finish import ceiling_step, draw_dressing, dress, lamps
from scenes.generator.interiors import Habits, furnish
from scenes.generator.palettes import Palette, draw_lighting, draw_palette
from scenes.generator.placing import WAY, Member, emit, moved
from scenes.generator.plan import OUTSIDE, FloorPlan
from scenes.generator.site import Site, boxes_of
from scenes.generator.wishes import Brief
from scenes.passages import ROBOT_RADIUS, free_region

__all__ = ["assemble"]

LEAST_DRIVEN = 0.25
"""Floor that the robot's centre must have in every room, m²."""
PLAY = 0.02
"""How much wider on either side than the robot a way must be that floor lies behind, m."""
MOST_TIGHT = 0.5
"""Floor that may lie behind ways without that play, m²."""
LOWERED = ("bathroom", "corridor", "storage")
"""Kinds that may have a lower ceiling than the rest."""


def assemble(
    rng: np.random.Generator,
    plan: FloorPlan,
    doorways: Sequence[Doorway],
    brief: Brief,
    name: str,
) -> Apartment | None:
    """Furnish and light a plan; None if the robot has no place to start."""
    palette = draw_palette(rng, plan.kinds, brief.contrast)
    panes = draw_panes(rng, plan, doorways)
    ceilings = _ceilings(rng, plan)
    sites = [_site(plan, k, ceilings[k], doorways, panes) for k in range(len(plan.kinds))]
    pieces = _furniture(rng, plan, sites, (doorways, panes), palette=palette, brief=brief)
    if pieces is None:
        return None
    lights = [list(lamps(rng, site)) for site in sites]
    bare = Apartment(
        name=name,
        description=_description(plan, brief),
        rooms=_rooms(rng, plan, palette, ceilings),
        walls=tuple(Wall(start=a, end=b, thickness=t) for a, b, t in plan.walls()),
        blocks=_steps(rng, sites, lights, palette, brief.ceiling_steps),
        passages=tuple(_passages(rng, doorways, palette)),
        windows=tuple(_window(pane, palette) for pane in panes),
        furniture=tuple(pieces),
        lamps=tuple(lamp for own in lights for lamp in own),
        materials=palette.materials,
        lighting=draw_lighting(rng, brief.lighting),
        passageway_contrast=brief.contrast,
        start=Start(position=doorways[-1].position),
    )
    start = _start(bare, plan, doorways[-1])
    if start is None:
        return None
    # Drawn last: whether there are thresholds changes nothing else of a home.
    passages = _with_threshold(bare, doorways, draw_threshold(rng))
    return bare.model_copy(update={"start": start, "passages": passages})


def _description(plan: FloorPlan, brief: Brief) -> str:
    area = float(shapely.area(plan.rooms).sum())
    return f"Generated: {len(plan.kinds)} rooms, {area:.1f} m², {brief.layout} layout."


def _ceilings(rng: np.random.Generator, plan: FloorPlan) -> list[float]:
    """One height for most rooms; in some homes bathroom and hall have a lower ceiling."""
    height = round(float(rng.uniform(2.45, 2.75)), 2)
    lowered = round(max(2.3, height - 0.2), 2) if rng.random() < 0.3 else height
    return [lowered if kind in LOWERED else height for kind in plan.kinds]


def _rooms(
    rng: np.random.Generator, plan: FloorPlan, palette: Palette, ceilings: Sequence[float]
) -> tuple[Room, ...]:
    """Clear floors, named after their kinds."""
    boards = None
    if rng.random() < 0.45:
        boards = Skirting(height=round(float(rng.uniform(0.05, 0.1)), 3), material=palette.skirting)
    rooms = []
    for index, (kind, shape) in enumerate(zip(plan.kinds, plan.rooms, strict=True)):
        ring = shapely.get_coordinates(shapely.orient_polygons(shape).exterior)[:-1]
        rooms.append(
            Room(
                name=_name(plan, index),
                kind=kind,
                polygon=tuple((round(float(x), 3), round(float(y), 3)) for x, y in ring),
                ceiling_height=ceilings[index],
                floor=palette.floors[kind],
                walls=palette.walls[kind],
                ceiling=palette.ceiling,
                skirting=None if kind == "bathroom" else boards,
            )
        )
    return tuple(rooms)


def _name(plan: FloorPlan, index: int) -> str:
    """Kind of a room, numbered where there are several of it."""
    kind = plan.kinds[index]
    same = [i for i, other in enumerate(plan.kinds) if other == kind]
    return kind if len(same) == 1 else f"{kind}_{same.index(index) + 1}"


def _passages(
    rng: np.random.Generator, doorways: Sequence[Doorway], palette: Palette
) -> list[Passage]:
    lintel = round(float(rng.uniform(1.98, 2.05)), 2)
    return [
        Passage(
            position=door.position,
            width=door.width,
            lintel_height=None if door.wide else lintel,
            frame=None if door.wide else palette.frame,
            closed=door.second == OUTSIDE,
        )
        for door in doorways
    ]


def _with_threshold(
    apartment: Apartment, doorways: Sequence[Doorway], threshold: Threshold | None
) -> tuple[Passage, ...]:
    """The passages, those with that threshold between whose rooms the floor changes."""
    floors = [room.floor for room in apartment.rooms]
    return tuple(
        passage
        if passage.closed or floors[door.first] == floors[door.second]
        else passage.model_copy(update={"threshold": threshold})
        for passage, door in zip(apartment.passages, doorways, strict=True)
    )


def _window(pane: Pane, palette: Palette) -> Window:
    return Window(
        position=pane.position,
        width=pane.width,
        sill_height=pane.sill,
        head_height=pane.head,
        frame=palette.window,
    )


# ---- furniture ----------------------------------------------------------------------------------


def _furniture(
    rng: np.random.Generator,
    plan: FloorPlan,
    sites: Sequence[Site],
    openings: tuple[Sequence[Doorway], Sequence[Pane]],
    *,
    palette: Palette,
    brief: Brief,
) -> list[Piece] | None:
    """Pieces of all rooms, room by room; None if one lacks what it must have."""
    doorways, panes = openings
    kitchens = [s.area for s in sites if s.kind == "kitchen"]
    habits = Habits(
        swap=palette.swap,
        driven=float(rng.uniform(0.35, 0.42)) - 0.03 * brief.clutter,
        clutter=brief.clutter,
        has_kitchen=bool(kitchens),
        dines=max(kitchens, default=0.0) > 9.0,
    )
    dressing = draw_dressing(rng)
    pieces: list[Piece] = []
    for index, site in enumerate(sites):
        own = [pane for pane in panes if pane.room == index]
        if index == doorways[-1].first and rng.random() < 0.6:
            pieces += _door_mat(plan, site, doorways[-1], habits)
        furnished = furnish(rng, site, habits)
        if furnished is None:
            return None
        pieces += furnished
        pieces += dress(rng, site, own, dressing, palette.swap)
    return pieces


def _door_mat(plan: FloorPlan, site: Site, entrance: Doorway, habits: Habits) -> list[Piece]:
    """A mat inside the entrance, unless it would close the way."""
    size = (0.7, 0.42, 0.009)
    inside = np.array(_inside(site.shape, entrance.position)) - entrance.position
    across = 0 if entrance.upright else 1
    position = np.array(entrance.position)
    position[across] += np.copysign(plan.outer / 2 + 0.03 + size[1] / 2, inside[across])
    turn = (90 if inside[0] > 0 else -90) if entrance.upright else (180 if inside[1] > 0 else 0)
    mat = Member("door_mat", size)
    box = moved(boxes_of([mat.box]), turn, position)
    if not site.is_open(box, WAY / 2, 0.1):
        return []
    site.solids.append(box)
    return [emit(mat, turn, position, habits.swap)]


def _site(
    plan: FloorPlan,
    index: int,
    ceiling: float,
    doorways: Sequence[Doorway],
    panes: Sequence[Pane],
) -> Site:
    """Collect what furnishing must know of a room."""
    shape = plan.rooms[index]
    doors = [door for door in doorways if index in (door.first, door.second)]
    zones = [_front(plan, shape, door, 0.12, 0.8) for door in doors]
    windows = [_front(plan, shape, pane, 0.0, 0.45) for pane in panes if pane.room == index]
    return Site(
        kind=plan.kinds[index],
        shape=shape,
        ceiling=ceiling,
        doors=boxes_of([box for zone in zones for box in zone]),
        windows=boxes_of([box for zone in windows for box in zone]),
        entries=np.array([_inside(shape, door.position) for door in doors]).reshape(-1, 2),
    )


def _inside(shape: Polygon, position: tuple[float, float]) -> tuple[float, float]:
    """The point 0.35 m from all walls that is nearest to a doorway."""
    core = shape.buffer(-0.35, join_style="mitre")
    x, y = shapely.get_coordinates(shapely.shortest_line(core, shapely.Point(position)))[0]
    return float(x), float(y)


def _front(
    plan: FloorPlan, shape: Polygon, opening: Doorway | Pane, margin: float, depth: float
) -> list[tuple[float, float, float, float]]:
    """Floor before an opening, ``margin`` m wider on both sides and that deep into the room, m."""
    x, y = opening.position
    reach, half = depth + plan.outer / 2, opening.width / 2 + margin
    dx, dy = (reach, half) if opening.upright else (half, reach)
    zone = shapely.box(x - dx, y - dy, x + dx, y + dy).intersection(shape)
    return [part.bounds for part in shapely.get_parts(zone) if part.area > 1e-6]


def _steps(
    rng: np.random.Generator,
    sites: Sequence[Site],
    lights: Sequence[Sequence[Lamp]],
    palette: Palette,
    count: int,
) -> tuple[Block, ...]:
    """Ceiling steps in so many rooms, the larger ones first."""
    blocks: list[Block] = []
    order = sorted(range(len(sites)), key=lambda k: -sites[k].area * rng.uniform(0.6, 1.4))
    for index in order:
        for _ in range(12):
            if len(blocks) >= count:
                return tuple(blocks)
            block = ceiling_step(rng, sites[index], lights[index], palette.ceiling)
            if block is not None:
                blocks.append(block)
                break
    return tuple(blocks)


def _largest(apartment: Apartment, radius: float) -> Polygon:
    """Where a disc of that radius can be without a break; empty if nowhere."""
    free = free_region(apartment, radius)
    return max(shapely.get_parts(free), key=shapely.area, default=Polygon())


def _start(apartment: Apartment, plan: FloorPlan, entrance: Doorway) -> Start | None:
    """Free floor nearest to the entrance from which every room is reached.

    None if there is none, or if much floor lies behind a gap hardly wider than the robot:
    whether a map of 5 cm cells knows such a gap is a matter of luck.
    """
    # A little wider than the robot, so that rounding does not put it into a wall.
    home = _largest(apartment, ROBOT_RADIUS + 0.01)
    first = home.intersection(plan.rooms[entrance.first])
    if any(home.intersection(room).area < LEAST_DRIVEN for room in plan.rooms):
        return None
    with_play = _largest(apartment, ROBOT_RADIUS + PLAY).buffer(PLAY + 1e-3)
    if _largest(apartment, ROBOT_RADIUS).difference(with_play).area > MOST_TIGHT:
        return None
    x, y = shapely.get_coordinates(shapely.shortest_line(first, shapely.Point(entrance.position)))[
        0
    ]
    inward = np.subtract((x, y), entrance.position)
    heading = float(np.degrees(np.arctan2(inward[1], inward[0])))
    heading = round(heading / 90.0) * 90.0
    return Start(position=(round(float(x), 3), round(float(y), 3)), heading_deg=heading)
