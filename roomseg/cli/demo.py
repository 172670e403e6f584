"""``roomseg demo``: all of it on three small apartments, ending in a report to look at."""

from __future__ import annotations

from pathlib import Path

import click

from roomseg.cli.options import OutputFolder, seed_option
from roomseg.cli.output import follow, progress_bar

PLACES = ("demo1", "demo2", "demo3")

EXAMPLE = """\b
Example:
  roomseg demo -o out/demo
"""


@click.command("demo", epilog=EXAMPLE)
@click.option(
    "-o",
    "--output",
    type=OutputFolder(),
    default="demo",
    show_default=True,
    help="Folder of the maps and the report; made if it is missing.",
)
@click.option("--preset", default="preview", show_default=True, help="Render settings.")
@seed_option
@click.pass_context
def command(ctx: click.Context, *, output: Path, preset: str, seed: int) -> None:
    """Clean, render and segment three small apartments, and write an HTML report.

    Each apartment's rooms are found by a classifier that was trained on the
    other two, with the best of nine parameter combinations (§2.3.3). Maps and
    images that are there are kept, so that a stopped demo goes on where it was.
    """
    from dataset import write_rooms
    from render import preset_named
    from roomseg.cli import render, simulate
    from roomseg.cli.features import labelled_maps
    from roomseg.cli.reporting import assemble
    from roomseg.evaluation import leave_one_environment_out
    from roomseg.parameter_search import EXCERPT, search_parameters
    from roomseg.report import write_report

    preset_named(preset)  # refused before anything is made
    maps = tuple(output / f"{place}-run1.h5" for place in PLACES)
    ctx.invoke(simulate.command, apartments=PLACES, output=output, seed=seed)
    ctx.invoke(render.command, maps=maps, preset=preset)
    labelled = labelled_maps(maps, "all")
    with progress_bar("combinations") as bar:
        searched = search_parameters(labelled, seed=seed, progress=follow(bar, "parameters"))
    evaluation = leave_one_environment_out(labelled, searched.best, seed=seed)
    for path, item, result in zip(maps, labelled, evaluation.results, strict=True):
        name = "the other places' classifier"
        write_rooms(path, result.labels, model=name, rooms=item.room_count)
    with progress_bar("figures") as bar:
        task = bar.add_task("report", total=None)
        page = write_report(assemble(maps, labelled, evaluation, searched), output / "report")
        bar.update(task, total=1, completed=1)
    papers = float(searched.mean[searched.combinations.index(EXCERPT[0])])
    click.echo(
        f"mean impurity {100 * evaluation.mean_impurity:.2f} % with the classifier "
        f"({100 * papers:.2f} % with the paper's parameters), "
        f"{100 * evaluation.uniform_impurity.mean():.2f} % with uniform weights"
    )
    click.echo(page.resolve())
