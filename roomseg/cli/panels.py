"""What there is to draw of a map: one panel for each of its parts."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dataset import MapFile

__all__ = ["SHOWN", "Panel", "map_panels"]

SHOWN = ("run", "obstacles", "graph", "truth", "rooms", "images")
IMAGE_COUNT = 4

Panel = Callable[[Any], None]
"""Draws into the axes that it is given."""


def map_panels(file: MapFile, show: tuple[str, ...]) -> list[Panel]:
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
