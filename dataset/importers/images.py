"""Camera messages of ROS as grey images."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from dataset.errors import FormatError

__all__ = ["grey_image"]

CHANNELS = {"mono8": 1, "8UC1": 1, "rgb8": 3, "bgr8": 3, "8UC3": 3, "rgba8": 4, "bgra8": 4}
"""Of the encodings that can be read."""


def grey_image(message: Any, turn_deg: int, where: str) -> NDArray[np.uint8]:
    """A ``sensor_msgs`` Image or CompressedImage, shape (rows, columns).

    Parameters
    ----------
    message : Image or CompressedImage
    turn_deg : int
        Quarter turns, counter-clockwise, that put what is ahead to the right.
    where : str
        What an error names.

    Raises
    ------
    FormatError
        If it cannot be decoded.
    """
    data = np.asarray(message.data, dtype=np.uint8)
    image = _plain(message, data, where) if hasattr(message, "encoding") else _packed(data, where)
    return np.ascontiguousarray(np.rot90(image, turn_deg // 90))


def _packed(data: NDArray[np.uint8], where: str) -> NDArray[np.uint8]:
    image = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE) if len(data) else None
    if image is None:
        raise FormatError(f"{where}: an image that cannot be decoded, expected JPEG or PNG")
    return np.asarray(image, dtype=np.uint8)


def _plain(message: Any, data: NDArray[np.uint8], where: str) -> NDArray[np.uint8]:
    channels = CHANNELS.get(message.encoding)
    if channels is None:
        raise FormatError(
            f"{where}: encoding {message.encoding!r}, expected one of {', '.join(CHANNELS)}"
        )
    rows, columns, step = int(message.height), int(message.width), int(message.step)
    if step < columns * channels or len(data) < rows * step or not rows * columns:
        raise FormatError(
            f"{where}: {len(data)} bytes of {rows} x {columns} pixels, expected {rows * step}"
        )
    pixels = data[: rows * step].reshape(rows, step)[:, : columns * channels]
    if channels == 1:
        return pixels
    order = "BGR" if message.encoding.startswith(("bgr", "8UC")) else "RGB"
    alpha = "A" if channels == 4 else ""
    colours = np.ascontiguousarray(pixels.reshape(rows, columns, channels))
    code = getattr(cv2, f"COLOR_{order}{alpha}2GRAY")
    return np.asarray(cv2.cvtColor(colours, code), dtype=np.uint8)
