"""``roomseg simulate``: clean an apartment and record maps."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from datetime import datetime
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from roomseg.cli.options import jobs_option, json_option, seed_option
from roomseg.cli.output import progress_bar, write_json

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from dataset import FisheyeCamera
    from scenes import Apartment
    from simulator import CoverageReport, RobotSpec, SensorSpec

    Show = Callable[[int, float], None]
    """Told the nodes and the simulated seconds."""


@dataclass(frozen=True)
class _Run:
    """One cleaning run to be simulated, as it is sent to another process."""

    apartment: Apartment
    name: str
    seed: int
    created: str
    output: Path
    robot: RobotSpec
    sensor: SensorSpec
    camera: FisheyeCamera
    start: tuple[float, float, float] | None = None


EXAMPLE = """\b
Example:
  roomseg simulate home7.json --runs 3 -o maps
  roomseg simulate sim4 --runs 5 --seed 1 --jobs 2 -o maps
  roomseg simulate sim4 --robot wide.toml -o wide
  roomseg simulate --reference-set --jobs 2 -o maps
"""


@click.command("simulate", epilog=EXAMPLE)
@click.argument("apartment", required=False)
@click.option(
    "--reference-set",
    is_flag=True,
    help="The 31 runs of the reference set, five new ones and five in the additional place "
    "(docs/places.md), instead of APARTMENT; each has its own seed, start and robot.",
)
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
@click.option(
    "--robot",
    "robot_file",
    type=click.Path(path_type=Path),
    help="Another robot, TOML: what differs from the paper's; see docs/robot.md.",
)
@jobs_option
@click.option(
    "--created",
    default="1970-01-01T00:00:00Z",
    show_default=True,
    help="ISO date to write into the maps; a clock would make equal seeds give other bytes.",
)
@click.option("--force", is_flag=True, help="Simulate again where a map is already there.")
@json_option
def command(
    *,
    apartment: str | None,
    reference_set: bool,
    runs: int,
    seed: int,
    output: Path,
    robot_file: Path | None,
    jobs: int,
    created: str,
    force: bool,
    json_file: Path | None,
) -> None:
    """Clean APARTMENT and write one map file per run.

    APARTMENT is a file or the name of a reference place. Maps that are already
    there are left alone, so that a stopped command can be called again. If the
    apartment has a 3D scene of its own, that is put beside the maps.
    """
    _check_date(created)
    if reference_set:
        _check_alone(click.get_current_context())
        wanted = _reference_set(output, created)
    elif apartment is None:
        raise click.UsageError("Missing argument 'APARTMENT', or --reference-set.")
    else:
        wanted = _runs_of(
            apartment, robot_file, runs=runs, seed=seed, output=output, created=created
        )
    todo = []
    for run in wanted:
        if run.output.exists() and not force:
            _check_same(run)
            click.echo(f"{run.output}: already there")
        else:
            todo.append(run)
    reports = _report_all(todo, jobs) if todo else {}
    figures = [{"map": str(path)} | asdict(reports[path]) for path in sorted(reports)]
    write_json(json_file, {"seed": seed, "maps": figures})


def _runs_of(
    apartment: str, robot_file: Path | None, *, runs: int, seed: int, output: Path, created: str
) -> list[_Run]:
    """The runs asked for in one apartment; its own 3D scene is put beside the maps."""
    from dataset import SIMULATED_CAMERA
    from scenes import load_apartment
    from scenes.scene_file import take_scene_file
    from simulator import RobotSpec, SensorSpec, read_specs

    robot, sensor = read_specs(robot_file) if robot_file else (RobotSpec(), SensorSpec())
    place = load_apartment(apartment)
    output.mkdir(parents=True, exist_ok=True)
    take_scene_file(place, Path(apartment).parent, output)
    wanted = []
    for number in range(1, runs + 1):
        name, path = f"run{number}", output / f"{place.name}-run{number}.h5"
        own_seed = run_seed(seed, number)
        wanted.append(_Run(place, name, own_seed, created, path, robot, sensor, SIMULATED_CAMERA))
    return wanted


def _reference_set(output: Path, created: str) -> list[_Run]:
    """All runs of the reference set."""
    from scenes import load_apartment
    from simulator import NEW_RUNS, NOVEL_RUNS, REFERENCE_RUNS

    output.mkdir(parents=True, exist_ok=True)
    wanted = []
    for run in (*REFERENCE_RUNS, *NEW_RUNS, *NOVEL_RUNS):
        place, path = load_apartment(run.place), output / run.file_name
        x, y, heading = run.start
        start = (x, y, radians(heading))
        wanted.append(
            _Run(place, run.name, run.seed, created, path, run.robot, run.sensor, run.camera, start)
        )
    return wanted


def _check_alone(context: click.Context) -> None:
    """Refuse what would not be heeded beside --reference-set."""
    given = click.core.ParameterSource.COMMANDLINE
    for name, text in (
        *(("apartment", "APARTMENT"), ("runs", "--runs")),
        *(("seed", "--seed"), ("robot_file", "--robot")),
    ):
        if context.get_parameter_source(name) == given and context.params[name] is not None:
            raise click.UsageError(f"{text} does not go with --reference-set, which says it all.")


def _check_same(run: _Run) -> None:
    """Refuse to take the map of another apartment or seed for the one that is wanted."""
    from dataset import RoomsegError, read_map
    from simulator import settings_of

    topomap = read_map(run.output)
    place, seed = run.apartment.model_dump_json(), run.seed
    same = {
        "apartment": topomap.scene == place,
        "seed": topomap.seed == seed,
        "robot": topomap.robot == settings_of(run.robot),
        "robot's sensors": topomap.sensor == settings_of(run.sensor),
    }
    if not all(same.values()):
        what = next(name for name, agrees in same.items() if not agrees)
        raise RoomsegError(
            f"{run.output}: already there, but of another {what}; "
            "choose another folder, or simulate again (--force)"
        )


def _report_all(runs: list[_Run], jobs: int) -> dict[Path, CoverageReport]:
    """Simulate, with a line of progress, and a line of figures for each run."""
    reports = {}
    with progress_bar("runs") as bar:
        task = bar.add_task("cleaning", total=len(runs))

        def show(nodes: int, seconds: float) -> None:
            bar.update(task, description=f"{nodes} nodes, {seconds / 60:.0f} min")

        for path, report in _simulate_all(runs, jobs, show):
            reports[path] = report
            bar.advance(task)
            click.echo(f"{path}: {_line(report)}")
    return reports


def _line(report: CoverageReport) -> str:
    return (
        f"{report.nodes} nodes, {100 * report.coverage:.1f} % covered, "
        f"{report.path_length:.0f} m driven in {report.duration / 60:.0f} min, "
        f"{report.nodes_per_m2:.1f} nodes/m², drift {report.drift:.2f} m"
    )


def _check_date(text: str) -> None:
    try:
        datetime.fromisoformat(text)
    except ValueError:
        raise click.BadParameter(
            f"{text!r} is no ISO date, expected one like 2026-01-31T12:00:00Z",
            param_hint="'--created'",
        ) from None


def run_seed(seed: int, number: int) -> int:
    """Seed of one run: independent of the others, and of how many there are."""
    return int(np.random.SeedSequence([seed, number]).generate_state(1)[0])


def _simulate_all(runs: list[_Run], jobs: int, show: Show) -> Iterator[tuple[Path, CoverageReport]]:
    if jobs == 1 or len(runs) < 2:
        yield from (_simulate(run, show) for run in runs)
        return
    from roomseg.cli.parallel import in_processes

    yield from in_processes(_simulate, runs, jobs)


def _simulate(run: _Run, show: Show | None = None) -> tuple[Path, CoverageReport]:
    """Simulate one run, write its map, and report on it."""
    from dataset import discard_frames, write_map
    from dataset.journal import journal_path
    from roomseg.ground_truth import label_rooms
    from simulator import coverage_report, simulate

    topomap = simulate(
        run.apartment,
        run=run.name,
        seed=run.seed,
        robot=run.robot,
        sensor=run.sensor,
        camera=run.camera,
        start=run.start,
        created=run.created,
        progress=show,
    )
    report = coverage_report(topomap, run.apartment, lane_spacing=run.robot.lane_spacing)
    topomap = label_rooms(topomap)
    if journal_path(run.output).exists():
        # Frames of the map that is being replaced would not fit the new one.
        discard_frames(run.output)
    write_map(run.output, topomap)
    return run.output, report
