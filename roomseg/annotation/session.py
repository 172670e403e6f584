"""One map being annotated: edits are cut, labelled, kept and told to whoever watches.

An edit is answered at once: crossed edges, leaks, and the rooms as the pieces have
them. The spectral clustering takes longer; `Annotation.pending` gives that work to be
done elsewhere, and `Annotation.settle` takes what came out. They differ only in
strips within passages, unless the count that was given is another than the borders'.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dataset import FormatError, GroundTruth, TopoMap, read_map, write_ground_truth
from dataset.closing import Closing
from roomseg.annotation import correction
from roomseg.annotation.carrying import carried_to_map
from roomseg.annotation.cut import Cut, CuttableMap
from roomseg.annotation.drawing import Drawing, Room, checked_line, ranges_of
from roomseg.annotation.history import History
from roomseg.annotation.identity import identified, room_of_nodes
from roomseg.annotation.journal import AnnotationJournal

__all__ = ["Annotation", "Confirmation"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

SAME = 0.35
"""m; a suggestion so near to a border that is drawn is for the same one."""


@dataclass(frozen=True)
class Confirmation:
    """What the clustering says of a drawing: room (n,), and why it cannot stand, if so."""

    drawing: Drawing
    label: Integers
    problem: str


class Annotation(Closing):
    """The annotation of one map file. Use it as a context manager.

    Parameters
    ----------
    path : path
    suggestions : array, shape (k, 2, 2), optional
        Borders that a model proposes, m, in the map frame.
    afresh : bool
        Begin without the borders that the map has.

    Raises
    ------
    RoomsegError
        If the map cannot be read or has no nodes, its journal is damaged, or another
        process annotates it.
    """

    def __init__(
        self, path: str | Path, suggestions: Floats | None = None, *, afresh: bool = False
    ) -> None:
        self.path = Path(path)
        topomap = read_map(path)
        if not len(topomap.nodes):
            raise FormatError(f"{path}: nodes: none, expected some to be told apart")
        self.canvas = CuttableMap(topomap)
        self.suggestions = np.zeros((0, 2, 2)) if suggestions is None else suggestions
        self.watchers: list[Callable[[], None]] = []
        base, self.notice = _base(topomap, afresh=afresh)
        cut = self.canvas.cut(base)
        if base.count == cut.proposed_count:
            base = replace(base, count=None)
        base = self._labelled(base, cut)
        self._journal = AnnotationJournal(path, topomap, base)
        self.history = self._journal.found or History(base)
        self.saved = self.history.past[0] if self.history.past else base
        if self.unsaved:
            edits = len(self.history.past)
            self.notice = f"Found again: {edits} edits that were not saved into the map yet."
        self._take(self.history)

    def close(self) -> None:
        """Let the map go; what is not saved stays in the journal."""
        self._journal.close()

    # What there is to see.

    @property
    def topomap(self) -> TopoMap:
        """The map."""
        return self.canvas.topomap

    @property
    def drawing(self) -> Drawing:
        """What is drawn now."""
        return self.history.present

    @property
    def count(self) -> int:
        """The number of rooms: given, or as many as the borders cut off."""
        given = self.drawing.count
        return min(given or self.cut.proposed_count, len(self.topomap.nodes))

    @property
    def unsaved(self) -> bool:
        """Whether something is drawn that the map does not have."""
        return self.drawing.borders != self.saved.borders or _said(self.drawing) != _said(
            self.saved
        )

    @property
    def room_of_node(self) -> Integers:
        """Number of each node's room, shape (n,)."""
        return room_of_nodes(self.drawing, len(self.topomap.nodes))

    def open_suggestions(self) -> Integers:
        """Which suggestions are neither struck out nor drawn already, or nearly so."""
        struck, drawn = set(self.drawing.struck), self.drawing.segments
        is_open = [
            checked_line(line) not in struck and not any(_alike(line, other) for other in drawn)
            for line in self.suggestions
        ]
        return np.flatnonzero(is_open)

    # Edits; each raises RoomsegError if it makes no sense, and is kept before it counts.

    def draw(self, line: Any) -> None:
        """Draw a border x0, y0, x1, y1."""
        self._edit(self.drawing.with_borders([line]))

    def move(self, border: int, line: Any) -> None:
        """Give a border other ends."""
        self._edit(self.drawing.moved(border, line))

    def delete(self, borders: Iterable[int]) -> None:
        """Delete borders."""
        self._edit(self.drawing.without(borders))

    def give_count(self, count: int | None) -> None:
        """Give the number of rooms; None: as many as the borders cut off."""
        self._edit(self.drawing.counted(count, len(self.topomap.nodes)))

    def rename(self, room: int, name: str) -> None:
        """Name a room."""
        self._edit(self.drawing.renamed(room, name))

    def split(self, room: int) -> None:
        """Draw a border where a room is narrow."""
        self._edit(correction.split(self.canvas, self.drawing, room))

    def merge(self, first: int, second: int) -> None:
        """Take away the borders between two rooms."""
        self._edit(correction.merged(self.canvas, self.drawing, self.cut, first, second))

    def accept(self, suggestions: Iterable[int]) -> None:
        """Draw suggestions as borders."""
        self._edit(self.drawing.with_borders(self.suggestions[index] for index in suggestions))

    def strike(self, suggestion: int) -> None:
        """Strike a suggestion out."""
        self._edit(self.drawing.with_struck(self.suggestions[suggestion]))

    def undo(self) -> None:
        """Take the last edit back."""
        if self.history.past:
            self._journal.append("undo")
            self._take(self.history.undone())

    def redo(self) -> None:
        """Do again what was taken back."""
        if self.history.future:
            self._journal.append("redo")
            self._take(self.history.redone())

    def _edit(self, drawing: Drawing) -> None:
        if drawing == self.drawing:
            return
        cut = self.canvas.cut(drawing)
        drawing = self._labelled(drawing, cut)
        self._journal.append(drawing)
        self._take(self.history.then(drawing), cut)

    def _labelled(self, drawing: Drawing, cut: Cut) -> Drawing:
        """Label by pieces, if these are as many as the rooms; else the clustering will."""
        if drawing.rooms and drawing.count not in (None, cut.proposed_count):
            return drawing
        count = min(cut.proposed_count, len(self.topomap.nodes))
        return identified(drawing, self.canvas.rooms_at_once(cut, count))

    def _take(self, history: History, cut: Cut | None = None) -> None:
        self.history = history
        self.cut = cut or self.canvas.cut(history.present)
        self.confirmation: Confirmation | None = None
        self._tell()

    def _tell(self) -> None:
        for watcher in tuple(self.watchers):
            watcher()

    # The clustering.

    def pending(self) -> Callable[[], Confirmation]:
        """The work of clustering what is drawn now; may be done in another thread."""
        return partial(_confirm, self.canvas, self.drawing, self.cut, self.count)

    def settle(self, confirmation: Confirmation) -> None:
        """Take the clustering's rooms, unless something else is drawn by now."""
        if confirmation.drawing is not self.drawing:
            return
        drawing = identified(self.drawing, confirmation.label)
        if drawing == self.drawing:
            drawing = self.drawing
        self.history = self.history.corrected(drawing)
        self.confirmation = replace(confirmation, drawing=drawing)
        self._tell()

    def save(self) -> str:
        """Write borders, room count, rooms and names into the map; say what was done.

        Borders that do not give that many rooms are written without rooms, and the
        journal stays.

        Raises
        ------
        RoomsegError
            If the map cannot be written, or is another one by now.
        """
        if self.confirmation is None:
            self.settle(self.pending()())
        confirmation = self.confirmation
        assert confirmation is not None
        self._journal.check_same(read_map(self.path))
        truth = GroundTruth(self.drawing.segments, "map", self.cut.edge_is_border, self.count)
        drawn = len(self.drawing.borders)
        lines = f"{drawn} border{'s' * (drawn != 1)}"
        if confirmation.problem:
            write_ground_truth(self.path, truth)
            return f"Saved {lines}, but no rooms yet: {confirmation.problem}"
        names = _names(self.drawing, confirmation.label, self.count)
        room = confirmation.label.astype(np.int32)
        write_ground_truth(self.path, replace(truth, room=room, room_names=names))
        self._journal.clear(self.drawing)
        self.saved = self.drawing
        self._tell()
        rooms = f"{self.count} room{'s' * (self.count != 1)}"
        return f"Saved {lines} and {rooms} into {self.path.name}."


