"""The diffuse light of an apartment, baked once by Cycles into one picture.

A *bake* holds, for every texel of `render.charts`, the radiance that a white matte
surface would have there. It is made twice. First coarsely, by path tracing in the very
scene that the path-traced presets render, and denoised. Then finely: the apartment shows
the coarse bake, and every texel gathers what it sees and the light of lamps, windows and
sun. A path of one bounce costs half as much as a whole one and leaves half the noise, and
the errors of the first bake are averaged away.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from dataset.camera import SIMULATED_CAMERA
from render.baked_scene import build_baked_scene
from render.blender import add_layer, add_mesh, build_scene
from render.charts import Atlas, Sheet, lay_out
from render.cycles import Device, configure, select_device
from render.denoising import continued, denoise
from render.open_image_denoise import Denoiser
from render.presets import Bake, Preset
from render.shading import ATLAS, build_material
from scenes.apartment import Apartment, Material, Passage, Window
from scenes.mesh import Mesh, apartment_mesh
from scenes.openings import place
from scenes.solids import apartment_solids, cutter, rooms_region

__all__ = ["COARSE", "FIRST", "bake", "gather", "lay_out_apartment", "quiet"]

COARSE = 2.0
"""Texels of the first bake, in texels of the second."""
FIRST = Preset("first bake", samples=32, diffuse_bounces=3)
"""One bounce less than `reference`: the second bake adds it."""
EYE_LEVEL = 0.3
"""No robot's camera is higher, m: what looks up above it is seen in reflections only."""
UNSEEN = 5.0
"""Texels of that, in texels of uprights."""
OUTSIDE = 20.0
"""Texels outdoors, in texels of uprights."""
FRAME_REACH = 0.15
"""How far frames reach beside a passage, m."""
WITHIN = 2e-3
"""What lies deeper in a wall than its face, m."""
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Picture = NDArray[np.float32]
White = Material(colour=(1.0, 1.0, 1.0), roughness=1.0)


def lay_out_apartment(apartment: Apartment, settings: Bake) -> Atlas:
    """The charts of the mesh of `scenes.mesh.apartment_mesh`."""
    mesh = apartment_mesh(apartment)
    texel = _needed_texels(apartment, mesh, settings)
    return lay_out(mesh, apartment_solids(apartment), texel)


def bake(
    bpy: Any,
    apartment: Apartment,
    settings: Bake,
    *,
    threads: int | None = None,
    device: Device = "auto",
) -> Picture:
    """Radiance (rows, columns, 3) of white matte surfaces all over the apartment's atlas.

    The Blender scene is lost.
    """
    denoiser = Denoiser(bpy, threads)

    def lit(scene: Any, atlas: Atlas, preset: Preset) -> Picture:
        configure(scene, preset, threads)
        select_device(bpy, scene, device)
        return quiet(denoiser, *gather(bpy, scene, atlas), atlas)

    coarse = lay_out_apartment(apartment, settings.scaled(COARSE))
    first = lit(build_scene(bpy, apartment, SIMULATED_CAMERA), coarse, FIRST)
    scene = build_baked_scene(bpy, apartment, SIMULATED_CAMERA, coarse, first)
    second = Preset("second bake", settings.samples, max_bounces=3, diffuse_bounces=1)
    return lit(scene, lay_out_apartment(apartment, settings), second)


def quiet(denoiser: Denoiser, raw: Picture, covered: Mask, atlas: Sheet) -> Picture:
    """What `gather` found, denoised, and with light in all texels."""
    noise = continued(raw, covered, atlas.boxes, np.random.default_rng(0))
    clean = denoise(denoiser, noise, atlas)
    return continued(clean, covered, atlas.boxes)


def _needed_texels(apartment: Apartment, mesh: Mesh, settings: Bake) -> Floats:
    """Side of a texel that each triangle needs, m, shape (t,)."""
    corners = mesh.vertices[mesh.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-15)
    texel = np.full(len(corners), settings.upright)
    texel[normal[:, 2] < -0.7] = settings.overhead
    upward = normal[:, 2] > 0.7
    texel[upward] = settings.floor
    texel[upward & (corners[..., 2].min(axis=1) > EYE_LEVEL)] = UNSEEN * settings.upright
    texel[_at_passages(apartment, corners) & ~upward] = settings.opening
    middle = corners.mean(axis=1)
    # Reveals and sills are bright before the window's frame and dim behind it.
    texel[_in_windows(apartment, middle)] = settings.opening
    outside = ~_indoors(apartment, middle + 0.02 * normal)
    texel[outside] = OUTSIDE * settings.upright
    return texel


