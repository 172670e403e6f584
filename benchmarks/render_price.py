r"""What an image costs: `fast` beside `reference`, and beside the plain loop of other tools.

The same poses of one place are rendered three times in one run, each time by a fresh
process: with baked light, whose bake is paid over a job of many images; by path tracing;
and as BlenderProc does it, whose defaults of the renderer are set: keyframes of the camera,
one animation into PNG files, up to 1024 samples a pixel until the noise is below 0.01,
denoised, then one gzip-compressed HDF5 file per frame. CPU time and wall time are given;
a machine that does other things meanwhile lengthens the latter only. The scene's own
start is left out of all three; with it, but for the plain loop, goes the first image.

    python benchmarks/render_price.py --place sim3 --views 20        # some 20 minutes
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

# Some files here have the names of packages, which Python would find first.
sys.path[:] = [folder for folder in sys.path if Path(folder) != Path(__file__).resolve().parent]

import click
import cv2
import h5py
import numpy as np

from dataset.camera import SIMULATED_CAMERA, FisheyeCamera
from render.presets import PRESETS, preset_named
from render.process import Job, RenderProcess
from roomseg.cli.output import write_json, write_table
from scenes import load_apartment, reachable_positions

Cost = tuple[float, float]
"""CPU seconds and wall seconds."""


def clocks() -> Cost:
    """CPU seconds of the children that have ended, and the wall clock."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime, time.perf_counter()


def spent(place: str, preset: str, poses: np.ndarray, options: dict[str, Any]) -> Cost:
    """What it costs to render the poses with a preset, in one process."""
    camera = SIMULATED_CAMERA.resized(options["disc"])
    cpu, wall = clocks()
    job = Job(
        load_apartment(place),
        camera,
        preset_named(preset),
        options["threads"],
        folder=options["folder"],
    )
    with RenderProcess(job) as process:
        for _ in process.frames(list(range(len(poses))), poses):
            pass
    return clocks()[0] - cpu, clocks()[1] - wall


def spent_by_loop(place: str, poses: np.ndarray, options: dict[str, Any]) -> Cost:
    """The same by the plain loop."""
    np.save(Path(options["folder"]) / "poses.npy", poses)
    given = ("--disc", options["disc"], "--threads", options["threads"], "--place", place)
    command = [sys.executable, __file__, "--loop-in", options["folder"], *map(str, given)]
    cpu, wall = clocks()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return clocks()[0] - cpu, clocks()[1] - wall


def loop(folder: Path, place: str, camera: FisheyeCamera, threads: int) -> None:
    """Render the poses in ``folder`` to one HDF5 file each, with BlenderProc's defaults."""
    from render.blender import build_scene, place_camera
    from render.libraries import load_bpy

    bpy = load_bpy()
    scene = build_scene(bpy, load_apartment(place), camera)
    poses = np.load(folder / "poses.npy", allow_pickle=False)
    for frame, pose in enumerate(poses):
        place_camera(scene.camera, pose, camera.height)
        for path in ("location", "rotation_euler"):
            scene.camera.keyframe_insert(path, frame=frame)
    scene.frame_start, scene.frame_end = 0, len(poses) - 1
    defaults(scene, threads)
    scene.render.filepath = str(folder / "rgb_")
    if not len(poses):
        return
    bpy.ops.render.render(animation=True)
    for frame in range(len(poses)):
        image = cv2.imread(str(folder / f"rgb_{frame:04d}.png"))
        with h5py.File(folder / f"{frame}.hdf5", "w") as file:
            file.create_dataset("colors", data=image, compression="gzip")


def defaults(scene: Any, threads: int) -> None:
    """The settings that BlenderProc starts with."""
    render, cycles = scene.render, scene.cycles
    render.engine, cycles.device = "CYCLES", "CPU"
    render.threads_mode, render.threads = "FIXED", threads
    render.image_settings.file_format, render.image_settings.color_depth = "PNG", "8"
    cycles.samples, cycles.use_adaptive_sampling, cycles.adaptive_threshold = 1024, True, 0.01
    cycles.use_denoising, cycles.denoiser = True, "OPENIMAGEDENOISE"
    cycles.max_bounces = cycles.diffuse_bounces = 3
    cycles.glossy_bounces = cycles.transmission_bounces = cycles.volume_bounces = 0
    cycles.transparent_max_bounces = 8


def per_image(many: Cost, one: Cost, images: int) -> Cost:
    """Cost of each further image."""
    return (many[0] - one[0]) / images, (many[1] - one[1]) / images


@click.command()
@click.option("--place", default="sim3", show_default=True)
@click.option("--views", default=20, show_default=True)
@click.option(
    "--loop-views", default=3, show_default=True, help="Of the plain loop, which is slow."
)
@click.option("--disc", default=464, show_default=True, help="Diameter of the image disc, px.")
@click.option("--job", default=2000, show_default=True, help="Images over which a bake is paid.")
@click.option("--threads", default=2, show_default=True)
@click.option("--seed", default=0, show_default=True)
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Figures for machines.")
@click.option("--loop-in", hidden=True, type=click.Path(path_type=Path))
def main(place: str, views: int, loop_views: int, loop_in: Path | None, **options: Any) -> None:
    """Print CPU and wall seconds per image, and how many times cheaper `fast` is."""
    if loop_in is not None:
        loop(loop_in, place, SIMULATED_CAMERA.resized(options["disc"]), options["threads"])
        return
    random = np.random.default_rng(options["seed"])
    free = reachable_positions(load_apartment(place))
    where = free[random.integers(len(free), size=views + 1)]
    poses = np.column_stack([where, random.uniform(-np.pi, np.pi, views + 1)])
    with tempfile.TemporaryDirectory() as folder:
        costs = measured(place, poses, loop_views, {**options, "folder": folder})
    show(costs, f"{place}, {views} images, {loop_views} by the plain loop", options["json_path"])


def measured(
    place: str, poses: np.ndarray, loop_views: int, options: dict[str, Any]
) -> dict[str, Cost]:
    """Cost of an image of each kind; that of a bake is added to those it serves."""
    images = len(poses) - 1
    cold = spent(place, "fast", poses[:1], options)
    warm = spent(place, "fast", poses[:1], options)
    bake = per_image(cold, warm, options["job"])
    fast = per_image(spent(place, "fast", poses, options), warm, images)
    first = spent(place, "reference", poses[:1], options)
    reference = per_image(spent(place, "reference", poses, options), first, images)
    start = spent_by_loop(place, poses[:0], options)
    plain = per_image(spent_by_loop(place, poses[:loop_views], options), start, loop_views)
    return {
        f"fast, {PRESETS['fast'].samples} samples": (fast[0] + bake[0], fast[1] + bake[1]),
        f"of it bake, over {options['job']} images": bake,
        f"reference, {PRESETS['reference'].samples} samples": reference,
        "plain loop, at most 1024 samples": plain,
    }


def show(costs: dict[str, Cost], title: str, json_path: Path | None) -> None:
    """One row per kind."""
    ours = next(iter(costs.values()))
    rows = [
        (name, f"{cpu:.2f}", f"{wall:.2f}", f"{60.0 / wall:.1f}", f"{cpu / ours[0]:.1f}")
        for name, (cpu, wall) in costs.items()
    ]
    write_table(title, ("", "CPU s/image", "s/image", "images/min", "CPU, fast = 1"), rows)
    write_json(json_path, {name: {"cpu": cpu, "wall": wall} for name, (cpu, wall) in costs.items()})


if __name__ == "__main__":
    main()
