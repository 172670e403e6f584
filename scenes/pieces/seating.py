"""What one sits on; conventions as `scenes.pieces`."""

from __future__ import annotations

import shapely

from scenes.parts import LEG, Part, Parts, cuboid, cylinder, four_legs, plate


def _upholstered(
    w: float, d: float, h: float, clear: float, count: int, *, materials: tuple[str, str]
) -> Parts:
    """Base over ``clear``, back, two arms in the first material; cushions in the second."""
    fabric, cushions = materials
    arm, back, seat = min(0.18, w / 5), 0.22, 0.5 * h
    yield plate(w, d, (clear, 0.75 * seat), fabric)
    yield cuboid((-w / 2, w / 2), (d / 2 - back, d / 2), (0.75 * seat, h), fabric)
    for x in ((-w / 2, -w / 2 + arm), (w / 2 - arm, w / 2)):
        yield cuboid(x, (-d / 2, d / 2 - back), (0.75 * seat, 1.5 * seat), fabric)
    step = (w - 2 * arm) / count
    for k in range(count):
        left = -w / 2 + arm + k * step
        x, y = (left + 0.005, left + step - 0.005), (-d / 2 + 0.01, d / 2 - back - 0.005)
        yield cuboid(x, y, (0.75 * seat, 1.05 * seat), cushions)


def sofa(
    w: float = 2.0,
    d: float = 0.9,
    h: float = 0.82,
    *,
    fabric: str = "fabric_grey",
    cushions: str = "fabric_grey",
    legs: str = "wood",
) -> Parts:
    """Two or three seats, high enough on its legs for the robot."""
    yield from four_legs(w, d, 0.12, legs, leg=LEG, inset=0.03)
    yield from _upholstered(w, d, h, 0.12, 2 if w < 1.9 else 3, materials=(fabric, cushions))


def low_sofa(
    w: float = 2.0,
    d: float = 0.9,
    h: float = 0.82,
    *,
    fabric: str = "fabric_beige",
    cushions: str = "fabric_beige",
    feet: str = "plastic_black",
) -> Parts:
    """A sofa whose base reaches down to 2 cm above the floor."""
    yield from four_legs(w, d, 0.02, feet, leg=LEG, inset=0.03)
    yield from _upholstered(w, d, h, 0.02, 2 if w < 1.9 else 3, materials=(fabric, cushions))


def corner_sofa(
    w: float = 2.5,
    d: float = 1.7,
    h: float = 0.82,
    *,
    fabric: str = "fabric_grey",
    cushions: str = "fabric_grey",
    feet: str = "plastic_black",
) -> Parts:
    """An L: a sofa along the back, a couch to the front on its right; 4 cm clear below."""
    couch, clear = 0.1 * w, 0.04
    corners = ((-w / 2, 0.0), (-w / 2, d / 2 - LEG), (w / 2 - LEG, d / 2 - LEG))
    for left, front in (*corners, (w / 2 - LEG, -d / 2), (couch, -d / 2)):
        yield cuboid((left, left + LEG), (front, front + LEG), (0.0, clear), feet)
    outline = shapely.box(-w / 2, 0.0, w / 2, d / 2)
    outline = outline.union(shapely.box(couch, -d / 2, w / 2, d / 2))
    low, high, arm, back = 0.375 * h, 0.75 * h, 0.16, d / 2 - 0.2
    yield Part(outline, clear, low, fabric)
    yield cuboid((-w / 2, w / 2), (back, d / 2), (low, h), fabric)
    yield cuboid((-w / 2, -w / 2 + arm), (0.0, back), (low, high), fabric)
    yield cuboid((w / 2 - arm, w / 2), (-d / 2, back), (low, high), fabric)
    middle = (couch - w / 2 + arm) / 2
    places = (-w / 2 + arm, middle, 0.0), (middle, couch, 0.0), (couch, w / 2 - arm, -d / 2)
    for left, right, front in places:
        x, y = (left + 0.005, right - 0.005), (front + 0.01, back - 0.005)
        yield cuboid(x, y, (low, 0.525 * h), cushions)


def armchair(
    w: float = 0.8,
    d: float = 0.85,
    h: float = 0.85,
    *,
    fabric: str = "fabric_grey",
    cushions: str = "fabric_grey",
    legs: str = "wood",
) -> Parts:
    """One seat, too low for the robot, as many armchairs are."""
    yield from four_legs(w, d, 0.06, legs, leg=LEG, inset=0.03)
    yield from _upholstered(w, d, h, 0.06, 1, materials=(fabric, cushions))


