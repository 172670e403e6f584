"""``roomseg view``: draw a map or an apartment, or show it, a model, or a folder as a page."""

from __future__ import annotations

import tempfile
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from roomseg.cli.options import OutputFile
from roomseg.cli.panels import SHOWN, map_panels
from roomseg.cli.sources import Kind, is_apartment, kind_of

if TYPE_CHECKING:
    from scenes import Apartment

DRAWINGS = (".png", ".svg", ".pdf", ".html")
PHOTOS = (".png", ".jpg", ".jpeg")

EXAMPLE = """\b
Example:
  roomseg view maps/sim4-run1.h5
  roomseg view maps/sim4-run1.h5 --compare model.skops -o page.html
  roomseg view home7.json -o home7.pdf
  roomseg view sim4 --cutaway -o sim4.jpg
  roomseg view maps/sim4-run1.h5 --show graph --show rooms -o rooms.png
  roomseg view model.skops
  roomseg view maps -o maps.html
"""


@click.command("view", epilog=EXAMPLE)
@click.argument("source", metavar="MAP|APARTMENT|MODEL|FOLDER", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=OutputFile(),
    help="A page (.html), or of a map or an apartment a picture (.png, .svg, .pdf; with "
    "--cutaway .png, .jpg). If absent, a page in the browser.",
)
@click.option("--browser", is_flag=True, help="Open the page that -o names in the browser, too.")
@click.option(
    "--compare",
    "others",
    metavar="MODEL|MAP",
    multiple=True,
    type=click.Path(path_type=Path),
    help="On a map's page: also the rooms that a model finds, or that another copy of the map "
    "has; may be repeated.",
)
@click.option(
    "--rooms",
    type=click.IntRange(1),
    help="How many rooms a model of --compare shall find; if absent, the ground truth's, or as "
    "many as homes of that size have.",
)
@click.option(
    "--show",
    multiple=True,
    type=click.Choice(SHOWN),
    help="What to draw of a map; may be repeated. If absent, all that it has but floor, edges "
    "and width.",
)
@click.option(
    "--cutaway",
    is_flag=True,
    help="Render the apartment from above, its walls cut, instead of drawing it.",
)
@click.option(
    "--dpi", type=click.IntRange(30, 1200), default=160, show_default=True, help="Of a drawing."
)
@click.option(
    "--size",
    type=click.IntRange(64, 8192),
    default=1000,
    show_default=True,
    help="Longer side of a cut-away picture, px.",
)
@click.option(
    "--samples",
    type=click.IntRange(1, 4096),
    default=24,
    show_default=True,
    help="Light paths per pixel of a cut-away picture.",
)
def command(
    *,
    source: Path,
    output: Path | None,
    browser: bool,
    others: tuple[Path, ...],
    rooms: int | None,
    show: tuple[str, ...],
    cutaway: bool,
    dpi: int,
    size: int,
    samples: int,
) -> None:
    """Look at a map, an apartment, a trained model, or a folder of them.

    A page needs nothing but a browser: of a map it has layers, rooms side by side, the run
    replayed, features and images of the nodes; of an apartment its plan; of a model what it
    was trained on and where it sees borders; of a folder a small picture of each file.
    An apartment is a file or the name of a reference place; --cutaway shows the one a map
    was recorded in, too.
    """
    kind = kind_of(source)
    is_page = not cutaway and (output is None or output.suffix.lower() == ".html")
    _check(kind, output, is_page, browser=browser, show=show, cutaway=cutaway)
    _check_comparison(kind, is_page, others, rooms)
    if is_page:
        from roomseg.cli.pages import page_of

        page = page_of(source, kind, others, rooms)
        _write_page(page, source, output, browser)
        return
    assert output is not None
    if cutaway:
        from render.cutaway import draw_cutaway

        apartment = _apartment(source)
        draw_cutaway(apartment, output, size=size, samples=samples, folder=source.parent)
    else:
        _write(_draw_plan(source) if kind == "apartment" else _draw_map(source, show), output, dpi)
    click.echo(str(output))


