"""Parameter searches on the reference maps, whose results are kept (§2.3.3)."""

from __future__ import annotations

from collections.abc import Callable

from roomseg.experiments.cache import Cache
from roomseg.experiments.grids import Grid
from roomseg.experiments.maps import Maps
from roomseg.parameter_search import Search, search_parameters

__all__ = ["Search", "search"]


def search(
    maps: Maps,
    grid: Grid,
    name: str,
    cache: Cache,
    *,
    seed: int = 0,
    jobs: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> Search:
    """Judge every combination of a grid on the reference maps; what is known is not redone."""
    return search_parameters(
        maps.reference,
        grid.combinations(),
        seed=seed,
        jobs=jobs,
        cache=cache,
        name=name,
        progress=progress,
    )
