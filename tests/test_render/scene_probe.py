"""A scene that is not ours, traced and from baked light, by Blender in a process of its own.

``python scene_probe.py FOLDER`` stores FOLDER/scene.npz. Two rooms of 3 m x 3 m share floor
and ceiling; between them stands a wall that is a single plane. The second is a hundred
times as dark.
"""

from __future__ import annotations

import hashlib
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
from scene_makers import add, box, paint

from dataset.camera import FisheyeCamera
from render.blender import add_camera, empty_scene
from render.cycles import FrameSource, configure, luminance, select_device
from render.libraries import load_bpy
from render.lit_materials import is_matte
from render.open_image_denoise import Denoiser
from render.own_scene import open_own_scene
from render.presets import PRESETS, Bake, Preset
from render.scene_atlas import lay_out_scene
from render.scene_baking import BakedScene, traced_rest
from render.scene_cutting import cut_at_walls
from render.scene_files import save_blend
from render.scene_surfaces import read_surfaces
from scenes.apartment import Apartment
from scenes.errors import SceneError

HEIGHT, HALF = 2.4, 1.5
CAMERA = FisheyeCamera().resized(96)
POSES = {"bright": np.array([-1.2, 0.17, 0.0]), "dark": np.array([1.2, 0.17, 0.0])}
SETTINGS = Bake(16, 0.04, 0.06, 0.08, 0.05)


def build(bpy: Any) -> None:
    empty_scene(bpy)
    west, east, south, north = -2 * HALF, 2 * HALF, -HALF, HALF
    ring = [(west, south), (east, south), (east, north), (west, north)]
    add(bpy, "floor", [(*p, 0.0) for p in ring], [(0, 1, 2, 3)])
    ceiling = add(bpy, "ceiling", [(*p, HEIGHT) for p in ring], [(0, 1, 2, 3)])
    paint(bpy, ceiling, (0.8, 0.8, 0.8))
    ends = [*zip(ring, ring[1:] + ring[:1], strict=True), ((0.0, south), (0.0, north))]
    for k, (a, b) in enumerate(ends):
        corners = [(*a, 0.0), (*b, 0.0), (*b, HEIGHT), (*a, HEIGHT)]
        paint(bpy, add(bpy, f"wall {k}", corners, [(0, 1, 2, 3)]), (0.7, 0.6, 0.5))
    for x in (-1.0, 1.0):
        group_paint(bpy, box(bpy, "crate", (x - 0.2, 0.8, 0.0), (x + 0.2, 1.2, 0.5)))
        turned = box(bpy, "turned", (-0.2, -0.2, 0.0), (0.2, 0.2, 0.8))
        turned.location, turned.rotation_euler, turned.scale = (
            (2 * x, -0.9, 0),
            (0, 0, 0.5),
            (-1, 1, 1),
        )
        shader = paint(bpy, turned, (0.5, 0.1, 0.1)).node_tree.nodes["Principled BSDF"]
        shader.inputs["Metallic"].default_value = 0.3
        shader.inputs["Roughness"].default_value = 0.4
        pane = box(bpy, "pane", (x - 0.3, -0.5, 1.2), (x + 0.3, -0.48, 1.8))
        glass = paint(bpy, pane, (1.0, 1.0, 1.0)).node_tree.nodes["Principled BSDF"]
        glass.inputs["Transmission Weight"].default_value = 1.0
        glass.inputs["Roughness"].default_value = 0.0
        light = bpy.data.objects.new("bulb", bpy.data.lights.new("bulb", "POINT"))
        light.data.energy, light.data.shadow_soft_size = 50.0 if x < 0 else 0.5, 0.1
        light.location = (2.2 * x, 0.7, 1.9)
        bpy.context.scene.collection.objects.link(light)


def group_paint(bpy: Any, item: Any) -> None:
    """A material whose diffuse shader is in a group, and mixed with a mirror."""
    group = bpy.data.node_groups.new("wood", "ShaderNodeTree")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    diffuse = group.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (0.2, 0.4, 0.2, 1.0)
    group.links.new(diffuse.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    tree = paint(bpy, item, (0.0, 0.0, 0.0)).node_tree
    outer, mix = tree.nodes.new("ShaderNodeGroup"), tree.nodes.new("ShaderNodeMixShader")
    outer.node_tree, mix.inputs[0].default_value = group, 0.2
    mirror = tree.nodes.new("ShaderNodeBsdfAnisotropic")
    mirror.inputs["Roughness"].default_value = 0.1
    tree.links.new(outer.outputs[0], mix.inputs[1])
    tree.links.new(mirror.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])


def apartment_of(path: Path) -> Apartment:
    """Two bare rooms whose scene is that file."""
    walls = [(-HALF, HALF), (-HALF, -HALF), (HALF, -HALF), (HALF, HALF)]
    rooms = [[(x + s * HALF, y) for x, y in walls] for s in (-1, 1)]
    return Apartment.model_validate(
        {
            "name": "two",
            "rooms": [{"name": str(k), "polygon": room} for k, room in enumerate(rooms)],
            "lighting": {"source": "exterior", "sun_strength": 0.0, "sky_strength": 0.0},
            "start": {"position": (-1.0, 0.0)},
            "scene_file": {
                "file": path.name,
                "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
            },
        }
    )


def saved(bpy: Any, folder: Path, name: str) -> Apartment:
    save_blend(bpy, str(folder / name))
    return apartment_of(folder / name)


