"""What a furnished room gets last: radiators, curtains, pictures, lamps, ceiling steps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from scenes.apartment import Block, Lamp, Piece
from scenes.generator.doorways import Pane
from scenes.generator.placing import Group, Member, emit, moved, overlap, place
from scenes.generator.plan import rectangles
from scenes.generator.site import Side, Site, boxes_of

__all__ = ["Dressing", "ceiling_step", "draw_dressing", "dress", "lamps"]

SOFT = ("living_room", "bedroom", "office", "other")
"""Kinds whose windows have curtains rather than blinds."""


@dataclass(frozen=True)
class Dressing:
    """How the windows of a home are dressed, and how many pictures a room has."""

    curtains: bool
    blinds: bool
    radiators: bool
    pictures: int


def draw_dressing(rng: np.random.Generator) -> Dressing:
    """Draw the habits of one home."""
    curtains, blinds, radiators = (bool(value) for value in rng.random(3) < (0.6, 0.5, 0.85))
    return Dressing(curtains, blinds, radiators, int(rng.integers(4)))


def dress(
    rng: np.random.Generator,
    site: Site,
    panes: Sequence[Pane],
    dressing: Dressing,
    swap: Mapping[str, str],
) -> Iterator[Piece]:
    """Pieces at the windows and on the walls of a furnished room."""
    for pane in panes:
        side = _side_of(site, pane)
        if side is not None:
            along = pane.position[1] if pane.upright else pane.position[0]
            for member in _at_window(site, pane, side, along, dressing):
                yield emit(member, side.turn, _origin(side, along), swap)
    for _ in range(dressing.pictures if site.kind in SOFT else dressing.pictures // 2):
        wide, high = (round(float(value), 2) for value in rng.uniform(0.35, (0.9, 0.75)))
        picture = Member("picture", (wide, 0.03, high), 0.0, -0.02)
        yield from place(rng, site, [Group((picture,), corner=-1.0)], swap)


def _side_of(site: Site, pane: Pane) -> Side | None:
    """The wall of the room in which a window is."""
    x, y = pane.position
    across, along = (x, y) if pane.upright else (y, x)
    fitting = [
        side
        for side in site.sides
        if (side.turn % 180 == 90) == pane.upright and side.low <= along <= side.high
    ]
    return min(fitting, key=lambda side: abs(side.line - across), default=None)


def _origin(side: Side, along: float) -> NDArray[np.float64]:
    return np.array((side.line, along) if side.turn % 180 else (along, side.line))


def _at_window(
    site: Site, pane: Pane, side: Side, along: float, dressing: Dressing
) -> Iterator[Member]:
    """Radiator below, curtains beside or blinds before a window, as far as there is room."""
    if dressing.radiators and pane.sill > 0.75:
        length = round(min(1.2, pane.width - 0.1), 2)
        high = round(min(0.7, pane.sill - 0.12), 2)
        radiator = Member("radiator", (length, 0.1, high), 0.0, -0.08)
        if length > 0.4 and _free(site, side, along, radiator):
            yield radiator
    head = pane.head + 0.12
    if site.kind in SOFT and dressing.curtains and head < site.ceiling:
        for sign in (-1, 1):
            at = sign * (pane.width / 2 + 0.16)
            curtain = Member("curtain", (0.36, 0.1, round(head, 2)), at, -0.09)
            if _free(site, side, along, curtain):
                yield curtain
    elif dressing.blinds and pane.sill > 0.5:
        blind = Member("blinds", (pane.width, 0.05, 1.0), 0.0, -0.045, 0, round(pane.head - 1.0, 2))
        if _free(site, side, along, blind, hung_only=True):
            yield blind


def _free(site: Site, side: Side, along: float, member: Member, *, hung_only: bool = False) -> bool:
    """Whether a member fits on the wall there, and remember it if so."""
    box = moved(boxes_of([member.box]), side.turn, _origin(side, along))
    x0, y0, x1, y1 = box[0]
    if not site.shape.buffer(1e-6).covers(shapely.box(x0, y0, x1, y1)):
        return False
    others = [*site.hung, site.doors]
    if not hung_only:
        others.append(site.standing())
    if overlap(box[None], np.concatenate([np.empty((0, 4)), *others]))[0]:
        return False
    (site.hung if member.hangs else site.solids).append(box)
    return True


# ---- lamps and ceiling --------------------------------------------------------------------------


def lamps(rng: np.random.Generator, site: Site) -> Iterator[Lamp]:
    """Ceiling or pendant lamps in the middle of each arm of a room, two in a long one."""
    temperature = float(rng.choice([2700.0, 3000.0, 4000.0]))
    radius = round(float(rng.uniform(0.12, 0.22)), 2)
    spots = [spot for box in rectangles(site.shape) for spot in _middles(box)]
    for x, y in spots or [_pole(site)]:
        power = round(float(np.clip(3.2 * site.area / max(1, len(spots)), 20.0, 60.0)), 1)
        yield Lamp(position=(x, y), radius=radius, power=power, temperature=temperature)


def _middles(box: tuple[float, float, float, float]) -> Iterator[tuple[float, float]]:
    """Middle of a box, or of its halves if it is long; none in narrow ones."""
    x0, y0, x1, y1 = box
    wide, high = x1 - x0, y1 - y0
    if min(wide, high) < 0.8:
        return
    count = 2 if wide * high > 18.0 or max(wide, high) > 5.0 else 1
    for k in range(count):
        share = (k + 0.5) / count
        x = x0 + wide * (share if wide >= high else 0.5)
        y = y0 + high * (share if wide < high else 0.5)
        yield round(x, 2), round(y, 2)


def _pole(site: Site) -> tuple[float, float]:
    point = site.shape.representative_point()
    return round(float(point.x), 2), round(float(point.y), 2)


def ceiling_step(
    rng: np.random.Generator, site: Site, lights: Sequence[Lamp], material: str
) -> Block | None:
    """A bulkhead along a wall or a beam across a room, away from lamps and windows."""
    side = site.sides[int(rng.integers(len(site.sides)))]
    beam = rng.random() < 0.4
    deep = float(rng.uniform(0.2, 0.32) if beam else rng.uniform(0.5, 1.2))
    x0, y0, x1, y1 = site.box
    across = (x1 - x0) if side.turn % 180 else (y1 - y0)
    offset = float(rng.uniform(0.3, 0.7)) * (across - deep) if beam else 0.0
    bottom = round(max(2.2, site.ceiling - float(rng.uniform(0.15, 0.4))), 2)
    if site.ceiling - bottom < 0.1 or side.high - side.low < 1.2 or deep > 0.4 * across:
        return None
    box = boxes_of([_strip(side, offset, deep)])
    x0, y0, x1, y1 = (round(float(value), 3) for value in box[0])
    shape = shapely.box(x0, y0, x1, y1)
    near = [shapely.Point(lamp.position).distance(shape) < lamp.radius + 0.05 for lamp in lights]
    hides = overlap(box[None], site.windows)[0]
    if any(near) or not site.shape.buffer(1e-3).covers(shape) or hides:
        return None
    corners = ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
    return Block(polygon=corners, bottom=bottom, material=material)


def _strip(side: Side, offset: float, deep: float) -> tuple[float, float, float, float]:
    """A box along a wall, ``offset`` m from it."""
    inward = {0: -1, 180: 1, 90: 1, -90: -1}[side.turn]
    low, high = sorted((side.line + inward * offset, side.line + inward * (offset + deep)))
    return (low, side.low, high, side.high) if side.turn % 180 else (side.low, low, side.high, high)
