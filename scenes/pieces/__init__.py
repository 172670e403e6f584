"""Furniture and fittings as prisms, with real clearances.

What a robot of 10 cm meets is what stands within 10 cm of the floor: four legs
of a table or a bed, the whole of a wardrobe. Every kind is one public function of
one of the modules listed in `_MODULES`, named as in files. Its signature says all
there is to know: ``w``, ``d``, ``h`` with the default width, depth and height (m),
then a keyword for every material slot with the default material; `hangs` says at
what elevation it hangs. It yields its parts in the piece's own frame: the middle
of the footprint at the origin, the back towards +y, its underside at z = 0.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import shapely
from numpy.typing import NDArray

from scenes.apartment import Piece
from scenes.parts import Part, Parts
from scenes.pieces import (
    bathroom,
    beds,
    clutter,
    fixtures,
    kitchen,
    seating,
    storage,
    tables,
    walls,
)
from scenes.trigonometry import sine_cosine

__all__ = ["KINDS", "Kind", "piece_parts"]

_MODULES = (beds, seating, tables, storage, kitchen, bathroom, walls, fixtures, clutter)


@dataclass(frozen=True)
class Kind:
    """A kind of piece, as the signature of its function has it.

    ``size`` the default (width, depth, height), m; ``slots`` the default material
    of every slot; ``elevation`` where its underside is unless a piece says, m (above
    0: it hangs); ``build`` the function; ``summary`` the first line of its docstring.
    """

    size: tuple[float, float, float]
    slots: Mapping[str, str]
    elevation: float
    build: Callable[..., Parts]
    summary: str


def _kind(build: Callable[..., Parts]) -> Kind:
    """Read the signature of a kind's function."""
    parameters = inspect.signature(build).parameters
    w, d, h = (float(parameters[name].default) for name in "wdh")
    slots = {name: str(p.default) for name, p in parameters.items() if name not in ("w", "d", "h")}
    summary = (inspect.getdoc(build) or "").splitlines()[0]
    return Kind(
        (w, d, h), MappingProxyType(slots), vars(build).get("elevation", 0.0), build, summary
    )


def _kinds() -> Iterator[tuple[str, Kind]]:
    for module in _MODULES:
        for name, value in inspect.getmembers(module, inspect.isfunction):
            if value.__module__ == module.__name__ and not name.startswith("_"):
                yield name, _kind(value)


KINDS: Mapping[str, Kind] = MappingProxyType(dict(sorted(_kinds())))
"""Every kind by its name in files."""


def piece_parts(piece: Piece) -> list[Part]:
    """Parts of a piece in the scene frame.

    Raises
    ------
    KeyError
        If the kind is not in `KINDS`.
    ValueError
        If the size leaves no room for a part.
    """
    kind = KINDS[piece.kind]
    # Rounding keeps quarter turns exact, so that edges stay parallel to the walls.
    s, c = (round(value, 15) for value in sine_cosine(math.radians(piece.rotation_deg)))
    parts = list(kind.build(*(piece.size or kind.size), **piece.materials))
    z = kind.elevation if piece.elevation is None else piece.elevation

    def moved(xy: NDArray[np.float64]) -> NDArray[np.float64]:
        x, y = xy.T
        turned: NDArray[np.float64] = (
            np.column_stack([c * x - s * y, s * x + c * y]) + piece.position
        )
        return turned

    footprints = shapely.transform([part.footprint for part in parts], moved)
    return [
        Part(shape, part.bottom + z, part.top + z, part.material)
        for shape, part in zip(footprints, parts, strict=True)
    ]
