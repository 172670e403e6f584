"""How well a threshold on one feature tells border edges (§2.2.5, Table 3, Fig. 11)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from roomseg.experiments import paper
from roomseg.experiments.edge_statistics import pooled
from roomseg.experiments.tables import Cell, Drawing, Row, Table
from roomseg.features import FEATURES, FROM_IMAGES
from roomseg.figures import RocCurve, draw_roc, new_figure
from roomseg.labelled_map import LabelledMap
from roomseg.metrics import FeatureQuality, feature_quality

__all__ = ["TITLES", "SingleFeatures", "single_features"]

TITLES = {
    "length": "Edge length",
    "passageway_width": "Obstacle data",
    "passageway": "Passageway detection",
    "d_c": "Image distance d_c",
    "d_s": "Image distance d_s",
}


@dataclass(frozen=True)
class SingleFeatures:
    """ROC analysis of each feature, by name."""

    qualities: dict[str, FeatureQuality]

    @property
    def table(self) -> Table:
        """Table 3."""
        rows = []
        for name, quality in self.qualities.items():
            area, accepted, youden = paper.SINGLE_FEATURES[name]
            cells = (Cell(quality.auc, area, accepted), Cell(quality.youden, youden))
            rows.append(Row(TITLES[name], cells))
        return Table(
            "table3",
            "Table 3: single edge features",
            ("feature", "area under curve", "Youden's J"),
            tuple(rows),
        )

    def draw(self) -> Figure:
        """Fig. 11: features without images, and with."""
        figure = new_figure(8.6, 4.4)
        panels = figure.subplots(1, 2)
        for index, (ax, title) in enumerate(
            zip(panels, ("(a) without camera images", "(b) with camera images"), strict=True)
        ):
            curves = [
                RocCurve(TITLES[name], q.false_positive, q.true_positive, q.auc)
                for name, q in self.qualities.items()
                if (name in FROM_IMAGES) == bool(index)
            ]
            draw_roc(ax, curves, title)
        return figure

    @property
    def drawing(self) -> Drawing:
        """Fig. 11."""
        return Drawing(
            "fig11",
            "Fig. 11: ROC curves of the five edge features",
            "Solid: the curve. Dashed in its colour: Youden's J, where the curve is highest above "
            "chance (black, dashed).",
            self.draw,
        )


def single_features(maps: Sequence[LabelledMap]) -> SingleFeatures:
    """Analyse each feature over the edges of all maps together."""
    is_border = np.concatenate([item.is_border for item in maps])
    return SingleFeatures(
        {name: feature_quality(pooled(maps, name), is_border) for name in FEATURES}
    )
