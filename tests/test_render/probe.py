"""Runs inside a process of its own, since bpy must not live in the test process.

``python probe.py OUT.npz`` renders small scenes and stores what came out.
"""

from __future__ import annotations

import os
import sys
from typing import Any

import numpy as np
from shapely import box

from dataset.camera import FisheyeCamera
from render.baked_scene import build_baked_scene
from render.baking import bake, lay_out_apartment
from render.blender import (
    add_camera,
    add_layer,
    add_mesh,
    build_scene,
    empty_scene,
    float_image,
)
from render.cycles import FrameSource, configure, luminance, select_device
from render.libraries import load_bpy
from render.lighting import SHARES
from render.open_image_denoise import Denoiser
from render.presets import PRESETS, Bake, Preset
from render.shading import ATLAS, build_glow, build_material
from scenes.apartment import Apartment, Material
from scenes.mesh import Mesh, prism_mesh
from scenes.solids import Prism

CAMERAS = {
    "simulated": FisheyeCamera(),
    "full_frame": FisheyeCamera(np.radians(185.0), 150.0, (170, 213), (83.5, 110.5)),
    "cropped": FisheyeCamera(np.radians(185.0), 149.3, (67, 213), (34.0, 107.0)),
    "small": FisheyeCamera().resized(96),
}
POSE = np.array([1.0, -2.0, 0.7])
POSE_IN_ROOM = np.array([0.3, -0.5, 0.7])
LEANING = np.array([*POSE, 0.05, -0.08])
"""With roll and pitch."""
MARKER_DISTANCE = 10.0
MARKER_CAMERAS = {
    "simulated": (FisheyeCamera(), 93.0),
    "real": (FisheyeCamera(np.radians(185.0), 450.0, (512, 640), (256.0, 320.0)), 90.5),
    "wide": (FisheyeCamera(np.radians(220.0), 560.0, (512, 640), (241.5, 330.5)), 105.0),
}
"""Three lenses, and the largest zenith angle of a marker, degrees. The last disc is larger
than its image and off its middle; no marker's azimuth leads out of the image."""


def boxed_room(window: tuple[float, float], source: str = "exterior") -> Apartment:
    """A bare room of 4 m x 4 m about the origin, with one window."""
    inner = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)]
    outer = [(-2.1, -2.1), (2.1, -2.1), (2.1, 2.1), (-2.1, 2.1)]
    lamp = {"kind": "ceiling", "position": (1.0, 0.0), "power": 40.0}
    return Apartment.model_validate(
        {
            "name": "box",
            "rooms": [{"name": "only", "polygon": inner}],
            "walls": [
                {"start": a, "end": b, "thickness": 0.2}
                for a, b in zip(outer, outer[1:] + outer[:1], strict=True)
            ],
            "windows": [{"position": window}],
            "lamps": [lamp],
            "lighting": {"source": source, "sun_strength": 0.0},
            "start": {"position": (0.0, 0.0)},
        }
    )


def direction_world(bpy: Any, scene: Any) -> None:
    """A world whose colour is its direction: (d + 1) / 2."""
    world = bpy.data.worlds.new("directions")
    world.use_nodes = True
    scene.world = world
    tree = world.node_tree
    tree.nodes.clear()
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    code = tree.nodes.new("ShaderNodeVectorMath")
    code.operation = "MULTIPLY_ADD"
    code.inputs[1].default_value = (0.5, 0.5, 0.5)
    code.inputs[2].default_value = (0.5, 0.5, 0.5)
    background = tree.nodes.new("ShaderNodeBackground")
    output = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(coordinates.outputs["Generated"], code.inputs[0])
    tree.links.new(code.outputs[0], background.inputs["Color"])
    tree.links.new(background.outputs[0], output.inputs["Surface"])


def directions(bpy: Any, camera: FisheyeCamera, pose: np.ndarray = POSE) -> np.ndarray:
    """Linear colours of the direction world."""
    scene = empty_scene(bpy)
    direction_world(bpy, scene)
    add_camera(bpy, scene, camera)
    configure(scene, Preset("probe", samples=8, denoise=False))
    return FrameSource(bpy, scene, camera).colour(pose)


def marker(bpy: Any, scene: Any, azimuth: float, zenith: float, camera: FisheyeCamera) -> None:
    """A small glowing octahedron seen from POSE at ``azimuth`` from the heading."""
    bearing = azimuth + POSE[2]
    direction = np.array(
        [np.sin(zenith) * np.cos(bearing), np.sin(zenith) * np.sin(bearing), np.cos(zenith)]
    )
    middle = np.array([POSE[0], POSE[1], camera.height]) + MARKER_DISTANCE * direction
    tips = np.array([s * np.eye(3)[axis] for axis in range(3) for s in (1.0, -1.0)])
    faces = [(x, y, z) for x in (0, 1) for y in (2, 3) for z in (4, 5)]
    shape = Mesh(
        middle + 0.2 * tips,
        np.array(faces, dtype=np.int32),
        np.zeros(len(faces), dtype=np.int32),
        ("glow",),
    )
    add_mesh(bpy, scene, shape, [build_glow(bpy, "glow", 6500.0, 1.0)])


