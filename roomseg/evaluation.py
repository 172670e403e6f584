"""Leave-one-environment-out evaluation (§2.3.3, §3.2, §3.3).

Maps of one place are never in both the training and the test set. k-means of
each map is seeded by the evaluation's seed and the map's name, so that a
result depends neither on the order of the maps nor on the number of jobs.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dataset.errors import FormatError
from roomseg.classifier import BorderModel, ClassifierParameters, TrainingMap, train
from roomseg.labelled_map import LabelledMap
from roomseg.metrics import (
    BorderQuality,
    SegmentationQuality,
    border_quality,
    segmentation_quality,
)
from roomseg.room_count import (
    EigenvalueGap,
    NodeCountRegression,
    RoomCountQuality,
    room_count_quality,
)
from roomseg.segmentation import affinity_of, edge_weights, segment
from roomseg.spectral import laplacian_eigenvalues

__all__ = [
    "Evaluation",
    "MapResult",
    "eigenvalues",
    "estimate_room_counts",
    "evaluate_room_count",
    "folds",
    "judge",
    "leave_one_environment_out",
    "map_rng",
    "result_of",
    "segment_map",
    "train_on",
]


MOST_ROOMS = 20
"""Eigenvalue gaps beyond this one are not looked at."""


@dataclass(frozen=True)
class MapResult:
    """What came out for one map.

    Attributes
    ----------
    environment, run : str
    predicted : array of bool, shape (e',)
        Kept edges that the classifier calls border edges (Fig. 12).
    labels, uniform_labels : arrays, shape (n,)
        Segmentation with the classifier and with uniform weights (§3.3).
    quality, uniform_quality : SegmentationQuality
    borders : BorderQuality
        Of the predicted border edges.
    """

    environment: str
    run: str
    predicted: NDArray[np.bool_]
    labels: NDArray[np.int32]
    uniform_labels: NDArray[np.int32]
    quality: SegmentationQuality
    uniform_quality: SegmentationQuality
    borders: BorderQuality


@dataclass(frozen=True)
class Evaluation:
    """Results of all maps.

    Attributes
    ----------
    results : tuple of MapResult
        In the order in which the maps were given.
    names : tuple of str
        The features.
    parameters : ClassifierParameters
    """

    results: tuple[MapResult, ...]
    names: tuple[str, ...]
    parameters: ClassifierParameters

    @property
    def impurity(self) -> NDArray[np.float64]:
        """Impurity of each map with the classifier, shape (maps,)."""
        return np.array([result.quality.impurity for result in self.results])

    @property
    def uniform_impurity(self) -> NDArray[np.float64]:
        """Impurity of each map with uniform weights, shape (maps,)."""
        return np.array([result.uniform_quality.impurity for result in self.results])

    @property
    def mean_impurity(self) -> float:
        """Mean impurity over all maps (§2.3.3)."""
        return float(self.impurity.mean())

    @property
    def median_impurity(self) -> float:
        """Median impurity over all maps (Table 5)."""
        return float(np.median(self.impurity))


def map_rng(seed: int, item: LabelledMap) -> np.random.Generator:
    """Make a generator of the map's own, whatever other maps there are."""
    return np.random.default_rng([seed, zlib.crc32(item.name.encode())])


def train_on(
    maps: Sequence[LabelledMap], parameters: ClassifierParameters | None = None
) -> BorderModel:
    """Train one classifier on the edges of several maps (§2.3.2).

    The result depends a little on the order of the rows, so the maps are
    taken in the order of their names, whatever order they are given in.

    Raises
    ------
    FormatError
        If there is no map, maps differ in their features, or all edges are of
        one kind.
    """
    if not maps:
        raise FormatError("maps: none to train on, expected at least 1")
    maps = sorted(maps, key=lambda item: (item.environment, item.run))
    names = maps[0].features.names
    values = [item.features.subset(names).values for item in maps]
    is_border = [item.is_border for item in maps]
    model = train(np.concatenate(values), np.concatenate(is_border), names, parameters)
    return replace(model, trained_on=tuple(_training_map(item) for item in maps))


def _training_map(item: LabelledMap) -> TrainingMap:
    return TrainingMap(
        item.environment,
        item.run,
        nodes=item.features.graph.node_count,
        rooms=int(item.room_count),
        edges=len(item.is_border),
        border_edges=int(item.is_border.sum()),
    )


def segment_map(item: LabelledMap, model: BorderModel | None, seed: int = 0) -> NDArray[np.int32]:
    """Segment a labelled map into its true number of rooms; None: uniform weights."""
    graph = item.features.graph
    predicted = None if model is None else model.predict(item.features)
    rho = 1.0 if model is None else model.parameters.rho
    return segment(graph, predicted, item.room_count, map_rng(seed, item), rho)


def leave_one_environment_out(
    maps: Sequence[LabelledMap],
    parameters: ClassifierParameters | None = None,
    *,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> Evaluation:
    """Segment every map with a classifier trained on all other environments (§2.3.3).

    Parameters
    ----------
    maps : sequence of LabelledMap
    parameters : ClassifierParameters, optional
    seed : int
        For the starts of k-means.
    progress : callable, optional
        Called with (maps done, maps in all).

    Returns
    -------
    Evaluation

    Raises
    ------
    FormatError
        If the maps come from fewer than two environments.
    """
    parameters = parameters or ClassifierParameters()
    results: dict[int, MapResult] = {}
    for known, test in folds(maps):
        model = train_on([maps[i] for i in known], parameters)
        for index in test:
            results[index] = judge(maps[index], model, seed)
            if progress is not None:
                progress(len(results), len(maps))
    ordered = tuple(results[index] for index in range(len(maps)))
    return Evaluation(ordered, maps[0].features.names, parameters)


def folds(maps: Sequence[LabelledMap]) -> list[tuple[list[int], list[int]]]:
    """Leave each environment out once: indices of the other maps, and of its own.

    Raises
    ------
    FormatError
        If the maps come from fewer than two environments.
    """
    environments = sorted({item.environment for item in maps})
    if len(environments) < 2:
        raise FormatError(
            f"maps: {len(environments)} environments ({', '.join(environments)}), "
            "expected at least 2 to leave one out"
        )
    return [
        (
            [i for i, item in enumerate(maps) if item.environment != name],
            [i for i, item in enumerate(maps) if item.environment == name],
        )
        for name in environments
    ]


def judge(item: LabelledMap, model: BorderModel, seed: int = 0) -> MapResult:
    """Segment one map with and without the model, and compare with its ground truth."""
    labels, uniform = segment_map(item, model, seed), segment_map(item, None, seed)
    return result_of(item, model.predict(item.features), labels, uniform)


def result_of(
    item: LabelledMap,
    predicted: NDArray[np.bool_],
    labels: NDArray[np.int32],
    uniform: NDArray[np.int32],
) -> MapResult:
    """Compare what was found, see `MapResult`, with a map's ground truth."""
    return MapResult(
        item.environment,
        item.run,
        predicted,
        labels,
        uniform,
        segmentation_quality(labels, item.room),
        segmentation_quality(uniform, item.room),
        border_quality(predicted, item.is_border),
    )


def evaluate_room_count(
    maps: Sequence[LabelledMap],
    parameters: ClassifierParameters | None = None,
    *,
    most_rooms: int = MOST_ROOMS,
) -> tuple[RoomCountQuality, RoomCountQuality]:
    """Table 7: node count regression and eigenvalue gap, leaving one environment out.

    The Laplacian's weights come from a classifier that has not seen the
    environment, as they would in use; those of the training maps come from the
    same classifier.

    Parameters
    ----------
    maps : sequence of LabelledMap
    parameters : ClassifierParameters, optional
    most_rooms : int
        Gaps beyond this one are not looked at.

    Returns
    -------
    tuple of two RoomCountQuality
        Of the node count regression, and of the eigenvalue gap.

    Raises
    ------
    FormatError
        If the maps come from fewer than two environments, or one has more
        rooms than ``most_rooms``.
    """
    rooms = [item.room_count for item in maps]
    by_nodes, by_gap = estimate_room_counts(maps, parameters, most_rooms=most_rooms)
    return (
        room_count_quality(by_nodes.tolist(), rooms),
        room_count_quality(by_gap.tolist(), rooms),
    )


def estimate_room_counts(
    maps: Sequence[LabelledMap],
    parameters: ClassifierParameters | None = None,
    *,
    most_rooms: int = MOST_ROOMS,
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Room counts of which `evaluate_room_count` tells the quality, each of shape (maps,)."""
    by_nodes, by_gap = np.zeros(len(maps), np.int64), np.zeros(len(maps), np.int64)
    rooms = [item.room_count for item in maps]
    counts = [item.features.graph.node_count for item in maps]
    for known, test in folds(maps):
        model = train_on([maps[i] for i in known], parameters)
        spectra = [eigenvalues(item, model, most_rooms) for item in maps]
        regression = NodeCountRegression.fit([counts[i] for i in known], [rooms[i] for i in known])
        gap = EigenvalueGap.fit([spectra[i] for i in known], [rooms[i] for i in known])
        for i in test:
            by_nodes[i], by_gap[i] = regression.predict(counts[i]), gap.predict(spectra[i])
    return by_nodes, by_gap


def eigenvalues(
    item: LabelledMap, model: BorderModel | None, most_rooms: int = MOST_ROOMS
) -> NDArray[np.float64]:
    """λ_1 .. λ_{most_rooms + 1} of a map weighted by the model; None: uniform weights."""
    graph = item.features.graph
    predicted = None if model is None else model.predict(item.features)
    weights = edge_weights(graph, predicted, 1.0 if model is None else model.parameters.rho)
    return laplacian_eigenvalues(affinity_of(graph, weights), most_rooms + 1)