def chair(
    w: float = 0.44, d: float = 0.48, h: float = 0.9, *, frame: str = "wood", seat: str = "wood"
) -> Parts:
    """Four thin legs, seat and back."""
    top, leg = 0.5 * h, 0.035
    yield from four_legs(w, d, top - 0.03, frame, leg=leg)
    yield plate(w, d, (top - 0.03, top), seat)
    for x in (-w / 2, w / 2 - leg):
        yield cuboid((x, x + leg), (d / 2 - leg, d / 2), (top, h), frame)
    rest = (-w / 2 + leg, w / 2 - leg)
    yield cuboid(rest, (d / 2 - 0.03, d / 2 - 0.01), (top + 0.15, h - 0.02), seat)


def office_chair(
    w: float = 0.6,
    d: float = 0.6,
    h: float = 1.05,
    *,
    frame: str = "metal_dark",
    seat: str = "fabric_dark",
) -> Parts:
    """A cross on four castors, seat and back."""
    yield cuboid((-w / 2, w / 2), (-0.03, 0.03), (0.05, 0.09), frame)
    yield cuboid((-0.03, 0.03), (-d / 2, d / 2), (0.05, 0.09), frame)
    for x, y in ((-w / 2 + 0.03, 0), (w / 2 - 0.03, 0), (0, -d / 2 + 0.03), (0, d / 2 - 0.03)):
        yield cylinder((x, y), (0.03, 0.03), (0.0, 0.05), frame, 8)
    yield cylinder((0, 0), (0.03, 0.03), (0.09, 0.42), frame, 8)
    yield cuboid((-0.45 * w, 0.45 * w), (-0.45 * d, 0.45 * d), (0.42, 0.5), seat)
    yield cuboid((-0.03, 0.03), (0.42 * d, 0.45 * d), (0.5, 0.55), frame)
    yield cuboid((-0.4 * w, 0.4 * w), (0.4 * d, 0.5 * d), (0.55, h), seat)


def stool(
    w: float = 0.35, d: float = 0.35, h: float = 0.45, *, frame: str = "wood", seat: str = "wood"
) -> Parts:
    """Four legs with rails and a seat."""
    yield from four_legs(w, d, h - 0.03, frame, leg=0.035, inset=0.015)
    yield from _rails(w, d, (0.45 * h, 0.45 * h + 0.025), frame, leg=0.035, inset=0.015)
    yield plate(w, d, (h - 0.03, h), seat)


def _rails(
    w: float, d: float, z: tuple[float, float], frame: str, *, leg: float, inset: float
) -> Parts:
    """Four rails between four legs."""
    x, y = w / 2 - inset, d / 2 - inset
    for left in (-x, x - 0.02):
        yield cuboid((left, left + 0.02), (-y + leg, y - leg), z, frame)
    for front in (-y, y - 0.02):
        yield cuboid((-x + leg, x - leg), (front, front + 0.02), z, frame)


def bar_stool(
    w: float = 0.4,
    d: float = 0.4,
    h: float = 0.78,
    *,
    frame: str = "metal",
    seat: str = "leather",
) -> Parts:
    """A round seat on a column; the robot does not get over its foot plate of 2.5 cm."""
    yield cylinder((0, 0), (0.5 * w, 0.5 * d), (0.0, 0.025), frame, 20)
    yield cylinder((0, 0), (0.03, 0.03), (0.025, h - 0.08), frame, 10)
    yield cuboid(
        (-0.35 * w, 0.35 * w), (-0.3 * d, -0.3 * d + 0.025), (0.3 * h, 0.3 * h + 0.025), frame
    )
    yield cuboid((-0.01, 0.01), (-0.3 * d + 0.025, -0.03), (0.3 * h, 0.3 * h + 0.025), frame)
    yield cylinder((0, 0), (0.45 * w, 0.45 * d), (h - 0.08, h), seat, 20)


def bench(
    w: float = 1.2, d: float = 0.35, h: float = 0.45, *, frame: str = "wood", seat: str = "wood"
) -> Parts:
    """Four legs, a stretcher and a long seat."""
    yield from four_legs(w, d, h - 0.04, frame, leg=LEG, inset=0.03)
    for left in (-w / 2 + 0.03, w / 2 - 0.03 - LEG):
        rail = (-d / 2 + 0.03 + LEG, d / 2 - 0.03 - LEG)
        yield cuboid((left, left + LEG), rail, (0.4 * h, 0.4 * h + 0.04), frame)
    reach = w / 2 - 0.03 - LEG
    yield cuboid((-reach, reach), (-0.02, 0.02), (0.4 * h, 0.4 * h + 0.04), frame)
    yield plate(w, d, (h - 0.04, h), seat)
