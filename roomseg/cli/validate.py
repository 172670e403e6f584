"""``roomseg validate``: everything that is wrong with map files."""

from __future__ import annotations

from pathlib import Path

import click

from roomseg.cli.options import maps_argument

EXAMPLE = """\b
Example:
  roomseg validate maps/*.h5
"""


@click.command("validate", epilog=EXAMPLE)
@maps_argument
def command(*, maps: tuple[Path, ...]) -> int:
    """Tell everything that is wrong with map files.

    Prints one line per problem. The exit code is 0 if there is none, 1 if
    there are problems, and 2 if a file cannot be read at all.
    """
    from dataset import problems
    from dataset.storage import open_map

    for path in maps:
        open_map(path).close()
    bad = 0
    for path in maps:
        found = list(problems(path))
        bad += bool(found)
        for problem in found:
            click.echo(problem if problem.startswith(str(path)) else f"{path}: {problem}")
        if not found:
            click.echo(f"{path}: good")
    return 1 if bad else 0