def views(bpy: Any, scene: Any, preset: Preset, denoiser: Denoiser | None) -> dict[str, np.ndarray]:
    add_camera(bpy, scene, CAMERA)
    configure(scene, preset, threads=2, glass=True)
    select_device(bpy, scene, "cpu")
    source = FrameSource(bpy, scene, CAMERA, denoiser=denoiser)
    return {name: luminance(source.colour(pose)) for name, pose in POSES.items()}


def rendered(bpy: Any, folder: Path) -> dict[str, np.ndarray]:
    """Both rooms, traced and from baked light, and what the scene was laid out as."""
    build(bpy)
    apartment = saved(bpy, folder, "two-1.blend")
    scene = open_own_scene(bpy, apartment, folder)
    traced = views(bpy, scene, Preset("probe", samples=64), None)
    baked = BakedScene(bpy, apartment, folder, SETTINGS)
    matte = {m.name.split(".")[0]: is_matte(m) for m in bpy.data.materials}
    scene = baked.show(baked.bake(threads=2, device="cpu"))
    shown = views(bpy, scene, traced_rest(PRESETS["fast"]), Denoiser(bpy, 2))
    return {
        **{f"traced_{name}": image for name, image in traced.items()},
        **{f"baked_{name}": image for name, image in shown.items()},
        "matte": np.array([name for name, is_so in matte.items() if is_so]),
        "not_matte": np.array([name for name, is_so in matte.items() if not is_so]),
    }


def pieces(bpy: Any) -> dict[str, np.ndarray]:
    """How many pieces there are of a few shapes, and in a few scenes the texels of each side."""
    empty_scene(bpy)
    square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    shapes = {
        "cube": box(bpy, "cube", (0, 0, 0), (1, 1, 1)),
        # Two squares side by side in one plane, without a common vertex.
        "row": add(
            bpy,
            "row",
            [(x, y, 0.0) for x, y in square] + [(x + 1.0, 1.5 * y - 0.2, 0.0) for x, y in square],
            [(0, 1, 2, 3), (4, 5, 6, 7)],
        ),
        # A floor and a ceiling that share nothing.
        "apart": add(
            bpy,
            "apart",
            [(x, y, z) for z in (0.0, 2.0) for x, y in square],
            [(0, 1, 2, 3), (4, 5, 6, 7)],
        ),
        "mirrored": box(bpy, "mirrored", (0, 0, 0), (1, 1, 1)),
    }
    shapes["mirrored"].scale = (-1, 1, 1)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24)
    shapes["ball"] = bpy.context.object
    bpy.context.view_layer.update()
    found = {}
    for name, item in shapes.items():
        surfaces = read_surfaces([(item, np.ones(len(item.data.polygons), dtype=bool))])
        found[f"pieces_{name}"] = np.array(len(surfaces.facing))
        corners = surfaces.points[surfaces.triangles]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        middle = surfaces.points.mean(axis=0)
        outward = np.einsum("ti,ti->t", across, corners.mean(axis=1) - middle)
        found[f"outward_{name}"] = outward
        facing = surfaces.facing[surfaces.piece[surfaces.triangles[:, 0]]]
        found[f"facing_{name}"] = np.einsum("ti,ti->t", across, facing)
        if name == "cube":
            met = np.zeros((6, 2))
            met[:, 0] = 1000.0
            atlas = lay_out_scene(surfaces, met, SETTINGS)
            found |= {"cube_boxes": atlas.boxes, "cube_uv": atlas.uv, "cube_shape": atlas.shape}
            found["cube_receivers"] = atlas.receiver_corners
    return {key: np.asarray(value) for key, value in found.items()}


def cuts(bpy: Any) -> dict[str, np.ndarray]:
    """A floor of 2 m x 2 m cut at a wall over half of it, and at one over all of it."""
    found = {}
    for name, end in (("cut", 1.0), ("walled", 2.0)):
        empty_scene(bpy)
        ring = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]
        floor = add(bpy, "floor", ring, [(0, 1, 2, 3)])
        corners = [(1, 0, 0), (1, end, 0), (1, end, 2), (1, 0, 2)]
        wall = add(bpy, "wall", corners, [(0, 1, 2, 3)])
        bpy.context.view_layer.update()
        cut_at_walls([floor, wall])
        items = [(item, np.ones(len(item.data.polygons), dtype=bool)) for item in (floor, wall)]
        surfaces = read_surfaces(items)
        found[f"{name}_areas"] = np.array([polygon.area for polygon in floor.data.polygons])
        found[f"{name}_pieces"] = np.array((surfaces.facing[:, 2] != 0.0).sum())
    return found


def refused(bpy: Any, folder: Path) -> str:
    """What is said of a scene of glass."""
    empty_scene(bpy)
    pane = box(bpy, "pane", (-1, -1, -0.1), (1, 1, 0.0))
    glass = paint(bpy, pane, (1.0, 1.0, 1.0)).node_tree.nodes["Principled BSDF"]
    glass.inputs["Transmission Weight"].default_value = 1.0
    try:
        BakedScene(bpy, saved(bpy, folder, "glass-1.blend"), folder, SETTINGS)
    except SceneError as error:
        return str(error)
    return "nothing was said"


def main() -> None:
    bpy, folder = load_bpy(), Path(sys.argv[1])
    found = {**rendered(bpy, folder), **pieces(bpy), **cuts(bpy)}
    found["refused"] = np.array(refused(bpy, folder))
    np.savez(folder / "scene.npz", **found)
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
