"""The images of a map as they lie in the file: one compressed chunk per image.

Finished frames can so be carried from the journal into the file, and from the old
file into the new one, without being unpacked (`dataset.journal`).

Radiance that is kept is float16 times a power of two of its own for each image: rooms
differ by far more in brightness than float16 spans, while relative to the brightest
pixel it reaches down to a billionth.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from dataset.errors import FormatError
from dataset.layout import array_of, read

if TYPE_CHECKING:
    from dataset.storage import MapFile

__all__ = [
    "Frame",
    "Images",
    "Radiance",
    "pack_image",
    "pack_radiance",
    "put_images",
    "stored_frames",
    "unpack_radiance",
]

Image = NDArray[np.uint8]


@dataclass(frozen=True)
class Radiance:
    """Linear light of one image: ``halves`` (rows, columns) float16, times 2 ** ``exponent``."""

    halves: NDArray[np.float16]
    exponent: int

    @classmethod
    def of(cls, light: NDArray[np.float32]) -> Radiance:
        """Round linear light to float16; ValueError if it is not finite."""
        highest = float(np.abs(light).max(initial=0.0))
        if not np.isfinite(highest):
            raise ValueError("radiance: has values that are not finite")
        # 2**14 <= highest < 2**15 in float16, whose range ends at 2**16.
        exponent = int(np.frexp(highest)[1]) - 15 if highest > 0.0 else 0
        return cls(np.ldexp(np.float64(light), -exponent).astype(np.float16), exponent)

    @property
    def light(self) -> NDArray[np.float32]:
        """Linear light, shape (rows, columns)."""
        return np.ldexp(self.halves.astype(np.float64), self.exponent).astype(np.float32)


@dataclass(frozen=True)
class Frame:
    """One frame, packed: its node, deflated pixels, exposure gain, and radiance if it is kept."""

    index: int
    pixels: bytes
    gain: float
    radiance: bytes = b""
    exponent: int = 0


@dataclass(frozen=True)
class Images:
    """The images of a map, read from the file only where they are indexed.

    ``images[3]`` is one image (rows, columns), ``images[10:20]`` and
    ``images[[4, 2]]`` are several, (k, rows, columns), all uint8; FormatError if one of
    them is not there (`MapFile.done` says which are).
    """

    file: MapFile

    def __len__(self) -> int:
        return len(self.file.done)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Of all images, (n, rows, columns)."""
        return (len(self), *self.file.topomap.camera.image_size)

    def __getitem__(self, index: int | slice | Sequence[int] | NDArray[Any]) -> Image:
        chosen = np.arange(len(self))[index]
        if chosen.ndim == 0:
            return self.file.image(int(chosen))
        stack = [self.file.image(int(node)) for node in chosen]
        return np.stack(stack) if stack else np.empty((0, *self.shape[1:]), np.uint8)

    def __iter__(self) -> Iterator[Image]:
        return (self.file.image(node) for node in range(len(self)))


def pack_image(image: Image, size: tuple[int, int]) -> bytes:
    """Deflate an image as HDF5's own filter would; FormatError if it has another size."""
    image = np.asarray(image)
    if image.dtype != np.uint8 or image.shape != tuple(size):
        raise FormatError(
            f"images/pixels: an image of {image.dtype} {image.shape}, expected uint8 {tuple(size)}"
        )
    # Level 1: higher levels cost several times the time and save a few per cent of noise.
    return zlib.compress(np.ascontiguousarray(image).tobytes(), 1)


def pack_radiance(radiance: Radiance, size: tuple[int, int]) -> bytes:
    """Shuffle and deflate radiance as HDF5's own filters would."""
    halves = np.ascontiguousarray(radiance.halves, dtype="<f2")
    if halves.shape != tuple(size):
        raise FormatError(f"images/radiance: shape {halves.shape}, expected {tuple(size)}")
    return zlib.compress(halves.view(np.uint8).reshape(-1, 2).T.tobytes(), 1)


def unpack_radiance(data: bytes, exponent: int, size: tuple[int, int]) -> Radiance:
    """Undo `pack_radiance`."""
    octets = np.frombuffer(zlib.decompress(data), np.uint8).reshape(2, -1).T
    return Radiance(np.ascontiguousarray(octets).view("<f2").reshape(size), exponent)


def put_images(
    file: h5py.File,
    frames: Iterable[Frame],
    n: int,
    size: tuple[int, int],
    preset: str = "",
    *,
    keep_radiance: bool = False,
) -> None:
    """Write ``/images`` from packed frames in order of their node."""
    group = file.create_group("images")
    if preset:
        group.attrs["preset"] = preset
    options = {"chunks": (1, *size), "compression": "gzip", "compression_opts": 1}
    pixels = group.create_dataset("pixels", (n, *size), "u1", **options)
    if keep_radiance:
        radiance = group.create_dataset("radiance", (n, *size), "<f2", shuffle=True, **options)
    gain, done, exponent = np.ones(n), np.zeros(n, bool), np.zeros(n, "<i4")
    for frame in frames:
        place = (frame.index, 0, 0)
        pixels.id.write_direct_chunk(place, frame.pixels)
        if keep_radiance:
            radiance.id.write_direct_chunk(place, frame.radiance)
        gain[frame.index], done[frame.index] = frame.gain, True
        exponent[frame.index] = frame.exponent
    group.create_dataset("gain", data=gain)
    group.create_dataset("done", data=done)
    if keep_radiance:
        group.create_dataset("radiance_exponent", data=exponent)


def stored_frames(file: h5py.File) -> Iterator[Frame]:
    """Yield the packed frames that a file already holds, in order of their node."""
    if "images" not in file:
        return
    pixels, gain = array_of(file, "images/pixels"), read(file, "images/gain", "f")
    kept = "images/radiance" in file
    exponent = read(file, "images/radiance_exponent", "i") if kept else np.zeros(len(gain), int)
    for index in np.flatnonzero(read(file, "images/done", "b")).tolist():
        if _is_plain(pixels, shuffle=False):
            data = pixels.id.read_direct_chunk((index, 0, 0))[1]
        else:
            data = pack_image(pixels[index], pixels.shape[1:])
        light = _stored_radiance(file, index, int(exponent[index])) if kept else b""
        yield Frame(index, data, float(gain[index]), light, int(exponent[index]))


def _stored_radiance(file: h5py.File, index: int, exponent: int) -> bytes:
    radiance = array_of(file, "images/radiance")
    if _is_plain(radiance, shuffle=True):
        data: bytes = radiance.id.read_direct_chunk((index, 0, 0))[1]
        return data
    return pack_radiance(Radiance(radiance[index], exponent), radiance.shape[1:])


def _is_plain(array: h5py.Dataset, *, shuffle: bool) -> bool:
    """Whether its chunks are packed as ours are."""
    one_each = array.chunks == (1, *array.shape[1:])
    return bool(one_each and array.compression == "gzip" and array.shuffle == shuffle)
