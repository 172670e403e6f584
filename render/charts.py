"""Flat pieces of a mesh laid out in one picture, and what of them light can reach.

A chart is all triangles that lie in one plane, look the same way and touch: a wall with
the piece over its doorway, a ceiling, a table top. Its texels are squares of the plane,
so that light which varies smoothly over a wall does so in the picture, too, and no seam
runs where two solids continue one another.

Solids stand in and on each other. Texels under a cupboard or within a wall would be
black, and would darken their neighbours: light is therefore gathered by *receivers*,
the triangles without what lies in other solids, cut exactly. Receivers float `LIFT` in
front of their surfaces and are seen by no ray.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from scenes.mesh import Mesh
from scenes.solids import Prism

__all__ = ["LIFT", "Atlas", "lay_out"]

LIFT = 1e-3
"""How far receivers float in front of their surface, m; what is nearer than that touches."""
GUTTER = 2
"""Texels around a chart that repeat its border."""
Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True)
class Atlas:
    """A mesh's charts in one picture.

    Attributes
    ----------
    shape : tuple of int
        (rows, columns) of the picture.
    uv : array, shape (t, 3, 2)
        Column and row of every triangle's corners, texels; texel (r, c) has its centre
        at (c + 0.5, r + 0.5).
    chart : array, shape (t,)
        The chart of every triangle.
    boxes : array, shape (c, 4)
        First row, first column, rows and columns of every chart, gutter included.
    normals : array, shape (c, 3)
        Where every chart looks.
    receiver_corners : array, shape (k, 3, 3)
        Corners of the receivers' triangles, m.
    receiver_uv : array, shape (k, 3, 2)
    """

    shape: tuple[int, int]
    uv: Floats
    chart: Ints
    boxes: Ints
    normals: Floats
    receiver_corners: Floats
    receiver_uv: Floats

    @property
    def scaled_uv(self) -> Floats:
        """``uv`` in units of the picture: 0 to 1."""
        return self.uv / self.shape[::-1]

    @property
    def scaled_receiver_uv(self) -> Floats:
        """``receiver_uv`` in units of the picture: 0 to 1."""
        return self.receiver_uv / self.shape[::-1]


@dataclass(frozen=True)
class _Planes:
    """The plane of every triangle: unit normal (t, 3), axes (t, 2, 3), distance (t,), m."""

    normal: Floats
    axes: Floats
    distance: Floats

    def flat(self, corners: Floats) -> Floats:
        """Plane coordinates (t, 3, 2) of corners (t, 3, 3), m."""
        return np.einsum("tki,tci->tck", self.axes, corners)

    def solid(self, points: Floats, which: Ints, lift: float) -> Floats:
        """Points (k, ..., 3) of plane coordinates (k, ..., 2), ``lift`` m before the plane."""
        axes, normal = self.axes[which], self.normal[which]
        away = (self.distance[which] + lift)[:, None] * normal
        return np.einsum("k...a,kai->k...i", points, axes) + away[:, None, :]


def lay_out(mesh: Mesh, prisms: Sequence[Prism], texel: Floats) -> Atlas:
    """Charts of ``mesh`` and its receivers.

    Parameters
    ----------
    mesh : Mesh
    prisms : sequence of Prism
        The solids that hide what is in them.
    texel : array, shape (t,)
        Side of a texel that each triangle needs, m; a chart gets as many texels as its
        triangles need together.
    """
    corners = mesh.vertices[mesh.triangles]
    planes = _planes(corners)
    flat = planes.flat(corners)
    shapes = shapely.polygons(flat)
    chart = _touching(planes, shapes)
    visible, owner = _exposed(corners, planes, shapes, prisms)
    scale, low, extent = _extents(flat, chart, texel)
    counts = np.maximum(np.ceil(extent / scale[:, None] - 1e-6), 1).astype(np.int32)
    shape, origin = _pack(counts + 2 * GUTTER)
    pitch = np.maximum(extent, 1e-9) / counts

    def place(points: Floats, which: Ints) -> Floats:
        start = (origin + GUTTER)[which][:, None]
        placed: Floats = start + (points - low[which][:, None]) / pitch[which][:, None]
        return placed

    first = np.unique(chart, return_index=True)[1]
    return Atlas(
        shape,
        place(flat, chart),
        chart,
        np.column_stack([origin[:, ::-1], counts[:, ::-1] + 2 * GUTTER]).astype(np.int32),
        planes.normal[first],
        planes.solid(visible, owner, LIFT),
        place(visible, chart[owner]),
    )


def _planes(corners: Floats) -> _Planes:
    """Planes of triangles (t, 3, 3); parallel planes share their axes."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-15)
    # Rounded, so that triangles of one plane get the very same axes.
    normal = np.round(normal, 5)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-15)
    level = np.abs(normal[:, 2]) > 0.9999
    across = np.column_stack([-normal[:, 1], normal[:, 0], np.zeros(len(normal))])
    across[level] = (1.0, 0.0, 0.0)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    axes = np.stack([across, np.cross(normal, across)], axis=1)
    return _Planes(normal, axes, np.einsum("ti,ti->t", normal, corners[:, 0]))


