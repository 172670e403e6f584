"""What is fixed to walls and ceilings; conventions as `scenes.pieces`."""

from __future__ import annotations

import shapely

from scenes.parts import Parts, cuboid, cylinder, hangs, plate
from scenes.pieces.cabinets import doors


@hangs(1.4)
def wall_cupboard(
    w: float = 1.2,
    d: float = 0.37,
    h: float = 0.7,
    *,
    body: str = "lacquer_white",
    fronts: str = "lacquer_white",
    handles: str = "metal",
) -> Parts:
    """A cabinet without plinth."""
    yield cuboid((-w / 2, w / 2), (-d / 2 + 0.04, d / 2), (0.0, h), body)
    yield from doors(w, -d / 2 + 0.02, (0.005, h - 0.005), 0.6, materials=(fronts, handles))


@hangs(1.6)
def extractor_hood(
    w: float = 0.6,
    d: float = 0.5,
    h: float = 0.7,
    *,
    body: str = "metal",
    filters: str = "metal_dark",
) -> Parts:
    """A flat hood with a shaft up the wall."""
    yield cuboid((-0.42 * w, 0.42 * w), (-0.4 * d, 0.4 * d), (0.0, 0.02), filters)
    yield plate(w, d, (0.02, 0.09), body)
    yield cuboid((-0.25 * w, 0.25 * w), (0.0, d / 2), (0.09, h), body)


@hangs(1.4)
def picture(
    w: float = 0.6,
    d: float = 0.03,
    h: float = 0.45,
    *,
    frame: str = "wood_dark",
    picture: str = "paper",
) -> Parts:
    """A framed picture."""
    yield from _framed(w, d, h, min(0.03, w / 4, h / 4), (frame, picture))


def _framed(w: float, d: float, h: float, edge: float, materials: tuple[str, str]) -> Parts:
    """A frame around something flat in its back half."""
    frame, inside = materials
    outer = shapely.box(-w / 2, -d / 2, w / 2, d / 2)
    for x in ((-w / 2, -w / 2 + edge), (w / 2 - edge, w / 2)):
        yield cuboid(x, (-d / 2, d / 2), (0.0, h), frame)
    inner = (-w / 2 + edge, w / 2 - edge)
    for z in ((0.0, edge), (h - edge, h)):
        yield cuboid(inner, (outer.bounds[1], outer.bounds[3]), z, frame)
    yield cuboid(inner, (0.0, d / 2), (edge, h - edge), inside)


@hangs(1.1)
def mirror(
    w: float = 0.6, d: float = 0.03, h: float = 0.9, *, frame: str = "metal", glass: str = "mirror"
) -> Parts:
    """A mirror in a thin frame."""
    yield from _framed(w, d, h, min(0.015, w / 4, h / 4), (frame, glass))


@hangs(0.9)
def whiteboard(
    w: float = 1.8,
    d: float = 0.04,
    h: float = 1.2,
    *,
    board: str = "enamel_white",
    frame: str = "metal",
) -> Parts:
    """A board in a metal frame with a tray for pens."""
    yield from _framed(w, d / 2, h, min(0.02, w / 4, h / 4), (frame, board))


@hangs(0.95)
def tv(
    w: float = 1.2,
    d: float = 0.07,
    h: float = 0.7,
    *,
    screen: str = "plastic_black",
    mount: str = "metal_dark",
) -> Parts:
    """A flat screen on a mount."""
    yield cuboid((-w / 2, w / 2), (-d / 2, 0.0), (0.0, h), screen)
    yield cuboid((-0.2 * w, 0.2 * w), (0.0, d / 2), (0.3 * h, 0.7 * h), mount)


