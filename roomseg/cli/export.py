"""``roomseg export``: an apartment, or a run, in the formats of other programs."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import click

from roomseg.cli.options import FiniteRange, OutputFile
from roomseg.cli.sources import is_apartment

WRITERS = {
    ".blend": "render.scene_export:write_scene",
    ".glb": "render.scene_export:write_scene",
    ".geojson": "scenes.exporters.geojson:write_geojson",
    ".svg": "scenes.exporters.svg:write_svg",
    ".yaml": "scenes.exporters.ros_map:write_ros_map",
}
"""Where the writer of a suffix is; one that writes several files returns their paths."""
MAP_WRITERS = {".rrd": "roomseg.cli.recording:write_recording"}
"""The same for what is made of a map; these read it themselves."""

EXAMPLE = """\b
Example:
  roomseg export home7.json -o home7.blend
  roomseg export sim4 -o sim4.yaml --resolution 0.02
  roomseg export home7.json -o home7.svg -o home7.geojson
  roomseg export maps/sim4-run1.h5 -o run.rrd
"""


@click.command("export", epilog=EXAMPLE)
@click.argument("source", metavar="APARTMENT|MAP")
@click.option(
    "-o",
    "--output",
    "outputs",
    type=OutputFile(),
    multiple=True,
    help=f"What to write: {', '.join([*WRITERS, *MAP_WRITERS])}; can be given several times.",
)
@click.option("--rerun", is_flag=True, help="Write a Rerun recording beside MAP: -o MAP.rrd.")
@click.option(
    "--resolution",
    type=FiniteRange(0.001, 1.0),
    help="Of a grid map, metres per cell; 0.05 if absent.",
)
def command(*, source: str, outputs: tuple[Path, ...], rerun: bool, **options: Any) -> None:
    """Write APARTMENT, a file or the name of a reference place, or MAP for other programs.

    The suffix says what. Of an apartment: Blender, glTF, GeoJSON, an SVG plan, or a
    ROS map (YAML with its picture, and the rooms as a picture with a table). Of a map:
    its run as a Rerun recording.
    """
    if rerun:
        if not Path(source).is_file():
            raise click.UsageError(f"{source or 'MAP'}: no such file, expected a map for --rerun")
        outputs += (OutputFile().convert(Path(source).with_suffix(".rrd"), None, None),)
    if not outputs:
        raise click.UsageError("-o/--output: missing, expected what to write")
    given = {key: value for key, value in options.items() if value is not None}
    for output in outputs:
        _check_suffix(output, source, given)
    for output in outputs:
        written = _writer(output)(_read(source, output), output, **given)
        for path in written if isinstance(written, Iterable) else (output,):
            click.echo(f"{path}: written")


def _read(source: str, output: Path) -> Any:
    """What the writer takes: the map's path, or the apartment."""
    if output.suffix.lower() in MAP_WRITERS:
        return Path(source)
    from scenes import load_apartment

    return load_apartment(source)


def _writer(output: Path) -> Any:
    module, name = (WRITERS | MAP_WRITERS)[output.suffix.lower()].split(":")
    return getattr(importlib.import_module(module), name)


def _check_suffix(output: Path, source: str, options: dict[str, Any]) -> None:
    """Refuse what cannot be written before anything is written."""
    known = [*WRITERS, *MAP_WRITERS]
    if output.suffix.lower() not in known:
        raise click.UsageError(f"{output}: expected a suffix of {', '.join(known)}")
    if output.suffix.lower() in MAP_WRITERS and is_apartment(Path(source)):
        raise click.UsageError(f"{output}: is made of a map, not of an apartment ({source})")
    for key in options:
        if key not in inspect.signature(_writer(output)).parameters:
            raise click.UsageError(f"--{key}: has no meaning for {output.suffix}")
