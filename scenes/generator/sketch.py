"""The division of a home into rooms, on a grid of 10 cm.

A treemap whose hierarchy follows the use of the rooms, after Marson and Musse
(2010): a *hub* (corridor, hall, or the living room of a small home) is laid
out first and the other rooms are slices of bands along it, so that all of them
open to the hub by construction and no bathroom is ever the way to another
room. Slice and dice (Shneiderman 1992) is enough for bands of one row.

Rooms are painted as rectangles one over the other; a room that is painted over
in a corner, or painted twice, becomes L-shaped, and bands of different lengths
give outlines that are no rectangles.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from scenes.apartment import RoomKind
from scenes.generator.programme import MOST_AREA, draw_programme, draw_weights
from scenes.generator.wishes import Brief

__all__ = ["MODULE", "Sketch", "draw_sketch"]

MODULE = 0.1
"""Grid of the sketch, m."""
CONTACT = 1.35
"""Least length that a room shares with the hub between wall centre lines, m."""
Span = tuple[float, float]
Links = list[tuple[int, int]]
SMALL: tuple[RoomKind, ...] = ("bathroom", "storage")

LONGEST = 2.1
"""How many times as long as wide a home may be: longer ones are barracks."""


@dataclass(frozen=True)
class Sketch:
    """Rooms on a grid of `MODULE` m.

    ``labels`` (ny, nx): index of the room in each cell, -1 outside; ``links``:
    pairs of rooms that a doorway must join.
    """

    kinds: tuple[RoomKind, ...]
    labels: NDArray[np.int64]
    links: tuple[tuple[int, int], ...]
    hub: int


@dataclass
class _Canvas:
    """What is painted, in order: room, x0, y0, x1, y1 (m); and what the painting needs."""

    rng: np.random.Generator
    kinds: tuple[RoomKind, ...]
    areas: list[float]
    l_shapes: float
    boxes: list[tuple[int, float, float, float, float]] = field(default_factory=list)

    def paint(self, room: int, x: Span, y: Span) -> None:
        self.boxes.append((room, min(x), min(y), max(x), max(y)))

    def area(self, rooms: Sequence[int]) -> float:
        return sum(self.areas[room] for room in rooms)

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def between(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def labels(self) -> NDArray[np.int64]:
        corners = np.round(np.array(self.boxes)[:, 1:] / MODULE).astype(int)
        corners -= np.tile(corners.min(axis=0)[:2], 2)
        nx, ny = corners.max(axis=0)[2:]
        labels = np.full((ny, nx), -1)
        for (room, *_), (x0, y0, x1, y1) in zip(self.boxes, corners, strict=True):
            labels[y0:y1, x0:x1] = room
        return labels


def draw_sketch(rng: np.random.Generator, brief: Brief) -> Sketch | None:
    """One random sketch; None if its pieces did not fit together or make too long a home."""
    kinds = draw_programme(rng, brief)
    weights = draw_weights(rng, kinds)
    # Walls take about an eighth of a home, a corridor about a tenth.
    gross = brief.area * (1.03 if "corridor" in kinds else 1.13) / sum(weights)
    areas = [
        min(gross * weight, MOST_AREA.get(kind, np.inf))
        for kind, weight in zip(kinds, weights, strict=True)
    ]
    canvas = _Canvas(rng, kinds, areas, brief.l_shapes)
    if "corridor" not in kinds:
        links = _around_living(canvas)
    elif brief.layout == "hub" and brief.rooms <= 9:
        links = _around_hall(canvas)
    else:
        links = _along_corridor(canvas, brief)
    if links is None:
        return None
    labels = canvas.labels()
    if max(labels.shape) > LONGEST * min(labels.shape):
        return None
    labels = np.rot90(labels, int(rng.integers(4)))
    labels = labels[:, ::-1] if rng.random() < 0.5 else labels
    hub = 1 if "corridor" in kinds else 0
    return Sketch(kinds, np.ascontiguousarray(labels), tuple(links), hub)


# ---- bands of rooms along a hub ---------------------------------------------------------------


def _cuts(canvas: _Canvas, rooms: Sequence[Sequence[int]], span: Span) -> Iterator[Span]:
    """Slices of a span in proportion to the areas of groups of rooms, m."""
    areas = [canvas.area(group) for group in rooms]
    shares = np.cumsum([0.0, *areas]) / sum(areas)
    yield from pairwise((span[0] + (span[1] - span[0]) * shares).tolist())


def _fill_band(canvas: _Canvas, rooms: Sequence[int], span: Span, depth: Span) -> None:
    """Slice a band along x into rooms; ``depth`` is y at the hub and at the facade.

    A small room may take only the corner of a larger one's slice at the hub;
    the larger one then wraps around it to the facade.
    """
    groups = _niches(canvas, rooms)
    for group, part in zip(groups, _cuts(canvas, groups, span), strict=True):
        canvas.paint(group[0], part, depth)
        if len(group) == 2:
            _niche(canvas, group, part, depth)


def _niches(canvas: _Canvas, rooms: Sequence[int]) -> list[list[int]]:
    """Rooms of a band one by one, or a large and a small neighbour that it wraps around."""
    groups: list[list[int]] = []
    for room in rooms:
        pair = [*groups[-1], room] if groups else [room]
        small = [other for other in pair if canvas.kinds[other] in SMALL]
        if len(pair) == 2 and len(small) == 1 and canvas.chance(canvas.l_shapes):
            groups[-1] = sorted(pair, key=lambda other: canvas.kinds[other] in SMALL)
        else:
            groups.append([room])
    return groups


def _niche(canvas: _Canvas, group: Sequence[int], span: Span, depth: Span) -> None:
    """Paint a small room into a corner at the hub; a plain slice if an arm became too thin."""
    width, deep = span[1] - span[0], abs(depth[1] - depth[0])
    share = canvas.areas[group[1]] / canvas.area(group)
    reach = canvas.between(0.42, 0.62)
    if (1.0 - reach) * deep < 1.6 or (1.0 - share / reach) * width < 1.5 or reach * deep < 1.65:
        reach = 1.0
    own = share / reach * width
    x = (span[0], span[0] + own) if canvas.chance(0.5) else (span[1] - own, span[1])
    canvas.paint(group[1], x, (depth[0], depth[0] + reach * (depth[1] - depth[0])))


def _split(canvas: _Canvas, rooms: Sequence[int]) -> list[list[int]]:
    """Two bands of about the same area, each in random order."""
    bands: list[list[int]] = [[], []]
    for room in sorted(rooms, key=lambda room: -canvas.areas[room] * canvas.between(0.8, 1.25)):
        min(bands, key=canvas.area).append(room)
    for band in bands:
        canvas.rng.shuffle(band)
    return bands if canvas.chance(0.5) else bands[::-1]


def _column(canvas: _Canvas, rooms: Sequence[int], x: Span, y: Span) -> None:
    """Rooms one above the other."""
    groups = [[room] for room in rooms]
    if groups:
        for room, part in zip(rooms, _cuts(canvas, groups, y), strict=True):
            canvas.paint(room, x, part)


# ---- the three families -----------------------------------------------------------------------


def _around_living(canvas: _Canvas) -> Links | None:
    """Small homes: rooms in a band above the living room, more of them to its left."""
    others = list(range(1, len(canvas.kinds)))
    living = canvas.areas[0]
    if not others:
        aspect = canvas.between(1.0, 1.5)
        canvas.paint(
            0, (0.0, float(np.sqrt(living * aspect))), (0.0, float(np.sqrt(living / aspect)))
        )
        return []
    above, left = others, []
    if len(others) > 2:
        canvas.rng.shuffle(others)
        count = 1 if len(others) == 3 or canvas.chance(0.5) else 2
        above, left = others[count:], others[:count]
    band = canvas.area(above)
    width = float(np.sqrt((living + band) * canvas.between(0.8, 1.6)))
    shorter = max(canvas.between(0.5, 0.8) * width, CONTACT * len(above))
    length = min(width, shorter) if canvas.chance(max(canvas.l_shapes, 0.2)) else width
    # What a short band leaves is the living room's, or outside.
    wraps = length < width and canvas.chance(min(1.0, 5.0 * canvas.l_shapes))
    depth = band / length
    own = (living - (width - length) * depth if wraps else living) / width
    if own < 2.2:
        return None
    canvas.paint(0, (0.0, width), (0.0, own + depth if wraps else own))
    _fill_band(canvas, above, (0.0, length), (own, own + depth))
    _column(canvas, left, (-canvas.area(left) / own, 0.0), (0.0, own))
    return [(0, room) for room in others]


def _around_hall(canvas: _Canvas) -> Links | None:
    """A hall at the front, a column of rooms on either side, the living room behind it."""
    rear, others = _social_rooms(canvas, list(range(2, len(canvas.kinds))), 0.6)
    left, right = _split(canvas, others)
    most = max(len(left), len(right))
    if most > 4 or not left:
        return None
    wide = canvas.between(1.7, 2.6)
    deep = max(2.6, most * canvas.between(1.9, 2.9))
    # A right column that reaches into the rear leaves the living room an L.
    bite = canvas.between(1.0, 2.0) if right and canvas.chance(canvas.l_shapes) else 0.0
    a, b = canvas.area(left) / deep, canvas.area(right) / (deep + bite)
    x, own = (-a, wide + b), canvas.area(rear) + bite * b
    top = deep
    if own / (a + wide + b) < 3.0:
        # The left column runs to the rear facade, the living room lies beside it.
        x, top = (0.0, wide + b), deep + own / (wide + b)
        a = canvas.area(left) / top
    back = own / (x[1] - x[0])
    canvas.paint(1, (0.0, wide), (0.0, deep))
    _column(canvas, left, (-a, 0.0), (0.0, top))
    _rear(canvas, rear, x, (deep, deep + back), left=bite > 0.0 or a > b)
    _column(canvas, right, (wide, wide + b), (0.0, deep + bite))
    return [*((1, room) for room in (0, *left, *right)), *((0, room) for room in rear[1:])]


def _social_rooms(canvas: _Canvas, others: list[int], share: float) -> tuple[list[int], list[int]]:
    """Living room, with that chance the kitchen with it; and the rooms that are left."""
    kitchens = [room for room in others if canvas.kinds[room] == "kitchen"]
    if not kitchens or not canvas.chance(share):
        return [0], others
    return [0, kitchens[0]], [room for room in others if room != kitchens[0]]


def _rear(canvas: _Canvas, rooms: Sequence[int], x: Span, y: Span, *, left: bool) -> None:
    """Living room behind the hall, the kitchen at the end of it that is farther from the hall."""
    canvas.paint(rooms[0], x, y)
    if len(rooms) == 2:
        own = canvas.areas[rooms[1]] / canvas.area(rooms) * (x[1] - x[0])
        canvas.paint(rooms[1], (x[0], x[0] + own) if left else (x[1] - own, x[1]), y)


@dataclass(frozen=True)
class _Bands:
    """One or two bands along a corridor of that width: rooms, lengths and depths, m."""

    rooms: list[list[int]]
    lengths: list[float]
    depths: list[float]
    across: float
    stepped: bool


def _along_corridor(canvas: _Canvas, brief: Brief) -> Links | None:
    """A corridor with one or two bands of rooms; the living room at its end or in a band."""
    share = 1.0 if brief.layout == "open" else 0.25
    social, others = _social_rooms(canvas, list(range(2, len(canvas.kinds))), share)
    if len(social) == 1 and len(others) >= 4 and canvas.chance(0.3):
        social, others = [], [0, *others]
    bands = _bands(canvas, others, broad=brief.layout == "hub")
    extension = _extension(canvas, social, bands)
    length = max(bands.lengths[0] + extension, *bands.lengths)
    canvas.paint(1, (0.0, length), (0.0, bands.across))
    for k, (rooms, long, deep) in enumerate(
        zip(bands.rooms, bands.lengths, bands.depths, strict=True)
    ):
        near, far = (0.0, -deep) if k else (bands.across, bands.across + deep)
        start = 0.0 if k else extension
        _fill_band(canvas, rooms, (start, start + long), (near, far))
    if not bands.stepped and not extension and canvas.chance(canvas.l_shapes):
        _wrap_end(canvas, bands.rooms[0][-1], length, bands.across)
    if social and not _across_end(canvas, social, bands, extension):
        return None
    banded = [room for band in bands.rooms for room in band if room]
    return [*((1, room) for room in (0, *banded)), *((0, room) for room in social[1:])]


def _bands(canvas: _Canvas, rooms: list[int], *, broad: bool) -> _Bands:
    """Divide rooms into bands of about square rooms; of one length unless stepped."""
    bands = [rooms] if len(rooms) < 3 else _split(canvas, rooms)
    # The kitchen comes next to the living room's end.
    bands = [sorted(band, key=lambda room: canvas.kinds[room] != "kitchen") for band in bands]
    across = canvas.between(1.9, 2.3) if broad else canvas.between(1.2, 1.65)
    mean = [canvas.area(band) / len(band) for band in bands]
    depths = [float(np.sqrt(area * canvas.between(0.95, 1.55))) for area in mean]
    lengths = [canvas.area(band) / depth for band, depth in zip(bands, depths, strict=True)]
    stepped = canvas.chance(0.3)
    if not stepped or max(lengths) - min(lengths) < 1.2:
        whole = sum(map(canvas.area, bands)) / sum(depths)
        lengths = [whole] * len(bands)
        depths = [canvas.area(band) / whole for band in bands]
    return _Bands(bands, lengths, depths, across, stepped)


def _extension(canvas: _Canvas, social: Sequence[int], bands: _Bands) -> float:
    """How far the living room reaches along the first band, m; 0: it does not."""
    fits = social and len(social) <= len(bands.rooms) and bands.depths[0] >= 2.7
    if not fits or not canvas.chance(canvas.l_shapes):
        return 0.0
    most = 0.45 * canvas.areas[0] / bands.depths[0]
    return canvas.between(1.6, most) if most > 1.6 else 0.0


def _wrap_end(canvas: _Canvas, last: int, length: float, across: float) -> None:
    """Give the corridor's end to the last room of the first band, which becomes L-shaped."""
    boxes = {room: box for room, *box in canvas.boxes}
    starts = [boxes[room][0] for room in boxes if room != 1 and boxes[room][2] >= length - 1e-9]
    first = max(starts) + CONTACT
    if length - first >= 1.5 and canvas.kinds[last] not in SMALL:
        canvas.paint(last, (canvas.between(first, length - 1.5), length), (0.0, across))


