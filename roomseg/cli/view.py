"""``roomseg view``: draw a map or an apartment."""

from __future__ import annotations

import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from roomseg.cli.options import output_option
from roomseg.cli.panels import SHOWN, map_panels, outlines_of
from roomseg.cli.sources import is_apartment

if TYPE_CHECKING:
    from scenes import Apartment

DRAWINGS = (".png", ".svg", ".pdf", ".html")
PHOTOS = (".png", ".jpg", ".jpeg")

EXAMPLE = """\b
Example:
  roomseg view home7.json -o home7.pdf
  roomseg view sim4 --cutaway -o sim4.jpg
  roomseg view maps/sim4-run1.h5 --show graph --show rooms -o rooms.png
  roomseg view maps/sim4-run1.h5 --browser -o sim4.html
"""


@click.command("view", epilog=EXAMPLE)
@click.argument("source", metavar="MAP|APARTMENT", type=click.Path(path_type=Path))
@output_option(
    "A picture (.png, .svg, .pdf; with --cutaway .png, .jpg), or of a map a page (.html)."
)
@click.option("--browser", is_flag=True, help="Open the page in the browser, too.")
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
    output: Path,
    show: tuple[str, ...],
    browser: bool,
    cutaway: bool,
    dpi: int,
    size: int,
    samples: int,
) -> None:
    """Draw a map, or the plan of an apartment, or its cut-away picture.

    A map is drawn by its run, obstacle points, graph, rooms and some images. An apartment is a
    file or the name of a reference place; --cutaway shows the one a map was
    recorded in, too. A map's page needs nothing but a browser: layers, rooms side by side, the
    run replayed, features and images of the nodes.
    """
    _check_name(output, PHOTOS if cutaway else DRAWINGS)
    is_page = output.suffix.lower() == ".html"
    if is_page and (show or is_apartment(source)):
        raise click.UsageError(f"-o {output}: a page is of a map, and has all layers")
    if browser and not is_page:
        raise click.UsageError(f"--browser: opens a page, expected -o FILE.html, not {output}")
    _check_options(("dpi",) if cutaway else ("size", "samples"), cutaway)
    if show and (cutaway or is_apartment(source)):
        raise click.UsageError(f"--show {show[0]}: says what to draw of a map, not of an apartment")
    if cutaway:
        from render.cutaway import draw_cutaway

        apartment = _apartment(source)
        draw_cutaway(apartment, output, size=size, samples=samples, folder=source.parent)
    elif output.suffix.lower() == ".html":
        _write_page(source, output)
    else:
        draw = _draw_plan if is_apartment(source) else _draw_map
        _write(draw(source, show), output, dpi)
    click.echo(str(output))
    if browser:
        webbrowser.open(output.resolve().as_uri())


def _check_name(output: Path, suffixes: tuple[str, ...]) -> None:
    """Refuse a name before the work rather than after it."""
    from dataset import RoomsegError

    if output.suffix.lower() not in suffixes:
        known = " or ".join(suffixes)
        raise RoomsegError(f"{output}: not a picture's name, expected one that ends in {known}")


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


def _write_page(source: Path, output: Path) -> None:
    """The page of a map, with those features that can be computed without images."""
    from dataset import MapFile
    from dataset.atomic import write_text
    from roomseg.browser.viewer import map_page
    from roomseg.features import SUBSETS, edge_features

    with MapFile(source) as file:
        complete = len(file.done) > 0 and bool(file.done.all())
        found = edge_features(file, SUBSETS["all" if complete else "no-camera"])
        features = {name: found.column(name) for name in found.names}
        write_text(output, map_page(file, outlines_of(file.topomap.scene), features))


def _draw_plan(source: Path, show: tuple[str, ...]) -> Any:
    """The figure of an apartment."""
    from roomseg.cli.home_plan import home_plan
    from roomseg.figures import home_plan_figure

    return home_plan_figure(home_plan(_apartment(source)))


def _write(figure: Any, output: Path, dpi: int) -> None:
    from dataset.atomic import replacing
    from roomseg.figures import figure_bytes

    picture = figure_bytes(figure, output.suffix.lower(), dpi)
    with replacing(output) as part:
        part.write_bytes(picture)
