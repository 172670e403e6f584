"""Judging segmentations, border edges and single features.

Impurity (Eq. 18), Youden's J and the area under the ROC curve (§2.2.5), and
the statistics of Table 1 and §2.2.2 are the paper's; the adjusted Rand index,
V-measure, precision and recall are added because readers know them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from sklearn.metrics import adjusted_rand_score, roc_auc_score, roc_curve, v_measure_score
from sklearn.metrics.cluster import contingency_matrix

__all__ = [
    "BorderErrors",
    "BorderQuality",
    "FeatureQuality",
    "LengthStatistics",
    "SegmentationQuality",
    "WidthStatistics",
    "border_errors",
    "border_quality",
    "feature_quality",
    "impurity",
    "length_statistics",
    "purity",
    "room_overlap",
    "segmentation_quality",
    "width_statistics",
]

Floats = NDArray[np.float64]
Labels = NDArray[np.int32]
Flags = NDArray[np.bool_]


def purity(labels: Labels, rooms: Labels) -> float:
    """ψ of Eq. 18: fraction of nodes in the main room of their cluster.

    Parameters
    ----------
    labels : array, shape (n,)
        Clusters C_i.
    rooms : array, shape (n,)
        Ground truth R_j.
    """
    overlap = contingency_matrix(labels, rooms)
    return float(overlap.max(axis=1).sum() / len(labels))


def impurity(labels: Labels, rooms: Labels) -> float:
    """Impurity v = 1 - ψ (§2.3.3)."""
    return 1.0 - purity(labels, rooms)


@dataclass(frozen=True)
class SegmentationQuality:
    """Impurity (Eq. 18), adjusted Rand index and V-measure of a segmentation."""

    impurity: float
    adjusted_rand: float
    v_measure: float


def segmentation_quality(labels: Labels, rooms: Labels) -> SegmentationQuality:
    """Compare room labels with the ground truth, both of shape (n,)."""
    return SegmentationQuality(
        impurity(labels, rooms),
        float(adjusted_rand_score(rooms, labels)),
        float(v_measure_score(rooms, labels)),
    )


def room_overlap(labels: Labels, rooms: Labels, threshold: float = 0.5) -> tuple[float, float]:
    """Mean intersection over union, and F1 of the rooms that are found.

    Found and true rooms, both of shape (n,), are paired one to one so that the sum of their
    intersections over unions is largest (Hungarian method). The mean is over all true rooms,
    0 for one without a partner; a room is found if its partner has at least ``threshold``.
    """
    overlap = contingency_matrix(labels, rooms).astype(np.float64)
    union = overlap.sum(axis=1)[:, None] + overlap.sum(axis=0)[None] - overlap
    shared = overlap / union
    pairs = shared[linear_sum_assignment(shared, maximize=True)]
    hits = int(np.count_nonzero(pairs >= threshold))
    return float(pairs.sum() / overlap.shape[1]), 2.0 * hits / sum(overlap.shape)


@dataclass(frozen=True)
class BorderErrors:
    """Whole room borders, not edges: how many were missed, and how many are where none is."""

    missed: int
    false: int


def border_errors(labels: Labels, rooms: Labels, edges: NDArray[np.int64]) -> BorderErrors:
    """Count the room borders that a segmentation misses, and those that it makes up (§3.4).

    Two neighbouring true rooms whose nodes mostly lie in the same found room have lost the
    border between them; two neighbouring found rooms whose nodes mostly lie in the same true
    room have one too many. A border that is merely shifted is neither.

    Parameters
    ----------
    labels, rooms : arrays, shape (n,)
        Found and true room of each node.
    edges : array, shape (e', 2)
        Those which make rooms neighbours.
    """
    return BorderErrors(
        _not_told_apart(rooms, labels, edges), _not_told_apart(labels, rooms, edges)
    )


def _not_told_apart(of: Labels, by: Labels, edges: NDArray[np.int64]) -> int:
    """Count neighbouring classes of one labelling with the same main class in another."""
    index = np.unique(of, return_inverse=True)[1]
    main = contingency_matrix(of, by).argmax(axis=1)
    pairs = np.unique(np.sort(index.reshape(-1)[edges], axis=1), axis=0)
    apart = pairs[:, 0] != pairs[:, 1]
    return int(np.count_nonzero(apart & (main[pairs[:, 0]] == main[pairs[:, 1]])))


@dataclass(frozen=True)
class BorderQuality:
    """Predicted border edges: precision and recall; 0 where there is nothing to count."""

    precision: float
    recall: float


def border_quality(predicted: Flags, is_border: Flags) -> BorderQuality:
    """Compare predicted with true border edges, both of shape (e',)."""
    hits = int(np.count_nonzero(predicted & is_border))
    return BorderQuality(
        hits / max(1, int(np.count_nonzero(predicted))),
        hits / max(1, int(np.count_nonzero(is_border))),
    )


@dataclass(frozen=True)
class FeatureQuality:
    """How well a threshold on one feature finds border edges (§2.2.5, Table 3).

    Attributes
    ----------
    auc, youden : float
        Area under the ROC curve and Youden's J, in the better direction.
    higher_is_border : bool
        The direction: whether edges above the threshold are taken for borders.
    threshold : float
        Where J is reached; edges at the threshold count as borders.
    false_positive, true_positive : arrays
        The ROC curve (Fig. 11).
    """

    auc: float
    youden: float
    higher_is_border: bool
    threshold: float
    false_positive: Floats
    true_positive: Floats


def feature_quality(
    values: Floats, is_border: Flags, weights: Floats | None = None
) -> FeatureQuality:
    """ROC analysis of one feature; all arrays have shape (e',).

    Parameters
    ----------
    values : array
    is_border : array of bool
    weights : array, optional
        How many edges each stands for, if they are a sample; 1 if absent.

    Raises
    ------
    ValueError
        If the edges are all of one kind.
    """
    if is_border.all() or not is_border.any():
        raise ValueError("is_border: one kind of edge only, expected both")
    auc = float(roc_auc_score(is_border, values, sample_weight=weights))
    sign = 1.0 if auc >= 0.5 else -1.0
    false_positive, true_positive, thresholds = roc_curve(
        is_border, sign * values, sample_weight=weights
    )
    best = int(np.argmax(true_positive - false_positive))
    return FeatureQuality(
        max(auc, 1.0 - auc),
        float(true_positive[best] - false_positive[best]),
        sign > 0,
        float(sign * thresholds[best]),
        false_positive,
        true_positive,
    )


@dataclass(frozen=True)
class LengthStatistics:
    """Table 1, and the class ratio of §2.3.2 (within-room edges per border edge)."""

    short: float
    border: float
    border_given_short: float
    border_given_long: float
    class_ratio: float


def length_statistics(
    length: Floats, is_border: Flags, short_length: float = 0.20
) -> LengthStatistics:
    """Probabilities of Table 1; an edge is short if l < 0.2 m. Both arrays: shape (e',)."""
    short = length < short_length
    return LengthStatistics(
        _fraction(short),
        _fraction(is_border),
        _fraction(is_border[short]),
        _fraction(is_border[~short]),
        float(np.count_nonzero(~is_border) / max(1, np.count_nonzero(is_border))),
    )


@dataclass(frozen=True)
class WidthStatistics:
    """Figures of §2.2.2: edges without L, largest L (m), P(border | L < 0.5 m)."""

    missing: float
    largest: float
    border_given_narrow: float


def width_statistics(
    width: Floats, is_border: Flags, default: float = 5.0, narrow: float = 0.5
) -> WidthStatistics:
    """Figures of §2.2.2 from L (m) of each edge; both arrays have shape (e',)."""
    measured = width[width != default]
    return WidthStatistics(
        _fraction(width == default),
        float(measured.max()) if len(measured) else float("nan"),
        _fraction(is_border[width < narrow]),
    )


def _fraction(flags: Flags) -> float:
    """Share of true flags; nan if there are none."""
    return float(flags.mean()) if len(flags) else float("nan")
