"""What a dataset holds: the manifest for machines, the card for people."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, fields, replace
from importlib.metadata import version
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, Literal

import jinja2
from pydantic import AfterValidator, BaseModel, ConfigDict, ValidationError

from dataset import FormatError, RoomsegError, summarise
from dataset.atomic import write_text
from roomseg.cli.output import counted
from roomseg.cli.overview import OVERVIEW, write_overview
from roomseg.cli.recipe import SPLITS, Place, Recipe
from roomseg.cli.toml_lines import dotted
from scenes import load_apartment
from scenes.faults import value_fault
from scenes.summary import summarise_apartment
from simulator import CoverageReport, settings_of

__all__ = ["CARD", "MANIFEST", "RECIPE", "changed_files", "read_manifest", "write_manifest"]

MANIFEST, CARD, RECIPE = "manifest.json", "README.md", "recipe.toml"
FORMAT = {"format": "roomseg-dataset", "format_version": 1}
LIBRARIES = ("roomseg", "bpy", "numpy", "scipy", "shapely", "h5py")
"""Those that the bytes of the files depend on."""
OF_MAP = (
    "run",
    "seed",
    "created",
    "software",
    "edge_count",
    "border_edge_count",
    "room_count",
    "part_count",
    "lane_count",
    "images_done",
    "preset",
)
"""What is told of a map, besides how good the run was."""
SUMS = ("nodes", "edge_count", "border_edge_count", "images_done", "path_length", "duration")
MOST_ROWS = 100
"""Of a table of the card."""
Made = tuple[Place, CoverageReport, Path]


def _inside(name: str) -> str:
    """A name that stays in the dataset's folder."""
    path = PurePosixPath(name)
    if path.is_absolute() or not path.parts or ".." in path.parts:
        raise ValueError("expected the name of a file in the folder")
    return name


Inside = Annotated[str, AfterValidator(_inside)]
Split = Literal["train", "validation", "test"]


class _Figures(BaseModel):
    """What `inspect` and `build` need to find; all else is kept as it is."""

    model_config = ConfigDict(extra="allow", strict=True)


class _File(_Figures):
    file: Inside
    bytes: int
    sha256: str
    split: Split


class _PlaceFigures(_File):
    name: str
    rooms: int
    floor_area: float


class _MapFigures(_File):
    place: str
    nodes: int
    images_done: int
    coverage: float


class _Sums(_Figures):
    places: int
    places_wanted: int
    rooms: int
    floor_area: float
    maps: int
    maps_wanted: int
    nodes: int
    edge_count: int
    border_edge_count: int
    images_done: int
    path_length: float
    bytes: int
    mean_coverage: float | None
    largest_drift: float | None


class _Manifest(_Figures):
    format: Literal["roomseg-dataset"]
    format_version: Literal[1]
    name: str
    description: str
    complete: bool
    seed: int
    preset: str
    libraries: dict[str, str]
    splits: dict[Split, _Sums]
    total: _Sums
    problems: list[str]
    places: list[_PlaceFigures]
    maps: list[_MapFigures]


def write_manifest(
    folder: Path,
    recipe: Recipe,
    places: Iterable[Place],
    made: Iterable[Made],
    problems: Sequence[str],
) -> str:
    """Write recipe, picture, card and, last of all, manifest; return a line on what there is.

    Parameters
    ----------
    folder : Path
        Of the dataset.
    recipe : Recipe
    places : iterable of Place
        Those with an apartment.
    made : iterable of (Place, CoverageReport, Path)
        The maps.
    problems : sequence of str
        What failed, one line each.
    """
    camera = replace(recipe.camera, height=recipe.sensor.camera_height)
    homes = [_place(folder, place) for place in places]
    maps = [_map(folder, *item) for item in made]
    wanted = sum(place.runs for place in recipe.places)
    whole = len(maps) == wanted and all(item["images_done"] == item["nodes"] for item in maps)
    figures: dict[str, Any] = FORMAT | {
        "name": recipe.name,
        "description": recipe.description,
        "complete": whole and not problems,
        "seed": recipe.seed,
        "created": recipe.created,
        "preset": recipe.preset.name,
        "hdr": recipe.hdr,
        "libraries": {name: version(name) for name in LIBRARIES},
        "recipe": {"file": RECIPE, "sha256": _sha256(recipe.text.encode())},
        "robot": settings_of(recipe.robot),
        "sensor": settings_of(recipe.sensor),
        "camera": asdict(recipe.preset.camera(camera)),
        "splits": {split: _sums(recipe, homes, maps, (split,)) for split in SPLITS},
        "total": _sums(recipe, homes, maps, SPLITS),
        "problems": problems,
        "places": homes,
        "maps": maps,
    }
    write_text(folder / RECIPE, recipe.text)
    if homes:
        write_overview(folder, figures, folder / OVERVIEW)
    write_text(folder / CARD, _card(figures))
    write_text(folder / MANIFEST, json.dumps(figures, indent=1, ensure_ascii=False) + "\n")
    total = figures["total"]
    return (
        f"{folder}: {counted(total['places'], 'place')}, {counted(total['maps'], 'map')}, "
        f"{counted(total['nodes'], 'node')}, {counted(total['images_done'], 'image')}"
    )


