"""Which maps play which part in the experiments, and classifiers that have not seen a place."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dataset.errors import FormatError
from roomseg.classifier import ClassifierParameters
from roomseg.evaluation import MapResult, judge, result_of, train_on
from roomseg.experiments import paper
from roomseg.experiments.cache import Cache
from roomseg.feature_set import MapFeatures
from roomseg.features import SUBSETS
from roomseg.labelled_map import LabelledMap

__all__ = ["ADDITIONAL_PLACE", "NEW_RUN", "Maps", "judged", "mean_and_median", "part_of"]

ADDITIONAL_PLACE = "novel"
"""Maps of this environment are of the additional place of §3.4."""
NEW_RUN = "new"
"""Runs whose names begin so are the new runs of §3.4."""


@dataclass(frozen=True)
class Maps:
    """The maps of the experiments.

    Attributes
    ----------
    reference : tuple of LabelledMap
        Those of Table 8.
    new : tuple of LabelledMap
        New runs in known places (§3.4).
    novel : tuple of LabelledMap
        Runs in the additional place (§3.4).
    identity : str
        Tells these maps and features from others.
    """

    reference: tuple[LabelledMap, ...]
    new: tuple[LabelledMap, ...]
    novel: tuple[LabelledMap, ...]
    identity: str

    @classmethod
    def of(cls, features: Sequence[MapFeatures], combination: int) -> Maps:
        """Sort maps by their parts, with the passageway feature of a combination of Table 2.

        Raises
        ------
        FormatError
            If fewer than two environments are left as the reference.
        """
        parts: dict[str, list[LabelledMap]] = {"reference": [], "new": [], "novel": []}
        for item in sorted(features, key=lambda item: _as_in_table_8(item.labelled)):
            parts[part_of(item.labelled)].append(item.with_passageway(combination))
        places = {item.environment for item in parts["reference"]}
        if len(places) < 2:
            raise FormatError(
                f"maps: {len(places)} environments, expected at least 2 to leave one out"
            )
        keys = " ".join(item.key for item in features)
        identity = hashlib.sha256(f"{combination} {keys}".encode()).hexdigest()
        reference, new, novel = (tuple(parts[name]) for name in parts)
        return cls(reference, new, novel, identity)

    def with_features(self, variant: str) -> Maps:
        """The same maps with a subset of the features (§3.3)."""
        names = SUBSETS[variant]
        reference, new, novel = (
            tuple(replace(item, features=item.features.subset(names)) for item in maps)
            for maps in (self.reference, self.new, self.novel)
        )
        return Maps(reference, new, novel, f"{self.identity} {names}")


def _as_in_table_8(item: LabelledMap) -> tuple[int, str, str]:
    """Sort by the paper's order of environments, others last."""
    known = list(paper.ENVIRONMENTS)
    rank = known.index(item.environment) if item.environment in known else len(known)
    return rank, item.environment, item.run


def part_of(item: LabelledMap) -> str:
    """Reference, new or novel, by the names of place and run."""
    if item.environment == ADDITIONAL_PLACE:
        return "novel"
    return "new" if item.run.startswith(NEW_RUN) else "reference"


def judged(
    maps: Maps,
    tests: Sequence[LabelledMap],
    parameters: ClassifierParameters,
    cache: Cache,
    *,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[MapResult, ...]:
    """Judge each map with a classifier trained on the reference maps of all other places.

    For maps of the reference that is leave-one-environment-out (§2.3.3); for the new runs,
    their place is left out, too, and for the additional place nothing is (§3.4).
    """
    names = [item.name for item in tests]
    depends = ("judged", maps.identity, names, parameters, seed)
    arrays = cache.get(
        "rooms",
        depends,
        lambda: dict(_judge_all(maps.reference, tests, parameters, seed, progress)),
    )
    return tuple(
        result_of(item, *(arrays[f"{kind}-{index}"] for kind in ("predicted", "labels", "uniform")))
        for index, item in enumerate(tests)
    )


def _judge_all(
    reference: Sequence[LabelledMap],
    tests: Sequence[LabelledMap],
    parameters: ClassifierParameters,
    seed: int,
    progress: Callable[[int, int], None] | None,
) -> Iterator[tuple[str, NDArray[Any]]]:
    """Predicted border edges and both segmentations of every test map, by name and index."""
    done = 0
    for environment in sorted({item.environment for item in tests}):
        training = [item for item in reference if item.environment != environment]
        model = train_on(training, parameters)
        for index, item in enumerate(tests):
            if item.environment != environment:
                continue
            result = judge(item, model, seed)
            yield f"predicted-{index}", result.predicted
            yield f"labels-{index}", result.labels
            yield f"uniform-{index}", result.uniform_labels
            done += 1
            if progress is not None:
                progress(done, len(tests))


def mean_and_median(results: Sequence[MapResult], *, uniform: bool = False) -> tuple[float, float]:
    """Mean and median impurity × 100 over maps."""
    values = [
        100.0 * (item.uniform_quality if uniform else item.quality).impurity for item in results
    ]
    return float(np.mean(values)), float(np.median(values))
