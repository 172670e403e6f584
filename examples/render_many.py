"""Add camera images to many maps, several maps at a time.

A map that was interrupted goes on where it was: call the script again. On a cluster, give
each machine other maps (a job array: ``render_many.py maps/*-run$TASK.h5``); every map has
one writer, and a second one is refused. ``--limit`` and the preset ``preview`` are for trying.
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

from render import preset_named, render_map


def render_one(path: Path, preset: str, limit: int | None, threads: int | None) -> str:
    count = render_map(path, preset=preset_named(preset), limit=limit, threads=threads)
    return f"{path}: {count} new images"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("maps", nargs="+", type=Path)
    parser.add_argument("--preset", default="reference")
    parser.add_argument("--limit", type=int)
    parser.add_argument("--jobs", type=int, default=1, help="maps at a time")
    parser.add_argument("--threads", type=int, help="cores of each; all if absent")
    given = parser.parse_args()
    work = partial(render_one, preset=given.preset, limit=given.limit, threads=given.threads)
    with ProcessPoolExecutor(given.jobs, mp_context=get_context("spawn")) as pool:
        for line in pool.map(work, given.maps):
            print(line)


if __name__ == "__main__":
    main()
