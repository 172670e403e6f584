"""Which of Table 2's passageway parameters tells border edges best (§2.2.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from roomseg.experiments import paper
from roomseg.experiments.tables import Cell, Drawing, Row, Table
from roomseg.feature_set import MapFeatures
from roomseg.figures import draw_lines, new_figure
from roomseg.metrics import feature_quality
from roomseg.passageway import TABLE_2, LintelParameters

__all__ = ["PassagewayParameters", "passageway_parameters"]


@dataclass(frozen=True)
class PassagewayParameters:
    """Area under the ROC curve of each combination of `TABLE_2`, shape (42,)."""

    area: NDArray[np.float64]

    @property
    def best(self) -> int:
        """The combination that is used throughout the rest."""
        return int(np.argmax(self.area))

    @property
    def best_said(self) -> str:
        """In words."""
        chosen = TABLE_2[self.best]
        return (
            f"I_min = {chosen.min_intensity:g}, (N_θ, N_s) = ({chosen.orientation_bins}, "
            f"{chosen.offset_bins}), ε = {np.degrees(chosen.tolerance):.0f}°"
        )

    @property
    def table(self) -> Table:
        """All combinations; the paper tells the area of the best only (Table 3)."""
        theirs, accepted, _ = paper.SINGLE_FEATURES["passageway"]
        columns = _tolerances()
        rows = [Row(_name(key), tuple(Cell(self._of(key, d), digits=3) for d in columns))
                for key in _histograms()]  # fmt: skip
        best = (Cell(float(self.area.max()), theirs, accepted, digits=3),)
        empty = (Cell(None),) * (len(columns) - 1)
        rows.append(Row(f"best: {self.best_said}", best + empty))
        return Table(
            "table2",
            "Table 2: area under the ROC curve of the passageway parameters",
            ("I_min, N_θ × N_s", *(f"ε = {degrees}°" for degrees in columns)),
            tuple(rows),
            f"Chosen here: {self.best_said}. The paper prints its choice in bold, which is lost in "
            "the text that we have; its area is that of Table 3.",
            said=False,
        )

    def _of(self, key: tuple[float, int, int], degrees: int) -> float:
        at = [
            index
            for index, parameters in enumerate(TABLE_2)
            if parameters.histogram == key and _degrees(parameters) == degrees
        ]
        return float(self.area[at[0]])

    def draw(self) -> Figure:
        """Area over ε, one line for each histogram."""
        figure = new_figure(5.6, 3.6)
        lines = {_name(key): [self._of(key, d) for d in _tolerances()] for key in _histograms()}
        ax = figure.subplots()
        draw_lines(ax, _tolerances(), lines, ("ε, degrees", "area under the ROC curve"))
        return figure

    @property
    def drawing(self) -> Drawing:
        """All combinations at a glance."""
        return Drawing(
            "table2",
            "Passageway parameters",
            "Area under the ROC curve over ε, for each I_min and histogram (N_θ × N_s bins).",
            self.draw,
        )


def _degrees(parameters: LintelParameters) -> int:
    return round(float(np.degrees(parameters.tolerance)))


def _tolerances() -> list[int]:
    return list(dict.fromkeys(map(_degrees, TABLE_2)))


def _histograms() -> list[tuple[float, int, int]]:
    return list(dict.fromkeys(parameters.histogram for parameters in TABLE_2))


def _name(key: tuple[float, int, int]) -> str:
    return f"{key[0]:g}, {key[1]} × {key[2]}"


def passageway_parameters(maps: Sequence[MapFeatures]) -> PassagewayParameters:
    """Judge all combinations by the edges of all maps together."""
    is_border = np.concatenate([item.labelled.is_border for item in maps])
    values = np.concatenate([item.passageway for item in maps], axis=1)
    area = [feature_quality(row.astype(np.float64), is_border).auc for row in values]
    return PassagewayParameters(np.array(area))
