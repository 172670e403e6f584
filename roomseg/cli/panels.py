"""What there is to draw of a map, as the paper's figures have it: one panel for each."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from dataset import MapFile, TopoMap

__all__ = ["SHOWN", "Panel", "coverage_of", "map_panels", "outlines_of"]

SHOWN = ("run", "floor", "obstacles", "edges", "graph", "width", "truth", "rooms", "images")
"""Figs. 3, 17, 16, 4, 5, 7, 22 (truth and result) and 18 of the paper."""
ASKED = ("floor", "edges", "width")
"""Drawn only when they are asked for."""
HOW = {
    "rooms": "roomseg segment finds them",
    "images": "roomseg render makes them",
    "truth": "it has no rooms in its ground truth",
    "width": "no edge has obstacle points on both sides",
}
"""Why something may be missing, and what would add it."""
IMAGE_COUNT = 4

Panel = Callable[[Any], None]
"""Draws into the axes that it is given."""


def map_panels(file: MapFile, show: tuple[str, ...]) -> list[Panel]:
    """Everything that was asked for; it is an error if the map does not have it."""
    from dataset import RoomsegError

    available = _available(file)
    for name in show:
        if name not in available:
            hint = f" ({HOW[name]})" if name in HOW else ""
            known = ", ".join(available)
            raise RoomsegError(f"{file.path}: has no {name} to draw{hint}, only {known}")
    usual = [name for name in available if name not in ASKED]
    return [panel for name in (show or usual) for panel in available[name]]


def _available(file: MapFile) -> dict[str, list[Panel]]:
    from roomseg import figures

    topomap = file.topomap
    outlines = outlines_of(topomap.scene)
    truth = topomap.ground_truth
    true_room = None if truth is None else truth.room
    rooms = file.rooms
    panels: dict[str, list[Panel]] = {
        "run": [
            partial(
                figures.draw_cleaning_run,
                topomap=topomap,
                outlines=outlines,
                title=topomap.title,
            )
        ],
        "obstacles": [partial(figures.draw_obstacle_map, topomap=topomap, title="Robot's map")],
    }
    panels |= _graph_panels(topomap, outlines)
    if topomap.scene is not None:
        panels["floor"] = [_floor_panel(topomap.scene, outlines)]
    draw_rooms = partial(
        figures.draw_rooms,
        nodes=topomap.nodes,
        points=topomap.obstacles.position,
        outlines=outlines,
    )
    if true_room is not None:
        panels["truth"] = [partial(draw_rooms, room=true_room, title="Ground truth")]
    if rooms is not None:
        title = f"Rooms by {rooms.model}"
        panels["rooms"] = [partial(draw_rooms, room=rooms.label, truth=true_room, title=title)]
    if file.image_count:
        panels["images"] = _image_panels(file)
    return panels


def outlines_of(scene: str | None) -> Any:
    """Read what stands near the floor from the map's scene, if it has one."""
    if scene is None:
        return None
    from scenes import Apartment, obstacles

    return obstacles(Apartment.model_validate_json(scene))


def coverage_of(topomap: TopoMap) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Times, every 10 s, and the covered share then; None without a scene or a path."""
    import numpy as np

    from scenes import Apartment
    from simulator.progress import coverage_progress

    path = topomap.path
    if topomap.scene is None or path is None or not len(path.time):
        return None
    place = Apartment.model_validate_json(topomap.scene)
    times = np.append(np.arange(0.0, path.time[-1], 10.0), path.time[-1])
    return times, coverage_progress(path, place, times, radius=topomap.robot_radius)


def _graph_panels(topomap: TopoMap, outlines: Any) -> dict[str, list[Panel]]:
    """The graph with all its edges, what Algorithm 1 keeps of it, and how a width is measured."""
    from roomseg import figures
    from roomseg.preprocessing import preprocess
    from roomseg.report.pictures import draw_passage
    from roomseg.report.views import measure_passage

    truth, graph = topomap.ground_truth, preprocess(topomap)
    draw = partial(figures.draw_graph, topomap=topomap, outlines=outlines)
    kept = None if truth is None else truth.edge_is_border[graph.kept]
    panels: dict[str, list[Panel]] = {
        "edges": [partial(draw, title="All edges")],
        "graph": [partial(draw, edges=graph.edges, is_border=kept, title="Map graph")],
    }
    passage = measure_passage(topomap, graph.edges)
    if passage is not None:
        panels["width"] = [partial(draw_passage, view=passage, title="Passageway width")]
    return panels


def _floor_panel(scene: str, outlines: Any) -> Panel:
    """The floor that is not occupied."""
    from roomseg.figures import draw_floor
    from scenes import Apartment, floor_region

    floor = floor_region(Apartment.model_validate_json(scene))
    return partial(draw_floor, floor=floor, obstacles=outlines, title="Free floor")


def _image_panels(file: MapFile) -> list[Panel]:
    """Choose a few images, spread over the run."""
    import numpy as np

    from roomseg.figures import draw_camera_image

    done = np.flatnonzero(file.done)
    chosen = done[np.linspace(0, len(done) - 1, min(IMAGE_COUNT, len(done))).astype(int)]
    return [
        partial(draw_camera_image, image=file.image(node), title=f"Node {node}") for node in chosen
    ]
