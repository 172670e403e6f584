"""A horizontal cut through a 3D scene of any make, for the cut-away picture."""

from __future__ import annotations

from typing import Any

__all__ = ["cut_scene"]

NEAR = 1e-5
"""Vertices this near to the cut count as on it, m."""
WELD = 1e-4
"""Vertices on the cut that are this near to each other become one, m."""


def cut_scene(bpy: Any, scene: Any, height: float, lid: Any) -> None:
    """Remove what is above ``height`` m, close what was cut with a lid, and put out lights.

    Parameters
    ----------
    bpy : module
    scene : bpy.types.Scene
        Objects are changed in place.
    height : float
        m.
    lid : bpy.types.Material
        Of the faces that close cut solids; a surface that encloses nothing stays open.
    """
    for item in list(scene.objects):
        if item.type == "MESH":
            _cut(item, height, lid)
        else:
            bpy.data.objects.remove(item)


def _cut(item: Any, height: float, lid: Any) -> None:
    """Cut one object's mesh, which becomes its own and gets world coordinates."""
    import bmesh
    from mathutils import Matrix

    item.data = item.data.copy()
    item.data.transform(item.matrix_world)
    item.parent = None
    item.matrix_world = Matrix.Identity(4)
    item.data.materials.append(lid)
    shape = bmesh.new()
    shape.from_mesh(item.data)
    bmesh.ops.bisect_plane(
        shape,
        geom=[*shape.verts, *shape.edges, *shape.faces],
        dist=NEAR,
        plane_co=(0.0, 0.0, height),
        plane_no=(0.0, 0.0, 1.0),
        clear_outer=True,
    )
    # Formats with one normal per vertex split solids along their edges: join them for the lid.
    on_cut = [vertex for vertex in shape.verts if abs(vertex.co.z - height) < WELD]
    bmesh.ops.remove_doubles(shape, verts=on_cut, dist=WELD)
    rim = [e for e in shape.edges if all(abs(v.co.z - height) < WELD for v in e.verts)]
    filled = bmesh.ops.triangle_fill(shape, edges=rim, use_beauty=True, normal=(0.0, 0.0, 1.0))
    for part in filled["geom"]:
        if isinstance(part, bmesh.types.BMFace):
            part.material_index = len(item.data.materials) - 1
    shape.to_mesh(item.data)
    shape.free()
