"""Pictures of grid maps: PGM and PNG, refused unless they are whole.

Decoders fill up a file that was cut short with grey; in a map that would be floor or
wall that nobody saw. So a PGM is read here, and the chunks of a PNG are checked
before OpenCV decodes it.
"""

from __future__ import annotations

import re
import struct
import zlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from scenes.errors import SceneError
from scenes.importers.reading import read_bytes

__all__ = ["is_picture", "read_picture"]

Cells = NDArray[np.uint8]

MOST_BYTES = 200_000_000
MOST_PIXELS = 64_000_000
PNG = b"\x89PNG\r\n\x1a\n"
PGM_HEADER = re.compile(
    rb"P([25])((?:\s|#[^\n]*\n)+)(\d{1,9})((?:\s|#[^\n]*\n)+)(\d{1,9})"
    rb"((?:\s|#[^\n]*\n)+)(\d{1,9})\s"
)


def is_picture(path: Path) -> bool:
    """Whether a file is a picture, by its name or its first bytes."""
    if path.suffix.lower() in (".png", ".pgm"):
        return True
    try:
        with path.open("rb") as file:
            return file.read(len(PNG)) == PNG
    except OSError:
        return False


def read_picture(path: Path) -> Cells:
    """Read a PGM (P2, P5) or PNG picture.

    Parameters
    ----------
    path : Path

    Returns
    -------
    array, shape (rows, columns) or (rows, columns, 2 to 4)
        8 bits; grey, or blue, green, red and opacity as OpenCV has them.

    Raises
    ------
    SceneError
        If it is neither, is cut short or damaged, or has too many pixels.
    """
    data = read_bytes(path, MOST_BYTES, "a map picture")
    if data.startswith(PNG):
        return _read_png(data, path)
    if data[:2] in (b"P2", b"P5"):
        return _read_pgm(data, path)
    raise SceneError(f"{path}: begins with {data[:8]!r}; expected a PGM (P2, P5) or PNG picture")


def _check_size(width: int, height: int, path: Path) -> None:
    if width < 1 or height < 1 or width * height > MOST_PIXELS:
        raise SceneError(
            f"{path}: {width} x {height} pixels; expected 1 to {MOST_PIXELS // 1_000_000} million; "
            f"cut the unknown margin off, or scale the map down"
        )


def _read_pgm(data: bytes, path: Path) -> Cells:
    header = PGM_HEADER.match(data)
    if header is None:
        raise SceneError(f"{path}: damaged PGM header; expected P5 or P2, width, height, maximum")
    width, height, most = (int(header[group]) for group in (3, 5, 7))
    _check_size(width, height, path)
    if not 1 <= most <= 65535:
        raise SceneError(f"{path}: PGM maximum {most}; expected 1 to 65535")
    values = _pgm_values(data[header.end() :], header[1] == b"5", most, path)
    if len(values) < width * height:
        raise SceneError(
            f"{path}: cut short: {len(values)} of {width} x {height} pixels; expected all of them"
        )
    values = values[: width * height].reshape(height, width)
    if values.max() > most or values.min() < 0:
        raise SceneError(f"{path}: pixel beyond the maximum {most} of its header; damaged?")
    if most == 255:
        return values.astype(np.uint8)
    return (values * (255.0 / most)).round().astype(np.uint8)


def _pgm_values(body: bytes, binary: bool, most: int, path: Path) -> NDArray[Any]:
    """All values after the header of a PGM."""
    if binary:
        depth = np.dtype(">u2" if most > 255 else "u1")
        return np.frombuffer(body, depth, count=len(body) // depth.itemsize)
    try:
        return np.array(list(map(int, re.sub(rb"#[^\n]*", b"", body).split())), dtype=np.int64)
    except (ValueError, OverflowError):
        raise SceneError(f"{path}: not all pixels are whole numbers; damaged?") from None


def _read_png(data: bytes, path: Path) -> Cells:
    _check_chunks(data, path)
    picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if picture is None:
        raise SceneError(f"{path}: damaged PNG: its pixels cannot be decoded")
    if picture.dtype == np.uint16:
        picture = (picture // 257).astype(np.uint8)
    cells: Cells = picture
    return cells


def _check_chunks(data: bytes, path: Path) -> None:
    """Walk through a PNG from the header to its end, checksums included."""
    place, kind = len(PNG), b""
    while kind != b"IEND":
        if place + 12 > len(data):
            raise SceneError(f"{path}: cut short: the PNG has no end; expected the whole file")
        length, kind = struct.unpack_from(">I4s", data, place)
        end = place + 8 + length
        if end + 4 > len(data):
            raise SceneError(f"{path}: cut short: the PNG has no end; expected the whole file")
        if zlib.crc32(data[place + 4 : end]) != struct.unpack_from(">I", data, end)[0]:
            raise SceneError(f"{path}: damaged PNG: wrong checksum at byte {place}")
        if place == len(PNG):
            if kind != b"IHDR" or length != 13:
                raise SceneError(f"{path}: damaged PNG: no header; expected IHDR first")
            width, height = struct.unpack_from(">II", data, place + 8)
            _check_size(width, height, path)
        place = end + 4
