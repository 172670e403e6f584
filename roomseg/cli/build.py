"""``roomseg build``: a whole dataset from one recipe.

Nothing is made here: apartments come from `roomseg.cli.generate`, maps from
`roomseg.cli.runs` and images from `render.render_map`, each of which leaves alone what is
there and right.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from roomseg.cli.generate import is_there, write_homes
from roomseg.cli.options import jobs_option
from roomseg.cli.output import counted, follow, progress_bar, tell, write_table
from roomseg.cli.runs import Outcome, Run, lost, recognise
from roomseg.cli.simulate import clean, runs_in, tell_all

if TYPE_CHECKING:
    from dataset import FisheyeCamera
    from render.cycles import Device
    from roomseg.cli.recipe import Place, Recipe

APARTMENTS = "apartments"

EXAMPLE = """\b
Example:
  roomseg build recipe.toml --dry-run -o homes
  roomseg build recipe.toml --jobs 2 -o homes
  roomseg inspect homes
"""


@click.command("build", epilog=EXAMPLE)
@click.argument("recipe", metavar="RECIPE", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    required=True,
    help="Folder of the dataset; made if it is missing.",
)
@jobs_option
@click.option("--threads", type=click.IntRange(1), help="Threads of the renderer; all if absent.")
@click.option(
    "--device",
    type=click.Choice(["auto", "cpu", "gpu"]),
    default="auto",
    show_default=True,
    help="What renders.",
)
@click.option("--no-images", is_flag=True, help="Stop before the images.")
@click.option("--dry-run", is_flag=True, help="Tell what is there and what is missing, no more.")
def command(
    *,
    recipe: Path,
    output: Path,
    jobs: int,
    threads: int | None,
    device: Device,
    no_images: bool,
    dry_run: bool,
) -> None:
    """Make the dataset of RECIPE: apartments, runs, images, a manifest and a card.

    RECIPE is a TOML file (docs/build.md). What is there and right is left alone, so that a
    stopped command can be called again. What fails is listed at the end; the rest goes on.
    """
    from dataset.atomic import locked
    from roomseg.cli.manifest import MANIFEST
    from roomseg.cli.recipe import read_recipe

    wanted = read_recipe(recipe)
    work = Work(wanted, output, jobs, threads, None if no_images else device)
    work.refuse_strangers()
    if dry_run:
        _show(work)
        return
    output.mkdir(parents=True, exist_ok=True)
    with locked(output / MANIFEST):
        tell_all(work.build())


@dataclass(frozen=True)
class Work:
    """A dataset to be made; without a device there are no images."""

    recipe: Recipe
    output: Path
    jobs: int
    threads: int | None
    device: Device | None

    def apartment(self, place: Place) -> Path:
        """Where the apartment of a place is."""
        return self.output / APARTMENTS / f"{place.name}.json"

    def runs(self, place: Place) -> list[Run]:
        """The runs in a place."""
        recipe = self.recipe
        usual = Run(
            "",
            "",
            0,
            recipe.created,
            self.output / place.split,
            recipe.robot,
            recipe.sensor,
            recipe.camera,
            "random" if place.starts == "random" else None,
        )
        return [*runs_in({place.name: str(self.apartment(place))}, usual, place.runs, recipe.seed)]

    def refuse_strangers(self) -> None:
        """Refuse to build around files that are not of the recipe: they would be taken for it.

        Raises
        ------
        RoomsegError
            One line that names the first.
        """
        from dataset import RoomsegError
        from roomseg.cli.recipe import SPLITS

        known = {self.apartment(place) for place in self.recipe.places}
        known |= {run.output for place in self.recipe.places for run in self.runs(place)}
        found = {*(self.output / APARTMENTS).glob("*.json")}
        found |= {path for split in SPLITS for path in (self.output / split).glob("*.h5")}
        if strange := sorted(found - known):
            raise RoomsegError(
                f"{strange[0]}: not of this recipe, as it is now; remove it or choose another "
                f"folder ({counted(len(strange), 'such file')} in {self.output})"
            )

    def build(self) -> list[str]:
        """Make what is missing, and the manifest last; one line on each thing that failed."""
        from roomseg.cli.manifest import MANIFEST, write_manifest

        (self.output / MANIFEST).unlink(missing_ok=True)
        places, problems = self._make_apartments()
        self._refuse_twins(places)
        runs = {run.output: (place, run) for place in places for run in self.runs(place)}
        outcomes = [*self._clean([run for _, run in runs.values()])]
        problems += [outcome.problem for outcome in outcomes if outcome.problem is not None]
        reports = {o.output: o.report for o in outcomes if o.report is not None}
        if self.device is not None:
            problems += self._render([path for path in runs if path in reports])
        made = [
            (place, reports[path], path) for path, (place, _) in runs.items() if path in reports
        ]
        told = [self._as_anywhere(problem) for problem in dict.fromkeys(problems)]
        click.echo(write_manifest(self.output, self.recipe, places, made, told))
        return problems

    def _as_anywhere(self, problem: str) -> str:
        """A problem without the folders of whoever builds: equal datasets have equal bytes."""
        for folder in (self.output, self.recipe.folder):
            problem = problem if folder == Path() else problem.replace(f"{folder}/", "")
        return problem

    def _make_apartments(self) -> tuple[list[Place], list[str]]:
        """Write the apartments that are missing; the places that have one, and what failed."""
        from dataset import RoomsegError
        from scenes import SceneError

        (self.output / APARTMENTS).mkdir(exist_ok=True)
        there: set[Path] = set()
        todo, problems = [], []
        for place in self.recipe.places:
            path = self.apartment(place)
            try:
                if place.wishes is None:
                    _take(place, path)
                if is_there(path):
                    there.add(path)
                elif place.wishes is not None:
                    todo.append((place.seed, place.wishes, path))
            except (RoomsegError, SceneError) as error:
                problems.append(str(error))
        if todo:
            problems += write_homes(todo, self.jobs, before=len(there))
        made = there | {path for _, _, path in todo if path.exists()}
        good = [place for place in self.recipe.places if self.apartment(place) in made]
        click.echo(f"{self.output / APARTMENTS}: {len(good)} of {len(self.recipe.places)}")
        return good, problems

    def _refuse_twins(self, places: Sequence[Place]) -> None:
        """Refuse the same apartment under two names in two splits.

        Raises
        ------
        RoomsegError
        """
        from dataset import RoomsegError
        from scenes import load_apartment

        seen: dict[str, Place] = {}
        for place in places:
            apartment = load_apartment(self.apartment(place), checked=False)
            text = apartment.model_dump_json(exclude={"name", "description", "start"})
            other = seen.setdefault(text, place)
            if other.split != place.split:
                raise RoomsegError(
                    f"{self.apartment(place)}: the apartment of {other.name!r} by another name; "
                    f"expected it in one split, not in {other.split} and {place.split}"
                )

    def _clean(self, runs: Sequence[Run]) -> Iterator[Outcome]:
        """Look at the maps that are there, simulate the others."""
        there = [run for run in runs if run.output.exists()]
        todo = [run for run in runs if not run.output.exists()]
        if there:
            with progress_bar("maps") as bar:
                show = follow(bar, "maps that are there")
                show(0, len(there))
                for done, outcome in enumerate(self._recognised(there), 1):
                    show(done, len(there))
                    yield outcome
        if todo:
            yield from clean(todo, self.jobs, before=len(there))

    def _recognised(self, runs: Sequence[Run]) -> Iterator[Outcome]:
        from roomseg.cli.parallel import in_processes

        seen = [Seen(run, self.recipe.preset.camera(_camera(run))) for run in runs]
        if self.jobs == 1 or len(seen) < 2:
            yield from map(_recognise, seen)
        else:
            yield from in_processes(_recognise, seen, self.jobs, lambda item: lost(item.run))

    def _render(self, maps: Sequence[Path]) -> Iterator[str]:
        """Add the images that are missing; yield one line on each map that has not got them."""
        there, total = {}, 0
        for path in maps:
            there[path], nodes = _images(path)
            total += nodes
        done = sum(there.values())
        with progress_bar("images") as bar:
            show = follow(bar, self.recipe.preset.name)
            show(done, total)
            for path in maps:
                done -= there[path]
                new = self._add_images(path, lambda n, _, more=done: show(more + n, total))
                done += _images(path)[0]
                if isinstance(new, str):
                    yield new
                elif new:
                    tell(bar, f"{path}: {counted(new, 'new image')}")

    def _add_images(self, path: Path, show: Callable[[int, int], None]) -> int | str:
        """Add the images that one map lacks; how many, or one line on why not."""
        from dataset import RoomsegError
        from render import render_map
        from scenes import SceneError

        assert self.device is not None
        try:
            return render_map(
                path,
                preset=self.recipe.preset,
                threads=self.threads,
                device=self.device,
                on_progress=show,
            )
        except (RoomsegError, SceneError, OSError) as error:
            return str(error)


@dataclass(frozen=True)
class Seen:
    """A run whose map is there, and the camera that its images have or will have."""

    run: Run
    camera: FisheyeCamera


def _recognise(seen: Seen) -> Outcome:
    """Make sure that a map that is there is the one of the run and has its camera."""
    from dataset import read_map

    outcome = recognise(seen.run, judged=True)
    if outcome.problem is not None:
        return outcome
    if read_map(seen.run.output).camera in (seen.camera, _camera(seen.run)):
        return outcome
    return Outcome(
        seen.run.output,
        problem=f"{seen.run.output}: already there, but of another camera; choose another folder",
    )


def _camera(run: Run) -> FisheyeCamera:
    """The camera of a run's map: at the height that its robot has it."""
    return replace(run.camera, height=run.sensor.camera_height)


