"""Choosing C, γ, w and ρ by the mean impurity of the segmentations (§2.3.3).

As in the paper, a combination is judged by leaving each environment out of training once, and
the one with the lowest mean impurity wins. The winner's impurity is therefore optimistic,
the more so the fewer the maps: they chose it.

The numbers are those of `roomseg.evaluation.leave_one_environment_out` for each combination,
without what would be done twice. The work comes in parts, one place left out and one γ, of
which every solution is the start of the next (`roomseg.svm.SvmPath`);
all ρ share a classification, and a map whose predicted border edges have come up before
is not segmented again. Parts do not depend on each other, nor on how many processes
there are.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray
from sklearn.preprocessing import StandardScaler
from threadpoolctl import threadpool_limits

from roomseg.classifier import ClassifierParameters, check_both_kinds
from roomseg.evaluation import folds, map_rng
from roomseg.labelled_map import LabelledMap
from roomseg.metrics import impurity
from roomseg.segmentation import segment
from roomseg.svm import SvmPath

if TYPE_CHECKING:
    from roomseg.experiments.cache import Cache

__all__ = ["EXCERPT", "Part", "Search", "judge_part", "search_parameters"]

Floats = NDArray[np.float64]

EXCERPT = tuple(
    ClassifierParameters(C=2.0**c, gamma=2.0**gamma) for c in (-3, 1, 5) for gamma in (-3, -7, -11)
)
"""Nine points of Table 4's full space, with w = 40 and ρ = 60; the first is the paper's choice."""


@dataclass(frozen=True)
class Search:
    """Impurity of each map for each combination.

    Attributes
    ----------
    combinations : tuple of p ClassifierParameters
    impurity : array, shape (p, maps)
    """

    combinations: tuple[ClassifierParameters, ...]
    impurity: Floats

    @property
    def mean(self) -> Floats:
        """Mean impurity of each combination, shape (p,)."""
        mean: Floats = self.impurity.mean(axis=1)
        return mean

    @property
    def median(self) -> Floats:
        """Median impurity of each combination, shape (p,)."""
        return np.asarray(np.median(self.impurity, axis=1))

    @property
    def order(self) -> NDArray[np.int64]:
        """Combinations by mean impurity; of equal ones the first of the grid comes first."""
        return np.argsort(np.round(self.mean, 12), kind="stable")

    @property
    def best(self) -> ClassifierParameters:
        """The combination with the lowest mean impurity."""
        return self.combinations[int(self.order[0])]

    @property
    def lowest(self) -> float:
        """Its mean impurity."""
        return float(self.mean.min())

    def joined(self, other: Search) -> Search:
        """Both together, without those of ``other`` that are here, too."""
        new = [i for i, c in enumerate(other.combinations) if c not in set(self.combinations)]
        return Search(
            (*self.combinations, *(other.combinations[i] for i in new)),
            np.concatenate([self.impurity, other.impurity[new]]),
        )


@dataclass(frozen=True)
class Part:
    """One place left out, and all combinations with one γ.

    Attributes
    ----------
    training, test : tuples of LabelledMap
    combinations : tuple of ClassifierParameters
    columns, rows : arrays
        Where its results belong in `Search.impurity`.
    """

    training: tuple[LabelledMap, ...]
    test: tuple[LabelledMap, ...]
    combinations: tuple[ClassifierParameters, ...]
    rows: NDArray[np.int64]
    columns: NDArray[np.int64]


def search_parameters(
    maps: Sequence[LabelledMap],
    candidates: Sequence[ClassifierParameters] = EXCERPT,
    *,
    seed: int = 0,
    jobs: int = 1,
    cache: Cache | None = None,
    name: str = "search",
    progress: Callable[[int, int], None] | None = None,
) -> Search:
    """Judge every combination, leaving each environment out once (§2.3.3, Table 5).

    Parameters
    ----------
    maps : sequence of LabelledMap
        From at least two environments.
    candidates : sequence of ClassifierParameters
    seed : int
        For the starts of k-means.
    jobs : int
        Processes, of one thread each.
    cache : Cache, optional
        Keeps the parts that are done; a stopped search goes on from there.
    name : str
        Begins their files' names.
    progress : callable, optional
        Called with (parts done, parts in all).

    Raises
    ------
    FormatError
        If the maps come from fewer than two environments, or the training edges of one are
        all of one kind.
    """
    maps = [replace(item, sketch=None) for item in maps]
    parts = list(_parts(maps, candidates))
    found = np.empty((len(candidates), len(maps)))
    work = partial(_kept, seed=seed, cache=cache, name=name, maps=_digest(maps))
    # What is not yet asked for is not begun, so that a stopped search leaves nothing half done.
    processes = Parallel(jobs, return_as="generator_unordered", batch_size=1, pre_dispatch=jobs)
    results = processes(delayed(work)(i, part) for i, part in enumerate(parts))
    for done, (index, impurities) in enumerate(results, 1):
        found[np.ix_(parts[index].rows, parts[index].columns)] = impurities
        if progress is not None:
            progress(done, len(parts))
    return Search(tuple(candidates), found)


def _parts(
    maps: Sequence[LabelledMap], candidates: Sequence[ClassifierParameters]
) -> Iterator[Part]:
    """All parts, those that take long first."""
    places = folds(maps)
    for training, _ in places:
        check_both_kinds(np.concatenate([maps[i].is_border for i in training]))
    for gamma in sorted({parameters.gamma for parameters in candidates}, reverse=True):
        rows = [i for i, parameters in enumerate(candidates) if parameters.gamma == gamma]
        for training, test in places:
            yield Part(
                tuple(sorted((maps[i] for i in training), key=lambda item: item.name)),
                tuple(maps[i] for i in test),
                tuple(candidates[i] for i in rows),
                np.array(rows),
                np.array(test),
            )


def _digest(maps: Sequence[LabelledMap]) -> str:
    """Tells these maps and features from others."""
    digest = hashlib.sha256()
    for item in sorted(maps, key=lambda item: item.name):
        graph = item.features.graph
        digest.update(repr((item.name, item.room_count, item.features.names)).encode())
        for values in (item.features.values, graph.edges, graph.length, item.is_border, item.room):
            digest.update(np.ascontiguousarray(values).tobytes())
    return digest.hexdigest()


def _kept(
    index: int, part: Part, *, seed: int, cache: Cache | None, name: str, maps: str
) -> tuple[int, Floats]:
    """Impurities of a part, shape (combinations, test maps); from the cache if there."""

    def make() -> Mapping[str, NDArray[Any]]:
        with threadpool_limits(1):
            return {"impurity": judge_part(part, seed)[0]}

    if cache is None:
        return index, make()["impurity"]
    tested = [item.name for item in part.test]
    depends = ("part of a search", maps, tested, part.combinations, seed)
    return index, cache.get(name, depends, make)["impurity"]


def judge_part(part: Part, seed: int) -> tuple[Floats, list[NDArray[np.bool_]]]:
    """Train, classify and segment for all combinations of a part.

    Returns
    -------
    impurity : array, shape (combinations, test maps)
    predicted : list of array
        For each combination, which edges of all test maps are taken for border edges.
    """
    rooms = [_Segmentations(item, seed) for item in part.test]
    found = np.empty((len(part.combinations), len(rooms)))
    predicted: list[NDArray[np.bool_]] = [np.zeros(0, bool)] * len(found)
    ends = np.cumsum([len(item.is_border) for item in part.test])[:-1]
    for indices, is_border in _classified(part):
        for column, edges in enumerate(np.split(is_border, ends)):
            for row in indices:
                rho = part.combinations[row].rho
                found[row, column] = rooms[column].impurity(edges, rho)
        for row in indices:
            predicted[row] = is_border
    return found, predicted


def _classified(part: Part) -> Iterator[tuple[list[int], NDArray[np.bool_]]]:
    """Predicted border edges of all test maps, and for which combinations they are."""
    names = part.training[0].features.names
    values = [item.features.subset(names).values for item in (*part.training, *part.test)]
    known = np.concatenate(values[: len(part.training)])
    is_border = np.concatenate([item.is_border for item in part.training])
    scaler = StandardScaler().fit(known)
    asked = scaler.transform(np.concatenate(values[len(part.training) :]))
    path = SvmPath(scaler.transform(known), is_border, asked, part.combinations[0].gamma)
    for C, weight in sorted({(each.C, each.class_weight) for each in part.combinations}):
        pairs = ((each.C, each.class_weight) for each in part.combinations)
        indices = [index for index, pair in enumerate(pairs) if pair == (C, weight)]
        yield indices, path.fit(C, weight).decision > 0.0


class _Segmentations:
    """Impurities of one map's segmentations; equal ones are made once."""

    def __init__(self, item: LabelledMap, seed: int) -> None:
        self._item, self._seed = item, seed
        self._known: dict[tuple[bytes, float], float] = {}

    def impurity(self, predicted: NDArray[np.bool_], rho: float) -> float:
        """Impurity with these predicted border edges, as `evaluation.segment_map` finds it."""
        item = self._item
        key = np.packbits(predicted).tobytes(), rho if predicted.any() else 1.0
        if key not in self._known:
            rng = map_rng(self._seed, item)
            labels = segment(item.features.graph, predicted, item.room_count, rng, rho)
            self._known[key] = impurity(labels, item.room)
        return self._known[key]
