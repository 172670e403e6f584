"""Groups of furniture as people put it together: bed and nightstands, sofa and television.

Every function yields or returns variants, the preferred first; see
`scenes.generator.placing` for the frame.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from scenes.generator.placing import Group, Member, behind

__all__ = [
    "alone",
    "bath_or_shower",
    "bed",
    "desk",
    "desk_place",
    "dining",
    "kitchen_row",
    "lounge",
    "round_dining",
    "small",
    "washbasin",
]

CHAIR = (0.44, 0.48, 0.9)


def alone(
    kind: str,
    size: tuple[float, float, float],
    *,
    front: float = 0.0,
    corner: float = 0.3,
    window: float = 0.3,
    above: Member | None = None,
) -> Group:
    """One piece at a wall with ``front`` m of free floor before it."""
    w, d, _ = size
    access = ((-w / 2, -d - front, w / 2, -d - 0.03),) if front else ()
    members = (behind(kind, size), *([above] if above else []))
    return Group(members, access, corner=corner, window=window)


def small(kind: str, size: tuple[float, float, float], *, free: bool = False) -> Group:
    """Something small on the floor that may stand in people's way."""
    member = Member(kind, size) if free else behind(kind, size)
    return Group((member,), free=free, loose=True, corner=0.2)


def bed(
    kind: str, width: float, stands: int, *, window: float = 0.5, picture: float = 0.0
) -> Group:
    """A bed with its head at a wall, nightstands beside it, and floor to get in from.

    ``picture``: width of one over its head, m; 0 for none.
    """
    size = (width, 2.05, 1.65 if kind == "bunk_bed" else 0.95)
    members = [behind(kind, size)]
    access = []
    sides = (-1, 1) if width > 1.3 else (1,)
    for k, side in enumerate(sides):
        edge = side * width / 2
        if k < stands:
            members.append(behind("nightstand", (0.42, 0.38, 0.5), edge + side * 0.235))
        low, high = sorted((edge + side * 0.03, edge + side * 0.55))
        access.append((low, -1.75, high, -0.65))
    if picture:
        members.append(Member("picture", (picture, 0.03, 0.5), 0.0, -0.02, 0, 1.3))
    # One side is enough where there is no nightstand on the other.
    access = access[: max(1, stands)]
    return Group(tuple(members), tuple(access), corner=0.3 * (width < 1.3), window=window)


def lounge(
    rng: np.random.Generator, depths: Sequence[float], *, wide: float, sofa: str
) -> Iterator[Group]:
    """A television at a wall, a sofa that faces it at each of some distances, a table between.

    ``depths``: from the wall to the back of the sofa, m; ``wide``: of the sofa, m.
    """
    screen = float(rng.choice([1.2, 1.5, 1.8]))
    board = rng.choice(["tv_stand", "sideboard", "chest_of_drawers"], p=[0.25, 0.25, 0.5])
    back = 0.92 if sofa != "corner_sofa" else 1.7
    for depth in depths:
        if board == "tv_stand":
            first = [behind("tv_stand", (screen, 0.42, 1.1))]
        else:
            hung = Member("tv", (min(screen, 1.4), 0.07, 0.75), 0.0, -0.055)
            first = [behind(str(board), (screen + 0.1, 0.42, 0.6)), hung]
        seat_depth = 0.9 if sofa != "corner_sofa" else 1.7
        seat = Member(sofa, (wide, seat_depth, 0.82), 0.0, -(depth - seat_depth / 2), 180)
        table_y = -(depth - 0.92 - 0.3 - 0.28)
        # The couch of a corner sofa is on one side, the table before the other.
        table_x = 0.2 * wide if sofa == "corner_sofa" else 0.0
        table = Member("coffee_table", (0.95, 0.55, 0.42), table_x, table_y)
        rug = Member("rug", (min(2.2, wide), 1.5, 0.008), 0.0, table_y - 0.1)
        with_rug = [rug] if rng.random() < 0.6 and depth > 2.7 else []
        access = (-0.5 * screen, -(depth - back), 0.5 * screen, -0.48)
        yield Group((*first, seat, table, *with_rug), (access,), window=0.3, corner=-0.2)


