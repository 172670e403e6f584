"""How much our maps resemble the paper's: Table 1, the figures of §2.2.2, and Table 3.

All maps count together, as in the paper. Beside the paper's value stands the
range within which we call a simulated world faithful. A feature that is far
*better* than the paper's fails too: then the world is too clean.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from roomseg.experiments import paper
from roomseg.experiments.single_features import TITLES
from roomseg.figures import RocCurve
from roomseg.labelled_map import LabelledMap
from roomseg.metrics import FeatureQuality, feature_quality, length_statistics, width_statistics
from roomseg.report.contents import Comparison, Measure

__all__ = ["edge_statistics", "feature_statistics", "roc_curves"]


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
            Measure("P(short), l < 0.2 m", length.short, *paper.TABLE_1["P(short)"]),
            Measure("P(border)", length.border, *paper.TABLE_1["P(border)"]),
            Measure(
                "P(border | short)",
                length.border_given_short,
                *paper.TABLE_1["P(border | short)"],
            ),
            Measure(
                "P(border | long)", length.border_given_long, *paper.TABLE_1["P(border | long)"]
            ),
            Measure(
                "within-room edges per border edge",
                length.class_ratio,
                *paper.CLASS_RATIO,
                digits=1,
            ),
            Measure("share of edges without L", width.missing, *paper.WIDTH["missing"]),
            Measure("largest L, m", width.largest, *paper.WIDTH["largest"], digits=2),
            Measure(
                "P(border | L < 0.5 m)",
                width.border_given_narrow,
                *paper.WIDTH["border_given_narrow"],
            ),
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
        paper_auc, accepted, paper_youden = paper.SINGLE_FEATURES[name]
        measures += [
            Measure(f"{TITLES[name]}: area under curve", quality.auc, paper_auc, accepted),
            Measure(f"{TITLES[name]}: Youden's J", quality.youden, paper_youden),
        ]
    return Comparison("Single edge features (Table 3)", tuple(measures))


def roc_curves(maps: Sequence[LabelledMap]) -> tuple[RocCurve, ...]:
    """Fig. 11: one curve for every feature that the maps have."""
    return tuple(
        RocCurve(TITLES[name], quality.false_positive, quality.true_positive, quality.auc)
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