def _alike(line: Floats, other: Floats) -> bool:
    """Whether two lines, shape (2, 2), are for one border: close together, about parallel."""
    step, way = line[1] - line[0], other[1] - other[0]
    share = np.clip((line.mean(axis=0) - other[0]) @ way / (way @ way), 0.0, 1.0)
    off = np.linalg.norm(other[0] + share * way - line.mean(axis=0))
    return bool(off < SAME and abs(step @ way) > 0.7 * np.linalg.norm(step) * np.linalg.norm(way))


def _said(drawing: Drawing) -> Any:
    """What a person has said beside the borders, without numbers of nodes."""
    return drawing.count, {room.id: room.name for room in drawing.active_rooms if room.name}


def _names(drawing: Drawing, label: Integers, count: int) -> tuple[str, ...] | None:
    """Name of each label; None if no room has one."""
    number = room_of_nodes(drawing, len(label))
    names = {room.id: room.name for room in drawing.active_rooms}
    first = np.unique(label, return_index=True)[1][:count]
    found = tuple(names[int(number[node])] for node in first)
    return found if any(found) else None


def _confirm(canvas: CuttableMap, drawing: Drawing, cut: Cut, count: int) -> Confirmation:
    """Label by clustering; if the borders do not cut so many rooms, say so."""
    try:
        return Confirmation(drawing, canvas.confirmed(drawing, cut, count), "")
    except FormatError as error:
        problem = str(error).split("ground_truth/", 1)[-1]
        return Confirmation(drawing, canvas.clustered(cut, count), problem)


def _base(topomap: TopoMap, *, afresh: bool) -> tuple[Drawing, str]:
    """What the map says already, and what to tell of it."""
    truth = topomap.ground_truth
    if truth is None or afresh:
        return Drawing(), ""
    borders, notice = truth.borders, ""
    if truth.frame == "scene":
        if topomap.nodes.true_pose is None:
            return Drawing(), "The map's borders are of its plan, but it has no true poses."
        borders = carried_to_map(topomap.nodes, borders)
        notice = "Borders of the plan, carried over to the robot's map. Saving replaces them."
    # An imported map's may be as short as the steps of a grid.
    drawing = Drawing().with_borders(borders.reshape(-1, 4), shortest=0.0)
    rooms = () if truth.room is None else _rooms(truth.room.astype(np.int64), truth.room_names)
    return replace(drawing, rooms=rooms, next_room=len(rooms) + 1, count=truth.room_count), notice


def _rooms(label: Integers, names: tuple[str, ...] | None) -> tuple[Room, ...]:
    """Identities of the rooms of a map's ground truth."""
    return tuple(
        Room(
            int(index) + 1, names[index] if names else "", ranges_of(np.flatnonzero(label == index))
        )
        for index in np.unique(label)
    )
