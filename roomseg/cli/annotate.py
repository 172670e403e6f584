"""``roomseg annotate``: draw room borders on maps, in the browser."""

from __future__ import annotations

import webbrowser
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click

from roomseg.cli.features import check_ready, compute
from roomseg.cli.options import maps_argument
from roomseg.cli.output import counted, progress_bar

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from roomseg.classifier import BorderModel

NONE = "none"

EXAMPLE = """\b
Example:
  roomseg annotate maps/home-7-run1.h5
  roomseg annotate maps/*.h5 --model model.skops
"""


@click.command("annotate", epilog=EXAMPLE)
@maps_argument
@click.option(
    "--model",
    "model_file",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="A model by `roomseg train`, which proposes borders, or `none`. If absent, the one that "
    "comes with roomseg, for maps with images of about 464 pixels and no borders yet.",
)
@click.option(
    "--rooms",
    type=click.IntRange(1),
    help="How many rooms the model shall find; as homes of that size have if absent.",
)
@click.option("--afresh", is_flag=True, help="Begin without the borders that the maps have.")
@click.option(
    "--port", type=click.IntRange(0, 65535), default=0, help="Of the page; any free one if absent."
)
@click.option("--open/--no-open", "opened", default=True, help="Open the page in the browser.")
def command(
    *,
    maps: tuple[Path, ...],
    model_file: Path | None,
    rooms: int | None,
    afresh: bool,
    port: int,
    opened: bool,
) -> None:
    """Draw room borders on maps in the browser, and save them with the rooms that they give.

    Everything drawn is kept beside the map (MAP.annotation) at once, and is found again
    when the command is called again; the page's Save writes it into the map (§3.1.1).
    The page is for this machine only. Ctrl-C ends it.
    """
    from roomseg.annotation.server import AnnotationServer
    from roomseg.annotation.session import Annotation
    from roomseg.classifier import load_model

    unasked = model_file is None
    model = None if model_file is None or str(model_file) == NONE else load_model(model_file)
    with ExitStack() as stack:
        annotations = []
        for path in maps:
            chosen = _shipped(path, afresh) if unasked else model
            lines = None if chosen is None else _suggestions(path, chosen, rooms)
            annotations.append(stack.enter_context(Annotation(path, lines, afresh=afresh)))
        server = AnnotationServer(annotations, port)
        click.echo(f"{server.url} shows {counted(len(maps), 'map')}; Ctrl-C ends it")
        if opened:
            webbrowser.open(server.url)
        with suppress(KeyboardInterrupt):
            server.run()
        for annotation in annotations:
            if annotation.unsaved:
                click.echo(f"{annotation.path}: not all is saved; call it again to go on")


def _shipped(path: Path, afresh: bool) -> BorderModel | None:
    """The model that comes with roomseg, where it has something to propose."""
    from dataset import MapFile
    from roomseg.shipped import fits_shipped_model, shipped_model

    with MapFile(path) as file:
        drawn = file.topomap.ground_truth is not None and not afresh
        return shipped_model() if fits_shipped_model(file) and not drawn else None


def _suggestions(path: Path, model: BorderModel, rooms: int | None) -> NDArray[np.float64]:
    """Borders that a model proposes for a map."""
    from dataset import MapFile
    from roomseg.annotation.cut import CuttableMap
    from roomseg.annotation.suggestion import suggested_lines

    check_ready(path, model.names)
    with progress_bar("images") as bar, MapFile(path) as file:
        features = compute(file, model.names, bar)
        topomap = file.topomap
    canvas = CuttableMap(topomap)
    marked = model.predict(features)
    return suggested_lines(canvas, marked, model.parameters.rho, rooms, topomap.seed)
