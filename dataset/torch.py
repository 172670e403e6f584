"""Maps for PyTorch: a data set of images, and one of graphs (extra ``roomseg[torch]``).

Files are opened when an item is asked for, once in each process, so that both can be
given to a ``DataLoader`` with workers.
"""

from __future__ import annotations

import os
from bisect import bisect_right
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dataset.camera import FisheyeCamera
from dataset.storage import MapFile
from dataset.tables import edge_columns

try:
    import torch
except ImportError as error:
    raise ImportError(
        f"dataset.torch needs the package torch ({error}): pip install 'roomseg[torch]'"
    ) from None

__all__ = ["GraphSet", "ImageSet", "MapTensors"]

Image = NDArray[np.uint8]
Unfold = Callable[[Image], Image]
NO_ROOM = -100
"""Label of a node whose room is unknown: what PyTorch's losses ignore."""


class _Files:
    """Map files by index, opened where they are used first."""

    def __init__(self, paths: Sequence[str | Path]) -> None:
        self.paths = [Path(path) for path in paths]
        self._open: dict[tuple[int, int], MapFile] = {}

    def __getitem__(self, index: int) -> MapFile:
        # Not across a fork: HDF5's files must not be shared between processes.
        key = (os.getpid(), index)
        if key not in self._open:
            self._open[key] = MapFile(self.paths[index])
        return self._open[key]

    def __getstate__(self) -> dict[str, Any]:
        return {"paths": self.paths, "_open": {}}


class ImageSet(torch.utils.data.Dataset):  # type: ignore[misc]
    """All images of some maps, with the rooms of their nodes.

    An item is ``(image, room)``, or ``(image, panorama, room)``: float tensors
    (1, rows, columns) from 0 to 1, and the room as a number, `NO_ROOM` if unknown.
    Rooms count from 0 in each map.

    Parameters
    ----------
    paths : sequence of paths
        Maps; nodes without an image are left out.
    panorama : callable, optional
        Makes, of a camera, what unfolds its images: ``roomseg.panorama.Unfolding.of``
        for that of §2.2.4.

    Raises
    ------
    RoomsegError
        If a map cannot be read.
    """

    def __init__(
        self,
        paths: Sequence[str | Path],
        panorama: Callable[[FisheyeCamera], Unfold] | None = None,
    ) -> None:
        self._files, self._nodes, self._rooms = _Files(paths), [], []
        self._unfold: list[Unfold | None] = []
        for path in self._files.paths:
            with MapFile(path) as file:
                self._nodes.append(np.flatnonzero(file.done))
                self._rooms.append(_rooms(file))
                camera = file.topomap.camera
            self._unfold.append(None if panorama is None else panorama(camera))
        self._ends = np.cumsum([len(nodes) for nodes in self._nodes]).tolist()

    def __len__(self) -> int:
        return int(self._ends[-1]) if self._ends else 0

    def where(self, index: int) -> tuple[Path, int]:
        """The map and the node of an item."""
        number, node = self._find(index)
        return self._files.paths[number], node

    def __getitem__(self, index: int) -> tuple[Any, ...]:
        number, node = self._find(index)
        image = self._files[number].image(node)
        unfold, room = self._unfold[number], int(self._rooms[number][node])
        if unfold is None:
            return _picture(image), room
        return _picture(image), _picture(unfold(image)), room

    def _find(self, index: int) -> tuple[int, int]:
        if not 0 <= index < len(self):
            raise IndexError(f"{index}, expected 0..{len(self) - 1}")
        number = bisect_right(self._ends, index)
        nodes = self._nodes[number]
        return number, int(nodes[index - self._ends[number] + len(nodes)])


class MapTensors(NamedTuple):
    """One map as tensors, named as PyTorch Geometric names them.

    Attributes
    ----------
    x : tensor, shape (n, 4), float32
        Position estimate, m, from the map's middle; cosine and sine of the heading.
    edge_index : tensor, shape (2, e), int64
        Each edge once, the smaller node first.
    edge_attr : tensor, shape (e, 1), float32
        Length, m.
    y : tensor, shape (n,), int64
        Room, `NO_ROOM` if unknown.
    border : tensor, shape (e,), float32
        1 for edges that cross a border, NaN without ground truth.
    """

    x: Any
    edge_index: Any
    edge_attr: Any
    y: Any
    border: Any


class GraphSet(torch.utils.data.Dataset):  # type: ignore[misc]
    """The graphs of some maps; an item is `MapTensors`, read when it is asked for."""

    def __init__(self, paths: Sequence[str | Path]) -> None:
        self.paths = [Path(path) for path in paths]

    def __len__(self) -> int:
        return len(self.paths)

    def __getitem__(self, index: int) -> MapTensors:
        with MapFile(self.paths[index]) as file:
            topomap, rooms = file.topomap, _rooms(file)
        nodes, edges = topomap.nodes, edge_columns(topomap)
        place = nodes.position - nodes.position.mean(axis=0)
        facing = np.stack([np.cos(nodes.heading), np.sin(nodes.heading)], axis=1)
        border = edges.get("border", np.full(len(topomap.edges), np.nan))
        return MapTensors(
            _tensor(np.hstack([place, facing]), np.float32),
            _tensor(topomap.edges.T, np.int64),
            _tensor(edges["length"][:, None], np.float32),
            _tensor(rooms, np.int64),
            _tensor(border, np.float32),
        )


def _rooms(file: MapFile) -> NDArray[np.int64]:
    truth = file.topomap.ground_truth
    if truth is None or truth.room is None:
        return np.full(len(file.topomap.nodes), NO_ROOM, np.int64)
    return truth.room.astype(np.int64)


def _tensor(array: NDArray[Any], dtype: Any) -> Any:
    return torch.from_numpy(np.ascontiguousarray(array, dtype))


def _picture(image: Image) -> Any:
    return _tensor(image[None] / 255.0, np.float32)
