"""The records of a journal of frames (`dataset.journal`).

A record is ``(length u4, node u4, gain f8, checksum u4)``, little endian, and
``length`` bytes: the deflated pixels exactly as HDF5 stores a chunk. Where radiance
is kept, these are ``(pixel length u4, exponent i4)``, the pixels, and the radiance
as HDF5 stores it.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

from dataset.frames import Frame

__all__ = ["RECORD", "Entry", "packed", "records", "seal", "unpacked"]

RECORD = struct.Struct("<IIdI")
WITH_RADIANCE = struct.Struct("<Ii")


@dataclass(frozen=True)
class Entry:
    """Where a frame's data lie in the journal."""

    offset: int
    length: int
    gain: float


def packed(frame: Frame) -> bytes:
    """Data of a frame whose radiance is kept."""
    return WITH_RADIANCE.pack(len(frame.pixels), frame.exponent) + frame.pixels + frame.radiance


def unpacked(index: int, gain: float, data: bytes, *, with_radiance: bool) -> Frame:
    """The frame of a record's data."""
    if not with_radiance:
        return Frame(index, data, gain)
    length, exponent = WITH_RADIANCE.unpack_from(data)
    split = WITH_RADIANCE.size + length
    return Frame(index, data[WITH_RADIANCE.size : split], gain, data[split:], exponent)


def seal(index: int, data: bytes, gain: float) -> bytes:
    """Make the head of a record, with the checksum of head and data."""
    plain = RECORD.pack(len(data), index, gain, 0)
    return RECORD.pack(len(data), index, gain, zlib.crc32(data, zlib.crc32(plain)))


def records(stream: BinaryIO) -> Iterator[tuple[int, Entry]]:
    """Yield whole records from here on; stop at the first that is cut off or damaged."""
    while len(head := stream.read(RECORD.size)) == RECORD.size:
        length, index, gain, _ = RECORD.unpack(head)
        offset = stream.tell()
        data = stream.read(length)
        if len(data) != length or seal(index, data, gain) != head:
            return
        yield index, Entry(offset, length, gain)
