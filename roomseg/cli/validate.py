"""``roomseg validate``: everything that is wrong with maps and apartments."""

from __future__ import annotations

from pathlib import Path

import click

from roomseg.cli.options import json_option
from roomseg.cli.output import write_json
from roomseg.cli.sources import is_apartment

EXAMPLE = """\b
Example:
  roomseg validate maps/*.h5
  roomseg validate home7.json
"""


@click.command("validate", epilog=EXAMPLE)
@click.argument(
    "files", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="FILE..."
)
@json_option
def command(*, files: tuple[Path, ...], json_file: Path | None) -> int:
    """Tell everything that is wrong with map files and apartments (.json).

    Prints one line per problem. The exit code is 0 if there is none, 1 if
    there are problems, and 2 if a file cannot be read at all.
    """
    problems_of, unreadable = _judge(files)
    write_json(json_file, problems_of)
    for name, found in problems_of.items():
        for problem in found:
            click.echo(problem if problem.startswith(f"{name}: ") else f"{name}: {problem}")
        if not found:
            click.echo(f"{name}: good")
    if unreadable is not None:
        raise unreadable
    return 1 if any(problems_of.values()) else 0


def _judge(files: tuple[Path, ...]) -> tuple[dict[str, list[str]], Exception | None]:
    """Problems of each readable file, and the error of the last one that is not."""
    from dataset import RoomsegError
    from scenes import SceneError

    problems_of: dict[str, list[str]] = {}
    unreadable: Exception | None = None
    for path in files:
        try:
            problems_of[str(path)] = _problems(path)
        except (RoomsegError, SceneError) as error:
            if unreadable is not None:
                click.echo(f"roomseg: error: {unreadable}", err=True)
            unreadable = error
    return problems_of, unreadable


def _problems(path: Path) -> list[str]:
    if is_apartment(path):
        return _problems_of_apartment(path)
    from dataset import problems
    from dataset.reading import open_map

    open_map(path).close()
    return list(problems(path))


def _problems_of_apartment(path: Path) -> list[str]:
    from scenes import SceneError, load_apartment

    try:
        load_apartment(str(path))
    except SceneError as error:
        if not error.problems:
            raise
        return list(error.problems)
    return []
