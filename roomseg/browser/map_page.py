"""A map as one self-contained page: layers, rooms side by side, a run to be replayed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dataset import MapFile
from roomseg.browser.comparison import Segmentation, segmentations_of
from roomseg.browser.map_layers import MapLayers
from roomseg.browser.map_view import MapView
from roomseg.browser.replay import replay_controls
from roomseg.browser.shell import fact_list, heading, jpeg_url, page, text
from roomseg.panorama import PanoramaParameters, Unfolding
from roomseg.preprocessing import preprocess

__all__ = ["map_page"]

Floats = NDArray[np.float64]

THUMBNAIL = 240
"""px; longer side of the images in the page."""


def map_page(
    file: MapFile,
    outlines: Any = None,
    *,
    features: Mapping[str, Floats] | None = None,
    others: Sequence[Segmentation] = (),
    facts: Sequence[tuple[str, str]] = (),
    most_images: int = 1000,
) -> str:
    """Make the page of a map.

    Parameters
    ----------
    file : MapFile
    outlines : shapely geometry, optional
        Obstacles of the apartment, scene frame.
    features : mapping of name to array, shape (e',), optional
        Features of the edges that Algorithm 1 keeps.
    others : sequence of Segmentation
        Besides the true rooms, and those that the map has.
    facts : sequence of (name, value)
        What to tell of the map.
    most_images : int
        If there are more, none are in the page, so that it stays small.
    """
    topomap, rooms, graph = file.topomap, file.rooms, preprocess(file.topomap)
    found = (None, "") if rooms is None else (rooms.label, rooms.model)
    segmentations = [*segmentations_of(topomap, *found), *others]
    view = MapView(MapLayers(topomap, graph, outlines), topomap, segmentations)
    picture = _picture(file, view, most_images)
    choice = view.feature_choice(graph.edges, features or {})
    replay = replay_controls(view.layers, view.nodes, view.switch, view.robots)
    title = topomap.title
    return page(
        title,
        view.layout(),
        heading(title),
        picture,
        *replay,
        text("<h2>Layers</h2>"),
        view.switch,
        *choice,
        *([fact_list(facts)] if facts else []),
    )


def _picture(file: MapFile, view: MapView, most: int) -> Any:
    """Where the images of a node are shown."""
    hint = f"Point at a node to see {'its images' if file.image_count else 'what it is'}."
    if file.image_count > most:
        hint = f"The {file.image_count} images are left out, so that the page stays small."
    picture = text(f"<p class='quiet'>{hint}</p>", name="node")
    images = _images(file, most)
    if any(images):
        # So that nothing moves when the first ones are shown.
        picture.min_height = THUMBNAIL + 60
    view.show_images(picture, images)
    return picture


def _images(file: MapFile, most: int) -> list[list[str]]:
    """Small images and panoramas of the nodes as data URLs; none where there is none."""
    if file.image_count > most:
        return [[] for _ in file.done]
    unfold = Unfolding.of(file.topomap.camera, PanoramaParameters())
    return [_views(file.image(node), unfold) if done else [] for node, done in enumerate(file.done)]


def _views(image: NDArray[np.uint8], unfold: Unfolding) -> list[str]:
    return [jpeg_url(image, THUMBNAIL), jpeg_url(unfold(image), unfold.map_x.shape[1])]
