"""Fittings: kitchen, bathroom, and what hangs on walls; conventions as `scenes.furniture`."""

from __future__ import annotations

import shapely

from scenes.furniture import cabinet, fronts, handle
from scenes.parts import LEG, Part, Parts, box, disc, legs


def kitchen_counter(w: float, d: float, h: float) -> Parts:
    """Cabinets under a worktop; hob and tap where it is long enough."""
    yield from cabinet(w, d, h - 0.04, 0.12, 0.6)
    yield box((-w / 2, w / 2), (-d / 2 + 0.01, d / 2), (h - 0.04, h), "worktop")
    if w > 1.5:
        hob = (-w / 2 + 0.3, -w / 2 + 0.88)
        yield box(hob, (-0.25, 0.25), (h, h + 0.008), "hob")
        yield disc((w / 2 - 0.5, 0.2), (0.02, 0.02), (h, h + 0.25), "handles", 8)


def wall_cupboard(w: float, d: float, h: float) -> Parts:
    """A cabinet without plinth; its piece says at what elevation it hangs."""
    yield box((-w / 2, w / 2), (-d / 2 + 0.04, d / 2), (0.0, h), "body")
    yield from fronts(w, -d / 2 + 0.02, (0.005, h - 0.005), 0.6)


def fridge(w: float, d: float, h: float) -> Parts:
    """Two doors over a plinth."""
    yield box((-w / 2, w / 2), (-d / 2 + 0.09, d / 2), (0.0, 0.05), "plinth")
    yield box((-w / 2, w / 2), (-d / 2 + 0.07, d / 2), (0.05, h), "body")
    split = 0.35 * h
    for z in ((0.06, split - 0.005), (split + 0.005, h)):
        yield box((-w / 2, w / 2), (-d / 2 + 0.02, -d / 2 + 0.065), z, "body")
        yield box((w / 2 - 0.06, w / 2 - 0.04), (-d / 2, -d / 2 + 0.02), handle(z), "handles")


def toilet(w: float, d: float, h: float) -> Parts:
    """A bowl, a lid and a tank."""
    tank, seat = 0.18, 0.53 * h
    length = d - tank
    y = -d / 2 + length / 2
    yield disc((0, y + 0.05), (0.32 * w, 0.42 * length), (0.0, 0.7 * seat), "ceramic")
    yield disc((0, y), (0.5 * w, 0.5 * length), (0.7 * seat, seat), "ceramic", 20)
    yield disc((0, y), (0.49 * w, 0.49 * length), (seat, seat + 0.03), "lid", 20)
    yield box((-0.25 * w, 0.25 * w), (0, d / 2 - tank), (0.0, seat), "ceramic")
    yield box((-0.5 * w, 0.5 * w), (d / 2 - tank, d / 2), (0.8 * seat, h), "ceramic")


def basin(w: float, d: float, h: float) -> Parts:
    """A bowl on a column."""
    outer, inner = shapely.box(-w / 2, -d / 2, w / 2, d / 2), (-0.38 * w, 0.38 * w)
    bowl = shapely.box(inner[0], -0.4 * d, inner[1], 0.25 * d)
    yield disc((0, 0.2 * d), (0.08, 0.08), (0.0, h - 0.16), "ceramic", 12)
    yield Part(outer, h - 0.16, h - 0.12, "ceramic")
    yield Part(outer.difference(bowl), h - 0.12, h, "ceramic")
    yield disc((0, 0.36 * d), (0.02, 0.02), (h, h + 0.12), "tap", 8)


def bath(w: float, d: float, h: float) -> Parts:
    """A tub with a rim."""
    outer, rim = shapely.box(-w / 2, -d / 2, w / 2, d / 2), 0.07
    if min(w, d) <= 3 * rim:
        raise ValueError("no room inside its rim")
    yield Part(outer, 0.0, 0.14, "ceramic")
    yield Part(outer.difference(outer.buffer(-rim)), 0.14, h, "ceramic")
    yield disc((-w / 2 + 0.035, 0), (0.02, 0.02), (h, h + 0.15), "tap", 8)


def shower_tray(w: float, d: float, h: float) -> Parts:
    """A low tray with the pipe and head of a shower."""
    yield box((-w / 2, w / 2), (-d / 2, d / 2), (0.0, h), "ceramic")
    yield disc((0, d / 2 - 0.05), (0.012, 0.012), (0.9, 2.0), "tap", 8)
    yield disc((0, d / 2 - 0.15), (0.1, 0.1), (2.0, 2.02), "tap", 12)


