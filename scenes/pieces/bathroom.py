"""Bathroom; conventions as `scenes.pieces`."""

from __future__ import annotations

import shapely

from scenes.parts import Part, Parts, cuboid, cylinder, four_legs, plate
from scenes.pieces.cabinets import doors


def toilet(
    w: float = 0.38,
    d: float = 0.66,
    h: float = 0.8,
    *,
    ceramic: str = "ceramic",
    lid: str = "plastic_white",
) -> Parts:
    """A bowl, a lid and a tank."""
    tank, seat = 0.18, 0.53 * h
    length = d - tank
    y = -d / 2 + length / 2
    yield cylinder((0, y + 0.05), (0.32 * w, 0.42 * length), (0.0, 0.7 * seat), ceramic)
    yield cylinder((0, y), (0.5 * w, 0.5 * length), (0.7 * seat, seat), ceramic, 20)
    yield cylinder((0, y), (0.49 * w, 0.49 * length), (seat, seat + 0.03), lid, 20)
    yield cuboid((-0.25 * w, 0.25 * w), (0, d / 2 - tank), (0.0, seat), ceramic)
    yield cuboid((-0.5 * w, 0.5 * w), (d / 2 - tank, d / 2), (0.8 * seat, h), ceramic)


def basin(
    w: float = 0.6,
    d: float = 0.48,
    h: float = 0.86,
    *,
    ceramic: str = "ceramic",
    tap: str = "metal",
) -> Parts:
    """A bowl on a column."""
    outer, inner = shapely.box(-w / 2, -d / 2, w / 2, d / 2), (-0.38 * w, 0.38 * w)
    bowl = shapely.box(inner[0], -0.4 * d, inner[1], 0.25 * d)
    yield cylinder((0, 0.2 * d), (0.08, 0.08), (0.0, h - 0.16), ceramic, 12)
    yield Part(outer, h - 0.16, h - 0.12, ceramic)
    yield Part(outer.difference(bowl), h - 0.12, h, ceramic)
    yield cylinder((0, 0.36 * d), (0.02, 0.02), (h, h + 0.12), tap, 8)


def vanity(
    w: float = 0.9,
    d: float = 0.48,
    h: float = 0.85,
    *,
    body: str = "lacquer_white",
    fronts: str = "wood",
    handles: str = "metal",
    ceramic: str = "ceramic",
) -> Parts:
    """A basin over a cabinet that hangs on the wall; the robot drives under it."""
    low, front = 0.4 * h, -d / 2 + 0.02
    yield cuboid((-0.49 * w, 0.49 * w), (front + 0.02, d / 2), (low, h - 0.1), body)
    yield from doors(0.98 * w, front, (low + 0.005, h - 0.105), 0.45, materials=(fronts, handles))
    outer = shapely.box(-w / 2, -d / 2, w / 2, d / 2)
    bowl = shapely.box(-0.36 * w, -0.38 * d, 0.36 * w, 0.22 * d)
    yield Part(outer, h - 0.1, h - 0.08, ceramic)
    yield Part(outer.difference(bowl), h - 0.08, h, ceramic)
    yield cylinder((0, 0.34 * d), (0.02, 0.02), (h, h + 0.14), handles, 8)
    spout = (0.12 * d, 0.34 * d - 0.02)
    yield cuboid((-0.012, 0.012), spout, (h + 0.115, h + 0.14), handles)


def bath(
    w: float = 1.7,
    d: float = 0.75,
    h: float = 0.56,
    *,
    ceramic: str = "ceramic",
    tap: str = "metal",
) -> Parts:
    """A tub with a rim."""
    outer, rim = shapely.box(-w / 2, -d / 2, w / 2, d / 2), 0.07
    if min(w, d) <= 3 * rim:
        raise ValueError("no room inside its rim")
    yield Part(outer, 0.0, 0.14, ceramic)
    yield Part(outer.difference(outer.buffer(-rim)), 0.14, h, ceramic)
    yield cylinder((-w / 2 + 0.035, 0), (0.02, 0.02), (h, h + 0.15), tap, 8)


def shower_tray(
    w: float = 0.9, d: float = 0.9, h: float = 0.05, *, ceramic: str = "ceramic", tap: str = "metal"
) -> Parts:
    """A low tray with the pipe and head of a shower."""
    yield plate(w, d, (0.0, h), ceramic)
    yield cylinder((0, d / 2 - 0.05), (0.012, 0.012), (0.9, 2.0), tap, 8)
    yield cuboid((-0.01, 0.01), (d / 2 - 0.038, d / 2), (0.95, 0.97), tap)
    yield cylinder((0, d / 2 - 0.15), (0.1, 0.1), (2.0, 2.02), tap, 12)


