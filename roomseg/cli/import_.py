"""``roomseg import``: an apartment from a map, plan or scene; a map from a robot's run."""

from __future__ import annotations

import importlib
import inspect
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from roomseg.cli.options import FiniteRange, output_option
from roomseg.cli.output import counted

if TYPE_CHECKING:
    from collections.abc import Callable

    from dataset.importers import ImportedRun
    from scenes.importers import Imported

    Reader = Callable[..., Imported]

READERS = {
    "grid": "scenes.importers.ros_map:read_ros_map",
    "geojson": "scenes.importers.geojson:read_geojson",
    "cubicasa": "scenes.importers.cubicasa:read_cubicasa",
    "houseexpo": "scenes.importers.houseexpo:read_houseexpo",
    "resplan": "scenes.importers.resplan:read_resplan",
    "r2v": "scenes.importers.r2v:read_r2v",
    "scene": "render.scene_import:read_scene",
}
"""Where the reader of a format is; each takes the options that it can use."""

RUNS = {
    "valetudo": "dataset.importers.valetudo:read_valetudo",
    "rosbag": "dataset.importers.rosbag:read_rosbag",
}
"""The same for runs of robots, which become maps."""

SUFFIXES = {
    ".yaml": "grid",
    ".yml": "grid",
    ".pgm": "grid",
    ".png": "grid",
    ".geojson": "geojson",
    ".svg": "cubicasa",
    ".txt": "r2v",
    ".bag": "rosbag",
}
"""Formats by suffix, but for those of 3D scenes; ``.json`` says by its content what it is."""

UPRIGHT = (".obj", ".ply", ".stl")
"""3D scenes that do not say which axis points up."""

OPTIONS = {"ceiling_height": "--ceiling"}
"""Options that are not called as the readers' parameters are."""

FILE_OR_FOLDER = click.Path(exists=True, path_type=Path)
EXISTING = click.Path(exists=True, dir_okay=False, path_type=Path)

EXAMPLE = """\b
Example:
  roomseg import map.yaml -o home.json
  roomseg import grid.png --scale 0.05 --labels rooms.png -o home.json
  roomseg import plan.geojson --furnish -o home.json
  roomseg import flat.glb --start 1.5,2 -o home.json
  roomseg import valetudo.json --name home -o monday.h5
  roomseg import monday.bag --topics robot.toml -o monday.h5
"""


class PointType(click.ParamType[tuple[float, float]]):
    """A point as ``X,Y``."""

    name = "x,y"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, float]:
        """Refuse anything but two finite numbers."""
        try:
            x, y = (float(part) for part in str(value).split(","))
        except ValueError:
            x = y = float("nan")
        if not (abs(x) <= 1000.0 and abs(y) <= 1000.0):
            self.fail(f"{value!r}; expected two numbers, such as 1.5,2", param, ctx)
        return x, y