def _take(place: Place, path: Path) -> None:
    """Put a file or reference place among the apartments, with its own 3D scene, if it has one.

    Raises
    ------
    RoomsegError
        If another apartment of that name is there.
    SceneError
        If it is no good apartment.
    """
    from dataset import RoomsegError
    from scenes import load_apartment, save_apartment
    from scenes.scene_file import take_scene_file

    apartment = load_apartment(place.source)
    if path.exists() and load_apartment(path, checked=False) != apartment:
        raise RoomsegError(
            f"{path}: already there, but not as in {place.source}; choose another folder"
        )
    take_scene_file(apartment, Path(place.source).parent, path.parent)
    if not path.exists():
        save_apartment(apartment, path)


def _images(path: Path) -> tuple[int, int]:
    """How many images a map has, and how many it should have."""
    from dataset import MapFile

    with MapFile(path) as file:
        return file.image_count, len(file.done)


def _show(work: Work) -> None:
    """Print what is there of each split."""
    from dataset import RoomsegError
    from roomseg.cli.recipe import SPLITS

    rows = []
    for split in SPLITS:
        places = [place for place in work.recipe.places if place.split == split]
        apartments = sum(work.apartment(place).exists() for place in places)
        maps = [run.output for place in places for run in work.runs(place)]
        there = [path for path in maps if path.exists()]
        counts = [(0, 0)]
        for path in there:
            try:
                counts.append(_images(path))
            except RoomsegError as error:
                click.echo(f"roomseg: error: {error}", err=True)
        images, nodes = (sum(column) for column in zip(*counts, strict=True))
        cells = (f"{apartments} of {len(places)}", f"{len(there)} of {len(maps)}")
        rows.append((split, *cells, f"{images} of {nodes}" if nodes else "-"))
    write_table("", ("split", "apartments", "maps", "images of these maps"), rows)
