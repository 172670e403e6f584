"""``roomseg export``: an apartment in the formats of other programs."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import click

from roomseg.cli.options import FiniteRange, OutputFile

WRITERS = {
    ".blend": "render.scene_export:write_scene",
    ".glb": "render.scene_export:write_scene",
    ".geojson": "scenes.exporters.geojson:write_geojson",
    ".svg": "scenes.exporters.svg:write_svg",
    ".yaml": "scenes.exporters.ros_map:write_ros_map",
}
"""Where the writer of a suffix is; one that writes several files returns their paths."""

EXAMPLE = """\b
Example:
  roomseg export home7.json -o home7.blend
  roomseg export sim4 -o sim4.yaml --resolution 0.02
  roomseg export home7.json -o home7.svg -o home7.geojson
"""


@click.command("export", epilog=EXAMPLE)
@click.argument("apartment")
@click.option(
    "-o",
    "--output",
    "outputs",
    type=OutputFile(),
    multiple=True,
    required=True,
    help=f"What to write: {', '.join(WRITERS)}; can be given several times.",
)
@click.option(
    "--resolution",
    type=FiniteRange(0.001, 1.0),
    help="Of a grid map, metres per cell; 0.05 if absent.",
)
def command(*, apartment: str, outputs: tuple[Path, ...], **options: Any) -> None:
    """Write APARTMENT, a file or the name of a reference place, for other programs.

    The suffix says what: Blender, glTF, GeoJSON, an SVG plan, or a ROS map (YAML with
    its picture, and the rooms as a picture with a table).
    """
    from scenes import load_apartment

    given = {key: value for key, value in options.items() if value is not None}
    for output in outputs:
        _check_suffix(output, given)
    place = load_apartment(apartment)
    for output in outputs:
        written = _writer(output)(place, output, **given)
        for path in written if isinstance(written, Iterable) else (output,):
            click.echo(f"{path}: written")


def _writer(output: Path) -> Any:
    module, name = WRITERS[output.suffix.lower()].split(":")
    return getattr(importlib.import_module(module), name)


def _check_suffix(output: Path, options: dict[str, Any]) -> None:
    """Refuse what cannot be written before anything is written."""
    if output.suffix.lower() not in WRITERS:
        raise click.UsageError(f"{output}: expected a suffix of {', '.join(WRITERS)}")
    for key in options:
        if key not in inspect.signature(_writer(output)).parameters:
            raise click.UsageError(f"--{key}: has no meaning for {output.suffix}")
