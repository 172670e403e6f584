"""Figures of segmentations beside the truth (Figs. 22 to 25, 27 and 29)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from roomseg.evaluation import MapResult
from roomseg.experiments.tables import Drawing
from roomseg.figures import add_map_legend, draw_rooms, new_figure
from roomseg.figures.plans import node_positions, plan_rings
from roomseg.labelled_map import LabelledMap
from roomseg.metrics import BorderErrors, border_errors

__all__ = ["FloorPlan", "Judged", "Plans", "errors_said", "room_drawing"]

NEARLY_IDENTICAL = 5.0
"""Largest impurity × 100 of a map that we call nearly identical to the ground truth."""
STAND_IN = "real"
"""Environments whose names begin so stand for real ones, and are drawn as those (Fig. 25)."""
Panel = tuple[str, NDArray[np.int32]]


@dataclass(frozen=True)
class FloorPlan:
    """Outlines of the obstacles and the floor of an apartment, shapely geometries, m."""

    outlines: Any
    floor: Any


Plans = Mapping[str, FloorPlan]
"""By environment; those of real robots have none."""


@dataclass(frozen=True)
class Judged:
    """A map and what came out for it."""

    item: LabelledMap
    result: MapResult

    @property
    def impurity(self) -> float:
        """Impurity × 100 with the classifier."""
        return 100.0 * self.result.quality.impurity

    @property
    def uniform_impurity(self) -> float:
        """Impurity × 100 with uniform weights."""
        return 100.0 * self.result.uniform_quality.impurity

    @property
    def errors(self) -> BorderErrors:
        """Room borders missed and made up with the classifier."""
        graph = self.item.features.graph
        return border_errors(self.result.labels, self.item.room, graph.edges)

    @property
    def right(self) -> bool:
        """Nearly identical to the ground truth: all borders, no others, few nodes astray."""
        return self.errors == BorderErrors(0, 0) and self.impurity <= NEARLY_IDENTICAL


def errors_said(errors: BorderErrors) -> str:
    """In words."""
    parts = [
        f"{count} border{'s' if count > 1 else ''} {kind}"
        for count, kind in ((errors.missed, "missed"), (errors.false, "made up"))
        if count
    ]
    return " and ".join(parts) if parts else "every room border is where it should be"


def room_drawing(
    name: str, number: str, judged: Judged, plans: Plans, *, beside: str = "truth"
) -> Drawing:
    """Two panels: the truth and the result, or the result and that of uniform weights.

    Parameters
    ----------
    name : str
        Of the files.
    number : str
        Such as ``Fig. 22``.
    judged : Judged
    plans : mapping
    beside : {'truth', 'uniform'}
    """
    item, result = judged.item, judged.result
    found = (f"method, impurity {judged.impurity:.2f} %", result.labels)
    if beside == "truth":
        panels = [("ground truth", item.room), found]
        said = f"{errors_said(judged.errors)[:1].upper()}{errors_said(judged.errors)[1:]}."
    else:
        uniform = f"uniform weights, impurity {judged.uniform_impurity:.2f} %"
        panels = [found, (uniform, result.uniform_labels)]
        said = "With the edge classifier, and without."
    wrong = "Black rings: nodes in a wrong room."
    return Drawing(
        name,
        f"{number}: {item.environment}, {item.run}",
        f"{said} {wrong}",
        partial(_draw, item, panels, plans),
    )


def _draw(item: LabelledMap, panels: Sequence[Panel], plans: Plans) -> Figure:
    sketch = item.sketch
    if sketch is None:
        raise ValueError(f"{item.name}: no sketch, expected one to draw")
    nodes, plan = sketch.nodes, plans.get(item.environment)
    if item.environment.startswith(STAND_IN):
        nodes = replace(nodes, true_pose=None)
    outlines = None if plan is None else plan.outlines
    corners = [node_positions(nodes)]
    if outlines is not None and nodes.true_pose is not None:
        corners += plan_rings(outlines)
    extent = np.ptp(np.vstack(corners), axis=0)
    height = 4.6 * float(np.clip(extent[1] / max(extent[0], 0.1), 0.4, 1.6))
    figure = new_figure(4.6 * len(panels), height + 0.6)
    axes = figure.subplots(1, len(panels), squeeze=False)[0]
    for ax, letter, (title, labels) in zip(axes, "abc", panels, strict=False):
        draw_rooms(
            ax,
            nodes,
            labels,
            truth=item.room,
            points=sketch.obstacles,
            outlines=outlines,
            title=f"({letter}) {title}",
        )
    add_map_legend(figure)
    return figure
