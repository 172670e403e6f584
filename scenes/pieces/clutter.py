"""What stands and lies about; conventions as `scenes.pieces`."""

from __future__ import annotations

import numpy as np
import shapely

from scenes.parts import Part, Parts, cuboid, cylinder, plate
from scenes.trigonometry import sine_cosine


def box(w: float = 0.5, d: float = 0.4, h: float = 0.5, *, body: str = "wood_light") -> Parts:
    """A plain box."""
    yield plate(w, d, (0.0, h), body)


def rug(w: float = 2.0, d: float = 1.4, h: float = 0.008, *, fabric: str = "carpet_red") -> Parts:
    """Flat on the floor, lower than what counts as an obstacle: driven over."""
    yield plate(w, d, (0.0, h), fabric)


def door_mat(
    w: float = 0.7, d: float = 0.45, h: float = 0.009, *, mat: str = "coir", edge: str = "rubber"
) -> Parts:
    """Low enough to be driven over."""
    outer = shapely.box(-w / 2, -d / 2, w / 2, d / 2)
    inner = outer.buffer(-0.03, join_style="mitre")
    yield Part(outer.difference(inner), 0.0, h, edge)
    yield Part(inner, 0.0, h, mat)


def cable(
    w: float = 1.5, d: float = 0.3, h: float = 0.009, *, sheath: str = "plastic_black"
) -> Parts:
    """A bent cable as thick as its height; up to 1 cm the robot drives over it and leans."""
    if w < 10.0 * h or d < 4.0 * h:
        raise ValueError("no room for its bends")
    x = np.linspace(-w / 2 + h, w / 2 - h, 25)
    sine = np.array([sine_cosine(3.0 * np.pi * place / w)[0] for place in x.tolist()])
    cosine = np.array([sine_cosine(np.pi * place / w)[1] for place in x.tolist()])
    y = (d / 2 - h) * sine * np.sqrt(cosine)
    line = shapely.LineString(np.column_stack([x, y]))
    yield Part(line.buffer(h / 2, quad_segs=2), 0.0, h, sheath)


def shoes(w: float = 0.28, d: float = 0.3, h: float = 0.11, *, upper: str = "leather") -> Parts:
    """A pair, toes to the front."""
    for middle in (-0.26 * w, 0.26 * w):
        x = (middle - 0.18 * w, middle + 0.18 * w)
        yield cuboid(x, (-d / 2, d / 2), (0.0, 0.3 * h), upper)
        yield cuboid(x, (-0.45 * d, 0.05 * d), (0.3 * h, 0.6 * h), upper)
        yield cuboid(x, (0.05 * d, 0.48 * d), (0.3 * h, h), upper)


def toys(
    w: float = 0.6,
    d: float = 0.6,
    h: float = 0.12,
    *,
    first: str = "plastic_red",
    second: str = "plastic_yellow",
    third: str = "plastic_blue",
) -> Parts:
    """Five blocks and a drum, spread over the floor."""
    spots = (
        (-0.35, -0.3),
        (0.05, -0.38),
        (0.36, -0.12),
        (-0.12, 0.05),
        (-0.38, 0.33),
        (0.25, 0.36),
    )
    for k, (x, y) in enumerate(spots):
        material, size = (first, second, third)[k % 3], (0.5, 0.8, 0.65)[k % 3] * h
        if k % 4 == 3:
            yield cylinder((x * w, y * d), (0.5 * h, 0.5 * h), (0.0, h), material, 12)
        else:
            half = size / 2
            across = (x * w - half, x * w + half)
            yield cuboid(across, (y * d - half, y * d + half), (0.0, size), material)


def pet_bowl(
    w: float = 0.5, d: float = 0.25, h: float = 0.06, *, bowl: str = "metal", food: str = "soil"
) -> Parts:
    """Two bowls, one with food."""
    radius = min(0.24 * w, 0.5 * d)
    for x in (-0.25 * w, 0.25 * w):
        outer = cylinder((x, 0), (radius, radius), (0.0, 0.3 * h), bowl, 20)
        yield outer
        inner = outer.footprint.buffer(-0.12 * radius)
        yield Part(outer.footprint.difference(inner), 0.3 * h, h, bowl)
        if x < 0:
            yield Part(inner, 0.3 * h, 0.6 * h, food)


def plant(
    w: float = 0.6,
    d: float = 0.6,
    h: float = 1.2,
    *,
    pot: str = "tiles_terracotta",
    soil: str = "soil",
    stem: str = "wood",
    leaves: str = "leaves",
) -> Parts:
    """A pot and layers of leaves."""
    rim = 0.25 * h
    yield cylinder((0, 0), (0.32 * w, 0.32 * d), (0.0, rim), pot)
    yield cylinder((0, 0), (0.29 * w, 0.29 * d), (rim, rim + 0.01), soil)
    yield cylinder((0, 0), (0.04 * w, 0.04 * d), (rim + 0.01, 0.5 * h), stem, 6)
    for k, (radius, top) in enumerate(((0.38, 0.62), (0.5, 0.78), (0.42, 0.9), (0.24, 1.0))):
        low = (0.5, 0.62, 0.78, 0.9)[k] * h
        yield cylinder((0, 0), (radius * w, radius * d), (low, top * h), leaves, 7 + k)


def floor_lamp(
    w: float = 0.4,
    d: float = 0.4,
    h: float = 1.6,
    *,
    stand: str = "metal_dark",
    shade: str = "paper",
) -> Parts:
    """A dark lamp: a foot, a rod and a shade (see `scenes.lamps` for light)."""
    yield cylinder((0, 0), (0.4 * w, 0.4 * d), (0.0, 0.03), stand)
    yield cylinder((0, 0), (0.015, 0.015), (0.03, h - 0.25), stand, 8)
    yield cylinder((0, 0), (0.5 * w, 0.5 * d), (h - 0.25, h), shade, 20)


def umbrella_stand(
    w: float = 0.25,
    d: float = 0.25,
    h: float = 0.85,
    *,
    body: str = "metal_dark",
    umbrellas: str = "fabric_red",
) -> Parts:
    """A tube with two umbrellas in it."""
    outer = cylinder((0, 0), (w / 2, d / 2), (0.0, 0.02), body, 16)
    yield outer
    yield Part(outer.footprint.difference(outer.footprint.buffer(-0.01)), 0.02, 0.6 * h, body)
    for x, top in ((-0.18, 1.0), (0.15, 0.9)):
        yield cylinder((x * w, 0.05 * d), (0.11 * w, 0.11 * d), (0.02, 0.8 * top * h), umbrellas, 8)
        yield cylinder((x * w, 0.05 * d), (0.04 * w, 0.04 * d), (0.8 * top * h, top * h), body, 6)


def waste_bin(
    w: float = 0.3,
    d: float = 0.3,
    h: float = 0.6,
    *,
    body: str = "metal",
    lid: str = "plastic_black",
) -> Parts:
    """A round bin with a lid."""
    yield cylinder((0, 0), (0.48 * w, 0.48 * d), (0.0, 0.03), lid, 20)
    yield cylinder((0, 0), (0.47 * w, 0.47 * d), (0.03, 0.88 * h), body, 20)
    yield cylinder((0, 0), (0.5 * w, 0.5 * d), (0.88 * h, h - 0.02), lid, 20)
    yield cylinder((0, 0), (0.36 * w, 0.36 * d), (h - 0.02, h), lid, 20)