def washing_machine(w: float, d: float, h: float) -> Parts:
    """A body on feet with a porthole."""
    yield from legs(w, d, 0.02, "body", leg=LEG, inset=0.02)
    yield box((-w / 2, w / 2), (-d / 2 + 0.03, d / 2), (0.02, h), "body")
    door, y = (-0.27 * w, 0.27 * w), (-d / 2, -d / 2 + 0.03)
    yield box(door, y, (0.3 * h, 0.3 * h + 0.54 * w), "door")


def radiator(w: float, d: float, h: float) -> Parts:
    """Hung on the wall, 12 cm above the floor, on one pipe."""
    clear, step = 0.12, 0.08
    count = max(2, int(w / step))
    left = -count * step / 2
    for k in range(count):
        x = (left + k * step + 0.008, left + (k + 1) * step - 0.008)
        yield box(x, (-d / 2, d / 2), (clear, h), "body")
    yield box((left, -left), (-0.02, 0.02), (clear + 0.04, clear + 0.08), "body")
    yield box((left, -left), (-0.02, 0.02), (h - 0.08, h - 0.04), "body")
    pipe = left + step / 2
    yield disc((pipe, d / 2 - 0.02), (0.01, 0.01), (0.0, clear), "body", 8)


def rug(w: float, d: float, h: float) -> Parts:
    """Lower than what counts as an obstacle."""
    yield box((-w / 2, w / 2), (-d / 2, d / 2), (0.0, h), "fabric")


def plant(w: float, d: float, h: float) -> Parts:
    """A pot and layers of leaves."""
    pot = 0.25 * h
    yield disc((0, 0), (0.32 * w, 0.32 * d), (0.0, pot), "pot")
    yield disc((0, 0), (0.29 * w, 0.29 * d), (pot, pot + 0.01), "soil")
    yield disc((0, 0), (0.04 * w, 0.04 * d), (pot + 0.01, 0.5 * h), "stem", 6)
    for k, (radius, top) in enumerate(((0.38, 0.62), (0.5, 0.78), (0.42, 0.9), (0.24, 1.0))):
        low = (0.5, 0.62, 0.78, 0.9)[k] * h
        yield disc((0, 0), (radius * w, radius * d), (low, top * h), "leaves", 7 + k)


def curtain(w: float, d: float, h: float) -> Parts:
    """Folds under a rail, just above the floor."""
    folds = max(2, round(w / 0.12))
    step = w / folds
    for k in range(folds):
        y = (-d / 2, 0.1 * d) if k % 2 else (-0.1 * d, d / 2)
        left = -w / 2 + k * step
        yield box((left, left + step), y, (0.03, h - 0.03), "fabric")
    yield box((-w / 2 - 0.05, w / 2 + 0.05), (-0.01, 0.01), (h - 0.03, h), "rail")


def picture(w: float, d: float, h: float) -> Parts:
    """A framed picture; its piece says at what elevation it hangs."""
    outer = shapely.box(-w / 2, -d / 2, w / 2, d / 2)
    edge = min(0.03, w / 4, h / 4)
    for x in ((-w / 2, -w / 2 + edge), (w / 2 - edge, w / 2)):
        yield box(x, (-d / 2, d / 2), (0.0, h), "frame")
    inner = (-w / 2 + edge, w / 2 - edge)
    for z in ((0.0, edge), (h - edge, h)):
        yield box(inner, (outer.bounds[1], outer.bounds[3]), z, "frame")
    yield box(inner, (0.0, d / 2), (edge, h - edge), "picture")


def floor_lamp(w: float, d: float, h: float) -> Parts:
    """A dark lamp: a foot, a rod and a shade (see `scenes.lamps` for light)."""
    yield disc((0, 0), (0.4 * w, 0.4 * d), (0.0, 0.03), "stand")
    yield disc((0, 0), (0.015, 0.015), (0.03, h - 0.25), "stand", 8)
    yield disc((0, 0), (0.5 * w, 0.5 * d), (h - 0.25, h), "shade", 20)


def whole(w: float, d: float, h: float) -> Parts:
    """A plain box."""
    yield box((-w / 2, w / 2), (-d / 2, d / 2), (0.0, h), "body")
