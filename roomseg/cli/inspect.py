"""``roomseg inspect``: what is in a map, an apartment or a dataset."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from roomseg.cli.options import OutputFile, json_option
from roomseg.cli.output import counted, write_json, write_table
from roomseg.cli.sources import is_apartment

if TYPE_CHECKING:
    from dataset.inspection import Summary
    from dataset.topomap import Settings
    from scenes.summary import ApartmentSummary

__all__ = ["apartment_lines", "command", "dataset_lines", "map_lines"]

SUMS = (
    ("places", "{}"),
    ("rooms", "{}"),
    ("floor_area", "{:.0f} m²"),
    ("maps", "{}"),
    ("nodes", "{}"),
    ("edge_count", "{}"),
    ("border_edge_count", "{}"),
    ("images_done", "{}"),
    ("path_length", "{:.0f} m"),
    ("mean_coverage", "{:.2%}"),
    ("largest_drift", "{:.2f} m"),
)
"""What is shown of each split, and how."""

EXAMPLE = """\b
Example:
  roomseg inspect maps/sim4-run1.h5
  roomseg inspect maps/sim4-run1.h5 --json sim4-run1.json
  roomseg inspect home7.json
  roomseg inspect homes -o sheet.png
"""


@click.command("inspect", epilog=EXAMPLE)
@click.argument("source", metavar="MAP|APARTMENT|DATASET", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=OutputFile(".png", ".svg", ".pdf"),
    help="Of a dataset: also draw plans, images and figures on one sheet.",
)
@json_option
def command(*, source: Path, output: Path | None, json_file: Path | None) -> None:
    """Show what is in a map file, an apartment (a file or a reference place), or a dataset.

    A dataset is the folder of `roomseg build`.
    """
    if source.is_dir():
        _inspect_dataset(source, output, json_file)
        return
    if output is not None:
        raise click.UsageError("-o: draws a dataset; `roomseg view` draws a map or an apartment")
    if is_apartment(source):
        _inspect_apartment(source, json_file)
    else:
        from dataset import summarise

        summary = summarise(source)
        write_json(json_file, asdict(summary))
        _echo(map_lines(summary))


def _inspect_dataset(folder: Path, output: Path | None, json_file: Path | None) -> None:
    from roomseg.cli.manifest import read_manifest

    figures = read_manifest(folder)
    write_json(json_file, figures)
    _echo(dataset_lines(folder, figures))
    rows = [
        (split, *(form.format(sums[name]) if sums["maps"] else "-" for name, form in SUMS))
        for split, sums in (figures["splits"] | {"all": figures["total"]}).items()
        if sums["places_wanted"]
    ]
    write_table("", ("split", *(name.replace("_", " ") for name, _ in SUMS)), rows)
    if output is not None:
        from roomseg.cli.overview import write_overview

        write_overview(folder, figures, output)
        click.echo(str(output))


def dataset_lines(folder: Path, figures: dict[str, Any]) -> list[tuple[str, str]]:
    """What there is to tell of a dataset."""
    from roomseg.cli.manifest import changed_files

    d, total = figures, figures["total"]
    wrong = changed_files(folder, figures)
    more = f" and {len(wrong) - 1} more" if len(wrong) > 1 else ""
    files = f"{wrong[0]}{more}: missing or changed" if wrong else "all there"
    return [
        ("dataset", d["name"]),
        *([("about", " ".join(d["description"].split()))] if d["description"] else []),
        ("made", f"seed {d['seed']}, preset {d['preset']}, roomseg {d['libraries']['roomseg']}"),
        ("places", f"{total['places']} of {total['places_wanted']}"),
        ("maps", f"{total['maps']} of {total['maps_wanted']}, {total['bytes'] / 1e6:.1f} MB"),
        ("images", f"{total['images_done']} of {total['nodes']}"),
        ("files", files),
        *(("problem", problem) for problem in d["problems"]),
    ]


def _echo(lines: list[tuple[str, str]]) -> None:
    for name, value in lines:
        click.echo(f"{name:<14}{value}")


def _inspect_apartment(source: Path, json_file: Path | None) -> None:
    from scenes import load_apartment
    from scenes.summary import summarise_apartment

    summary = summarise_apartment(load_apartment(str(source)))
    write_json(json_file, asdict(summary))
    _echo(apartment_lines(summary))
    rows = [
        (
            room.name,
            room.kind,
            f"{room.area:.1f}",
            f"{room.ceiling_height:.2f}",
            f"{room.floor}, {room.walls}, {room.ceiling}",
            ", ".join(room.passages_to),
        )
        for room in summary.rooms
    ]
    columns = ("room", "kind", "m²", "height m", "floor, walls, ceiling", "leads to")
    write_table("", columns, rows)


def apartment_lines(summary: ApartmentSummary) -> list[tuple[str, str]]:
    """What there is to tell of an apartment, but for its rooms."""
    s = summary
    pieces = ", ".join(f"{count} {kind}" for kind, count in s.pieces.items())
    passages = (
        f"{s.passages}, {s.framed_passages} framed, {s.passages_without_lintel} without lintel; "
        f"{s.closed_passages} closed, {counted(s.thresholds, 'threshold')}; "
        f"{counted(s.borders_without_wall, 'border')} without a wall"
    )
    return [
        ("apartment", s.name),
        *([("about", s.description)] if s.description else []),
        ("rooms", f"{len(s.rooms)} on {s.floor_area:.1f} m², {s.free_area:.1f} m² free"),
        ("passages", passages),
        ("windows", str(s.windows)),
        ("light", f"{s.lighting}, {counted(s.lamps, 'lamp')} of {s.lamp_power:.0f} W in all"),
        ("contrast", s.passageway_contrast),
        ("pieces", f"{sum(s.pieces.values())}: {pieces}" if s.pieces else "none"),
        ("3D scene", "its own solids" if s.scene_file is None else s.scene_file),
    ]


def map_lines(summary: Summary) -> list[tuple[str, str]]:
    """What there is to tell of a map."""
    s = summary
    length = "" if s.median_edge_length is None else f", median length {s.median_edge_length:.3f} m"
    driven = "" if s.path_length is None else f", {s.path_length:.1f} m driven"
    return [
        ("file", f"{s.file}, {s.file_size / 1e6:.1f} MB"),
        ("environment", s.environment),
        ("run", f"{s.run}, seed {s.seed}, {s.duration:.0f} s{driven}"),
        ("made", " ".join(part for part in (s.created, "by", s.software) if part)),
        ("nodes", f"{s.node_count} in {s.lane_count} lanes of {s.part_count} parts"),
        ("visits", str(s.visit_count)),
        ("edges", f"{s.edge_count}{length}"),
        ("obstacles", f"{s.obstacle_count} points"),
        *_robot_lines(s),
        ("camera", _camera(s)),
        *([("images", _images(s))] if s.image_size else []),
        ("ground truth", _ground_truth(s)),
        ("rooms found", "no" if s.segmented_by is None else f"by {s.segmented_by}"),
        ("scene", "inside" if s.has_scene else "no"),
    ]


def _robot_lines(summary: Summary) -> list[tuple[str, str]]:
    """The robot and its sensors, by what is unlike the prototype."""
    radius = f"radius {summary.robot_radius:g} m"
    if summary.robot is None:
        return [("robot", radius)]
    from simulator import RobotSpec, SensorSpec, settings_of

    usual = {**settings_of(RobotSpec()), "radius": summary.robot_radius}
    robot = ("robot", f"{radius}; {_unlike(summary.robot, usual)}")
    if summary.sensor is None:
        return [robot]
    return [robot, ("sensors", _unlike(summary.sensor, settings_of(SensorSpec())))]


def _unlike(settings: Settings, usual: Settings) -> str:
    other = [f"{name} {value}" for name, value in settings.items() if usual.get(name) != value]
    return f"unlike the prototype: {', '.join(other)}" if other else "else as the prototype"


def _camera(summary: Summary) -> str:
    if summary.image_size is None:
        return "no"
    rows, columns = summary.image_size
    return f"{rows} x {columns} px, disc {summary.disc_diameter:g} px"


def _images(summary: Summary) -> str:
    text = f"{summary.images_done} of {summary.node_count}"
    text += f", preset {summary.preset}" if summary.preset else ""
    text += ", with their radiance" if summary.keeps_radiance else ""
    more = "; more in the journal, `roomseg render` goes on with them"
    return text + (more if summary.journal else "")


def _ground_truth(summary: Summary) -> str:
    if summary.room_count is None:
        return "no"
    labels = "nodes labelled" if summary.nodes_labelled else "nodes not labelled"
    rooms = counted(summary.room_count, "room")
    return f"{rooms}, {counted(summary.border_edge_count or 0, 'border edge')}, {labels}"
