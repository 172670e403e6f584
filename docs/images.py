"""What the camera sees in every place, and what the kinds of light make of it.

The robot stands in a doorway of each place. Frames are kept in a folder of their own, so
that a stopped page goes on where it was; then ``docs/images.md`` and its JPEGs are written.

    python docs/images.py                            # the bakes of nine places: an hour
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import cv2
import numpy as np

from dataset.atomic import replacing, write_text
from dataset.camera import FisheyeCamera
from render.develop import noise_of
from render.exposure import expose
from render.presets import PRESETS, Preset
from render.process import Job, RenderProcess
from roomseg.cli.output import progress_bar
from roomseg.figures import (
    contact_sheet_figure,
    draw_camera_image,
    draw_edge_pixels,
    new_figure,
    png_bytes,
)
from roomseg.panorama import PanoramaParameters, Unfolding
from roomseg.passageway import LintelParameters, LintelSearch, edge_pixels
from scenes import Apartment, load_apartment
from scenes.openings import place as place_opening
from scenes.passages import reachable_positions
from simulator.reference_set import NOVEL_RUNS, REFERENCE_RUNS

HERE = Path(__file__).resolve().parent
SIMULATED = ("sim1", "sim2", "sim3", "sim4", "sim5", "novel")
STAND_INS = ("real1", "real2", "real3")
COMPARED = ("sim3", "sim2", "sim5")
PRESETS_SHOWN = {
    "path tracing, not denoised": replace(PRESETS["reference"], name="raw", denoise=False),
    "reference": PRESETS["reference"],
    "fast": PRESETS["fast"],
}

PAGE = """# Images

`python docs/images.py` renders this page with the default preset, `fast`; a stopped page goes
on where it was. The robot stands in a doorway; below each image is its unfolded,
histogram-equalised panorama of 288 × 48 pixels (§2.2.4), as in Figs. 18 to 21.

## Simulated places

![A doorway of each simulated place](images/simulated.jpg)

## Stand-ins for the real places

Their camera has the prototype's disc, vignetting, blur and noise.

![A doorway of each stand-in](images/stand-ins.jpg)

## Path tracing, with and without denoising, and baked light

The middle of the images, the ceiling cone of §2.2.3, of `sim3` (daylight), `sim2` (low sun and
lamps) and `sim5` (lamps), and the edge pixels that the lintel search takes there (I_min = 200).
{samples} samples a pixel, but for `fast`: {fast}. Without denoising noise is taken for edges
everywhere. How much the kinds differ over many views, and what they cost, is measured in
[Rendering](render.md).

![Three places, three kinds of light](images/presets.jpg)
"""


def doorway(apartment: Apartment) -> np.ndarray:
    """A pose (3,) in the first doorway with a lintel, looking through it."""
    passage = next(p for p in apartment.passages if not p.closed and p.lintel_height is not None)
    opening = place_opening(apartment, passage.position, passage.width)
    free = reachable_positions(apartment)
    x, y = free[np.linalg.norm(free - opening.centre, axis=1).argmin()]
    return np.array([x, y, np.arctan2(opening.across[1], opening.across[0])])


def camera_of(name: str) -> FisheyeCamera:
    """The camera of the place's runs, as high as their robot carries it."""
    run = next(run for run in (*REFERENCE_RUNS, *NOVEL_RUNS) if run.place == name)
    return replace(run.camera, height=run.sensor.camera_height)


def image_of(name: str, preset: Preset, folder: Path) -> np.ndarray:
    """The exposed image in the doorway of a place, rendered unless it is in ``folder``."""
    camera, kept = camera_of(name), folder / f"{name}-{preset.name}.npy"
    if not kept.exists():
        apartment = load_apartment(name)
        job = Job(apartment, camera, preset, folder=str(folder))
        with RenderProcess(job) as process:
            ((_, radiance),) = process.frames([0], doorway(apartment)[None])
        with replacing(kept) as part, part.open("wb") as stream:
            np.save(stream, radiance)
    return expose(np.load(kept, allow_pickle=False), camera, noise_of(0, 0))[0]


def sheet(title: str, names: tuple[str, ...], folder: Path) -> Any:
    """Images over their panoramas."""
    unfold = Unfolding.of(camera_of(names[0]), PanoramaParameters())
    images = [(name, image_of(name, PRESETS["fast"], folder)) for name in names]
    return contact_sheet_figure(title, [(name, image, unfold(image)) for name, image in images])


def comparison(folder: Path) -> Any:
    """Middles of images and their edge pixels; a row for each place, a pair for each preset."""
    figure = new_figure(2.1 * 2 * len(PRESETS_SHOWN), 2.3 * len(COMPARED))
    axes = figure.subplots(len(COMPARED), 2 * len(PRESETS_SHOWN), squeeze=False)
    for row, name in zip(axes, COMPARED, strict=True):
        camera = camera_of(name)
        search = LintelSearch.of(camera, LintelParameters())
        for index, (caption, preset) in enumerate(PRESETS_SHOWN.items()):
            image, (left, right) = image_of(name, preset, folder), row[2 * index : 2 * index + 2]
            theta, _, found = edge_pixels(image, search, 200.0)
            count = f"{len(found)} edge pixels"
            draw_edge_pixels(
                right, image, camera, pixels=search.pixels[found], theta=theta, title=count
            )
            draw_camera_image(left, image, f"{name}, {caption}")
            left.set_xlim(right.get_xlim())
            left.set_ylim(right.get_ylim())
    return figure


def write_jpeg(path: Path, figure: Any, quality: int) -> None:
    """Write a figure, whole or not at all."""
    pixels = cv2.imdecode(np.frombuffer(png_bytes(figure, dpi=110), np.uint8), cv2.IMREAD_COLOR)
    _, data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])
    with replacing(path) as part:
        part.write_bytes(data.tobytes())


@click.command()
@click.option("--quality", type=click.IntRange(1, 100), default=85, show_default=True)
@click.option("-o", "--output", type=click.Path(path_type=Path), default="out/images")
def main(*, quality: int, output: Path) -> None:
    """Render the page; frames and bakes go to OUTPUT first."""
    output.mkdir(parents=True, exist_ok=True)
    target = HERE / "images"
    target.mkdir(exist_ok=True)
    with progress_bar("pictures") as bar:
        task = bar.add_task("images", total=3)
        for name, make in (
            ("presets", lambda: comparison(output)),
            ("stand-ins", lambda: sheet("Stand-ins for the real places", STAND_INS, output)),
            ("simulated", lambda: sheet("Simulated places", SIMULATED, output)),
        ):
            write_jpeg(target / f"{name}.jpg", make(), quality)
            bar.advance(task)
    samples = {"samples": PRESETS["reference"].samples, "fast": PRESETS["fast"].samples}
    write_text(HERE / "images.md", PAGE.format(**samples))
    click.echo(HERE / "images.md")


if __name__ == "__main__":
    main()
