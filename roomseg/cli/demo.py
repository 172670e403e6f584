"""``roomseg demo``: all of it on three small apartments, ending in a report to look at."""

from __future__ import annotations

from pathlib import Path

import click

from roomseg.cli.options import seed_option
from roomseg.cli.output import progress_bar

PLACES = ("demo1", "demo2", "demo3")

EXAMPLE = """\b
Example:
  roomseg demo -o out/demo
"""


@click.command("demo", epilog=EXAMPLE)
@click.option(
    "-o",
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
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
    other two. Maps and images that are there are kept, so that a stopped demo
    goes on where it was.
    """
    from dataset import write_rooms
    from roomseg.cli import render, simulate
    from roomseg.cli.features import labelled_maps
    from roomseg.cli.reporting import assemble
    from roomseg.evaluation import leave_one_environment_out
    from roomseg.report import write_report

    maps = tuple(output / f"{place}-run1.h5" for place in PLACES)
    for place in PLACES:
        ctx.invoke(simulate.command, apartment=place, output=output, seed=seed)
    ctx.invoke(render.command, maps=maps, preset=preset)
    labelled = labelled_maps(maps, "all")
    evaluation = leave_one_environment_out(labelled, seed=seed)
    for path, item, result in zip(maps, labelled, evaluation.results, strict=True):
        name = "the other places' classifier"
        write_rooms(path, result.labels, model=name, rooms=item.room_count)
    with progress_bar("figures") as bar:
        task = bar.add_task("report", total=None)
        page = write_report(assemble(maps, labelled, evaluation), output / "report")
        bar.update(task, total=1, completed=1)
    uniform = evaluation.uniform_impurity.mean()
    click.echo(
        f"mean impurity {100 * evaluation.mean_impurity:.2f} % with the classifier, "
        f"{100 * uniform:.2f} % with uniform weights"
    )
    click.echo(page.resolve())
