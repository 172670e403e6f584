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

EXAMPLE = """\b
Example:
  roomseg segment maps/home-7-run1.h5 --model model.skops
  roomseg view maps/home-7-run1.h5 --show rooms -o rooms.png
"""


@click.command("segment", epilog=EXAMPLE)
@click.argument("map_file", metavar="MAP", type=click.Path(path_type=Path))
@click.option(
    "--model",
    "model_file",
    type=click.Path(path_type=Path),
    help="A model by `roomseg train`; equal weights for all edges if absent.",
)
@click.option(
    "--rooms", type=click.IntRange(1), help="How many rooms; the ground truth's if absent."
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
    count = room_count(map_file, topomap, rooms)
    name = "uniform weights" if model_file is None else model_file.name
    label, _ = found_rooms(map_file, topomap, model_file, count, seed)
    write_rooms(map_file, label, model=name, rooms=count)
    figures = _figures(map_file, name, topomap, label)
    write_json(json_file, figures)
    line = f"{map_file}: {counted(count, 'room')} by {name}"
    impurity = figures["impurity"]
    click.echo(line if impurity is None else f"{line}, impurity {100 * impurity:.2f} %")


def room_count(path: Path, topomap: TopoMap, rooms: int | None) -> int:
    """As many as were asked for, or as the ground truth has (RoomsegError if it has none)."""
    from dataset import RoomsegError

    if rooms is not None:
        return rooms
    if topomap.ground_truth is None:
        raise RoomsegError(f"{path}: has no ground truth to take the room count from; give --rooms")
    return topomap.ground_truth.room_count


def found_rooms(
    path: Path, topomap: TopoMap, model_file: Path | None, count: int, seed: int
) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Find rooms with a model, or with equal weights for all edges (§2.4).

    Returns
    -------
    label : array, shape (n,)
    crossing : array, shape (k, 2)
        Nodes of the edges that the model takes for border edges.
    """
    import numpy as np

    from roomseg.classifier import load_model
    from roomseg.preprocessing import preprocess
    from roomseg.segmentation import segment

    rng = np.random.default_rng(seed)
    if model_file is None:
        graph = preprocess(topomap)
        return segment(graph, None, count, rng, 1.0), graph.edges[:0]
    model = load_model(model_file)
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
