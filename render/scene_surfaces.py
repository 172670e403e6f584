"""The matte surfaces of a scene of any make, as pieces that can be laid flat.

Nothing is known of such a mesh but its polygons: neither what is solid, nor which side
is outside. A *piece* is what hangs together by edges and looks in one of the six main
directions, so that a look along that direction flattens it without folds; what lies in
one plane and touches is one piece, too, whatever its edges. A single plane may be lit
from both sides: each piece has a front and a back.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from render.charts import contacts
from render.planes import planes_of

__all__ = ["Surfaces", "read_surfaces"]

WELD = 1e-4
"""Corners that are nearer are one, m."""
BROAD = 0.02
"""Triangles of that area are looked at for touching ones in their plane, m²."""
SHORT = 0.03
"""Nobody looks what stands on shorter edges, m."""
LEVEL = 0.999
"""Cosine of the angle between polygons that count as one plane."""
OVER, BESIDE = 4e-3, 0.015
"""How far above a plane and beside an edge it is looked for what stands there, m."""
WIDE = 3e-3
"""Triangles of one plane that are nearer touch, m."""
AXES = np.array([(1, 2), (0, 2), (0, 1)])
"""What is left of a point, seen along x, y or z."""
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Surfaces:
    """The meshes of a scene, corner by corner, and their matte triangles.

    A corner is one of a polygon, not shared with its neighbours; those of one object
    follow one another.

    Attributes
    ----------
    objects : tuple of bpy.types.Object
    starts : array, shape (o + 1,)
        The first corner of each object, and their number.
    points, normals : array, shape (n, 3)
        Where each corner is, m, and where it looks by its shading.
    flat : array, shape (n, 2)
        Seen along the main direction of its piece, m.
    piece : array, shape (n,)
        -1 where a corner belongs to nothing matte.
    triangles : array, shape (t, 3)
        Corners of the matte triangles, counter-clockwise from the front.
    facing : array, shape (pieces, 3)
        The main direction in which each piece's front looks.
    tree : mathutils.bvhtree.BVHTree
        Of the triangles.
    """

    objects: tuple[Any, ...]
    starts: Ints
    points: Floats
    normals: Floats
    flat: Floats
    piece: Ints
    triangles: Ints
    facing: Floats
    tree: Any


@dataclass(frozen=True)
class _Part:
    """One object's corners: where, their normals, their polygons; its triangles, all in world."""

    points: Floats
    normals: Floats
    polygon: Ints
    triangles: Ints


