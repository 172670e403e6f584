"""What of a mesh stands free: its triangles without what lies in other solids.

Solids stand in and on each other. A triangle's plane, moved a little forward, cuts the
solids in polygons; these are what no light reaches.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from render.planes import Planes
from scenes.solids import Prism

__all__ = ["LIFT", "free_parts"]

LIFT = 1e-3
"""How far in front of a surface its surroundings are looked at, m."""
SPECK = 1e-7
"""Smaller pieces do not count, m²."""
Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Cover = tuple[int, shapely.Geometry]


def free_parts(corners: Floats, planes: Planes, prisms: Sequence[Prism]) -> tuple[Floats, Ints]:
    """The free parts of triangles, cut into triangles.

    Parameters
    ----------
    corners : array, shape (t, 3, 3)
        m. Only level and upright triangles are cut.
    planes : Planes
    prisms : sequence of Prism

    Returns
    -------
    array, shape (k, 3, 2)
        Corners in plane coordinates, counter-clockwise about the normal, m.
    array, shape (k,)
        The triangle that each is a part of.
    """
    covers = defaultdict(list)
    if prisms:
        tree = shapely.STRtree([prism.footprint for prism in prisms])
        heights = np.array([(prism.bottom, prism.top) for prism in prisms])
        lifted = corners + LIFT * planes.normal[:, None]
        for cover in (_level_covers, _upright_covers):
            for triangle, shape in cover(lifted, planes, tree, heights):
                covers[triangle].append(shape)
    left = shapely.polygons(planes.flat(corners))
    for triangle, shapes in covers.items():
        left[triangle] = shapely.difference(left[triangle], shapely.union_all(shapes))
    pieces, owner = shapely.get_parts(left, return_index=True)
    keep = (shapely.get_type_id(pieces) == shapely.GeometryType.POLYGON) & (
        shapely.area(pieces) > SPECK
    )
    return _triangulated(pieces[keep], owner[keep])


def _triangulated(pieces: NDArray[np.object_], owner: NDArray[np.int64]) -> tuple[Floats, Ints]:
    cut, inner = shapely.get_parts(
        shapely.constrained_delaunay_triangles(pieces), return_index=True
    )
    points = shapely.get_coordinates(cut).reshape(-1, 4, 2)[:, :3]
    one, two = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    clockwise = one[:, 0] * two[:, 1] < one[:, 1] * two[:, 0]
    points[clockwise] = points[clockwise][:, ::-1]
    return points, owner[inner].astype(np.int32)


def _level_covers(
    lifted: Floats, planes: Planes, tree: shapely.STRtree, heights: Floats
) -> Iterator[Cover]:
    """Footprints of the solids at the height of level triangles."""
    level = np.flatnonzero(planes.level)
    plan = shapely.polygons(lifted[level, :, :2])
    found, solid = tree.query(plan, predicate="intersects")
    z = lifted[level, 0, 2][found]
    inside = (heights[solid, 0] < z) & (z < heights[solid, 1])
    for triangle, which in zip(level[found[inside]], solid[inside], strict=True):
        shape = tree.geometries[which]
        # What looks down has its second axis against y.
        mirrored = planes.axes[triangle, 1, 1] < 0.0
        yield int(triangle), shapely.transform(shape, _mirror) if mirrored else shape


def _mirror(points: Floats) -> Floats:
    return points * (1.0, -1.0)


def _upright_covers(
    lifted: Floats, planes: Planes, tree: shapely.STRtree, heights: Floats
) -> Iterator[Cover]:
    """Rectangles in which upright triangles' planes cut the solids."""
    upright = np.flatnonzero(planes.upright)
    corners, across = lifted[upright], planes.axes[upright, 0]
    along = np.einsum("tci,ti->tc", corners, across)
    rows = np.arange(len(upright))
    ends = [corners[rows, pick(along, axis=1), :2] for pick in (np.argmin, np.argmax)]
    lines = shapely.linestrings(np.stack(ends, axis=1))
    found, solid = tree.query(lines, predicate="intersects")
    low, high = corners[..., 2].min(axis=1)[found], corners[..., 2].max(axis=1)[found]
    beside = (heights[solid, 0] < high) & (low < heights[solid, 1])
    found, solid = found[beside], solid[beside]
    shared, pair = shapely.get_parts(
        shapely.intersection(lines[found], tree.geometries[solid]), return_index=True
    )
    for part, index in zip(shared, pair, strict=True):
        if part.geom_type == "LineString" and part.length > 1e-6:
            reach = shapely.get_coordinates(part) @ across[found[index], :2]
            bottom, top = heights[solid[index]]
            triangle = int(upright[found[index]])
            yield triangle, shapely.box(reach.min(), bottom, reach.max(), top)
