"""The gallery: cut-away pictures of the reference places and of made-up apartments.

Pictures are rendered into a folder of their own under names that carry a hash of
what they show, so that a stopped gallery goes on where it was and only what has
changed is rendered again. Then ``docs/gallery.md`` and its JPEGs are written.

    python docs/gallery.py
    python docs/gallery.py --size 350 --samples 4    # a quick look
"""

from __future__ import annotations

import hashlib
import textwrap
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import cv2
import numpy as np

from dataset.atomic import replacing, write_text
from render.cutaway import draw_cutaway
from roomseg.cli.output import progress_bar
from roomseg.figures import new_figure, png_bytes
from scenes import (
    Apartment,
    apartment_to_json,
    floor_area,
    generate_apartment,
    load_apartment,
    reference_names,
)

HERE = Path(__file__).resolve().parent
SHEET = (4, 3)
"""Columns and rows of a sheet of made-up apartments."""
THUMBNAIL = 0.65
"""Size of a sheet's pictures beside that of the places'."""
LOOK = 1
"""To be raised when `render.cutaway` changes what pictures look like."""

INTRODUCTION = """# Gallery

Every picture is what `roomseg view NAME --cutaway -o picture.jpg` shows: the apartment from
above, its walls cut at 1.6 m. `python docs/gallery.py` makes this page; a stopped gallery goes
on where it was.

## The reference places

"""
MADE_UP = """
## Made up by seed

`roomseg generate --seed N -o home.json`, nothing else given.

"""


@dataclass(frozen=True)
class Shown:
    """An apartment and the picture of it."""

    apartment: Apartment
    picture: Path

    @property
    def caption(self) -> str:
        """What it is, in a few words."""
        rooms = len(self.apartment.rooms)
        area = f"{floor_area(self.apartment):.0f} m²"
        return f"{self.apartment.name}: {rooms} room{'s' * (rooms > 1)}, {area}"


def render_all(
    what: str, apartments: list[Apartment], folder: Path, *, size: int, samples: int
) -> list[Shown]:
    """Render what is not there yet."""
    shown = []
    with progress_bar("pictures") as bar:
        task = bar.add_task(what, total=len(apartments))
        for apartment in apartments:
            content = f"{LOOK} {size} {samples} {apartment_to_json(apartment)}"
            mark = hashlib.sha256(content.encode()).hexdigest()[:16]
            picture = folder / f"{apartment.name}-{mark}.png"
            if not picture.exists():
                draw_cutaway(apartment, picture, size=size, samples=samples)
            shown.append(Shown(apartment, picture))
            bar.advance(task)
    return shown


def write_jpeg(path: Path, pixels: Any, quality: int) -> None:
    """Write a picture, whole or not at all."""
    _, data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])
    with replacing(path) as part:
        part.write_bytes(data.tobytes())


def sheet(shown: list[Shown]) -> Any:
    """A contact sheet of pictures with captions, pixels (h, w, 3)."""
    columns, rows = SHEET
    figure = new_figure(3.5 * columns, 2.75 * rows)
    figure.set_facecolor("#F5F5F4")  # the ground of the pictures
    for index, item in enumerate(shown):
        ax = figure.add_subplot(rows, columns, index + 1)
        ax.imshow(cv2.imread(str(item.picture))[..., ::-1], interpolation="antialiased")
        ax.set_title(item.caption, fontsize=9)
        ax.set_axis_off()
    encoded = np.frombuffer(png_bytes(figure, dpi=115), np.uint8)
    return cv2.imdecode(encoded, cv2.IMREAD_COLOR)


def write_page(places: list[Shown], homes: list[Shown], quality: int) -> None:
    """Write the JPEGs and the page that shows them."""
    target = HERE / "gallery"
    target.mkdir(exist_ok=True)
    text = INTRODUCTION
    for item in places:
        name = item.apartment.name
        write_jpeg(target / f"{name}.jpg", cv2.imread(str(item.picture)), quality)
        light, contrast = item.apartment.lighting.source, item.apartment.passageway_contrast
        words = f"**{item.caption}**, {light} light, {contrast} passageway contrast. "
        text += textwrap.fill(words + item.apartment.description, 98)
        text += f"\n\n![{name}](gallery/{name}.jpg)\n\n"
    text += MADE_UP.lstrip("\n")
    each = SHEET[0] * SHEET[1]
    for number, first in enumerate(range(0, len(homes), each), start=1):
        part = homes[first : first + each]
        write_jpeg(target / f"homes-{number}.jpg", sheet(part), quality)
        names = f"{part[0].apartment.name} to {part[-1].apartment.name}"
        text += f"![Apartments {names}](gallery/homes-{number}.jpg)\n\n"
    write_text(HERE / "gallery.md", text.rstrip("\n") + "\n")


@click.command()
@click.option("--seeds", type=click.IntRange(1), default=24, show_default=True)
@click.option("--size", type=click.IntRange(64), default=700, show_default=True, help="px")
@click.option("--samples", type=click.IntRange(1), default=24, show_default=True)
@click.option("--quality", type=click.IntRange(1, 100), default=80, show_default=True)
@click.option("-o", "--output", type=click.Path(path_type=Path), default="out/gallery")
def main(*, seeds: int, size: int, samples: int, quality: int, output: Path) -> None:
    """Render the gallery; pictures go to OUTPUT first."""
    output.mkdir(parents=True, exist_ok=True)
    names = [name for name in reference_names() if not name.startswith("demo")]
    names.sort(key=lambda name: (name.startswith("novel"), name.startswith("real"), name))
    places = [load_apartment(name) for name in names]
    homes = [generate_apartment(seed) for seed in range(1, seeds + 1)]
    small = round(THUMBNAIL * size)
    write_page(
        render_all("places", places, output, size=size, samples=samples),
        render_all("seeds", homes, output, size=small, samples=samples),
        quality,
    )
    click.echo(HERE / "gallery.md")


if __name__ == "__main__":
    main()
