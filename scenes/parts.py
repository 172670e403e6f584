"""The prisms that pieces of furniture and lamps are made of, in the piece's own frame."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import shapely
from shapely import Polygon

from scenes.trigonometry import sine_cosine

__all__ = ["LEG", "Part", "Parts", "Span", "cuboid", "cylinder", "four_legs", "hangs", "plate"]

LEG = 0.05
"""Thickness of an ordinary leg, m."""

Span = tuple[float, float]
"""From, to, m."""


@dataclass(frozen=True)
class Part:
    """A vertical prism of a piece: footprint, bottom and top (m), material.

    Raises
    ------
    ValueError
        If it is no single polygon with an area and a height: the piece is too small.
    """

    footprint: Polygon
    bottom: float
    top: float
    material: str

    def __post_init__(self) -> None:
        whole = self.footprint.geom_type == "Polygon" and self.footprint.area > 0.0
        if not (whole and self.footprint.is_valid and self.top - self.bottom > 1e-6):
            raise ValueError(f"no room for its {self.material}")


Parts = Iterator[Part]
_Build = TypeVar("_Build", bound=Callable[..., Parts])


def hangs(elevation: float) -> Callable[[_Build], _Build]:
    """Mark a kind of piece as hung: where its underside is unless a piece says, m."""

    def mark(build: _Build) -> _Build:
        vars(build)["elevation"] = elevation
        return build

    return mark


def cuboid(x: Span, y: Span, z: Span, material: str) -> Part:
    """An upright block.

    Raises
    ------
    ValueError
        If it has no extent along an axis: the piece is too small for it.
    """
    for name, (low, high) in zip("xyz", (x, y, z), strict=True):
        if not high - low > 1e-6:
            raise ValueError(f"no room for its {material} along {name}")
    return Part(shapely.box(x[0], y[0], x[1], y[1]), z[0], z[1], material)


def plate(w: float, d: float, z: Span, material: str) -> Part:
    """A block over the whole of a w x d footprint.

    Raises
    ------
    ValueError
        As `cuboid`.
    """
    return cuboid((-w / 2, w / 2), (-d / 2, d / 2), z, material)


def cylinder(
    centre: tuple[float, float],
    radii: tuple[float, float],
    z: Span,
    material: str,
    corners: int = 16,
) -> Part:
    """An upright elliptic cylinder (m) as a polygon of that many corners.

    Raises
    ------
    ValueError
        If it has no radius or no height: the piece is too small for it.
    """
    if not min(radii) > 0.0:
        raise ValueError(f"no room for its {material}")
    angle = (np.arange(corners) + 0.5) * 2.0 * np.pi / corners
    sine, cosine = np.array([sine_cosine(a) for a in angle.tolist()]).T
    ring = np.column_stack([centre[0] + radii[0] * cosine, centre[1] + radii[1] * sine])
    return Part(Polygon(ring), z[0], z[1], material)


def four_legs(
    w: float, d: float, top: float, material: str, *, leg: float = LEG, inset: float = 0.0
) -> Parts:
    """Four legs in the corners of a w x d footprint."""
    x, y = w / 2 - inset, d / 2 - inset
    for left in (-x, x - leg):
        for front in (-y, y - leg):
            yield cuboid((left, left + leg), (front, front + leg), (0.0, top), material)