def _across_end(canvas: _Canvas, rooms: Sequence[int], bands: _Bands, extension: float) -> bool:
    """Living room, and maybe kitchen, across the corridor's end; whether they fit."""
    low = -bands.depths[1] if len(bands.rooms) == 2 else 0.0
    high = top = bands.across + bands.depths[0]
    if bands.stepped and not extension:
        low += canvas.between(-1.5, 1.0) if low < 0.0 else 0.0
        high += canvas.between(-1.0, 1.5)
    own = canvas.area(rooms) - extension * bands.depths[0]
    if bands.stepped and own / (high - low) < 2.9:
        high = max(bands.across + 1.2, low + own / 3.2)
    side = own / (high - low)
    canvas.paint(0, (-side, 0.0), (low, high))
    if extension:
        canvas.paint(0, (0.0, extension), (bands.across, top))
    if len(rooms) == 2:
        part = canvas.areas[rooms[1]] / own * (high - low)
        above = not extension and high - part >= bands.across + 0.1
        ends = (high - part, high) if above else (low, low + part)
        canvas.paint(rooms[1], (-side, 0.0), ends)
        # The corridor must end at the living room, not at the kitchen.
        return side >= 2.7 and (ends[0] >= bands.across + 0.1 or ends[1] <= -0.1)
    return side >= 2.7
