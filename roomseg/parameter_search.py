"""Choosing C, γ, w and ρ by the mean impurity of the segmentations (§2.3.3).

As in the paper, a combination is judged by leaving each environment out of
training once, and the one with the lowest mean impurity wins. The winner's
impurity is therefore optimistic, the more so the fewer the maps: they chose it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product

from roomseg.classifier import ClassifierParameters
from roomseg.evaluation import Evaluation, leave_one_environment_out
from roomseg.labelled_map import LabelledMap

__all__ = ["EXCERPT", "search_parameters"]

EXCERPT = tuple(
    ClassifierParameters(C=2.0**c, gamma=2.0**g) for c, g in product((-3, 1, 5), (-3, -7, -11))
)
"""Nine points of Table 4's full space, with w = 40 and ρ = 60; the first is the paper's choice."""


def search_parameters(
    maps: Sequence[LabelledMap],
    candidates: Sequence[ClassifierParameters] = EXCERPT,
    *,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Evaluation, ...]:
    """Evaluate every combination and sort by mean impurity, best first (§2.3.3, Table 5).

    Parameters
    ----------
    maps : sequence of LabelledMap
        From at least two environments.
    candidates : sequence of ClassifierParameters
    seed : int
        For the starts of k-means.
    progress : callable, optional
        Called with (combinations done, combinations in all).

    Returns
    -------
    tuple of Evaluation
        One per combination; of equally good ones the earlier candidate comes first.

    Raises
    ------
    FormatError
        If the maps come from fewer than two environments.
    """
    evaluations = []
    for done, parameters in enumerate(candidates, 1):
        evaluations.append(leave_one_environment_out(maps, parameters, seed=seed))
        if progress is not None:
            progress(done, len(candidates))
    return tuple(sorted(evaluations, key=lambda evaluation: evaluation.mean_impurity))
