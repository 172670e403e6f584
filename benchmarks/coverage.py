"""Does the robot always finish? Generated apartments, two starts each.

The first start is the apartment's own, the second a random reachable pose. For
every run: does it end by itself, which share of the reachable positions lies within
20 cm of the driven path, does the true body ever enter an obstacle of the true plan,
is the map graph connected, and how long is the path beside the shortest possible
(free area over lane spacing). Runs that fail are drawn. A stopped benchmark goes on
where it was.

    python benchmarks/coverage.py --count 500 --jobs 2 -o out/coverage
"""

from __future__ import annotations

import json
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from multiprocessing import get_context
from pathlib import Path
from typing import Any

# Some files here have the names of packages, which Python would find first.
sys.path[:] = [folder for folder in sys.path if Path(folder) != Path(__file__).resolve().parent]

import click
import numpy as np
import shapely

from roomseg.cli.output import follow, progress_bar, write_json, write_table

LEAST_COVERAGE = 0.98
TOUCH = 1e-3
"""How far the body's disc may seem to reach into an obstacle, m: bisection's rest."""


def one_run(seed: int, number: int, folder: Path) -> dict[str, Any]:
    """Clean the apartment of a seed from one of its starts; figures of the run."""
    from dataset import RoomsegError
    from scenes.generator import generate_apartment
    from scenes.passages import reachable_positions
    from scenes.solids import obstacles
    from simulator import RobotSpec, coverage_report, simulate

    apartment, robot = generate_apartment(seed), RobotSpec()
    solid = obstacles(apartment, high=robot.height)
    shapely.prepare(solid)
    start = None
    if number:
        rng = np.random.default_rng([seed, number])
        places = reachable_positions(apartment, robot.radius)
        # Grid points on the very limit may touch by rounding.
        places = places[~shapely.dwithin(solid, shapely.points(places), robot.radius + 1e-6)]
        start = (*places[rng.integers(len(places))].tolist(), float(rng.uniform(-np.pi, np.pi)))
    figures: dict[str, Any] = {"seed": seed, "start": number, "rooms": len(apartment.rooms)}
    begin = time.process_time()
    try:
        topomap = simulate(apartment, seed=seed + number, start=start)
    except RoomsegError as error:
        return figures | {"failed": str(error)}
    figures |= {"failed": None, "seconds": time.process_time() - begin}
    report = coverage_report(topomap, apartment)
    assert topomap.path is not None
    track = shapely.points(topomap.path.true_pose[:, :2])
    inside = shapely.dwithin(solid, track, robot.radius - TOUCH)
    figures |= asdict(report) | {"collisions": int(inside.sum())}
    if is_failure(figures):
        draw(topomap, apartment, figures, folder / f"home-{seed}-start{number}.png")
    return figures


def is_failure(figures: dict[str, Any]) -> bool:
    """Whether a run breaks what every run must keep."""
    return bool(
        figures["failed"]
        or figures["coverage"] < LEAST_COVERAGE
        or figures["collisions"]
        or not figures["connected"]
    )


def draw(topomap: Any, apartment: Any, figures: dict[str, Any], path: Path) -> None:
    """The run over the plan, with what stayed uncovered in red."""
    from roomseg.figures import draw_cleaning_run, new_figure, png_bytes
    from scenes.passages import reachable_positions
    from scenes.solids import obstacles

    figure = new_figure(9.0, 8.0)
    axes = figure.add_subplot()
    title = f"{path.stem}: {100 * figures['coverage']:.1f} % covered"
    draw_cleaning_run(axes, topomap=topomap, outlines=obstacles(apartment), title=title)
    places = reachable_positions(apartment)
    line = shapely.linestrings(topomap.path.true_pose[:, :2])
    shapely.prepare(line)
    left = places[~shapely.dwithin(line, shapely.points(places), 0.2)]
    axes.plot(*left.T, "r.", markersize=2)
    path.write_bytes(png_bytes(figure, 90))


def summary(runs: list[dict[str, Any]]) -> list[tuple[str, str]]:
    """The rows of the table."""
    ended = [run for run in runs if run["failed"] is None]
    coverage = np.array([run["coverage"] for run in ended])
    length = np.array([run["path_length"] for run in ended])
    ratio = length / np.array([run["shortest_path"] for run in ended])
    seconds = np.array([run["seconds"] for run in ended])
    return [
        ("runs", str(len(runs))),
        ("ended by themselves", f"{100 * len(ended) / len(runs):.1f} %"),
        ("coverage, lowest", f"{100 * coverage.min():.2f} %"),
        ("coverage, 5th percentile", f"{100 * np.percentile(coverage, 5):.2f} %"),
        ("coverage, median", f"{100 * np.median(coverage):.2f} %"),
        (
            f"runs below {100 * LEAST_COVERAGE:.0f} %",
            str(int((coverage < LEAST_COVERAGE).sum())),
        ),
        ("collisions of the true body", str(sum(run["collisions"] for run in ended))),
        ("connected graphs", f"{100 * np.mean([run['connected'] for run in ended]):.1f} %"),
        (
            "back at the base (0.3 m)",
            f"{100 * np.mean([r['from_home'] < 0.3 for r in ended]):.1f} %",
        ),
        ("path per floor, median", f"{np.median([run['path_per_m2'] for run in ended]):.2f} m/m²"),
        ("path over the shortest possible, median", f"{np.median(ratio):.2f}"),
        ("overlap, median", f"{100 * np.median([run['overlap'] for run in ended]):.0f} %"),
        ("nodes per m², median", f"{np.median([run['nodes_per_m2'] for run in ended]):.1f}"),
        ("seconds, median and most", f"{np.median(seconds):.2f}, {seconds.max():.2f}"),
    ]


@click.command()
@click.option("--count", default=500, show_default=True, help="Apartments.")
@click.option("--seed", default=0, show_default=True, help="Of the first apartment.")
@click.option("--starts", default=2, show_default=True, help="Runs in each.")
@click.option("--jobs", default=1, show_default=True)
@click.option("-o", "--output", type=click.Path(path_type=Path), default="out/coverage")
@click.option("--json", "json_file", type=click.Path(path_type=Path))
def main(
    count: int, seed: int, starts: int, jobs: int, output: Path, json_file: Path | None
) -> None:
    output.mkdir(parents=True, exist_ok=True)
    journal = output / "runs.jsonl"
    lines = journal.read_text().splitlines() if journal.exists() else []
    known = {(run["seed"], run["start"]): run for run in map(json.loads, lines)}
    wanted = [(s, number) for s in range(seed, seed + count) for number in range(starts)]
    todo = [key for key in wanted if key not in known]
    with (
        ProcessPoolExecutor(jobs, get_context("spawn")) as pool,
        progress_bar("runs") as bar,
        journal.open("a", encoding="utf-8") as file,
    ):
        show = follow(bar, "coverage")
        tasks = [pool.submit(one_run, *key, output) for key in todo]
        for done, task in enumerate(as_completed(tasks), len(wanted) - len(todo) + 1):
            run = task.result()
            known[run["seed"], run["start"]] = run
            file.write(json.dumps(run) + "\n")
            file.flush()
            show(done, len(wanted))
    runs = [known[key] for key in wanted]
    write_json(json_file, {"runs": runs})
    write_table(f"{count} generated apartments, {starts} starts", ("", "measured"), summary(runs))
    for run in filter(is_failure, runs):
        print(f"home-{run['seed']} start {run['start']}: {run['failed'] or run['coverage']}")


if __name__ == "__main__":
    main()
