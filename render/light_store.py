"""Baked light in files: made once, shared by all runs and workers, safe to delete.

A file lies in the folder ``bakes`` beside the map. Its name tells the apartment and what
its light depends on: everything of the apartment but names, words and the start, the
settings of the bake, and the versions of Blender and of the way to bake. Who finds a
file being made waits for it.
"""

from __future__ import annotations

import hashlib
import json
import zipfile
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dataset.atomic import locked, remove_leftovers, replacing, unwritten
from render.presets import Bake
from scenes.apartment import Apartment

__all__ = ["FOLDER", "bake_path", "stored_light"]

FOLDER = "bakes"
VERSION = 1
"""Raised whenever `render.baking` would make other light of the same apartment."""
DARK = {"name", "description", "start", "borders", "passageway_contrast"}
"""What of an apartment no light depends on."""
Picture = NDArray[np.float32]


def bake_path(apartment: Apartment, settings: Bake, folder: str | Path, blender: str = "") -> Path:
    """Where the light of an apartment is kept for maps in ``folder``."""
    fields = {
        "version": VERSION,
        "blender": blender,
        "settings": asdict(settings),
        "apartment": apartment.model_dump(mode="json", exclude=DARK),
    }
    key = hashlib.sha256(json.dumps(fields, sort_keys=True).encode()).hexdigest()
    return Path(folder) / FOLDER / f"{apartment.name}-{key[:16]}.npz"


def stored_light(path: Path, shape: tuple[int, int], make: Callable[[], Picture]) -> Picture:
    """The light in ``path``; made and stored first if it is not there or damaged.

    Parameters
    ----------
    path : Path
    shape : tuple of int
        (rows, columns) that it must have.
    make : callable

    Returns
    -------
    array, shape (rows, columns, 3), float32
        As stored, in half precision: the same from a new file and an old one.

    Raises
    ------
    RoomsegError
        If the file cannot be written.
    """
    found = _load(path, shape)
    if found is not None:
        return found
    try:
        path.parent.mkdir(exist_ok=True)
    except OSError as error:
        raise unwritten(path, error) from error
    with locked(path, wait=True):
        remove_leftovers(path)
        found = _load(path, shape)
        if found is not None:
            return found
        half = np.clip(make(), 0.0, np.finfo(np.float16).max).astype(np.float16)
        with replacing(path) as part, part.open("wb") as stream:
            np.savez_compressed(stream, light=half)
    return half.astype(np.float32)


def _load(path: Path, shape: tuple[int, int]) -> Picture | None:
    """The light in a file; None if it is absent, damaged or of another shape."""
    try:
        with np.load(path, allow_pickle=False) as stored:
            light = stored["light"]
    except (OSError, EOFError, KeyError, ValueError, zipfile.BadZipFile):
        return None
    if light.shape != (*shape, 3) or light.dtype != np.float16 or not np.isfinite(light).all():
        return None
    found: Picture = light.astype(np.float32)
    return found
