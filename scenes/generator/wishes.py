"""What may be asked of a generated apartment, and what is drawn where nothing is asked."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any, Literal, get_args

import numpy as np

from scenes.errors import SceneError

__all__ = ["Brief", "Contrast", "Layout", "Source", "Wishes", "draw_brief"]

Contrast = Literal["low", "medium", "high"]
Source = Literal["interior", "exterior", "mixed"]
Layout = Literal["corridor", "hub", "open"]

MAX_ROOMS = 12
MAX_STEPS = 6
AREA_PER_ROOM = (5.0, 30.0)
"""Clear floor per room that may be asked for, m²; below 9 not every plan is found."""
USUAL_AREA = (9.5, 21.0)
"""Clear floor per room where the area is drawn, m²."""
LEAST_ROOMS = {"corridor": 4, "hub": 1, "open": 3}
"""Rooms without which a layout makes no sense."""
COUNTS = (0, 1, 8, 14, 18, 18, 15, 11, 7, 4, 2, 1.5, 1)
"""How often homes have that many rooms (index), bathroom and corridor counted."""


@dataclass(frozen=True)
class Wishes:
    """What is asked for; ``None`` is drawn from the seed, a pair is a range to draw from.

    The fields are those of `scenes.generator.generate_apartment`.

    Raises
    ------
    SceneError
        If a value is outside its range: one line with the field, its value and
        what would be right.
    """

    rooms: int | tuple[int, int] | None = None
    area: float | tuple[float, float] | None = None
    layout: Layout | None = None
    wide_share: float | None = None
    contrast: Contrast | None = None
    lighting: Source | None = None
    clutter: float | None = None
    ceiling_steps: int | None = None
    l_shapes: float | None = None

    def __post_init__(self) -> None:
        for problem in self._problems():
            raise SceneError(problem)

    def tag(self) -> str:
        """Eight hexadecimal digits that tell different wishes apart; empty if there are none."""
        asked = {name: value for name, value in asdict(self).items() if value is not None}
        if not asked:
            return ""
        # As text of numbers of one type: 40 and 40.0 ask for the same.
        plain = {
            name: value if isinstance(value, str) else np.array(value, dtype=float).tolist()
            for name, value in asked.items()
        }
        text = json.dumps(plain, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:8]

    def _problems(self) -> Iterator[str]:
        for value in _ends(self.rooms):
            if not _whole(value) or not 1 <= value <= MAX_ROOMS:
                yield f"rooms: {self.rooms!r}; expected a whole number from 1 to {MAX_ROOMS}"
        yield from self._area_problems()
        yield from self._range_problems()
        yield from self._choice_problems()
        for name in ("wide_share", "clutter", "l_shapes"):
            value = getattr(self, name)
            if value is not None and not (_number(value) and 0.0 <= value <= 1.0):
                yield f"{name}: {value!r}; expected a number from 0 to 1"
        steps = self.ceiling_steps
        if steps is not None and not (_whole(steps) and 0 <= steps <= MAX_STEPS):
            yield f"ceiling_steps: {steps!r}; expected a whole number from 0 to {MAX_STEPS}"

    def _range_problems(self) -> Iterator[str]:
        for name in ("rooms", "area"):
            ends = _ends(getattr(self, name))
            if len(ends) == 2 and not ends[0] <= ends[1]:
                yield f"{name}: {getattr(self, name)!r}; expected the smaller value first"

    def _choice_problems(self) -> Iterator[str]:
        for name, known in (("layout", Layout), ("contrast", Contrast), ("lighting", Source)):
            value = getattr(self, name)
            if value is not None and value not in get_args(known):
                yield f"{name}: {value!r}; expected {', '.join(get_args(known))}"
        most = max(_ends(self.rooms), default=MAX_ROOMS)
        if self.layout is not None and most < LEAST_ROOMS[self.layout]:
            yield (
                f"layout: {self.layout!r} with rooms: {self.rooms!r}; expected at least "
                f"{LEAST_ROOMS[self.layout]} rooms"
            )

    def _area_problems(self) -> Iterator[str]:
        rooms = _ends(self.rooms) or (1, MAX_ROOMS)
        least, most = AREA_PER_ROOM[0] * min(rooms), AREA_PER_ROOM[1] * max(rooms)
        for value in _ends(self.area):
            if not _number(value) or not least <= value <= most:
                asked = "" if self.rooms is None else f" for rooms: {self.rooms!r}"
                yield f"area: {self.area!r}; expected {least:g} to {most:g} m²{asked}"


@dataclass(frozen=True)
class Brief:
    """What one apartment shall be like, all of it decided."""

    rooms: int
    area: float
    layout: Layout
    wide_share: float
    contrast: Contrast
    lighting: Source
    clutter: float
    ceiling_steps: int
    l_shapes: float


def draw_brief(rng: np.random.Generator, wishes: Wishes) -> Brief:
    """Decide what the wishes leave open.

    Everything is drawn whether it is needed or not, so that asking for one
    thing leaves the others of the same seed as they were.
    """
    chance = rng.random(4)
    count = _draw_rooms(chance[0], wishes)
    area = _draw_area(chance[1], rng.normal(), wishes, count)
    layouts = [name for name in get_args(Layout) if count >= LEAST_ROOMS[name]]
    layout = layouts[int(chance[2] * len(layouts))]
    wide, clutter, l_shapes = rng.beta([1.2, 1.6, 1.6], [2.5, 1.6, 1.0])
    contrast = get_args(Contrast)[int(rng.integers(3))]
    lighting = get_args(Source)[int(rng.integers(3))]
    steps = min(int(rng.poisson(0.25 + 0.06 * count)), MAX_STEPS)
    drawn = {
        "layout": layout,
        "wide_share": round(float(wide), 3),
        "contrast": contrast,
        "lighting": lighting,
        "clutter": round(float(clutter), 3),
        "ceiling_steps": steps,
        "l_shapes": round(float(l_shapes), 3),
    }
    asked = {name: value for name in drawn if (value := getattr(wishes, name)) is not None}
    return Brief(rooms=count, area=area, **{**drawn, **asked})


def _draw_rooms(chance: float, wishes: Wishes) -> int:
    """Room count: as asked, from the range asked for, or one that suits the area."""
    low, *high = _ends(wishes.rooms) or (2, MAX_ROOMS)
    counts = np.arange(low, max([low, *high]) + 1)
    if wishes.layout is not None:
        counts = counts[counts >= LEAST_ROOMS[wishes.layout]]
    usual = counts
    if areas := _ends(wishes.area):
        # Any count whose usual area meets the range; all of them if none does.
        low_area, high_area = USUAL_AREA[0] * counts, USUAL_AREA[1] * counts
        usual = counts[(low_area <= max(areas)) & (high_area >= min(areas))]
        usual = usual if len(usual) else counts[[np.abs(13.0 * counts - areas[0]).argmin()]]
    weight = np.cumsum(np.array(COUNTS, dtype=float)[usual])
    return int(usual[min(np.searchsorted(weight, chance * weight[-1]), len(usual) - 1)])


def _draw_area(chance: float, normal: float, wishes: Wishes, rooms: int) -> float:
    """Clear floor, m²: as asked, or about 12.5 m² per room, more in small homes."""
    ends = _ends(wishes.area)
    if len(ends) == 1:
        return float(ends[0])
    low, high = USUAL_AREA[0] * rooms, USUAL_AREA[1] * rooms
    if ends:
        low, high = (min(max(value, low), high) for value in ends)
        low, high = (min(max(value, ends[0]), ends[1]) for value in (low, high))
        return float(round(low + chance * (high - low), 1))
    usual = (12.2 + 3.0 / rooms) * rooms * math.exp(0.17 * normal)
    return float(round(min(max(usual, low), high), 1))


def _ends(value: Any) -> tuple[Any, ...]:
    """The one value, the two ends of a range, or nothing."""
    if value is None:
        return ()
    return value if isinstance(value, tuple) and len(value) == 2 else (value,)


def _number(value: Any) -> bool:
    known = isinstance(value, int | float | np.integer | np.floating)
    return known and not isinstance(value, bool) and math.isfinite(value)


def _whole(value: Any) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)
