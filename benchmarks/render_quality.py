r"""Images of every preset beside a long denoised reference: edges, panoramas, price.

Views are drawn in several places, every other one under or beside a lintel. For each
preset the table says how many pixels of the ceiling cone (38°, §2.2.3) have an edge that
the reference lacks, and lack one that it has, for three values of I_min; the PSNR of the
exposed images; the distance of the panoramas as the shift of the camera, in cm, that
changes the reference's panorama as much; seconds per image; seconds of the bake, and how
many images a minute that makes over a job. A stopped benchmark goes on where it was.

    python benchmarks/render_quality.py -o out/quality            # hours
    python benchmarks/render_quality.py -o out/small --place demo1 --views 2 --disc 160 \
        --reference-samples 64 --preset fast --preset draft       # minutes
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

# Some files here have the names of packages, which Python would find first.
sys.path[:] = [folder for folder in sys.path if Path(folder) != Path(__file__).resolve().parent]

import click
import cv2
import numpy as np

from dataset.atomic import replacing, write_text
from dataset.camera import SIMULATED_CAMERA, FisheyeCamera
from render.exposure import expose
from render.presets import PRESETS, Preset
from render.process import Job, RenderProcess
from roomseg.cli.output import write_json, write_table
from roomseg.panorama import PanoramaParameters, Unfolding
from scenes import Apartment, load_apartment
from scenes.openings import place as place_opening
from scenes.passages import reachable_positions

THRESHOLDS = (100, 200, 400)
SHIFT = 0.02
"""How far the reference's camera is moved to learn what a shift does, m."""
TRACED = {f"{n} spp": Preset(f"{n} spp", n) for n in (1, 2, 4, 8, 16, 32, 64)}
BESIDE = 0.4
"""Farthest from the middle of a doorway, along the way through it, m."""


@dataclass(frozen=True)
class Setting:
    """A row of the table: a preset, seen from the views or from beside them."""

    name: str
    preset: Preset
    shift: float = 0.0


def draw_views(apartment: Apartment, count: int, seed: int) -> np.ndarray:
    """Poses (n, 3); every other one under or beside a lintel."""
    generator = np.random.default_rng(seed)
    free = reachable_positions(apartment)
    doors = [
        place_opening(apartment, passage.position, passage.width)
        for passage in apartment.passages
        if not passage.closed and passage.lintel_height is not None
    ]
    poses = []
    for index in range(count):
        wish = free[generator.integers(len(free))]
        if index % 2 == 0 and doors:
            door = doors[generator.integers(len(doors))]
            wish = door.centre + generator.uniform(-BESIDE, BESIDE) * door.across
            wish = free[np.linalg.norm(free - wish, axis=1).argmin()]
        poses.append((*wish, generator.uniform(-np.pi, np.pi)))
    return np.array(poses)


def rendered(
    folder: Path, apartment: Apartment, setting: Setting, poses: np.ndarray, disc: int, threads: int
) -> Iterator[dict[str, Any]]:
    """Radiance and seconds of every view, rendered unless they are in ``folder``."""
    name = f"{apartment.name}-{disc}-{setting.name.replace(' ', '-')}"
    paths = [folder / name / f"{index:03d}.npz" for index in range(len(poses))]
    missing = [index for index, path in enumerate(paths) if not path.exists()]
    if missing:
        paths[0].parent.mkdir(parents=True, exist_ok=True)
        _render(folder, apartment, setting, poses, disc, threads, missing, paths)
    for path in paths:
        with np.load(path, allow_pickle=False) as stored:
            yield {"radiance": stored["radiance"], "seconds": float(stored["seconds"])}


def _render(
    folder: Path,
    apartment: Apartment,
    setting: Setting,
    poses: np.ndarray,
    disc: int,
    threads: int,
    missing: list[int],
    paths: list[Path],
) -> None:
    """Render and store the ``missing`` views, one after another; the first one twice."""
    camera, moved = SIMULATED_CAMERA.resized(disc), poses.copy()
    moved[:, 0] += setting.shift
    bakes = set(folder.glob("bakes/*.npz"))
    begin = time.perf_counter()
    # The first frame pays for the scene; it is rendered again to be timed.
    job = Job(apartment, camera, setting.preset, threads, "auto", 0, str(folder))
    with RenderProcess(job) as process:
        if set(folder.glob("bakes/*.npz")) != bakes:
            seconds = {"seconds": time.perf_counter() - begin}
            write_text(paths[0].parent / "bake.json", json.dumps(seconds))
        warm_up = process.frames([missing[0], *missing], moved)
        next(warm_up)
        begin = time.perf_counter()
        for index, radiance in warm_up:
            seconds = {"seconds": time.perf_counter() - begin, "radiance": radiance}
            with replacing(paths[index]) as part, part.open("wb") as stream:
                np.savez(stream, **seconds)
            begin = time.perf_counter()


def edges(image: np.ndarray, camera: FisheyeCamera, threshold: float) -> np.ndarray:
    """Which pixels of the ceiling cone have an edge."""
    inside = camera.pixel_zenith() < np.radians(19.0)
    gradient = (cv2.Scharr(image, cv2.CV_32F, *axis) for axis in ((1, 0), (0, 1)))
    return np.hypot(*gradient)[inside] > threshold