def markers(bpy: Any) -> dict[str, np.ndarray]:
    """Twenty markers from 0° to the rim in a dark world, for each camera."""
    found = {}
    for name, (camera, last) in MARKER_CAMERAS.items():
        scene = empty_scene(bpy)
        zenith = np.radians(np.linspace(0.0, last, 20))
        # Ahead and behind by turns, up to 40° to either side.
        side = np.radians(40.0) * np.cos(2.0 * np.arange(20))
        azimuth = side + np.pi * (np.arange(20) % 2)
        azimuth[5] = np.radians(90.0)
        for a, z in zip(azimuth, zenith, strict=True):
            marker(bpy, scene, a, z, camera)
        add_camera(bpy, scene, camera)
        configure(scene, Preset("probe", samples=16, denoise=False))
        found[f"markers_{name}"] = luminance(FrameSource(bpy, scene, camera).colour(POSE))
        found[f"marker_angles_{name}"] = np.stack([azimuth, zenith], axis=1)
    return found


def rooms(bpy: Any) -> dict[str, np.ndarray]:
    """The boxed room with its window at +y, seen with two headings; and by lamp light."""
    camera = FisheyeCamera().resized(64)
    scene = build_scene(bpy, boxed_room((0.0, 2.1)), camera)
    configure(scene, Preset("probe", samples=4))
    source = FrameSource(bpy, scene, camera, seed=5)
    ahead = source.radiance(np.array([0.0, 0.0, 0.0]), 0)
    found = {"room": ahead, "room_turned": source.radiance(np.array([0.0, 0.0, np.pi / 2]), 1)}
    found["room_again"] = source.radiance(np.array([0.0, 0.0, 0.0]), 0)
    found["room_other_index"] = source.radiance(np.array([0.0, 0.0, 0.0]), 7)
    source._frames._capture.works = False
    found["room_through_file"] = source.radiance(np.array([0.0, 0.0, 0.0]), 0)
    lit = build_scene(bpy, boxed_room((0.0, 2.1), "interior"), camera)
    configure(lit, Preset("probe", samples=4))
    found["lamp"] = FrameSource(bpy, lit, camera).radiance(np.array([0.0, 0.0, 0.0]))
    return found


def baked(bpy: Any) -> dict[str, np.ndarray]:
    """The boxed room by lamp and by window: traced, and from baked light; and the light itself."""
    camera, settings = FisheyeCamera().resized(64), Bake(16, 0.05, 0.05, 0.1, 0.05)
    shown = PRESETS["fast"]
    found = {}
    for source in ("interior", "exterior"):
        room = boxed_room((0.0, 2.1), source)
        scene = build_scene(bpy, room, camera)
        configure(scene, Preset("probe", samples=128))
        found[f"traced_{source}"] = FrameSource(bpy, scene, camera).radiance(POSE_IN_ROOM)
        light = bake(bpy, room, settings, device="cpu")
        found[f"light_{source}"] = light
        atlas = lay_out_apartment(room, settings)
        scene = build_baked_scene(bpy, room, camera, atlas, light)
        configure(scene, shown)
        source_of_light = FrameSource(bpy, scene, camera, denoiser=Denoiser(bpy, 1))
        found[f"baked_{source}"] = source_of_light.radiance(POSE_IN_ROOM)
        source_of_light._frames._capture.works = False
        found[f"baked_file_{source}"] = source_of_light.radiance(POSE_IN_ROOM)
    found["light_again"] = bake(bpy, room, settings, threads=1, device="cpu")
    return found


def furnace(bpy: Any) -> dict[str, np.ndarray]:
    """A sealed glowing box: every ray sees the radiance asked for."""
    assert SHARES["interior"][0] == 1.0
    camera = FisheyeCamera().resized(32)
    scene = empty_scene(bpy)
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([t for q in quads for t in (q[:3], (q[0], q[2], q[3]))], dtype=np.int32)
    shape = Mesh(corners, faces, np.zeros(len(faces), dtype=np.int32), ("glow",))
    add_mesh(bpy, scene, shape, [build_glow(bpy, "glow", 6500.0, 3.0)])
    add_camera(bpy, scene, camera)
    configure(scene, Preset("probe", samples=1, denoise=False))
    return {"furnace": FrameSource(bpy, scene, camera).radiance(np.zeros(3))}


