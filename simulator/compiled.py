"""Machine code for the loops of every time step (numba); kept on disk for the next start."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numba

__all__ = ["compiled"]

Function = TypeVar("Function", bound=Callable[..., object])


def compiled(function: Function) -> Function:
    """Compile on first use.

    Without ``fastmath``: sums keep their order, so that every machine gives the same bytes.
    """
    return cast(Function, numba.njit(cache=True)(function))
