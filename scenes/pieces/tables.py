"""Tables and desks; conventions as `scenes.pieces`."""

from __future__ import annotations

from scenes.parts import LEG, Parts, cuboid, cylinder, four_legs, plate


def table(
    w: float = 1.4, d: float = 0.8, h: float = 0.75, *, top: str = "wood", legs: str = "wood"
) -> Parts:
    """Four legs, rails and a top."""
    yield from four_legs(w, d, h - 0.03, legs, leg=LEG, inset=0.03)
    yield plate(w, d, (h - 0.03, h), top)
    rail = (-w / 2 + 0.08, w / 2 - 0.08)
    for y in (-d / 2 + 0.04, d / 2 - 0.06):
        yield cuboid(rail, (y, y + 0.02), (h - 0.1, h - 0.03), legs)


def coffee_table(
    w: float = 1.0, d: float = 0.6, h: float = 0.42, *, top: str = "wood", legs: str = "wood"
) -> Parts:
    """Four thicker legs and a low top."""
    yield from four_legs(w, d, h - 0.04, legs, leg=0.06)
    yield plate(w, d, (h - 0.04, h), top)


def round_table(
    w: float = 0.9, d: float = 0.9, h: float = 0.75, *, top: str = "wood_light", legs: str = "metal"
) -> Parts:
    """A foot plate, a column and a round top."""
    yield cylinder((0, 0), (0.3 * w, 0.3 * d), (0.0, 0.03), legs)
    yield cylinder((0, 0), (0.04, 0.04), (0.03, h - 0.03), legs, 8)
    yield cylinder((0, 0), (w / 2, d / 2), (h - 0.03, h), top, 24)


def side_table(
    w: float = 0.5,
    d: float = 0.5,
    h: float = 0.5,
    *,
    top: str = "wood_light",
    legs: str = "metal_dark",
) -> Parts:
    """Four thin legs, a shelf and a top."""
    yield from four_legs(w, d, h - 0.02, legs, leg=0.025)
    shelf = (-w / 2 + 0.025, w / 2 - 0.025)
    yield cuboid(shelf, (-d / 2, d / 2), (0.4 * h, 0.4 * h + 0.015), top)
    yield plate(w, d, (h - 0.02, h), top)


def desk(
    w: float = 1.4,
    d: float = 0.7,
    h: float = 0.74,
    *,
    top: str = "wood_light",
    legs: str = "metal",
    drawers: str = "wood_light",
    screen: str = "plastic_black",
) -> Parts:
    """Two legs, a chest of drawers and a screen."""
    yield plate(w, d, (h - 0.03, h), top)
    for y in (-d / 2 + 0.03, d / 2 - 0.08):
        yield cuboid((-w / 2 + 0.03, -w / 2 + 0.08), (y, y + LEG), (0.0, h - 0.03), legs)
    chest = (w / 2 - 0.45, w / 2 - 0.03)
    yield cuboid(chest, (-d / 2 + 0.05, d / 2 - 0.02), (0.0, h - 0.03), drawers)
    yield cuboid((-0.28, 0.28), (d / 2 - 0.2, d / 2 - 0.16), (h + 0.08, h + 0.42), screen)
    yield cuboid((-0.1, 0.1), (d / 2 - 0.25, d / 2 - 0.1), (h, h + 0.02), screen)
    yield cuboid((-0.03, 0.03), (d / 2 - 0.16, d / 2 - 0.13), (h + 0.02, h + 0.2), screen)


def office_desk(
    w: float = 1.6,
    d: float = 0.8,
    h: float = 0.74,
    *,
    top: str = "lacquer_white",
    legs: str = "metal",
) -> Parts:
    """T-shaped feet that the robot feels, a modesty panel and a plain top."""
    for x in (-w / 2 + 0.06, w / 2 - 0.12):
        yield cuboid((x, x + 0.06), (-d / 2 + 0.05, d / 2 - 0.05), (0.0, 0.03), legs)
        yield cuboid((x, x + 0.06), (-0.03, 0.05), (0.03, h - 0.025), legs)
    panel = (-w / 2 + 0.12, w / 2 - 0.12)
    yield cuboid(panel, (0.03, 0.045), (0.55 * h, h - 0.025), top)
    yield plate(w, d, (h - 0.025, h), top)


def ironing_board(
    w: float = 1.2,
    d: float = 0.4,
    h: float = 0.9,
    *,
    cover: str = "fabric_blue",
    legs: str = "metal",
) -> Parts:
    """A padded board with a narrow end on two feet."""
    for x in (-0.35 * w, 0.35 * w - 0.03):
        yield cuboid((x, x + 0.03), (-0.45 * d, 0.45 * d), (0.0, 0.03), legs)
        yield cuboid((x, x + 0.03), (-0.02, 0.02), (0.03, h - 0.03), legs)
    yield cuboid((-0.35 * w + 0.03, 0.35 * w - 0.03), (-0.01, 0.01), (h - 0.06, h - 0.03), legs)
    yield cuboid((-w / 2, 0.3 * w), (-d / 2, d / 2), (h - 0.03, h), cover)
    yield cuboid((0.3 * w, w / 2), (-0.3 * d, 0.3 * d), (h - 0.03, h), cover)
