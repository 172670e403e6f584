"""Parameter searches whose results are kept (§2.3.3)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np
from numpy.typing import NDArray

from roomseg.classifier import ClassifierParameters
from roomseg.experiments.cache import Cache
from roomseg.experiments.grids import Grid
from roomseg.experiments.maps import Maps
from roomseg.parameter_search import search_parameters

__all__ = ["Search", "search"]


@dataclass(frozen=True)
class Search:
    """Impurity of each map for each combination.

    Attributes
    ----------
    combinations : tuple of p ClassifierParameters
    impurity : array, shape (p, maps)
    """

    combinations: tuple[ClassifierParameters, ...]
    impurity: NDArray[np.float64]

    @property
    def mean(self) -> NDArray[np.float64]:
        """Mean impurity of each combination, shape (p,)."""
        mean: NDArray[np.float64] = self.impurity.mean(axis=1)
        return mean

    @property
    def median(self) -> NDArray[np.float64]:
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


def search(
    maps: Maps,
    grid: Grid,
    name: str,
    cache: Cache,
    *,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> Search:
    """Judge every combination of a grid on the reference maps; what is known is not redone.

    Combinations that share γ and w are kept together, so that a stopped search goes on where
    it was.
    """
    combinations = grid.combinations()
    at = {parameters: index for index, parameters in enumerate(combinations)}
    impurity = np.empty((len(combinations), len(maps.reference)))
    done = 0
    for part in _parts(grid):
        some = part.combinations()
        depends = ("search", maps.identity, some, seed)
        rows = cache.get(name, depends, partial(_impurities, maps, some, seed))
        impurity[[at[parameters] for parameters in some]] = rows["impurity"]
        done += len(some)
        if progress is not None:
            progress(done, len(combinations))
    return Search(combinations, impurity)


def _parts(grid: Grid) -> Iterator[Grid]:
    """What shares its kernel and class weight, the parts that are kept one by one."""
    for gamma, weight in product(grid.log2_gamma, grid.class_weight):
        yield replace(grid, log2_gamma=(gamma,), class_weight=(weight,))


def _impurities(
    maps: Maps, combinations: Sequence[ClassifierParameters], seed: int
) -> dict[str, NDArray[np.float64]]:
    """Impurity of each map for each combination, in the order of both."""
    found = search_parameters(maps.reference, combinations, seed=seed)
    by_parameters = {evaluation.parameters: evaluation.impurity for evaluation in found}
    return {"impurity": np.stack([by_parameters[c] for c in combinations])}
