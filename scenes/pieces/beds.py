"""Beds, and what stands beside them; conventions as `scenes.pieces`."""

from __future__ import annotations

from scenes.parts import Parts, cuboid, four_legs


def bed(
    w: float = 1.6,
    d: float = 2.1,
    h: float = 0.95,
    *,
    frame: str = "wood",
    mattress: str = "fabric_white",
    cover: str = "fabric_blue",
) -> Parts:
    """Four legs, a frame with a head board, mattress, cover and pillows."""
    clear = min(0.18, 0.4 * h)
    top = clear + 0.12 + 0.6 * min(0.35, h - clear - 0.12)
    yield from four_legs(w, d, clear, frame, leg=0.06)
    yield cuboid((-w / 2, w / 2), (-d / 2, d / 2 - 0.05), (clear, clear + 0.12), frame)
    yield cuboid((-w / 2, w / 2), (d / 2 - 0.05, d / 2), (clear, h), frame)
    inner = (-w / 2 + 0.03, w / 2 - 0.03)
    yield cuboid(inner, (-d / 2 + 0.03, d / 2 - 0.05), (clear + 0.12, top), mattress)
    yield from _bedding(w, d, top, mattress, cover)


def _bedding(w: float, d: float, z: float, pillow: str, cover: str) -> Parts:
    """A cover and one pillow, or two, on a mattress at height z."""
    spread = (-d / 2 + 0.02, d / 2 - 0.6)
    yield cuboid((-w / 2 + 0.02, w / 2 - 0.02), spread, (z, z + 0.05), cover)
    pillows = 2 if w > 1.2 else 1
    step = (w - 0.1) / pillows
    for k in range(pillows):
        left = -w / 2 + 0.05 + k * step
        y = (d / 2 - 0.5, d / 2 - 0.1)
        yield cuboid((left + 0.05, left + step - 0.05), y, (z, z + 0.1), pillow)


def divan_bed(
    w: float = 1.6,
    d: float = 2.1,
    h: float = 0.95,
    *,
    base: str = "fabric_grey",
    mattress: str = "fabric_white",
    cover: str = "fabric_green",
) -> Parts:
    """A bed on a closed box down to the floor."""
    low = 0.36 * h
    top = low + 0.22 * h
    yield cuboid((-w / 2, w / 2), (-d / 2, d / 2 - 0.08), (0.0, low), base)
    yield cuboid((-w / 2, w / 2), (d / 2 - 0.08, d / 2), (0.0, h), base)
    inner = (-w / 2 + 0.02, w / 2 - 0.02)
    yield cuboid(inner, (-d / 2 + 0.02, d / 2 - 0.08), (low, top), mattress)
    yield from _bedding(w, d, top, mattress, cover)


def bunk_bed(
    w: float = 1.0,
    d: float = 2.05,
    h: float = 1.65,
    *,
    frame: str = "wood_light",
    mattress: str = "fabric_white",
    cover: str = "fabric_red",
) -> Parts:
    """Two beds between four posts, with a ladder at the front end."""
    post = 0.06
    yield from four_legs(w, d, h, frame, leg=post)
    for low, rail in ((0.2 * h, 0.0), (0.7 * h, 0.95 * h)):
        yield from _bunk(w, d, low, post, frame)
        top = low + 0.2
        inner = (-w / 2 + post, w / 2 - post)
        yield cuboid(inner, (-d / 2 + post, d / 2 - post), (low + 0.08, top), mattress)
        yield cuboid(inner, (-d / 2 + post, d / 2 - 0.7), (top, top + 0.04), cover)
        pillow = (inner[0] + 0.08, inner[1] - 0.08)
        yield cuboid(pillow, (d / 2 - 0.5, d / 2 - 0.12), (top, top + 0.09), mattress)
        if rail:
            for x in (-w / 2, w / 2 - 0.03):
                yield cuboid(
                    (x, x + 0.03), (-d / 2 + post, d / 2 - post), (rail - 0.04, rail), frame
                )
    for k in range(3):
        z = (0.32 + 0.13 * k) * h
        rung = (-w / 2 + post, w / 2 - post)
        yield cuboid(rung, (-d / 2 + 0.01, -d / 2 + 0.04), (z, z + 0.03), frame)


def _bunk(w: float, d: float, z: float, post: float, frame: str) -> Parts:
    """Side boards and slats between the posts."""
    for x in (-w / 2, w / 2 - 0.03):
        yield cuboid((x, x + 0.03), (-d / 2 + post, d / 2 - post), (z, z + 0.14), frame)
    for y in (-d / 2, d / 2 - 0.03):
        yield cuboid((-w / 2 + post, w / 2 - post), (y, y + 0.03), (z, z + 0.14), frame)
    inner, length = (-w / 2 + 0.03, w / 2 - 0.03), d - 2 * post
    count = max(3, round(length / 0.16))
    for k in range(count):
        y0 = -length / 2 + (k + 0.25) * length / count
        yield cuboid(inner, (y0, y0 + 0.5 * length / count), (z + 0.06, z + 0.08), frame)


def nightstand(
    w: float = 0.45,
    d: float = 0.4,
    h: float = 0.5,
    *,
    body: str = "wood",
    fronts: str = "wood",
    handles: str = "metal",
) -> Parts:
    """A drawer on four legs."""
    clear, front = 0.3 * h, -d / 2 + 0.02
    yield from four_legs(w, d - 0.04, clear, body, leg=0.035, inset=0.01)
    yield cuboid((-w / 2, w / 2), (front + 0.02, d / 2), (clear, h), body)
    drawer = (clear + 0.02, h - 0.02)
    yield cuboid((-w / 2 + 0.02, w / 2 - 0.02), (front, front + 0.02), drawer, fronts)
    middle = (drawer[0] + drawer[1]) / 2
    knob = (middle - 0.01, middle + 0.01)
    yield cuboid((-0.05, 0.05), (front - 0.02, front), knob, handles)
