"""Closed bodies with doors and drawers, which storage, kitchen and bathroom share."""

from __future__ import annotations

from scenes.parts import Parts, Span, cuboid

__all__ = ["cabinet", "carcass", "doors", "drawers", "handle"]


def doors(
    w: float, y: float, z: Span, target: float, *, materials: tuple[str, str], x: float = 0.0
) -> Parts:
    """Doors of about ``target`` width, 2 cm thick, before the front face at ``y``.

    ``materials`` are those of the doors and of their handles; ``x`` the middle.
    """
    fronts, handles = materials
    count = max(1, round(w / target))
    step = w / count
    for k in range(count):
        left = x - w / 2 + k * step
        across = (left + 0.003, x - w / 2 + (k + 1) * step - 0.003)
        yield cuboid(across, (y, y + 0.02), z, fronts)
        yield cuboid((across[1] - 0.05, across[1] - 0.035), (y - 0.02, y), handle(z), handles)


def drawers(
    w: float, y: float, z: Span, count: int, *, materials: tuple[str, str], x: float = 0.0
) -> Parts:
    """A column of drawers with bar handles before the front face at ``y``."""
    fronts, handles = materials
    step = (z[1] - z[0]) / count
    for k in range(count):
        low = z[0] + k * step
        span, across = (low + 0.003, low + step - 0.003), (x - w / 2 + 0.003, x + w / 2 - 0.003)
        yield cuboid(across, (y, y + 0.02), span, fronts)
        bar, middle = 0.15 * w, low + 0.7 * step
        yield cuboid((x - bar, x + bar), (y - 0.02, y), (middle - 0.008, middle + 0.008), handles)


def handle(z: Span) -> Span:
    """Heights of a handle in the middle of a front."""
    middle, half = (z[0] + z[1]) / 2, min(0.07, (z[1] - z[0]) / 4)
    return middle - half, middle + half


def cabinet(
    w: float, d: float, h: float, plinth: float, target: float, *, materials: tuple[str, str, str]
) -> Parts:
    """A closed body over a recessed plinth, with doors; the footprint is w x d.

    ``materials`` are those of body, doors and handles.
    """
    yield from carcass(w, d, h, plinth, materials[0])
    z = (plinth + 0.005, h - 0.005)
    yield from doors(w, -d / 2 + 0.02, z, target, materials=materials[1:])


def carcass(w: float, d: float, h: float, plinth: float, body: str) -> Parts:
    """A closed body over a recessed plinth, its face 4 cm behind the footprint's front."""
    front = -d / 2 + 0.02
    yield cuboid((-w / 2, w / 2), (front + 0.07, d / 2), (0.0, plinth), body)
    yield cuboid((-w / 2, w / 2), (front + 0.02, d / 2), (plinth, h), body)
