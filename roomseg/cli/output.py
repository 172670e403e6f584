"""What commands print: progress on standard error, figures on standard output."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
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
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table
from rich.text import Text

__all__ = ["progress_bar", "write_json", "write_table"]


class _Rate(ProgressColumn):
    """How many per minute."""

    def __init__(self, unit: str) -> None:
        super().__init__()
        self.unit = unit

    def render(self, task: Task) -> Text:
        speed = task.finished_speed or task.speed
        rate = "-" if speed is None else f"{60.0 * speed:.3g}"
        return Text(f"{rate} {self.unit}/min")


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
        BarColumn(),
        MofNCompleteColumn(),
        _Rate(unit),
        TextColumn("left"),
        TimeRemainingColumn(),
        TextColumn("after"),
        TimeElapsedColumn(),
    )
    # A long window: Blender's first frame of a map takes far longer than the others.
    with Progress(*columns, console=Console(stderr=True), speed_estimate_period=120.0) as bar:
        yield bar


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
    width = console.measure(table).maximum
    Console(width=max(width, console.width) if not console.is_terminal else None).print(table)
    click.echo(nl=False)
