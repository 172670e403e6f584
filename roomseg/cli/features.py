"""``roomseg features``, and edge features of several maps for `train` and `evaluate`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click
from rich.progress import Progress

from roomseg.cli.options import FiniteRange, jobs_option, maps_argument
from roomseg.cli.output import counted, follow, progress_bar

if TYPE_CHECKING:
    from dataset import MapFile
    from roomseg.classifier import ClassifierParameters
    from roomseg.features import EdgeFeatures
    from roomseg.labelled_map import LabelledMap

__all__ = [
    "check_labelled",
    "check_ready",
    "chosen_parameters",
    "classifier_options",
    "command",
    "compute",
    "labelled_maps",
    "origins",
    "subset_option",
]

Command = TypeVar("Command", bound=Callable[..., Any])

# From `roomseg.features.SUBSETS`, which is only imported when it is needed.
SUBSET_NAMES = ("all", "no-camera", "no-pano", "no-ceiling", "no-obst")

EXAMPLE = """\b
Example:
  roomseg features maps/*.h5 -o features.h5
  roomseg reproduce --from-features features.h5 -o reproduction
"""

subset_option = click.option(
    "--features",
    "subset",
    type=click.Choice(SUBSET_NAMES),
    default="all",
    show_default=True,
    help="Subset of the edge features; no-camera needs no images.",
)


def classifier_options(command: Command) -> Command:
    """Add the four parameters of the method (Table 6)."""
    positive = FiniteRange(0.0, min_open=True)
    for name, target, default, text in (
        ("--rho", "rho", 60.0, "ρ: border edges weigh so many times less."),
        ("--w", "class_weight", 40.0, "w: border edges count so many times."),
        ("--gamma", "gamma", 2.0**-3, "γ of the kernel."),
        ("--C", "c", 2.0**-3, "C of the SVM."),
    ):
        add = click.option(
            name, target, type=positive, default=default, show_default=True, help=text
        )
        command = add(command)
    return command


def chosen_parameters(
    *, c: float, gamma: float, class_weight: float, rho: float
) -> ClassifierParameters:
    """Collect what `classifier_options` gave."""
    from roomseg.classifier import ClassifierParameters

    return ClassifierParameters(C=c, gamma=gamma, class_weight=class_weight, rho=rho)


def labelled_maps(
    paths: Sequence[Path], subset: str, *, several_places: bool = False
) -> list[LabelledMap]:
    """Read maps with their ground truth and compute their edge features.

    Parameters
    ----------
    paths : sequence of Path
        Maps, and feature sets, which have the features of several.
    subset : str
        Name of the subset of the features.
    several_places : bool
        Whether places will be left out, so that there must be two.

    Raises
    ------
    RoomsegError
        Before anything is computed: if a map is unreadable, lacks images that
        the features need, or lacks its ground truth, or all are of one place.
    """
    from roomseg.feature_set import is_feature_set
    from roomseg.features import SUBSETS

    names = SUBSETS[subset]
    sets = {path: _maps_of_set(path, names) for path in paths if is_feature_set(path)}
    for path in paths:
        if path not in sets:
            check_ready(path, names)
            check_labelled(path)
    if several_places:
        _check_places([path for path in paths if path not in sets], sets.values())
    maps: list[LabelledMap] = []
    with progress_bar("images") as bar:
        for path in paths:
            maps += sets[path] if path in sets else [_labelled_map(path, names, bar)]
    return maps


def _maps_of_set(path: Path, names: Sequence[str]) -> list[LabelledMap]:
    """All maps of a feature set (RoomsegError if it has none)."""
    from dataset import RoomsegError
    from roomseg.feature_set import read_feature_set

    found = [item.labelled for item in read_feature_set(path)]
    if not found:
        raise RoomsegError(f"{path}: has no maps, expected at least 1")
    return [replace(item, features=item.features.subset(names)) for item in found]


def _labelled_map(path: Path, names: Sequence[str], bar: Progress) -> LabelledMap:
    from dataset import MapFile
    from roomseg.labelled_map import LabelledMap

    with MapFile(path) as file:
        return LabelledMap.of(file.topomap, compute(file, names, bar))


def origins(paths: Sequence[Path]) -> list[Path]:
    """The file of each of `labelled_maps`."""
    from roomseg.feature_set import is_feature_set, keys_in

    counts = [len(keys_in(path)) if is_feature_set(path) else 1 for path in paths]
    return [path for path, count in zip(paths, counts, strict=True) for _ in range(count)]


def compute(file: MapFile, names: Sequence[str], bar: Progress) -> EdgeFeatures:
    """Compute the edge features of one map; with a line of progress if images are read."""
    from roomseg.features import FROM_IMAGES, edge_features

    if not FROM_IMAGES & set(names):
        return edge_features(file, names)
    show = follow(bar, file.path.name)
    show(0, len(file.done))
    features = edge_features(file, names, progress=show)
    show(len(file.done), len(file.done))
    return features


def check_ready(path: Path, names: Sequence[str]) -> None:
    """Refuse a map without the images that features need, and say how to get them."""
    from dataset import MapFile, RoomsegError
    from roomseg.features import FROM_IMAGES

    with MapFile(path) as file:
        n, done = len(file.done), file.image_count
    if done < n and FROM_IMAGES & set(names):
        raise RoomsegError(
            f"{path}: {done} of {n} nodes have an image, expected all; "
            f"`roomseg render {path}` makes them"
        )


def check_labelled(path: Path) -> None:
    """Refuse a map without a complete ground truth (RoomsegError)."""
    from dataset import RoomsegError, read_map

    truth = read_map(path).ground_truth
    if truth is None or truth.room is None:
        raise RoomsegError(
            f"{path}: has no /ground_truth/room, expected the room of every node; "
            "`roomseg simulate` makes maps with it, docs/robot.md tells how to label your own"
        )


def _check_places(paths: Iterable[Path], sets: Iterable[Sequence[LabelledMap]]) -> None:
    """Refuse maps of one place, before minutes are spent on their images."""
    from dataset import RoomsegError, read_map

    names = {read_map(path).environment for path in paths}
    names |= {item.environment for maps in sets for item in maps}
    if len(names) < 2:
        raise RoomsegError(
            f"maps: all of the environment {names.pop()!r}, expected at least 2 environments "
            "to leave one out"
        )


@click.command("features", epilog=EXAMPLE)
@maps_argument
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    required=True,
    help="The feature set; maps that it has already are left alone.",
)
@jobs_option
def command(*, maps: tuple[Path, ...], output: Path, jobs: int) -> None:
    """Put the edge features and the truth of maps with images into one small file.

    It holds the passageway feature for all parameters of Table 2, and what figures need, so
    that `roomseg reproduce --from-features` needs neither maps nor images.
    """
    from dataset import RoomsegError
    from roomseg.cli.feature_sets import complete_feature_set

    if output.resolve() in {path.resolve() for path in maps}:
        raise RoomsegError(f"{output}: is one of the maps and would be lost, expected another name")
    new = complete_feature_set(maps, output, jobs)
    size = output.stat().st_size / 1e6
    click.echo(f"{output}: {counted(len(maps), 'map')}, {new} of them new, {size:.1f} MB")