@hangs(1.45)
def wall_shelf(
    w: float = 0.9,
    d: float = 0.24,
    h: float = 0.26,
    *,
    board: str = "wood",
    books: str = "paper",
    boxes: str = "fabric_green",
) -> Parts:
    """A board with books and a box."""
    yield plate(w, d, (0.0, 0.03), board)
    heights = (1.0, 0.85, 0.94, 0.78)
    step = 0.1 * w
    for k, share in enumerate(heights):
        left = -0.46 * w + k * step
        x = (left + 0.002, left + step - 0.002)
        yield cuboid(x, (-0.3 * d, 0.45 * d), (0.03, 0.03 + share * (h - 0.03)), books)
    yield cuboid((0.15 * w, 0.42 * w), (-0.4 * d, 0.4 * d), (0.03, 0.7 * h), boxes)


@hangs(1.35)
def boiler(
    w: float = 0.45,
    d: float = 0.35,
    h: float = 0.8,
    *,
    body: str = "lacquer_white",
    panel: str = "plastic_black",
    pipes: str = "copper",
) -> Parts:
    """A gas boiler: a box with a panel, and pipes below."""
    yield cuboid((-w / 2, w / 2), (-d / 2 + 0.01, d / 2), (0.12, h), body)
    yield cuboid((-0.4 * w, 0.4 * w), (-d / 2, -d / 2 + 0.01), (0.15, 0.25), panel)
    for k in range(4):
        x = (-0.3 + 0.2 * k) * w
        yield cylinder((x, 0.35 * d), (0.011, 0.011), (0.0, 0.12), pipes, 8)


@hangs(2.3)
def ceiling_beam(
    w: float = 3.0, d: float = 0.15, h: float = 0.2, *, body: str = "wood_dark"
) -> Parts:
    """A beam under a ceiling of 2.5 m; give an elevation for other ceilings."""
    yield plate(w, d, (0.0, h), body)


@hangs(0.8)
def blinds(
    w: float = 1.2,
    d: float = 0.06,
    h: float = 1.3,
    *,
    slats: str = "lacquer_white",
    rail: str = "metal",
) -> Parts:
    """Slats under a rail, let down half the way and gathered there; hangs before a window."""
    yield plate(w, d, (h - 0.04, h), rail)
    count = max(4, round(h / 0.05))
    step = (h - 0.04) / count
    half = count // 2
    for k in range(half):
        z = h - 0.04 - (k + 1) * step
        yield cuboid((-0.49 * w, 0.49 * w), (-0.4 * d, 0.4 * d), (z, z + 0.004), slats)
    for x in (-0.35 * w, 0.35 * w):
        cord = (0.4 * d, 0.4 * d + 0.003)
        yield cuboid((x - 0.002, x + 0.002), cord, (0.0, h - 0.04), rail)


def curtain(
    w: float = 0.7,
    d: float = 0.1,
    h: float = 2.35,
    *,
    fabric: str = "fabric_beige",
    rail: str = "metal",
) -> Parts:
    """Folds under a rail, just above the floor."""
    folds = max(2, round(w / 0.12))
    step = w / folds
    for k in range(folds):
        y = (-d / 2, 0.1 * d) if k % 2 else (-0.1 * d, d / 2)
        left = -w / 2 + k * step
        yield cuboid((left, left + step), y, (0.03, h - 0.03), fabric)
    yield cuboid((-w / 2 - 0.05, w / 2 + 0.05), (-0.01, 0.01), (h - 0.03, h), rail)


def radiator(
    w: float = 0.9, d: float = 0.1, h: float = 0.7, *, body: str = "lacquer_white"
) -> Parts:
    """Ribs on the wall, 12 cm above the floor, on one pipe."""
    clear, step = 0.12, 0.08
    count = max(2, int(w / step))
    left = -count * step / 2
    for k in range(count):
        x = (left + k * step + 0.008, left + (k + 1) * step - 0.008)
        yield cuboid(x, (-d / 2, d / 2), (clear, h), body)
    yield cuboid((left, -left), (-0.02, 0.02), (clear + 0.04, clear + 0.08), body)
    yield cuboid((left, -left), (-0.02, 0.02), (h - 0.08, h - 0.04), body)
    pipe = left + step / 2
    yield cylinder((pipe, d / 2 - 0.02), (0.01, 0.01), (0.0, clear), body, 8)
