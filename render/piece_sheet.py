"""The contact sheet: every kind of piece in one picture, each as large as its cell lets it be.

All stand on one floor before one camera of parallel rays, and are turned and shrunk
alike in all directions, so that they look as they do in a home. Larger pieces come
out larger, though less so than they are.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from dataset.atomic import replacing
from render.blender import add_mesh, empty_scene
from render.cutaway import add_daylight, to_srgb
from render.cycles import configure, render_through_file, select_device
from render.presets import Preset
from render.shading import build_material
from render.task import run_task
from scenes.apartment import Material, Piece
from scenes.materials import BUILT_IN
from scenes.mesh import Mesh, prism_mesh
from scenes.pieces import KINDS, piece_parts
from scenes.solids import Prism

__all__ = ["draw_piece_sheet", "perform"]

TILT = math.radians(62.0)
"""How far the camera leans from the vertical, rad."""
TURN = math.radians(-28.0)
CELL = (1.25, 1.4)
"""Width and height of a piece's cell in the picture, of which it may fill 1.08 x 1.02."""
FLOOR = Material(colour=(0.5, 0.5, 0.5), roughness=1.0)
JPEG_QUALITY = 82


def draw_piece_sheet(
    path: str | Path, *, columns: int = 10, cell: int = 130, samples: int = 32
) -> None:
    """Render the contact sheet of all kinds as a JPEG.

    Parameters
    ----------
    path : path
        Written whole or not at all.
    columns : int
        Pieces side by side.
    cell : int
        Width of a piece's cell, px.
    samples : int
        Paths per pixel.

    Raises
    ------
    RoomsegError
        If Blender fails.
    """
    with replacing(Path(path)) as part:
        run_task("piece_sheet", path=str(part), columns=columns, cell=cell, samples=samples)


def perform(bpy: Any, *, path: str, columns: int, cell: int, samples: int) -> dict[str, Any]:
    """Render and write the sheet; the arguments are those of `draw_piece_sheet`."""
    rows = -(-len(KINDS) // columns)
    scene = empty_scene(bpy)
    for place, kind in enumerate(KINDS):
        _add_piece(bpy, scene, kind, divmod(place, columns))
    _add_floor(bpy, scene)
    add_daylight(bpy, scene)
    _add_camera(bpy, scene, (columns, rows), cell)
    configure(scene, Preset("piece_sheet", samples=samples, diffuse_bounces=2, glossy_bounces=2))
    select_device(bpy, scene, "auto")
    picture = np.ascontiguousarray(to_srgb(render_through_file(bpy, scene))[..., ::-1])
    _label(picture, columns, rows)
    _, encoded = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    Path(path).write_bytes(encoded.tobytes())
    return {"width": picture.shape[1], "height": picture.shape[0]}


def _add_piece(bpy: Any, scene: Any, kind: str, place: tuple[int, int]) -> None:
    """One piece in the cell at (row, column)."""
    mesh = _piece_mesh(kind)
    materials = [
        bpy.data.materials.get(name) or build_material(bpy, name, BUILT_IN[name])
        for name in mesh.materials
    ]
    made = add_mesh(bpy, scene, mesh, materials, kind)
    turn = np.array([[math.cos(TURN), math.sin(TURN)], [-math.sin(TURN), math.cos(TURN)]])
    seen = _seen(np.column_stack([mesh.vertices[:, :2] @ turn, mesh.vertices[:, 2]]))
    extent = np.ptp(seen, axis=0)
    scale = float(np.min((1.08, 1.02) / extent) * min(1.0, float(extent.max()) / 1.2) ** 0.35)
    middle = scale * (seen.max(axis=0) + seen.min(axis=0)) / 2.0
    row, column = place
    across, up = (column + 0.5) * CELL[0] - middle[0], -(row + 0.45) * CELL[1] - middle[1]
    made.scale = (scale, scale, scale)
    made.rotation_euler = (0.0, 0.0, TURN)
    made.location = (across, up / math.cos(TILT), 0.0)


def _piece_mesh(kind: str) -> Mesh:
    """All parts of a kind at its default size, at the origin."""
    parts = piece_parts(Piece(kind=kind, position=(0.0, 0.0), elevation=0.0))
    shells = [prism_mesh(Prism(p.footprint, p.bottom, p.top, p.material)) for p in parts]
    first = np.cumsum([0, *(len(vertices) for vertices, _ in shells)])
    names = sorted({part.material for part in parts})
    index = [names.index(part.material) for part in parts]
    return Mesh(
        np.concatenate([vertices for vertices, _ in shells]),
        np.concatenate([t + k for (_, t), k in zip(shells, first, strict=False)]).astype(np.int32),
        np.repeat(index, [len(triangles) for _, triangles in shells]).astype(np.int32),
        tuple(names),
    )


def _seen(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (n, 3), m, as the camera sees them: to the right and up (n, 2), m."""
    up = points[:, 1] * math.cos(TILT) + points[:, 2] * math.sin(TILT)
    return np.column_stack([points[:, 0], up])


def _add_floor(bpy: Any, scene: Any) -> None:
    corners = [(-1e3, -1e3, 0.0), (1e3, -1e3, 0.0), (1e3, 1e3, 0.0), (-1e3, 1e3, 0.0)]
    triangles = np.array([(0, 1, 2), (0, 2, 3)], dtype=np.int32)
    # A little lower than what lies flat on it.
    vertices = np.array(corners) - (0.0, 0.0, 1e-3)
    mesh = Mesh(vertices, triangles, np.zeros(2, dtype=np.int32), ("floor",))
    add_mesh(bpy, scene, mesh, [build_material(bpy, "floor", FLOOR)], "floor")


def _add_camera(bpy: Any, scene: Any, grid: tuple[int, int], cell: int) -> None:
    """Parallel rays on a grid of (columns, rows)."""
    width, height = grid[0] * CELL[0], grid[1] * CELL[1]
    data = bpy.data.cameras.new("camera")
    data.type = "ORTHO"
    data.ortho_scale = max(width, height)
    data.clip_end = 1e4
    made = bpy.data.objects.new("camera", data)
    backward = 200.0 * np.array([0.0, -math.sin(TILT), math.cos(TILT)])
    made.location = (np.array([width / 2, -height / 2 / math.cos(TILT), 0.0]) + backward).tolist()
    made.rotation_euler = (TILT, 0.0, 0.0)
    scene.collection.objects.link(made)
    scene.camera = made
    scene.render.resolution_x = cell * grid[0]
    scene.render.resolution_y = round(cell * grid[1] * CELL[1] / CELL[0])
    scene.render.resolution_percentage = 100


def _label(picture: NDArray[np.uint8], columns: int, rows: int) -> None:
    """Write the kinds' names under the pieces."""
    height, width = picture.shape[0] / rows, picture.shape[1] / columns
    font, size = cv2.FONT_HERSHEY_SIMPLEX, width / 330.0
    for place, kind in enumerate(KINDS):
        row, column = divmod(place, columns)
        text = kind.replace("_", " ")
        (wide, _), _ = cv2.getTextSize(text, font, size, 1)
        at = (round((column + 0.5) * width - wide / 2), round((row + 0.96) * height))
        cv2.putText(picture, text, at, font, size, (20, 20, 20), 1, cv2.LINE_AA)
