"""Apartments from what others have: grid maps, drawings, slices of 3D scenes.

Every reader is a function ``read_<format>(path, **options) -> Imported``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from scenes.apartment import Apartment

__all__ = ["Imported", "first_of"]


@dataclass(frozen=True)
class Imported:
    """What a reader found.

    Attributes
    ----------
    apartment : Apartment
    notes : tuple of str
        What could not be used or had to be guessed, one line per element.
    """

    apartment: Apartment
    notes: tuple[str, ...] = ()


def first_of(labels: Sequence[str], most: int = 3) -> str:
    """The first of several things of which one note tells, and how many more there are."""
    more = f" and {len(labels) - most} more" if len(labels) > most else ""
    return ", ".join(labels[:most]) + more
