"""Kitchen and household machines; conventions as `scenes.pieces`."""

from __future__ import annotations

import shapely

from scenes.parts import LEG, Part, Parts, Span, cuboid, cylinder, four_legs, plate
from scenes.pieces.cabinets import cabinet, carcass, doors, drawers, handle


def kitchen_counter(
    w: float = 2.4,
    d: float = 0.62,
    h: float = 0.9,
    *,
    worktop: str = "stone",
    hob: str = "glass_dark",
    body: str = "lacquer_white",
    fronts: str = "lacquer_white",
    handles: str = "metal",
) -> Parts:
    """Cabinets under a worktop; hob, sink and tap where it is longer than 1.5 m."""
    yield from cabinet(w, d, h - 0.04, 0.12, 0.6, materials=(body, fronts, handles))
    top = shapely.box(-w / 2, -d / 2 + 0.01, w / 2, d / 2)
    if w > 1.5:
        half = min(0.25, d / 2 - 0.02)
        yield cuboid((-w / 2 + 0.3, -w / 2 + 0.88), (-half, half), (h, h + 0.008), hob)
        bowl = shapely.box(w / 2 - 0.72, -0.8 * half, w / 2 - 0.28, 0.5 * half)
        yield Part(bowl, h - 0.04, h - 0.035, handles)
        top = top.difference(bowl)
        yield cylinder((w / 2 - 0.5, 0.2), (0.02, 0.02), (h, h + 0.25), handles, 8)
    yield Part(top, h - 0.04, h, worktop)


def kitchen_sink(
    w: float = 1.2,
    d: float = 0.62,
    h: float = 0.9,
    *,
    worktop: str = "stone",
    sink: str = "metal",
    body: str = "lacquer_white",
    fronts: str = "lacquer_white",
    handles: str = "metal",
) -> Parts:
    """A counter with a sunken bowl, a draining board and a tap."""
    yield from cabinet(w, d, h - 0.16, 0.12, 0.6, materials=(body, fronts, handles))
    outer = shapely.box(-w / 2, -d / 2 + 0.01, w / 2, d / 2)
    bowl = shapely.box(-0.4 * w, -0.32 * d, 0.02 * w, 0.25 * d)
    yield Part(outer.difference(bowl.buffer(0.006, join_style="mitre")), h - 0.16, h, worktop)
    yield Part(bowl.buffer(0.006, join_style="mitre").difference(bowl), h - 0.155, h, sink)
    yield Part(bowl.buffer(0.006, join_style="mitre"), h - 0.16, h - 0.155, sink)
    for k in range(6):
        y = -0.28 * d + k * 0.09 * d
        yield cuboid((0.08 * w, 0.4 * w), (y, y + 0.03 * d), (h, h + 0.006), sink)
    yield cylinder((-0.19 * w, 0.34 * d), (0.02, 0.02), (h, h + 0.26), sink, 8)
    spout = (0.05 * d, 0.34 * d - 0.02)
    yield cuboid((-0.19 * w - 0.012, -0.19 * w + 0.012), spout, (h + 0.235, h + 0.26), sink)


def kitchen_island(
    w: float = 1.6,
    d: float = 0.9,
    h: float = 0.9,
    *,
    worktop: str = "stone",
    body: str = "lacquer_white",
    fronts: str = "wood",
    handles: str = "metal",
) -> Parts:
    """Cabinets to the front under a worktop that stands over at the back, for stools."""
    deep = 0.68 * d
    back = -d / 2 + deep
    yield cuboid((-w / 2 + 0.06, w / 2 - 0.06), (-d / 2 + 0.1, back - 0.05), (0.0, 0.1), body)
    yield cuboid((-w / 2 + 0.02, w / 2 - 0.02), (-d / 2 + 0.05, back), (0.1, h - 0.04), body)
    yield from doors(w - 0.04, -d / 2 + 0.03, (0.105, h - 0.045), 0.55, materials=(fronts, handles))
    yield plate(w, d, (h - 0.04, h), worktop)


