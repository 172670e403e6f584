"""Baked light for a scene of any make (`render.own_scene`), and the scene that shows it.

The same two steps as in `render.baking`; what differs is that nothing is known of the
scene. Every side of every matte surface gathers light, where it is needed
(`render.scene_survey`); what no light reaches lies within something, and what it would
darken at its rim is taken from beside it.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

from render.baking import COARSE, FIRST, gather, quiet
from render.blender import float_image
from render.cycles import Device, configure, select_device
from render.lit_materials import BACK, FRONT, is_matte, lit_copy, plain_material
from render.open_image_denoise import Denoiser
from render.own_scene import open_own_scene
from render.presets import Bake, Preset
from render.scene_atlas import SceneAtlas, lay_out_scene
from render.scene_cutting import cut_at_walls
from render.scene_surfaces import Surfaces, read_surfaces
from render.scene_survey import survey
from scenes.apartment import Apartment
from scenes.errors import SceneError

__all__ = ["BakedScene", "traced_rest"]

MOST_POLYGONS = 1_000_000
"""The largest meshes beyond that are traced."""
BURIED = 1e-4
"""What is darker than that share of the mean lies in something."""
CORE = 3
"""So many texels in a row and column must be that dark."""
RIM = 1
"""Texels about them that are darker than they should be."""
ASIDE = 0.05
"""How far in front of a chart its surroundings are, m: its back is not next to it."""
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Picture = NDArray[np.float32]


def traced_rest(preset: Preset) -> Preset:
    """The preset as it traces what is not baked: all glass, and light that scatters once."""
    return replace(preset, max_bounces=8, diffuse_bounces=1, glossy_bounces=4)


class BakedScene:
    """An apartment's own scene, opened, and where the light of its surfaces is kept.

    Parameters
    ----------
    bpy : module
    apartment : Apartment
    folder : path
        Where its scene file is.
    settings : Bake

    Attributes
    ----------
    scene : bpy.types.Scene
    atlas : SceneAtlas

    Raises
    ------
    SceneError
        If the scene file cannot be used, or nothing in it is matte.
    """

    def __init__(self, bpy: Any, apartment: Apartment, folder: str | Path, settings: Bake) -> None:
        self._bpy, self._apartment, self._folder = bpy, apartment, folder
        self._settings = settings
        self._open()
        self._met = survey(self._surfaces, apartment)
        self.atlas = lay_out_scene(self._surfaces, self._met, settings)

    def _open(self) -> None:
        self.scene = open_own_scene(self._bpy, self._apartment, self._folder)
        self._surfaces = _matte_surfaces(self._bpy, self.scene)
        if not len(self._surfaces.triangles):
            assert self._apartment.scene_file is not None
            raise SceneError(
                f"{self._apartment.scene_file.file}: nothing in it is matte, there is no light to "
                f"bake; expected the preset 'reference'"
            )

    def bake(self, threads: int | None = None, device: Device = "auto") -> Picture:
        """Radiance (rows, columns, 3) of white matte surfaces, all over the atlas.

        The scene is then as it was: without baked light.
        """
        denoiser = Denoiser(self._bpy, threads)

        def lit(atlas: SceneAtlas, preset: Preset) -> Picture:
            configure(self.scene, preset, threads, glass=True)
            select_device(self._bpy, self.scene, device)
            raw, covered = gather(self._bpy, self.scene, atlas)
            usable = covered & ~_darkened(raw, covered)
            return quiet(denoiser, *_with_all_charts(raw, usable, covered, atlas), atlas)

        coarse = lay_out_scene(self._surfaces, self._met, self._settings.scaled(COARSE))
        first = lit(coarse, FIRST)
        self._open()
        self._show(coarse, first)
        second = traced_rest(Preset("second bake", self._settings.samples))
        light = lit(self.atlas, second)
        self._open()
        return light

    def show(self, light: Picture) -> Any:
        """Let the scene shine with its baked light, and return it."""
        self._show(self.atlas, light)
        return self.scene

    def _show(self, atlas: SceneAtlas, light: Picture) -> None:
        image = float_image(self._bpy, "light", light)
        surfaces, uv = self._surfaces, atlas.scaled_uv
        for item, low, high in zip(
            surfaces.objects, surfaces.starts[:-1], surfaces.starts[1:], strict=True
        ):
            for name, places in ((FRONT, uv[0]), (BACK, uv[1])):
                layer = item.data.attributes.new(name, "FLOAT_VECTOR", "CORNER")
                values = np.zeros((high - low, 3), dtype=np.float32)
                values[:, :2] = places[low:high]
                layer.data.foreach_set("vector", values.ravel())
        shining: dict[str, Any] = {}
        for item in surfaces.objects:
            for index, material in enumerate(item.data.materials):
                if is_matte(material):
                    if material.name not in shining:
                        shining[material.name] = lit_copy(material, image)
                    item.data.materials[index] = shining[material.name]


def _matte_surfaces(bpy: Any, scene: Any) -> Surfaces:
    """The matte surfaces of the meshes, smallest first; each has a mesh of its own then."""
    plain, taken, left = plain_material(bpy), [], MOST_POLYGONS
    meshes = [item for item in scene.objects if item.type == "MESH" and len(item.data.polygons)]
    for item in sorted(meshes, key=lambda item: len(item.data.polygons)):
        left -= len(item.data.polygons)
        if left < 0:
            break
        if item.data.users > 1:
            item.data = item.data.copy()
        slots = item.data.materials
        if not len(slots):
            slots.append(plain)
        for index, material in enumerate(slots):
            if material is None:
                slots[index] = plain
        taken.append(item)
    cut_at_walls(taken)
    return read_surfaces([(item, _matte_polygons(item)) for item in taken])


def _matte_polygons(item: Any) -> Mask:
    """Which polygons of an object have a material that is matte."""
    matte = np.array([is_matte(material) for material in item.data.materials])
    slot = np.empty(len(item.data.polygons), dtype=np.int32)
    item.data.polygons.foreach_get("material_index", slot)
    found: Mask = matte[np.clip(slot, 0, len(matte) - 1)]
    return found


def _darkened(raw: Picture, covered: Mask) -> Mask:
    """Which texels lie within something, or are half within."""
    light = raw.mean(axis=2)
    limit = BURIED * light[covered].mean() if covered.any() else 0.0
    dark = (light <= limit) & covered
    core = ndimage.binary_erosion(dark, np.ones((CORE, CORE)))
    within = ndimage.binary_dilation(core, np.ones((CORE, CORE)))
    found: Mask = ndimage.binary_dilation(within, np.ones((3, 3)), iterations=RIM) & covered
    return found


def _with_all_charts(
    raw: Picture, usable: Mask, covered: Mask, atlas: SceneAtlas
) -> tuple[Picture, Mask]:
    """Light and where it is usable, in each chart somewhere.

    A chart that lies within something altogether is dark. A sliver between all centres of
    texels takes the light of the nearest chart.
    """
    made, known = raw.copy(), usable.copy()
    slivers = []
    for chart, (row, column, rows, columns) in enumerate(atlas.boxes.tolist()):
        window = np.s_[row : row + rows, column : column + columns]
        if usable[window].any():
            continue
        if covered[window].any():
            known[window] = covered[window]
        else:
            slivers.append(chart)
    if slivers:
        middle = atlas.middles + ASIDE * atlas.normals
        lit = np.setdiff1d(np.arange(len(atlas.boxes)), slivers)
        nearest = lit[cKDTree(middle[lit]).query(middle[slivers])[1]]
        for chart, other in zip(slivers, nearest, strict=True):
            row, column, rows, columns = atlas.boxes[other]
            window = np.s_[row : row + rows, column : column + columns]
            light = raw[window][known[window]].mean(axis=0)
            row, column, rows, columns = atlas.boxes[chart]
            window = np.s_[row : row + rows, column : column + columns]
            made[window], known[window] = light, True
    return made, known
