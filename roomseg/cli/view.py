"""``roomseg view``: draw a map."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from roomseg.cli.options import output_option

if TYPE_CHECKING:
    from dataset import MapFile

SHOWN = ("run", "obstacles", "graph", "truth", "rooms", "images")
IMAGE_COUNT = 4

Panel = Callable[[Any], None]

EXAMPLE = """\b
Example:
  roomseg view maps/sim4-run1.h5 -o sim4.png
  roomseg view maps/sim4-run1.h5 --show graph --show rooms -o rooms.png
"""


@click.command("view", epilog=EXAMPLE)
@click.argument("map_file", metavar="MAP", type=click.Path(path_type=Path))
@output_option("The picture, PNG.")
@click.option(
    "--show",
    multiple=True,
    type=click.Choice(SHOWN),
    help="What to draw; may be repeated. All that the map has if absent.",
)
@click.option("--dpi", type=click.IntRange(30, 1200), default=160, show_default=True)
def command(*, map_file: Path, output: Path, show: tuple[str, ...], dpi: int) -> None:
    """Draw the run, the graph, the rooms and some images of a map."""
    from dataset import MapFile, RoomsegError
    from dataset.atomic import replacing
    from roomseg.figures import new_figure, png_bytes

    if output.suffix.lower() != ".png":
        raise RoomsegError(f"{output}: not a picture's name, expected one that ends in .png")
    with MapFile(map_file) as file:
        panels = _panels(file, show)
        columns = min(3, len(panels))
        rows = -(-len(panels) // columns)
        figure = new_figure(5.0 * columns, 4.2 * rows)
        for index, draw in enumerate(panels):
            draw(figure.add_subplot(rows, columns, index + 1))
        picture = png_bytes(figure, dpi)
    with replacing(output) as part:
        part.write_bytes(picture)
    click.echo(str(output))


def _panels(file: MapFile, show: tuple[str, ...]) -> list[Panel]:
    """Everything that was asked for; it is an error if the map does not have it."""
    from dataset import RoomsegError

    available = _available(file)
    for name in show:
        if name not in available:
            raise RoomsegError(f"{file.path}: has no {name} to draw, only {', '.join(available)}")
    return [panel for name in (show or available) for panel in available[name]]


def _available(file: MapFile) -> dict[str, list[Panel]]:
    from roomseg import figures

    topomap = file.topomap
    outlines = _outlines(topomap.scene)
    truth = topomap.ground_truth
    true_room = None if truth is None else truth.room
    rooms = file.rooms
    panels: dict[str, list[Panel]] = {
        "run": [
            partial(
                figures.draw_cleaning_run,
                topomap=topomap,
                outlines=outlines,
                title=f"{topomap.environment}, {topomap.run}",
            )
        ],
        "obstacles": [partial(figures.draw_obstacle_map, topomap=topomap, title="Robot's map")],
        "graph": [
            partial(
                figures.draw_graph,
                topomap=topomap,
                is_border=None if truth is None else truth.edge_is_border,
                outlines=outlines,
                title="Map graph",
            )
        ],
    }
    draw_rooms = partial(figures.draw_rooms, topomap=topomap, outlines=outlines)
    if true_room is not None:
        panels["truth"] = [partial(draw_rooms, room=true_room, title="Ground truth")]
    if rooms is not None:
        title = f"Rooms by {rooms.model}"
        panels["rooms"] = [partial(draw_rooms, room=rooms.label, truth=true_room, title=title)]
    if file.image_count:
        panels["images"] = _image_panels(file)
    return panels


def _outlines(scene: str | None) -> Any:
    """Read what stands near the floor from the map's scene, if it has one."""
    if scene is None:
        return None
    from scenes import Apartment, obstacles

    return obstacles(Apartment.model_validate_json(scene))


def _image_panels(file: MapFile) -> list[Panel]:
    """Choose a few images, spread over the run."""
    import numpy as np

    from roomseg.figures import draw_camera_image

    done = np.flatnonzero(file.done)
    chosen = done[np.linspace(0, len(done) - 1, min(IMAGE_COUNT, len(done))).astype(int)]
    return [
        partial(draw_camera_image, image=file.image(node), title=f"Node {node}") for node in chosen
    ]
