"""The score sheet: eight measures of the method, of uniform weights and of the one-room answer.

Border edges are judged by where the found rooms end: an edge whose nodes lie in different found
rooms is a border edge. Several border lines across a deep passage make several rows of true border
edges, of which even the true rooms cut one, so that a recall of 1 is out of reach there.

The number of rooms is given for the segmentation, as in the paper; the room count's error is that
of the eigenvalue gap (§2.4.1) with the weights in question, and of the answer 1.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass, fields

import numpy as np
from numpy.typing import NDArray

from roomseg.classifier import BorderModel, ClassifierParameters
from roomseg.evaluation import Evaluation, MapResult, eigenvalues, folds, judge, train_on
from roomseg.labelled_map import LabelledMap
from roomseg.metrics import border_quality, room_overlap, segmentation_quality
from roomseg.room_count import EigenvalueGap

__all__ = ["ANSWERS", "MEASURES", "Score", "ScoreSheet", "score", "score_sheet"]

ANSWERS = ("method", "uniform", "one room")
RESAMPLES = 10_000


@dataclass(frozen=True)
class Score:
    """Measures of one answer for one map, 0 to 1 but for the last.

    Attributes
    ----------
    impurity : float
        Eq. 18; lower is better.
    adjusted_rand, v_measure : float
    mean_iou, room_f1 : float
        Of rooms that are paired one to one (`roomseg.metrics.room_overlap`).
    border_precision, border_recall : float
        Of the edges between found rooms.
    room_count_error : float
        Absolute.
    """

    impurity: float
    adjusted_rand: float
    v_measure: float
    mean_iou: float
    room_f1: float
    border_precision: float
    border_recall: float
    room_count_error: float


MEASURES = tuple(field.name for field in fields(Score))


@dataclass(frozen=True)
class ScoreSheet:
    """Scores of every map.

    Attributes
    ----------
    evaluation : Evaluation
        The segmentations.
    scores : mapping of arrays, shape (maps, measures)
        By `ANSWERS`; the columns are `MEASURES`.
    """

    evaluation: Evaluation
    scores: Mapping[str, NDArray[np.float64]]

    @property
    def places(self) -> tuple[str, ...]:
        """The environments, in order."""
        return tuple(dict.fromkeys(result.environment for result in self.evaluation.results))

    def of_place(self, answer: str, place: str) -> NDArray[np.float64]:
        """Mean over the maps of a place, shape (measures,)."""
        mean: NDArray[np.float64] = self.scores[answer][self._at(place)].mean(axis=0)
        return mean

    def _at(self, place: str) -> NDArray[np.int64]:
        names = [result.environment for result in self.evaluation.results]
        return np.flatnonzero(np.array(names) == place)

    def intervals(self, answer: str, rng: np.random.Generator) -> NDArray[np.float64]:
        """95 % intervals of the means over all maps, shape (2, measures).

        Places are drawn with replacement, each with all its maps (bootstrap): maps of a place
        are too much alike to be drawn by themselves.
        """
        groups = [self._at(place) for place in self.places]
        sums = np.stack([self.scores[answer][group].sum(axis=0) for group in groups])
        counts = np.array([len(group) for group in groups])
        drawn = rng.integers(len(groups), size=(RESAMPLES, len(groups)))
        means = sums[drawn].sum(axis=1) / counts[drawn].sum(axis=1)[:, None]
        limits: NDArray[np.float64] = np.percentile(means, (2.5, 97.5), axis=0)
        return limits


def score(labels: NDArray[np.int32], item: LabelledMap, room_count: int) -> Score:
    """Judge a segmentation, shape (n,), and an estimated room count."""
    edges = item.features.graph.edges
    quality = segmentation_quality(labels, item.room)
    borders = border_quality(labels[edges[:, 0]] != labels[edges[:, 1]], item.is_border)
    return Score(
        quality.impurity,
        quality.adjusted_rand,
        quality.v_measure,
        *room_overlap(labels, item.room),
        borders.precision,
        borders.recall,
        float(abs(room_count - item.room_count)),
    )


def score_sheet(
    maps: Sequence[LabelledMap],
    parameters: ClassifierParameters | None = None,
    *,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> ScoreSheet:
    """Judge every map, each environment left out of training once (§2.3.3).

    Parameters
    ----------
    maps : sequence of LabelledMap
    parameters : ClassifierParameters, optional
    seed : int
        For the starts of k-means.
    progress : callable, optional
        Called with (maps done, maps in all).

    Raises
    ------
    FormatError
        If the maps come from fewer than two environments.
    """
    parameters = parameters or ClassifierParameters()
    results: dict[int, MapResult] = {}
    counts: dict[int, tuple[int, int]] = {}
    for known, test in folds(maps):
        model = train_on([maps[i] for i in known], parameters)
        by_method, by_uniform = (_counts(maps, known, test, of) for of in (model, None))
        for index in test:
            results[index] = judge(maps[index], model, seed)
            counts[index] = by_method[index], by_uniform[index]
            if progress is not None:
                progress(len(results), len(maps))
    ordered = tuple(results[index] for index in range(len(maps)))
    rows: dict[str, list[Score]] = {answer: [] for answer in ANSWERS}
    for index, (item, result) in enumerate(zip(maps, ordered, strict=True)):
        one = np.zeros_like(result.labels)
        rows["method"].append(score(result.labels, item, counts[index][0]))
        rows["uniform"].append(score(result.uniform_labels, item, counts[index][1]))
        rows["one room"].append(score(one, item, 1))
    scores = {answer: np.array([astuple(row) for row in found]) for answer, found in rows.items()}
    return ScoreSheet(Evaluation(ordered, maps[0].features.names, parameters), scores)


def _counts(
    maps: Sequence[LabelledMap],
    known: Sequence[int],
    test: Sequence[int],
    model: BorderModel | None,
) -> dict[int, int]:
    """Room counts of the test maps by the eigenvalue gap, fitted to the known ones."""
    rooms = [maps[i].room_count for i in known]
    if max(rooms) == 1:
        return dict.fromkeys(test, 1)
    gap = EigenvalueGap.fit([eigenvalues(maps[i], model) for i in known], rooms)
    return {i: gap.predict(eigenvalues(maps[i], model)) for i in test}
