"""Rendering an apartment that has a 3D scene of its own.

Its objects, lights and world stay as they are; how its file would render them does not
count. The apartment's lamps, sun and sky come on top of them; the importer leaves them
dark for a scene that is lit. The sky does light here: nobody knows where the windows of
a foreign scene are.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from render.blender import add_mesh, build_materials, empty_scene
from render.lighting import add_outdoor_light
from render.scene_cleaning import open_blend, remove_scripts, settle_images
from render.scene_evaluation import sources_of_light
from render.scene_files import inspect_scene
from scenes.apartment import Apartment
from scenes.mesh import solids_mesh
from scenes.scene_file import find_scene_file
from scenes.solids import solid_groups

__all__ = ["open_own_scene"]


def open_own_scene(bpy: Any, apartment: Apartment, folder: str | Path) -> Any:
    """Open the scene file of ``apartment`` in ``folder`` and add the apartment's light.

    Returns
    -------
    bpy.types.Scene

    Raises
    ------
    SceneError
        If the file is missing, has other content than it should, or cannot be read.
    """
    path = find_scene_file(apartment, folder).resolve()
    inspect_scene(path)
    empty_scene(bpy)
    found, _ = open_blend(bpy, path)
    remove_scripts(bpy)
    settle_images(bpy, None)
    scene = bpy.data.scenes.new("rendered")
    scene.world = found.world
    for item in found.objects:
        scene.collection.objects.link(item)
    bpy.context.window.scene = scene
    bpy.context.view_layer.update()
    prisms = [p for g in solid_groups(apartment) if g.collection == "lamps" for p in g.prisms]
    if prisms:
        shape = solids_mesh(apartment, prisms)
        add_mesh(bpy, scene, shape, build_materials(bpy, apartment, shape), "added lamps")
    add_outdoor_light(bpy, scene, apartment, sky="sky" not in sources_of_light(bpy, scene))
    return scene
