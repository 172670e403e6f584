"""A Blender scene as it looks, without what makes it so.

Modifiers, instances, curves and texts become plain meshes; lights, materials and the
world stay. What is sliced into obstacles and what is rendered are then the same
triangles, and the new scene needs no other file.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from render.scene_cleaning import all_data
from scenes.importers.slicing import Triangles

__all__ = ["Body", "evaluate_scene", "glows", "plain_scene", "sources_of_light", "triangles_of"]

SOLID = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
SILENT = {"CAMERA", "ARMATURE", "LATTICE", "LIGHT", "LIGHT_PROBE", "SPEAKER"}
"""Objects that are no solids, and that nobody takes for one."""
SEEN_BY = (
    "visible_camera",
    "visible_diffuse",
    "visible_glossy",
    "visible_transmission",
    "visible_volume_scatter",
    "visible_shadow",
)


@dataclass(frozen=True)
class Body:
    """A mesh or light: its data (of the new scene), and where it is.

    ``matrix`` (4, 4) in the units of the file; ``seen_by`` Cycles' ray visibility.
    """

    name: str
    data: Any
    matrix: NDArray[np.float64]
    seen_by: tuple[bool, ...]
    is_light: bool


def evaluate_scene(bpy: Any, scene: Any) -> tuple[list[Body], list[str]]:
    """All meshes and lights that a rendering shows, and notes on what it does not."""
    bpy.context.window.scene = scene
    _show_what_is_rendered(bpy, scene)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    bodies, shared = [], dict[tuple[Any, ...], Any]()
    shown = set()
    for instance in depsgraph.object_instances:
        item = instance.object
        shown.add(item.original.name)
        if item.type not in SOLID and item.type != "LIGHT":
            continue
        key = (item.type, item.data.as_pointer(), *(slot.name for slot in item.material_slots))
        if key not in shared:
            shared[key] = _copied(bpy, instance, depsgraph)
        if shared[key] is not None:
            matrix = np.array(instance.matrix_world, dtype=float)
            seen = tuple(bool(getattr(item, flag)) for flag in SEEN_BY)
            name = item.original.name
            bodies.append(Body(name, shared[key], matrix, seen, item.type == "LIGHT"))
    return bodies, list(_unused(scene, bodies, shown))


def _show_what_is_rendered(bpy: Any, scene: Any) -> None:
    """Make the evaluation, which follows the viewport, follow the render settings."""
    for item in scene.objects:
        item.hide_viewport = item.hide_render
    for item in bpy.context.view_layer.objects:
        item.hide_set(False)
    for item in scene.objects:
        for modifier in item.modifiers:
            modifier.show_viewport = modifier.show_render
            if hasattr(modifier, "render_levels"):
                modifier.levels = modifier.render_levels
    for collection in bpy.data.collections:
        collection.hide_viewport = collection.hide_render
    for layer in _layers(bpy.context.view_layer.layer_collection):
        layer.hide_viewport = False
    bpy.context.view_layer.update()


def _layers(root: Any) -> Iterator[Any]:
    yield root
    for child in root.children:
        yield from _layers(child)


def _copied(bpy: Any, instance: Any, depsgraph: Any) -> Any:
    """Data of an evaluated object for the new scene; None if it has no surface."""
    item = instance.object
    if item.type == "LIGHT":
        return item.original.data.copy()
    if item.type == "MESH" and instance.is_instance:
        # What geometry nodes make stands in for an object and is known by its data alone.
        mesh = item.data.copy()
    else:
        mesh = bpy.data.meshes.new_from_object(
            item, preserve_all_data_layers=True, depsgraph=depsgraph
        )
    if not len(mesh.polygons):
        bpy.data.meshes.remove(mesh)
        return None
    _use_original_materials(mesh, item)
    mesh.calc_loop_triangles()
    return mesh


def _use_original_materials(mesh: Any, item: Any) -> None:
    """Give a mesh the file's own materials; they may hang on the object instead."""
    slots = [slot.material for slot in item.material_slots]
    for index in range(len(slots), len(mesh.materials)):
        slots.append(mesh.materials[index])
    for index, material in enumerate(slots):
        original = None if material is None else material.original
        if index < len(mesh.materials):
            mesh.materials[index] = original
        else:
            mesh.materials.append(original)


def _unused(scene: Any, bodies: list[Body], shown: set[str]) -> Iterator[str]:
    """One line for each object that does not show."""
    used = {body.name for body in bodies}
    for item in scene.objects:
        kind = item.type.lower()
        if any(system.settings.type == "HAIR" for system in item.particle_systems):
            yield f"{kind} {item.name!r}: its hair is left out"
        if item.name in used or item.type in SILENT:
            continue
        if item.type == "EMPTY":
            if not item.children and item.instance_collection is None:
                yield f"empty {item.name!r}: nothing to see; left out"
        elif item.name not in shown:
            yield f"{kind} {item.name!r}: hidden from rendering; left out itself"
        elif item.type in SOLID:
            yield f"{kind} {item.name!r}: has no surface; left out"
        else:
            yield f"{kind} {item.name!r}: neither mesh, curve nor text; left out"


