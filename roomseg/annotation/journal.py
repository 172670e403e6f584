"""What is drawn is kept beside the map at once, edit by edit.

``MAP.annotation`` is a text file, one line of JSON for each edit, forced to disk
before the page shows that it was taken. Its first line says which map it belongs to
and what was drawn before; each further one is the drawing after an edit, or
``"undo"`` or ``"redo"``. A last line that a crash has torn is dropped. The file has
one writer, and goes when the annotation is saved into the map.
"""

from __future__ import annotations

import hashlib
import json
import os
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Any

from pydantic import TypeAdapter, ValidationError

from dataset.atomic import force_to_disk, locked, unwritten
from dataset.closing import Closing
from dataset.errors import FormatError
from dataset.topomap import TopoMap
from roomseg.annotation.drawing import Drawing
from roomseg.annotation.history import History

__all__ = ["AnnotationJournal", "journal_path"]

FORMAT = "roomseg-annotation"
VERSION = 1
OPEN = "the map is open in another `roomseg annotate`; end that first"
_DRAWING = TypeAdapter(Drawing)


def journal_path(path: str | Path) -> Path:
    """Name the journal of a map file."""
    return Path(f"{Path(path).resolve()}.annotation")


def _fingerprint(topomap: TopoMap) -> str:
    """Tells maps apart, but not a map from itself with another ground truth."""
    digest = hashlib.sha256(topomap.nodes.position.tobytes())
    digest.update(topomap.edges.tobytes())
    return digest.hexdigest()


def _line(content: Any) -> bytes:
    return json.dumps(content, separators=(",", ":")).encode()


class AnnotationJournal(Closing):
    """The one writer of a map's journal. Use it as a context manager.

    Parameters
    ----------
    path : path
        The map file.
    topomap : TopoMap
    base : Drawing
        What the map says, before the first edit.

    Attributes
    ----------
    found : History or None
        What an earlier session has drawn and not saved.

    Raises
    ------
    FormatError
        If there is a journal of another map, or a damaged one.
    RoomsegError
        If another process is annotating the map.
    """

    def __init__(self, path: str | Path, topomap: TopoMap, base: Drawing) -> None:
        self.path = journal_path(path)
        self._map = _fingerprint(topomap)
        self._stream: IO[bytes] | None = None
        self._base = base
        with ExitStack() as stack:
            stack.enter_context(locked(self.path, busy=OPEN))
            self.found = self._read() if self.path.exists() else None
            self._stack = stack.pop_all()

    def close(self) -> None:
        """Let the journal go; its file stays."""
        if self._stream is not None:
            self._stream.close()
            self._stream = None
        self._stack.close()

    def append(self, step: Drawing | str) -> None:
        """Keep a drawing after an edit, or ``"undo"`` or ``"redo"``; on disk when it returns."""
        try:
            if self._stream is None:
                self._stream = self._opened()
            whole = _DRAWING.dump_json(step) if isinstance(step, Drawing) else _line(step)
            self._write(self._stream, whole)
        except OSError as error:
            raise unwritten(self.path, error) from error

    def check_same(self, topomap: TopoMap) -> None:
        """Refuse a map that is not the one that is drawn on (FormatError)."""
        if _fingerprint(topomap) != self._map:
            raise FormatError(
                f"{self.path.stem}: is another map now than the one drawn on; what is drawn "
                f"stays in {self.path.name}"
            )

    def clear(self, base: Drawing) -> None:
        """Everything is in the map now, which says ``base``."""
        if self._stream is not None:
            self._stream.close()
            self._stream = None
        self.path.unlink(missing_ok=True)
        self._base = base

    def _opened(self) -> IO[bytes]:
        new = not self.path.exists()
        stream = self.path.open("ab", buffering=0)
        if new:
            head = {"format": FORMAT, "version": VERSION, "map": self._map}
            base = _DRAWING.dump_python(self._base, mode="json")
            self._write(stream, _line(head | {"base": base}))
            force_to_disk(self.path.parent)
        return stream

    def _write(self, stream: IO[bytes], line: bytes) -> None:
        size = stream.seek(0, os.SEEK_END)
        try:
            stream.write(line + b"\n")
            os.fsync(stream.fileno())
        except OSError:
            # Of a full disk: half a line would spoil the next one.
            os.truncate(stream.fileno(), size)
            raise

    def _read(self) -> History | None:
        """Read the journal; a torn end is cut off the file, too."""
        content = self.path.read_bytes()
        whole = content[: content.rfind(b"\n") + 1]
        if not whole:
            self.path.unlink()
            return None
        lines = whole.splitlines()
        history = self._head(lines[0])
        for number, line in enumerate(lines[1:], start=2):
            history = self._step(history, line, number)
        if len(whole) < len(content):
            os.truncate(self.path, len(whole))
        return history

    def _head(self, line: bytes) -> History:
        head = self._parsed(line, 1)
        if not isinstance(head, dict) or head.get("format") != FORMAT:
            raise FormatError(f"{self.path}: no journal of an annotation, move it away")
        if head.get("version") != VERSION:
            raise FormatError(f"{self.path}: version {head.get('version')!r}, expected {VERSION}")
        if head.get("map") != self._map:
            raise FormatError(
                f"{self.path}: was drawn on another map of this name, move it away or bring "
                "that map back"
            )
        return History(self._drawing(head.get("base"), 1))

    def _step(self, history: History, line: bytes, number: int) -> History:
        content = self._parsed(line, number)
        if content == "undo":
            return history.undone()
        if content == "redo":
            return history.redone()
        return history.then(self._drawing(content, number))

    def _parsed(self, line: bytes, number: int) -> Any:
        try:
            return json.loads(line)
        except ValueError as error:
            raise self._damaged(number, error) from error

    def _drawing(self, content: Any, number: int) -> Drawing:
        try:
            return _DRAWING.validate_python(content)
        except ValidationError as error:
            raise self._damaged(number, error.errors()[0]["msg"]) from error

    def _damaged(self, number: int, reason: object) -> FormatError:
        return FormatError(
            f"{self.path}: line {number} is damaged ({reason}), remove it to go on with the others"
        )
