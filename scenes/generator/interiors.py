"""What the rooms of a home are furnished with, by their kinds.

First comes what a room of its kind needs, from the largest down; then things
that fill it until the robot can drive on about as much of the floor as in the
homes of Table 8 (15 to 22 nodes of 0.03 m² per m²); then what lies about.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from scenes.apartment import Piece, RoomKind
from scenes.generator import groups
from scenes.generator.groups import alone, small
from scenes.generator.placing import Group, Member, place
from scenes.generator.site import Site

__all__ = ["Habits", "furnish"]

Choice = Sequence[Group]
"""Variants of which one is placed."""


REDRAWS = 4
"""How often a room is furnished anew before the whole plan is given up."""
VITAL = {
    "basin",
    "bath",
    "bed",
    "cooker",
    "divan_bed",
    "low_sofa",
    "shower_tray",
    "sofa",
    "toilet",
    "vanity",
}
"""A choice with any of these must find its place."""


@dataclass(frozen=True)
class Habits:
    """What the furnishing of all rooms of a home has in common.

    ``swap`` maps default materials to the home's own; ``driven`` is the share
    of the floor for the robot's centre at which filling stops; ``clutter`` 0 to 1.
    """

    swap: dict[str, str]
    driven: float
    clutter: float
    has_kitchen: bool
    dines: bool


def furnish(rng: np.random.Generator, site: Site, habits: Habits) -> list[Piece] | None:
    """Furnish one room, as the generator's state decides; None if what it must have has no place.

    What stands in the room already stays there.
    """
    begin = [list(boxes) for boxes in (site.solids, site.access, site.hung)]
    for _ in range(REDRAWS):
        pieces = _essentials(rng, site, habits)
        if pieces is not None:
            break
        site.solids, site.access, site.hung = map(list, begin)
    else:
        return None
    for group in _fillers(rng, site):
        if site.driven() <= habits.driven:
            break
        pieces += place(rng, site, [group], habits.swap)
    for group in _clutter(rng, site, habits):
        pieces += place(rng, site, [group], habits.swap)
    return pieces


def _essentials(rng: np.random.Generator, site: Site, habits: Habits) -> list[Piece] | None:
    """What a room of its kind needs; None if one of the things in `VITAL` found no place."""
    pieces: list[Piece] = []
    for choice in _needs(rng, site, habits):
        placed = place(rng, site, choice, habits.swap)
        if not placed and VITAL & {member.kind for group in choice for member in group.members}:
            return None
        pieces += placed
    return pieces


def _needs(rng: np.random.Generator, site: Site, habits: Habits) -> Iterator[Choice]:
    make = _NEEDS.get(site.kind)
    if site.kind == "living_room":
        yield from _living_room(rng, site, habits)
    elif make is not None:
        yield from make(rng, site)


def _living_room(rng: np.random.Generator, site: Site, habits: Habits) -> Iterator[Choice]:
    if not habits.has_kitchen:
        yield [groups.kitchen_row(rng, length) for length in (2.8, 2.4, 2.0)]
    yield list(_lounges(rng, site))
    if not habits.dines or site.area > 26.0:
        yield _tables(rng, site.area)
    if rng.random() < 0.5:
        yield [alone("bookcase", (w, 0.3, 2.1), front=0.45) for w in (1.6, 1.2, 0.9)]
    else:
        yield [alone("sideboard", (w, 0.45, 0.8), front=0.45) for w in (1.8, 1.4, 1.0)]
    if site.area > 30.0 and rng.random() < 0.5:
        yield [
            alone("piano", (1.5, 0.6, 1.25), front=0.7),
            alone("fireplace", (1.3, 0.4, 1.1), front=0.8),
        ]
    if rng.random() < 0.7:
        yield [alone("plant", (0.6, 0.6, 1.3), corner=1.0, window=-0.5)]


def _lounges(rng: np.random.Generator, site: Site) -> Iterator[Group]:
    """Sofa and television, the sofa at the far wall if that is near enough."""
    x0, y0, x1, y1 = site.box
    spans = [span - 0.02 for span in (x1 - x0, y1 - y0) if 2.5 <= span <= 4.4]
    far = [3.4, 3.1, 2.8, 2.6]
    kind = "sofa" if rng.random() < 0.3 else "low_sofa"
    if site.area > 20.0 and rng.random() < 0.35:
        yield from groups.lounge(rng, [*spans, *far[:3]], wide=2.4, sofa="corner_sofa")
    wide = float(rng.choice([1.9, 2.1, 2.3])) if site.area > 15.0 else 1.7
    for width in dict.fromkeys((wide, 1.7, 1.5)):
        yield from groups.lounge(rng, [*spans, *far], wide=width, sofa=kind)
    yield alone("low_sofa", (1.6, 0.88, 0.82), front=0.4)
    yield alone("armchair", (0.8, 0.85, 0.85), front=0.3)


def _tables(rng: np.random.Generator, area: float) -> Choice:
    """A dining table for the size of the room."""
    chairs = 6 if area > 22.0 else 4
    large = groups.dining(chairs, length=1.8 if chairs == 6 else 1.4, width=0.85)
    middle = [groups.dining(4, length=1.2), groups.round_dining(4, wide=1.0)]
    if rng.random() < 0.5:
        middle.reverse()
    least = [groups.dining(4, length=1.2, wall=True), groups.dining(2, length=0.75, wall=True)]
    return [*([large] if area > 16.0 else []), *middle, *least]


def _bedroom(rng: np.random.Generator, site: Site) -> Iterator[Choice]:
    kind = "bed" if rng.random() < 0.25 else "divan_bed"
    single = site.area < 8.5 or (site.area < 12.0 and rng.random() < 0.5)
    child = single and rng.random() < 0.7
    if single:
        first = "bunk_bed" if child and rng.random() < 0.3 else kind
        yield [groups.bed(first, w, stands) for w, stands in ((1.0, 1), (0.9, 1), (0.9, 0))]
    else:
        widths = (1.8, 1.6) if site.area > 11.0 else (1.4,)
        picture = float(rng.choice([0.0, 0.6, 0.9]))
        yield [
            groups.bed(kind, w, stands, picture=picture)
            for w, stands in (*((w, 2) for w in widths), (1.4, 2), (1.4, 1), (1.2, 1), (0.9, 0))
        ]
    wide = (2.4, 2.0) if site.area > 13.0 else (1.6,) if site.area > 9.0 else ()
    yield [alone("wardrobe", (w, 0.6, 2.1), front=0.6, corner=0.6) for w in (*wide, 1.2, 1.0, 0.8)]
    if child or rng.random() < 0.3:
        yield [groups.desk(1.2), groups.desk(1.0)]
    if rng.random() < 0.6:
        yield [alone("chest_of_drawers", (w, 0.46, 0.85), front=0.5) for w in (1.1, 0.8)]
    if rng.random() < 0.5:
        yield [small("rug", (1.4, 0.9, 0.008), free=True)]


def _kitchen(rng: np.random.Generator, site: Site) -> Iterator[Choice]:
    longest = max(side.high - side.low for side in site.sides) - 0.05
    lengths = [length for length in (4.0, 3.6, 3.2, 2.9, 2.6, 2.3, 2.0) if length <= longest]
    start = int(rng.integers(min(2, max(len(lengths), 1)))) if site.area < 14 else 0
    yield [groups.kitchen_row(rng, length) for length in lengths[start:]]
    if site.area > 6.5:
        yield (
            _tables(rng, min(site.area, 15.0))
            if site.area > 9.0
            else [groups.dining(2, length=0.75, wall=True)]
        )
    yield [small("waste_bin", (0.3, 0.3, 0.6))]


def _bathroom(rng: np.random.Generator, site: Site) -> Iterator[Choice]:
    yield list(groups.bath_or_shower(rng, site.area))
    yield [
        alone("toilet", (0.38, 0.65, 0.8), front=0.5),
        alone("toilet", (0.36, 0.55, 0.8), front=0.4),
    ]
    yield list(groups.washbasin(rng, site.area))
    if site.area > 4.5 and rng.random() < 0.5:
        yield [alone("washing_machine", (0.6, 0.6, 0.85), front=0.5)]
    yield [alone("towel_radiator", (0.5, 0.1, 1.2), corner=0.0)]


def _office(rng: np.random.Generator, site: Site) -> Iterator[Choice]:
    desks = [groups.desk(1.6), groups.desk(1.4), groups.desk(1.2)]
    yield [groups.desk_place(rng), *desks] if rng.random() < 0.35 else desks
    yield [alone("bookcase", (w, 0.3, 2.1), front=0.4) for w in (1.6, 1.2, 0.8)]
    yield [alone("filing_cabinet", (0.45, 0.6, 0.72), front=0.4)]


def _storage(rng: np.random.Generator, site: Site) -> Iterator[Choice]:
    deep = 0.4 if min(site.box[2] - site.box[0], site.box[3] - site.box[1]) > 1.5 else 0.3
    yield [alone("shelf", (w, deep, 1.9), corner=0.6) for w in (1.4, 1.0, 0.7)]
    if rng.random() < 0.5:
        yield [alone("washing_machine", (0.6, 0.6, 0.85), front=0.45)]
    yield [alone("shelf", (w, 0.3, 1.9), corner=0.6) for w in (1.0, 0.7)]


def _corridor(rng: np.random.Generator, site: Site) -> Iterator[Choice]:
    x0, y0, x1, y1 = site.box
    broad = min(x1 - x0, y1 - y0) > 1.5
    yield [_coats(0.9), _coats(0.6)]
    if min(x1 - x0, y1 - y0) > 1.25:
        deep = 0.5 if broad else 0.36
        yield [alone("wardrobe", (w, deep, 2.1), corner=0.6) for w in (1.6, 1.2, 0.9)]
    if broad:
        yield [alone("bench", (1.0, 0.35, 0.45), corner=0.0)]
    mirror = Member("mirror", (0.5, 0.03, 1.2), 0.0, -0.03, 0, 0.7)
    yield [Group((mirror,))]
    if rng.random() < 0.5:
        long = (0.7, 1.8, 0.008) if y1 - y0 > x1 - x0 else (1.8, 0.7, 0.008)
        yield [small("rug", long, free=True)]


def _coats(width: float) -> Group:
    """Coats on the wall, shoes below them."""
    rack = Member("shoe_rack", (width, 0.24, 0.45), 0.0, -0.14)
    coats = Member("coat_rack", (width, 0.22, 1.1), 0.0, -0.12, 0, 0.7)
    return Group((rack, coats), corner=0.3)


def _spare(rng: np.random.Generator, site: Site) -> Iterator[Choice]:
    if rng.random() < 0.5:
        yield [groups.bed("divan_bed", 1.4, 1), groups.bed("divan_bed", 0.9, 0)]
        yield [alone("chest_of_drawers", (0.9, 0.46, 0.85), front=0.5)]
    else:
        yield [groups.desk(1.4), groups.desk(1.1)]
        yield [alone("piano", (1.4, 0.58, 1.2), front=0.6), alone("bookcase", (1.0, 0.3, 2.1))]
    yield [alone("shelf", (w, 0.35, 1.9), front=0.4) for w in (1.2, 0.8)]


_NEEDS: dict[RoomKind, Callable[[np.random.Generator, Site], Iterator[Choice]]] = {
    "bedroom": _bedroom,
    "kitchen": _kitchen,
    "bathroom": _bathroom,
    "office": _office,
    "storage": _storage,
    "corridor": _corridor,
    "other": _spare,
}


_FILL: dict[RoomKind, tuple[str, ...]] = {
    "living_room": (
        "armchair",
        "bookcase",
        "low_cabinet",
        "plant",
        "divider",
        "desk",
        "floor_lamp",
    ),
    "bedroom": ("armchair", "wardrobe", "shelf", "chest", "plant", "desk", "laundry_basket"),
    "kitchen": ("counter", "island", "cabinet", "low_cabinet", "plant"),
    "bathroom": ("laundry_basket", "cabinet", "stool"),
    "corridor": ("narrow", "narrow", "plant"),
    "office": ("armchair", "low_cabinet", "shelf", "plant", "bookcase", "chest", "printer"),
    "storage": ("box", "box", "laundry_basket", "narrow"),
    "other": ("shelf", "armchair", "wardrobe", "box", "plant", "chest"),
}
_FILLERS = {
    "armchair": alone("armchair", (0.8, 0.85, 0.84), front=0.25, corner=0.5),
    "bench": alone("bench", (1.1, 0.36, 0.45)),
    "bookcase": alone("bookcase", (1.5, 0.32, 2.1), front=0.4, corner=0.4),
    "box": alone("box", (0.5, 0.42, 0.5), corner=0.6),
    "cabinet": alone("shelf", (0.6, 0.35, 1.7), corner=0.5),
    "chest": alone("chest_of_drawers", (0.9, 0.45, 0.85), front=0.45),
    "counter": alone("kitchen_counter", (1.5, 0.6, 0.9), front=0.6, corner=0.5),
    "desk": groups.desk(1.2),
    "divider": Group((Member("room_divider", (1.6, 0.38, 1.7)),), free=True),
    "floor_lamp": alone("floor_lamp", (0.4, 0.4, 1.6), corner=1.0),
    "island": Group((Member("kitchen_island", (1.4, 0.85, 0.9)),), free=True),
    "laundry_basket": alone("laundry_basket", (0.4, 0.4, 0.6), corner=0.7),
    "low_cabinet": alone("chest_of_drawers", (1.7, 0.48, 0.8), front=0.4),
    "narrow": alone("shelf", (1.1, 0.28, 0.9), corner=0.4),
    "plant": alone("plant", (0.5, 0.5, 1.1), corner=0.8, window=-0.4),
    "printer": alone("filing_cabinet", (0.45, 0.6, 0.72), front=0.4),
    "shelf": alone("shelf", (1.2, 0.4, 1.9), front=0.4, corner=0.4),
    "stool": alone("stool", (0.35, 0.35, 0.45), corner=0.4),
    "wardrobe": alone("wardrobe", (1.5, 0.6, 2.1), front=0.55, corner=0.5),
}


_ONCE = ("desk", "divider", "floor_lamp", "island", "printer")
"""Nobody has two of them in a room."""
_LEAST_AREA = {"divider": 28.0, "island": 12.0}
"""Rooms from which on such a piece makes sense, m²."""


def _fillers(rng: np.random.Generator, site: Site) -> Iterator[Group]:
    """More pieces for a room that is still too empty, in random order."""
    names = [name for name in _FILL[site.kind] if site.area >= _LEAST_AREA.get(name, 0.0)]
    for _ in range(1 + int(site.area / 14.0)):
        yield from (_FILLERS[names[k]] for k in rng.permutation(len(names)))
        names = [name for name in names if name not in _ONCE]


_LITTER: dict[RoomKind, tuple[str, ...]] = {
    "living_room": ("toys", "cable", "box", "pet_bowl"),
    "bedroom": ("toys", "shoes", "cable", "basket", "box"),
    "kitchen": ("pet_bowl", "box", "bin"),
    "bathroom": ("basket", "bin", "stool"),
    "corridor": ("shoes", "shoes", "umbrella", "box"),
    "office": ("cable", "bin", "box", "cable"),
    "storage": ("box", "ironing", "basket"),
    "other": ("toys", "horse", "box", "cable"),
}
_LITTLE = {
    "basket": small("laundry_basket", (0.38, 0.38, 0.55)),
    "bin": small("waste_bin", (0.26, 0.26, 0.4)),
    "box": small("box", (0.4, 0.32, 0.3)),
    "cable": small("cable", (1.2, 0.3, 0.009)),
    "horse": small("clothes_horse", (1.1, 0.55, 1.0), free=True),
    "ironing": small("ironing_board", (1.2, 0.38, 0.9)),
    "pet_bowl": small("pet_bowl", (0.5, 0.25, 0.06)),
    "shoes": small("shoes", (0.26, 0.3, 0.11)),
    "stool": small("stool", (0.33, 0.33, 0.42)),
    "toys": small("toys", (0.5, 0.5, 0.12), free=True),
    "umbrella": small("umbrella_stand", (0.24, 0.24, 0.8)),
}


def _clutter(rng: np.random.Generator, site: Site, habits: Habits) -> Iterator[Group]:
    """What lies about: with full clutter about one thing for every 4 m²."""
    count = int(rng.poisson(habits.clutter * site.area / 4.0)) if habits.clutter > 0.0 else 0
    names = _LITTER[site.kind]
    # Twice the same only where there is more than one of each.
    order = [k for _ in range(3) for k in rng.permutation(len(names))]
    yield from (_LITTLE[names[k]] for k in order[:count])
