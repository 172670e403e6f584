"""An apartment as a file that people open elsewhere: Blender (.blend) or glTF (.glb).

Everything that a person would call one thing is an object of its own, in a collection
of its kind, and furniture has its origin where it stands, so that it can be moved and
turned. The Blender file has the materials, lights and camera that `render.blender`
renders, the camera at the robot's start.

glTF knows no procedural patterns: there a surface has the mean colour of its pattern.
It knows sun and glowing bodies but no sky, nor the lights in the windows.

Blender writes addresses of its memory into its files: two exports of one apartment
show the same scene, but are not the same bytes. The bytes of a .glb are the same.
"""

from __future__ import annotations

import math
import re
import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from dataset.atomic import replacing, unwritten
from dataset.camera import FisheyeCamera
from render.blender import (
    add_camera,
    add_mesh,
    build_materials,
    empty_scene,
    place_camera,
    surface_area,
)
from render.cycles import configure
from render.lighting import add_lighting, lamp_radiance
from render.presets import preset_named
from render.scene_files import require_whole, save_blend
from render.task import run_task
from scenes.apartment import Apartment
from scenes.errors import SceneError
from scenes.materials import LAMP_PREFIX, mean_colour, resolve
from scenes.mesh import Mesh, apartment_mesh, solids_mesh
from scenes.solids import SolidGroup, solid_groups

__all__ = ["FORMATS", "perform", "write_scene"]

FORMATS = (".blend", ".glb")

GLOW_KELVIN = np.array([1000.0, 2000.0, 3000.0, 4500.0, 6500.0, 12000.0])
GLOW_RGB = np.array(
    [(1, 0.1, 0), (1, 0.27, 0.02), (1, 0.46, 0.14), (1, 0.71, 0.45), (1, 0.93, 0.96), (0.7, 0.8, 1)]
)
"""Linear colours of a black body, for what has no node that knows them."""


def write_scene(apartment: Apartment, path: str | Path) -> None:
    """Write an apartment as ``.blend`` or ``.glb``, in a child process; atomically.

    Parameters
    ----------
    apartment : Apartment
    path : path
        The suffix says which format.

    Raises
    ------
    SceneError
        If the suffix is another, or the apartment itself is rendered from a scene file.
    RoomsegError
        If the file cannot be written, or Blender fails.
    """
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise SceneError(f"{path}: unknown suffix; expected {' or '.join(FORMATS)}")
    if apartment.scene_file is not None:
        raise SceneError(
            f"{apartment.name}: its 3D scene is {apartment.scene_file.file} already; "
            "expected an apartment without a scene_file"
        )
    with tempfile.TemporaryDirectory() as folder:
        # Blender minds the suffix, so it does not write to the part itself.
        file = Path(folder) / f"scene{path.suffix.lower()}"
        try:
            run_task("scene_export", apartment=apartment.model_dump(mode="json"), output=str(file))
            require_whole(file)
            with replacing(path) as part:
                shutil.copyfile(file, part)
        except OSError as error:
            raise unwritten(path, error) from None


def perform(bpy: Any, *, apartment: dict[str, Any], output: str) -> dict[str, Any]:
    """Build the scene and write it; see `write_scene`. There is nothing to answer."""
    plain = output.endswith(".glb")
    _build(bpy, Apartment.model_validate(apartment), plain=plain)
    try:
        if plain:
            bpy.ops.export_scene.gltf(
                filepath=output, export_format="GLB", export_lights=True, export_texcoords=False
            )
        else:
            save_blend(bpy, output)
    except RuntimeError as error:
        # Blender makes one of any error of its add-ons.
        if (failure := re.search(r"^OSError: (?:\[Errno \d+\] )?(.*)$", str(error), re.M)) is None:
            raise
        raise OSError(failure[1]) from None
    return {}


def _build(bpy: Any, apartment: Apartment, *, plain: bool) -> None:
    """The scene, one object per solid group."""
    scene = empty_scene(bpy)
    scene.name = apartment.name
    whole = apartment_mesh(apartment)
    if plain:
        made = [
            _plain_material(bpy, apartment, whole, slot) for slot in range(len(whole.materials))
        ]
    else:
        made = build_materials(bpy, apartment, whole)
    materials = dict(zip(whole.materials, made, strict=True))
    for group in solid_groups(apartment):
        shape = solids_mesh(apartment, group.prisms)
        body = add_mesh(bpy, scene, shape, [materials[n] for n in shape.materials], group.name)
        _take_hold(body, group)
        _move(bpy, scene, body, group.collection)
    add_lighting(bpy, scene, apartment)
    for light in [item for item in scene.collection.objects if item.type == "LIGHT"]:
        if plain and light.data.type == "AREA":
            bpy.data.objects.remove(light)  # glTF has no area lights
        else:
            _move(bpy, scene, light, "lights")
    if not plain:
        _add_robot_camera(bpy, scene, apartment)


def _take_hold(body: Any, group: SolidGroup) -> None:
    """Give an object its origin and turn, without moving its surface."""
    x, y, turn = group.pose
    body.location = (x, y, 0.0)
    body.rotation_euler = (0.0, 0.0, math.radians(turn))
    body.data.transform(body.matrix_basis.inverted())


def _move(bpy: Any, scene: Any, item: Any, name: str) -> None:
    """Move an object of the scene into the collection ``name``."""
    home = bpy.data.collections.get(name)
    if home is None:
        home = bpy.data.collections.new(name)
        scene.collection.children.link(home)
    home.objects.link(item)
    scene.collection.objects.unlink(item)


def _add_robot_camera(bpy: Any, scene: Any, apartment: Apartment) -> None:
    """The robot's camera where the run begins, and the settings of the reference preset."""
    camera = FisheyeCamera()
    start = apartment.start
    made = add_camera(bpy, scene, camera)
    pose = np.array([*start.position, math.radians(start.heading_deg)])
    place_camera(made, pose, camera.height)
    configure(scene, preset_named("reference"))
    scene.render.threads_mode = "AUTO"


# ---- plain materials ------------------------------------------------------------------------


def _plain_material(bpy: Any, apartment: Apartment, mesh: Mesh, slot: int) -> Any:
    """One Principled shader, which is all that glTF can say of a surface."""
    name = mesh.materials[slot]
    made = bpy.data.materials.new(name)
    if made.node_tree is None:
        made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    surface = resolve(apartment, name)
    shader.inputs["Base Color"].default_value = (*mean_colour(surface), 1.0)
    shader.inputs["Roughness"].default_value = surface.roughness
    shader.inputs["Metallic"].default_value = 1.0 if surface.pattern == "metal" else 0.0
    if name.startswith(LAMP_PREFIX):
        lamp = int(name.removeprefix(LAMP_PREFIX))
        area = surface_area(mesh, slot)
        kelvin = apartment.lamps[lamp].temperature
        glow = [float(np.interp(kelvin, GLOW_KELVIN, GLOW_RGB[:, k])) for k in range(3)]
        shader.inputs["Emission Color"].default_value = (*glow, 1.0)
        shader.inputs["Emission Strength"].default_value = lamp_radiance(apartment, lamp, area)
    return made
