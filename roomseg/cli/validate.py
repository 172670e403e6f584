"""``roomseg validate``: everything that is wrong with map files."""

from __future__ import annotations

from pathlib import Path

import click

from roomseg.cli.options import json_option, maps_argument
from roomseg.cli.output import write_json

EXAMPLE = """\b
Example:
  roomseg validate maps/*.h5
"""


@click.command("validate", epilog=EXAMPLE)
@maps_argument
@json_option
def command(*, maps: tuple[Path, ...], json_file: Path | None) -> int:
    """Tell everything that is wrong with map files.

    Prints one line per problem. The exit code is 0 if there is none, 1 if
    there are problems, and 2 if a file cannot be read at all.
    """
    from dataset import problems
    from dataset.storage import open_map

    for path in maps:
        open_map(path).close()
    problems_of = {str(path): list(problems(path)) for path in maps}
    write_json(json_file, problems_of)
    for name, found in problems_of.items():
        for problem in found:
            click.echo(problem if problem.startswith(f"{name}: ") else f"{name}: {problem}")
        if not found:
            click.echo(f"{name}: good")
    return 1 if any(problems_of.values()) else 0
