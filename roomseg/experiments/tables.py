"""Tables with the paper's number beside ours in every cell, and what to say where they differ."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from matplotlib.figure import Figure

__all__ = ["Cell", "Drawing", "Row", "Table"]

MISSING = "–"


@dataclass(frozen=True)
class Cell:
    """Our number and the paper's, None (for ours, NaN) where there is none.

    ``accepted`` is the range within which we call them alike; ``digits`` are written after
    the point. A ``paper`` number without ours is shown, but not compared. A difference that is
    ``expected`` is no finding.
    """

    ours: float | None
    paper: float | None = None
    accepted: tuple[float, float] | None = None
    digits: int = 2
    expected: bool = False

    def __post_init__(self) -> None:
        if self.ours is not None and math.isnan(self.ours):
            object.__setattr__(self, "ours", None)

    @property
    def agrees(self) -> bool | None:
        """Whether ours lies in the accepted range; None without one."""
        if self.accepted is None or self.ours is None:
            return None
        return bool(self.accepted[0] <= self.ours <= self.accepted[1])

    @property
    def differs(self) -> bool:
        """Whether the two are not the same as they are written, and should be."""
        if self.expected or None in (self.ours, self.paper):
            return False
        return self.written != self.paper_written

    @property
    def written(self) -> str:
        """Our number as it is shown."""
        return _written(self.ours, self.digits)

    @property
    def paper_written(self) -> str:
        """The paper's number as it is shown."""
        return _written(self.paper, self.digits)

    @property
    def band(self) -> str:
        """The accepted range as it is shown."""
        if self.accepted is None:
            return ""
        low, high = (_written(limit, self.digits) for limit in self.accepted)
        if self.accepted[0] == float("-inf"):
            return f"at most {high}"
        return f"at least {low}" if self.accepted[1] == float("inf") else f"{low} to {high}"


def _written(value: float | None, digits: int) -> str:
    if value is None:
        return MISSING
    return f"{value:.{digits}f}".replace("-", "−")


@dataclass(frozen=True)
class Row:
    """A row's label and its cells, one for each column."""

    label: str
    cells: tuple[Cell, ...]


@dataclass(frozen=True)
class Table:
    """A table of the paper, or one of the same kind.

    Attributes
    ----------
    name : str
        Of its file, such as ``table3``.
    title : str
    columns : tuple of str
        Heading of the labels, then of each cell.
    rows : tuple of Row
    note : str
    said : bool
        Whether each difference is worth a sentence of its own.

    Raises
    ------
    ValueError
        If a row has another number of cells than there are columns.
    """

    name: str
    title: str
    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    note: str = ""
    said: bool = True

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row.cells) != len(self.columns) - 1:
                raise ValueError(
                    f"{self.name}: {row.label}: {len(row.cells)} cells, "
                    f"expected {len(self.columns) - 1}"
                )

    @property
    def sentences(self) -> tuple[str, ...]:
        """One for every cell in which ours and the paper's number differ as written."""
        return tuple(self._sentences()) if self.said else ()

    @property
    def misses(self) -> tuple[str, ...]:
        """One for every cell that lies outside of what we accept."""
        return tuple(self._sentences(misses_only=True))

    def _sentences(self, *, misses_only: bool = False) -> Iterator[str]:
        for row in self.rows:
            for column, cell in zip(self.columns[1:], row.cells, strict=True):
                if cell.agrees is False or (cell.differs and not misses_only):
                    name = row.label if len(row.cells) == 1 else f"{row.label}, {column}"
                    yield f"{name}: {_difference(cell)}."

    def csv(self) -> str:
        """Comma-separated values: ours, the paper's and the verdict for each column."""
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        heads = [
            f"{name}{part}" for name in self.columns[1:] for part in ("", " (paper)", " (accepted)")
        ]
        writer.writerow([self.columns[0], *heads])
        for row in self.rows:
            values = [part for cell in row.cells for part in _csv_cells(cell)]
            writer.writerow([row.label, *values])
        return stream.getvalue()


def _csv_cells(cell: Cell) -> list[str]:
    verdict = {None: "", True: "within", False: "outside"}[cell.agrees]
    numbers = ["" if value is None else f"{value:.10g}" for value in (cell.ours, cell.paper)]
    return [*numbers, f"{verdict} {cell.band}".strip()]


def _difference(cell: Cell) -> str:
    """Say what we found, what the paper has, by how much, and whether that is accepted."""
    said = f"{cell.written} here"
    if cell.ours is not None and cell.paper is not None:
        more = cell.ours - cell.paper
        same = not cell.differs
        amount = _written(abs(more), cell.digits)
        small = cell.digits and float(amount) == 0.0
        way = "higher" if more > 0 else "lower"
        by = "as written the same" if same else f"{'slightly' if small else amount} {way}"
        said += f", {cell.paper_written} in the paper ({by})"
    if cell.agrees is False and cell.written in (cell.band.split(" to ")):
        # Outside by less than is written.
        said += f" (exactly {_written(cell.ours, cell.digits + 2)})"
    if cell.agrees is not None:
        said += f"; {'within' if cell.agrees else 'outside'} what we accept, {cell.band}"
    return said


@dataclass(frozen=True)
class Drawing:
    """A figure of the report, drawn when it is written.

    Attributes
    ----------
    name : str
        Of its files, such as ``fig11``.
    title, caption : str
    draw : callable
        Makes the figure.
    """

    name: str
    title: str
    caption: str
    draw: Callable[[], Figure] = field(compare=False)
