"""Maps from the runs of real robots: what they drove and saw.

Every reader is a function ``read_<format>(path, **options) -> ImportedRun``.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dataset.topomap import TopoMap

__all__ = ["ImportedRun"]


@dataclass(frozen=True)
class ImportedRun:
    """What a reader found.

    Attributes
    ----------
    topomap : TopoMap
    notes : tuple of str
        What could not be used or had to be guessed, one line each.
    images : iterable of arrays (rows, columns) uint8 or None, optional
        One for each node, if the robot has a camera; None for a node without.
    """

    topomap: TopoMap
    notes: tuple[str, ...] = ()
    images: Iterable[NDArray[np.uint8] | None] | None = None