def _at_passages(apartment: Apartment, corners: Floats) -> NDArray[np.bool_]:
    """Which triangles (t, 3, 3) are reveals, lintels and frames of passages."""
    places = [place(apartment, item.position, item.width) for item in apartment.passages]
    around = shapely.union_all([cutter(opening, FRAME_REACH) for opening in places])
    found: NDArray[np.bool_] = _within(around, corners).all(axis=1)
    return found


def _in_windows(apartment: Apartment, points: Floats) -> NDArray[np.bool_]:
    """Which points (t, 3) lie between a window's wall faces."""
    found = []
    for window in apartment.windows:
        opening = place(apartment, window.position, window.width)
        half, depth = 0.5 * opening.width + WITHIN, 0.5 * opening.thickness - WITHIN
        found.append(opening.rectangle((-half, half), (-depth, depth)))
    return _within(shapely.union_all(found), points)


def _within(shape: shapely.Geometry, points: Floats) -> NDArray[np.bool_]:
    """Which points (..., 3) lie over ``shape``."""
    shapely.prepare(shape)
    found: NDArray[np.bool_] = shapely.intersects_xy(shape, points[..., 0], points[..., 1])
    return found


def _indoors(apartment: Apartment, points: Floats) -> NDArray[np.bool_]:
    """Whether points (n, 3) are in a room or an opening."""
    openings: tuple[Passage | Window, ...] = (*apartment.windows, *apartment.passages)
    cuts = [cutter(place(apartment, item.position, item.width)) for item in openings]
    inside = shapely.union_all([rooms_region(apartment), *cuts])
    highest = max(room.ceiling_height for room in apartment.rooms)
    over = _within(inside, points)
    found: NDArray[np.bool_] = over & (points[:, 2] > 0.0) & (points[:, 2] < highest)
    return found


def gather(bpy: Any, scene: Any, atlas: Sheet) -> tuple[Picture, Mask]:
    """What the receivers got, row 0 first, and which texels they cover."""
    rows, columns = atlas.shape
    image = bpy.data.images.new("gathered", columns, rows, alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    receivers = _add_receivers(bpy, scene, atlas, image)
    bpy.ops.object.select_all(action="DESELECT")
    receivers.select_set(True)
    bpy.context.view_layer.objects.active = receivers
    bpy.ops.object.bake(
        type="DIFFUSE",
        pass_filter={"DIRECT", "INDIRECT"},
        margin=0,
        use_clear=True,
        target="IMAGE_TEXTURES",
        uv_layer=ATLAS,
    )
    flat = np.empty(rows * columns * 4, dtype=np.float32)
    image.pixels.foreach_get(flat)
    pixels = flat.reshape(rows, columns, 4)
    return np.ascontiguousarray(pixels[..., :3]), pixels[..., 3] > 0.5


def _add_receivers(bpy: Any, scene: Any, atlas: Sheet, image: Any) -> Any:
    """An object of the receivers that no ray meets, white and matte."""
    corners = atlas.receiver_corners
    index = np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
    slots = np.zeros(len(corners), dtype=np.int32)
    shape = Mesh(corners.reshape(-1, 3), index, slots, ("white",))
    white = build_material(bpy, "white", White)
    target = white.node_tree.nodes.new("ShaderNodeTexImage")
    target.image = image
    white.node_tree.nodes.active = target
    made = add_mesh(bpy, scene, shape, [white], "receivers")
    add_layer(made.data, ATLAS, atlas.scaled_receiver_uv)
    if atlas.receiver_normals is not None:
        made.data.shade_smooth()
        made.data.normals_split_custom_set(atlas.receiver_normals.reshape(-1, 3))
    # An object that no kind of ray sees is left out; there are no volumes here.
    for kind in ("camera", "diffuse", "glossy", "transmission", "shadow"):
        setattr(made, f"visible_{kind}", False)
    return made
