"""``roomseg simulate``: clean an apartment and record maps."""

from __future__ import annotations

import signal
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from roomseg.cli.options import jobs_option, seed_option
from roomseg.cli.output import progress_bar

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenes import Apartment


@dataclass(frozen=True)
class _Run:
    """One cleaning run to be simulated, as it is sent to another process."""

    apartment: Apartment
    name: str
    seed: int
    output: Path


EXAMPLE = """\b
Example:
  roomseg simulate home7.json --runs 3 -o maps
  roomseg simulate sim4 --runs 5 --seed 1 --jobs 2 -o maps
"""


@click.command("simulate", epilog=EXAMPLE)
@click.argument("apartment")
@click.option(
    "--runs", type=click.IntRange(1, 1000), default=1, show_default=True, help="Cleaning runs."
)
@seed_option
@click.option(
    "-o",
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    default=".",
    show_default=True,
    help="Folder of the map files; made if it is missing.",
)
@jobs_option
@click.option("--force", is_flag=True, help="Simulate again where a map is already there.")
def command(*, apartment: str, runs: int, seed: int, output: Path, jobs: int, force: bool) -> None:
    """Clean APARTMENT and write one map file per run.

    APARTMENT is a file or the name of a reference place. Maps that are already
    there are left alone, so that a stopped command can be called again.
    """
    from scenes import load_apartment

    place = load_apartment(apartment)
    output.mkdir(parents=True, exist_ok=True)
    todo = []
    for number in range(1, runs + 1):
        path = output / f"{place.name}-run{number}.h5"
        if path.exists() and not force:
            click.echo(f"{path}: already there")
        else:
            todo.append(_Run(place, f"run{number}", run_seed(seed, number), path))
    with progress_bar("runs") as bar:
        task = bar.add_task(place.name, total=len(todo))
        for line in _simulate_all(todo, jobs):
            bar.advance(task)
            click.echo(line)


def run_seed(seed: int, number: int) -> int:
    """Seed of one run: independent of the others, and of how many there are."""
    return int(np.random.SeedSequence([seed, number]).generate_state(1)[0])


def _simulate_all(runs: list[_Run], jobs: int) -> Iterator[str]:
    if jobs == 1 or len(runs) < 2:
        yield from map(_simulate, runs)
        return
    # Spawned, not forked: threads of numerical libraries do not survive a fork.
    pool = ProcessPoolExecutor(jobs, get_context("spawn"), initializer=_leave_stopping_to_parent)
    try:
        for future in as_completed([pool.submit(_simulate, run) for run in runs]):
            yield future.result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _leave_stopping_to_parent() -> None:
    """Ctrl-C reaches the whole group: the run in progress ends, the parent says one line."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _simulate(run: _Run) -> str:
    """Simulate one run, write its map, and report on it in one line."""
    from dataset import discard_frames, write_map
    from dataset.journal import journal_path
    from roomseg.ground_truth import label_rooms
    from simulator import coverage_report, simulate

    topomap = simulate(run.apartment, run=run.name, seed=run.seed)
    report = coverage_report(topomap, run.apartment)
    topomap = label_rooms(topomap)
    if journal_path(run.output).exists():
        # Frames of the map that is being replaced would not fit the new one.
        discard_frames(run.output)
    write_map(run.output, topomap)
    return f"{run.output}: {report}"
