"""Cutting a scene's broad surfaces where others stand on them.

Walls of a foreign scene may be single planes, and a floor or a ceiling may reach under
many of them: a texel there would be lit from two rooms. Every broad polygon is therefore
cut along the broad polygons that touch or cross it, and across at their ends; which of
the parts are then one surface is for `render.scene_surfaces` to find.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

__all__ = ["cut_at_walls"]

BROAD = 0.25
"""Smaller polygons are neither cut nor cut others, m²."""
REACH = 2e-3
"""What is nearer touches, m."""
MOST_CUTS = 100
"""Of one polygon."""
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Polygon:
    """A broad polygon: its object's place, its own in it, its corners (k, 3) and normal, m."""

    owner: int
    index: int
    corners: Floats
    normal: Floats
    area: float


def cut_at_walls(objects: list[Any]) -> None:
    """Cut the meshes of ``objects``, of which each has its own."""
    found = [part for owner, item in enumerate(objects) for part in _broad(owner, item)]
    cuts: dict[int, dict[int, list[tuple[Floats, Floats]]]] = {}
    for target, others in _neighbours(found):
        planes = list(_planes(target, others))[:MOST_CUTS]
        if planes:
            cuts.setdefault(target.owner, {})[target.index] = planes
    for owner, wanted in cuts.items():
        _cut(objects[owner], wanted)


def _broad(owner: int, item: Any) -> Iterator[_Polygon]:
    mesh, matrix = item.data, np.array(item.matrix_world, dtype=float)
    scale = float(np.abs(np.linalg.det(matrix[:3, :3]))) ** (2.0 / 3.0)
    area = np.empty(len(mesh.polygons), dtype=np.float32)
    mesh.polygons.foreach_get("area", area)
    # A stretched object's areas are not known before its corners are.
    for index in np.flatnonzero(area * scale > 0.1 * BROAD).tolist():
        local = np.array([mesh.vertices[k].co for k in mesh.polygons[index].vertices])
        corners = local @ matrix[:3, :3].T + matrix[:3, 3]
        normal = 0.5 * np.cross(corners - corners[0], np.roll(corners, -1, axis=0) - corners[0])
        across = normal.sum(axis=0)
        size = float(np.linalg.norm(across))
        if size > BROAD:
            yield _Polygon(owner, index, corners, across / size, size)


def _neighbours(found: list[_Polygon]) -> Iterator[tuple[_Polygon, list[_Polygon]]]:
    """Every polygon with those whose bounds meet its own, largest first."""
    if not found:
        return
    low = np.array([part.corners.min(axis=0) for part in found]) - REACH
    high = np.array([part.corners.max(axis=0) for part in found]) + REACH
    plan = shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    one, other = shapely.STRtree(plan).query(plan)
    meets = (low[one, 2] < high[other, 2]) & (low[other, 2] < high[one, 2]) & (one != other)
    order = np.lexsort([other, -np.array([part.area for part in found])[other], one])
    near: dict[int, list[_Polygon]] = {}
    for pair in order[meets[order]].tolist():
        near.setdefault(int(one[pair]), []).append(found[other[pair]])
    for index, others in near.items():
        yield found[index], others


def _planes(target: _Polygon, others: list[_Polygon]) -> Iterator[tuple[Floats, Floats]]:
    """Where to cut a polygon: a point of each plane, and its normal."""
    seen = set()
    for other in others:
        along = np.cross(target.normal, other.normal)
        if np.linalg.norm(along) < 0.1:
            continue
        along /= np.linalg.norm(along)
        if not (_reaches(target, other) and _reaches(other, target)):
            continue
        ends = other.corners @ along
        first, last = other.corners[ends.argmin()], other.corners[ends.argmax()]
        for point, normal in ((first, other.normal), (first, along), (last, along)):
            side = (target.corners - point) @ normal
            if side.min() > -REACH or side.max() < REACH:
                continue
            sign = 1.0 if normal[np.abs(normal).argmax()] > 0.0 else -1.0
            key = (*np.round(sign * normal, 3).tolist(), round(float(sign * point @ normal), 3))
            if key not in seen:
                seen.add(key)
                yield point, normal


def _reaches(one: _Polygon, other: _Polygon) -> bool:
    """Whether a polygon comes up to the other's plane."""
    side = (one.corners - other.corners[0]) @ other.normal
    return bool(side.min() < REACH and side.max() > -REACH)


def _cut(item: Any, wanted: dict[int, list[tuple[Floats, Floats]]]) -> None:
    """Cut polygons of one object by planes of the world."""
    import bmesh

    matrix = np.array(item.matrix_world, dtype=float)
    mesh = bmesh.new()
    mesh.from_mesh(item.data)
    mesh.faces.ensure_lookup_table()
    for first, planes in [(mesh.faces[index], planes) for index, planes in wanted.items()]:
        faces = [first]
        for point, normal in planes:
            # The plane in the object's own coordinates; it may be flattened by its matrix.
            across = matrix[:3, :3].T @ normal
            size = float(across @ across)
            if size < 1e-12:
                continue
            parts = {
                *faces,
                *(e for f in faces for e in f.edges),
                *(v for f in faces for v in f.verts),
            }
            done = bmesh.ops.bisect_plane(
                mesh,
                geom=sorted(parts, key=lambda part: (type(part).__name__, part.index)),
                dist=1e-6,
                plane_co=(across * (float(normal @ (point - matrix[:3, 3])) / size)).tolist(),
                plane_no=across.tolist(),
            )
            faces = [part for part in done["geom"] if isinstance(part, bmesh.types.BMFace)]
            mesh.faces.index_update()
            mesh.edges.index_update()
            mesh.verts.index_update()
    mesh.to_mesh(item.data)
    mesh.free()
