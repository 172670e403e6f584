r"""Images of every preset beside a long denoised reference: edges and panoramas.

Views are drawn in several places, every other one under or beside a lintel. For each
preset the table says how many pixels of the ceiling cone (38°, §2.2.3) have an edge that
the reference lacks, and lack one that it has, for three values of I_min; the PSNR of the
exposed images; and the distance of the panoramas as the shift of the camera, in cm, that
changes the reference's panorama as much. A stopped benchmark goes on where it was.

The cone is a twentieth of the disc, so it alone is rendered with the many samples of the
reference, by a camera of narrower view with the same pixels, and laid over a disc of
fewer (`--disc-samples`): beside the errors of a preset theirs are small.

    python benchmarks/render_quality.py -o out/quality            # three hours
    python benchmarks/render_quality.py -o out/small --place demo1 --views 2 --disc 160 \
        --reference-samples 64 --preset fast --preset draft       # minutes
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

# Some files here have the names of packages, which Python would find first.
sys.path[:] = [folder for folder in sys.path if Path(folder) != Path(__file__).resolve().parent]

import click
import cv2
import numpy as np

from dataset.atomic import replacing
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
"""How far the camera is moved to learn what a shift does, m."""
TRACED = {f"{n} spp": Preset(f"{n} spp", n) for n in (1, 2, 4, 8, 16, 32, 64)}
FIRST_JUDGED = 4
"""Settings before those that the table has a row for."""
BESIDE = 0.4
"""Farthest from the middle of a doorway, along the way through it, m."""
MARGIN = 8
"""Of the cone that is rendered beyond the one that is judged, px."""


@dataclass(frozen=True)
class Setting:
    """A preset, seen from the views or from beside them, by the whole camera or in its cone."""

    name: str
    preset: Preset
    shift: float = 0.0
    in_cone: bool = False

    def camera(self, disc: int) -> FisheyeCamera:
        """The camera for a disc of that many px."""
        camera = SIMULATED_CAMERA.resized(disc)
        return cone_of(camera) if self.in_cone else camera


def cone_of(camera: FisheyeCamera) -> FisheyeCamera:
    """A camera that has the pixels of the middle of another."""
    side = 2 * (int(np.radians(19.0) * camera.pixels_per_radian) + MARGIN)
    return replace(
        camera,
        field_of_view=side / camera.pixels_per_radian,
        disc_diameter=float(side),
        image_size=(side, side),
        disc_centre=(side / 2, side / 2),
    )


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
) -> list[np.ndarray]:
    """Radiance of every view, rendered unless it is in ``folder``."""
    name = f"{apartment.name}-{disc}-{setting.name.replace(' ', '-')}"
    paths = [folder / name / f"{index:03d}.npy" for index in range(len(poses))]
    missing = [index for index, path in enumerate(paths) if not path.exists()]
    if missing:
        paths[0].parent.mkdir(parents=True, exist_ok=True)
        _render(folder, apartment, setting, poses, disc, threads, missing, paths)
    return [np.load(path, allow_pickle=False) for path in paths]


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
    """Render and store the ``missing`` views."""
    moved = poses.copy()
    moved[:, 0] += setting.shift
    camera = setting.camera(disc)
    job = Job(apartment, camera, setting.preset, threads, "auto", 0, str(folder))
    with RenderProcess(job) as process:
        for index, radiance in process.frames(missing, moved):
            with replacing(paths[index]) as part, part.open("wb") as stream:
                np.save(stream, radiance)


def composed(disc: np.ndarray, cone: np.ndarray) -> np.ndarray:
    """The disc with the cone laid over its middle."""
    whole, first = disc.copy(), [(a - b) // 2 for a, b in zip(disc.shape, cone.shape, strict=True)]
    middle = whole[first[0] : first[0] + cone.shape[0], first[1] : first[1] + cone.shape[1]]
    # The cone's own corners are black.
    rows, columns = np.indices(cone.shape) + 0.5 - 0.5 * cone.shape[0]
    seen = np.hypot(rows, columns) < 0.5 * cone.shape[0] - 1.0
    middle[seen] = cone[seen]
    return whole


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
    # The first settings are the reference's cone and disc, and what a shift changes.
    cone, disc, *seen = [rendered(folder, apartment, setting, *where) for setting in settings]
    truths = [composed(*pair) for pair in zip(disc, cone, strict=True)]
    images = [[expose(radiance, camera)[0] for radiance in row] for row in (truths, *seen)]
    for index in range(len(poses)):
        truth, still, moved = (row[index] for row in images[:3])
        shifted = compare(moved, still, camera)["panorama"]
        for setting, shown in zip(settings[FIRST_JUDGED:], images[3:], strict=True):
            figures = compare(shown[index], truth, camera)
            figures["shift_cm"] = 100.0 * SHIFT * figures["panorama"] / max(shifted, 1e-9)
            found.append({"place": apartment.name, "setting": setting.name, **figures})
    return found


def row_of(setting: Setting, found: list[dict[str, Any]]) -> tuple[list[str], dict[str, float]]:
    """The table's row of a setting, and its figures."""
    mine = [item for item in found if item["setting"] == setting.name]
    mean = {k: float(np.mean([m[k] for m in mine])) for k in mine[0] if k not in _WORDS}
    cells = [f"{mean[f'false {t}']:.0f} / {mean[f'missed {t}']:.0f}" for t in THRESHOLDS]
    return [setting.name, *cells, f"{mean['psnr']:.1f}", f"{mean['shift_cm']:.2f}"], mean


