"""Floor plans of the ResPlan data set: JSON with the outlines of everything as WKT.

A file is one plan or a list of plans; the outlines are ``POLYGON`` texts, by layer,
under ``geometries`` or in the plan itself. Units differ from plan to plan and are not
told. What is read:

- ``living``, ``bedroom``, ``bathroom``, ``kitchen``, ``storage``, ``stair`` … are
  rooms. They may overlap (a kitchen in the living room): the smaller keeps the floor,
  and what touches with no wall between is open to each other.
- ``wall`` are footprints; ``door`` and ``window`` are thin shapes in gaps between them,
  ``front_door`` the door to the outside. y is up.
- ``balcony``, ``garden``, ``parking``, ``pool`` and ``veranda`` are outside and left out;
  other layers (``inner``, ``land`` …) repeat what these say, and are not read.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely import Polygon

from scenes.apartment import Point, RoomKind
from scenes.errors import SceneError
from scenes.faults import shape_fault
from scenes.importers import Imported
from scenes.importers.drawing import PlanDrawing, PlanOpening, PlanRoom, long_axis
from scenes.importers.plan import PlanOptions
from scenes.importers.plan_file import ask_for_scale, built, check_extent, check_scale
from scenes.importers.reading import read_json

__all__ = ["read_resplan"]

FORMAT = "ResPlan JSON"
ROOMS: dict[str, RoomKind] = {
    "living": "living_room",
    "bedroom": "bedroom",
    "bathroom": "bathroom",
    "kitchen": "kitchen",
    "storage": "storage",
    "corridor": "corridor",
    "office": "office",
    "room": "other",
}
OUTSIDE = ("balcony", "garden", "parking", "pool", "veranda", "stair")
OPENINGS = ("door", "front_door", "window")
DOOR_WIDTH = 0.8
"""At the right scale half of the doors are narrower, m."""

Shapes = dict[str, list[tuple[str, Polygon]]]


def read_resplan(
    path: str | Path,
    *,
    scale: float | None = None,
    name: str | None = None,
    plan: str | None = None,
    start: Point | None = None,
    ceiling_height: float = 2.5,
    furnish: bool = True,
    add_doors: bool = False,
) -> Imported:
    """Read a floor plan of ResPlan; the module's docstring says how.

    Parameters
    ----------
    path : path
    scale : float
        Metres per unit.
    name : str, optional
        Of the apartment; the file's stem, and the plan's id, if absent.
    plan : str, optional
        Id of the plan, in a file that has several.
    start, ceiling_height, furnish, add_doors
        `PlanOptions`; there are no fixtures to furnish with.

    Raises
    ------
    SceneError
        One line: the file, the element, its value, what would be right. Without a
        scale it says at which half of the doors would be narrower than 0.80 m.
    """
    check_scale(path, scale)
    chosen, several = _chosen(path, read_json(path, FORMAT), plan)
    layers = _layers(path, chosen)
    if not any(layers.get(layer) for layer in ROOMS):
        raise SceneError(f"{path}: no room in it; expected one of {', '.join(ROOMS)}")
    if scale is None:
        doors = [_length(shape) for _, shape in layers.get("door", [])]
        raise ask_for_scale(path, doors, DOOR_WIDTH)
    drawing = _drawing(layers, scale)
    check_extent(path, [room.shape for room in drawing.rooms], scale)
    stem = f"{Path(path).stem}_{chosen.get('id')}" if several else None
    options = PlanOptions(ceiling_height, furnish=furnish, add_doors=add_doors, start=start)
    return built(path, drawing, name or stem, options)


def _chosen(path: str | Path, data: Any, plan: str | None) -> tuple[Mapping[str, Any], bool]:
    """The plan asked for, and whether the file has several."""
    plans = data if isinstance(data, list) else [data]
    if not plans or not all(isinstance(item, dict) for item in plans):
        raise SceneError(f"{path}: no plan in it; expected {FORMAT}, a plan or a list of plans")
    known = [str(item.get("id", index)) for index, item in enumerate(plans)]
    if plan is None and len(plans) == 1:
        return plans[0], False
    if plan not in known:
        which = f"plan {plan!r} is not in it" if plan is not None else f"has {len(plans)} plans"
        shown = ", ".join(known[:12]) + (", …" if len(known) > 12 else "")
        raise SceneError(f"{path}: {which}; expected --plan with one of {shown}")
    return plans[known.index(plan)], len(plans) > 1


def _layers(path: str | Path, plan: Mapping[str, Any]) -> Shapes:
    """The polygons of every layer that is read, each with the label of its text."""
    source = plan.get("geometries", plan)
    if not isinstance(source, dict):
        raise SceneError(f"{path}: geometries: {source!r:.40}; expected layers of WKT polygons")
    layers: Shapes = {}
    for layer in (*ROOMS, *OUTSIDE, *OPENINGS, "wall"):
        texts = source.get(layer) or []
        for index, text in enumerate(texts if isinstance(texts, list) else [texts]):
            label = f"{layer}[{index}]"
            layers.setdefault(layer, []).extend((label, p) for p in _polygons(path, label, text))
    return layers


def _polygons(path: str | Path, label: str, text: object) -> Iterator[Polygon]:
    try:
        with np.errstate(all="ignore"):
            shape = shapely.from_wkt(text) if isinstance(text, str) else None
    except shapely.errors.ShapelyError:
        shape = None
    if shape is None or not np.isfinite(shapely.get_coordinates(shape)).all():
        raise SceneError(f"{path}: {label}: {text!r:.60}; expected a POLYGON as WKT")
    for part in shapely.get_parts(shape):
        if part.geom_type == "Polygon" and part.length > 0.0:
            if not part.is_valid and label.partition("[")[0] in ROOMS:
                raise SceneError(f"{path}: {label}: {shape_fault(part)}; expected a simple polygon")
            yield part


def _length(shape: Polygon) -> float:
    return float(np.hypot(*np.diff(long_axis(shape), axis=0)[0]))


def _drawing(layers: Shapes, scale: float) -> PlanDrawing:
    """The drawing in metres, its corner at the origin."""
    corner = shapely.total_bounds([shape for layer in layers.values() for _, shape in layer])[:2]
    metres: Shapes = {
        layer: [
            (label, shapely.transform(p, lambda xy: (xy - corner) * scale)) for label, p in all_
        ]
        for layer, all_ in layers.items()
    }
    rooms = [
        PlanRoom(label, layer, kind, shape)
        for layer, kind in ROOMS.items()
        for label, shape in metres.get(layer, [])
    ]
    drawn = [(label, layer, shape) for layer in OPENINGS for label, shape in metres.get(layer, [])]
    shapes = [shape for _, shape in metres.get("wall", [])]
    notes = [
        f"{label}: outside, no room for a robot; left out"
        for layer in OUTSIDE
        for label, _ in metres.get(layer, [])
    ]
    return PlanDrawing(
        tuple(rooms),
        # Walls have gaps where the openings are.
        wall_shapes=(*shapes, *(shape for _, _, shape in drawn)),
        openings=tuple(_opening(label, layer, shape) for label, layer, shape in drawn),
        notes=tuple(notes),
    )


def _opening(label: str, layer: str, shape: Polygon) -> PlanOpening:
    start, end = (tuple(point) for point in np.round(long_axis(shape), 4).tolist())
    return PlanOpening(label, "window" if layer == "window" else "door", start, end)
