"""Groups of pieces that belong together, and where in a room they go.

A group (a bed with its nightstands, a row of kitchen cabinets, a sofa before a
television) is described with the wall behind it at y = 0 and the room at
y < 0. Many places are drawn along all walls; those where nothing overlaps are
tried from the most to the least fitting one until the ways through the room
stay open.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from scenes.apartment import Piece
from scenes.generator.site import Boxes, Side, Site, boxes_of
from scenes.pieces import KINDS

__all__ = ["WAY", "Group", "Member", "behind", "emit", "moved", "overlap", "place"]

Box = tuple[float, float, float, float]

WAY = 0.5
"""Clear width that must remain from doorway to doorway and through most of the room, m."""
OPEN = 0.1
"""Share of the floor that must stay in reach at that width."""
POCKET = 0.02
"""Share of the floor that may be free but out of the robot's reach."""
WALL_GAP = 0.02
"""Between the back of a piece and the wall, m."""
TALL = 0.95
"""Higher pieces do not stand before windows, m."""
TRIES = 10
"""How many fitting places are tested for open ways."""

_TURNS = {
    0: ((1, 0), (0, 1)),
    90: ((0, 1), (-1, 0)),
    180: ((-1, 0), (0, -1)),
    -90: ((0, -1), (1, 0)),
}
"""Rows that x and y become under quarter turns: points @ rows."""


@dataclass(frozen=True)
class Member:
    """One piece of a group: middle of its footprint and turn in the group's frame."""

    kind: str
    size: tuple[float, float, float]
    x: float = 0.0
    y: float = 0.0
    turn: int = 0
    elevation: float | None = None

    @property
    def box(self) -> Box:
        """Footprint."""
        w, d = self.size[:2] if self.turn % 180 == 0 else self.size[1::-1]
        return self.x - w / 2, self.y - d / 2, self.x + w / 2, self.y + d / 2

    @property
    def hangs(self) -> bool:
        """Whether it is fixed to the wall above the floor."""
        lift = KINDS[self.kind].elevation if self.elevation is None else self.elevation
        return lift > 0.0

    @property
    def flat(self) -> bool:
        """Whether the robot drives over it, as over rugs."""
        return not self.hangs and self.size[2] <= 0.01


@dataclass(frozen=True)
class Group:
    """Pieces that are placed together.

    ``access``: floor before them that later pieces leave free. ``corner``,
    ``window``: how much better a place in a corner, how much worse one before a
    window is (other things equal: chance of 0 to 1). ``left``: only in a corner
    with a wall on its left. ``free``: anywhere, not at a wall. ``loose``: may
    stand in the access of others. ``bonus``: added to all its places.
    """

    members: tuple[Member, ...]
    access: tuple[Box, ...] = ()
    corner: float = 0.0
    window: float = 0.0
    left: bool = False
    free: bool = False
    loose: bool = False
    bonus: float = 0.0

    @cached_property
    def solids(self) -> Boxes:
        """Footprints of what stands on the floor."""
        return boxes_of([m.box for m in self.members if not m.hangs and not m.flat])

    @cached_property
    def body(self) -> Boxes:
        """What must not overlap anything: the solids, or all of it if there are none."""
        return self.solids if len(self.solids) else self.extent

    @cached_property
    def extent(self) -> Boxes:
        """Footprints of everything."""
        return boxes_of([m.box for m in self.members])

    @cached_property
    def high(self) -> Boxes:
        """What would hide a window: tall members, or what only hangs."""
        hung = all(m.hangs for m in self.members)
        return boxes_of([m.box for m in self.members if hung or (m.size[2] > TALL and not m.hangs)])


@dataclass(frozen=True)
class _Spot:
    """A place of a group: where its origin goes, and its turn in degrees."""

    group: Group
    turn: int
    origin: NDArray[np.float64]
    score: float


def behind(kind: str, size: tuple[float, float, float], x: float = 0.0) -> Member:
    """A member with its back to the group's wall."""
    return Member(kind, size, x, -(WALL_GAP + size[1] / 2))


def place(
    rng: np.random.Generator, site: Site, variants: Sequence[Group], swap: Mapping[str, str]
) -> list[Piece]:
    """Put one of several variants of a group into a room, or none if there is no place.

    Variants that come first are preferred. The site remembers what was placed.
    """
    for group in variants:
        spots = [spot for turn_spots in _spots(rng, site, group) for spot in turn_spots]
        spots.sort(key=lambda spot: -spot.score)
        for spot in spots[:TRIES]:
            solids = moved(group.solids, spot.turn, spot.origin)
            if _keeps_open(site, solids):
                site.solids.append(solids)
                site.access.append(moved(boxes_of(group.access), spot.turn, spot.origin))
                hung = [m.box for m in group.members if m.hangs]
                site.hung.append(moved(boxes_of(hung), spot.turn, spot.origin))
                return [emit(m, spot.turn, spot.origin, swap) for m in _unblocked(site, spot)]
    return []


def _keeps_open(site: Site, solids: Boxes) -> bool:
    """Whether the ways stay open and no corner is cut off from the robot."""
    if not len(solids):
        return True
    if not site.is_open(solids, WAY / 2, OPEN):
        return False
    return site.pockets(solids) <= POCKET * site.area + 0.03


