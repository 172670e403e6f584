"""How much our maps resemble the paper's: Table 1, the figures of §2.2.2, and Table 3.

All maps count together, as in the paper. Beside the paper's value stands the
range within which we call a simulated world faithful. A feature that is far
*better* than the paper's fails too: then the world is too clean.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from roomseg.figures import RocCurve
from roomseg.labelled_map import LabelledMap
from roomseg.metrics import FeatureQuality, feature_quality, length_statistics, width_statistics
from roomseg.report.contents import Comparison, Measure

__all__ = ["edge_statistics", "feature_statistics", "roc_curves"]

# name in the paper: (area under the curve, its tolerance, Youden's J)
_TABLE_3 = {
    "length": (0.71, 0.06, 0.35),
    "passageway_width": (0.78, 0.08, 0.56),
    "passageway": (0.87, 0.07, 0.61),
    "d_c": (0.77, 0.08, 0.40),
    "d_s": (0.66, 0.08, 0.29),
}

_TITLES = {
    "length": "Edge length",
    "passageway_width": "Obstacle data (passageway width L)",
    "passageway": "Passageway detection",
    "d_c": "Image distance d_c",
    "d_s": "Image distance d_s",
}


def edge_statistics(maps: Sequence[LabelledMap]) -> Comparison:
    """Table 1, the class ratio of §2.3.2, and the figures of L in §2.2.2.

    Parameters
    ----------
    maps : sequence of LabelledMap
        With the features ``length`` and ``passageway_width``.

    Returns
    -------
    Comparison
    """
    is_border = np.concatenate([item.is_border for item in maps])
    length = length_statistics(_pooled(maps, "length"), is_border)
    width = width_statistics(_pooled(maps, "passageway_width"), is_border)
    return Comparison(
        "Edges of the map graph (Table 1, §2.2.2, §2.3.2)",
        (
            Measure("P(short), l < 0.2 m", length.short, 0.498, (0.45, 0.55)),
            Measure("P(border)", length.border, 0.026, (0.020, 0.033)),
            Measure("P(border | short)", length.border_given_short, 0.008, (0.004, 0.014)),
            Measure("P(border | long)", length.border_given_long, 0.043, (0.033, 0.055)),
            Measure("within-room edges per border edge", length.class_ratio, 38, (30, 50), 1),
            Measure("share of edges without L", width.missing, 0.47, (0.37, 0.57)),
            Measure("largest L, m", width.largest, 4.4, (3.5, 5.0), 2),
            Measure("P(border | L < 0.5 m)", width.border_given_narrow, 0.005, (0.0, 0.015)),
        ),
        note="The accepted ranges are for whole homes; a tiny flat has more door per floor.",
    )


def feature_statistics(
    maps: Sequence[LabelledMap], weights: NDArray[np.float64] | None = None
) -> Comparison:
    """Table 3: area under the ROC curve and Youden's J of every single feature.

    Parameters
    ----------
    maps : sequence of LabelledMap
    weights : array, optional
        How many edges each edge of all maps, one after the other, stands for.

    Returns
    -------
    Comparison
    """
    measures = []
    for name, quality in _qualities(maps, weights).items():
        paper_auc, tolerance, paper_youden = _TABLE_3[name]
        accepted = (paper_auc - tolerance, paper_auc + tolerance)
        measures += [
            Measure(f"{_TITLES[name]}: area under curve", quality.auc, paper_auc, accepted),
            Measure(f"{_TITLES[name]}: Youden's J", quality.youden, paper_youden),
        ]
    return Comparison("Single edge features (Table 3)", tuple(measures))


def roc_curves(maps: Sequence[LabelledMap]) -> tuple[RocCurve, ...]:
    """Fig. 11: one curve for every feature that the maps have."""
    return tuple(
        RocCurve(_TITLES[name], quality.false_positive, quality.true_positive, quality.auc)
        for name, quality in _qualities(maps).items()
    )


def _qualities(
    maps: Sequence[LabelledMap], weights: NDArray[np.float64] | None = None
) -> dict[str, FeatureQuality]:
    is_border = np.concatenate([item.is_border for item in maps])
    names = maps[0].features.names
    return {name: feature_quality(_pooled(maps, name), is_border, weights) for name in names}


def _pooled(maps: Sequence[LabelledMap], name: str) -> NDArray[np.float64]:
    return np.concatenate([item.features.column(name) for item in maps])