def shower_cabin(
    w: float = 0.9,
    d: float = 0.9,
    h: float = 2.0,
    *,
    ceramic: str = "ceramic",
    glass: str = "glass",
    frame: str = "metal",
) -> Parts:
    """A tray for a corner (walls at the back and on the left), glass walls, pipe and head."""
    pane, post, tray = 0.008, 0.03, 0.06
    yield plate(w, d, (0.0, tray), ceramic)
    for left, front in ((-w / 2, -d / 2), (w / 2 - post, -d / 2), (w / 2 - post, d / 2 - post)):
        yield cuboid((left, left + post), (front, front + post), (tray, h - post), frame)
    yield cuboid((-w / 2, w / 2), (-d / 2, -d / 2 + post), (h - post, h), frame)
    yield cuboid((w / 2 - post, w / 2), (-d / 2 + post, d / 2), (h - post, h), frame)
    middle = (post - pane) / 2
    y = (-d / 2 + middle, -d / 2 + middle + pane)
    yield cuboid((-w / 2 + post, w / 2 - post), y, (tray, h - post), glass)
    x = (w / 2 - middle - pane, w / 2 - middle)
    yield cuboid(x, (-d / 2 + post, d / 2 - post), (tray, h - post), glass)
    yield cuboid((-0.2, -0.176), (d / 2 - 0.03, d / 2), (1.0, h), frame)
    yield cylinder((-0.188, d / 2 - 0.13), (0.1, 0.1), (h - 0.03, h - 0.01), frame, 12)


def towel_radiator(
    w: float = 0.5,
    d: float = 0.1,
    h: float = 1.2,
    *,
    body: str = "lacquer_white",
    towel: str = "fabric_white",
) -> Parts:
    """A ladder of pipes on the wall, 12 cm above the floor, with a towel."""
    clear, tube = 0.12, 0.03
    for x in (-w / 2, w / 2 - tube):
        yield cuboid((x, x + tube), (0.0, tube), (clear, h), body)
        yield cuboid((x, x + tube), (tube, d / 2), (h - 0.15, h - 0.12), body)
        yield cylinder((x + tube / 2, tube / 2), (0.01, 0.01), (0.0, clear), body, 8)
    inner, rungs = (-w / 2 + tube, w / 2 - tube), max(4, round((h - clear) / 0.09))
    for z in (clear + (k + 0.5) * (h - clear) / rungs for k in range(rungs)):
        yield cuboid(inner, (0.005, 0.025), (z - 0.01, z + 0.01), body)
    yield cuboid((-0.35 * w, 0.35 * w), (-0.03, 0.005), (0.45 * h, 0.85 * h), towel)


def laundry_basket(
    w: float = 0.4, d: float = 0.4, h: float = 0.6, *, body: str = "wicker", lid: str = "wood_light"
) -> Parts:
    """A round basket with a lid."""
    yield cylinder((0, 0), (0.46 * w, 0.46 * d), (0.0, h - 0.03), body, 20)
    yield cylinder((0, 0), (0.5 * w, 0.5 * d), (h - 0.03, h), lid, 20)


def clothes_horse(
    w: float = 1.1,
    d: float = 0.55,
    h: float = 1.0,
    *,
    frame: str = "metal",
    laundry: str = "fabric_white",
) -> Parts:
    """Thin legs, lines and some laundry."""
    yield from four_legs(w, d, h, frame, leg=0.018)
    inner, across = (-w / 2 + 0.018, w / 2 - 0.018), (-d / 2 + 0.018, d / 2 - 0.018)
    for x in (-w / 2, w / 2 - 0.018):
        yield cuboid((x, x + 0.018), across, (h - 0.018, h), frame)
    lines = 7
    ys = [
        across[0] + 0.004 + k * (across[1] - across[0] - 0.012) / (lines - 1) for k in range(lines)
    ]
    for y in ys:
        yield cuboid(inner, (y, y + 0.004), (h - 0.012, h - 0.008), frame)
    for k, y in enumerate(ys[1::2]):
        span = ((-0.4 + 0.25 * k) * w, (-0.12 + 0.25 * k) * w)
        yield cuboid(
            span, (y + 0.004, y + 0.01), ((0.35, 0.55, 0.45)[k % 3] * h, h - 0.008), laundry
        )
