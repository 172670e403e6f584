"""Parameter searches whose results are kept (§2.3.3)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

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

    Combinations that share C, γ and w are kept together, so that a stopped search goes on
    where it was.
    """
    combinations = grid.combinations()
    step = len(grid.rho)
    rows = []
    for begin in range(0, len(combinations), step):
        some = combinations[begin : begin + step]
        depends = ("search", maps.identity, some, seed)
        rows.append(cache.get(name, depends, partial(_impurities, maps, some, seed)))
        if progress is not None:
            progress(begin + len(some), len(combinations))
    return Search(combinations, np.concatenate([row["impurity"] for row in rows]))


def _impurities(
    maps: Maps, combinations: Sequence[ClassifierParameters], seed: int
) -> dict[str, NDArray[np.float64]]:
    """Impurity of each map for each combination, in the order of both."""
    found = search_parameters(maps.reference, combinations, seed=seed)
    by_parameters = {evaluation.parameters: evaluation.impurity for evaluation in found}
    return {"impurity": np.stack([by_parameters[c] for c in combinations])}
