"""The files of a dataset: where each belongs, which are missing, and which are not of it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from dataset import MapFile, RoomsegError
from roomseg.cli.manifest import CARD, RECIPE, changed_files, read_manifest
from roomseg.cli.output import counted
from roomseg.cli.overview import OVERVIEW
from roomseg.cli.recipe import SPLITS, Place, Recipe
from roomseg.cli.runs import Run
from roomseg.cli.simulate import runs_in
from scenes import SceneError, load_apartment

__all__ = ["APARTMENTS", "DatasetFiles", "Missing", "images_of"]

APARTMENTS = "apartments"
LEFTOVER = re.compile(r"\..+\.(json|h5|blend|md|toml|png)\.[^/]+")
"""Name of a file that a killed process had not finished."""


@dataclass(frozen=True)
class Missing:
    """What is missing of a dataset; images of the maps that are there."""

    apartments: tuple[Path, ...]
    maps: tuple[Path, ...]
    images: int

    def line(self, folder: Path) -> str:
        """``2 apartments (a.json, b.json), 40 images of maps that are there``."""
        parts = [
            f"{counted(len(paths), what)} ({_some(paths, folder)})"
            for what, paths in (("apartment", self.apartments), ("map", self.maps))
            if paths
        ]
        if self.images:
            parts.append(f"{counted(self.images, 'image')} of maps that are there")
        return ", ".join(parts)


@dataclass(frozen=True)
class DatasetFiles:
    """The files of a recipe's dataset in a folder."""

    recipe: Recipe
    folder: Path

    def apartment(self, place: Place) -> Path:
        """Where the apartment of a place is."""
        return self.folder / APARTMENTS / f"{place.name}.json"

    def runs(self, place: Place) -> list[Run]:
        """The runs in a place."""
        recipe = self.recipe
        usual = Run(
            "",
            "",
            0,
            recipe.created,
            self.folder / place.split,
            recipe.robot,
            recipe.sensor,
            recipe.camera,
            "random" if place.starts == "random" else None,
        )
        return [*runs_in({place.name: str(self.apartment(place))}, usual, place.runs, recipe.seed)]

    def all_runs(self) -> dict[Path, tuple[Place, Run]]:
        """Place and run of every map."""
        places = self.recipe.places
        return {run.output: (place, run) for place in places for run in self.runs(place)}

    def refuse_strangers(self) -> None:
        """Refuse to build around files that are not of the recipe: they would be taken for it.

        Raises
        ------
        RoomsegError
            One line that names the first.
        """
        known = {self.apartment(place) for place in self.recipe.places} | {*self.all_runs()}
        found = {*(self.folder / APARTMENTS).glob("*.json")}
        found |= {path for split in SPLITS for path in (self.folder / split).glob("*.h5")}
        if strange := sorted(found - known):
            raise RoomsegError(
                f"{strange[0]}: not of this recipe, as it is now; remove it or choose another "
                f"folder ({counted(len(strange), 'such file')} in {self.folder})"
            )

    def missing(self, *, images: bool) -> Missing:
        """What is missing; ``images``: whether these count, too.

        A map that cannot be read counts as there: whoever needs it says what is wrong.
        """
        paths = [self.apartment(place) for place in self.recipe.places]
        maps = [*self.all_runs()]
        lacking = 0
        for path in maps if images else ():
            if path.exists():
                done, nodes = images_of(path)
                lacking += nodes - done
        return Missing(
            tuple(path for path in paths if not path.exists()),
            tuple(path for path in maps if not path.exists()),
            lacking,
        )

    def is_complete(self) -> bool:
        """Whether it has a manifest of this recipe, and all that the manifest says is there."""
        try:
            figures = read_manifest(self.folder)
            if not figures["complete"] or changed_files(self.folder, figures, thorough=True):
                return False
            if not all((self.folder / name).is_file() for name in (CARD, OVERVIEW)):
                return False
            recipe = (self.folder / RECIPE).read_bytes().decode("utf-8")
            return recipe == self.recipe.text and all(map(self._is_taken, self.recipe.places))
        except (RoomsegError, SceneError, OSError):
            return False

    def _is_taken(self, place: Place) -> bool:
        """Whether the apartment of a place is that of its source, if it has one."""
        if place.wishes is not None:
            return True
        ours = load_apartment(self.apartment(place), checked=False)
        return load_apartment(place.source, checked=False) == ours

    def remove_leftovers(self) -> None:
        """Remove what killed processes had not finished; only while nobody else builds here."""
        for folder in (self.folder, *(self.folder / name for name in (APARTMENTS, *SPLITS))):
            for path in folder.glob(".*"):
                if LEFTOVER.fullmatch(path.name) and path.is_file():
                    path.unlink()


def images_of(path: Path) -> tuple[int, int]:
    """How many images a map has, and how many it should have; (0, 0) if it cannot be read."""
    try:
        with MapFile(path) as file:
            return file.image_count, len(file.done)
    except RoomsegError:
        return 0, 0


def _some(paths: Sequence[Path], folder: Path) -> str:
    """The names of a few files, or of the first one of many."""
    names = [path.relative_to(folder).as_posix() for path in paths[:4]]
    return ", ".join(names) if len(names) < 4 else f"{names[0]}, …"
