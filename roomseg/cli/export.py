"""``roomseg export``: an apartment, or a map, in the formats of other programs."""

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
    "blend": "render.scene_export:write_scene",
    "glb": "render.scene_export:write_scene",
    "geojson": "scenes.exporters.geojson:write_geojson",
    "svg": "scenes.exporters.svg:write_svg",
    "ros": "scenes.exporters.ros_map:write_ros_map",
}
"""Where the writer of a format is; one that writes several files returns their paths."""
MAP_WRITERS = {
    "rerun": "roomseg.cli.recording:write_recording",
    "graphml": "roomseg.cli.map_exports:write_graphml",
    "node-link": "roomseg.cli.map_exports:write_node_link",
    "valetudo": "roomseg.cli.map_exports:write_valetudo",
    "images": "roomseg.cli.map_exports:write_views",
    "geojson": "roomseg.cli.map_exports:write_geojson",
    "ros": "roomseg.cli.map_exports:write_ros_map",
}
"""The same for what is made of a map; these read it themselves."""
SUFFIXES = {
    ".blend": "blend",
    ".glb": "glb",
    ".geojson": "geojson",
    ".svg": "svg",
    ".yaml": "ros",
    ".rrd": "rerun",
    ".graphml": "graphml",
    ".json": "node-link",
    ".csv": "images",
}
FORMATS = [*WRITERS, *(name for name in MAP_WRITERS if name not in WRITERS)]

EXAMPLE = """\b
Example:
  roomseg export home7.json -o home7.blend
  roomseg export sim4 -o sim4.yaml --resolution 0.02
  roomseg export home7.json -o home7.svg -o home7.geojson
  roomseg export maps/sim4-run1.h5 -o run.rrd
  roomseg export maps/sim4-run1.h5 -o rooms.geojson -o graph.graphml
"""


@click.command("export", epilog=EXAMPLE)
@click.argument("source", metavar="APARTMENT|MAP")
@click.option(
    "-o",
    "--output",
    "outputs",
    type=OutputFile(),
    multiple=True,
    help=f"What to write: {', '.join(SUFFIXES)}; can be given several times.",
)
@click.option(
    "--format",
    "format_",
    type=click.Choice(FORMATS),
    help="What to write; by the suffix if absent.",
)
@click.option("--rerun", is_flag=True, help="Write a Rerun recording beside MAP: -o MAP.rrd.")
@click.option(
    "--resolution",
    type=FiniteRange(0.001, 1.0),
    help="Of a grid map, metres per cell; 0.05 if absent.",
)
@click.option(
    "--rooms",
    type=click.Choice(["truth", "found"]),
    help="Of MAP: those of the ground truth (if absent and there is one), or of `segment`.",
)
def command(
    *, source: str, outputs: tuple[Path, ...], format_: str | None, rerun: bool, **options: Any
) -> None:
    """Write APARTMENT, a file or the name of a reference place, or MAP for other programs.

    The suffix says what. Of an apartment: Blender, glTF, GeoJSON, an SVG plan, or a
    ROS map (YAML with its picture, and the rooms as a picture with a table). Of a map:
    its run as a Rerun recording, its graph as GraphML or node-link JSON, its images
    with a table (CSV), its rooms as GeoJSON, as a ROS map or as a Valetudo map
    (--format valetudo).
    """
    if rerun:
        if not Path(source).is_file():
            raise click.UsageError(f"{source or 'MAP'}: no such file, expected a map for --rerun")
        outputs += (OutputFile().convert(Path(source).with_suffix(".rrd"), None, None),)
    if not outputs:
        raise click.UsageError("-o/--output: missing, expected what to write")
    given = {key: value for key, value in options.items() if value is not None}
    writers = [_writer(output, source, format_, given) for output in outputs]
    for output, writer in zip(outputs, writers, strict=True):
        written = writer(_read(source), output, **given)
        for path in written if isinstance(written, Iterable) else (output,):
            click.echo(f"{path}: written")


def _read(source: str) -> Any:
    """What the writer takes: the map's path, or the apartment."""
    if not is_apartment(Path(source)):
        return Path(source)
    from scenes import load_apartment

    return load_apartment(source)


def _writer(output: Path, source: str, format_: str | None, options: dict[str, Any]) -> Any:
    """Find the writer; refuse what cannot be written before anything is."""
    suffix = output.suffix.lower()
    if format_ is None and suffix not in SUFFIXES:
        raise click.UsageError(f"{output}: expected a suffix of {', '.join(SUFFIXES)}, or --format")
    format_ = format_ or SUFFIXES[suffix]
    of_apartment = is_apartment(Path(source))
    writers = WRITERS if of_apartment else MAP_WRITERS
    if format_ not in writers:
        one, other = ("a map", "an apartment") if of_apartment else ("an apartment", "a map")
        raise click.UsageError(f"{output}: is made of {one}, not of {other} ({source})")
    module, name = writers[format_].split(":")
    writer = getattr(importlib.import_module(module), name)
    for key in options:
        if key not in inspect.signature(writer).parameters:
            raise click.UsageError(f"--{key}: has no meaning for {format_}")
    return writer
