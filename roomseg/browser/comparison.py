"""Segmentations of a map side by side: one names its rooms as the other does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dataset.topomap import TopoMap
from roomseg.browser.shell import PALETTE
from roomseg.figures import match_rooms
from roomseg.metrics import impurity

__all__ = ["TRUE_ROOMS", "Segmentation", "Shown", "segmentations_of", "shown_beside"]

Integers = NDArray[Any]
TRUE_ROOMS = "true rooms"


@dataclass(frozen=True)
class Segmentation:
    """Rooms of a map's nodes.

    Attributes
    ----------
    name : str
        Where they are from.
    room : array, shape (n,)
    crossing : array, shape (k, 2), optional
        Nodes of the edges that are taken for border edges.
    room_names : tuple of str, optional
        One for each label of ``room``.
    """

    name: str
    room: Integers
    crossing: Integers | None = None
    room_names: tuple[str, ...] | None = None

    @property
    def count(self) -> int:
        """How many rooms."""
        return len(np.unique(self.room))


@dataclass(frozen=True)
class Shown:
    """A segmentation as it is shown beside another one.

    Attributes
    ----------
    about : str
        How many rooms, and how many nodes differ.
    colour : array, shape (n,), uint8
        Index into the palette.
    rooms : dict of list
        Where the rooms' names stand, m, and the names.
    """

    about: str
    colour: NDArray[np.uint8]
    rooms: dict[str, list[Any]]


def segmentations_of(
    topomap: TopoMap, found: Integers | None = None, model: str = ""
) -> list[Segmentation]:
    """The true rooms of a map and those that were found and written into it, if there are any."""
    truth = topomap.ground_truth
    result = []
    if truth is not None and truth.room is not None:
        crossing = topomap.edges[truth.edge_is_border]
        result.append(Segmentation(TRUE_ROOMS, truth.room, crossing, truth.room_names))
    if found is not None:
        result.append(Segmentation(f"rooms by {model}", found))
    return result


def shown_beside(
    segmentations: Sequence[Segmentation], position: NDArray[np.float64]
) -> list[list[Shown]]:
    """Segmentation j as it is shown beside segmentation i, for all i and j.

    Rooms that share most nodes have the same colour and number (`match_rooms`).

    Parameters
    ----------
    segmentations : sequence of Segmentation
    position : array, shape (n, 2)
        Of the nodes, m.
    """
    if not segmentations:
        return []
    first = _numbered(segmentations[0].room)
    named = [first] + [match_rooms(other.room, first) for other in segmentations[1:]]
    rows = []
    for i, own in enumerate(segmentations):
        row = []
        for j, other in enumerate(segmentations):
            label = named[i] if i == j else match_rooms(named[j], named[i])
            about = _about(other) if i == j else _about(other, own, label != named[i])
            row.append(_shown(about, label, other, position))
        rows.append(row)
    return rows


def _numbered(label: Integers) -> Integers:
    """Labels from 0 on."""
    return np.asarray(np.unique(label, return_inverse=True)[1]).ravel()


def _about(
    shown: Segmentation, beside: Segmentation | None = None, differs: Integers | None = None
) -> str:
    about = f"{shown.count} room{'s' * (shown.count != 1)}"
    if beside is None or differs is None:
        return about
    about += f"; {np.count_nonzero(differs)} of {len(differs)} nodes differ"
    if beside.name == TRUE_ROOMS:
        about += f", impurity {100.0 * impurity(shown.room, beside.room):.1f} %"
    return about


def _shown(about: str, label: Integers, of: Segmentation, position: NDArray[np.float64]) -> Shown:
    rooms: dict[str, list[Any]] = {"x": [], "y": [], "name": []}
    for number in np.unique(label):
        inside = np.flatnonzero(label == number)
        # The node nearest to the median lies inside the room.
        own = position[inside]
        middle = np.linalg.norm(own - np.median(own, axis=0), axis=1).argmin()
        rooms["x"].append(round(float(own[middle, 0]), 3))
        rooms["y"].append(round(float(own[middle, 1]), 3))
        names = of.room_names or ()
        own_label = int(of.room[inside[0]])
        name = names[own_label] if 0 <= own_label < len(names) else ""
        rooms["name"].append(name or str(int(number) + 1))
    return Shown(about, (label % len(PALETTE)).astype(np.uint8), rooms)
