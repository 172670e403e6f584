"""The recipe of a dataset: a TOML file, read with errors that tell the line.

What a value means is left to those who use it: `Wishes`, `RobotSpec`,
`FisheyeCamera` and the presets refuse what is impossible in words that begin with the
field's name, and the name gives the line.
"""

from __future__ import annotations

import difflib
import json
import re
import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from dataset import REAL_CAMERA, SIMULATED_CAMERA, FisheyeCamera, FormatError, RoomsegError
from render import preset_named
from render.blender import render_window
from render.presets import Preset
from roomseg.cli.toml_lines import Keys, dotted, known_part, line_of, value_at
from scenes import SceneError, load_apartment, reference_names
from scenes.faults import value_fault
from scenes.generator import Wishes, apartment_name
from simulator import RobotSpec, SensorSpec, read_specs, specs_of
from simulator.camera_file import camera_of, read_camera

__all__ = ["SPLITS", "Place", "Recipe", "Split", "read_recipe"]

Split = Literal["train", "validation", "test"]
Starts = Literal["own", "random"]
Spec = TypeVar("Spec")

SPLITS: tuple[Split, ...] = ("train", "validation", "test")
CAMERAS = {"simulated": SIMULATED_CAMERA, "real": REAL_CAMERA}
MOST_PLACES = 1_000_000


@dataclass(frozen=True)
class Place:
    """An apartment of the dataset.

    Either generated from ``seed`` and ``wishes``, or read from ``source``: a file's path, or
    the name of a reference place, which is a text.
    """

    name: str
    split: Split
    runs: int
    starts: Starts
    source: str | Path = ""
    seed: int = 0
    wishes: Wishes | None = None

    @property
    def origin(self) -> str:
        """Where it is from, without the folders of whoever built it."""
        return Path(self.source).name if self.wishes is None else f"seed {self.seed}"


@dataclass(frozen=True)
class Recipe:
    """All that a dataset is made of; ``text`` is the file's own, ``folder`` where it lies."""

    folder: Path
    text: str
    name: str
    description: str
    seed: int
    created: str
    preset: Preset
    hdr: bool
    robot: RobotSpec
    sensor: SensorSpec
    camera: FisheyeCamera
    places: tuple[Place, ...]


def _pair(value: Any) -> Any:
    """A number alone is the first and the last one."""
    return (value, value) if isinstance(value, int) else _tuple(value)


def _names(value: Any) -> Any:
    """A text alone is a list of one."""
    return (value,) if isinstance(value, str) else _tuple(value)


def _tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


