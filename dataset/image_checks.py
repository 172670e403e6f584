"""What can be wrong with the images of a map file; one at a time, as all are large."""

from __future__ import annotations

from collections.abc import Iterator

import h5py
import numpy as np
from numpy.typing import NDArray

__all__ = ["image_problems", "radiance_problems"]


def image_problems(pixels: h5py.Dataset, index: int) -> Iterator[str]:
    """Yield what is wrong with the image of a node."""
    if pixels.chunks is not None and pixels.chunks[0] == 1:
        stored = pixels.id.get_chunk_info_by_coord((index, 0, 0))
        if stored.byte_offset is None:
            yield f"/images/done: node {index} is marked done, but has no image"
            return
    try:
        pixels[index]
    except (OSError, RuntimeError, ValueError):
        yield f"/images/pixels: the image of node {index} is damaged"


def radiance_problems(
    file: h5py.File, shape: tuple[int, ...], done: NDArray[np.intp]
) -> Iterator[str]:
    """Yield what is wrong with the radiance of the nodes ``done``; ``shape`` as the images."""
    radiance, exponent = file["images/radiance"], file.get("images/radiance_exponent")
    if (
        not isinstance(radiance, h5py.Dataset)
        or radiance.shape != shape
        or radiance.dtype != np.float16
    ):
        yield f"/images/radiance: expected float16 {shape}"
        return
    if (
        not isinstance(exponent, h5py.Dataset)
        or exponent.dtype.kind != "i"
        or exponent.shape != shape[:1]
    ):
        yield f"/images/radiance_exponent: expected {shape[0]} whole numbers"
    for index in done.tolist():
        try:
            good = bool(np.isfinite(radiance[index]).all())
        except (OSError, RuntimeError, ValueError):
            good = False
        if not good:
            yield f"/images/radiance: that of node {index} is damaged"
