"""``roomseg build``: a whole dataset from one recipe.

Nothing is made here: apartments come from `roomseg.cli.generate`, maps from
`roomseg.cli.runs` and images from `render.render_map`, each of which leaves alone what is
there and right.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

import click

from roomseg.cli.generate import is_there, write_homes
from roomseg.cli.options import OutputFolder, jobs_option
from roomseg.cli.output import counted, follow, progress_bar, tell, write_table
from roomseg.cli.rendering import ImageBar, rendered, scheduler_option, threads_option
from roomseg.cli.runs import Outcome, Run, lost, recognise
from roomseg.cli.simulate import clean, tell_all

if TYPE_CHECKING:
    from render.cycles import Device
    from roomseg.cli.dataset_files import DatasetFiles
    from roomseg.cli.recipe import Place

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
    type=OutputFolder(),
    required=True,
    help="Folder of the dataset; made if it is missing.",
)
@jobs_option
@scheduler_option
@threads_option
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
    scheduler: str | None,
    threads: int | None,
    device: Device,
    no_images: bool,
    dry_run: bool,
) -> None:
    """Make the dataset of RECIPE: apartments, runs, images, a manifest and a card.

    RECIPE is a TOML file (docs/build.md). The first line tells what is missing. What is
    there and right is left alone, so that a stopped command can be called again. What fails
    is listed at the end; the rest goes on.
    """
    from dataset.atomic import locked
    from roomseg.cli.dataset_files import DatasetFiles
    from roomseg.cli.manifest import MANIFEST
    from roomseg.cli.recipe import read_recipe

    files = DatasetFiles(read_recipe(recipe), output)
    files.refuse_strangers()
    if dry_run:
        _show(files, images=not no_images)
        return
    output.mkdir(parents=True, exist_ok=True)
    with locked(output / MANIFEST):
        files.remove_leftovers()
        if files.is_complete():
            click.echo(f"{output}: nothing is missing")
            return
        tell_all(Work(files, jobs, scheduler, threads, None if no_images else device).build())


def _show(files: DatasetFiles, *, images: bool) -> None:
    """Print what is there of each split, and what is missing."""
    from roomseg.cli.dataset_files import images_of
    from roomseg.cli.recipe import SPLITS

    rows = []
    for split in SPLITS:
        places = [place for place in files.recipe.places if place.split == split]
        apartments = sum(files.apartment(place).exists() for place in places)
        maps = [run.output for place in places for run in files.runs(place)]
        there = [path for path in maps if path.exists()]
        done, nodes = (sum(column) for column in zip((0, 0), *map(images_of, there), strict=True))
        cells = (f"{apartments} of {len(places)}", f"{len(there)} of {len(maps)}")
        rows.append((split, *cells, f"{done} of {nodes}" if nodes else "-"))
    write_table("", ("split", "apartments", "maps", "images of these maps"), rows)
    click.echo(f"missing: {files.missing(images=images).line(files.folder) or 'nothing'}")


@dataclass(frozen=True)
class Work:
    """A dataset to be made; without a device there are no images."""

    files: DatasetFiles
    jobs: int
    scheduler: str | None
    threads: int | None
    device: Device | None

    def build(self) -> list[str]:
        """Make what is missing, and the manifest last; one line on each thing that failed."""
        from roomseg.cli.manifest import MANIFEST, write_manifest

        files = self.files
        missing = files.missing(images=self.device is not None).line(files.folder)
        click.echo(f"{files.folder}: missing: {missing or 'nothing but the manifest'}")
        (files.folder / MANIFEST).unlink(missing_ok=True)
        places, problems = self._make_apartments()
        self._refuse_twins(places)
        good = {place.name for place in places}
        runs = {path: item for path, item in files.all_runs().items() if item[0].name in good}
        outcomes = [*self._clean([run for _, run in runs.values()])]
        problems += [outcome.problem for outcome in outcomes if outcome.problem is not None]
        reports = {o.output: o.report for o in outcomes if o.report is not None}
        if self.device is not None:
            problems += self._render([path for path in runs if path in reports])
        made = [
            (place, reports[path], path) for path, (place, _) in runs.items() if path in reports
        ]
        told = [self._as_anywhere(problem) for problem in dict.fromkeys(problems)]
        click.echo(write_manifest(files.folder, files.recipe, places, made, told))
        return problems

    def _as_anywhere(self, problem: str) -> str:
        """A problem without the folders of whoever builds: equal datasets have equal bytes."""
        for folder in (self.files.folder, self.files.recipe.folder):
            problem = problem if folder == Path() else problem.replace(f"{folder}/", "")
        return problem

    def _make_apartments(self) -> tuple[list[Place], list[str]]:
        """Write the apartments that are missing; the places that have one, and what failed."""
        from dataset import RoomsegError
        from scenes import SceneError

        files, there = self.files, set[Path]()
        todo, problems = [], []
        for place in files.recipe.places:
            path = files.apartment(place)
            path.parent.mkdir(exist_ok=True)
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
        return [place for place in files.recipe.places if files.apartment(place) in made], problems

    def _refuse_twins(self, places: Sequence[Place]) -> None:
        """Refuse the same apartment under two names in two splits.

        Raises
        ------
        RoomsegError
        """
        from dataset import RoomsegError
        from scenes import load_apartment

        seen: dict[bytes, Place] = {}
        for place in places:
            path = self.files.apartment(place)
            apartment = load_apartment(path, checked=False)
            text = apartment.model_dump_json(exclude={"name", "description", "start"})
            other = seen.setdefault(sha256(text.encode()).digest(), place)
            if other.split != place.split:
                raise RoomsegError(
                    f"{path}: the apartment of {other.name!r} by another name; expected it in "
                    f"one split, not in {other.split} and {place.split}"
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

        look = partial(recognise, judged=True)
        if self.jobs == 1 or len(runs) < 2:
            yield from map(look, runs)
        else:
            yield from in_processes(look, runs, self.jobs, lost)

    def _render(self, maps: Sequence[Path]) -> Iterator[str]:
        """Add the images that are missing; yield one line on each map that has not got them."""
        from render import Wanted
        from roomseg.cli.dataset_files import images_of

        assert self.device is not None
        recipe = self.files.recipe
        wanted = Wanted(recipe.preset, None, self.threads, self.device, recipe.hdr)
        with progress_bar("images") as bar:
            images = ImageBar(bar, {path: images_of(path) for path in maps})
            with closing(
                rendered(maps, wanted, images, jobs=self.jobs, scheduler=self.scheduler)
            ) as outcomes:
                for outcome in outcomes:
                    if outcome.problem is not None:
                        yield str(outcome.problem)
                    elif outcome.count:
                        tell(bar, f"{outcome.path}: {counted(outcome.count, 'new image')}")


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
