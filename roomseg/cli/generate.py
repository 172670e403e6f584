"""``roomseg generate``: make up apartments."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from roomseg.cli.options import FiniteRange, OutputFile, jobs_option, seed_option
from roomseg.cli.output import counted, follow, progress_bar, tell

if TYPE_CHECKING:
    from scenes.generator import Wishes

Command = TypeVar("Command", bound=Callable[..., Any])


class Range(click.ParamType["float | int | tuple[float, float] | tuple[int, int]"]):
    """A number or two with a hyphen between them: ``4`` or ``2-8``."""

    def __init__(self, least: int, most: int, *, whole: bool) -> None:
        self.least, self.most, self.whole = least, most, whole
        self.name = "number or range"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Refuse what is no number, and numbers outside the limits."""
        number = int if self.whole else float
        try:
            # A hyphen at the beginning is the sign of a number.
            head, hyphen, tail = value[1:].partition("-")
            ends = [number(value[:1] + head), *([number(tail)] if hyphen else [])]
        except ValueError:
            kind = "a whole number" if self.whole else "a number"
            self.fail(f"{value!r} is neither {kind} nor a range such as 2-8", param, ctx)
        for end in ends:
            if not self.least <= end <= self.most:
                limits = f"{self.least}<=x<={self.most}"
                self.fail(f"{end:g} is not in the range {limits}.", param, ctx)
        if ends[0] > ends[-1]:
            right = f"{ends[1]:g}-{ends[0]:g}"
            self.fail(f"{value}; expected the smaller value first, {right}", param, ctx)
        return ends[0] if len(ends) == 1 else tuple(ends)


EXAMPLE = """\b
Example:
  roomseg generate --seed 7 -o home7.json
  roomseg generate --seed 8 --rooms 3 --area 40 --lighting interior -o home8.json
  roomseg generate --count 1000 --jobs 2 --rooms 2-8 -o homes
"""

_SHARES = {
    "--wide-share": "Share (0 to 1) of wide passages without door and lintel where there may be.",
    "--clutter": "How much lies about on the floor, 0 to 1.",
    "--l-shapes": "How readily rooms become L-shaped, 0 to 1.",
}
_CHOICES = {
    "--layout": (("corridor", "hub", "open"), "Along a corridor, around a hall, or open plan."),
    "--contrast": (("low", "medium", "high"), "How much doorways stand out in the images."),
    "--lighting": (("interior", "exterior", "mixed"), "Lamps, sun and sky, or both."),
}


def wish_options(command: Command) -> Command:
    """Options for what the apartments shall be like."""
    for name, text in reversed(_SHARES.items()):
        command = click.option(name, type=FiniteRange(0.0, 1.0), help=text)(command)
    steps = click.IntRange(0, 6)
    text = "Rooms with a step or beam of the ceiling."
    command = click.option("--ceiling-steps", type=steps, help=text)(command)
    for name, (values, text) in reversed(_CHOICES.items()):
        command = click.option(name, type=click.Choice(values), help=text)(command)
    area, rooms = Range(5, 360, whole=False), Range(1, 12, whole=True)
    text = "Clear floor, m², 5 to 30 per room, or a range."
    command = click.option("--area", type=area, help=text)(command)
    return click.option("--rooms", type=rooms, help="How many rooms, or a range.")(command)


@click.command("generate", epilog=EXAMPLE)
@seed_option
@wish_options
@click.option(
    "--count",
    type=click.IntRange(1, 1_000_000),
    help="So many apartments into a folder, with the seeds from SEED on.",
)
@jobs_option
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    required=True,
    help="The apartment, JSON; with --count a folder, made if it is missing.",
)
def command(
    *,
    seed: int,
    count: int | None,
    jobs: int,
    output: Path,
    **asked: Any,
) -> None:
    """Make up apartments that could be real.

    What is not asked for is drawn from the seed. With --count, apartments that
    are already there are left alone, so that a stopped command can be called again.
    """
    from scenes.generator import Wishes

    if count is None:
        output = OutputFile(".json").convert(output, None, click.get_current_context())
        _generate_one(seed, Wishes(**asked), output)
    else:
        _check_folder(output)
        _generate_many(range(seed, seed + count), Wishes(**asked), output, jobs)


