"""The command ``roomseg``: finds the command's module, and ends in one clear line.

Nothing heavy is imported here, so that ``roomseg --help`` answers at once; a
command's module is imported when the command is called, and what it needs
when it runs. `main` is the one place that catches errors of the user's.
"""

from __future__ import annotations

import importlib
import keyword
import os
import sys
from collections.abc import Sequence

import click

__all__ = ["cli", "main"]

COMMANDS = {
    "demo": "All of it, small, in minutes.",
    "generate": "Make up an apartment.",
    "import": "Make an apartment of a plan or scene, a map of a run.",
    "export": "Write an apartment or a map for other programs.",
    "simulate": "Clean apartments and record maps.",
    "render": "Add camera images to maps.",
    "expose": "Expose the images of maps again, without rendering.",
    "build": "Make a whole dataset from a recipe.",
    "features": "Put the edge features of maps into one small file.",
    "train": "Train the room-border classifier.",
    "segment": "Find the rooms of a map.",
    "annotate": "Draw room borders on maps in the browser.",
    "evaluate": "Judge the method, leaving each environment out once.",
    "reproduce": "The paper's experiments, table by table.",
    "inspect": "Show what is in a map, an apartment or a dataset.",
    "validate": "Tell everything that is wrong with maps and apartments.",
    "view": "Draw a map or an apartment.",
    "replay": "Show a cleaning run as a film.",
}
"""In the order of the work; each is ``command`` of the module of its name.

A name that is a word of Python has a line behind it there: ``import_``."""

EXAMPLE = """\b
Example:
  roomseg generate --seed 7 -o home7.json
  roomseg simulate home7.json --runs 3 -o maps
  roomseg render maps/*.h5
  roomseg evaluate maps/*.h5
"""

BAD_INPUT = 2
STOPPED = 130


class LazyGroup(click.Group):
    """A group that imports a command when it is called, not to list it."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Name the commands in the order of the work."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the command's module."""
        if cmd_name not in COMMANDS:
            return None
        module = f"{cmd_name}_" if keyword.iskeyword(cmd_name) else cmd_name
        command = importlib.import_module(f"roomseg.cli.{module}").command
        assert isinstance(command, click.Command)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(
    cls=LazyGroup,
    epilog=EXAMPLE,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(package_name="roomseg", message="roomseg %(version)s")
def cli() -> None:
    """Labelled indoor maps with camera images, and human-like room segmentation.

    Stages go from file to file; each can be stopped and started again.
    """


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments : sequence of str, optional
        Those of the process if absent.

    Returns
    -------
    int
        0: done; 1: `roomseg validate` found problems; 2: bad input, told in
        one line; 130: stopped by the user.
    """
    try:
        code = cli.main(args=arguments, prog_name="roomseg", standalone_mode=False)
    except click.exceptions.NoArgsIsHelpError as help_:
        click.echo(help_.format_message(), err=True)
        return BAD_INPUT
    except (click.Abort, KeyboardInterrupt):
        return _say("stopped; call it again to go on", STOPPED, "")
    except BrokenPipeError:
        # The reader of our output (head, less) has had enough: no error.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception as error:
        message = _message(error)
        if message is None:
            raise
        return _say(message, BAD_INPUT)
    return code if isinstance(code, int) else 0


def _say(message: str, code: int, kind: str = "error: ") -> int:
    """Print one line to standard error, whatever line breaks the message has."""
    print(f"roomseg: {kind}{' '.join(message.split())}", file=sys.stderr)
    return code


def _message(error: Exception) -> str | None:
    """Choose what to tell the user; None if the error is ours."""
    # Imported only now, when it matters.
    from dataset.errors import RoomsegError
    from scenes.errors import SceneError

    if isinstance(error, click.UsageError):
        command = f"{error.ctx.command_path} --help" if error.ctx else "roomseg --help"
        return f"{error.format_message().rstrip('.')}; see `{command}`"
    if isinstance(error, click.ClickException):
        return error.format_message()
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}"
    return str(error) if isinstance(error, OSError | RoomsegError | SceneError) else None
