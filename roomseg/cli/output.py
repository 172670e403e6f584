"""What commands print: progress on standard error, figures on standard output."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeRemainingColumn,
)
from rich.table import Table
from rich.text import Text

__all__ = ["counted", "follow", "progress_bar", "tell", "write_json", "write_table"]


MOST_COLUMNS = 1000
"""No table is wider."""


class _Rate(ProgressColumn):
    """How many per minute since the beginning, without those that were there before."""

    def __init__(self, unit: str) -> None:
        super().__init__()
        self.unit = unit

    def render(self, task: Task) -> Text:
        seconds = task.finished_time or task.elapsed
        new = task.completed - task.fields.get("begin", 0)
        rate = _figures(60.0 * new / seconds) if seconds and new else "-"
        return Text(f"{rate} {self.unit}/min", no_wrap=True)


def counted(number: int, noun: str) -> str:
    """``1 room``, ``2 rooms``."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _figures(value: float) -> str:
    """Three figures, without an exponent."""
    return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"


@contextmanager
def progress_bar(unit: str) -> Iterator[Progress]:
    """Show bars on standard error: done of total, rate per minute, time left.

    Parameters
    ----------
    unit : str
        What is counted, in the plural.
    """
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=20),
        MofNCompleteColumn(),
        _Rate(unit),
        TimeRemainingColumn(),
        TextColumn("left"),
    )
    # A long window: Blender's first frame of a map takes far longer than the others.
    bar = Progress(
        *columns,
        console=Console(stderr=True),
        speed_estimate_period=120.0,
        # Else what is printed for a file would be shown above the bar instead.
        redirect_stdout=sys.stdout.isatty(),
    )
    bar.start()
    shown = False
    try:
        yield bar
        shown = bool(bar.tasks)
    finally:
        if shown:
            bar.stop()
        else:
            # An error is one line; neither a bar nor an empty line stays above it.
            bar.live.transient = True
            bar.live.stop()


def follow(bar: Progress, name: str) -> Callable[[int, int], None]:
    """Add a line to a bar, and return what moves it: called with (done, total)."""
    task = bar.add_task(name, total=None)
    begun = False

    def show(done: int, total: int) -> None:
        nonlocal begun
        if not begun:
            # The rate counts from here, without what was there before.
            bar.reset(task, total=total, completed=done, begin=done)
            begun = True
        bar.update(task, total=total, completed=done)

    return show


def tell(bar: Progress, line: str, *, err: bool = False) -> None:
    """Print a line while bars are shown: above them if both go to one terminal."""
    stream = sys.stderr if err else sys.stdout
    if bar.console.is_terminal and stream.isatty():
        bar.console.print(line, markup=False, highlight=False, emoji=False, soft_wrap=True)
    else:
        click.echo(line, err=err)


def write_json(path: Path | None, figures: Any) -> None:
    """Write figures for machines, atomically; nothing if no file was asked for."""
    if path is not None:
        from dataset.atomic import write_text

        write_text(path, json.dumps(figures, indent=2, ensure_ascii=False) + "\n")


def write_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table; numbers, all but the first column, to the right."""
    table = Table(title=title, title_justify="left")
    for index, column in enumerate(columns):
        table.add_column(column, justify="left" if index == 0 else "right", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    # Piped output has no width of its own; a table for a file must not be cut.
    console = Console()
    if not console.is_terminal:
        console = Console(width=Console(width=MOST_COLUMNS).measure(table).maximum)
    console.print(table)
