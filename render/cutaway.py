"""The cut-away picture: an apartment from above, cut at chest height, as a doll's house.

Everything solid is a vertical prism, so the cut is exact: what begins above it goes,
what reaches through it is shortened, and the cut walls get a dark lid, as in an
architect's section. The camera looks down from the south, a little tilted and far
away, so that the picture lies as the plan does: x to the right, y up.

An apartment with a 3D scene of its own is cut by a plane (`render.scene_cut`).

The light is not the apartment's own: a bright sky and a mild sun show the furniture
of every place alike.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from shapely import box

from dataset.atomic import replacing
from dataset.errors import RoomsegError
from render.blender import add_mesh, empty_scene
from render.cycles import configure, render_through_file, select_device
from render.own_scene import open_own_scene
from render.presets import Preset
from render.scene_cut import cut_scene
from render.shading import build_glow, build_material
from render.task import run_task
from scenes.apartment import Apartment, Material
from scenes.materials import LAMP_PREFIX, resolve
from scenes.mesh import Mesh, prism_mesh, solids_mesh
from scenes.solids import WALL, Prism, apartment_solids

__all__ = ["CUT_HEIGHT", "add_daylight", "cut_solids", "draw_cutaway", "perform", "to_srgb"]

CUT_HEIGHT = 1.6
"""Where walls are cut, m: above tables and beds, below lintels."""
LID = "<cut>"
LID_SURFACE = Material(colour=(0.035, 0.037, 0.042), roughness=1.0)
LID_THICKNESS = 0.02
GROUND = "<ground>"
GROUND_SURFACE = Material(colour=(0.86, 0.86, 0.85), roughness=1.0)
GROUND_LEVEL = -0.2
"""Underside of the floors, m."""
TILT = np.radians(14.0)
"""How far the camera leans from the vertical, rad."""
DISTANCE = 3.5
"""Distance of the camera, in lengths of the apartment: the more, the less perspective."""
MARGIN = 0.04
SUN_DIRECTION = (np.radians(57.0), np.radians(135.0))
"""Elevation and azimuth of the sun, rad: from the upper left."""
SUN_ANGLE = np.radians(4.0)
SUN_STRENGTH = 3.0
SKY = (0.94, 0.98, 1.05)
EXPOSURE = 0.95
FORMATS = (".png", ".jpg", ".jpeg")
JPEG_QUALITY = 85


def draw_cutaway(
    apartment: Apartment,
    path: str | Path,
    *,
    size: int = 1000,
    samples: int = 24,
    cut: float = CUT_HEIGHT,
    folder: str | Path = ".",
) -> None:
    """Render the cut-away picture of an apartment in a child process.

    Parameters
    ----------
    apartment : Apartment
    path : path
        ``.png`` or ``.jpg``; written whole or not at all.
    size : int
        Longer side of the picture, px.
    samples : int
        Paths per pixel.
    cut : float
        Height of the cut, m; the lowest ceiling, if that is lower.
    folder : path
        Where the apartment's scene file is, if it has one.

    Raises
    ------
    RoomsegError
        If the name is no picture's, the scene file is not there, or Blender fails.
    """
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise RoomsegError(f"{path}: not a picture's name, expected one of {', '.join(FORMATS)}")
    with replacing(path) as part:
        run_task(
            "cutaway",
            apartment=apartment.model_dump_json(),
            path=str(part),
            kind=path.suffix.lower(),
            size=size,
            samples=samples,
            cut=cut,
            folder=str(folder),
        )


def perform(
    bpy: Any,
    *,
    apartment: str,
    path: str,
    kind: str,
    size: int,
    samples: int,
    cut: float,
    folder: str,
) -> dict[str, Any]:
    """Render and write one picture; the arguments are those of `draw_cutaway`."""
    place = Apartment.model_validate_json(apartment)
    height = min([cut, *(room.ceiling_height for room in place.rooms)])
    if place.scene_file is None:
        scene = empty_scene(bpy)
    else:
        scene = open_own_scene(bpy, place, folder)
        cut_scene(bpy, scene, height, build_material(bpy, LID, LID_SURFACE))
    _complete(bpy, scene, place, height, size)
    settings = Preset("cutaway", samples=samples, diffuse_bounces=3, glossy_bounces=2)
    configure(scene, settings, glass=place.scene_file is not None)
    scene.cycles.pixel_filter_type = "BLACKMAN_HARRIS"
    scene.cycles.filter_width = 1.5
    scene.cycles.sample_clamp_indirect = 5.0
    select_device(bpy, scene, "auto")
    pixels = to_srgb(render_through_file(bpy, scene))
    options = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY] if kind != ".png" else []
    _, encoded = cv2.imencode(kind, pixels[..., ::-1], options)
    Path(path).write_bytes(encoded.tobytes())
    return {"width": pixels.shape[1], "height": pixels.shape[0]}


def cut_solids(prisms: Iterable[Prism], height: float) -> Iterator[Prism]:
    """What a horizontal cut leaves of some solids; a lid on every wall that it cuts.

    Parameters
    ----------
    prisms : iterable of Prism
    height : float
        m above the floor.
    """
    for prism in prisms:
        if prism.top <= height:
            yield prism
        elif prism.bottom < height and prism.material != WALL:
            yield Prism(prism.footprint, prism.bottom, height, prism.material)
        elif prism.bottom < height - LID_THICKNESS:
            yield Prism(prism.footprint, prism.bottom, height - LID_THICKNESS, WALL)
            yield Prism(prism.footprint, height - LID_THICKNESS, height, LID)


def to_srgb(linear: NDArray[np.float32]) -> NDArray[np.uint8]:
    """8-bit sRGB (h, w, 3) of linear light (h, w, 3 or more), highlights rolled off."""
    light = np.maximum(linear[..., :3] * EXPOSURE, 0.0)
    # Straight up to the shoulder; above it an exponential that reaches 1 only at infinity.
    shoulder = 0.5
    rolled = 1.0 - (1.0 - shoulder) * np.exp(-(light - shoulder) / (1.0 - shoulder))
    tone = np.where(light > shoulder, rolled, light)
    low, high = 12.92 * tone, 1.055 * tone ** (1.0 / 2.4) - 0.055
    encoded = np.where(tone <= 0.0031308, low, high)
    picture: NDArray[np.uint8] = np.round(255.0 * np.clip(encoded, 0.0, 1.0)).astype(np.uint8)
    return picture


def _complete(bpy: Any, scene: Any, apartment: Apartment, height: float, size: int) -> None:
    """Add what is below the cut, unless the scene has it, and ground, light and camera."""
    mesh = solids_mesh(apartment, list(cut_solids(apartment_solids(apartment), height)))
    if apartment.scene_file is None:
        add_mesh(bpy, scene, mesh, [_surface(bpy, apartment, name) for name in mesh.materials])
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    add_mesh(bpy, scene, _ground(low, high), [build_material(bpy, GROUND, GROUND_SURFACE)])
    add_daylight(bpy, scene)
    _add_camera(bpy, scene, _view(low, high), size)


def _surface(bpy: Any, apartment: Apartment, name: str) -> Any:
    """Blender material of one of the mesh's slots; lamps glow faintly."""
    if name.startswith(LAMP_PREFIX):
        lamp = apartment.lamps[int(name.removeprefix(LAMP_PREFIX))]
        return build_glow(bpy, name, lamp.temperature, 1.5)
    return build_material(bpy, name, LID_SURFACE if name == LID else resolve(apartment, name))


