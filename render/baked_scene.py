"""An apartment that shines with its baked light; only gloss, mirrors and glass are traced."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from dataset.camera import FisheyeCamera
from render.blender import (
    add_camera,
    add_layer,
    add_mesh,
    build_materials,
    empty_scene,
    float_image,
)
from render.charts import Atlas
from render.lighting import add_lighting
from render.shading import ATLAS
from scenes.apartment import Apartment
from scenes.mesh import apartment_mesh

__all__ = ["build_baked_scene"]


def build_baked_scene(
    bpy: Any, apartment: Apartment, camera: FisheyeCamera, atlas: Atlas, light: NDArray[np.float32]
) -> Any:
    """A fresh Blender scene of ``apartment`` that shows baked light.

    Parameters
    ----------
    bpy : module
    apartment : Apartment
    camera : FisheyeCamera
    atlas : Atlas
    light : array, shape (rows, columns, 3)
        What `render.baking.bake` made for the atlas.
    """
    scene = empty_scene(bpy)
    mesh = apartment_mesh(apartment)
    image = float_image(bpy, "light", light)
    pixel = 1.0 / camera.pixels_per_radian
    made = add_mesh(bpy, scene, mesh, build_materials(bpy, apartment, mesh, image, pixel))
    add_layer(made.data, ATLAS, atlas.scaled_uv)
    add_lighting(bpy, scene, apartment, windows_gleam=True)
    add_camera(bpy, scene, camera)
    return scene
