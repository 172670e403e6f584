"""The page of a folder: its apartments, maps and models, each with a small picture."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from dataset import MapFile, RoomsegError, summarise
from roomseg.browser.folder_page import FolderItem, folder_page
from roomseg.classifier import load_model
from roomseg.cli.home_plan import home_plan
from roomseg.cli.inspect import dataset_lines
from roomseg.cli.manifest import MANIFEST, read_manifest
from roomseg.cli.output import counted, follow, progress_bar
from roomseg.cli.panels import outlines_of
from roomseg.cli.sources import kind_of
from roomseg.figures import Chart, draw_rooms, figure_bytes, new_figure
from roomseg.figures.plan import draw_home_plan
from scenes import Apartment, SceneError, load_apartment
from scenes.summary import summarise_apartment

__all__ = ["page_of_folder"]

SUFFIXES = (".json", ".h5", ".skops")
APARTMENT = (b'"roomseg-apartment"', b'"polygon"')
"""One of these stands at the beginning of an apartment's file; other JSON files are left alone."""
HEAD = 4096
MOST_PICTURES = 200
"""Of more files only so many, evenly chosen, have a picture."""
SIZE, DPI = (2.6, 2.2), 80
"""Of a picture, inches and pixels per inch."""
MOST_UNREAD = 20
"""Told one by one; more are only counted."""

Values = Mapping[str, float]
"""What the diagrams show of a file, by what it is."""


def page_of_folder(folder: Path) -> str:
    """Make the page of everything in a folder, and in the folders in it.

    Raises
    ------
    RoomsegError
        If there is no apartment, map or model in it that can be read.
    """
    paths = list(_files(folder))
    chosen = np.linspace(0, len(paths) - 1, min(len(paths), MOST_PICTURES)).astype(int)
    pictured = {paths[index] for index in chosen}
    items, values, unread = [], [], []
    with progress_bar("files") as bar:
        show = follow(bar, str(folder))
        for done, path in enumerate(paths, 1):
            name = path.relative_to(folder).as_posix()
            try:
                item, own = _READERS[kind_of(path)](path, name, path in pictured)
            except (RoomsegError, SceneError) as error:
                unread.append(str(error))
            else:
                items.append(item)
                values.append(own)
            show(done, len(paths))
    if not items:
        hint = f"; {unread[0]}" if unread else ""
        raise RoomsegError(
            f"{folder}: no apartment (.json), map (.h5) or model (.skops) to show{hint}"
        )
    title = folder.resolve().name
    return folder_page(title, items, _charts(values), _facts(folder, items), _told(unread))


def _files(folder: Path) -> Iterator[Path]:
    """Apartments, maps and models by their names, without what is hidden."""
    for at, folders, names in os.walk(folder):
        folders[:] = sorted((name for name in folders if not name.startswith(".")), key=_by_number)
        for name in sorted(names, key=_by_number):
            path = Path(at) / name
            if name.startswith(".") or path.suffix not in SUFFIXES or not path.is_file():
                continue
            if path.suffix != ".json" or _is_apartment(path):
                yield path


def _by_number(name: str) -> list[str | int]:
    """Sorts home-2 before home-10."""
    parts = re.split(r"([0-9]+)", name)
    return [int(part) if index % 2 else part for index, part in enumerate(parts)]


def _is_apartment(path: Path) -> bool:
    with path.open("rb") as file:
        head = file.read(HEAD)
    return any(word in head for word in APARTMENT)


def _charts(values: list[Values]) -> list[Chart]:
    labels = dict.fromkeys(label for own in values for label in own)
    return [Chart(label, {"": [own[label] for own in values if label in own]}) for label in labels]


def _facts(folder: Path, items: list[FolderItem]) -> list[tuple[str, str]]:
    """What there is; of a dataset what `roomseg inspect` tells."""
    kinds = Counter(item.kind for item in items)
    facts = [("files", ", ".join(counted(number, kind) for kind, number in kinds.items()))]
    if not (folder / MANIFEST).is_file():
        return facts
    return [*facts, *dataset_lines(folder, read_manifest(folder))]


def _told(unread: list[str]) -> list[str]:
    more = len(unread) - MOST_UNREAD
    return unread[:MOST_UNREAD] + ([f"and {more} more"] if more > 0 else [])


def _apartment_item(path: Path, name: str, pictured: bool) -> tuple[FolderItem, Values]:
    apartment = load_apartment(path, checked=False)
    summary = summarise_apartment(apartment)
    pieces = sum(summary.pieces.values())
    facts = (
        f"{counted(len(summary.rooms), 'room')} on {summary.floor_area:.0f} m²",
        f"{counted(pieces, 'piece')}, light: {summary.lighting}",
    )
    values = {
        "rooms of an apartment": len(summary.rooms),
        "floor of an apartment, m²": summary.floor_area,
    }
    picture = _plan_picture(apartment) if pictured else b""
    return FolderItem(name, "apartment", len(summary.rooms), facts, picture), values


def _map_item(path: Path, name: str, pictured: bool) -> tuple[FolderItem, Values]:
    s = summarise(path)
    driven = f"{s.edge_count} edges" if s.path_length is None else f"{s.path_length:.0f} m driven"
    images = f"{s.images_done} of {s.node_count} images" if s.images_done else "no images"
    facts = [f"{s.environment}, {s.run}", f"{s.node_count} nodes, {driven}", images]
    if s.room_count is not None:
        facts.append(f"{counted(s.room_count, 'true room')}")
    if s.segmented_by is not None:
        facts.append(f"rooms found by {s.segmented_by}")
    values = {"nodes of a map": float(s.node_count)}
    if s.room_count is not None:
        values["true rooms of a map"] = float(s.room_count)
    picture = _map_picture(path) if pictured else b""
    return FolderItem(name, "map", s.room_count, tuple(facts), picture), values


def _model_item(path: Path, name: str, pictured: bool) -> tuple[FolderItem, Values]:
    model = load_model(path)
    maps, edges = len(model.trained_on), sum(item.edges for item in model.trained_on)
    facts = [f"features: {', '.join(model.names)}"]
    if maps:
        facts.append(f"trained on {edges} edges of {counted(maps, 'map')}")
    return FolderItem(name, "model", None, tuple(facts)), {}


_READERS = {"apartment": _apartment_item, "map": _map_item, "model": _model_item}


def _plan_picture(apartment: Apartment) -> bytes:
    figure = new_figure(*SIZE)
    ax = figure.add_subplot()
    draw_home_plan(ax, home_plan(apartment))
    ax.autoscale_view()
    ax.set_aspect("equal")
    ax.set_axis_off()
    return figure_bytes(figure, ".png", DPI)


def _map_picture(path: Path) -> bytes:
    """Its rooms, the true ones if it has them."""
    with MapFile(path) as file:
        topomap, rooms = file.topomap, file.rooms
    truth = topomap.ground_truth
    label = np.zeros(len(topomap.nodes), int) if rooms is None else rooms.label
    if truth is not None and truth.room is not None:
        label = truth.room
    figure = new_figure(*SIZE)
    draw_rooms(
        figure.add_subplot(),
        topomap.nodes,
        label,
        points=topomap.obstacles.position,
        outlines=outlines_of(topomap.scene),
    )
    return figure_bytes(figure, ".png", DPI)
