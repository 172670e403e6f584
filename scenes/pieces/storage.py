"""What one keeps things in; conventions as `scenes.pieces`."""

from __future__ import annotations

import numpy as np

from scenes.parts import Parts, cuboid, four_legs, plate
from scenes.pieces.cabinets import cabinet, carcass, doors, drawers


def shelf(
    w: float = 0.8,
    d: float = 0.3,
    h: float = 1.9,
    *,
    body: str = "wood_light",
    books: str = "paper",
    boxes: str = "fabric_red",
) -> Parts:
    """An open shelf with a back, books and boxes, closed to the floor."""
    board = 0.02
    for x in (-w / 2, w / 2 - board):
        yield cuboid((x, x + board), (-d / 2, d / 2), (0.0, h), body)
    inner = (-w / 2 + board, w / 2 - board)
    yield cuboid(inner, (d / 2 - 0.01, d / 2), (0.0, h), body)
    yield cuboid(inner, (-d / 2 + 0.01, -d / 2 + 0.02), (0.0, 0.06), body)
    count = max(2, round(h / 0.36) + 1)
    levels = np.linspace(0.06, h - board, count)
    for z in levels:
        yield cuboid(inner, (-d / 2, d / 2 - 0.01), (z, z + board), body)
    for k, z in enumerate(levels[:-1]):
        # Books fill a different share of each board, from alternating sides.
        fill = (0.85, 0.5, 0.7, 0.3)[k % 4] * (w - 2 * board)
        span = (inner[0], inner[0] + fill) if k % 2 else (inner[1] - fill, inner[1])
        top = min(z + board + 0.22 + 0.03 * (k % 3), levels[k + 1] - 0.01)
        yield cuboid(
            span, (-d / 2 + 0.04, d / 2 - 0.01), (z + board, top), books if k % 2 else boxes
        )


def bookcase(
    w: float = 1.0,
    d: float = 0.3,
    h: float = 2.1,
    *,
    body: str = "wood_dark",
    books: str = "paper",
    spines: str = "fabric_red",
) -> Parts:
    """Tall, closed back and plinth, two columns full of books."""
    board = 0.022
    yield cuboid((-w / 2, w / 2), (d / 2 - 0.012, d / 2), (0.0, h), body)
    for x in (-w / 2, -board / 2, w / 2 - board):
        yield cuboid((x, x + board), (-d / 2, d / 2 - 0.012), (0.0, h), body)
    levels = np.linspace(0.08, h - board, max(2, round(h / 0.33) + 1))
    for side in (-1, 1):
        inner = (board / 2, w / 2 - board) if side > 0 else (-w / 2 + board, -board / 2)
        yield cuboid(inner, (-d / 2 + 0.02, d / 2 - 0.012), (0.0, 0.08), body)
        for k, z in enumerate(levels):
            yield cuboid(inner, (-d / 2, d / 2 - 0.012), (z, z + board), body)
            if k + 1 < len(levels):
                room = levels[k + 1] - z - board
                yield from _books(
                    inner, d, z + board, room, materials=(books, spines), turn=k + (side > 0)
                )


