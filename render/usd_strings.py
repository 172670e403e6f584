"""The strings of USD files, text (usda), binary (usdc) and packed (usdz).

USD composes a scene from other files while it is opened, so their names are wanted
before. Binary files keep all strings in one table, in blocks of LZ4.
"""

from __future__ import annotations

import io
import re
import struct
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from scenes.errors import SceneError

__all__ = ["Layer", "usd_layers"]

BINARY, PACKED = b"PXR-USDC", b"PK\x03\x04"
LARGEST = 2_000_000_000
MOST_STRINGS = 50_000_000
SECTION = struct.Struct("<16s2q")
ASSET = re.compile(
    r"\.(?:usd[acz]?|abc|obj|gltf|glb|vdb|png|jpe?g|exr|hdr|tiff?|tga|bmp|webp|ies|mtlx|udim)$",
    re.IGNORECASE,
)
"""How a string of a binary file ends that names another file."""


@dataclass(frozen=True)
class Layer:
    """One layer of a USD file: the words in it, and the files that it names."""

    words: frozenset[str]
    assets: tuple[str, ...]


def usd_layers(path: Path, stream: IO[bytes]) -> Iterator[Layer]:
    """Layers of a USD file, the root layer first.

    Raises
    ------
    SceneError
        If it is no USD file or damaged.
    """
    data = stream.read(LARGEST)
    if not data.startswith(PACKED):
        yield _layer(path, data)
        return
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as package:
            for item in package.infolist():
                if item.compress_type != zipfile.ZIP_STORED:
                    raise zipfile.BadZipFile  # as the format wants it: nothing to unpack
                if item.filename.lower().endswith((".usd", ".usda", ".usdc")):
                    yield _layer(path, package.read(item))
    except (zipfile.BadZipFile, OSError, EOFError, RuntimeError):
        raise _damaged(path) from None


def _damaged(path: Path) -> SceneError:
    return SceneError(f"{path}: cut short, damaged, or no USD; expected a whole USD file")


def _layer(path: Path, data: bytes) -> Layer:
    if data.startswith(b"#usda"):
        text = data.decode(errors="replace")
        named = re.findall(r"@@@(.+?)@@@|@([^@\n]+)@", text)
        return Layer(frozenset(re.findall(r"\w+", text)), tuple(a or b for a, b in named))
    if not data.startswith(BINARY):
        raise _damaged(path)
    try:
        words = _table(data).decode(errors="replace").split("\0")
    except (struct.error, IndexError, ValueError):
        raise _damaged(path) from None
    return Layer(frozenset(words), tuple(word for word in words if ASSET.search(word)))


def _table(data: bytes) -> bytes:
    """The string table of a binary file: its section TOKENS."""
    (contents,) = struct.unpack_from("<q", data, 16)
    (count,) = struct.unpack_from("<q", data, contents)
    for index in range(min(count, 64)):
        name, start, _ = SECTION.unpack_from(data, contents + 8 + index * SECTION.size)
        if name.rstrip(b"\0") == b"TOKENS":
            _, size, packed = struct.unpack_from("<3q", data, start)
            if size > MOST_STRINGS or start + 24 + packed > len(data):
                raise ValueError("table")
            return _chunks(data[start + 24 : start + 24 + packed])
    raise ValueError("no table")


def _chunks(data: bytes) -> bytes:
    """One block of LZ4, or several with their lengths, after their number."""
    if data[0] == 0:
        return _lz4(data[1:])
    made, place = b"", 1
    for _ in range(data[0]):
        (length,) = struct.unpack_from("<i", data, place)
        made += _lz4(data[place + 4 : place + 4 + length])
        place += 4 + length
    return made


def _lz4(data: bytes) -> bytes:
    """Unpack one block of LZ4: literals, then a copy of what came before, and again."""
    made, place = bytearray(), 0
    while place < len(data):
        token = data[place]
        length, place = _length(data, place + 1, token >> 4)
        made += data[place : place + length]
        place += length
        if place >= len(data):
            break
        back = data[place] | data[place + 1] << 8
        length, place = _length(data, place + 2, token & 15)
        length += 4
        if not 0 < back <= len(made) or len(made) + length > MOST_STRINGS:
            raise ValueError("block")
        made += (made[-back:] * (length // back + 1))[:length]
    return bytes(made)


def _length(data: bytes, place: int, length: int) -> tuple[int, int]:
    """A length that goes on in further bytes if its four bits are all set."""
    if length == 15:
        while True:
            length += data[place]
            place += 1
            if data[place - 1] != 255:
                break
    return length, place
