"""Does the robot always finish? Generated apartments, or others, two starts each.

The first start is the apartment's own, the second a random reachable pose. For
every run: does it end by itself, which share of the reachable positions lies within
20 cm of the driven path, does the true body ever enter an obstacle of the true plan,
is the map graph connected, and how long is the path beside the shortest possible
(free area over lane spacing). Runs that fail are drawn. A stopped benchmark goes on
where it was.

    python benchmarks/coverage.py --count 500 --jobs 2 -o out/coverage
    python benchmarks/coverage.py sim1 sim2 home.json -o out/some
"""

from __future__ import annotations

import json
import sys
import time
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

# Some files here have the names of packages, which Python would find first.
sys.path[:] = [folder for folder in sys.path if Path(folder) != Path(__file__).resolve().parent]

import click
import numpy as np
import shapely

from dataset.atomic import write_text
from roomseg.cli.output import follow, progress_bar, write_json, write_table
from roomseg.cli.parallel import in_processes

LEAST_COVERAGE = 0.98
FEW = 24
"""So many runs get a row each."""
AT_HOME = 0.3
"""A run has come home if it ends this near to its base, m."""
TOUCH = 1e-3
"""How far the body's disc may seem to reach into an obstacle, m: bisection's rest."""


def one_run(key: tuple[str, int], folder: Path) -> dict[str, Any]:
    """Clean a place from one of its starts; figures of the run."""
    from dataset import RoomsegError
    from scenes.solids import obstacles
    from simulator import RobotSpec, coverage_report, random_start, simulate

    place, number = key
    apartment, seed = apartment_of(place)
    robot = RobotSpec()
    solid = obstacles(apartment, high=robot.height)
    shapely.prepare(solid)
    rng = np.random.default_rng([seed, number])
    start = random_start(apartment, robot, rng) if number else None
    figures: dict[str, Any] = {"place": place, "start": number, "rooms": len(apartment.rooms)}
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
        draw(topomap, apartment, figures, folder / f"{Path(place).stem}-start{number}.png")
    return figures


def apartment_of(place: str) -> tuple[Any, int]:
    """The apartment, and a seed for its runs: ``home-7`` is generated with seed 7."""
    from scenes import load_apartment
    from scenes.generator import generate_apartment

    name, _, seed = place.rpartition("-")
    if name == "home" and seed.isdecimal():
        return generate_apartment(int(seed)), int(seed)
    return load_apartment(place), 0


def is_failure(figures: dict[str, Any]) -> bool:
    """Whether a run breaks what every run must keep."""
    return bool(
        figures["failed"]
        or figures["coverage"] < LEAST_COVERAGE
        or figures["collisions"]
        or not figures["connected"]
        or figures["from_home"] > AT_HOME
    )


def failure(figures: dict[str, Any]) -> str:
    """What a run that ended breaks, in words."""
    graph = "connected" if figures["connected"] else "in pieces"
    return (
        f"{100 * figures['coverage']:.1f} % covered, {figures['collisions']} collisions, "
        f"graph {graph}, {figures['from_home']:.2f} m from the base"
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


COLUMNS = ("start", "coverage", "path, m", "over shortest", "robot's hours", "seconds")


def row(run: dict[str, Any]) -> tuple[str, ...]:
    """One run in the table of all runs."""
    name = (Path(run["place"]).stem, str(run["start"]))
    if run["failed"]:
        return (*name, *["-"] * (len(COLUMNS) - 1))
    return (
        *name,
        f"{100 * run['coverage']:.2f} %",
        f"{run['path_length']:.0f}",
        f"{run['path_length'] / run['shortest_path']:.2f}",
        f"{run['duration'] / 3600:.1f}",
        f"{run['seconds']:.1f}",
    )


def summary(runs: list[dict[str, Any]]) -> list[tuple[str, str]]:
    """The rows of the table."""
    ended = [run for run in runs if run["failed"] is None]
    if not ended:
        return [("runs", str(len(runs))), ("ended by themselves", "0.0 %")]
    coverage = np.array([run["coverage"] for run in ended])
    length = np.array([run["path_length"] for run in ended])
    ratio = length / np.array([run["shortest_path"] for run in ended])
    turns = np.array([run["turns"] * run["path_per_m2"] / run["path_length"] for run in ended])
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
            f"back at the base ({AT_HOME} m)",
            f"{100 * np.mean([run['from_home'] <= AT_HOME for run in ended]):.1f} %",
        ),
        ("path per floor, median", f"{np.median([run['path_per_m2'] for run in ended]):.2f} m/m²"),
        ("path over the shortest possible, median", f"{np.median(ratio):.2f}"),
        ("overlap, median", f"{100 * np.median([run['overlap'] for run in ended]):.0f} %"),
        ("full turns per m², median", f"{np.median(turns):.2f}"),
        ("nodes per m², median", f"{np.median([run['nodes_per_m2'] for run in ended]):.1f}"),
        ("seconds, median and most", f"{np.median(seconds):.2f}, {seconds.max():.2f}"),
    ]


def journalled(journal: Path) -> dict[tuple[str, int], dict[str, Any]]:
    """Runs of the journal by place and start; a line that was cut short is dropped."""
    text = journal.read_text(encoding="utf-8") if journal.exists() else ""
    whole = text[: text.rfind("\n") + 1]
    if whole != text:
        write_text(journal, whole)
    return {(run["place"], run["start"]): run for run in map(json.loads, whole.splitlines())}


@click.command()
@click.argument("places", nargs=-1)
@click.option(
    "--count", default=500, show_default=True, help="Generated apartments, without PLACES."
)
@click.option("--seed", default=0, show_default=True, help="Of the first one.")
@click.option("--starts", default=2, show_default=True, help="Runs in each.")
@click.option("--jobs", default=1, show_default=True)
@click.option("-o", "--output", type=click.Path(path_type=Path), default="out/coverage")
@click.option("--json", "json_file", type=click.Path(path_type=Path))
def main(
    places: tuple[str, ...],
    count: int,
    seed: int,
    starts: int,
    jobs: int,
    output: Path,
    json_file: Path | None,
) -> None:
    """PLACES are names of reference places and apartment files."""
    output.mkdir(parents=True, exist_ok=True)
    journal = output / "runs.jsonl"
    known = journalled(journal)
    title = f"{len(places) or count} {'' if places else 'generated '}apartments, {starts} starts"
    places = places or tuple(f"home-{k}" for k in range(seed, seed + count))
    wanted = [(place, number) for place in places for number in range(starts)]
    todo = [key for key in wanted if key not in known]
    with progress_bar("runs") as bar, journal.open("a", encoding="utf-8") as file:
        show = follow(bar, "coverage")
        show(len(wanted) - len(todo), len(wanted))
        work = partial(one_run, folder=output)
        for done, run in enumerate(in_processes(work, todo, jobs), len(wanted) - len(todo) + 1):
            known[run["place"], run["start"]] = run
            file.write(json.dumps(run) + "\n")
            file.flush()
            show(done, len(wanted))
    runs = [known[key] for key in wanted]
    write_json(json_file, {"runs": runs})
    if len(runs) <= FEW:
        write_table("every run", ("place", *COLUMNS), [row(run) for run in runs])
    write_table(title, ("", "measured"), summary(runs))
    for run in filter(is_failure, runs):
        print(f"{run['place']} start {run['start']}: {run['failed'] or failure(run)}")


if __name__ == "__main__":
    main()