class NameType(click.ParamType[str]):
    """A name that an apartment can have."""

    name = "text"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Refuse what the name of a file could not be."""
        if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}", str(value)):
            self.fail(f"{value!r}; expected letters, digits, '_', '.', '-', at most 64", param, ctx)
        return str(value)


@click.command("import", epilog=EXAMPLE)
@click.argument("file", type=FILE_OR_FOLDER)
@output_option("The apartment (.json) or, of a run, the map (.h5).", ".json", ".h5")
@click.option(
    "--format",
    "format_",
    type=click.Choice([*READERS, *RUNS]),
    help="What FILE is; by its suffix and content if absent.",
)
@click.option("--name", type=NameType(), help="Of the apartment or place; that of FILE if absent.")
@click.option("--start", type=PointType(), help="Where the robot starts, m.")
@click.option(
    "--scale",
    "--resolution",
    "scale",
    type=FiniteRange(0, min_open=True),
    help="Metres per unit or pixel of FILE.",
)
@click.option("--ceiling", "ceiling_height", type=FiniteRange(1, 20), help="Its height, m.")
@click.option(
    "--borders", type=EXISTING, help="Lines between rooms: CSV or JSON, x0,y0,x1,y1 in m."
)
@click.option("--labels", type=EXISTING, help="Picture of the rooms, as large as the map.")
@click.option("--label-table", type=EXISTING, help="What its values mean: value,name,kind.")
@click.option(
    "--furnish/--no-furnish",
    default=None,
    help="Floor plans: whether fixtures become furniture; they do if absent.",
)
@click.option(
    "--add-doors",
    is_flag=True,
    default=None,
    help="Floor plans: open a door to rooms without one, instead of leaving them out.",
)
@click.option("--plan", help="ResPlan: id of the plan, in a file that has several.")
@click.option(
    "--floor-clearance", type=FiniteRange(0, 1), help="3D scenes: what is lower is floor, m."
)
@click.option(
    "--floor",
    type=FiniteRange(-1000, 1000),
    help="3D scenes: height of the floor, m; found if absent.",
)
@click.option("--up", type=click.Choice(["Y", "Z"]), help="OBJ, PLY, STL: the axis upwards.")
@click.option(
    "--robot-height",
    type=FiniteRange(0, 3),
    help="3D scenes: obstacles are lower, m.",
)
@click.option("--robot-radius", type=FiniteRange(0.05, 1), help="Valetudo: of the body, m.")
@click.option("--topics", type=EXISTING, help="ROS bag: TOML that names its topics.")
def command(*, file: Path, output: Path, format_: str | None, **options: Any) -> None:
    """Make an apartment of FILE, or a map if it is a robot's run.

    FILE is a ROS map (YAML), a grid map (PGM, PNG), a floor plan (GeoJSON, CubiCasa5k
    SVG, HouseExpo or ResPlan JSON, R2V text) or a 3D scene (.blend, .glb, .obj, USD …).
    A run is a Valetudo map with its path, or a ROS bag (a .bag file, or the folder of a
    ROS 2 bag). What cannot be used is told line by line on standard error.
    """
    format_ = format_ or _format_of(file)
    given = {key: value for key, value in options.items() if value is not None}
    _check_company(file, given)
    _check_output(file, format_, output)
    if format_ in RUNS:
        _import_run(file, output, _reader(format_, given), given)
    else:
        _import_apartment(file, output, format_, given)


def _import_run(file: Path, output: Path, reader: Any, given: dict[str, Any]) -> None:
    """Read a run, write its map, and say what is in it."""
    from dataset import write_map

    run: ImportedRun = reader(file, **given)
    for note in run.notes:
        click.echo(f"{file}: {' '.join(note.split())}", err=True)
    topomap = run.topomap
    write_map(output, topomap, run.images)
    rooms = "no ground truth"
    if topomap.ground_truth is not None:
        rooms = counted(topomap.ground_truth.room_count, "room")
    lanes = len({*zip(topomap.nodes.part.tolist(), topomap.nodes.lane.tolist(), strict=True)})
    click.echo(
        f"{output}: {counted(len(topomap.nodes), 'node')}, {counted(len(topomap.edges), 'edge')}, "
        f"{counted(lanes, 'lane')}, {counted(len(topomap.obstacles.time), 'obstacle point')}, "
        f"{rooms}"
    )


def _import_apartment(file: Path, output: Path, format_: str, given: dict[str, Any]) -> None:
    """Read what becomes an apartment, write it, and say what is in it."""
    import numpy as np

    from dataset.errors import RoomsegError
    from scenes import check, floor_area, save_apartment

    reader = _reader(format_, given)
    if format_ == "scene":
        given["output_folder"] = output.parent  # the scene's own file goes beside the apartment's
    # GEOS raises floating-point flags on absurd coordinates; readers refuse what comes of them.
    with np.errstate(all="ignore"):
        result = reader(file, **given)
    for note in result.notes:
        click.echo(f"{file}: {' '.join(note.split())}", err=True)
    apartment = result.apartment
    if problems := list(check(apartment)):
        raise RoomsegError(f"{file}: {problems[0]}")
    save_apartment(apartment, output)
    click.echo(
        f"{output}: {counted(len(apartment.rooms), 'room')}, {floor_area(apartment):.1f} m², "
        f"{counted(len(apartment.walls), 'wall')}, {counted(len(apartment.blocks), 'block')}, "
        f"{counted(len(apartment.furniture), 'piece')}, {counted(len(result.notes), 'note')}"
    )


def _format_of(file: Path) -> str:
    """Tell the format by the suffix, that of JSON by what is in it."""
    from dataset.errors import RoomsegError
    from render.scene_files import FORMATS

    suffix = file.suffix.lower()
    if file.is_dir():
        return _folder_format(file)
    if suffix == ".json":
        return _json_format(file)
    if suffix in FORMATS:
        return "scene"
    if suffix in SUFFIXES:
        return SUFFIXES[suffix]
    raise RoomsegError(
        f"{file}: its suffix says nothing; expected one of .json, "
        f"{', '.join([*SUFFIXES, *FORMATS])}, or --format"
    )


def _json_format(file: Path) -> str:
    """Tell the floor plans that are JSON apart."""
    from dataset.errors import RoomsegError
    from scenes.importers.reading import read_json

    fields = read_json(file, "a floor plan or a robot's map")
    keys = set(fields) if isinstance(fields, dict) else set()
    if isinstance(fields, dict) and fields.get("format") == "roomseg-apartment":
        raise RoomsegError(f"{file}: is an apartment already; nothing to import")
    if "__class" in keys:
        return "valetudo"
    if "features" in keys:
        return "geojson"
    return "houseexpo" if "verts" in keys else "resplan"


def _folder_format(folder: Path) -> str:
    """A folder is a ROS 2 bag or nothing."""
    from dataset.errors import RoomsegError

    if not (folder / "metadata.yaml").is_file():
        raise RoomsegError(f"{folder}: is a folder without metadata.yaml, expected a ROS 2 bag")
    return "rosbag"


def _check_output(file: Path, format_: str, output: Path) -> None:
    """An apartment is JSON, a map HDF5."""
    suffix, what = (".h5", "a run") if format_ in RUNS else (".json", "an apartment")
    if output.suffix.lower() != suffix:
        raise click.UsageError(f"{output}: {file.name} is {what}, expected a name with {suffix}")


def _check_company(file: Path, options: dict[str, Any]) -> None:
    """Refuse options that mean nothing without another one, or for a file that says it itself."""
    if (file.is_dir() or file.suffix == ".bag") and "topics" not in options:
        raise click.UsageError("--topics: missing, expected a TOML file that names the topics")
    if "label_table" in options and "labels" not in options:
        raise click.UsageError("--label-table: says what --labels shows; expected --labels, too")
    if "up" in options and file.suffix.lower() not in UPRIGHT:
        known = ", ".join(UPRIGHT)
        raise click.UsageError(f"--up: {file.name} has its own axes; expected it for {known} only")


def _reader(format_: str, options: dict[str, Any]) -> Reader:
    """The reader of a format, if it can use all options."""
    module, name = (READERS | RUNS)[format_].split(":")
    reader: Reader = getattr(importlib.import_module(module), name)
    known = inspect.signature(reader).parameters
    for key in options:
        if key not in known:
            option = OPTIONS.get(key, f"--{key.replace('_', '-')}")
            raise click.UsageError(f"{option}: has no meaning for the format {format_}")
    return reader