def _check(
    kind: Kind,
    output: Path | None,
    is_page: bool,
    *,
    browser: bool,
    show: tuple[str, ...],
    cutaway: bool,
) -> None:
    """Refuse what does not fit together, before the work rather than after it."""
    from dataset import RoomsegError

    _check_options(("dpi",) if cutaway else ("size", "samples"), cutaway)
    if show and (cutaway or kind != "map"):
        raise click.UsageError(f"--show {show[0]}: says what to draw of a map, of nothing else")
    if show and is_page:
        raise click.UsageError(f"--show {show[0]}: a page has all layers; -o FILE.png is a picture")
    if output is None:
        if cutaway:
            raise click.UsageError("--cutaway: makes a picture, give its name with -o")
        return
    suffixes = PHOTOS if cutaway else DRAWINGS
    if output.suffix.lower() not in suffixes:
        known = " or ".join(suffixes)
        raise RoomsegError(f"{output}: not a picture's name, expected one that ends in {known}")
    if browser and not is_page:
        raise click.UsageError(f"--browser: opens a page, expected -o FILE.html, not {output}")
    if kind in ("model", "folder") and not is_page:
        hint = "; `roomseg inspect` draws a dataset" if kind == "folder" else ""
        raise click.UsageError(f"-o {output}: a {kind} has a page, expected -o FILE.html{hint}")


def _check_comparison(
    kind: Kind, is_page: bool, others: tuple[Path, ...], rooms: int | None
) -> None:
    """Refuse to compare where nothing shows it."""
    if others and (kind != "map" or not is_page):
        raise click.UsageError(f"--compare {others[0]}: only a map's page shows it")
    if rooms is not None and not any(kind_of(other) == "model" for other in others):
        raise click.UsageError(f"--rooms {rooms}: for a model of --compare, which is not there")


def _check_options(without_use: tuple[str, ...], cutaway: bool) -> None:
    """Refuse options that the other kind of picture has."""
    context = click.get_current_context()
    for name in without_use:
        if context.get_parameter_source(name) is not ParameterSource.DEFAULT:
            kind = "a drawing, not of --cutaway" if cutaway else "--cutaway only"
            raise click.UsageError(f"--{name}: an option of {kind}")


def _apartment(source: Path) -> Apartment:
    """The apartment of that name, or the one that a map was recorded in."""
    from dataset import RoomsegError, read_map
    from scenes import apartment_from_json, load_apartment

    if is_apartment(source):
        return load_apartment(str(source))
    scene = read_map(source).scene
    if scene is None:
        raise RoomsegError(f"{source}: the map does not say in which apartment it was recorded")
    return apartment_from_json(scene, origin=str(source))


def _draw_map(source: Path, show: tuple[str, ...]) -> Any:
    """The figure of a map."""
    from dataset import MapFile
    from roomseg.figures import add_map_legend, new_figure

    with MapFile(source) as file:
        panels = map_panels(file, show)
        # Four make a square rather than a row and a rest.
        columns = 2 if len(panels) == 4 else min(3, len(panels))
        rows = -(-len(panels) // columns)
        # One alone has the page for itself.
        scale = 1.5 if len(panels) == 1 else 1.0
        figure = new_figure(5.0 * columns * scale, 4.2 * rows * scale)
        for index, draw in enumerate(panels):
            draw(figure.add_subplot(rows, columns, index + 1))
    add_map_legend(figure)
    return figure


def _draw_plan(source: Path) -> Any:
    """The figure of an apartment."""
    from roomseg.cli.home_plan import home_plan
    from roomseg.figures import home_plan_figure

    return home_plan_figure(home_plan(_apartment(source)))


def _write_page(page: str, source: Path, output: Path | None, browser: bool) -> None:
    """Write the page, and open it if it was asked for or has no name."""
    from dataset.atomic import write_text

    if output is None:
        # The browser reads it after this command has ended; the system tidies it up.
        output = Path(tempfile.mkdtemp(prefix="roomseg-")) / f"{source.resolve().stem}.html"
        browser = True
    write_text(output, page)
    click.echo(str(output))
    if browser:
        webbrowser.open(output.resolve().as_uri())


def _write(figure: Any, output: Path, dpi: int) -> None:
    from dataset.atomic import replacing
    from roomseg.figures import figure_bytes

    picture = figure_bytes(figure, output.suffix.lower(), dpi)
    with replacing(output) as part:
        part.write_bytes(picture)
