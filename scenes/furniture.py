"""Furniture: what one sleeps, sits and works on, and keeps things in.

Every function takes the piece's (width, depth, height), m, and yields its parts
in the piece's own frame: the middle of the footprint at the origin, the back
towards +y, the floor at z = 0.
"""

from __future__ import annotations

import numpy as np

from scenes.parts import LEG, Parts, box, disc, legs


def bed(w: float, d: float, h: float) -> Parts:
    """Four legs, a frame with a head board, mattress, cover and pillows."""
    clear = min(0.18, 0.4 * h)
    mattress = clear + 0.12 + 0.6 * min(0.35, h - clear - 0.12)
    yield from legs(w, d, clear, "frame", leg=0.06)
    yield box((-w / 2, w / 2), (-d / 2, d / 2 - 0.05), (clear, clear + 0.12), "frame")
    yield box((-w / 2, w / 2), (d / 2 - 0.05, d / 2), (clear, h), "frame")
    inner = (-w / 2 + 0.03, w / 2 - 0.03)
    yield box(inner, (-d / 2 + 0.03, d / 2 - 0.05), (clear + 0.12, mattress), "mattress")
    cover = (-d / 2 + 0.02, d / 2 - 0.6)
    yield box((-w / 2 + 0.02, w / 2 - 0.02), cover, (mattress, mattress + 0.05), "cover")
    pillows = 2 if w > 1.2 else 1
    step = (w - 0.1) / pillows
    for k in range(pillows):
        left = -w / 2 + 0.05 + k * step
        y = (d / 2 - 0.5, d / 2 - 0.1)
        yield box((left + 0.05, left + step - 0.05), y, (mattress, mattress + 0.1), "mattress")


def seat(w: float, d: float, h: float, clear: float, cushions: int) -> Parts:
    """Body of sofa and armchair: base over ``clear``, back, two arms, cushions."""
    arm, back, seat = min(0.18, w / 5), 0.22, 0.5 * h
    yield from legs(w, d, clear, "legs", leg=LEG, inset=0.03)
    yield box((-w / 2, w / 2), (-d / 2, d / 2), (clear, 0.75 * seat), "fabric")
    yield box((-w / 2, w / 2), (d / 2 - back, d / 2), (0.75 * seat, h), "fabric")
    for x in ((-w / 2, -w / 2 + arm), (w / 2 - arm, w / 2)):
        yield box(x, (-d / 2, d / 2 - back), (0.75 * seat, 1.5 * seat), "fabric")
    step = (w - 2 * arm) / cushions
    for k in range(cushions):
        left = -w / 2 + arm + k * step
        x, y = (left + 0.005, left + step - 0.005), (-d / 2 + 0.01, d / 2 - back - 0.005)
        yield box(x, y, (0.75 * seat, 1.05 * seat), "cushions")


def sofa(w: float, d: float, h: float) -> Parts:
    """High enough on its legs for the robot."""
    return seat(w, d, h, 0.12, 2 if w < 1.9 else 3)


def armchair(w: float, d: float, h: float) -> Parts:
    """Too low for the robot, as many armchairs are."""
    return seat(w, d, h, 0.06, 1)


def table(w: float, d: float, h: float) -> Parts:
    """Four legs, rails and a top."""
    yield from legs(w, d, h - 0.03, "legs", leg=LEG, inset=0.03)
    yield box((-w / 2, w / 2), (-d / 2, d / 2), (h - 0.03, h), "top")
    rail = (-w / 2 + 0.08, w / 2 - 0.08)
    for y in (-d / 2 + 0.04, d / 2 - 0.06):
        yield box(rail, (y, y + 0.02), (h - 0.1, h - 0.03), "legs")


def coffee_table(w: float, d: float, h: float) -> Parts:
    """Four thicker legs and a low top."""
    yield from legs(w, d, h - 0.04, "legs", leg=0.06)
    yield box((-w / 2, w / 2), (-d / 2, d / 2), (h - 0.04, h), "top")


def round_table(w: float, d: float, h: float) -> Parts:
    """A foot plate, a column and a round top."""
    yield disc((0, 0), (0.3 * w, 0.3 * d), (0.0, 0.03), "legs")
    yield disc((0, 0), (0.04, 0.04), (0.03, h - 0.03), "legs", 8)
    yield disc((0, 0), (w / 2, d / 2), (h - 0.03, h), "top", 24)


def chair(w: float, d: float, h: float) -> Parts:
    """Four thin legs, seat and back."""
    seat, leg = 0.5 * h, 0.035
    yield from legs(w, d, seat - 0.03, "frame", leg=leg)
    yield box((-w / 2, w / 2), (-d / 2, d / 2), (seat - 0.03, seat), "seat")
    for x in (-w / 2, w / 2 - leg):
        yield box((x, x + leg), (d / 2 - leg, d / 2), (seat, h), "frame")
    rest = (-w / 2 + leg, w / 2 - leg)
    yield box(rest, (d / 2 - 0.03, d / 2 - 0.01), (seat + 0.15, h - 0.02), "seat")


