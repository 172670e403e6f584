"""Blender's system libraries: load bpy, or say in one line what is missing.

The bpy wheel brings Blender but not the X11 and OpenGL libraries that it is
linked with, even though no window is ever opened. ``python -m render.libraries``
checks them and exits with code 2 if one is missing.
"""

from __future__ import annotations

import importlib
import re
import sys
from ctypes.util import find_library
from types import ModuleType

from dataset.errors import RoomsegError

__all__ = ["DEBIAN_PACKAGES", "MissingLibraryError", "explain", "load_bpy"]

DEBIAN_PACKAGES = {
    "libX11": "libx11-6",
    "libXrender": "libxrender1",
    "libXfixes": "libxfixes3",
    "libXi": "libxi6",
    "libxkbcommon": "libxkbcommon0",
    "libSM": "libsm6",
    "libICE": "libice6",
    "libGL": "libgl1",
}
"""Debian package of each library, by the stem of its file name."""


class MissingLibraryError(RoomsegError):
    """Blender cannot be loaded; the message names the library and its package."""


def explain(error: ImportError) -> str:
    """One line on why bpy does not load and what to install.

    Parameters
    ----------
    error : ImportError
        As raised by ``import bpy``.
    """
    if isinstance(error, ModuleNotFoundError):
        return "Blender (bpy): not installed, expected: pip install bpy==5.0.1 (Python 3.11)"
    match = re.search(r"(lib\w+)\.so[.\d]*", str(error))
    if match is None:
        return f"Blender (bpy): cannot be loaded: {' '.join(str(error).split())}"
    # The loader names only the first; a user wants to install all of them at once.
    packages = [
        package
        for library, package in DEBIAN_PACKAGES.items()
        if library == match[1] or find_library(library.removeprefix("lib")) is None
    ]
    install = " ".join(packages if match[1] in DEBIAN_PACKAGES else DEBIAN_PACKAGES.values())
    return (
        f"Blender (bpy): system library {match[0]} is missing, expected: apt-get install {install}"
    )


def load_bpy() -> ModuleType:
    """Import and return bpy.

    Raises
    ------
    MissingLibraryError
        If bpy or a system library is missing.
    """
    try:
        return importlib.import_module("bpy")
    except ImportError as error:
        raise MissingLibraryError(explain(error)) from error


def main() -> int:
    """Load bpy; print one line and return 2 if that fails."""
    try:
        load_bpy()
    except MissingLibraryError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.stdout.flush()
    status = main()
    # Blender can hang while the interpreter shuts down, so leave without it.
    import os

    sys.stderr.flush()
    os._exit(status)
