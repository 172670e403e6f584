"""Rendering many maps for `roomseg render` and `roomseg build`: one by one, or by a pool."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from roomseg.cli.output import follow, tell

if TYPE_CHECKING:
    from rich.progress import Progress

    from render import Outcome, Wanted

__all__ = ["ImageBar", "rendered", "scheduler_option", "threads_option"]

scheduler_option = click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Render on the workers of this Dask scheduler, tcp://HOST:PORT, instead of here.",
)

threads_option = click.option(
    "--threads",
    type=click.IntRange(1),
    help="Threads of each renderer; all cores shared if absent, one on a cluster.",
)


class ImageBar:
    """One line for the images of all maps: how many, per minute, time left, and where.

    Parameters
    ----------
    bar : Progress
    counts : mapping of Path to (int, int)
        Images that each map has, and will have.
    """

    def __init__(self, bar: Progress, counts: Mapping[Path, tuple[int, int]]) -> None:
        self._bar = bar
        self._done = {path: done for path, (done, _) in counts.items()}
        self._total = sum(total for _, total in counts.values())
        self._move = follow(bar, "images")
        self._move(sum(self._done.values()), self._total)

    def show(self, path: Path, done: int, total: int) -> None:
        """A map has ``done`` images now."""
        self._bar.update(self._bar.task_ids[0], description=path.stem)
        self._done[path] = done
        self._move(sum(self._done.values()), self._total)

    def tell(self, path: Path, line: str) -> None:
        """Say something about a map."""
        tell(self._bar, f"{path}: {line}", err=True)


def rendered(
    maps: Sequence[Path],
    wanted: Wanted,
    bar: ImageBar,
    *,
    jobs: int = 1,
    scheduler: str | None = None,
) -> Generator[Outcome, None, None]:
    """Render what maps lack; yield what became of each. Use `contextlib.closing`."""
    if jobs > 1 or scheduler is not None:
        # Dask takes a second to load.
        from render.pool import render_maps

        yield from render_maps(
            maps, wanted, jobs=jobs, scheduler=scheduler, tell=bar.tell, show=bar.show
        )
    else:
        yield from (_rendered_here(path, wanted, bar) for path in maps)


def _rendered_here(path: Path, wanted: Wanted, bar: ImageBar) -> Outcome:
    """Render one map in one process."""
    from dataset import RoomsegError, discard_frames
    from render import Outcome, render_map
    from scenes import SceneError

    try:
        if wanted.force:
            discard_frames(path)
        count = render_map(
            path,
            preset=wanted.preset,
            limit=wanted.limit,
            threads=wanted.threads,
            device=wanted.device,
            hdr=wanted.hdr,
            on_device=lambda device: bar.tell(path, f"rendering on {device}"),
            on_bake=lambda: bar.tell(path, "baking the light, once per apartment"),
            on_progress=lambda done, total: bar.show(path, done, total),
        )
    except (RoomsegError, SceneError, OSError) as error:
        return Outcome(path, 0, error)
    return Outcome(path, count)
