"""The OpenImageDenoise library that comes with Blender, called directly.

Blender runs it over whole renders only. Baked light needs more: a picture of texels is
denoised chart by chart, and of an image only what was traced, since the rest has no noise.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from dataset.errors import RoomsegError

__all__ = ["Denoiser"]

CPU = 1
FLOAT3 = 3
QUALITIES = {"fast": 4, "high": 6}
Picture = NDArray[np.float32]


class Denoiser:
    """Denoises linear pictures on the processor; the same pixels whatever the threads.

    Parameters
    ----------
    bpy : module
    threads : int, optional
        All cores if absent.

    Raises
    ------
    RoomsegError
        If the library is not there or does not start.
    """

    def __init__(self, bpy: Any, threads: int | None = None) -> None:
        self._library = _load(bpy)
        self._device = self._library.oidnNewDevice(CPU)
        self._library.oidnSetDeviceInt(
            self._device, b"numThreads", threads or len(os.sched_getaffinity(0))
        )
        # Threads bound to cores would be in the way of other jobs' threads.
        self._library.oidnSetDeviceBool(self._device, b"setAffinity", False)
        self._library.oidnCommitDevice(self._device)
        self._check()

    def __call__(
        self,
        picture: Picture,
        guides: Mapping[Literal["albedo", "normal"], Picture] | None = None,
        quality: Literal["fast", "high"] = "high",
    ) -> Picture:
        """A picture (rows, columns, 3) without its noise.

        Parameters
        ----------
        picture : array, shape (rows, columns, 3), float32
            Linear, of any brightness.
        guides : mapping, optional
            Pictures without noise that have the edges: 'albedo' (0..1), with or without
            'normal'.
        quality : {'fast', 'high'}

        Raises
        ------
        RoomsegError
            If the library fails.
        """
        made = np.empty(picture.shape, dtype=np.float32)
        kept = {"color": np.ascontiguousarray(picture, np.float32)}
        for name, item in (guides or {}).items():
            kept[name] = np.ascontiguousarray(item, np.float32)
        kept["output"] = made
        library, run = self._library, self._library.oidnNewFilter(self._device, b"RT")
        rows, columns, _ = picture.shape
        for role, item in kept.items():
            library.oidnSetSharedFilterImage(
                run, role.encode(), item.ctypes.data, FLOAT3, columns, rows, 0, 0, 0
            )
        library.oidnSetFilterBool(run, b"hdr", True)
        library.oidnSetFilterBool(run, b"cleanAux", guides is not None)
        library.oidnSetFilterInt(run, b"quality", QUALITIES[quality])
        library.oidnCommitFilter(run)
        library.oidnExecuteFilter(run)
        library.oidnReleaseFilter(run)
        self._check()
        return made

    def _check(self) -> None:
        message = ctypes.c_char_p()
        if self._library.oidnGetDeviceError(self._device, ctypes.byref(message)):
            said = (message.value or b"failed").decode(errors="replace")
            raise RoomsegError(f"Blender: OpenImageDenoise: {' '.join(said.split())}")


def _load(bpy: Any) -> Any:
    """The library beside ``bpy``, its functions declared."""
    folder = Path(bpy.utils.resource_path("LOCAL")).parent / "lib"
    found = sorted(folder.glob("*OpenImageDenoise.*"), key=lambda path: len(path.name))
    if not found:
        raise RoomsegError(f"Blender: OpenImageDenoise: not found in {folder}")
    library = ctypes.CDLL(str(found[0]))
    pointer, text, number, size = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_size_t
    flag = ctypes.c_bool
    image = [pointer, text, pointer, number, size, size, size, size, size]
    for name, result, arguments in (
        ("oidnNewDevice", pointer, [number]),
        ("oidnSetDeviceInt", None, [pointer, text, number]),
        ("oidnSetDeviceBool", None, [pointer, text, flag]),
        ("oidnCommitDevice", None, [pointer]),
        ("oidnGetDeviceError", number, [pointer, ctypes.POINTER(text)]),
        ("oidnNewFilter", pointer, [pointer, text]),
        ("oidnSetSharedFilterImage", None, image),
        ("oidnSetFilterBool", None, [pointer, text, flag]),
        ("oidnSetFilterInt", None, [pointer, text, number]),
        ("oidnCommitFilter", None, [pointer]),
        ("oidnExecuteFilter", None, [pointer]),
        ("oidnReleaseFilter", None, [pointer]),
    ):
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library
