"""Compute what a feature set lacks, map by map, each safe as soon as it is finished."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from roomseg.cli.features import check_labelled, check_ready
from roomseg.cli.output import follow, progress_bar

if TYPE_CHECKING:
    from rich.progress import Progress

    from roomseg.feature_set import MapFeatures

__all__ = ["complete_feature_set"]


def complete_feature_set(maps: Sequence[Path], output: Path, jobs: int) -> int:
    """Put the maps into a feature set that may have some of them; how many were new.

    Raises
    ------
    RoomsegError
        Before anything is computed: if a map is unreadable, lacks images or its ground truth.
    """
    from dataset import MapFile
    from roomseg.feature_set import add_to_feature_set, content_key, keys_in
    from roomseg.features import FEATURES

    for path in maps:
        check_ready(path, FEATURES)
        check_labelled(path)
    known, todo = keys_in(output), []
    for path in maps:
        with MapFile(path) as file:
            if content_key(file) not in known:
                todo.append(path)
    with progress_bar("maps") as bar:
        show = follow(bar, "features")
        show(len(maps) - len(todo), len(maps))
        for done, item in enumerate(_computed(todo, jobs, bar), len(maps) - len(todo) + 1):
            add_to_feature_set(output, [item])
            show(done, len(maps))
    return len(todo)


def _computed(maps: Sequence[Path], jobs: int, bar: Progress) -> Iterator[MapFeatures]:
    """Features of each map, in this process or in several."""
    if jobs > 1 and len(maps) > 1:
        from roomseg.cli.parallel import in_processes

        yield from in_processes(_features_of, maps, jobs)
        return
    from dataset import MapFile
    from roomseg.feature_set import compute_features

    for path in maps:
        with MapFile(path) as file:
            yield compute_features(file, follow(bar, path.name))


def _features_of(path: Path) -> MapFeatures:
    """Work of one process."""
    from dataset import MapFile
    from roomseg.feature_set import compute_features

    with MapFile(path) as file:
        return compute_features(file)