def read_manifest(folder: Path) -> dict[str, Any]:
    """The manifest of a dataset.

    Raises
    ------
    RoomsegError
        If there is none, or it is something else.
    """
    path = folder / MANIFEST
    try:
        figures = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise RoomsegError(
            f"{folder}: is a folder without {MANIFEST}; expected that of a finished `roomseg build`"
        ) from None
    except (OSError, ValueError) as error:
        raise FormatError(f"{path}: cannot be read: {error}") from error
    try:
        _Manifest.model_validate(figures)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        where = dotted(fault["loc"]) or "content"
        what = "missing" if fault["type"] == "missing" else value_fault(fault)
        raise FormatError(f"{path}: {where}: {what}; not the manifest of a dataset") from error
    return dict(figures)


def changed_files(folder: Path, figures: Mapping[str, Any], *, thorough: bool = False) -> list[str]:
    """The files of a manifest that are missing or of another size or, ``thorough``, content."""
    return [
        item["file"]
        for item in (*figures["places"], *figures["maps"])
        if not _is_same(folder / item["file"], item, thorough=thorough)
    ]


def _is_same(path: Path, item: Mapping[str, Any], *, thorough: bool) -> bool:
    if not path.is_file() or path.stat().st_size != item["bytes"]:
        return False
    return not thorough or _digest(path) == item["sha256"]


def _place(folder: Path, place: Place) -> dict[str, Any]:
    """What the manifest tells of a place."""
    path = folder / "apartments" / f"{place.name}.json"
    apartment = load_apartment(path, checked=False)
    summary = summarise_apartment(apartment)
    scene = apartment.scene_file
    return {
        "name": place.name,
        "split": place.split,
        "from": place.origin,
        **_file(folder, path),
        **({} if scene is None else {"scene_file": f"{path.parent.name}/{scene.file}"}),
        "rooms": len(summary.rooms),
        "floor_area": round(summary.floor_area, 3),
        "pieces": sum(summary.pieces.values()),
        "lighting": summary.lighting,
        "passageway_contrast": summary.passageway_contrast,
    }


def _map(folder: Path, place: Place, report: CoverageReport, path: Path) -> dict[str, Any]:
    """What the manifest tells of a map."""
    summary = summarise(path)
    figures = {name: getattr(summary, name) for name in OF_MAP}
    figures |= {field.name: _rounded(getattr(report, field.name)) for field in fields(report)}
    return {"place": place.name, "split": place.split, **_file(folder, path), **figures}


def _file(folder: Path, path: Path) -> dict[str, Any]:
    name = path.relative_to(folder).as_posix()
    return {"file": name, "bytes": path.stat().st_size, "sha256": _digest(path)}


def _digest(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _sums(
    recipe: Recipe,
    homes: Sequence[Mapping[str, Any]],
    maps: Sequence[Mapping[str, Any]],
    splits: Sequence[str],
) -> dict[str, Any]:
    """Figures of some splits together; what is wanted of a recipe stands beside what is there."""
    wanted = [place for place in recipe.places if place.split in splits]
    own = [home for home in homes if home["split"] in splits]
    there = [item for item in maps if item["split"] in splits]
    sums = {name: _rounded(sum(item[name] or 0 for item in there)) for name in SUMS}
    mean = sum(item["coverage"] for item in there) / max(len(there), 1)
    return {
        "places": len(own),
        "places_wanted": len(wanted),
        "rooms": sum(home["rooms"] for home in own),
        "floor_area": _rounded(sum(home["floor_area"] for home in own)),
        "maps": len(there),
        "maps_wanted": sum(place.runs for place in wanted),
        **sums,
        "bytes": sum(item["bytes"] for item in there),
        "mean_coverage": _rounded(mean) if there else None,
        "least_coverage": min((item["coverage"] for item in there), default=None),
        "largest_drift": max((item["drift"] for item in there), default=None),
    }


def _rounded(value: Any) -> Any:
    """Six figures behind the point are enough; numbers that are whole stay so."""
    return round(value, 6) if isinstance(value, float) else value


def _sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _card(figures: Mapping[str, Any]) -> str:
    """The dataset card, Markdown."""
    used = {name: sums for name, sums in figures["splits"].items() if sums["places_wanted"]}
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("roomseg", "templates"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    return environment.get_template("dataset_card.md").render(
        d=figures, parts={**used, "all": figures["total"]}, picture=OVERVIEW, most=MOST_ROWS
    )
