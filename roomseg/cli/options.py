"""Options and arguments that several commands share."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

__all__ = [
    "FiniteRange",
    "OutputFile",
    "OutputFolder",
    "jobs_option",
    "json_option",
    "maps_argument",
    "output_option",
    "seed_option",
]

Command = TypeVar("Command", bound=Callable[..., Any])


class FiniteRange(click.FloatRange):
    """A number within bounds; click lets NaN through every bound."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Refuse what is not finite, too."""
        number = float(super().convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f"{value} is not a finite number", param, ctx)
        return number


class OutputFile(click.ParamType[Path]):
    """A file to be written, checked before the work begins rather than after it."""

    name = "file"

    def __init__(self, *suffixes: str) -> None:
        self.suffixes = suffixes
        """What the name has to end in; anything if there are none."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Refuse a folder, a device, a map, and a folder that is missing or not writable."""
        path = Path(value)
        if path.is_dir():
            self.fail(f"{path} is a folder, expected a file name", param, ctx)
        if path.exists() and (path.suffix == ".h5" or _is_map(path)):
            self.fail(f"{path} is a map and would be lost, expected another file name", param, ctx)
        if path.exists() and not path.is_file():
            self.fail(f"{path} is no regular file, expected another file name", param, ctx)
        if self.suffixes and path.suffix.lower() not in self.suffixes:
            ends = " or ".join(self.suffixes)
            self.fail(f"{path}: expected a name that ends in {ends}", param, ctx)
        if not self.suffixes and path.suffix == ".h5":
            self.fail(f"{path}: a name that ends in .h5 is a map's, expected another", param, ctx)
        # A link stays, and the file that it leads to is written.
        folder = path.resolve().parent if path.is_symlink() else path.parent
        if not folder.is_dir():
            self.fail(f"{path}: the folder {folder} does not exist", param, ctx)
        if not os.access(folder, os.W_OK):
            self.fail(f"{path}: the folder {folder} is not writable", param, ctx)
        return path


FILE_SUFFIXES = frozenset({".h5", ".hdf5", ".json", ".toml", ".html"})
"""Names that end so are not meant to be folders."""


class OutputFolder(click.Path):
    """A folder to be written, made if it is missing."""

    def __init__(self) -> None:
        super().__init__(file_okay=False, path_type=Path)

    def convert(
        self,
        value: str | os.PathLike[str],
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> Path:
        """Refuse a file, and a name that was meant to be one."""
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        if path.suffix.lower() in FILE_SUFFIXES and not path.exists():
            self.fail(f"{path} is the name of a file, expected a folder", param, ctx)
        return path


def _is_map(path: Path) -> bool:
    """Whether there is a map, or another HDF5 file, of whatever name."""
    if not path.is_file():
        return False
    from dataset.reading import begins_as_hdf5

    return begins_as_hdf5(path)


maps_argument = click.argument(
    "maps", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="MAP..."
)

json_option = click.option(
    "--json", "json_file", type=OutputFile(), help="Also write the figures to a JSON file."
)

seed_option = click.option(
    "--seed",
    type=click.IntRange(0, 2**32 - 1),
    default=0,
    show_default=True,
    help="Same seed, same result.",
)

jobs_option = click.option(
    "--jobs",
    type=click.IntRange(1),
    default=1,
    show_default=True,
    help="How many processes work at the same time.",
)


def output_option(
    text: str, *suffixes: str, default: str | None = None
) -> Callable[[Command], Command]:
    """Make ``-o FILE`` with one of the suffixes; required if it has no default."""
    # An explicit default of None would make click take the option as given.
    given: dict[str, Any] = (
        {"required": True} if default is None else {"default": default, "show_default": True}
    )
    return click.option("-o", "--output", type=OutputFile(*suffixes), help=text, **given)
