"""Seconds and quality of every full-size preset beside a long denoised reference.

Renders the view from a doorway of `sim3` and prints, for each number of
samples, seconds per image, and against the reference: PSNR, false and missed
edge pixels (Scharr > 200 in the 38° ceiling cone of §2.2.3), and the distance
of the equalised panoramas.

    python benchmarks/render_presets.py                      # about three minutes on two cores
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

# Some files here have the names of packages, which Python would find first.
sys.path[:] = [folder for folder in sys.path if Path(folder) != Path(__file__).resolve().parent]

import click
import cv2
import numpy as np

from dataset.camera import SIMULATED_CAMERA
from render.exposure import expose
from render.presets import PRESETS, Preset
from render.process import Job, RenderProcess
from roomseg.cli.output import write_table
from roomseg.panorama import PanoramaParameters, Unfolding
from scenes import load_apartment

DOORWAY = np.array([4.75, 3.13, 0.0])
REFERENCE_SAMPLES = 64
VIEWS = 4


def render(preset: Preset) -> tuple[np.ndarray, float]:
    """Exposed image at the doorway, and seconds per image once the scene is ready."""
    poses = np.tile(DOORWAY, (VIEWS + 1, 1))
    with RenderProcess(Job(load_apartment("sim3"), SIMULATED_CAMERA, preset)) as process:
        frames: Iterator = process.frames(list(range(VIEWS + 1)), poses)
        next(frames)
        begin = time.perf_counter()
        *_, (_, radiance) = frames
        seconds = (time.perf_counter() - begin) / VIEWS
    return expose(radiance, SIMULATED_CAMERA)[0], seconds


def edges(image: np.ndarray) -> np.ndarray:
    inside = SIMULATED_CAMERA.pixel_zenith() < np.radians(19.0)
    gradient = (cv2.Scharr(image, cv2.CV_32F, *axis) for axis in ((1, 0), (0, 1)))
    return np.hypot(*gradient)[inside] > 200


def panorama(image: np.ndarray) -> np.ndarray:
    return Unfolding.of(SIMULATED_CAMERA, PanoramaParameters())(image).astype(float)


@click.command()
def main() -> None:
    """Print one row per preset; the reference is rendered first."""
    full_size = [p for p in PRESETS.values() if p.disc_diameter is None and p.bake is None]
    reference, _ = render(replace(full_size[0], name="truth", samples=REFERENCE_SAMPLES))
    disc = SIMULATED_CAMERA.pixel_zenith() < np.radians(95.0)
    rows = []
    for preset in full_size:
        image, seconds = render(preset)
        error = np.mean((image[disc].astype(float) - reference[disc]) ** 2)
        ours, true = edges(image), edges(reference)
        rows.append(
            (
                f"{preset.name}, {preset.samples} samples",
                f"{seconds:.2f}",
                f"{10.0 * np.log10(255.0**2 / error):.1f}",
                str(np.count_nonzero(ours & ~true)),
                str(np.count_nonzero(true & ~ours)),
                f"{np.linalg.norm(panorama(image) - panorama(reference)):.0f}",
            )
        )
    title = f"sim3, doorway, against {REFERENCE_SAMPLES} samples ({true.sum()} edge pixels)"
    write_table(title, ("preset", "s/image", "PSNR dB", "false", "missed", "panorama"), rows)


if __name__ == "__main__":
    main()
