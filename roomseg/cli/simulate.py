"""``roomseg simulate``: clean apartments and record maps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from datetime import datetime
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from roomseg.cli.options import FiniteRange, OutputFolder, jobs_option, json_option, seed_option
from roomseg.cli.output import counted, follow, progress_bar, tell, write_json
from roomseg.cli.runs import Outcome, Run, attempt, lost, recognise, run_seed

if TYPE_CHECKING:
    from dataset import FisheyeCamera
    from simulator import CoverageReport

UNDATED = "1970-01-01T00:00:00Z"
"""The same date in all maps, whenever they were made."""

COMPILING = "the simulator is compiled, once after it was installed; this takes some 20 s"

EXAMPLE = """\b
Example:
  roomseg simulate home7.json --runs 3 -o maps
  roomseg simulate homes/*.json --runs 2 --random-starts --jobs 2 -o maps
  roomseg simulate sim4 --robot wide.toml -o wide
  roomseg simulate --reference-set --jobs 2 -o maps
"""


@click.command("simulate", epilog=EXAMPLE)
@click.argument("apartments", nargs=-1, metavar="APARTMENT...")
@click.option(
    "--reference-set",
    is_flag=True,
    help="The 31 runs of the reference set, five new ones and five in the additional place "
    "(docs/places.md), instead of APARTMENT; each has its own seed, start and robot.",
)
@click.option(
    "--runs",
    type=click.IntRange(1, 1000),
    default=1,
    show_default=True,
    help="Cleaning runs in each apartment.",
)
@click.option(
    "--random-starts",
    is_flag=True,
    help="Begin each run at a pose of its own, anywhere within reach of the apartment's start.",
)
@click.option(
    "--start",
    type=(FiniteRange(), FiniteRange(), FiniteRange()),
    metavar="X Y HEADING",
    help="Begin at this pose instead of the apartment's: m, m, degrees.",
)
@seed_option
@click.option(
    "-o",
    "--output",
    type=OutputFolder(),
    default=".",
    show_default=True,
    help="Folder of the map files; made if it is missing.",
)
@click.option(
    "--robot",
    "robot_file",
    type=click.Path(path_type=Path),
    help="Another robot, TOML: what differs from the paper's; see docs/robot.md. One too "
    "large for the base begins beside it.",
)
@jobs_option
@click.option(
    "--created",
    default=UNDATED,
    show_default=True,
    help="ISO date to write into the maps; a clock would make equal seeds give other bytes.",
)
@click.option("--force", is_flag=True, help="Simulate again where a map is already there.")
@json_option
def command(
    *,
    apartments: tuple[str, ...],
    reference_set: bool,
    runs: int,
    random_starts: bool,
    start: tuple[float, float, float] | None,
    seed: int,
    output: Path,
    robot_file: Path | None,
    jobs: int,
    created: str,
    force: bool,
    json_file: Path | None,
) -> None:
    """Clean every APARTMENT and write one map file per run.

    APARTMENT is a file or the name of a reference place. Maps that are already
    there are left alone, so that a stopped command can be called again. If an
    apartment has a 3D scene of its own, that is put beside the maps. What fails
    is listed at the end; the other runs go on.
    """
    from simulator import RobotSpec, SensorSpec, read_specs

    _check_date(created)
    _check_reference_set(click.get_current_context())
    begin = _start(start, random_starts, apartments)
    robot, sensor = read_specs(robot_file) if robot_file else (RobotSpec(), SensorSpec())
    camera = _camera(robot_file)
    sources, problems = _by_name(apartments)
    if reference_set:
        wanted = reference_runs(output, created)
    else:
        usual = Run("", "", 0, created, output, robot, sensor, camera, begin)
        wanted = [*runs_in(sources, usual, runs, seed)]
    outcomes, there = carry_out(wanted, jobs, force=force, judged=json_file is not None)
    reports = {o.output: o.report for o in outcomes if o.report is not None}
    figures = [{"map": str(path)} | asdict(reports[path]) for path in sorted(reports)]
    write_json(json_file, {"seed": seed, "maps": figures})
    problems += [outcome.problem for outcome in outcomes if outcome.problem is not None]
    if len(apartments) > 1:
        made = sum(outcome.problem is None for outcome in outcomes)
        click.echo(f"{output}: {counted(made, 'map')}, {there} of them there before")
    tell_all(problems)


def carry_out(
    wanted: Sequence[Run], jobs: int, *, force: bool = False, judged: bool = False
) -> tuple[list[Outcome], int]:
    """Recognise the maps that are there and simulate the others; how many were there."""
    there = {run.output for run in wanted if not force and run.output.exists()}
    outcomes = [*_recognise([run for run in wanted if run.output in there], judged=judged)]
    todo = [run for run in wanted if run.output not in there]
    outcomes += clean(todo, jobs, before=len(there)) if todo else ()
    return outcomes, len(there)


def _start(
    start: tuple[float, float, float] | None, random_starts: bool, apartments: Sequence[str]
) -> tuple[float, float, float] | Literal["random"] | None:
    """Where the runs begin: x m, y m and the heading in rad, drawn, or at the base."""
    if start is None:
        return "random" if random_starts else None
    if random_starts or len(apartments) > 1:
        other = "--random-starts" if random_starts else "several apartments"
        raise click.UsageError(f"--start does not go with {other}.")
    return start[0], start[1], radians(start[2])


def _camera(robot_file: Path | None) -> FisheyeCamera:
    """The camera of the robot.

    Raises
    ------
    RoomsegError
        If it cannot be read, or its images could not be rendered later.
    """
    from dataset import SIMULATED_CAMERA, RoomsegError
    from render.blender import render_window
    from simulator.camera_file import read_camera

    if robot_file is None:
        return SIMULATED_CAMERA
    camera = read_camera(robot_file)
    try:
        render_window(camera)
    except ValueError as error:
        raise RoomsegError(f"{robot_file}: camera.{error}") from error
    return camera


def _by_name(apartments: Sequence[str]) -> tuple[dict[str, str], list[str]]:
    """Sources of the apartments by name, and one line on each that cannot be read.

    Raises
    ------
    RoomsegError
        If two have the same name: the maps of one would stand for those of the other.
    """
    from dataset import RoomsegError
    from scenes import SceneError, load_apartment

    sources: dict[str, str] = {}
    problems = []
    for source in apartments:
        try:
            # Many are checked where they are cleaned: here it would take a minute or so.
            place = load_apartment(source, checked=len(apartments) == 1)
        except SceneError as error:
            problems.append(str(error))
            continue
        if place.name in sources:
            raise RoomsegError(
                f"{source}: name: {place.name!r}, as in {sources[place.name]}; expected another "
                "one, as the maps are named after it"
            )
        sources[place.name] = source
    return sources, problems


def runs_in(sources: Mapping[str, str], usual: Run, count: int, seed: int) -> Iterator[Run]:
    """So many runs in each apartment, otherwise as ``usual``, whose output is the folder."""
    for place, source in sources.items():
        for number in range(1, count + 1):
            name = f"run{number}"
            yield replace(
                usual,
                apartment=source,
                name=name,
                seed=run_seed(seed, place, number),
                output=usual.output / f"{place}-{name}.h5",
            )


def reference_runs(output: Path, created: str = UNDATED) -> list[Run]:
    """All runs of the reference set."""
    from simulator import NEW_RUNS, NOVEL_RUNS, REFERENCE_RUNS

    return [
        Run(
            apartment=run.place,
            name=run.name,
            seed=run.seed,
            created=created,
            output=output / run.file_name,
            robot=run.robot,
            sensor=run.sensor,
            camera=run.camera,
            start=(*run.start[:2], radians(run.start[2])),
        )
        for run in (*REFERENCE_RUNS, *NEW_RUNS, *NOVEL_RUNS)
    ]


def _recognise(runs: Sequence[Run], *, judged: bool) -> Iterator[Outcome]:
    """Look at the maps that are there, with a line for each that is as wanted."""
    for run in runs:
        outcome = recognise(run, judged=judged)
        if outcome.problem is None:
            click.echo(f"{run.output}: already there")
        yield outcome


def clean(runs: Sequence[Run], jobs: int, before: int) -> Iterator[Outcome]:
    """Simulate, with a line of progress, and a line of figures for each run.

    ``before``: how many runs were done before.
    """
    from simulator.steering import is_compiled

    with progress_bar("runs") as bar:
        folders = {run.output.parent.name for run in runs}
        title = (folders.pop() if len(folders) == 1 else "") or "maps"
        show = follow(bar, title)
        show(before, before + len(runs))
        if not is_compiled():
            tell(bar, COMPILING, err=True)

        def show_nodes(nodes: int, seconds: float) -> None:
            name = f"{nodes} nodes, {seconds / 60:.0f} min"
            bar.update(bar.task_ids[0], description=name)

        for done, outcome in enumerate(_outcomes(runs, jobs, show_nodes), before + 1):
            show(done, before + len(runs))
            if outcome.report is not None:
                tell(bar, f"{outcome.output}: {_line(outcome.report)}")
            if outcome.trace is not None:
                tell(bar, outcome.trace, err=True)
            yield outcome
        bar.update(bar.task_ids[0], description=title)


def _outcomes(
    runs: Sequence[Run], jobs: int, show: Callable[[int, float], None]
) -> Iterator[Outcome]:
    """Simulate in this process, which tells more, or in several."""
    if jobs == 1 or len(runs) < 2:
        yield from (attempt(run, show) for run in runs)
        return
    from roomseg.cli.parallel import in_processes

    yield from in_processes(attempt, runs, jobs, lost)


def _line(report: CoverageReport) -> str:
    return (
        f"{report.nodes} nodes, {100 * report.coverage:.1f} % covered, "
        f"{report.path_length:.0f} m driven in {report.duration / 60:.0f} min "
        f"(shortest possible {report.shortest_path:.0f} m), "
        f"{100 * report.overlap:.0f} % overlap, {report.turns:.0f} turns, "
        f"drift {report.drift:.2f} m"
    )


def tell_all(problems: Sequence[str]) -> None:
    """List what failed, each cause once.

    Raises
    ------
    RoomsegError
        The last of them.
    """
    from dataset import RoomsegError

    *others, last = dict.fromkeys(problems) or [None]
    for problem in others:
        click.echo(f"roomseg: error: {problem}", err=True)
    if last is not None:
        raise RoomsegError(last)


def _check_reference_set(context: click.Context) -> None:
    """Refuse what would not be heeded beside --reference-set, and nothing at all."""
    if not context.params["reference_set"]:
        if not context.params["apartments"]:
            raise click.UsageError("Missing argument 'APARTMENT...', or --reference-set.")
        return
    given = click.core.ParameterSource.COMMANDLINE
    others = {"apartments": "APARTMENT", "runs": "--runs", "random_starts": "--random-starts"}
    others["start"] = "--start"
    for name, text in (others | {"seed": "--seed", "robot_file": "--robot"}).items():
        if context.get_parameter_source(name) == given and context.params[name] not in (None, ()):
            raise click.UsageError(f"{text} does not go with --reference-set, which says it all.")


def _check_date(text: str) -> None:
    try:
        datetime.fromisoformat(text)
    except ValueError:
        raise click.BadParameter(
            f"{text!r} is no ISO date, expected one like 2026-01-31T12:00:00Z",
            param_hint="'--created'",
        ) from None