def cooker(
    w: float = 0.6,
    d: float = 0.6,
    h: float = 0.9,
    *,
    body: str = "lacquer_white",
    hob: str = "glass_dark",
    knobs: str = "metal",
) -> Parts:
    """Hob and oven in one, with a drawer below."""
    front = -d / 2 + 0.03
    yield cuboid((-w / 2, w / 2), (front + 0.04, d / 2), (0.0, 0.08), body)
    yield cuboid((-w / 2, w / 2), (front, d / 2), (0.08, h - 0.02), body)
    yield from _oven(w, front, (0.28 * h, 0.8 * h), hob, knobs)
    for k in range(5):
        x = (-0.32 + 0.16 * k) * w
        dial = (0.9 * h - 0.02, 0.9 * h + 0.02)
        yield cuboid((x - 0.02, x + 0.02), (front - 0.025, front), dial, knobs)
    yield cuboid((-w / 2, w / 2), (-d / 2 + 0.01, d / 2), (h - 0.02, h - 0.008), knobs)
    yield cuboid((-0.46 * w, 0.46 * w), (-0.42 * d, 0.44 * d), (h - 0.008, h), hob)


def _oven(w: float, front: float, z: Span, glass: str, bar: str) -> Parts:
    """Oven door with a bar across its top before the face at ``front``."""
    yield cuboid((-0.46 * w, 0.46 * w), (front - 0.015, front), z, glass)
    high = z[1] - 0.06
    yield cuboid((-0.38 * w, 0.38 * w), (front - 0.03, front - 0.015), (high, high + 0.02), bar)


def oven_tower(
    w: float = 0.6,
    d: float = 0.62,
    h: float = 2.1,
    *,
    body: str = "lacquer_white",
    fronts: str = "lacquer_white",
    oven: str = "glass_dark",
    handles: str = "metal",
) -> Parts:
    """A tall cabinet with two ovens at the height of one's hands."""
    front = -d / 2 + 0.03
    yield from carcass(w, d, h, 0.1, body)
    yield from drawers(w, front - 0.01, (0.105, 0.3 * h), 2, materials=(fronts, handles))
    for z in ((0.31 * h, 0.5 * h), (0.52 * h, 0.69 * h)):
        yield from _oven(w, front + 0.01, z, oven, handles)
    yield from doors(w, front - 0.01, (0.71 * h, h - 0.005), 0.6, materials=(fronts, handles))


def fridge(
    w: float = 0.6,
    d: float = 0.66,
    h: float = 1.8,
    *,
    body: str = "lacquer_white",
    plinth: str = "plastic_black",
    handles: str = "metal",
) -> Parts:
    """Two doors over a plinth."""
    yield cuboid((-w / 2, w / 2), (-d / 2 + 0.09, d / 2), (0.0, 0.05), plinth)
    yield cuboid((-w / 2, w / 2), (-d / 2 + 0.07, d / 2), (0.05, h), body)
    split = 0.35 * h
    for z in ((0.06, split - 0.005), (split + 0.005, h)):
        yield cuboid((-w / 2, w / 2), (-d / 2 + 0.02, -d / 2 + 0.065), z, body)
        yield cuboid((w / 2 - 0.06, w / 2 - 0.04), (-d / 2, -d / 2 + 0.02), handle(z), handles)


def dishwasher(
    w: float = 0.6,
    d: float = 0.6,
    h: float = 0.85,
    *,
    body: str = "lacquer_white",
    panel: str = "metal_dark",
    handles: str = "metal",
) -> Parts:
    """A door with a panel and a bar over a plinth."""
    front = -d / 2 + 0.03
    yield cuboid((-w / 2, w / 2), (front + 0.06, d / 2), (0.0, 0.09), panel)
    yield cuboid((-w / 2, w / 2), (front, d / 2), (0.09, h), body)
    yield cuboid((-0.48 * w, 0.48 * w), (front - 0.01, front), (h - 0.12, h - 0.02), panel)
    yield cuboid((-0.4 * w, 0.4 * w), (front - 0.03, front), (h - 0.17, h - 0.15), handles)


def washing_machine(
    w: float = 0.6,
    d: float = 0.6,
    h: float = 0.85,
    *,
    body: str = "lacquer_white",
    door: str = "glass_dark",
) -> Parts:
    """A body on feet with a porthole."""
    yield from four_legs(w, d, 0.02, body, leg=LEG, inset=0.02)
    yield cuboid((-w / 2, w / 2), (-d / 2 + 0.03, d / 2), (0.02, h), body)
    porthole, y = (-0.27 * w, 0.27 * w), (-d / 2, -d / 2 + 0.03)
    yield cuboid(porthole, y, (0.3 * h, 0.3 * h + 0.54 * w), door)
