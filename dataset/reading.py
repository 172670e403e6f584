"""Opening map files: whatever a bad one makes h5py raise becomes one line that names it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from dataset.errors import FormatError
from dataset.layout import check_format

__all__ = ["begins_as_hdf5", "errors_of", "open_map", "opened"]


@contextmanager
def errors_of(path: str | Path) -> Iterator[None]:
    """Turn whatever a bad file makes h5py raise into one line that names the file."""
    try:
        yield
    except FormatError as error:
        message = str(error)
        named = message.startswith(f"{path}: ")
        raise FormatError(message if named else f"{path}: {message}") from error
    except (OSError, KeyError, RuntimeError, ValueError, TypeError, MemoryError) as error:
        reason = " ".join(str(error).split())
        raise FormatError(f"{path}: damaged map file ({reason})") from error


@contextmanager
def opened(path: str | Path) -> Iterator[h5py.File]:
    """Open a map file for reading; every error names it."""
    with errors_of(path), open_map(path) as file:
        yield file


def begins_as_hdf5(path: Path) -> bool:
    """Whether a file that is there begins with the signature of HDF5."""
    with path.open("rb") as stream:
        return stream.read(8) == b"\x89HDF\r\n\x1a\n"


def open_map(path: str | Path) -> h5py.File:
    """Open a map file for reading.

    Raises
    ------
    FormatError
        If there is none, it cannot be read, is cut off, or is no roomseg map.
    """
    path = Path(path)
    if path.is_dir() or not path.exists():
        what = "is a folder" if path.is_dir() else "no such file"
        raise FormatError(f"{path}: {what}, expected a map file (.h5)")
    if not os.access(path, os.R_OK):
        raise FormatError(f"{path}: not readable, check its permissions")
    if not begins_as_hdf5(path):
        raise FormatError(f"{path}: not an HDF5 file, expected a map file (.h5)")
    with errors_of(path):
        try:
            file = h5py.File(path, "r")
        except OSError as error:
            raise FormatError(
                f"{path}: cut off or damaged HDF5 file, expected a complete map file"
            ) from error
        try:
            check_format(file)
        except FormatError:
            file.close()
            raise
        return file
