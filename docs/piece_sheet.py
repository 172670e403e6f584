"""The picture of docs/pieces.md: every kind of piece at its default size.

python docs/piece_sheet.py
"""

from __future__ import annotations

from pathlib import Path

import click

from render.piece_sheet import draw_piece_sheet


@click.command()
@click.option("--cell", type=click.IntRange(16), default=130, show_default=True, help="px")
@click.option("--samples", type=click.IntRange(1), default=32, show_default=True)
@click.option("-o", "--output", type=click.Path(path_type=Path))
def main(*, cell: int, samples: int, output: Path | None) -> None:
    """Render the contact sheet, to docs/pieces.jpg unless OUTPUT says."""
    path = output or Path(__file__).resolve().parent / "pieces.jpg"
    draw_piece_sheet(path, cell=cell, samples=samples)
    click.echo(path)


if __name__ == "__main__":
    main()