Names = Annotated[tuple[str, ...], BeforeValidator(_names)]
Runs = Annotated[int, Field(ge=1, le=1000)]
Seed = Annotated[int, Field(ge=0, lt=2**63)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class _Group(_Table):
    """One ``[[places]]``."""

    split: Split
    reference: Names | None = None
    files: Names | None = None
    seeds: Annotated[tuple[Seed, Seed], BeforeValidator(_pair)] | None = None
    options: dict[str, Any] | None = None
    runs: Runs | None = None
    starts: Starts | None = None


class _Fields(_Table):
    """The file."""

    places: tuple[_Group, ...]
    preset: str = "fast"
    name: Annotated[str, Field(max_length=100, pattern=r"^[^\n]*$")] = ""
    description: str = ""
    seed: Annotated[int, Field(ge=0, le=2**32 - 1)] = 0
    created: str = "1970-01-01T00:00:00Z"
    runs: Runs = 1
    starts: Starts = "own"
    robot: str | dict[str, Any] = {}
    sensor: dict[str, Any] = {}
    camera: str | dict[str, Any] | None = None
    hdr: bool = False


def read_recipe(path: str | Path) -> Recipe:
    """Read a recipe.

    Raises
    ------
    RoomsegError
        If the file cannot be read, is no TOML, or has an unknown key or an impossible
        value: one line with the file, the line, the key, and what would be right.
    """
    return _Reader(Path(path)).recipe()


class _Reader:
    """A recipe's text, and what refuses parts of it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self.text = path.read_bytes().decode("utf-8").replace("\r\n", "\n")
            self.data = tomllib.loads(self.text)
        except OSError as error:
            raise RoomsegError(f"{path}: cannot be read: {error.strerror or error}") from error
        except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise RoomsegError(f"{path}: not a TOML text file: {error}") from error

    def recipe(self) -> Recipe:
        given = self._fields()
        robot, sensor = self._specs(given)
        return Recipe(
            folder=self.path.parent,
            text=self.text,
            name=given.name or self.path.stem,
            description=given.description,
            seed=given.seed,
            created=self._date(given.created),
            preset=self._preset(given.preset),
            hdr=given.hdr,
            robot=robot,
            sensor=sensor,
            camera=self._camera(given),
            places=self._places(given),
        )

    def refuse(self, keys: Keys, message: str) -> NoReturn:
        """Raise the one line on a key's value."""
        line = line_of(self.text, keys)
        raise RoomsegError(f"{self.path}: line {line}: {dotted(keys)}: {message}")

    def refuse_named(self, keys: Keys, message: str) -> NoReturn:
        """Refuse what an error says that begins with the name of a field in a table."""
        table, (names, _, words) = value_at(self.data, keys), message.partition(": ")
        named = [name + end for name in re.findall(r"\w+", names) for end in ("", "_deg")]
        known = [name for name in named if name in table]
        if len(known) == 1:
            self.refuse((*keys, known[0]), words)
        self.refuse(keys, message)

    def _fields(self) -> _Fields:
        try:
            # By way of JSON, in which lists may be tuples and dates are texts.
            return _Fields.model_validate_json(json.dumps(self.data, default=str))
        except ValidationError as error:
            faults = error.errors(include_url=False)
        # Of what is wrong, the first in the file.
        at = [line_of(self.text, fault["loc"]) for fault in faults]
        fault = faults[at.index(min(at))]
        keys = known_part(self.data, fault["loc"])
        if fault["type"] == "extra_forbidden":
            self.refuse(keys, f"unknown key{_hint(keys)}")
        if fault["type"] == "missing":
            self.refuse(fault["loc"], "missing; expected a value")
        self.refuse(keys, f"{_short(value_at(self.data, keys))}; {value_fault(fault)}")

    def _date(self, text: str) -> str:
        try:
            datetime.fromisoformat(text)
        except ValueError:
            self.refuse(("created",), f"{text!r}; expected a date like 2026-01-31T12:00:00Z")
        return text

    def _preset(self, name: str) -> Preset:
        try:
            return preset_named(name)
        except RoomsegError as error:
            self.refuse_named((), str(error))

    def _specs(self, given: _Fields) -> tuple[RobotSpec, SensorSpec]:
        """The robot and its sensors, by tables or by a robot's file."""
        if isinstance(given.robot, str):
            if given.sensor:
                self.refuse(("sensor",), f"expected it in {given.robot!r}, the robot's file")
            return self._of_file(read_specs, given.robot)
        try:
            return specs_of(self.data)
        except RoomsegError as error:
            self._refuse_setting(str(error))

    def _camera(self, given: _Fields) -> FisheyeCamera:
        """The camera: the recipe's, else that of the robot's file, else the usual one."""
        if isinstance(given.camera, str):
            if given.camera not in CAMERAS:
                self.refuse(("camera",), f"{given.camera!r}; expected 'simulated', 'real', a table")
            return CAMERAS[given.camera]
        if given.camera is None and isinstance(given.robot, str):
            return self._of_file(_read_camera, given.robot)
        try:
            return _renderable(camera_of(self.data.get("camera", {})))
        except RoomsegError as error:
            self._refuse_setting(str(error))

    def _of_file(self, read: Callable[[Path], Spec], name: str) -> Spec:
        """What a robot's file says."""
        try:
            return read(self._inside(("robot",), name))
        except RoomsegError as error:
            self.refuse(("robot",), str(error))

    def _refuse_setting(self, message: str) -> NoReturn:
        """Refuse what an error says that begins with a table and the name of a setting."""
        table, _, setting = message.partition(".")
        self.refuse_named((table,), setting)

    def _places(self, given: _Fields) -> tuple[Place, ...]:
        """All places, none of them twice."""
        if not given.places:
            self.refuse(("places",), "empty; expected at least one")
        found: dict[str, tuple[Place, int]] = {}
        for index, group in enumerate(given.places):
            for place in self._group(index, group, given):
                if place.name in found:
                    there, other = found[place.name]
                    what = f"{place.name!r} is in places[{other}], {there.split}, already"
                    self.refuse(("places", index), f"{what}; expected every place once")
                if len(found) == MOST_PLACES:
                    self.refuse(("places", index), f"expected {MOST_PLACES} places at most")
                found[place.name] = (place, index)
        return tuple(place for place, _ in found.values())

    def _group(self, index: int, group: _Group, given: _Fields) -> Iterator[Place]:
        keys: Keys = ("places", index)
        kinds = [k for k in ("reference", "files", "seeds") if getattr(group, k) is not None]
        if len(kinds) != 1:
            self.refuse(keys, "expected one of reference, files and seeds")
        if group.options is not None and group.seeds is None:
            self.refuse((*keys, "options"), "say what to generate; expected seeds, too")
        runs, starts = group.runs or given.runs, group.starts or given.starts
        for name in group.reference or ():
            if name not in reference_names():
                known = ", ".join(reference_names())
                self.refuse((*keys, "reference"), f"{name!r}; expected some of {known}")
            yield Place(name, group.split, runs, starts, source=name)
        for name in group.files or ():
            source = self._inside((*keys, "files"), name)
            yield Place(_name_in(source), group.split, runs, starts, source=source)
        if group.seeds is not None:
            wishes = self._wishes(keys, group.options or {})
            first, last = group.seeds
            if last < first:
                self.refuse((*keys, "seeds"), f"{first}, {last}; expected the smaller one first")
            for seed in range(first, last + 1):
                name = apartment_name(seed, wishes)
                yield Place(name, group.split, runs, starts, seed=seed, wishes=wishes)

    def _wishes(self, place: Keys, options: dict[str, Any]) -> Wishes:
        keys, known = (*place, "options"), [field.name for field in fields(Wishes)]
        for name in options:
            if name not in known:
                self.refuse((*keys, name), f"unknown key{_suggest(name, known)}")
        lists: dict[str, Any] = {
            n: tuple(v) if isinstance(v, list) else v for n, v in options.items()
        }
        try:
            return Wishes(**lists)
        except SceneError as error:
            self.refuse_named(keys, str(error))

    def _inside(self, keys: Keys, name: str) -> Path:
        """A file beside the recipe or below; a recipe from elsewhere reads no others."""
        folder, path = self.path.parent, self.path.parent / name
        if Path(name).is_absolute() or not path.resolve().is_relative_to(folder.resolve()):
            self.refuse(keys, f"{name!r}; expected a file in the recipe's folder")
        return path


def _hint(keys: Keys) -> str:
    table = _Group if len(keys) == 3 else _Fields
    return _suggest(str(keys[-1]), list(table.model_fields))


def _suggest(name: str, known: Sequence[str]) -> str:
    close = difflib.get_close_matches(name, known, n=1)
    return f"; did you mean {close[0]!r}?" if close else f"; expected one of {', '.join(known)}"


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _read_camera(path: Path) -> FisheyeCamera:
    """The camera of a robot's file.

    Raises
    ------
    RoomsegError
        If it cannot be read, or its images could not be rendered later.
    """
    try:
        return _renderable(read_camera(path))
    except FormatError as error:
        named = str(error).startswith(f"{path}: ")
        raise RoomsegError(str(error) if named else f"{path}: {error}") from error


def _renderable(camera: FisheyeCamera) -> FisheyeCamera:
    """The camera; FormatError, that begins as those of `camera_of`, if it cannot be rendered."""
    try:
        render_window(camera)
    except ValueError as error:
        raise FormatError(f"camera.{error}") from error
    return camera


def _name_in(source: Path) -> str:
    """Name of the apartment in a file; of one that cannot be read, the file's."""
    try:
        return load_apartment(source, checked=False).name
    except SceneError:
        return source.stem