def compare(image: np.ndarray, truth: np.ndarray, camera: FisheyeCamera) -> dict[str, float]:
    """Figures of one view: edges, squared error, distance of the panoramas."""
    disc = camera.pixel_zenith() < 0.5 * camera.field_of_view
    unfold = Unfolding.of(camera, PanoramaParameters())
    figures: dict[str, float] = {}
    for threshold in THRESHOLDS:
        ours, true = (edges(item, camera, threshold) for item in (image, truth))
        figures[f"true {threshold}"] = float(np.count_nonzero(true))
        figures[f"false {threshold}"] = float(np.count_nonzero(ours & ~true))
        figures[f"missed {threshold}"] = float(np.count_nonzero(true & ~ours))
    error = image[disc].astype(float) - truth[disc]
    figures["psnr"] = float(10.0 * np.log10(255.0**2 / max(np.mean(error**2), 1e-9)))
    figures["panorama"] = float(
        np.linalg.norm(unfold(image).astype(float) - unfold(truth).astype(float))
    )
    return figures


def figures_of(
    folder: Path, apartment: Apartment, settings: list[Setting], poses: np.ndarray, options: Any
) -> list[dict[str, Any]]:
    """Figures of every view of one place with every setting."""
    camera, found = SIMULATED_CAMERA.resized(options["disc"]), []
    where = (poses, options["disc"], options["threads"])
    # The first two settings are the reference and the same from a little further.
    frames = [list(rendered(folder, apartment, setting, *where)) for setting in settings]
    images = [[expose(frame["radiance"], camera)[0] for frame in row] for row in frames]
    for index in range(len(poses)):
        truth = images[0][index]
        shifted = compare(images[1][index], truth, camera)["panorama"]
        for setting, row, shown in zip(settings, frames, images, strict=True):
            figures = compare(shown[index], truth, camera)
            figures["shift_cm"] = 100.0 * SHIFT * figures["panorama"] / max(shifted, 1e-9)
            figures["seconds"] = row[index]["seconds"]
            found.append({"place": apartment.name, "setting": setting.name, **figures})
    return found


def bake_seconds(folder: Path, setting: Setting) -> float:
    """Mean seconds of the bakes that were made for a setting; 0 if there were none."""
    name = setting.name.replace(" ", "-")
    stored = [json.loads(p.read_text()) for p in folder.glob(f"*-{name}/bake.json")]
    return float(np.mean([item["seconds"] for item in stored])) if stored else 0.0


def row_of(
    setting: Setting, found: list[dict[str, Any]], bake: float, job: int
) -> tuple[list[str], dict[str, float]]:
    """The table's row of a setting, and its figures."""
    mine = [item for item in found if item["setting"] == setting.name]
    mean = {k: float(np.mean([m[k] for m in mine])) for k in mine[0] if k not in _WORDS}
    mean["bake_s"], mean["images_per_minute"] = bake, 60.0 / (mean["seconds"] + bake / job)
    cells = [f"{mean[f'false {t}']:.0f} / {mean[f'missed {t}']:.0f}" for t in THRESHOLDS]
    cells += [f"{mean['psnr']:.1f}", f"{mean['shift_cm']:.2f}", f"{mean['seconds']:.2f}"]
    return [setting.name, *cells, f"{bake:.0f}", f"{mean['images_per_minute']:.1f}"], mean


_WORDS = ("place", "setting")


@click.command()
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True)
@click.option("--place", "places", multiple=True, default=("sim1", "sim2", "sim3", "sim5", "real2"))
@click.option("--views", default=8, show_default=True, help="Per place.")
@click.option("--disc", default=464, show_default=True, help="Diameter of the image disc, px.")
@click.option("--reference-samples", default=2048, show_default=True)
@click.option(
    "--preset",
    "names",
    multiple=True,
    default=("fast", "8 spp", "16 spp"),
    help="A preset, or 'N spp' for path tracing with N denoised samples; repeatable.",
)
@click.option("--job", default=2000, show_default=True, help="Images over which a bake is paid.")
@click.option("--threads", default=2, show_default=True)
@click.option("--seed", default=0, show_default=True)
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Figures for machines.")
def main(output: Path, places: tuple[str, ...], names: tuple[str, ...], **options: Any) -> None:
    """Render what is missing, then print one row per preset."""
    known = {**PRESETS, **TRACED}
    unknown = [name for name in names if name not in known]
    if unknown:
        raise click.BadParameter(f"{unknown[0]!r}, expected one of {', '.join(known)}")
    truth = replace(PRESETS["reference"], samples=options["reference_samples"])
    settings = [
        Setting(f"truth {truth.samples}", truth),
        Setting(f"moved {truth.samples}", truth, SHIFT),
        *(Setting(name, known[name]) for name in names),
    ]
    found = []
    for place in places:
        apartment = load_apartment(place)
        poses = draw_views(apartment, options["views"], options["seed"])
        found += figures_of(output, apartment, settings, poses, options)
    rows, means = [], {}
    for setting in settings[1:]:
        bake = bake_seconds(output, setting)
        cells, means[setting.name] = row_of(setting, found, bake, options["job"])
        rows.append(cells)
    true = ", ".join(f"{means[settings[1].name][f'true {t}']:.0f}" for t in THRESHOLDS)
    title = f"{len(places) * options['views']} views; edge pixels of the reference: {true}"
    columns = ("preset", *(f"false / missed, {t}" for t in THRESHOLDS))
    write_table(title, (*columns, "PSNR dB", "shift cm", "s/image", "bake s", "images/min"), rows)
    write_json(options["json_path"], {"views": found, "means": means})


if __name__ == "__main__":
    main()
