"""``roomseg generate``: make up an apartment."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from roomseg.cli.options import output_option, seed_option

if TYPE_CHECKING:
    from scenes.palettes import Contrast, Source

AREA_PER_ROOM = 12.5
"""Clear floor per room if nothing else is asked for, m²."""

EXAMPLE = """\b
Example:
  roomseg generate --seed 7 --rooms 5 -o home7.json
  roomseg generate --seed 8 --rooms 3 --area 40 --lighting interior -o home8.json
"""


@click.command("generate", epilog=EXAMPLE)
@seed_option
@click.option(
    "--rooms", type=click.IntRange(1, 12), default=4, show_default=True, help="How many rooms."
)
@click.option(
    "--area",
    type=click.FloatRange(6.0, 360.0),
    help="Clear floor, m², 5 to 30 per room; 12.5 per room if absent.",
)
@click.option(
    "--contrast",
    type=click.Choice(["low", "medium", "high"]),
    default="medium",
    show_default=True,
    help="How much doorways stand out in the images.",
)
@click.option(
    "--lighting",
    type=click.Choice(["interior", "exterior", "mixed"]),
    default="exterior",
    show_default=True,
    help="Lamps, sun and sky, or both.",
)
@output_option("The apartment, JSON.")
def command(
    *, seed: int, rooms: int, area: float | None, contrast: Contrast, lighting: Source, output: Path
) -> None:
    """Make up an apartment that could be real."""
    from scenes import save_apartment
    from scenes.generator import generate_apartment

    apartment = generate_apartment(
        seed,
        rooms=rooms,
        area=AREA_PER_ROOM * rooms if area is None else area,
        contrast=contrast,
        lighting=lighting,
    )
    save_apartment(apartment, output)
    click.echo(f"{output}: {len(apartment.rooms)} rooms, {len(apartment.furniture)} pieces")
