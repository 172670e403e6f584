"""``roomseg segment``: find the rooms of a map."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from roomseg.cli.features import check_ready, compute
from roomseg.cli.options import json_option, seed_option
from roomseg.cli.output import counted, progress_bar, write_json

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from dataset import TopoMap
    from roomseg.classifier import BorderModel
    from roomseg.preprocessing import MapGraph

__all__ = ["command", "found_rooms", "room_count"]

UNIFORM = "uniform"
UNIFORM_WEIGHTS = "uniform weights"
"""What a map calls them."""


EXAMPLE = """\b
Example:
  roomseg segment maps/home-7-run1.h5
  roomseg segment maps/home-7-run1.h5 --model model.skops --rooms 5
  roomseg view maps/home-7-run1.h5 --show rooms -o rooms.png
"""


@click.command("segment", epilog=EXAMPLE)
@click.argument("map_file", metavar="MAP", type=click.Path(path_type=Path))
@click.option(
    "--model",
    "model_file",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="A model by `roomseg train`, or `uniform`: all edges weigh alike. If absent, the model "
    "that comes with roomseg for a map with images of about 464 pixels, else uniform weights.",
)
@click.option(
    "--rooms",
    type=click.IntRange(1),
    help="How many rooms; if absent, those of the ground truth, or as many as homes of that "
    "size have.",
)
@seed_option
@json_option
def command(
    *,
    map_file: Path,
    model_file: Path | None,
    rooms: int | None,
    seed: int,
    json_file: Path | None,
) -> None:
    """Find the rooms of a map and write them back into it (§2.4)."""
    from dataset import read_map, write_rooms

    topomap = read_map(map_file)
    name, model = _chosen(map_file, model_file)
    count = room_count(topomap, rooms)
    label, _ = found_rooms(map_file, topomap, model, count, seed)
    write_rooms(map_file, label, model=name, rooms=count)
    figures = _figures(map_file, name, topomap, label)
    write_json(json_file, figures)
    line = f"{map_file}: {counted(count, 'room')} by {name}"
    impurity = figures["impurity"]
    click.echo(line if impurity is None else f"{line}, impurity {100 * impurity:.2f} %")


def room_count(topomap: TopoMap, rooms: int | None) -> int:
    """As many as were asked for, as the ground truth has, or as is usual for so many nodes."""
    from roomseg.room_count import usual_room_count

    if rooms is not None:
        return rooms
    if topomap.ground_truth is not None:
        return topomap.ground_truth.room_count
    count = usual_room_count(len(topomap.nodes))
    click.echo(
        f"{counted(count, 'room')} assumed for so many nodes; --rooms knows better", err=True
    )
    return count


def _chosen(path: Path, model_file: Path | None) -> tuple[str, BorderModel | None]:
    """The name of a model and the model, which is None for uniform weights."""
    from dataset import MapFile
    from roomseg.classifier import load_model
    from roomseg.shipped import SHIPPED_MODEL, fits_shipped_model, shipped_model

    if model_file is None:
        with MapFile(path) as file:
            if fits_shipped_model(file):
                return SHIPPED_MODEL.name, shipped_model()
            if file.image_count:
                click.echo(
                    f"{path}: not all images are there, or not of about 464 pixels, as the model "
                    "that comes with roomseg needs them",
                    err=True,
                )
    if model_file is None or str(model_file) == UNIFORM:
        return UNIFORM_WEIGHTS, None
    return model_file.name, load_model(model_file)


def found_rooms(
    path: Path, topomap: TopoMap, model: BorderModel | None, count: int, seed: int
) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Find rooms with a model, or with equal weights for all edges (§2.4).

    Returns
    -------
    label : array, shape (n,)
    crossing : array, shape (k, 2)
        Nodes of the edges that the model takes for border edges.
    """
    import numpy as np

    from roomseg.preprocessing import preprocess
    from roomseg.segmentation import segment

    rng = np.random.default_rng(seed)
    if model is None:
        graph = preprocess(topomap)
        return segment(graph, None, count, rng, 1.0), graph.edges[:0]
    graph, is_border = _borders(path, model)
    return segment(graph, is_border, count, rng, model.parameters.rho), graph.edges[is_border]


def _borders(path: Path, model: BorderModel) -> tuple[MapGraph, NDArray[np.bool_]]:
    """Find the map graph, and which of its edges the model takes for borders."""
    from dataset import MapFile

    check_ready(path, model.names)
    with progress_bar("images") as bar, MapFile(path) as file:
        features = compute(file, model.names, bar)
    return features.graph, model.predict(features)


def _figures(path: Path, name: str, topomap: TopoMap, label: NDArray[np.int32]) -> dict[str, Any]:
    from roomseg.metrics import impurity

    truth = topomap.ground_truth
    room = None if truth is None else truth.room
    return {
        "map": str(path),
        "model": name,
        "rooms": int(label.max()) + 1,
        "impurity": None if room is None else impurity(label, room),
    }
