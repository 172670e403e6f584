"""New HDF5 files in place of old ones; a full disk is an error like any other."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py

from dataset.atomic import replacing
from dataset.interrupts import interrupts_held

__all__ = ["created"]


class _Sink(io.FileIO):
    """A new file for HDF5 to write to, which it is never told cannot be written.

    HDF5 crashes the process when it closes a file after a failed write. So it is left
    to finish, and `failure` has what went wrong.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, "w+")
        self.failure: OSError | None = None

    def write(self, data: Any, /) -> int:
        """Write all of it; what follows a failure goes nowhere."""
        rest = memoryview(data).cast("B")
        size = len(rest)
        try:
            while self.failure is None and len(rest):
                rest = rest[super().write(rest) :]
        except OSError as error:
            self.failure = error
        return size

    def truncate(self, size: int | None = None, /) -> int:
        """Set the size, unless a write has failed."""
        try:
            if self.failure is None:
                return super().truncate(size)
        except OSError as error:
            self.failure = error
        return size or 0


@contextmanager
def created(path: str | Path) -> Iterator[h5py.File]:
    """Replace a map file by a new one that the body fills.

    Raises
    ------
    RoomsegError
        If it cannot be written.
    """
    with interrupts_held(), replacing(path) as part, _Sink(part) as sink:
        try:
            with h5py.File(sink, "w") as file:
                yield file
        except Exception:
            # Whatever HDF5 stumbled over then: this is why.
            if sink.failure is None:
                raise
        if sink.failure is not None:
            raise sink.failure
