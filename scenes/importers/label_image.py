"""Rooms as a picture: every room's cells in a grey or colour of their own.

Cells of one value that hang together are a room. Black is no room. Small gaps (the dark
lines that part rooms in research data sets) go to the nearest room; floor without a
label that is large enough becomes a room without a name.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast, get_args

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from scenes.apartment import RoomKind
from scenes.errors import SceneError
from scenes.importers.drawing import free_name, renamed
from scenes.importers.pictures import read_picture
from scenes.importers.rooms import SMALLEST
from scenes.importers.tables import read_rows

__all__ = ["LabelledRoom", "LabelledRooms", "read_label_image"]

Ints = NDArray[np.int64]

KINDS = get_args(RoomKind)
NAME = r"[A-Za-z0-9][A-Za-z0-9_.-]{0,55}"
"""Names that an apartment takes, with room for a number behind."""
TABLE = "a table of rooms: columns value (or r,g,b), name, kind (CSV with that line first, or JSON)"


@dataclass(frozen=True)
class LabelledRoom:
    """A room of a label picture; no name: empty.

    ``cells`` (rows, columns) are the part of the picture that holds the room, ``corner``
    (row, column) is where in the picture its upper left cell lies.
    """

    name: str
    kind: RoomKind
    cells: NDArray[np.bool_]
    corner: tuple[int, int]


@dataclass(frozen=True)
class LabelledRooms:
    """All rooms of a label picture, and notes on what could not be used."""

    rooms: tuple[LabelledRoom, ...]
    notes: tuple[str, ...]


def read_label_image(
    path: Path, table: str | Path | None, free: NDArray[np.bool_], resolution: float
) -> LabelledRooms:
    """Read a label picture for a grid map.

    Parameters
    ----------
    path : Path
        PNG or PGM, as large as the map.
    table : path, optional
        What the values mean: CSV or JSON with the columns ``value`` (grey) or
        ``r,g,b`` (colour), ``name`` and, optional, ``kind``.
    free : array of bool, shape (rows, columns)
        Free cells of the map.
    resolution : float
        m per cell.

    Returns
    -------
    LabelledRooms
        Every free cell is in one room.

    Raises
    ------
    SceneError
        If the picture has another size than the map, labels no free cell, or the
        table is not one.
    """
    values, coloured = _values(read_picture(path))
    if values.shape != free.shape:
        raise SceneError(
            f"{path}: {values.shape[1]} x {values.shape[0]} pixels; expected those of the map, "
            f"{free.shape[1]} x {free.shape[0]}"
        )
    notes: list[str] = []
    meaning = {} if table is None else _read_table(Path(table), coloured, notes)
    label, values_of = _components(np.where(free, values, 0), resolution)
    if not values_of:
        raise SceneError(f"{path}: no room on any free cell; expected rooms that are not black")
    label, unnamed = _fill(label, free, resolution)
    rooms = []
    for index, box in enumerate(ndimage.find_objects(label)):
        value = values_of[index] if index < len(values_of) else 0
        name, kind = meaning.get(value, ("", "other"))
        corner = (box[0].start, box[1].start)
        rooms.append(LabelledRoom(name, kind, label[box] == index + 1, corner))
    notes += [
        f"{table}: {name!r}: labels less than {SMALLEST:g} m² of free floor; left out"
        for value, (name, _) in meaning.items()
        if value not in values_of
    ]
    if unnamed:
        notes.append(f"{path}: {unnamed} parts of the floor without a label: rooms of their own")
    return LabelledRooms(tuple(rooms), tuple(notes))


def _values(picture: NDArray[np.uint8]) -> tuple[NDArray[np.int64], bool]:
    """One number for each pixel, 0 for black, and whether it is a colour's.

    Grey, or red·65536 + green·256 + blue.
    """
    if picture.ndim == 2:
        return picture.astype(np.int64), False
    colours = picture.shape[2] - (picture.shape[2] in (2, 4))
    channels = [picture[..., i].astype(np.int64) for i in range(colours)]
    # A grey picture in colour is a grey picture.
    if all(np.array_equal(channels[0], other) for other in channels[1:]):
        return channels[0], False
    blue, green, red = channels
    return _code(red, green, blue), True


def _code(red: Any, green: Any, blue: Any) -> Any:
    return (red << 16) + (green << 8) + blue


def _components(values: Ints, resolution: float) -> tuple[Ints, list[int]]:
    """Connected cells of one value, from the size of a room on: labels from 1 on, values."""
    known, index = np.unique(values, return_inverse=True)
    number = _large(index.reshape(values.shape), known != 0, resolution)
    label = np.zeros_like(number)
    values_of: list[int] = []
    # Values too rare for a room are gone, and each is looked for only where it is: a picture
    # may have as many colours as pixels.
    for place, box in enumerate(ndimage.find_objects(number), start=1):
        own = number[box] == place
        parts, count = ndimage.label(own)
        parts = _large(parts, np.arange(count + 1) > 0, resolution)
        label[box] += np.where(parts > 0, parts + len(values_of), 0)
        values_of += [int(values[box][own][0])] * int(parts.max())
    return label, values_of


def _large(number: Ints, counts: NDArray[np.bool_], resolution: float) -> Ints:
    """Cells numbered anew, 1, 2 …, without the numbers too rare for a room; those become 0.

    ``counts`` (n,) says which numbers may stay at all.
    """
    area = np.bincount(number.ravel(), minlength=len(counts)) * resolution**2
    stays = counts & (area >= SMALLEST)
    renumbered: Ints = np.where(stays, np.cumsum(stays), 0)[number]
    return renumbered


def _fill(label: Ints, free: NDArray[np.bool_], resolution: float) -> tuple[Ints, int]:
    """Give free cells without a label to the nearest room, or to a room of their own."""
    parts, count = ndimage.label(free & (label == 0))
    unnamed = _large(parts, np.arange(count + 1) > 0, resolution)
    full = label + np.where(unnamed > 0, unnamed + label.max(), 0)
    nearest = ndimage.distance_transform_edt(full == 0, return_distances=False, return_indices=True)
    return np.where(free, full[tuple(nearest)], 0), int(unnamed.max())


def _read_table(path: Path, coloured: bool, notes: list[str]) -> dict[int, tuple[str, RoomKind]]:
    """Names and kinds by value; notes are added on names that are none."""
    meaning: dict[int, tuple[str, RoomKind]] = {}
    for index, row in enumerate(read_rows(path, TABLE)):
        where = f"{path}: row {index + 1}"
        kind = str(row.get("kind") or "other").strip()
        if kind not in KINDS:
            raise SceneError(f"{where}: kind: {kind!r}; expected one of {', '.join(KINDS)}")
        columns = ("r", "g", "b") if coloured else ("value",)
        parts = [_byte(row.get(column), f"{where}: {column}") for column in columns]
        value = int(_code(*parts)) if coloured else parts[0]
        if value in meaning:
            raise SceneError(f"{where}: the label is that of an earlier row; expected another")
        name = str(row.get("name") or "")
        clean = _clean(name)
        if name.strip() and name != clean:
            notes.append(renamed(where, name, clean))
        meaning[value] = (clean, cast("RoomKind", kind))
    return meaning


def _byte(text: Any, where: str) -> int:
    try:
        value = int(text)
    except (TypeError, ValueError):
        value = -1
    if not 0 <= value <= 255:
        shown = "missing" if text is None else repr(text)[:60]
        raise SceneError(f"{where}: {shown}; expected a whole number, 0 to 255")
    return value


def _clean(name: str) -> str:
    """A name as apartments have it; it may be empty."""
    if not name.strip():
        return ""
    return name if re.fullmatch(NAME, name) else free_name(name, ())