def read_surfaces(objects: list[tuple[Any, NDArray[np.bool_]]]) -> Surfaces:
    """The surfaces of objects, of each with the polygons that are matte."""
    from mathutils.bvhtree import BVHTree

    parts = [_part(item, matte) for item, matte in objects]
    starts = np.cumsum([0, *(len(part.points) for part in parts)])
    ahead = np.cumsum([0, *(len(item.data.polygons) for item, _ in objects)])
    points = np.concatenate([np.zeros((0, 3)), *(part.points for part in parts)])
    polygon = np.concatenate(
        [np.zeros(0, int), *(p.polygon + k for p, k in zip(parts, ahead, strict=False))]
    )
    triangles = np.concatenate(
        [np.zeros((0, 3), int), *(p.triangles + k for p, k in zip(parts, starts, strict=False))]
    )
    way = _main_directions(points[triangles], polygon[triangles[:, 0]], int(ahead[-1]))
    tree = BVHTree.FromPolygons(points.tolist(), triangles.tolist())
    piece = _pieces(points, polygon, triangles, way, tree)
    facing = np.zeros((int(piece.max(initial=-1)) + 1, 3))
    of_corner = way[polygon]
    matte = piece >= 0
    facing[piece[matte], of_corner[matte] // 2] = 1.0 - 2.0 * (of_corner[matte] % 2)
    return Surfaces(
        tuple(item for item, _ in objects),
        starts,
        points,
        np.concatenate([np.zeros((0, 3)), *(part.normals for part in parts)]),
        np.take_along_axis(points, AXES[of_corner // 2], axis=1),
        piece,
        triangles,
        facing,
        tree,
    )


def _part(item: Any, matte: NDArray[np.bool_]) -> _Part:
    mesh, matrix = item.data, np.array(item.matrix_world, dtype=float)
    count = len(mesh.loops)
    vertex = _column(mesh.loops, "vertex_index", count, np.int32)
    place = _column(mesh.vertices, "co", 3 * len(mesh.vertices)).reshape(-1, 3)
    normal = _column(mesh.corner_normals, "vector", 3 * count).reshape(-1, 3).astype(float)
    mesh.calc_loop_triangles()
    triangles = _column(
        mesh.loop_triangles, "loops", 3 * len(mesh.loop_triangles), np.int32
    ).reshape(-1, 3)
    owner = _column(mesh.loop_triangles, "polygon_index", len(triangles), np.int32)
    total = _column(mesh.polygons, "loop_total", len(mesh.polygons), np.int32)
    if np.linalg.det(matrix[:3, :3]) < 0.0:
        triangles = triangles[:, ::-1]  # mirrored: keeps looking outward
    normal = normal @ np.linalg.pinv(matrix[:3, :3])
    return _Part(
        place[vertex].astype(float) @ matrix[:3, :3].T + matrix[:3, 3],
        normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12),
        np.repeat(np.arange(len(total)), total),
        triangles[matte[owner]].astype(np.int64),
    )


def _column(rows: Any, name: str, size: int, kind: Any = np.float32) -> NDArray[Any]:
    found = np.empty(size, dtype=kind)
    rows.foreach_get(name, found)
    return found


def _main_directions(corners: Floats, owner: Ints, count: int) -> Ints:
    """0 to 5 for +x, -x, +y, ... as each polygon looks; triangles (t, 3, 3) of ``owner``."""
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal = np.stack([np.bincount(owner, across[:, k], count) for k in range(3)], axis=1)
    axis = np.abs(normal).argmax(axis=1)
    against = np.take_along_axis(normal, axis[:, None], axis=1)[:, 0] < 0.0
    found: Ints = 2 * axis + against
    return found


def _pieces(points: Floats, polygon: Ints, triangles: Ints, way: Ints, tree: Any) -> Ints:
    """Number of the piece of every corner; -1 where nothing is matte."""
    matte = np.zeros(len(way), dtype=bool)
    matte[polygon[triangles[:, 0]]] = True
    links = [_by_edges(points, polygon, way), _by_planes(points, polygon, triangles)]
    pairs, where, across = (np.concatenate(column) for column in zip(*links, strict=True))
    alike = matte[pairs].all(axis=1) & (way[pairs[:, 0]] == way[pairs[:, 1]])
    pairs, where, across = pairs[alike], where[alike], across[alike]
    normal = _normals(points, polygon, triangles, len(way))
    open_ = ~_blocked(tree, normal[pairs], where, across)
    one, other = pairs[open_].T
    graph = coo_array((np.ones(len(one), dtype=bool), (one, other)), shape=(len(way),) * 2)
    found = connected_components(graph, directed=False)[1]
    number = np.full(len(way), -1)
    number[matte] = np.unique(found[matte], return_inverse=True)[1]
    return number[polygon]


def _normals(points: Floats, polygon: Ints, triangles: Ints, count: int) -> Floats:
    corners, owner = points[triangles], polygon[triangles[:, 0]]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal = np.stack([np.bincount(owner, across[:, k], count) for k in range(3)], axis=1)
    return _unit(normal)


def _blocked(tree: Any, normals: Floats, where: Floats, across: Floats) -> NDArray[np.bool_]:
    """Whether something stands between polygons of one plane, on either side of it.

    Parameters
    ----------
    tree : BVHTree
    normals : array, shape (k, 2, 3)
        Of both polygons.
    where, across : array, shape (k, 3)
        The middle of where they touch, and from the one to the other, m; shorter ones than
        `SHORT` are taken for open.
    """
    found = np.zeros(len(where), dtype=bool)
    long = np.linalg.norm(across, axis=1) > SHORT
    flat = np.einsum("ki,ki->k", normals[:, 0], normals[:, 1]) > LEVEL
    for index in np.flatnonzero(long & flat).tolist():
        step = BESIDE * across[index] / np.linalg.norm(across[index])
        for side in (OVER, -OVER):
            start = where[index] + side * normals[index, 0] - step
            if tree.ray_cast(start, step, 2.0 * BESIDE)[0] is not None:
                found[index] = True
    return found


Links = tuple[Ints, Floats, Floats]


def _by_edges(points: Floats, polygon: Ints, way: Ints) -> Links:
    """Pairs of polygons (k, 2) that share an edge and look the same way.

    Besides the middle of the edge, and a vector in the first one's plane, square to the
    edge and as long (k, 3).
    """
    nothing = np.zeros((0, 2), int), np.zeros((0, 3)), np.zeros((0, 3))
    if not len(points):
        return nothing
    vertex = np.unique(np.round(points / WELD).astype(np.int64), axis=0, return_inverse=True)[1]
    vertex = vertex.ravel()
    last = np.append(polygon[1:] != polygon[:-1], True)
    first = np.flatnonzero(np.append(True, last[:-1]))
    after = np.arange(1, len(points) + 1)
    after[last] = first
    ends = np.sort(np.stack([vertex, vertex[after]], axis=1), axis=1)
    key = np.column_stack([ends, way[polygon]])
    order = np.lexsort(key.T)
    same = (key[order][1:] == key[order][:-1]).all(axis=1)
    one, other = order[:-1][same], order[1:][same]
    edge = points[after[one]] - points[one]
    before = np.empty(len(points), dtype=np.int64)
    before[after] = np.arange(len(points))
    square = np.cross(np.cross(points[before[one]] - points[one], edge), edge)
    across = _unit(square) * np.linalg.norm(edge, axis=1, keepdims=True)
    pairs = np.stack([polygon[one], polygon[other]], axis=1)
    return pairs, points[one] + 0.5 * edge, across


def _by_planes(points: Floats, polygon: Ints, triangles: Ints) -> Links:
    """Pairs of polygons whose broad triangles touch in one plane; as `_by_edges`."""
    corners = points[triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    broad = np.flatnonzero(np.linalg.norm(across, axis=1) > 2.0 * BROAD)
    if not len(broad):
        return np.zeros((0, 2), int), np.zeros((0, 3)), np.zeros((0, 3))
    planes = planes_of(corners[broad])
    flat = planes.flat(corners[broad])
    one, other = contacts(planes, flat)
    owner = polygon[triangles[broad, 0]]
    new = (one < other) & (owner[one] != owner[other])
    one, other = one[new], other[new]
    shapes = shapely.polygons(flat)
    meeting = shapely.centroid(
        shapely.intersection(shapely.buffer(shapes[one], WIDE), shapes[other])
    )
    middle = shapely.get_coordinates(meeting)[:, None]
    where = planes.solid(middle, one, 0.0)[:, 0]
    centres = corners[broad].mean(axis=1)
    return np.stack([owner[one], owner[other]], axis=1), where, centres[other] - centres[one]


def _unit(vectors: NDArray[Any]) -> Floats:
    found: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-15)
    return found
