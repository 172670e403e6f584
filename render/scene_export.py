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
import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from dataset.atomic import replacing
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
from render.task import run_task
from scenes.apartment import Apartment, Colour, Material
from scenes.errors import SceneError
from scenes.materials import LAMP_PREFIX, resolve
from scenes.mesh import Mesh, apartment_mesh, solids_mesh
from scenes.solids import SolidGroup, solid_groups

__all__ = ["FORMATS", "mean_colour", "perform", "write_scene"]

FORMATS = (".blend", ".glb")

SECOND_SHARE = {
    "plaster": 0.5,
    "wallpaper": 0.5,
    "parquet": 0.25,
    "planks": 0.25,
    "tiles": 0.04,
    "carpet": 0.5,
    "wood": 0.5,
    "fabric": 0.5,
}
"""Share of a surface that has the second colour, by pattern, as `render.shading` draws it."""

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
        If Blender fails or the file cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise SceneError(f"{path}: unknown suffix; expected {' or '.join(FORMATS)}")
    if apartment.scene_file is not None:
        raise SceneError(
            f"{apartment.name}: its 3D scene is {apartment.scene_file.file} already; "
            "expected an apartment without a scene_file"
        )
    run_task(
        "scene_export",
        apartment=apartment.model_dump(mode="json"),
        output=str(path.resolve()),
    )


def perform(bpy: Any, *, apartment: dict[str, Any], output: str) -> dict[str, Any]:
    """Build the scene and write it; see `write_scene`.

    Returns
    -------
    dict
        ``objects``: how many mesh objects there are.
    """
    place = Apartment.model_validate(apartment)
    target = Path(output)
    plain = target.suffix.lower() == ".glb"
    count = _build(bpy, place, plain=plain)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"scene{target.suffix.lower()}"
        _save(bpy, file)
        try:
            with replacing(target) as part:
                shutil.copyfile(file, part)
        except OSError as error:
            raise SceneError(f"{target}: cannot be written: {error.strerror or error}") from None
    return {"objects": count}


def _save(bpy: Any, file: Path) -> None:
    if file.suffix == ".blend":
        bpy.ops.wm.save_as_mainfile(filepath=str(file), compress=True)
        return
    bpy.ops.export_scene.gltf(
        filepath=str(file), export_format="GLB", export_lights=True, export_texcoords=False
    )


def _build(bpy: Any, apartment: Apartment, *, plain: bool) -> int:
    """The scene, one object per solid group; returns how many."""
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
    groups = solid_groups(apartment)
    for group in groups:
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
    return len(groups)


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


def mean_colour(material: Material) -> Colour:
    """Mean colour of a pattern, linear."""
    share = SECOND_SHARE.get(material.pattern, 0.0) if material.second_colour else 0.0
    second = material.second_colour or material.colour
    red, green, blue = (
        (1.0 - share) * a + share * b for a, b in zip(material.colour, second, strict=True)
    )
    return (red, green, blue)


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