def _touching(planes: _Planes, shapes: NDArray[np.object_]) -> Ints:
    """Number of the chart of every triangle: same plane, in touch."""
    key = np.column_stack([np.round(planes.normal, 4), np.round(planes.distance / LIFT)])
    plane = np.unique(key + 0.0, axis=0, return_inverse=True)[1].ravel()
    # One tree for all planes: they are moved apart along u.
    width = 1.0 + float(np.ptp(shapely.bounds(shapes)[:, [0, 2]]))
    apart = shapely.transform(
        shapes,
        lambda points, shift=np.repeat(plane * width, shapely.get_num_coordinates(shapes)): (
            points + np.column_stack([shift, np.zeros(len(shift))])
        ),
    )
    one, other = shapely.STRtree(apart).query(apart, predicate="dwithin", distance=2 * LIFT)
    links = coo_array((np.ones(len(one), dtype=bool), (one, other)), shape=(len(shapes),) * 2)
    chart: Ints = connected_components(links, directed=False)[1].astype(np.int32)
    return chart


def _exposed(
    corners: Floats, planes: _Planes, shapes: NDArray[np.object_], prisms: Sequence[Prism]
) -> tuple[Floats, Ints]:
    """Triangles (k, 3, 2) in plane coordinates that no solid covers, and whose part they are."""
    cover = _covers(corners, planes, prisms)
    left = shapes.copy()
    for index, parts in cover.items():
        left[index] = shapely.difference(left[index], shapely.union_all(parts))
    pieces, owner = shapely.get_parts(left, return_index=True)
    keep = (shapely.get_type_id(pieces) == 3) & (shapely.area(pieces) > 1e-7)
    pieces, owner = pieces[keep], owner[keep]
    cut, inner = shapely.get_parts(
        shapely.constrained_delaunay_triangles(pieces), return_index=True
    )
    points = shapely.get_coordinates(cut).reshape(-1, 4, 2)[:, :3]
    one, two = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    clockwise = one[:, 0] * two[:, 1] < one[:, 1] * two[:, 0]
    points[clockwise] = points[clockwise][:, ::-1]
    return points, owner[inner].astype(np.int32)


def _covers(
    corners: Floats, planes: _Planes, prisms: Sequence[Prism]
) -> dict[int, list[shapely.Geometry]]:
    """What of every triangle's plane lies in solids, where there is any, in plane coordinates."""
    if not prisms:
        return {}
    feet = np.array([prism.footprint for prism in prisms], dtype=object)
    heights = np.array([(prism.bottom, prism.top) for prism in prisms])
    tree = shapely.STRtree(feet)
    lifted = corners + LIFT * planes.normal[:, None]
    found: dict[int, list[shapely.Geometry]] = {}
    low, high = lifted[..., 2].min(axis=1), lifted[..., 2].max(axis=1)
    level = np.flatnonzero(np.abs(planes.normal[:, 2]) > 0.9999)
    upright = np.flatnonzero(np.abs(planes.normal[:, 2]) < 1e-4)

    some, solid = tree.query(shapely.polygons(lifted[level, :, :2]), predicate="intersects")
    some = level[some]
    hit = (heights[solid, 0] < low[some]) & (high[some] < heights[solid, 1])
    for triangle, which in zip(some[hit].tolist(), solid[hit].tolist(), strict=True):
        # Seen from below, the second axis runs the other way.
        flip = planes.axes[triangle, 1, 1]
        shape = feet[which]
        found.setdefault(triangle, []).append(
            shape if flip > 0 else shapely.transform(shape, lambda p: p * (1.0, -1.0))
        )

    along = np.einsum("tci,ti->tc", lifted, planes.axes[:, 0])
    first, last = along.argmin(axis=1), along.argmax(axis=1)
    ends = np.stack([lifted[upright, first[upright]], lifted[upright, last[upright]]], axis=1)
    lines = shapely.linestrings(ends[..., :2])
    some, solid = tree.query(lines, predicate="intersects")
    hit = (heights[solid, 0] < high[upright[some]]) & (low[upright[some]] < heights[solid, 1])
    some, solid = some[hit], solid[hit]
    shared, inner = shapely.get_parts(shapely.intersection(lines[some], feet[solid]), True)
    for part, pair in zip(shared, inner.tolist(), strict=True):
        if part.geom_type != "LineString" or part.length < 1e-6:
            continue
        triangle = int(upright[some[pair]])
        ends_on = np.asarray(part.coords) @ planes.axes[triangle, 0, :2]
        bottom, top = heights[solid[pair]]
        found.setdefault(triangle, []).append(
            shapely.box(ends_on.min(), bottom, ends_on.max(), top)
        )
    return found


def _extents(flat: Floats, chart: Ints, texel: Floats) -> tuple[Floats, Floats, Floats]:
    """Texel side (c,), lowest corner (c, 2) and extent (c, 2) of every chart, m."""
    count = int(chart.max()) + 1
    one, two = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    area = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]) + 1e-12
    needed = np.bincount(chart, area / texel**2, count)
    scale = np.sqrt(np.bincount(chart, area, count) / needed)
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, chart, flat.min(axis=1))
    np.maximum.at(high, chart, flat.max(axis=1))
    return scale, low, high - low


def _pack(sizes: Ints) -> tuple[tuple[int, int], Ints]:
    """Shape of a picture that holds rectangles (columns, rows), and where: (column, row).

    Shelves: highest first, from left to right.
    """
    area = float(np.prod(sizes.astype(float), axis=1).sum())
    width = int(max(np.ceil(np.sqrt(1.1 * area)), sizes[:, 0].max()))
    origin = np.zeros_like(sizes)
    column = row = shelf = 0
    for index in np.argsort(-sizes[:, 1], kind="stable").tolist():
        columns, rows = sizes[index].tolist()
        if column + columns > width:
            row, column, shelf = row + shelf, 0, 0
        origin[index] = (column, row)
        column, shelf = column + columns, max(shelf, rows)
    return (row + shelf, width), origin
