"""Rooms and borders of a map as GeoJSON, in the map frame, m."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from dataset.topomap import TopoMap
from roomseg.exporters.floor import floor_grid, room_areas, room_name

__all__ = ["drawn_borders", "map_geojson"]

Floats = NDArray[np.float64]


def map_geojson(
    topomap: TopoMap,
    room: NDArray[np.int32],
    resolution: float = 0.025,
    names: Sequence[str] = (),
) -> dict[str, Any]:
    """The FeatureCollection of a map's rooms.

    Parameters
    ----------
    topomap : TopoMap
    room : array, shape (n,)
        Room of each node, from 0.
    resolution : float
        Of the grid whose cells the floor is made of, m; corners are cut by as much.
    names : sequence of str, optional
        Of the rooms; one without is called ``room-1`` and so on.

    Returns
    -------
    dict
        Layers ``room`` (floor, with number and nodes), ``border`` (where two rooms
        meet), and ``drawn_border`` (the ground truth's segments in the map frame).
    """
    about = {"environment": topomap.environment, "run": topomap.run}
    return {
        "type": "FeatureCollection",
        "map": about,
        "features": [*_features(topomap, room, resolution, names)],
    }


def _features(
    topomap: TopoMap, room: NDArray[np.int32], resolution: float, names: Sequence[str]
) -> Iterator[dict[str, Any]]:
    areas = room_areas(floor_grid(topomap, room, resolution))
    # Simplified together: neighbours keep the same line between them.
    smooth = shapely.coverage_simplify(areas, 2 * resolution)
    for number, area in enumerate(smooth):
        nodes = int((room == number).sum())
        yield _feature(
            area, layer="room", name=room_name(names, number), room=number, nodes=nodes,
            area=round(float(area.area), 3),
        )  # fmt: skip
    for (i, one), (j, other) in combinations(enumerate(smooth), 2):
        lines = shapely.line_merge(_lines(shapely.intersection(one, other)))
        for line in shapely.get_parts(lines):
            yield _feature(line, layer="border", rooms=[i, j])
    for segment in drawn_borders(topomap):
        yield _feature(shapely.linestrings(segment), layer="drawn_border")


def _lines(shape: shapely.Geometry) -> shapely.Geometry:
    parts = shapely.get_parts(shape)
    return shapely.multilinestrings(parts[shapely.get_type_id(parts) == 1])


def drawn_borders(topomap: TopoMap) -> Floats:
    """Border segments of the ground truth in the map frame, shape (b, 2, 2), m.

    Those drawn on the plan are moved as the estimate of the node nearest to each is
    from its true pose: estimates are good among neighbours only (§2.1).
    """
    truth, pose = topomap.ground_truth, topomap.nodes.true_pose
    if truth is None or not len(truth.borders):
        return np.empty((0, 2, 2))
    if truth.frame == "map" or pose is None:
        return truth.borders
    gap = truth.borders.mean(axis=1)[:, None] - pose[None, :, :2]
    nearest = np.hypot(*np.moveaxis(gap, -1, 0)).argmin(axis=1)
    turn = topomap.nodes.heading[nearest] - pose[nearest, 2]
    cos, sin = np.cos(turn), np.sin(turn)
    rotation = np.moveaxis(np.array([[cos, -sin], [sin, cos]]), -1, 0)
    offset = truth.borders - pose[nearest, None, :2]
    moved: Floats = np.einsum("bij,bkj->bki", rotation, offset)
    return moved + topomap.nodes.position[nearest, None]


def _feature(shape: shapely.Geometry, **properties: Any) -> dict[str, Any]:
    parts = shapely.get_parts(shape)
    plain = parts[0] if len(parts) == 1 else shape
    # RFC 7946: outer rings counter-clockwise.
    plain = shapely.orient_polygons(plain)
    rounded = shapely.transform(plain, lambda points: np.round(points, 6))
    geometry = shapely.geometry.mapping(rounded)
    return {"type": "Feature", "properties": properties, "geometry": geometry}
