"""Results that took long, kept by the content of what they were made from."""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dataset.atomic import replacing

__all__ = ["Cache"]

Arrays = Mapping[str, NDArray[Any]]

COMPUTATION = 2
"""Counted up when the same maps and parameters give other results."""


@dataclass(frozen=True)
class Cache:
    """A folder of arrays; without a folder, nothing is kept.

    A file's name holds a hash of everything that its content depends on. So a file that is
    there is right, and what has changed is made anew beside it.
    """

    folder: Path | None = None

    def get(self, name: str, depends_on: object, make: Callable[[], Arrays]) -> Arrays:
        """Return what is there, or make and keep it.

        Parameters
        ----------
        name : str
            Begins the file's name, for people.
        depends_on : object
            Its ``repr`` says all that the arrays depend on.
        make : callable
            Makes the arrays by their names; none of objects.
        """
        if self.folder is None:
            return make()
        digest = hashlib.sha256(repr((COMPUTATION, depends_on)).encode()).hexdigest()[:20]
        path = self.folder / f"{name}-{digest}.npz"
        found = _loaded(path)
        if found is None:
            found = make()
            self.folder.mkdir(parents=True, exist_ok=True)
            with replacing(path) as part:
                part.write_bytes(_packed(found))
        return found


def _packed(arrays: Arrays) -> bytes:
    stream = io.BytesIO()
    np.savez_compressed(stream, **dict(arrays))
    return stream.getvalue()


def _loaded(path: Path) -> Arrays | None:
    """The arrays of a file; None if there is none, or it is damaged."""
    if not path.is_file():
        return None
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except (OSError, ValueError, zipfile.BadZipFile, EOFError):
        return None