_WORDS = ("place", "setting")


@click.command()
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True)
@click.option("--place", "places", multiple=True, default=("sim1", "sim2", "sim3", "sim5", "real2"))
@click.option("--views", default=8, show_default=True, help="Per place.")
@click.option("--disc", default=464, show_default=True, help="Diameter of the image disc, px.")
@click.option("--reference-samples", default=2048, show_default=True, help="In the cone.")
@click.option("--disc-samples", default=128, show_default=True, help="Of the rest of its disc.")
@click.option(
    "--preset",
    "names",
    multiple=True,
    default=("fast", "8 spp", "16 spp"),
    help="A preset, or 'N spp' for path tracing with N denoised samples; repeatable.",
)
@click.option("--threads", default=2, show_default=True)
@click.option("--seed", default=0, show_default=True)
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Figures for machines.")
def main(output: Path, places: tuple[str, ...], names: tuple[str, ...], **options: Any) -> None:
    """Render what is missing, then print one row per preset."""
    known = {**PRESETS, **TRACED}
    unknown = [name for name in names if name not in known]
    if unknown:
        raise click.BadParameter(f"{unknown[0]!r}, expected one of {', '.join(known)}")
    many, few = options["reference_samples"], options["disc_samples"]
    truth = replace(PRESETS["reference"], samples=many)
    disc = replace(PRESETS["reference"], samples=few)
    settings = [
        Setting(f"cone {many}", truth, in_cone=True),
        Setting(f"disc {few}", disc),
        Setting("fast", PRESETS["fast"]),
        Setting("fast moved", PRESETS["fast"], SHIFT),
        *(Setting(name, known[name]) for name in names),
    ]
    found = []
    for place in places:
        apartment = load_apartment(place)
        poses = draw_views(apartment, options["views"], options["seed"])
        found += figures_of(output, apartment, settings, poses, options)
    rows, means = [], {}
    for setting in settings[FIRST_JUDGED:]:
        cells, means[setting.name] = row_of(setting, found)
        rows.append(cells)
    true = ", ".join(f"{means[settings[-1].name][f'true {t}']:.0f}" for t in THRESHOLDS)
    title = f"{len(places) * options['views']} views; edge pixels of the reference: {true}"
    columns = ("preset", *(f"false / missed, {t}" for t in THRESHOLDS))
    write_table(title, (*columns, "PSNR dB", "shift cm"), rows)
    write_json(options["json_path"], {"views": found, "means": means})


if __name__ == "__main__":
    main()
