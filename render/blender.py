"""An apartment as a Blender scene: one mesh, its materials, lights and the camera.

The camera's pose follows `dataset.camera`: it looks up, the heading points to the
right of the image (+column), and what is left of the robot comes out at the bottom
(+row). A Blender camera looks along its own -z with +y up in the image; turning it
by pi about x makes it look up with world +x to the right and world +y down, and the
turn about z by the heading does the rest.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dataset.camera import FisheyeCamera
from render.lighting import add_lighting, lamp_radiance
from render.shading import build_glow, build_material
from scenes.apartment import Apartment
from scenes.materials import LAMP_PREFIX, resolve
from scenes.mesh import Mesh, apartment_mesh

__all__ = [
    "add_camera",
    "add_layer",
    "add_mesh",
    "build_materials",
    "build_scene",
    "empty_scene",
    "float_image",
    "place_camera",
    "render_window",
    "surface_area",
    "surface_coordinates",
]


def surface_coordinates(
    vertices: NDArray[np.float64], triangles: NDArray[np.int32]
) -> NDArray[np.float64]:
    """Coordinates in metres on the surface of every triangle corner.

    Horizontal faces take (x, y); upright and slanted ones the distance along the
    horizontal tangent, and z.

    Parameters
    ----------
    vertices : array, shape (v, 3)
        m.
    triangles : array, shape (t, 3)

    Returns
    -------
    array, shape (t, 3, 2)
        m.
    """
    corners = vertices[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    level = np.abs(normal[:, 2]) > 0.7
    tangent = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)
    along = np.einsum("tci,ti->tc", corners[..., :2], tangent)
    upright = np.stack([along, corners[..., 2]], axis=-1)
    return np.where(level[:, None, None], corners[..., :2], upright)


def empty_scene(bpy: Any) -> Any:
    """Forget the start-up scene and return an empty one."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return bpy.context.scene


def add_mesh(
    bpy: Any,
    scene: Any,
    shape: Mesh,
    materials: list[Any],
    name: str = "apartment",
) -> Any:
    """One mesh object with a material slot per entry of ``materials``.

    Parameters
    ----------
    bpy : module
    scene : bpy.types.Scene
    shape : Mesh
    materials : list of bpy.types.Material
    name : str
        Of the object and its mesh.
    """
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(shape.vertices.tolist(), [], shape.triangles.tolist())
    for material in materials:
        mesh.materials.append(material)
    mesh.polygons.foreach_set("material_index", shape.material_index.astype(np.int32))
    uv = surface_coordinates(shape.vertices, shape.triangles)
    add_layer(mesh, "metres", uv)
    mesh.update()
    made = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(made)
    return made


def add_layer(mesh: Any, name: str, uv: NDArray[np.float64]) -> None:
    """Give a Blender mesh one more UV layer, (t, 3, 2)."""
    layer = mesh.uv_layers.new(name=name)
    layer.data.foreach_set("uv", np.ascontiguousarray(uv, dtype=np.float32).ravel())


def float_image(bpy: Any, name: str, values: NDArray[np.float32]) -> Any:
    """A Blender image of linear values (rows, columns, 3); row 0 is at the bottom."""
    rows, columns, _ = values.shape
    image = bpy.data.images.new(name, columns, rows, alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.ones((rows, columns, 4), dtype=np.float32)
    pixels[..., :3] = values
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    return image


def render_window(camera: FisheyeCamera) -> tuple[tuple[int, int], tuple[int, int]]:
    """The square of pixels that is rendered for ``camera``.

    Blender's fisheye fills a square about its middle. The square takes whole pixels
    of the camera image, so its middle must lie on a pixel's corner (even side) or
    centre (odd side), the same for rows and columns.

    Returns
    -------
    side : tuple of int
        (side, side), px.
    origin : tuple of int
        (row, column) of its first pixel in the camera image; may be negative.

    Raises
    ------
    ValueError
        If the disc centre is not on the half-pixel grid.
    """
    doubled = [2.0 * value for value in camera.disc_centre]
    if any(value != round(value) for value in doubled) or (doubled[0] - doubled[1]) % 2:
        raise ValueError(
            f"disc_centre: {camera.disc_centre}, expected both whole or both whole + 0.5 px"
        )
    side = math.ceil(camera.disc_diameter)
    side += (side + int(doubled[0])) % 2
    row, column = (int(value - side) // 2 for value in doubled)
    return (side, side), (row, column)


def add_camera(bpy: Any, scene: Any, camera: FisheyeCamera) -> Any:
    """The upward equidistant fisheye; the scene's resolution is set to its square."""
    (rows, columns), _ = render_window(camera)
    data = bpy.data.cameras.new("camera")
    data.type = "PANO"
    data.panorama_type = "FISHEYE_EQUIDISTANT"
    data.fisheye_fov = rows / camera.pixels_per_radian
    data.clip_start = 1e-3
    made = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(made)
    scene.camera = made
    scene.render.resolution_x = columns
    scene.render.resolution_y = rows
    scene.render.resolution_percentage = 100
    return made


def place_camera(camera_object: Any, pose: NDArray[np.float64], height: float) -> None:
    """Put the camera at ``pose``, ``height`` m above the floor.

    ``pose`` is x m, y m, heading rad and, optionally, roll (left side up) and
    pitch (front down), rad. The camera is near the floor: a tilt does not move it.
    """
    x, y, heading, roll, pitch = (*(float(value) for value in pose), 0.0, 0.0)[:5]
    camera_object.location = (x, y, height)
    # Blender turns about x first: up, then leaning to a side, then to the front, then around.
    camera_object.rotation_euler = (math.pi + roll, pitch, heading)


def surface_area(mesh: Mesh, slot: int) -> float:
    """Area of all triangles with one material, m²; a speck if there are none."""
    corners = mesh.vertices[mesh.triangles[mesh.material_index == slot]]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return max(0.5 * float(np.linalg.norm(across, axis=1).sum()), 1e-6)


def build_materials(
    bpy: Any, apartment: Apartment, mesh: Mesh, light: Any = None, pixel: float = 0.0
) -> list[Any]:
    """Blender materials of the mesh's slots; the bodies of lamps that are on glow.

    With ``light``, an image of baked light, the others show it, for a camera's pixels of so
    many rad (`render.shading`).
    """
    made = []
    for slot, name in enumerate(mesh.materials):
        if name.startswith(LAMP_PREFIX):
            lamp = int(name.removeprefix(LAMP_PREFIX))
            radiance = lamp_radiance(apartment, lamp, surface_area(mesh, slot))
            if radiance > 0.0:
                warmth = apartment.lamps[lamp].temperature
                made.append(build_glow(bpy, name, warmth, radiance))
                continue
        made.append(build_material(bpy, name, resolve(apartment, name), light, pixel))
    return made


def build_scene(bpy: Any, apartment: Apartment, camera: FisheyeCamera) -> Any:
    """A fresh Blender scene of ``apartment``, lit, with ``camera``.

    Parameters
    ----------
    bpy : module
    apartment : Apartment
    camera : FisheyeCamera

    Returns
    -------
    bpy.types.Scene
    """
    scene = empty_scene(bpy)
    mesh = apartment_mesh(apartment)
    materials = build_materials(bpy, apartment, mesh)
    add_mesh(bpy, scene, mesh, materials)
    add_lighting(bpy, scene, apartment)
    add_camera(bpy, scene, camera)
    return scene