def _spots(rng: np.random.Generator, site: Site, group: Group) -> Iterator[list[_Spot]]:
    """Places where a group overlaps nothing, for each wall or each turn."""
    if group.free:
        x0, y0, x1, y1 = site.box
        for turn in (0, 90, 180, -90)[:: 1 if len(group.members) > 1 else 2]:
            origins = rng.uniform((x0, y0), (x1, y1), (60, 2))
            yield _fitting(site, group, turn, np.round(origins, 3), rng.random(60))
        return
    for side in site.sides:
        origins, ends = _along(rng, group, side)
        if len(origins):
            scores = group.corner * ends + rng.random(len(ends))
            yield _fitting(site, group, side.turn, origins, scores)


def _along(
    rng: np.random.Generator, group: Group, side: Side
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Origins along a wall, and which of them lie in a corner: in both, and between."""
    axis = 1 if side.turn % 180 else 0
    extent = _rotated(group.extent, side.turn)
    low = side.low + WALL_GAP - float(extent[:, axis].min())
    high = side.high - WALL_GAP - float(extent[:, axis + 2].max())
    if high < low:
        return np.empty((0, 2)), np.empty(0)
    # The left end of the group is at the low end of walls whose turn is 0 or 90.
    left_is_low = side.turn in (0, 90)
    if group.left:
        along = np.array([low if left_is_low else high])
        ends = np.array([side.low_corner if left_is_low else side.high_corner], dtype=float)
        along, ends = along[ends > 0], ends[ends > 0]
    else:
        count = 6 + int((high - low) / 0.15)
        along = np.concatenate([[low, high], rng.uniform(low, high, count)])
        ends = np.concatenate([[side.low_corner, side.high_corner], np.zeros(count)])
    line = np.full(len(along), side.line)
    pairs = (line, along) if axis else (along, line)
    return np.round(np.column_stack(pairs), 3), ends


def _fitting(
    site: Site,
    group: Group,
    turn: int,
    origins: NDArray[np.float64],
    scores: NDArray[np.float64],
) -> list[_Spot]:
    """Those of many places where the group is inside, apart from everything, and usable."""
    shift = np.tile(origins, 2)[:, None, :]
    body = _rotated(group.body, turn)[None] + shift
    extent = _rotated(group.extent, turn)[None] + shift
    access = _rotated(boxes_of(group.access), turn)[None] + shift
    walls, standing = site.notches, site.standing()
    x0, y0, x1, y1 = site.box
    inside = (extent[..., :2] >= (x0, y0)).all(axis=(1, 2)) & (extent[..., 2:] <= (x1, y1)).all(
        axis=(1, 2)
    )
    room = (access[..., :2] >= (x0 - 0.01, y0 - 0.01)).all(axis=(1, 2)) & (
        access[..., 2:] <= (x1 + 0.01, y1 + 0.01)
    ).all(axis=(1, 2))
    blocked = [site.doors, standing, np.concatenate([np.empty((0, 4)), *site.hung])]
    if not group.loose:
        blocked += site.access
    good = inside & room & ~overlap(extent, walls) & ~overlap(body, np.concatenate(blocked))
    good &= ~overlap(access, np.concatenate([walls, standing]))
    good &= ~overlap(_rotated(group.high, turn)[None] + shift, site.windows)
    before = overlap(body, site.windows)
    total = scores + group.bonus - group.window * before
    return [_Spot(group, turn, origins[k], float(total[k])) for k in np.flatnonzero(good)]


def overlap(boxes: Boxes, others: Boxes, gap: float = 0.008) -> NDArray[np.bool_]:
    """For each place (first axis): whether any of its boxes comes within ``gap`` of another."""
    a, b = boxes[:, :, None, :], others[None, None, :, :]
    apart = (
        (a[..., 0] >= b[..., 2] + gap)
        | (a[..., 2] <= b[..., 0] - gap)
        | (a[..., 1] >= b[..., 3] + gap)
        | (a[..., 3] <= b[..., 1] - gap)
    )
    found: NDArray[np.bool_] = (~apart).any(axis=(1, 2))
    return found


def _rotated(boxes: Boxes, turn: int) -> Boxes:
    """Boxes turned by a multiple of 90° about the origin."""
    rows = np.array(_TURNS[turn], dtype=float)
    a, b = boxes[:, :2] @ rows, boxes[:, 2:] @ rows
    return np.column_stack([np.minimum(a, b), np.maximum(a, b)])


def moved(boxes: Boxes, turn: int, origin: NDArray[np.float64]) -> Boxes:
    """Boxes of a group's frame where the group stands."""
    return _rotated(boxes, turn) + np.tile(origin, 2)


def _unblocked(site: Site, spot: _Spot) -> Iterator[Member]:
    """Members of a group without what would hang before a window or a door."""
    zones = np.concatenate([site.windows, site.doors])
    for member in spot.group.members:
        box = moved(boxes_of([member.box]), spot.turn, spot.origin)
        if not member.hangs or not overlap(box[None], zones)[0]:
            yield member


def emit(member: Member, turn: int, origin: NDArray[np.float64], swap: Mapping[str, str]) -> Piece:
    """The piece that a member becomes, in the home's own materials."""
    w, d, h = (round(value, 3) for value in member.size)
    x, y = np.array([member.x, member.y]) @ np.array(_TURNS[turn]) + origin
    angle = (member.turn + turn + 180) % 360 - 180
    slots = KINDS[member.kind].slots
    keys = {slot: f"{slot}:{name}" for slot, name in slots.items()}
    materials = {slot: swap.get(keys[slot], swap.get(name, name)) for slot, name in slots.items()}
    return Piece(
        kind=member.kind,
        position=(round(float(x), 3), round(float(y), 3)),
        rotation_deg=float(angle),
        elevation=member.elevation,
        size=(w, d, h),
        materials={slot: name for slot, name in materials.items() if name != slots[slot]},
    )
