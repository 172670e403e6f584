"""The pages of ``roomseg view``: what they show, brought together from files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from dataset import MapFile, RoomsegError, TopoMap, summarise
from roomseg.browser.comparison import TRUE_ROOMS, Segmentation
from roomseg.cli.inspect import apartment_lines, map_lines
from roomseg.cli.panels import outlines_of
from roomseg.cli.segment import found_rooms, room_count
from roomseg.cli.sources import Kind, kind_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["page_of"]


def page_of(source: Path, kind: Kind, others: Sequence[Path] = (), rooms: int | None = None) -> str:
    """Make the page of a file or a folder.

    Parameters
    ----------
    source : Path
    kind : {'map', 'apartment', 'model', 'folder'}
    others : sequence of Path
        Models, and copies of a map, to compare it with.
    rooms : int, optional
        How many a model shall find.

    Raises
    ------
    RoomsegError, SceneError
        If something cannot be read, or there is nothing to compare.
    """
    if kind == "map":
        return _map_page(source, others, rooms)
    if kind == "model":
        return _model_page(source)
    if kind == "apartment":
        return _apartment_page(source)
    from roomseg.cli.folder_page import page_of_folder

    return page_of_folder(source)


def _map_page(source: Path, others: Sequence[Path], rooms: int | None) -> str:
    """With those features that can be computed without images, or all if it has all images."""
    from roomseg.browser.map_page import map_page
    from roomseg.features import SUBSETS, edge_features

    # Whoever gets the page need not learn where the file was.
    summary = replace(summarise(source), file=source.name)
    facts = [line for line in map_lines(summary) if line[0] != "environment"]
    with MapFile(source) as file:
        compared = [item for other in others for item in _compared(source, file, other, rooms)]
        complete = len(file.done) > 0 and bool(file.done.all())
        found = edge_features(file, SUBSETS["all" if complete else "no-camera"])
        features = {name: found.column(name) for name in found.names}
        outlines = outlines_of(file.topomap.scene)
        return map_page(file, outlines, features=features, others=compared, facts=facts)


def _compared(
    source: Path, file: MapFile, other: Path, rooms: int | None
) -> Iterator[Segmentation]:
    """What a model finds, or what another copy of the map has."""
    from roomseg.classifier import load_model

    if kind_of(other) == "model":
        model, count = load_model(other), room_count(file.topomap, rooms)
        label, crossing = found_rooms(source, file.topomap, model, count, seed=0)
        yield Segmentation(f"rooms by {other.name}", label, crossing)
        return
    if kind_of(other) != "map":
        raise RoomsegError(f"--compare {other}: expected a model (.skops) or a map")
    yield from _other_rooms(source, file, other)


def _other_rooms(source: Path, file: MapFile, other: Path) -> Iterator[Segmentation]:
    """Rooms of another copy of the map that this one does not have."""
    with MapFile(other) as copy:
        _check_copy(source, file.topomap, other, copy.topomap)
        own, its = _labels(file), _labels(copy)
        truth = copy.topomap.ground_truth
    new = [name for name in its if name not in own or not np.array_equal(its[name], own[name])]
    if not new:
        raise RoomsegError(f"{other}: has no rooms but those of {source}, expected some to compare")
    for name in new:
        title = f"{name} of {other.name}"
        if name == TRUE_ROOMS and truth is not None:
            crossing = copy.topomap.edges[truth.edge_is_border]
            yield Segmentation(title, its[name], crossing, truth.room_names)
        else:
            yield Segmentation(title, its[name])


def _labels(file: MapFile) -> dict[str, NDArray[np.int32]]:
    truth, found = file.topomap.ground_truth, file.rooms
    labels = {}
    if truth is not None and truth.room is not None:
        labels[TRUE_ROOMS] = truth.room
    if found is not None:
        labels[f"rooms by {found.model}"] = found.label
    return labels


def _check_copy(source: Path, own: TopoMap, other: Path, copy: TopoMap) -> None:
    """Refuse a map of another run."""
    n, m = len(own.nodes), len(copy.nodes)
    if n != m:
        raise RoomsegError(f"{other}: has {m} nodes, expected the {n} of {source}, a copy of it")
    if not np.allclose(own.nodes.position, copy.nodes.position):
        raise RoomsegError(f"{other}: its nodes lie elsewhere, expected a copy of {source}")


def _apartment_page(source: Path) -> str:
    from roomseg.browser.apartment_page import apartment_page
    from roomseg.cli.home_plan import home_plan
    from scenes import load_apartment
    from scenes.summary import summarise_apartment

    apartment = load_apartment(str(source))
    summary = summarise_apartment(apartment)
    told = [
        [
            ("kind", room.kind.replace("_", " ")),
            ("height", f"{room.ceiling_height:.2f} m"),
            ("floor", room.floor.replace("_", " ")),
            ("walls", room.walls.replace("_", " ")),
            ("ceiling", room.ceiling.replace("_", " ")),
            ("leads to", ", ".join(room.passages_to) or "no room"),
        ]
        for room in summary.rooms
    ]
    hidden = ("apartment", "about")
    facts = [line for line in apartment_lines(summary) if line[0] not in hidden]
    return apartment_page(home_plan(apartment), told, facts, summary.description)


def _model_page(source: Path) -> str:
    from roomseg.browser.model_page import model_page
    from roomseg.classifier import load_model

    return model_page(load_model(source), source.name)
