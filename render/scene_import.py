"""An apartment from a 3D scene of any make: its obstacles by slicing, its look as it is.

The scene is opened in a child process, cleaned of everything that could run or read
other files, evaluated to plain meshes, and moved and scaled so that its floor is at
height 0 and its unit the metre. What results is saved as one Blender file that holds
all its data, beside the apartment's own file, and that is what is sliced and rendered.

One normal form for all formats: the rendering then needs no importer, opens nothing
but that file, gets the same scene on every machine, and shows exactly the triangles
that were sliced. The file's name has the first digits of its SHA-256, the apartment
has all of them.
"""

from __future__ import annotations

import hashlib
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from dataset.atomic import force_to_disk, unwritten
from render.blender import empty_scene
from render.scene_cleaning import first_line, open_blend, remove_scripts, settle_images
from render.scene_evaluation import (
    evaluate_scene,
    plain_scene,
    sources_of_light,
    triangles_of,
)
from render.scene_files import inspect_scene, require_whole, save_blend
from render.task import run_task
from scenes.apartment import Apartment, Lighting, Point, SceneFile
from scenes.checks import check
from scenes.errors import SceneError
from scenes.importers import Imported
from scenes.importers.ceiling_lamps import ceiling_lamps
from scenes.importers.free_space import free_space_apartment
from scenes.importers.slicing import Triangles, floor_level, free_floor, height_of_ceiling
from scenes.importers.tables import read_borders

__all__ = ["perform", "read_scene"]

UNITS = {1.0: "m", 0.3048: "ft", 0.0254: "in", 0.01: "cm", 0.001: "mm"}
"""Metres per unit that people draw in."""
USUAL_HEIGHT = 2.6
LOWEST, HIGHEST, LARGEST = 0.5, 100.0, 1000.0
"""Heights and extent that a scene may have, m; else its unit is taken for wrong."""
MOST_TRIANGLES = 10_000_000
DEFAULT_CEILING = 2.5
TOLERANCE = 2e-3
"""How far outlines may be moved to get fewer corners, m."""

Up = Literal["Y", "Z"]
FORWARD = {"Y": "NEGATIVE_Z", "Z": "Y"}


def read_scene(
    path: str | Path,
    output_folder: str | Path,
    *,
    scale: float | None = None,
    up: Up = "Y",
    floor: float | None = None,
    name: str | None = None,
    start: Point | None = None,
    borders: str | Path | None = None,
    ceiling_height: float | None = None,
    floor_clearance: float = 0.01,
    robot_height: float = 0.10,
) -> Imported:
    """Import a 3D scene; its Blender file is written to ``output_folder``.

    Parameters
    ----------
    path : path
        One of `render.scene_files.FORMATS`.
    output_folder : path
        Where the apartment's own file will be.
    scale : float, optional
        Metres per unit of the file; needed if the file does not say it.
    up : {'Y', 'Z'}
        The axis that points up in a format that does not say it: OBJ, PLY, STL.
    floor : float, optional
        Height of the floor in the file, m; the lowest large one if absent.
    name : str, optional
        Of the apartment; that of the file if absent.
    start : tuple of float, optional
        Where the robot starts, m; the middle of the most open place if absent.
    borders : path, optional
        Border segments between rooms, m: see `scenes.importers.tables.read_borders`.
    ceiling_height : float, optional
        m; measured if absent.
    floor_clearance, robot_height : float
        Between these heights things are obstacles, m.

    Returns
    -------
    Imported

    Raises
    ------
    SceneError, RoomsegError
        If the file cannot be read, does not say its unit, or has no floor for the robot;
        nothing is written then.
    """
    path, folder = Path(path), Path(output_folder)
    has_unit = inspect_scene(path)
    _check_options(path, scale, floor_clearance, robot_height)
    called = name or _name_of(path)
    options = {"scale": scale, "up": up, "floor": floor, "has_unit": has_unit}
    with _work_folder(folder) as work:
        blend, surface = work / "scene.blend", work / "surface.npz"
        try:
            found = run_task(
                "scene_import",
                path=str(path.resolve()),
                blend=str(blend.resolve()),
                surface=str(surface.resolve()),
                **options,
            )
            require_whole(blend)
        except OSError as error:
            raise unwritten(folder, error) from None
        with np.load(surface) as stored:
            triangles = Triangles(stored["corners"], stored["owner"])
        apartment, notes = _apartment(
            triangles,
            called,
            start=start,
            borders=borders,
            ceiling=ceiling_height,
            slab=(floor_clearance, robot_height),
            light=set(found["light"]),
        )
        for problem in check(apartment):
            raise SceneError(f"{path}: {problem}")
        apartment = apartment.model_copy(update={"scene_file": _keep(blend, folder, called)})
    return Imported(apartment, (*found["notes"], *notes))