def triangles_of(bodies: list[Body]) -> Triangles:
    """All triangles, in the units of the file; the owner is the place in ``bodies``."""
    corners, owners = [np.zeros((0, 3, 3))], [np.zeros(0, dtype=np.int64)]
    for number, body in enumerate(bodies):
        if not body.is_light:
            local = _mesh_corners(body.data)
            placed = local @ body.matrix[:3, :3].T + body.matrix[:3, 3]
            if np.linalg.det(body.matrix[:3, :3]) < 0.0:
                placed = placed[:, ::-1]  # mirrored: keep looking outward
            corners.append(placed)
            owners.append(np.full(len(placed), number))
    return Triangles(np.concatenate(corners), np.concatenate(owners))


def _mesh_corners(mesh: Any) -> NDArray[np.float64]:
    """Corners (t, 3, 3) of a mesh's triangles."""
    place = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", place)
    index = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
    mesh.loop_triangles.foreach_get("vertices", index)
    corners: NDArray[np.float64] = place.reshape(-1, 3).astype(float)[index.reshape(-1, 3)]
    return corners


# ---- the new scene --------------------------------------------------------------------------


def plain_scene(bpy: Any, old: Any, bodies: list[Body], frame: NDArray[np.float64]) -> Any:
    """A scene of the bodies alone, moved by ``frame`` (4, 4); all else is removed."""
    from mathutils import Matrix

    scale = float(np.cbrt(np.linalg.det(frame[:3, :3])))
    made = bpy.data.scenes.new("imported")
    made.world = old.world
    for light in {body.data.name: body.data for body in bodies if body.is_light}.values():
        _scale_light(light, scale)
    kept = []
    for body in bodies:
        item = bpy.data.objects.new(body.name, body.data)
        _place(item, Matrix(frame @ body.matrix))
        for flag, value in zip(SEEN_BY, body.seen_by, strict=True):
            setattr(item, flag, value)
        made.collection.objects.link(item)
        kept.append(item)
    _remove_all_but(bpy, made, kept)
    return made


def _place(item: Any, matrix: Any) -> None:
    """Put an object where a matrix says, also one that shears."""
    item.matrix_basis = matrix
    wrong = np.abs(np.array(item.matrix_basis) - np.array(matrix)).max()
    if wrong > 1e-5 * max(1.0, np.abs(np.array(matrix)).max()) and item.type == "MESH":
        item.data = item.data.copy()
        item.data.transform(matrix)
        item.matrix_basis.identity()


def _scale_light(light: Any, scale: float) -> None:
    """As much light on surfaces that are nearer by ``scale`` takes its square of the power."""
    if light.type != "SUN":
        light.energy *= scale**2
        if hasattr(light, "shadow_soft_size"):
            light.shadow_soft_size *= scale


def _remove_all_but(bpy: Any, scene: Any, kept: list[Any]) -> None:
    """Remove the other scenes and objects, and then what nothing uses."""
    bpy.context.window.scene = scene
    bpy.data.batch_remove([other for other in bpy.data.scenes if other != scene])
    names = {item.name for item in kept}
    bpy.data.batch_remove([item for item in bpy.data.objects if item.name not in names])
    bpy.data.batch_remove(list(bpy.data.collections))
    for _, block in all_data(bpy):
        if hasattr(block, "use_fake_user") and block.id_type not in ("SCENE", "WORKSPACE"):
            block.use_fake_user = False
    bpy.data.orphans_purge(do_local_ids=True, do_linked_ids=True, do_recursive=True)


# ---- light ----------------------------------------------------------------------------------


def sources_of_light(bpy: Any, scene: Any) -> set[str]:
    """What lights a scene: 'lamps' (lights, glowing surfaces), 'sun', 'sky' (its world)."""
    found = set()
    for light in bpy.data.lights:
        if light.users and light.energy > 0.0:
            found.add("sun" if light.type == "SUN" else "lamps")
    if any(glows(material) for material in bpy.data.materials if material.users):
        found.add("lamps")
    if scene.world is not None and glows(scene.world):
        found.add("sky")
    return found


def glows(block: Any) -> bool:
    """Whether a material or world sends out light."""
    tree = block.node_tree
    if tree is None:
        return hasattr(block, "color") and any(value > 0.0 for value in block.color)
    return any(
        _is_on(node, "Color", "Strength")
        if node.type in ("EMISSION", "BACKGROUND")
        else node.type == "BSDF_PRINCIPLED" and _is_on(node, "Emission Color", "Emission Strength")
        for node in tree.nodes
    )


def _is_on(node: Any, colour: str, strength: str) -> bool:
    """Whether both inputs are linked or above zero."""
    tint, power = node.inputs[colour], node.inputs[strength]
    bright = tint.is_linked or max(list(tint.default_value)[:3]) > 0.0
    return bool(bright and (power.is_linked or power.default_value > 0.0))