def panes(bpy: Any) -> dict[str, np.ndarray]:
    """A glowing ceiling seen through a pane of glass that lets half through: clear, frosted."""
    camera = FisheyeCamera().resized(32)
    found = {}
    for name, roughness in (("pane", 0.0), ("frosted_pane", 0.4)):
        scene = empty_scene(bpy)
        for low, size, material in (
            (1.0, 50.0, build_glow(bpy, "glow", 6500.0, 3.0)),
            (
                0.5,
                0.4,
                build_material(
                    bpy,
                    "glass",
                    Material(pattern="glass", colour=(0.5, 0.5, 0.5), roughness=roughness),
                ),
            ),
        ):
            corners, triangles = prism_mesh(
                Prism(box(-size, -size, size, size), low, low + 0.01, "x")
            )
            index = np.zeros(len(triangles), dtype=np.int32)
            add_mesh(bpy, scene, Mesh(corners, triangles, index, ("x",)), [material])
        add_camera(bpy, scene, camera)
        configure(scene, Preset("probe", samples=64, denoise=False))
        found[name] = FrameSource(bpy, scene, camera).radiance(np.zeros(3))
    return found


def joints(bpy: Any) -> dict[str, np.ndarray]:
    """A ceiling of boards that shines with even light: many samples, and few without and with
    joints that are smoothed."""
    camera = FisheyeCamera().resized(96)
    pixel = 1.0 / camera.pixels_per_radian
    corners, triangles = prism_mesh(Prism(box(-6.0, -6.0, 6.0, 6.0), 2.0, 2.1, "x"))
    shape = Mesh(corners, triangles, np.zeros(len(triangles), dtype=np.int32), ("x",))
    boards = Material(pattern="planks", colour=(0.5, 0.5, 0.5), roughness=0.9, size=0.2)
    found = {}
    for name, samples, smoothed in (("many", 512, 0.0), ("plain", 4, 0.0), ("smooth", 4, pixel)):
        scene = empty_scene(bpy)
        light = float_image(bpy, "light", np.ones((2, 2, 3), np.float32))
        made = add_mesh(bpy, scene, shape, [build_material(bpy, "x", boards, light, smoothed)])
        add_layer(made.data, ATLAS, np.full((3 * len(triangles), 2), 0.5, np.float32))
        add_camera(bpy, scene, camera)
        configure(scene, Preset("probe", samples=samples, denoise=False))
        found[f"joints_{name}"] = FrameSource(bpy, scene, camera).radiance(np.zeros(3))
    return found


def state(bpy: Any) -> dict[str, np.ndarray]:
    """Values that Blender holds, without rendering."""
    scene = empty_scene(bpy)
    camera = add_camera(bpy, scene, CAMERAS["simulated"])
    tiles = build_material(bpy, "tiles", Material(pattern="tiles", size=0.3, roughness=0.2))
    bricks = next(node for node in tiles.node_tree.nodes if node.type == "TEX_BRICK")
    kinds = []
    patterns = Material.model_fields["pattern"].annotation.__args__
    for pattern in patterns:
        made = build_material(bpy, pattern, Material(pattern=pattern))
        output = next(n for n in made.node_tree.nodes if n.type == "OUTPUT_MATERIAL")
        kinds.append(output.inputs["Surface"].is_linked)
    motifs = Material.model_fields["motif"].annotation.__args__
    for motif in motifs:
        paper = build_material(bpy, motif, Material(pattern="wallpaper", size=0.25, motif=motif))
        output = next(n for n in paper.node_tree.nodes if n.type == "OUTPUT_MATERIAL")
        kinds.append(output.inputs["Surface"].is_linked)
    repeats = next(node for node in paper.node_tree.nodes if node.type == "MAPPING")
    moved = build_material(bpy, "moved", Material(pattern="plaster", seed=5))
    shift = next(node for node in moved.node_tree.nodes if node.type == "MAPPING")
    configure(scene, Preset("probe", samples=3, max_bounces=2), threads=1)
    used = select_device(bpy, scene, "auto")
    return {
        "fov": np.array(camera.data.fisheye_fov),
        "tile": np.array([bricks.inputs[n].default_value for n in ("Brick Width", "Row Height")]),
        "repeats": np.array(repeats.inputs["Scale"].default_value),
        "seed_shift": np.array(shift.inputs["Location"].default_value),
        "patterns_linked": np.array(kinds),
        "samples": np.array(scene.cycles.samples),
        "diffuse_bounces": np.array(scene.cycles.diffuse_bounces),
        "transmission_bounces": np.array(scene.cycles.transmission_bounces),
        "threads": np.array(scene.render.threads),
        "device": np.array(used),
        "cycles_device": np.array(scene.cycles.device),
    }


def main() -> None:
    bpy = load_bpy()
    found = {f"directions_{name}": directions(bpy, camera) for name, camera in CAMERAS.items()}
    found["directions_leaning"] = directions(bpy, CAMERAS["small"], LEANING)
    found |= (
        markers(bpy)
        | rooms(bpy)
        | baked(bpy)
        | furnace(bpy)
        | panes(bpy)
        | state(bpy)
        | joints(bpy)
    )
    np.savez(sys.argv[1], **found)
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