def _generate_one(seed: int, wishes: Wishes, output: Path) -> None:
    from scenes import save_apartment
    from scenes.generator import generate

    apartment = generate(seed, wishes)
    save_apartment(apartment, output)
    rooms, pieces = len(apartment.rooms), len(apartment.furniture)
    click.echo(f"{output}: {counted(rooms, 'room')}, {counted(pieces, 'piece')}")


def _check_folder(output: Path) -> None:
    """Refuse a file where a folder is expected, and make the folder.

    Raises
    ------
    click.BadParameter
        One line that says so.
    """
    hint = "'-o' / '--output'"
    if output.is_file() or output.suffix == ".json":
        text = f"{output} is a file name, expected a folder for the apartments of --count"
        raise click.BadParameter(text, param_hint=hint)
    if not output.parent.is_dir():
        text = f"{output}: the folder {output.parent} does not exist"
        raise click.BadParameter(text, param_hint=hint)
    output.mkdir(exist_ok=True)
    if not os.access(output, os.W_OK):
        raise click.BadParameter(f"{output} is not writable", param_hint=hint)


def _generate_many(seeds: range, wishes: Wishes, folder: Path, jobs: int) -> None:
    """Write what is missing; tell what did not come out.

    Raises
    ------
    RoomsegError
        If no apartment was found for some of the seeds, or one that is there is another one.
    """
    from dataset import RoomsegError

    todo = [item for item in _items(seeds, wishes, folder) if not is_there(item[2])]
    there = len(seeds) - len(todo)
    if failed := write_homes(todo, jobs, before=there):
        raise RoomsegError(f"{folder}: {len(failed)} of {len(seeds)} could not be made")
    click.echo(f"{folder}: {len(seeds)} apartments, {there} of them there before")


def write_homes(items: Sequence[Item], jobs: int, before: int) -> list[str]:
    """Generate apartments, with a line of progress; tell and return what did not come out.

    ``before``: how many were done before.
    """
    problems = []
    with progress_bar("homes") as bar:
        show = follow(bar, items[0][2].parent.name if items else "homes")
        show(before, before + len(items))
        for done, problem in enumerate(_write_all(items, jobs), before + 1):
            show(done, before + len(items))
            if problem is not None:
                problems.append(problem)
                tell(bar, problem, err=True)
    return problems


Item = tuple[int, "Wishes", Path]


def _items(seeds: range, wishes: Wishes, folder: Path) -> Iterator[Item]:
    from scenes.generator import apartment_name

    for seed in seeds:
        yield seed, wishes, folder / f"{apartment_name(seed, wishes)}.json"


def is_there(path: Path) -> bool:
    """Whether the apartment of that name, which has seed and wishes in it, is there.

    Raises
    ------
    RoomsegError
        If the file is something else.
    """
    from dataset import RoomsegError
    from scenes import SceneError, load_apartment

    if not path.exists():
        return False
    try:
        name = load_apartment(path, checked=False).name
    except SceneError as error:
        raise RoomsegError(f"{error}; choose another folder") from None
    if name != path.stem:
        raise RoomsegError(f"{path}: is the apartment {name!r}; choose another folder")
    return True


def _write_all(items: Sequence[Item], jobs: int) -> Iterator[str | None]:
    """Write apartments in this process or in several; yield a problem or None for each."""
    if jobs == 1 or len(items) < 2:
        yield from map(_write, items)
        return
    from roomseg.cli.parallel import in_processes

    yield from in_processes(_write, items, jobs, _lost)


def _lost(item: Item) -> str:
    """What to say of an apartment over which a process died twice."""
    return f"{item[2]}: its process died; is there enough memory?"


def _write(item: Item) -> str | None:
    """Generate and write one apartment; the problem if there is none for its seed."""
    from scenes import SceneError, save_apartment
    from scenes.generator import generate

    seed, wishes, path = item
    try:
        apartment = generate(seed, wishes)
    except SceneError as error:
        return str(error)
    save_apartment(apartment, path)
    return None