@contextmanager
def _work_folder(folder: Path) -> Iterator[Path]:
    """A folder in the one where the scene will be, so that it can be renamed into it."""
    try:
        made = tempfile.TemporaryDirectory(dir=folder, prefix=".import-")
    except OSError as error:
        raise SceneError(f"{folder}: cannot be written: {error.strerror or error}") from None
    with made as name:
        yield Path(name)


def _check_options(path: Path, scale: float | None, low: float, high: float) -> None:
    if scale is not None and not 1e-6 <= scale <= 1e4:
        raise SceneError(f"{path}: scale: {scale:g} m per unit; expected 0.000001 to 10000")
    if not 0.0 <= low < high <= 2.0:
        raise SceneError(
            f"{path}: obstacles between {low:g} and {high:g} m; expected 0 <= floor clearance < "
            f"robot height <= 2 m"
        )


def _name_of(path: Path) -> str:
    """A name for the apartment from that of its file."""
    return re.sub(r"[^A-Za-z0-9_.-]+", "_", path.stem).lstrip("_.-")[:48] or "scene"


def _keep(blend: Path, folder: Path, name: str) -> SceneFile:
    """Give the Blender file the name of its content; atomic."""
    with blend.open("rb") as stream:
        digest = hashlib.file_digest(stream, "sha256").hexdigest()
    file = f"{name[:48]}-{digest[:8]}.blend"
    force_to_disk(blend)
    blend.chmod(0o644)
    blend.replace(folder / file)
    force_to_disk(folder)
    return SceneFile(file=file, sha256=digest)


def _apartment(
    triangles: Triangles,
    name: str,
    *,
    start: Point | None,
    borders: str | Path | None,
    ceiling: float | None,
    slab: tuple[float, float],
    light: set[str],
) -> tuple[Apartment, tuple[str, ...]]:
    """The apartment of a sliced scene, without its scene file."""
    free = free_floor(triangles, *slab)
    measured = ceiling if ceiling is not None else height_of_ceiling(triangles, free)
    notes = [] if measured else [f"no ceiling found: {DEFAULT_CEILING:g} m assumed"]
    result = free_space_apartment(
        free,
        name=name,
        start=start,
        borders=None if borders is None else read_borders(Path(borders)),
        ceiling_height=measured or DEFAULT_CEILING,
        lintel_height=None,
        obstacle_top=slab[1],
        tolerance=TOLERANCE,
    )
    if "sky" in light or light == {"lamps"}:
        lit: dict[str, Any] = {"lighting": Lighting(sun_strength=0.0, sky_strength=0.0)}
    elif light:
        lit = {"lighting": Lighting(sun_strength=0.0)}
        notes.append("a sun, but no sky in the file: a sky added")
    else:
        lamps = ceiling_lamps(result.apartment, triangles)
        lit = {"lighting": Lighting(source="interior", sun_strength=0.0), "lamps": lamps}
        notes.append(f"no light in the file: ceiling lamps ({len(lamps)}) and a dim sky added")
    return result.apartment.model_copy(update=lit), (*notes, *result.notes)


# ---- in Blender's process -------------------------------------------------------------------


