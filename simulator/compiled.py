"""Machine code for the loops of every time step (numba); kept on disk for the next start."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

from scenes import trigonometry

__all__ = ["compiled", "is_kept"]

Function = TypeVar("Function", bound=Callable[..., object])


def _sources() -> str:
    """Digest of the source files of this package, and of what else it compiles."""
    files = [*sorted(Path(__file__).parent.glob("*.py")), Path(trigonometry.__file__)]
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()


_STAMP = _sources()


def compiled(function: Function) -> Function:
    """Compile on first use.

    Without ``fastmath``: sums keep their order, so that every machine gives the same bytes.
    """
    dispatcher = numba.njit(cache=True)(function)
    # What is kept holds the functions that it calls, too; numba looks at one file only.
    dispatcher._cache._cache_file._source_stamp = _STAMP
    return cast(Function, dispatcher)


def is_kept(function: Callable[..., object]) -> bool:
    """Tell whether machine code of a compiled function is on disk; if not, its first call waits."""
    index = cast(Any, function)._cache._cache_file._load_index()
    return bool(index)
