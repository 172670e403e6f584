"""The picture of a dataset: how its figures spread, plans of places, and images."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from roomseg.figures import Chart, SheetPlace

__all__ = ["OVERVIEW", "write_overview"]

OVERVIEW = "overview.png"
"""Its name in the dataset."""
MOST_PLACES = 30
"""Of more, evenly chosen ones are drawn."""
IMAGES = 3
"""Of a place."""
LARGEST = 150
"""Side of an image on the sheet, px."""
CHARTS = (
    ("places", "rooms", "rooms of a place", 1.0),
    ("places", "floor_area", "floor of a place, m²", 1.0),
    ("maps", "nodes", "nodes of a map", 1.0),
    ("maps", "coverage", "coverage of a map, %", 100.0),
)
"""List, figure, label, factor."""


def write_overview(folder: Path, figures: Mapping[str, Any], output: Path) -> None:
    """Draw a dataset.

    Parameters
    ----------
    folder : Path
        Of the dataset.
    figures : Mapping
        Its manifest.
    output : Path
        The picture.

    Raises
    ------
    SceneError, RoomsegError
        If an apartment or a map cannot be read, or the picture cannot be written.
    """
    from dataset.atomic import replacing
    from roomseg.cli.output import counted
    from roomseg.figures import dataset_sheet, figure_bytes

    order = [*figures["splits"]]
    places = sorted(figures["places"], key=lambda place: order.index(place["split"]))
    places = places[:: -(-len(places) // MOST_PLACES) or 1]
    total = figures["total"]
    title = (
        f"{figures['name']}: {counted(total['places'], 'place')}, "
        f"{counted(total['maps'], 'map')}, {counted(total['images_done'], 'image')}"
    )
    drawn = [_place(folder, figures, place) for place in places]
    picture = figure_bytes(dataset_sheet(title, drawn, _charts(figures)), output.suffix.lower())
    with replacing(output) as part:
        part.write_bytes(picture)


def _charts(figures: Mapping[str, Any]) -> list[Chart]:
    from roomseg.figures import Chart

    return [
        Chart(
            label,
            {
                split: [factor * item[name] for item in figures[kind] if item["split"] == split]
                for split in figures["splits"]
            },
        )
        for kind, name, label, factor in CHARTS
    ]


def _place(folder: Path, figures: Mapping[str, Any], place: Mapping[str, Any]) -> SheetPlace:
    from roomseg.cli.home_plan import home_plan
    from roomseg.cli.output import counted
    from roomseg.figures import SheetPlace
    from scenes import load_apartment

    plan = home_plan(load_apartment(folder / place["file"], checked=False))
    maps = [item for item in figures["maps"] if item["place"] == place["name"]]
    size = f"{counted(place['rooms'], 'room')}, {place['floor_area']:.0f} m²"
    title = f"{place['name']} ({place['split']})\n{size}, {counted(len(maps), 'map')}"
    images = _images(folder / maps[0]["file"]) if maps else ()
    return SheetPlace(title, place["split"], plan, images)


def _images(path: Path) -> tuple[NDArray[np.uint8], ...]:
    """Some images of a map, spread over its run, so small that the sheet stays so."""
    from dataset import MapFile

    with MapFile(path) as file:
        done = np.flatnonzero(file.done)
        if not len(done):
            return ()
        # Neither the first nor the last: these look at the walls around the base.
        chosen = done[np.linspace(0, len(done) - 1, IMAGES + 2).astype(int)[1:-1]]
        return tuple(_small(file.image(int(node))) for node in np.unique(chosen))


def _small(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """An image that is no larger than needed."""
    scale = LARGEST / max(image.shape)
    if scale >= 1.0:
        return image
    return np.asarray(cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA))