def _ground(low: NDArray[np.float64], high: NDArray[np.float64]) -> Mesh:
    """A wide plate under the house, on which its shadow falls."""
    reach = 4.0 * float((high - low).max())
    plate = box(low[0] - reach, low[1] - reach, high[0] + reach, high[1] + reach)
    vertices, triangles = prism_mesh(Prism(plate, GROUND_LEVEL - 0.1, GROUND_LEVEL, GROUND))
    return Mesh(vertices, triangles, np.zeros(len(triangles), dtype=np.int32), (GROUND,))


def add_daylight(bpy: Any, scene: Any) -> None:
    """A sky of even brightness, 1 W/m²/sr, and a soft sun."""
    world = bpy.data.worlds.new("sky")
    if world.node_tree is None:
        world.use_nodes = True
    scene.world = world
    tree = world.node_tree
    tree.nodes.clear()
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (*SKY, 1.0)
    output = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy = SUN_STRENGTH
    sun.data.angle = SUN_ANGLE
    sun.data.color = (1.0, 0.95, 0.88)
    elevation, azimuth = SUN_DIRECTION
    sun.rotation_euler = (0.0, np.pi / 2.0 - elevation, azimuth)
    scene.collection.objects.link(sun)


@dataclass(frozen=True)
class _View:
    """Where the camera is (3,), m, and the window of slopes that it sees."""

    position: NDArray[np.float64]
    left: float
    right: float
    bottom: float
    top: float


def _view(low: NDArray[np.float64], high: NDArray[np.float64]) -> _View:
    """The camera that sees a box with corners ``low`` and ``high`` (3,) and a margin."""
    forward = np.array([0.0, np.sin(TILT), -np.cos(TILT)])
    up = np.array([0.0, np.cos(TILT), np.sin(TILT)])
    position = (low + high) / 2.0 - DISTANCE * float((high - low)[:2].max()) * forward
    corners = np.array(
        [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    )
    seen = corners - position
    depth = seen @ forward
    across, along = seen[:, 0] / depth, (seen @ up) / depth
    margin = MARGIN * max(np.ptp(across), np.ptp(along))
    return _View(
        position,
        float(across.min() - margin),
        float(across.max() + margin),
        float(along.min() - margin),
        float(along.max() + margin),
    )


def _add_camera(bpy: Any, scene: Any, view: _View, size: int) -> None:
    """The camera of a view; its window is moved by lens shift, so that uprights stay put."""
    data = bpy.data.cameras.new("camera")
    width, height = view.right - view.left, view.top - view.bottom
    longer = max(width, height)
    data.sensor_fit = "AUTO"
    data.lens = data.sensor_width / longer
    data.shift_x = (view.left + view.right) / (2.0 * longer)
    data.shift_y = (view.bottom + view.top) / (2.0 * longer)
    data.clip_end = 1e5
    made = bpy.data.objects.new("camera", data)
    made.location = view.position.tolist()
    made.rotation_euler = (TILT, 0.0, 0.0)
    scene.collection.objects.link(made)
    scene.camera = made
    scene.render.resolution_x = max(16, round(size * width / longer))
    scene.render.resolution_y = max(16, round(size * height / longer))
    scene.render.resolution_percentage = 100
