"""A map as Valetudo's JSON: floor, walls and segments as pixels, the driven path.

Pixels count from the upper left corner, y down, in cells of the resolution; points are
in cm. The middle of the picture is the origin of the map frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dataset.topomap import TopoMap
from roomseg.exporters.floor import FREE, OCCUPIED, FloorGrid, floor_grid, room_name

__all__ = ["valetudo_map"]

LEAST_SIZE = 5120
"""Side of the picture that robots have, cm."""


def valetudo_map(
    topomap: TopoMap,
    room: NDArray[np.int32] | None,
    resolution: float = 0.05,
    names: Sequence[str] = (),
) -> dict[str, Any]:
    """The fields of a ``ValetudoMap``, version 2.

    Parameters
    ----------
    topomap : TopoMap
    room : array, shape (n,), optional
        Room of each node, from 0: segment ``room + 1``.
    resolution : float
        m per pixel, whole centimetres.
    names : sequence of str, optional
        Of the rooms; one without is called ``room-1`` and so on.
    """
    pixel = max(1, round(100 * resolution))
    grid = floor_grid(topomap, room, pixel / 100)
    rows, columns = grid.cells.shape
    x, y = (round(value / grid.resolution) for value in grid.origin)
    reach = max(abs(x), abs(y), abs(x + columns), abs(y + rows))
    half = max(LEAST_SIZE // (2 * pixel), reach)
    corner = (half + x, half - y - rows)
    masks: list[tuple[str, dict[str, Any], NDArray[np.bool_]]] = []
    masks.append(("floor", {}, (grid.cells == FREE) & (grid.rooms == 0)))
    masks.append(("wall", {}, grid.cells == OCCUPIED))
    for number in np.unique(grid.rooms[grid.rooms > 0]).tolist():
        name = room_name(names, number - 1)
        meta = {"segmentId": str(number), "active": False, "name": name}
        masks.append(("segment", meta, grid.rooms == number))
    layers = [_layer(kind, meta, mask, corner, pixel) for kind, meta, mask in masks if mask.any()]
    return {
        "__class": "ValetudoMap",
        "metaData": {"version": 2, "totalLayerArea": _area(grid, pixel)},
        "size": {"x": 2 * half * pixel, "y": 2 * half * pixel},
        "pixelSize": pixel,
        "layers": layers,
        "entities": _entities(topomap, half * pixel),
    }


def _area(grid: FloorGrid, pixel: int) -> int:
    return int(((grid.cells == FREE) | (grid.cells == OCCUPIED)).sum()) * pixel * pixel


def _layer(
    kind: str,
    meta: dict[str, Any],
    mask: NDArray[np.bool_],
    corner: tuple[int, int],
    pixel: int,
) -> dict[str, Any]:
    """One layer; ``compressedPixels`` are runs x, y, length along the rows."""
    edge = np.diff(np.pad(mask, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, begin = np.nonzero(edge == 1)
    end = np.nonzero(edge == -1)[1]
    runs = np.stack([begin + corner[0], row + corner[1], end - begin], axis=1)
    down, right = np.nonzero(mask)
    count = int(mask.sum())
    return {
        "__class": "MapLayer",
        "metaData": {**meta, "area": count * pixel * pixel},
        "type": kind,
        "pixels": [],
        "compressedPixels": runs.ravel().tolist(),
        "dimensions": {
            "x": _span(right + corner[0]),
            "y": _span(down + corner[1]),
            "pixelCount": count,
        },
    }


def _span(values: NDArray[np.int64]) -> dict[str, int]:
    low, high = int(values.min()), int(values.max())
    return {"min": low, "max": high, "mid": (low + high + 1) // 2, "avg": round(values.mean())}


def _entities(topomap: TopoMap, middle: int) -> list[dict[str, Any]]:
    """The driven path, or the nodes in order; the robot at its end."""
    path, nodes = topomap.path, topomap.nodes
    track = nodes.position if path is None else path.estimate[:, :2]
    points = np.rint(np.array([middle, middle]) + track * (100, -100)).astype(np.int64)
    fresh = np.r_[True, (np.diff(points, axis=0) != 0).any(axis=1)]
    points = points[fresh]
    heading = float(nodes.heading[-1] if path is None else path.estimate[-1, 2])
    # Valetudo's angles: degrees, clockwise, 0 ahead is up.
    angle = round(90 - np.degrees(heading)) % 360
    return [
        _entity("PathMapEntity", "path", points.ravel().tolist(), {}),
        _entity("PointMapEntity", "robot_position", points[-1].tolist(), {"angle": angle}),
        _entity("PointMapEntity", "charger_location", points[0].tolist(), {}),
    ]


def _entity(class_: str, kind: str, points: list[int], meta: dict[str, Any]) -> dict[str, Any]:
    return {"__class": class_, "metaData": meta, "points": points, "type": kind}
