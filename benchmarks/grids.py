"""Occupancy grids that are no apartments: a long corridor, a cluttered lab, a huge hall.

They are drawn as a robot's mapping would leave them, with ragged walls and specks, written
as ROS maps (a PGM picture and its YAML file), and imported.

    python benchmarks/grids.py -o out/grids
    python benchmarks/coverage.py --starts 1 -o out/grids out/grids/*.json
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

# Some files here have the names of packages, which Python would find first.
sys.path[:] = [folder for folder in sys.path if Path(folder) != Path(__file__).resolve().parent]

import click
import cv2
import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]

RESOLUTION = 0.05
"""m per cell."""
OCCUPIED, UNKNOWN, FREE = 0, 205, 254
YAML = """image: {name}.pgm
resolution: {resolution}
origin: [-3.0, 2.0, {yaw}]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""


def corridor(rng: np.random.Generator, size: float) -> Mask:
    """A corridor of 2 m width, of ``size`` x 60 m, with a room every 5 m."""
    length = round(size * 1200)
    free = np.zeros((130, length + 40), np.bool_)
    free[70:110, 20:-20] = True
    for left in range(30, length - 60, 100):
        depth, door = rng.integers(24, 50), left + rng.integers(0, 50)
        free[66 - depth : 66, left : left + 70] = True
        free[64:72, door : door + 18] = True
    return free


def lab(rng: np.random.Generator, size: float) -> Mask:
    """A room of 18 x 13 m, of ``size`` times its area, full of benches, boxes and legs."""
    rows, columns = (round(side * np.sqrt(size)) for side in (260, 360))
    free = np.pad(np.ones((rows, columns), np.bool_), 20)
    for largest, count in ((24, 60), (8, 60), (1, 60)):
        for _ in range(round(size * count)):
            y, x = rng.integers(20, rows), rng.integers(20, columns)
            deep, wide = rng.integers(1, largest + 1, 2)
            free[y : y + deep, x : x + wide] = False
    return free


def hall(rng: np.random.Generator, size: float) -> Mask:
    """A hall of 30 x 20 m, of ``size`` times its area, with pillars and some racks."""
    rows, columns = (round(side * np.sqrt(size)) for side in (400, 600))
    free = np.pad(np.ones((rows, columns), np.bool_), 20)
    for y in range(100, rows, 150):
        for x in range(100, columns, 150):
            wide = 12 if rng.random() < 0.8 else 80
            free[y : y + 12, x : x + wide] = False
    return free


GRIDS: dict[str, Callable[[np.random.Generator, float], Mask]] = {
    "corridor": corridor,
    "lab": lab,
    "hall": hall,
}
"""How each grid is drawn: called with noise and size."""


def write_grid(name: str, folder: Path, size: float = 1.0) -> Path:
    """Draw a grid and write it as a ROS map; returns the YAML file.

    Parameters
    ----------
    name : str
        One of `GRIDS`.
    folder : Path
    size : float
        Of the floor; 1: as it should be.
    """
    rng = np.random.default_rng(0)
    cells = _as_mapped(GRIDS[name](rng, size), rng)
    header = b"P5\n%d %d\n255\n" % cells.shape[::-1]
    (folder / f"{name}.pgm").write_bytes(header + cells.tobytes())
    path = folder / f"{name}.yaml"
    yaw = 0.3 if name == "lab" else 0.0
    path.write_text(YAML.format(name=name, resolution=RESOLUTION, yaw=yaw), encoding="utf-8")
    return path


def _as_mapped(free: Mask, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Walls around the floor, a cell ragged here and there, and a few specks."""
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    wall = (cv2.dilate(free.astype(np.uint8), cross) > 0) & ~free
    beside = (cv2.dilate(wall.astype(np.uint8), cross) > 0) & free
    cells = np.full(free.shape, UNKNOWN, np.uint8)
    cells[free] = FREE
    cells[wall | (beside & (rng.random(free.shape) < 0.1))] = OCCUPIED
    cells[free & (rng.random(free.shape) < 0.0005)] = OCCUPIED
    return cells


def roomseg(*arguments: str) -> None:
    subprocess.run([sys.executable, "-m", "roomseg.cli", *arguments], check=True)


@click.command()
@click.option("--size", default=1.0, show_default=True, help="Of the floors.")
@click.option("-o", "--output", type=click.Path(path_type=Path), default="out/grids")
def main(size: float, output: Path) -> None:
    output.mkdir(parents=True, exist_ok=True)
    for name in GRIDS:
        grid = write_grid(name, output, size)
        roomseg("import", str(grid), "-o", str(grid.with_suffix(".json")))


if __name__ == "__main__":
    main()
