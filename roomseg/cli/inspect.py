"""``roomseg inspect``: what is in a map file."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from roomseg.cli.options import json_option
from roomseg.cli.output import write_json

if TYPE_CHECKING:
    from dataset.inspection import Summary

EXAMPLE = """\b
Example:
  roomseg inspect maps/sim4-run1.h5
  roomseg inspect maps/sim4-run1.h5 --json sim4-run1.json
"""


@click.command("inspect", epilog=EXAMPLE)
@click.argument("map_file", metavar="MAP", type=click.Path(path_type=Path))
@json_option
def command(*, map_file: Path, json_file: Path | None) -> None:
    """Show what is in a map file."""
    from dataset import summarise

    summary = summarise(map_file)
    write_json(json_file, asdict(summary))
    for name, value in _lines(summary):
        click.echo(f"{name:<14}{value}")


def _lines(summary: Summary) -> list[tuple[str, str]]:
    s = summary
    length = "" if s.median_edge_length is None else f", median length {s.median_edge_length:.3f} m"
    driven = "" if s.path_length is None else f", {s.path_length:.1f} m driven"
    return [
        ("file", f"{s.file}, {s.file_size / 1e6:.1f} MB"),
        ("environment", s.environment),
        ("run", f"{s.run}, seed {s.seed}, {s.duration:.0f} s{driven}"),
        ("made", f"{s.created} by {s.software}"),
        ("nodes", f"{s.node_count} in {s.lane_count} lanes of {s.part_count} parts"),
        ("visits", str(s.visit_count)),
        ("edges", f"{s.edge_count}{length}"),
        ("obstacles", f"{s.obstacle_count} points"),
        ("camera", f"{s.image_size[0]} x {s.image_size[1]} px, disc {s.disc_diameter:g} px"),
        ("images", _images(s)),
        ("ground truth", _ground_truth(s)),
        ("rooms found", "no" if s.segmented_by is None else f"by {s.segmented_by}"),
        ("scene", "inside" if s.has_scene else "no"),
    ]


def _images(summary: Summary) -> str:
    text = f"{summary.images_done} of {summary.node_count}"
    text += f", preset {summary.preset}" if summary.preset else ""
    more = "; more in the journal, `roomseg render` goes on with them"
    return text + (more if summary.journal else "")


def _ground_truth(summary: Summary) -> str:
    if summary.room_count is None:
        return "no"
    labels = "nodes labelled" if summary.nodes_labelled else "nodes not labelled"
    return f"{summary.room_count} rooms, {summary.border_edge_count} border edges, {labels}"
