"""``roomseg export MAP``: read the map, have it made into another format, write that.

Every writer takes the map's path and the output's; it returns what it wrote if that is
several files. `roomseg.cli.export` finds writers and their options by name.
"""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dataset import MapFile, RoomsegError
from dataset.atomic import unwritten, write_text

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = [
    "write_geojson",
    "write_graphml",
    "write_node_link",
    "write_ros_map",
    "write_valetudo",
    "write_views",
]


def write_graphml(source: Path, output: Path) -> None:
    """Write the map graph as GraphML."""
    from roomseg.exporters.graph import graph_of, graphml

    with MapFile(source) as file:
        write_text(output, graphml(graph_of(file.topomap, _found(file))))


def write_node_link(source: Path, output: Path) -> None:
    """Write the map graph as node-link JSON."""
    from roomseg.exporters.graph import graph_of, node_link_json

    with MapFile(source) as file:
        write_text(output, node_link_json(graph_of(file.topomap, _found(file))))


def write_ros_map(
    source: Path, output: Path, *, resolution: float = 0.05, rooms: str | None = None
) -> tuple[Path, ...]:
    """Write the floor as a ROS map, its rooms as a picture with a table."""
    from roomseg.exporters.floor import floor_grid, room_name
    from scenes.exporters.ros_map import MOST_ROOMS, GridMap, save_grid_map

    with MapFile(source) as file, _about(source):
        label, called = rooms_of(file, rooms)
        grid = floor_grid(file.topomap, label, resolution)
    count = int(grid.rooms.max())
    if count > MOST_ROOMS:
        raise RoomsegError(f"{source}: {count} rooms, expected at most {MOST_ROOMS} for a picture")
    names = [(room_name(called, k), "other") for k in range(count)]
    picture = grid.rooms.astype("u1")
    return save_grid_map(GridMap(grid.cells, picture, resolution, grid.origin), names, output)


def write_geojson(
    source: Path, output: Path, *, resolution: float = 0.025, rooms: str | None = None
) -> None:
    """Write rooms and borders as GeoJSON, one feature a line."""
    from roomseg.exporters.geojson import map_geojson

    with MapFile(source) as file, _about(source):
        label, called = rooms_of(file, rooms)
        if label is None:
            raise RoomsegError(f"{source}: has no rooms; `roomseg segment` finds them")
        data = map_geojson(file.topomap, label, resolution, called)
    lines = ",\n".join(json.dumps(feature) for feature in data.pop("features"))
    head = json.dumps(data, ensure_ascii=False)[:-1]
    write_text(output, f'{head}, "features": [\n{lines}\n]}}\n')


def write_valetudo(
    source: Path, output: Path, *, resolution: float = 0.05, rooms: str | None = None
) -> None:
    """Write floor, walls, segments and path as a Valetudo map."""
    from roomseg.exporters.valetudo import valetudo_map

    with MapFile(source) as file, _about(source):
        label, called = rooms_of(file, rooms)
        data = valetudo_map(file.topomap, label, resolution, called)
    write_text(output, json.dumps(data) + "\n")


def write_views(source: Path, output: Path) -> tuple[Path, ...]:
    """Write a table of the nodes, and their images and panoramas to a folder beside it."""
    from roomseg.exporters.views import node_table, views

    folder = output.with_suffix("")
    pictures = {}
    with MapFile(source) as file:
        if not file.image_count:
            raise RoomsegError(f"{source}: has no images; `roomseg render {source}` makes them")
        with _replacing_folder(folder) as part:
            for view in views(file):
                image, panorama = view.names
                (part / image).write_bytes(view.image)
                (part / panorama).write_bytes(view.panorama)
                pictures[view.node] = (f"{folder.name}/{image}", f"{folder.name}/{panorama}")
        write_text(output, node_table(file, pictures))
    return output, folder


def rooms_of(file: MapFile, which: str | None) -> tuple[NDArray[np.int32] | None, tuple[str, ...]]:
    """Room of each node, and the rooms' names: of the ground truth, or found, which have none.

    The first that is there, if it is not said which.

    Raises
    ------
    RoomsegError
        If what is asked for is not in the file.
    """
    truth = file.topomap.ground_truth
    labels = {"truth": None if truth is None else truth.room, "found": _found(file)}
    if which is None:
        which = "found" if labels["truth"] is None else "truth"
    elif labels[which] is None:
        means = {"truth": "ground truth", "found": "segmentation; `roomseg segment` makes one"}
        raise RoomsegError(f"{file.path}: has no {means[which]}")
    named = () if truth is None or which == "found" else truth.room_names
    return labels[which], named or ()


def _found(file: MapFile) -> NDArray[np.int32] | None:
    rooms = file.rooms
    if rooms is None:
        return None
    n = len(file.topomap.nodes)
    if rooms.label.shape != (n,) or (n and rooms.label.min() < 0):
        raise RoomsegError(f"{file.path}: /rooms/label: expected {n} labels from 0 on")
    return rooms.label


@contextmanager
def _about(source: Path) -> Iterator[None]:
    """Name the file in errors of what is made of it."""
    try:
        yield
    except RoomsegError as error:
        named = str(error).startswith(f"{source}: ")
        raise type(error)(str(error) if named else f"{source}: {error}") from error


@contextmanager
def _replacing_folder(folder: Path) -> Iterator[Path]:
    """Fill a new folder of pictures, then put it in place of an earlier one."""
    _check_pictures(folder)
    part = folder.with_name(f".{folder.name}.{os.getpid()}.part")
    try:
        part.mkdir()
        yield part
        if folder.exists():
            shutil.rmtree(folder)
        part.rename(folder)
    except OSError as error:
        raise unwritten(folder, error) from error
    finally:
        shutil.rmtree(part, ignore_errors=True)


def _check_pictures(folder: Path) -> None:
    """Refuse to replace a folder that holds anything but pictures of nodes."""
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise RoomsegError(f"{folder}: is no folder, expected another name for the pictures")
    others = [
        item for item in _items(folder) if not re.fullmatch(r"node-\d+(-panorama)?\.png", item)
    ]
    if others:
        raise RoomsegError(
            f"{folder}: holds {others[0]}, which would be lost; expected another name for the table"
        )


def _items(folder: Path) -> list[Any]:
    return sorted(item.name for item in folder.iterdir()) if folder.exists() else []
