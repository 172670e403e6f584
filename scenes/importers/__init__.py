"""Apartments from what others have: grid maps, drawings, slices of 3D scenes.

Every reader is a function ``read_<format>(path, **options) -> Imported``.
"""

from __future__ import annotations

from dataclasses import dataclass

from scenes.apartment import Apartment

__all__ = ["Imported"]


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