def _books(
    x: tuple[float, float],
    d: float,
    z: float,
    room: float,
    *,
    materials: tuple[str, str],
    turn: int,
) -> Parts:
    """Seven spines of different height and depth, ``turn`` choosing which."""
    step = (x[1] - x[0]) / 7
    for k in range(7):
        share = (0.82, 0.7, 0.9, 0.62, 0.78)[(3 * k + 2 * turn) % 5]
        front = -d / 2 + (0.15, 0.24, 0.1)[(k + turn) % 3] * d
        span = (x[0] + k * step + 0.003, x[0] + (k + 1) * step - 0.003)
        material = materials[(k * (turn + 2) // 2 + turn) % 2]
        yield cuboid(span, (front, d / 2 - 0.012), (z, z + share * room), material)


def room_divider(
    w: float = 1.6,
    d: float = 0.35,
    h: float = 1.7,
    *,
    body: str = "wood_light",
    boxes: str = "fabric_beige",
) -> Parts:
    """A shelf open to both sides that stands free, with some boxes; closed to the floor."""
    board = 0.03
    columns, rows = max(2, round(w / 0.4)), max(2, round(h / 0.4))
    yield plate(w, d - 0.06, (0.0, 0.03), body)
    xs, levels = (
        np.linspace(-w / 2, w / 2 - board, columns + 1),
        np.linspace(0.03, h - board, rows + 1),
    )
    for z in levels:
        yield plate(w, d, (z, z + board), body)
    for k in range(rows):
        z = (levels[k] + board, levels[k + 1])
        for x in xs:
            yield cuboid((x, x + board), (-d / 2, d / 2), z, body)
        for j in range(columns):
            if (j + 2 * k) % 3 == 0:
                inside = (xs[j] + board + 0.02, xs[j + 1] - 0.02)
                y = (-d / 2 + 0.03, d / 2 - 0.03)
                yield cuboid(inside, y, (z[0], z[0] + 0.7 * (z[1] - z[0])), boxes)


def wardrobe(
    w: float = 1.5,
    d: float = 0.62,
    h: float = 2.1,
    *,
    body: str = "lacquer_white",
    fronts: str = "lacquer_white",
    handles: str = "metal",
) -> Parts:
    """A tall cabinet on a plinth."""
    return cabinet(w, d, h, 0.08, 0.5, materials=(body, fronts, handles))


def chest_of_drawers(
    w: float = 0.9,
    d: float = 0.48,
    h: float = 0.85,
    *,
    body: str = "wood",
    fronts: str = "wood",
    handles: str = "metal_dark",
) -> Parts:
    """Drawers over a plinth, under a top that stands over them."""
    yield from carcass(w, d, h - 0.025, 0.06, body)
    yield cuboid((-w / 2, w / 2), (-d / 2 + 0.01, d / 2), (h - 0.025, h), body)
    count = max(2, round(h / 0.22))
    span = (0.065, h - 0.03)
    yield from drawers(w, -d / 2 + 0.02, span, count, materials=(fronts, handles))


def sideboard(
    w: float = 1.6,
    d: float = 0.45,
    h: float = 0.8,
    *,
    body: str = "wood",
    fronts: str = "lacquer_white",
    handles: str = "metal_dark",
    legs: str = "metal_dark",
) -> Parts:
    """Doors and drawers on legs that let the robot under."""
    clear, front = 0.15, -d / 2 + 0.02
    yield from four_legs(w, d - 0.04, clear, legs, leg=0.04, inset=0.04)
    yield cuboid((-w / 2, w / 2), (front + 0.02, d / 2), (clear, h), body)
    z, third = (clear + 0.01, h - 0.01), w / 3
    for x in (-third, third):
        yield from doors(third, front, z, 0.6, materials=(fronts, handles), x=x)
    yield from drawers(third, front, z, 3, materials=(fronts, handles))


def filing_cabinet(
    w: float = 0.45,
    d: float = 0.6,
    h: float = 0.72,
    *,
    body: str = "lacquer_white",
    fronts: str = "lacquer_white",
    handles: str = "metal",
) -> Parts:
    """Three drawers on hidden castors."""
    front = -d / 2 + 0.02
    yield from four_legs(w, d - 0.04, 0.03, handles, leg=0.04, inset=0.03)
    yield cuboid((-w / 2, w / 2), (front + 0.02, d / 2), (0.03, h), body)
    yield from drawers(w, front, (0.035, h - 0.01), 3, materials=(fronts, handles))


def tv_stand(
    w: float = 1.6,
    d: float = 0.42,
    h: float = 1.1,
    *,
    body: str = "wood",
    screen: str = "plastic_black",
) -> Parts:
    """A low board on legs with a screen."""
    stand = 0.42 * h
    yield from four_legs(w, d, 0.13, body, leg=0.04)
    yield plate(w, d, (0.13, stand), body)
    x = 0.4 * w
    yield cuboid((-0.3 * x, 0.3 * x), (-0.1, 0.1), (stand, stand + 0.02), screen)
    yield cuboid((-0.04, 0.04), (0.01, 0.04), (stand + 0.02, stand + 0.1), screen)
    yield cuboid((-x, x), (-0.03, 0.01), (stand + 0.06, h), screen)


def shoe_rack(
    w: float = 0.8, d: float = 0.3, h: float = 0.5, *, frame: str = "metal", shoes: str = "leather"
) -> Parts:
    """Grids between two ends, with shoes; open at the floor, but too low to drive under."""
    for x in (-w / 2, w / 2 - 0.025):
        yield cuboid((x, x + 0.025), (-d / 2, d / 2), (0.0, h), frame)
    inner = (-w / 2 + 0.025, w / 2 - 0.025)
    for z in (0.16 * h, 0.55 * h, h - 0.02):
        for y in (-d / 2, -0.1 * d, 0.3 * d):
            yield cuboid(inner, (y, y + 0.02), (z, z + 0.02), frame)
    pairs = max(1, int((inner[1] - inner[0]) / 0.25))
    step = (inner[1] - inner[0]) / pairs
    for z in (0.16 * h + 0.02, 0.55 * h + 0.02):
        for k in range(pairs):
            left = inner[0] + k * step
            for shift in (0.03, 0.03 + 0.45 * step):
                span = (left + shift, left + shift + 0.35 * step)
                yield cuboid(span, (-0.48 * d, 0.4 * d), (z, z + 0.2 * h), shoes)


def coat_rack(
    w: float = 0.9,
    d: float = 0.25,
    h: float = 1.7,
    *,
    frame: str = "wood",
    coats: str = "fabric_dark",
) -> Parts:
    """A panel with a hat board and coats on hooks, all above the robot."""
    yield cuboid((-w / 2, w / 2), (d / 2 - 0.02, d / 2), (0.55 * h, h), frame)
    for x in (-w / 2, w / 2 - 0.03):
        yield cuboid((x, x + 0.03), (d / 2 - 0.02, d / 2), (0.0, 0.55 * h), frame)
    yield cuboid((-w / 2, w / 2), (-d / 2, d / 2 - 0.02), (h - 0.03, h), frame)
    hooks = max(2, round(w / 0.22))
    step = w / hooks
    for k in range(hooks):
        x = -w / 2 + (k + 0.5) * step
        top = 0.88 * h
        yield cuboid((x - 0.01, x + 0.01), (d / 2 - 0.1, d / 2 - 0.02), (top, top + 0.02), frame)
        if k % 3 != 1:
            wide = min(0.09, 0.45 * step)
            low = (0.3, 0.42, 0.36)[k % 3] * h
            yield cuboid((x - wide, x + wide), (d / 2 - 0.16, d / 2 - 0.02), (low, top), coats)
