"""``roomseg reproduce``: the paper's maps, experiments, tables and figures."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import click

from roomseg.cli.options import OutputFolder, jobs_option, seed_option
from roomseg.cli.output import counted, follow, progress_bar
from roomseg.cli.runs import Run, run_seed

if TYPE_CHECKING:
    from rich.progress import Progress

    from roomseg.experiments import FloorPlan, Reproduction
    from roomseg.feature_set import MapFeatures

SMALL_PLACES = ("demo1", "demo2", "demo3")
DEFAULT_PRESET = "fast"
QUICK_PRESET = "preview"

EXAMPLE = """\b
Example:
  roomseg reproduce --jobs 2 -o reproduction
  roomseg reproduce --from-features features.h5 -o reproduction
  roomseg reproduce --quick -o quick
"""


@click.command("reproduce", epilog=EXAMPLE)
@click.option(
    "-o",
    "--output",
    type=OutputFolder(),
    default="reproduction",
    show_default=True,
    help="Folder of the report, the feature set and all that is kept; made if it is missing.",
)
@click.option(
    "--maps",
    "folder",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder of the maps; OUTPUT/maps if absent.",
)
@click.option(
    "--from-features",
    "features_file",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Start from a feature set: no maps, no images.",
)
@click.option(
    "--quick", is_flag=True, help="Three small apartments and coarse searches, in minutes."
)
@click.option("--preset", help="Render settings; fast, or preview with --quick, if absent.")
@jobs_option
@seed_option
def command(
    *,
    output: Path,
    folder: Path | None,
    features_file: Path | None,
    quick: bool,
    preset: str | None,
    jobs: int,
    seed: int,
) -> None:
    """Reproduce the paper's experiments, and write a report with its numbers beside ours.

    The reference set is simulated and rendered as far as it is not there, its features are
    computed, and every experiment is run. Whatever is finished is kept: call a stopped
    command again.
    """
    from roomseg.experiments import (
        FULL_SETTINGS,
        QUICK_SETTINGS,
        Cache,
        reproduce,
    )
    from roomseg.feature_set import read_feature_set

    begun = time.monotonic()
    output.mkdir(parents=True, exist_ok=True)
    if features_file is None:
        runs = _runs(folder or output / "maps", quick=quick)
        chosen = preset or (QUICK_PRESET if quick else DEFAULT_PRESET)
        features_file = output / "features.h5"
        features = _features(runs, chosen, features_file, jobs)
    else:
        features = list(read_feature_set(features_file))
    with progress_bar("steps") as bar:
        found = reproduce(
            features,
            _plans(features),
            QUICK_SETTINGS if quick else FULL_SETTINGS,
            Cache(output / "cache"),
            seed=seed,
            jobs=jobs,
            tell=_teller(bar),
        )
    page = _write(found, output / "report", features, features_file, time.monotonic() - begun)
    mean, median = found.segmentations.overall.rows[0].cells
    click.echo(
        f"mean impurity × 100: {mean.written} (paper {mean.paper_written}), "
        f"median {median.written} (paper {median.paper_written})"
    )
    click.echo(page.resolve())


def _runs(folder: Path, *, quick: bool) -> list[Run]:
    """The runs of the reference set; or one in each small apartment, and a new one."""
    from dataset import SIMULATED_CAMERA
    from roomseg.cli.simulate import UNDATED, reference_runs
    from simulator import RobotSpec, SensorSpec

    if not quick:
        return reference_runs(folder)

    def run(place: str, name: str, number: int) -> Run:
        return Run(
            place,
            name,
            run_seed(0, place, number),
            UNDATED,
            folder / f"{place}-{name}.h5",
            RobotSpec(),
            SensorSpec(),
            SIMULATED_CAMERA,
            None if number == 1 else "random",
        )

    return [*(run(place, "run1", 1) for place in SMALL_PLACES), run(SMALL_PLACES[0], "new1", 2)]


def _features(
    runs: Sequence[Run], preset: str, features_file: Path, jobs: int
) -> list[MapFeatures]:
    """Simulate, render and compute what is missing."""
    from render import preset_named
    from roomseg.cli import render
    from roomseg.cli.feature_sets import complete_feature_set
    from roomseg.cli.simulate import carry_out, tell_all
    from roomseg.feature_set import read_feature_set

    preset_named(preset)  # refused before anything is made
    outcomes, _ = carry_out(runs, jobs)
    tell_all([outcome.problem for outcome in outcomes if outcome.problem is not None])
    maps = tuple(run.output for run in runs)
    click.get_current_context().invoke(render.command, maps=maps, preset=preset, jobs=jobs)
    complete_feature_set(maps, features_file, jobs)
    wanted = {path.stem for path in maps}
    return [
        item
        for item in read_feature_set(features_file)
        if item.labelled.name.replace("/", "-") in wanted
    ]


def _plans(features: Sequence[MapFeatures]) -> dict[str, FloorPlan]:
    """Floor plans of the places that were simulated."""
    from roomseg.experiments import FloorPlan
    from scenes import apartment_from_json, floor_region, obstacles

    scenes = {
        item.labelled.environment: item.labelled.sketch.scene
        for item in features
        if item.labelled.sketch is not None and item.labelled.sketch.scene is not None
    }
    places = {name: apartment_from_json(scene) for name, scene in scenes.items() if scene}
    return {
        name: FloorPlan(obstacles(place), floor_region(place)) for name, place in places.items()
    }


def _teller(bar: Progress) -> Callable[[str, int, int], None]:
    """Show each experiment as a line of progress."""
    lines: dict[str, Callable[[int, int], None]] = {}

    def tell(what: str, done: int, total: int) -> None:
        if what not in lines:
            lines[what] = follow(bar, what)
        lines[what](done, total)

    return tell


def _write(
    found: Reproduction,
    folder: Path,
    features: Sequence[MapFeatures],
    features_file: Path,
    seconds: float,
) -> Path:
    from roomseg.report import Fact
    from roomseg.report.reproduction_page import write_reproduction

    edges = sum(len(item.labelled.features.graph) for item in features)
    return write_reproduction(
        found,
        folder,
        software=f"roomseg {version('roomseg')}",
        description=(
            f"{counted(len(features), 'map')} with {edges:,} edges, from {features_file.name}; "
            f"this call took {seconds / 60:.0f} min, without what was there before."
        ),
        facts=(Fact("maps", str(len(features))),),
    )
