"""Changing a part of a map file: it is replaced as a whole by a copy with that part changed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import ArrayLike

from dataset.atomic import locked, remove_leftovers
from dataset.errors import FormatError
from dataset.layout import array_of, decode_map, encode_ground_truth
from dataset.reading import errors_of, open_map
from dataset.topomap import GroundTruth
from dataset.writing import created

__all__ = ["rewriting", "write_ground_truth", "write_rooms"]


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


def write_ground_truth(path: str | Path, truth: GroundTruth) -> None:
    """Write what a person says about a map into its file, in place of what was said before.

    Raises
    ------
    FormatError
        If it is not of as many edges and nodes as the map has.
    RoomsegError
        If another process is writing to the file.
    """
    with locked(path), rewriting(path, without=["ground_truth"]) as (source, target):
        with errors_of(path):
            decode_map(source).with_ground_truth(truth)
        encode_ground_truth(target.create_group("ground_truth"), truth)
