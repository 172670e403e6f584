"""Map files: write one, read one, read its images one by one.

A map file is only ever replaced as a whole (`dataset.atomic`), because HDF5 is
not crash-safe when it is changed in place. How images lie in it: `dataset.frames`.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from dataset.atomic import locked, remove_leftovers
from dataset.camera import FisheyeCamera
from dataset.errors import FormatError
from dataset.frames import Frame, Image, Images, Radiance, pack_image, put_images
from dataset.layout import (
    array_of,
    check_format,
    decode_camera,
    decode_map,
    encode_map,
    number_attribute,
    read,
    text_attribute,
)
from dataset.tables import (
    Columns,
    data_frame,
    edge_columns,
    node_columns,
    obstacle_columns,
)
from dataset.topomap import TopoMap
from dataset.writing import created

__all__ = ["MapFile", "Rooms", "read_map", "write_map", "write_rooms"]

OWN_CAMERA = "own_camera"
"""Keeps the camera that a map had before its images were made with another one."""


@dataclass(frozen=True)
class Rooms:
    """A segmentation that was written back: label (n,), the model's name, how many rooms."""

    label: NDArray[np.int32]
    model: str
    count: int


def write_map(
    path: str | Path,
    topomap: TopoMap,
    images: Iterable[Image | None] | None = None,
    gains: ArrayLike | None = None,
) -> None:
    """Write a map file, atomically.

    Parameters
    ----------
    path : path
        An existing file is replaced as a whole.
    topomap : TopoMap
    images : iterable of arrays (rows, columns) uint8, optional
        One per node; ``None`` for a node without image.
    gains : array, shape (n,), optional
        Exposure gain of each image; 1 if absent.

    Raises
    ------
    FormatError
        If an image has another size than ``topomap.camera`` says.
    RoomsegError
        If another process is writing to the file.
    """
    with locked(path):
        remove_leftovers(path)
        with created(path) as file:
            encode_map(file, topomap)
            if images is not None:
                frames = _packed(images, gains, topomap)
                put_images(file, frames, len(topomap.nodes), topomap.camera.image_size)


def _packed(
    images: Iterable[Image | None], gains: ArrayLike | None, topomap: TopoMap
) -> Iterator[Frame]:
    n = len(topomap.nodes)
    gain = np.ones(n) if gains is None else np.asarray(gains, float)
    if gain.shape != (n,):
        raise FormatError(f"images/gain: shape {gain.shape}, expected {(n,)}")
    count = 0
    for index, image in enumerate(images):
        count += 1
        if image is not None and index < n:
            packed = pack_image(image, topomap.camera.image_size)
            yield Frame(index, packed, float(gain[index]))
    if count != n:
        raise FormatError(f"images/pixels: {count} images, expected {n}, one per node")


def read_map(path: str | Path) -> TopoMap:
    """Read everything but the images.

    Raises
    ------
    FormatError
        One line: the file, the field, the value, and what would be right.
    """
    with opened(path) as file:
        return decode_map(file)


@contextmanager
def errors_of(path: str | Path) -> Iterator[None]:
    """Turn whatever a bad file makes h5py raise into one line that names the file."""
    try:
        yield
    except FormatError as error:
        message = str(error)
        named = message.startswith(f"{path}: ")
        raise FormatError(message if named else f"{path}: {message}") from error
    except (OSError, KeyError, RuntimeError, ValueError, TypeError, MemoryError) as error:
        reason = " ".join(str(error).split())
        raise FormatError(f"{path}: damaged map file ({reason})") from error


@contextmanager
def opened(path: str | Path) -> Iterator[h5py.File]:
    """Open a map file for reading; every error names it."""
    with errors_of(path), open_map(path) as file:
        yield file


def begins_as_hdf5(path: Path) -> bool:
    """Whether a file that is there begins with the signature of HDF5."""
    with path.open("rb") as stream:
        return stream.read(8) == b"\x89HDF\r\n\x1a\n"


def open_map(path: str | Path) -> h5py.File:
    """Open a map file for reading.

    Raises
    ------
    FormatError
        If there is none, it cannot be read, is cut off, or is no roomseg map.
    """
    path = Path(path)
    if path.is_dir() or not path.exists():
        what = "is a folder" if path.is_dir() else "no such file"
        raise FormatError(f"{path}: {what}, expected a map file (.h5)")
    if not os.access(path, os.R_OK):
        raise FormatError(f"{path}: not readable, check its permissions")
    if not begins_as_hdf5(path):
        raise FormatError(f"{path}: not an HDF5 file, expected a map file (.h5)")
    with errors_of(path):
        try:
            file = h5py.File(path, "r")
        except OSError as error:
            raise FormatError(
                f"{path}: cut off or damaged HDF5 file, expected a complete map file"
            ) from error
        try:
            check_format(file)
        except FormatError:
            file.close()
            raise
        return file


