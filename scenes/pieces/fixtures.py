"""Heavy things that stand for good; conventions as `scenes.pieces`."""

from __future__ import annotations

from scenes.parts import Parts, cuboid, four_legs, plate


def piano(
    w: float = 1.5,
    d: float = 0.6,
    h: float = 1.25,
    *,
    body: str = "lacquer_black",
    keys: str = "plastic_white",
) -> Parts:
    """An upright piano, its keys to the front."""
    shelf = 0.5 * h
    yield cuboid((-w / 2, w / 2), (-0.1 * d, d / 2), (0.0, h - 0.03), body)
    yield cuboid((-w / 2, w / 2), (-0.15 * d, d / 2), (h - 0.03, h), body)
    for x in (-w / 2, w / 2 - 0.06):
        yield cuboid((x, x + 0.06), (-d / 2, -0.1 * d), (0.0, 0.06), body)
        yield cuboid((x, x + 0.06), (-0.48 * d, -0.38 * d), (0.06, shelf), body)
    yield cuboid((-w / 2, w / 2), (-d / 2, -0.1 * d), (shelf, shelf + 0.08), body)
    yield cuboid((-0.46 * w, 0.46 * w), (-0.47 * d, -0.2 * d), (shelf + 0.08, shelf + 0.1), keys)
    yield cuboid((-0.15 * w, 0.15 * w), (-0.13 * d, -0.1 * d), (shelf + 0.18, shelf + 0.42), keys)


def copier(
    w: float = 0.6,
    d: float = 0.65,
    h: float = 1.1,
    *,
    body: str = "plastic_white",
    trays: str = "plastic_black",
) -> Parts:
    """Paper drawers under a scanner, on castors."""
    yield from four_legs(w, d, 0.04, trays, leg=0.05, inset=0.04)
    yield cuboid((-w / 2, w / 2), (-d / 2 + 0.02, d / 2), (0.04, 0.72 * h), body)
    for k in range(3):
        z = 0.08 + 0.16 * k * h
        yield cuboid((-0.45 * w, 0.45 * w), (-d / 2, -d / 2 + 0.02), (z, z + 0.02), trays)
    yield cuboid((-w / 2, w / 2), (0.1 * d, d / 2), (0.72 * h, 0.86 * h), trays)
    yield cuboid((-w / 2, -0.3 * w), (-d / 2 + 0.02, 0.1 * d), (0.72 * h, 0.86 * h), body)
    yield cuboid((-w / 2, w / 2), (-d / 2 + 0.02, d / 2), (0.86 * h, h), body)
    yield cuboid((0.1 * w, 0.45 * w), (-d / 2, -d / 2 + 0.02), (0.9 * h, 0.96 * h), trays)


def fireplace(
    w: float = 1.3,
    d: float = 0.4,
    h: float = 1.1,
    *,
    surround: str = "stone_light",
    hearth: str = "brick",
    logs: str = "wood_dark",
) -> Parts:
    """A surround with a mantelpiece about an open fire on a raised hearth."""
    opening, side = 0.3 * w, 0.65 * h
    yield plate(w, d, (0.0, 0.06), surround)
    for x in ((-0.46 * w, -opening), (opening, 0.46 * w)):
        yield cuboid(x, (-0.38 * d, d / 2), (0.06, side), surround)
    yield cuboid((-opening, opening), (0.4 * d, d / 2), (0.06, side), hearth)
    yield cuboid((-0.46 * w, 0.46 * w), (-0.38 * d, d / 2), (side, h - 0.05), surround)
    yield plate(w, d, (h - 0.05, h), surround)
    for k in range(3):
        left = (-0.16 + 0.12 * k) * w
        yield cuboid((left, left + 0.07 * w), (-0.2 * d, 0.3 * d), (0.06, 0.14), logs)


def column(w: float = 0.3, d: float = 0.3, h: float = 2.5, *, body: str = "white_plaster") -> Parts:
    """A square column from the floor to a ceiling of 2.5 m."""
    yield plate(w, d, (0.0, h), body)
