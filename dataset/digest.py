"""What tells the content of one map file from another's."""

from __future__ import annotations

import hashlib
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

__all__ = ["map_digest"]

NO_CONTENT = {"rooms", "images"}
"""Groups that are left out: what was found in the map, and the images, which come by themselves."""


def map_digest(file: h5py.File, pixels: h5py.Dataset | None, done: NDArray[np.bool_]) -> str:
    """SHA-256 of a map and its images.

    Parameters
    ----------
    file : h5py.File
    pixels : h5py.Dataset or None
        ``/images/pixels``, if there are images.
    done : array of bool, shape (n,)
        Which nodes have an image.
    """
    digest = hashlib.sha256(_described("", file))

    def add(name: str, item: h5py.HLObject) -> None:
        if name.partition("/")[0] not in NO_CONTENT:
            digest.update(_described(name, item))

    file.visititems(add)
    for index in np.flatnonzero(done).tolist():
        digest.update(index.to_bytes(4, "little"))
        digest.update(_stored_bytes(pixels, index))
    return digest.hexdigest()


def _described(name: str, item: h5py.HLObject) -> bytes:
    """Name, attributes and, of an array, the values."""
    attributes = {key: np.asarray(item.attrs[key]).tolist() for key in sorted(item.attrs)}
    value = item[()] if isinstance(item, h5py.Dataset) else b""
    content = value if isinstance(value, bytes) else np.asarray(value).tobytes()
    return f"{name}{attributes!r}".encode() + content


def _stored_bytes(pixels: Any, index: int) -> bytes:
    """The bytes of an image as they lie in the file, which need not be unpacked."""
    if pixels.chunks == (1, *pixels.shape[1:]):
        return bytes(pixels.id.read_direct_chunk((index, 0, 0))[1])
    return np.asarray(pixels[index]).tobytes()
