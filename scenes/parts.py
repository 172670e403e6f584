"""The prisms that pieces of furniture and lamps are made of, in the piece's own frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import Polygon

__all__ = ["LEG", "Part", "Parts", "Span", "box", "disc", "legs"]

LEG = 0.05
"""Thickness of an ordinary leg, m."""

Span = tuple[float, float]
"""From, to, m."""


@dataclass(frozen=True)
class Part:
    """A vertical prism of a piece: footprint, bottom and top (m), material slot."""

    footprint: Polygon
    bottom: float
    top: float
    slot: str


Parts = Iterator[Part]


def box(x: Span, y: Span, z: Span, slot: str) -> Part:
    """An upright block.

    Raises
    ------
    ValueError
        If it has no extent along an axis: the piece is too small for it.
    """
    for name, (low, high) in zip("xyz", (x, y, z), strict=True):
        if not high - low > 1e-6:
            raise ValueError(f"no room for its {slot} along {name}")
    return Part(shapely.box(x[0], y[0], x[1], y[1]), z[0], z[1], slot)


def disc(
    centre: tuple[float, float],
    radii: tuple[float, float],
    z: Span,
    slot: str,
    corners: int = 16,
) -> Part:
    """An upright elliptic cylinder (m) as a polygon of that many corners.

    Raises
    ------
    ValueError
        If it has no radius or no height: the piece is too small for it.
    """
    if not (min(radii) > 0.0 and z[1] - z[0] > 1e-6):
        raise ValueError(f"no room for its {slot}")
    angle = (np.arange(corners) + 0.5) * 2.0 * np.pi / corners
    x, y = radii[0] * np.cos(angle), radii[1] * np.sin(angle)
    return Part(Polygon(np.column_stack([centre[0] + x, centre[1] + y])), z[0], z[1], slot)


def legs(
    w: float, d: float, top: float, slot: str, *, leg: float = LEG, inset: float = 0.0
) -> Parts:
    """Four legs in the corners of a w × d footprint."""
    x, y = w / 2 - inset, d / 2 - inset
    for left in (-x, x - leg):
        for front in (-y, y - leg):
            yield box((left, left + leg), (front, front + leg), (0.0, top), slot)
