"""Map files: write one, read one, read its images one by one.

A map file is only ever replaced as a whole (`dataset.atomic`), because HDF5 is
not crash-safe when it is changed in place. How images lie in it: `dataset.frames`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from dataset.atomic import locked, remove_leftovers
from dataset.camera import FisheyeCamera
from dataset.closing import Closing
from dataset.digest import map_digest
from dataset.errors import FormatError
from dataset.frames import Frame, Image, Images, Radiance, pack_image, put_images
from dataset.layout import (
    array_of,
    decode_camera,
    decode_map,
    encode_map,
    number_attribute,
    read,
    text_attribute,
)
from dataset.reading import errors_of, open_map, opened
from dataset.tables import (
    Columns,
    data_frame,
    edge_columns,
    node_columns,
    obstacle_columns,
)
from dataset.topomap import TopoMap
from dataset.writing import created

__all__ = ["MapFile", "Rooms", "read_map", "write_map"]

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


class MapFile(Closing):
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

    def digest(self) -> str:
        """SHA-256 of the map and its images; other labels in ``/rooms`` do not change it."""
        with errors_of(self.path):
            return map_digest(self._file, self._pixels if self.image_count else None, self.done)

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