def dining(chairs: int, *, length: float, width: float = 0.8, wall: bool = False) -> Group:
    """A table with chairs along its long sides; with one end at a wall or in the open."""
    members = [Member("table", (length, width, 0.75), 0.0, 0.0)]
    rows = (chairs + 1) // 2
    for k in range(chairs):
        side = 1 if k % 2 else -1
        along = length * ((k // 2 + 0.5) / rows - 0.5)
        y = side * (width / 2 + 0.14)
        members.append(Member("chair", CHAIR, along, y, 0 if side > 0 else 180))
    reach = width / 2 + 0.4
    access = (
        (-length / 2, -reach - 0.3, length / 2, -reach),
        (-length / 2, reach, length / 2, reach + 0.3),
    )
    if not wall:
        return Group(tuple(members), access, free=True)
    # A quarter turn: one short end of the table at the wall.
    turned = [
        Member(m.kind, m.size, m.y, -m.x - length / 2 - 0.03, (m.turn - 90) % 360) for m in members
    ]
    sides = ((reach, -length, reach + 0.3, -0.2), (-reach - 0.3, -length, -reach, -0.2))
    return Group(tuple(turned), sides, window=-0.3)


def round_dining(chairs: int, *, wide: float) -> Group:
    """A round table with chairs on two or four sides."""
    members = [Member("round_table", (wide, wide, 0.75))]
    reach = wide / 2 + 0.12
    for x, y, turn in ((0.0, reach, 0), (0.0, -reach, 180), (reach, 0.0, -90), (-reach, 0.0, 90))[
        :chairs
    ]:
        members.append(Member("chair", CHAIR, x, y, turn))
    return Group(tuple(members), free=True)


def kitchen_row(rng: np.random.Generator, length: float) -> Group:
    """Fridge, sink, dishwasher, cooker and counters in a row, cupboards and a hood above."""
    flip = 1.0 if rng.random() < 0.5 else -1.0
    members: list[Member] = []
    x = -length / 2
    for kind, width in _row(rng, length):
        middle = flip * (x + width / 2)
        deep, high = {"fridge": (0.64, 1.85), "oven_tower": (0.62, 2.1)}.get(kind, (0.61, 0.9))
        if kind == "dishwasher":
            high = 0.88
        members.append(behind(kind, (width, deep, high), middle))
        if kind in ("kitchen_counter", "kitchen_sink") and width >= 0.5:
            members.append(Member("wall_cupboard", (width, 0.35, 0.68), middle, -0.185, 0, 1.42))
        if kind == "cooker":
            members.append(Member("extractor_hood", (width, 0.48, 0.62), middle, -0.25, 0, 1.55))
        x += width
    front = (-length / 2, -1.45, length / 2, -0.68)
    return Group(tuple(members), (front,), corner=0.5, window=0.25)


def _row(rng: np.random.Generator, length: float) -> Iterator[tuple[str, float]]:
    """Modules of a kitchen row that fill its length: tall ones at one end, m."""
    yield "fridge", 0.6
    rest = length - 0.6
    if rest >= 3.2 and rng.random() < 0.6:
        yield "oven_tower", 0.6
        rest -= 0.6
    sink = 1.2 if rest >= 2.4 else 0.8
    machine = rest - sink - 0.6 >= 1.0
    free = rest - sink - 0.6 - 0.6 * machine
    before = free if free < 0.8 else round(free * float(rng.uniform(0.4, 0.6)), 2)
    if before >= 0.3:
        yield "kitchen_counter", before
        free -= before
    yield "kitchen_sink", sink
    if machine:
        yield "dishwasher", 0.6
    yield "cooker", 0.6
    if free >= 0.3:
        yield "kitchen_counter", round(free, 2)


def desk(width: float, *, kind: str = "desk") -> Group:
    """A desk at a wall with a chair before it."""
    deep = 0.7
    chair = Member("office_chair", (0.58, 0.58, 1.05), -0.1 * width, -deep - 0.28, 180)
    access = ((-width / 2, -deep - 0.85, width / 2, -deep - 0.57),)
    return Group((behind(kind, (width, deep, 0.74)), chair), access, window=-0.4, corner=0.3)


def desk_place(rng: np.random.Generator) -> Group:
    """A desk that stands into the room with its short side at the wall."""
    width = float(rng.choice([1.4, 1.6]))
    table = Member("office_desk", (width, 0.75, 0.74), 0.0, -0.03 - width / 2, 90)
    chair = Member("office_chair", (0.58, 0.58, 1.05), 0.68, -0.1 - width / 2, -90)
    return Group((table, chair), ((0.97, -width, 1.2, 0.0),), window=-0.3, corner=0.2)


def washbasin(rng: np.random.Generator, area: float) -> Iterator[Group]:
    """Vanity or basin with a mirror over it."""
    if area > 4.0 and rng.random() < 0.6:
        width = float(rng.choice([0.8, 0.9, 1.0]))
        yield _basin("vanity", (width, 0.48, 0.85), float(rng.choice([0.8, 1.0])))
    yield _basin("basin", (0.58, 0.46, 0.86), 0.8)
    yield _basin("basin", (0.45, 0.36, 0.86), 0.7)


def _basin(kind: str, size: tuple[float, float, float], high: float) -> Group:
    mirror = Member("mirror", (size[0], 0.03, high), 0.0, -0.03, 0, 1.1)
    return alone(kind, size, front=0.55, corner=0.0, window=0.6, above=mirror)


def bath_or_shower(rng: np.random.Generator, area: float) -> Iterator[Group]:
    """A bath in larger bathrooms, else a shower in a corner."""
    if area > 4.4 and rng.random() < 0.6:
        yield alone("bath", (1.7, 0.75, 0.56), front=0.5, corner=0.8, window=0.1)
    for wide in (0.9, 0.8):
        cabin = alone("shower_cabin", (wide, wide, 2.0), front=0.45)
        if rng.random() < 0.7:
            yield Group(cabin.members, cabin.access, left=True)
        yield alone("shower_tray", (wide, wide, 0.05), front=0.45, corner=2.0)
