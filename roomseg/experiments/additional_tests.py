"""New runs in known places, and a place that is unlike all others (§3.4, Figs. 28 and 29)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from roomseg.experiments import paper
from roomseg.experiments.maps import ADDITIONAL_PLACE
from roomseg.experiments.room_figures import Judged, Plans, errors_said, room_drawing
from roomseg.experiments.segmentations import Segmentations
from roomseg.experiments.tables import Cell, Drawing, Row, Table
from roomseg.figures import draw_floor, new_figure

__all__ = ["AdditionalTests"]


@dataclass(frozen=True)
class AdditionalTests:
    """The new runs, the runs in the additional place, and the known runs to compare with."""

    new: tuple[Judged, ...]
    novel: tuple[Judged, ...]
    known: Segmentations

    @property
    def tables(self) -> tuple[Table, ...]:
        """One for each part that there are maps for."""
        return tuple(
            table
            for table, maps in ((self._new_runs(), self.new), (self._novel(), self.novel))
            if maps
        )

    def _new_runs(self) -> Table:
        rows = []
        for judged in self.new:
            name = judged.item.environment
            before = [other.impurity for other in self.known.of(name)]
            wrong = paper.WRONG_BORDERS_IN_NEW_RUNS.get(name)
            cells = (
                Cell(judged.impurity),
                Cell(float(np.mean(before)) if before else None),
                Cell(judged.errors.missed, wrong, digits=0),
                Cell(judged.errors.false, digits=0),
            )
            rows.append(Row(judged.item.name, cells))
        columns = ("map", "v × 100", "earlier runs, mean", "borders missed", "made up")
        return Table(
            "new-runs", "§3.4: new runs in known places", columns, tuple(rows),
            "The places were left out of training, as before.",
        )  # fmt: skip

    def _novel(self) -> Table:
        rows = [
            Row(
                judged.item.name,
                (
                    Cell(judged.impurity),
                    Cell(judged.uniform_impurity),
                    Cell(judged.errors.missed, digits=0),
                    Cell(judged.errors.false, digits=0),
                ),
            )
            for judged in self.novel
        ]
        right, of = paper.NOVEL_MAPS_RIGHT
        ours = sum(judged.errors.missed == 0 for judged in self.novel)
        accepted = (float(right), float("inf")) if len(self.novel) == of else None
        count = (Cell(None), Cell(None), Cell(ours, right, accepted, digits=0), Cell(None))
        rows.append(Row("maps without a missed border", count))
        columns = ("map", "v × 100", "uniform", "borders missed", "made up")
        return Table("novel", "§3.4: a place unlike the others", columns, tuple(rows))

    @property
    def remarks(self) -> tuple[str, ...]:
        """What went wrong where."""
        remarks = [
            f"{judged.item.name}: {errors_said(judged.errors)}."
            for judged in (*self.new, *self.novel)
            if not judged.right
        ]
        return tuple(remarks)

    def drawings(self, plans: Plans) -> tuple[Drawing, ...]:
        """Fig. 28, the floor, and Fig. 29, the worst map of the additional place."""
        if not self.novel:
            return ()
        drawings = []
        plan = plans.get(ADDITIONAL_PLACE)
        if plan is not None:

            def draw() -> Figure:
                figure = new_figure(5.6, 4.6)
                draw_floor(figure.subplots(), plan.floor, plan.outlines)
                return figure

            drawings.append(
                Drawing(
                    "fig28",
                    "Fig. 28: the additional place",
                    "The unoccupied floor: a wide passage without a lintel, small rooms side by "
                    "side, furniture that divides large rooms.",
                    draw,
                )
            )
        worst = max(self.novel, key=lambda judged: judged.impurity)
        return (*drawings, room_drawing("fig29", "Fig. 29", worst, plans))