def perform(
    bpy: Any,
    *,
    path: str,
    blend: str,
    surface: str,
    scale: float | None,
    up: Up,
    floor: float | None,
    has_unit: bool,
) -> dict[str, Any]:
    """Open a scene, save its normal form as ``blend`` and its triangles as ``surface``.

    Returns
    -------
    dict
        ``notes``: what could not be used; ``light``: see `sources_of_light`.
    """
    source = Path(path)
    scene, notes = _open(bpy, source, up, own_unit=has_unit and scale is None)
    notes += remove_scripts(bpy)
    notes += settle_images(bpy, source.parent)
    bodies, unused = evaluate_scene(bpy, scene)
    count = sum(len(body.data.loop_triangles) for body in bodies if not body.is_light)
    if not 0 < count <= MOST_TRIANGLES:
        raise SceneError(
            f"{source}: {count} triangles that are rendered; expected 1 to {MOST_TRIANGLES}"
        )
    triangles = triangles_of(bodies)
    if scale is None and source.suffix.lower() == ".blend":
        has_unit = scene.unit_settings.system != "NONE"
    frame = _frame(source, triangles, scale or _unit(source, scene, triangles, has_unit), floor)
    placed = triangles.corners @ frame[:3, :3].T + frame[:3, 3]
    np.savez(surface, corners=placed, owner=triangles.owner)
    made = plain_scene(bpy, scene, bodies, frame)
    light = sources_of_light(bpy, made)
    save_blend(bpy, blend)
    return {"notes": notes + unused, "light": sorted(light)}


def _open(bpy: Any, path: Path, up: Up, *, own_unit: bool) -> tuple[Any, list[str]]:
    """Read a file into an empty Blender: its scene, and what else was in it."""
    scene = empty_scene(bpy)
    kind = path.suffix.lower()
    if kind == ".blend":
        return open_blend(bpy, path)
    try:
        if kind in (".glb", ".gltf"):
            bpy.ops.import_scene.gltf(filepath=str(path), import_pack_images=True)
        elif kind in (".obj", ".ply", ".stl"):
            read = getattr(bpy.ops.wm, f"{kind[1:]}_import")
            read(filepath=str(path), up_axis=up, forward_axis=FORWARD[up])
        elif kind == ".fbx":
            bpy.ops.wm.fbx_import(filepath=str(path))
        else:
            textures = "IMPORT_PACK" if kind == ".usdz" else "IMPORT_NONE"
            bpy.ops.wm.usd_import(
                filepath=str(path),
                import_textures_mode=textures,
                apply_unit_conversion_scale=own_unit,
            )
    except RuntimeError as error:
        raise SceneError(f"{path}: Blender cannot read it: {first_line(error)}") from None
    return scene, []


def _unit(path: Path, scene: Any, triangles: Triangles, has_unit: bool) -> float:
    """Metres per unit, as the file says; an error with a proposal if it does not."""
    z = triangles.corners[:, :, 2]
    height = float(z.max() - z.min())
    own = float(scene.unit_settings.scale_length) if path.suffix.lower() == ".blend" else 1.0
    extent = float(np.ptp(triangles.corners.reshape(-1, 3), axis=0).max())
    if has_unit and LOWEST <= own * height <= HIGHEST and own * extent <= LARGEST:
        return own
    guess = min(UNITS, key=lambda unit: abs(np.log(max(unit * height, 1e-12) / USUAL_HEIGHT)))
    said = f"would be {own * height:.3g} m high" if has_unit else "does not say its unit"
    raise SceneError(
        f"{path}: {said}; expected --scale, metres per unit, such as {guess:g} for {UNITS[guess]} "
        f"(the scene would be {guess * height:.3g} m high)"
    )


def _frame(
    path: Path, triangles: Triangles, scale: float, floor: float | None
) -> NDArray[np.float64]:
    """Transformation (4, 4) from the units of the file to metres above its floor."""
    scaled = Triangles(scale * triangles.corners, triangles.owner)
    level = floor_level(scaled) if floor is None else floor
    if level is None:
        raise SceneError(f"{path}: nothing level in it; expected a floor, or --floor HEIGHT")
    frame = np.diag([scale, scale, scale, 1.0])
    frame[2, 3] = -level
    return frame