def office_chair(w: float, d: float, h: float) -> Parts:
    """A cross on four castors, seat and back."""
    yield box((-w / 2, w / 2), (-0.03, 0.03), (0.05, 0.09), "frame")
    yield box((-0.03, 0.03), (-d / 2, d / 2), (0.05, 0.09), "frame")
    for x, y in ((-w / 2 + 0.03, 0), (w / 2 - 0.03, 0), (0, -d / 2 + 0.03), (0, d / 2 - 0.03)):
        yield disc((x, y), (0.03, 0.03), (0.0, 0.05), "frame", 8)
    yield disc((0, 0), (0.03, 0.03), (0.09, 0.42), "frame", 8)
    yield box((-0.45 * w, 0.45 * w), (-0.45 * d, 0.45 * d), (0.42, 0.5), "seat")
    yield box((-0.4 * w, 0.4 * w), (0.4 * d, 0.5 * d), (0.55, h), "seat")


def desk(w: float, d: float, h: float) -> Parts:
    """Two legs, a chest of drawers and a screen."""
    yield box((-w / 2, w / 2), (-d / 2, d / 2), (h - 0.03, h), "top")
    for y in (-d / 2 + 0.03, d / 2 - 0.08):
        yield box((-w / 2 + 0.03, -w / 2 + 0.08), (y, y + LEG), (0.0, h - 0.03), "legs")
    drawers = (w / 2 - 0.45, w / 2 - 0.03)
    yield box(drawers, (-d / 2 + 0.05, d / 2 - 0.02), (0.0, h - 0.03), "drawers")
    yield box((-0.28, 0.28), (d / 2 - 0.2, d / 2 - 0.16), (h + 0.08, h + 0.42), "screen")
    yield box((-0.1, 0.1), (d / 2 - 0.25, d / 2 - 0.1), (h, h + 0.02), "screen")
    yield box((-0.03, 0.03), (d / 2 - 0.16, d / 2 - 0.13), (h + 0.02, h + 0.2), "screen")


def shelf(w: float, d: float, h: float) -> Parts:
    """An open shelf with books and boxes."""
    board = 0.02
    for x in (-w / 2, w / 2 - board):
        yield box((x, x + board), (-d / 2, d / 2), (0.0, h), "body")
    inner = (-w / 2 + board, w / 2 - board)
    yield box(inner, (d / 2 - 0.01, d / 2), (0.0, h), "body")
    yield box(inner, (-d / 2 + 0.01, -d / 2 + 0.02), (0.0, 0.06), "body")
    count = max(2, round(h / 0.36) + 1)
    levels = np.linspace(0.06, h - board, count)
    for z in levels:
        yield box(inner, (-d / 2, d / 2 - 0.01), (z, z + board), "body")
    for k, z in enumerate(levels[:-1]):
        # Books fill a different share of each board, from alternating sides.
        fill = (0.85, 0.5, 0.7, 0.3)[k % 4] * (w - 2 * board)
        span = (inner[0], inner[0] + fill) if k % 2 else (inner[1] - fill, inner[1])
        top = min(z + board + 0.22 + 0.03 * (k % 3), levels[k + 1] - 0.01)
        slot = "books" if k % 2 else "boxes"
        yield box(span, (-d / 2 + 0.04, d / 2 - 0.01), (z + board, top), slot)


def fronts(w: float, y: float, z: tuple[float, float], target: float) -> Parts:
    """Doors of about ``target`` width, 2 cm thick, before the front face at ``y``."""
    count = max(1, round(w / target))
    step = w / count
    for k in range(count):
        x = (-w / 2 + k * step + 0.003, -w / 2 + (k + 1) * step - 0.003)
        yield box(x, (y, y + 0.02), z, "fronts")
        yield box((x[1] - 0.05, x[1] - 0.035), (y - 0.02, y), handle(z), "handles")


def handle(z: tuple[float, float]) -> tuple[float, float]:
    """Heights of a handle in the middle of a front."""
    middle, half = (z[0] + z[1]) / 2, min(0.07, (z[1] - z[0]) / 4)
    return middle - half, middle + half


def cabinet(w: float, d: float, h: float, plinth: float, target: float) -> Parts:
    """A closed body over a recessed plinth, with doors; the footprint is w × d."""
    front = -d / 2 + 0.02
    yield box((-w / 2, w / 2), (front + 0.07, d / 2), (0.0, plinth), "body")
    yield box((-w / 2, w / 2), (front + 0.02, d / 2), (plinth, h), "body")
    yield from fronts(w, front, (plinth + 0.005, h - 0.005), target)


def wardrobe(w: float, d: float, h: float) -> Parts:
    """A tall cabinet."""
    return cabinet(w, d, h, 0.08, 0.5)


def tv_stand(w: float, d: float, h: float) -> Parts:
    """A low board on legs with a screen."""
    stand = 0.42 * h
    yield from legs(w, d, 0.13, "body", leg=0.04)
    yield box((-w / 2, w / 2), (-d / 2, d / 2), (0.13, stand), "body")
    x = 0.4 * w
    yield box((-0.3 * x, 0.3 * x), (-0.1, 0.1), (stand, stand + 0.02), "screen")
    yield box((-0.04, 0.04), (0.01, 0.04), (stand + 0.02, stand + 0.1), "screen")
    yield box((-x, x), (-0.03, 0.01), (stand + 0.06, h), "screen")
