"""``roomseg render``: add camera images to maps."""

from __future__ import annotations

from pathlib import Path

import click
from rich.progress import TaskID

from roomseg.cli.options import maps_argument
from roomseg.cli.output import progress_bar

EXAMPLE = """\b
Example:
  roomseg render maps/*.h5
  roomseg render maps/home7-run1.h5 --preset preview --limit 20
"""


@click.command("render", epilog=EXAMPLE)
@maps_argument
@click.option(
    "--preset",
    default="reference",
    show_default=True,
    help="Render settings: reference, draft (noisier), preview (small).",
)
@click.option("--limit", type=click.IntRange(1), help="At most so many new images per map.")
@click.option("--threads", type=click.IntRange(1), help="Threads of the renderer; all if absent.")
@click.option("--force", is_flag=True, help="Throw away the images that are there.")
def command(
    *, maps: tuple[Path, ...], preset: str, limit: int | None, threads: int | None, force: bool
) -> None:
    """Add camera images to maps.

    Images that are there are kept, each new one is safe as soon as it is
    finished, and a stopped command goes on where it was when called again.
    """
    from dataset import discard_frames, read_map
    from render import preset_named, render_map

    chosen = preset_named(preset)
    for path in maps:
        # All files are looked at before hours are spent on the first.
        read_map(path)
    with progress_bar("images") as bar:
        for path in maps:
            if force:
                discard_frames(path)
            task = bar.add_task(path.name, total=None)

            def show(done: int, total: int, task: TaskID = task) -> None:
                bar.update(task, completed=done, total=total)

            count = render_map(path, preset=chosen, limit=limit, threads=threads, on_progress=show)
            click.echo(f"{path}: {count} new images")