class MapFile:
    """A map file open for reading; arrays are read when they are asked for.

    Use it as a context manager. Images that are still in a journal are not
    visible until they are packed.

    Parameters
    ----------
    path : path

    Raises
    ------
    FormatError
        If the file is missing, cut off or no map; the other members raise it
        if what they read is missing or wrong.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._file = open_map(self.path)

    def __enter__(self) -> MapFile:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; closing twice does nothing."""
        self._file.close()

    @cached_property
    def topomap(self) -> TopoMap:
        """Everything but the images."""
        with errors_of(self.path):
            return decode_map(self._file)

    @cached_property
    def done(self) -> NDArray[np.bool_]:
        """Which nodes have an image, shape (n,)."""
        n = len(self.topomap.nodes)
        if "images" not in self._file:
            return np.zeros(n, bool)
        with errors_of(self.path):
            done = read(self._file, "images/done", "b")
            if done.shape != (n,):
                raise FormatError(f"/images/done: shape {done.shape}, expected {(n,)}")
            return done

    @property
    def image_count(self) -> int:
        """How many nodes have an image."""
        return int(self.done.sum())

    @property
    def preset(self) -> str:
        """Name of the preset that the images were rendered with; empty if unknown."""
        images = self._file.get("images")
        return "" if images is None or "preset" not in images.attrs else images.attrs["preset"]

    def image(self, index: int) -> Image:
        """Read the camera image of a node, shape ``camera.image_size``, uint8."""
        self._require(index)
        with errors_of(self.path):
            return np.asarray(self._pixels[index])

    @property
    def images(self) -> Images:
        """All images as one array that is read where it is sliced: ``file.images[10:20]``."""
        return Images(self)

    @property
    def own_camera(self) -> FisheyeCamera:
        """The map's camera before its images were made with another one."""
        if OWN_CAMERA not in self._file:
            return self.topomap.camera
        with errors_of(self.path):
            return decode_camera(self._file, OWN_CAMERA)

    @property
    def keeps_radiance(self) -> bool:
        """Whether the images' radiance is kept (`roomseg render --hdr`)."""
        return "images/radiance" in self._file

    def radiance(self, index: int) -> NDArray[np.float32]:
        """Linear radiance of a node's image before exposure, shape ``camera.image_size``."""
        self._require(index)
        if not self.keeps_radiance:
            raise FormatError(
                f"{self.path}: /images/radiance: missing; `roomseg render --hdr` keeps it"
            )
        with errors_of(self.path):
            halves = np.asarray(array_of(self._file, "images/radiance")[index])
            exponent = int(read(self._file, "images/radiance_exponent", "i")[index])
            return Radiance(halves, exponent).light

    def gain(self, index: int) -> float:
        """Exposure gain a of a node's image."""
        self._require(index)
        with errors_of(self.path):
            return float(array_of(self._file, "images/gain")[index])

    @property
    def rooms(self) -> Rooms | None:
        """The segmentation that was written back, if any."""
        with errors_of(self.path):
            if "rooms" not in self._file:
                return None
            group = self._file["rooms"]
            return Rooms(
                label=read(self._file, "rooms/label", "i"),
                model=text_attribute(group, "model"),
                count=int(number_attribute(group, "rooms")),
            )

    def node_columns(self) -> Columns:
        """Arrays of all nodes by name, with the rooms that were found (`dataset.tables`)."""
        rooms = self.rooms
        return node_columns(self.topomap, None if rooms is None else rooms.label)

    def nodes_table(self) -> Any:
        """One row per node, a `pandas.DataFrame`; RoomsegError without pandas."""
        return data_frame(self.node_columns() | {"image": self.done}, "node")

    def edges_table(self) -> Any:
        """One row per edge, a `pandas.DataFrame`; RoomsegError without pandas."""
        return data_frame(edge_columns(self.topomap), "edge")

    def visits_table(self) -> Any:
        """One row per visit, a `pandas.DataFrame`; RoomsegError without pandas."""
        visits = self.topomap.visits
        return data_frame({"node": visits.node, "time": visits.time}, "visit")

    def obstacles_table(self) -> Any:
        """One row per obstacle point, a `pandas.DataFrame`; RoomsegError without pandas."""
        return data_frame(obstacle_columns(self.topomap), "point")

    @cached_property
    def _pixels(self) -> h5py.Dataset:
        pixels = array_of(self._file, "images/pixels")
        expected = (len(self.topomap.nodes), *self.topomap.camera.image_size)
        if pixels.shape != expected or pixels.dtype != np.uint8:
            raise FormatError(
                f"/images/pixels: {pixels.dtype} {pixels.shape}, expected uint8 {expected}"
            )
        return pixels

    def _require(self, index: int) -> None:
        if not 0 <= index < len(self.done):
            raise FormatError(f"{self.path}: node {index}, expected 0..{len(self.done) - 1}")
        if not self.done[index]:
            raise FormatError(
                f"{self.path}: node {index} has no image; `roomseg render {self.path}` makes it"
            )


@contextmanager
def rewriting(
    path: str | Path, without: Sequence[str] = ()
) -> Iterator[tuple[h5py.File, h5py.File]]:
    """Replace a map file by a copy, changed in the body; call it under the lock.

    Yields
    ------
    source, target : h5py.File
        The old file, and a new one with all its content but the groups ``without``.
    """
    remove_leftovers(path)
    # Not `opened`: a full disk while the body writes is no damaged map file.
    with open_map(path) as source, created(path) as target:
        with errors_of(path):
            for name, value in source.attrs.items():
                target.attrs[name] = value
            for name in source:
                if name not in without:
                    source.copy(name, target)
        yield source, target


def write_rooms(path: str | Path, label: ArrayLike, *, model: str, rooms: int) -> None:
    """Write a segmentation back into its map file, in place of an earlier one.

    Parameters
    ----------
    path : path
    label : array, shape (n,)
        Room of each node.
    model : str
        Name of the classifier, or what stood in for it.
    rooms : int
        The number of rooms that was asked for.

    Raises
    ------
    FormatError
        If there is not one label per node.
    RoomsegError
        If another process is writing to the file.
    """
    labels = np.asarray(label, "<i4")
    with locked(path), rewriting(path, without=["rooms"]) as (source, target):
        n = len(array_of(source, "nodes/position"))
        if labels.shape != (n,):
            raise FormatError(f"{path}: rooms/label: shape {labels.shape}, expected {(n,)}")
        group = target.create_group("rooms")
        group.create_dataset("label", data=labels)
        group.attrs["model"] = model
        group.attrs["rooms"] = int(rooms)
