"""The search for C, γ, w and ρ (§2.3.4, Tables 4 to 6, Figs. 13 and 14)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from roomseg.classifier import ClassifierParameters
from roomseg.experiments import paper
from roomseg.experiments.grids import Grid
from roomseg.experiments.searches import Search
from roomseg.experiments.tables import Cell, Drawing, Row, Table
from roomseg.figures import draw_impurity_surface, new_figure

__all__ = ["ParameterSelection", "parameter_cells", "spaces_table"]

PAPER_COUNTS = {
    "full": 1440,
    "fine": 600,
    "extrafine": 495,
    "basic": 480,
    "no-camera": 396,
    "no-ceiling": 780,
}
"""p of Table 4; of Table 9 with the combinations of the basic space that lie inside."""
COLUMNS = ("rank", "log₂ C", "log₂ γ", "w", "ρ", "mean v × 100", "median v × 100")


@dataclass(frozen=True)
class ParameterSelection:
    """The searches, coarse to fine, by their names in Table 4."""

    grids: Mapping[str, Grid]
    searches: Mapping[str, Search]

    @property
    def all(self) -> Search:
        """All searches together."""
        first, *others = self.searches.values()
        for other in others:
            first = first.joined(other)
        return first

    @property
    def best(self) -> ClassifierParameters:
        """(Ĉ, γ̂, ŵ, ρ̂): the best of all searches."""
        return self.all.best

    @property
    def tables(self) -> tuple[Table, ...]:
        """Tables 4, 5 and 6."""
        names = list(self.searches)
        tables = [
            spaces_table("table4", "Table 4: parameter search spaces", self.grids),
            _ranking("table5", f"Table 5: the best of the {names[0]} search",
                     self.searches[names[0]], paper.FULL_SEARCH),
        ]  # fmt: skip
        if len(names) > 1:
            title = f"Table 6: the best of the {names[-1]} search"
            last = self.searches[names[-1]]
            tables.append(_ranking("table6", title, last, paper.FINEST_SEARCH))
        return tuple(tables)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a reader should know about the winner."""
        both = self.all
        remarks = [
            f"Chosen here: {said(self.best)}, mean impurity × 100 of {100 * both.lowest:.2f}. "
            "The same maps chose these parameters, so that this is an optimistic figure, "
            "as in the paper.",
        ]
        theirs = said(ClassifierParameters())
        if ClassifierParameters() in both.combinations:
            at = both.combinations.index(ClassifierParameters())
            better = int((both.mean < both.mean[at]).sum())
            remarks.append(
                f"With the paper's parameters ({theirs}) it is {100 * both.mean[at]:.2f}; "
                f"{better} of {len(both.combinations)} combinations are better."
            )
        share = float((both.mean <= both.lowest + 0.01).mean())
        remarks.append(
            f"{100 * share:.0f} % of all combinations lie within 1 (× 100) of the best: "
            + ("it hardly matters which." if share > 0.2 else "the choice matters.")
        )
        fine = self.grids.get("fine")
        first = next(iter(self.searches.values())).best
        if fine is not None and not _inside(fine, first):
            remarks.append(
                f"The best of the coarse search, {said(first)}, lies outside of Table 4's fine "
                "space, which surrounds the paper's choice."
            )
        return tuple(remarks)

    def draw_full(self) -> Figure:
        """Fig. 13."""
        name = next(iter(self.searches))
        weights = self.grids[name].class_weight[-2:]
        return _surfaces(self.grids, self.searches, [(name, w) for w in weights])

    def draw_fine(self) -> Figure:
        """Fig. 14."""
        names = list(self.searches)[1:]
        return _surfaces(
            self.grids, self.searches, [(name, self.grids[name].class_weight[0]) for name in names]
        )

    @property
    def drawings(self) -> tuple[Drawing, ...]:
        """Figs. 13 and 14."""
        caption = (
            "Mean impurity over C and γ, for the ρ nearest to 60; the ring marks the lowest, "
            "the cross the paper's choice. Values above the scale share the darkest colour."
        )
        full = Drawing("fig13", "Fig. 13: the full search space", caption, self.draw_full)
        if len(self.searches) == 1:
            return (full,)
        fine = Drawing("fig14", "Fig. 14: the finer search spaces", caption, self.draw_fine)
        return full, fine


def said(parameters: ClassifierParameters) -> str:
    """Parameters in words."""
    c, gamma, weight, rho = logs(parameters)
    return f"C = 2^{c:g}, γ = 2^{gamma:g}, w = {weight:g}, ρ = {rho:g}".replace("-", "−")


def logs(parameters: ClassifierParameters) -> tuple[float, float, float, float]:
    """log₂ C, log₂ γ, w, ρ."""
    return (
        float(np.log2(parameters.C)),
        float(np.log2(parameters.gamma)),
        parameters.class_weight,
        parameters.rho,
    )


def parameter_cells(
    ours: ClassifierParameters | None, theirs: Sequence[float | None]
) -> tuple[Cell, ...]:
    """Four cells, of which no difference is a finding by itself."""
    values: Sequence[float | None] = (None,) * 4 if ours is None else logs(ours)
    digits = (1, 1, 0, 1)
    return tuple(
        Cell(mine, paper_, digits=count, expected=True)
        for mine, paper_, count in zip(values, theirs, digits, strict=True)
    )


def spaces_table(name: str, title: str, grids: Mapping[str, Grid]) -> Table:
    """Extent and size of search spaces."""
    rows = []
    for key, grid in grids.items():
        count = len(grid.combinations())
        extent = [
            Cell(limit, digits=1)
            for values in (grid.log2_c, grid.log2_gamma)
            for limit in (values[0], values[-1])
        ]
        counts = (Cell(len(grid.class_weight), digits=0), Cell(len(grid.rho), digits=0))
        rows.append(Row(key, (*extent, *counts, Cell(count, PAPER_COUNTS.get(key), digits=0))))
    columns = ("search", "log₂ C from", "to", "log₂ γ from", "to ", "values of w", "of ρ", "p")
    return Table(name, title, columns, tuple(rows))


def _ranking(name: str, title: str, search: Search, theirs: Sequence[Sequence[float]]) -> Table:
    """The best combinations, each beside the paper's of the same rank."""
    rows = []
    for rank, (index, row) in enumerate(zip(search.order, theirs, strict=False), 1):
        accepted = paper.IMPURITY if rank == 1 else ((0.0, None), (0.0, None))
        impurities = (
            Cell(100.0 * float(search.mean[index]), row[4], accepted[0][1]),
            Cell(100.0 * float(search.median[index]), row[5], accepted[1][1]),
        )
        cells = (*parameter_cells(search.combinations[index], row[:4]), *impurities)
        rows.append(Row(str(rank), cells))
    note = "Each row stands beside the paper's of the same rank, whatever its parameters."
    return Table(name, title, COLUMNS, tuple(rows), note, said=False)


def _inside(grid: Grid, parameters: ClassifierParameters) -> bool:
    c, gamma, weight, _ = logs(parameters)
    return (
        grid.log2_c[0] <= c <= grid.log2_c[-1]
        and grid.log2_gamma[0] <= gamma <= grid.log2_gamma[-1]
        and weight in grid.class_weight
    )


def _surfaces(
    grids: Mapping[str, Grid], searches: Mapping[str, Search], panels: list[tuple[str, float]]
) -> Figure:
    figure = new_figure(4.3 * len(panels), 3.4)
    axes: Any = figure.subplots(1, len(panels), squeeze=False)[0]
    limit = max(0.15, min(0.4, 1.5 * min(search.lowest for search in searches.values())))
    for ax, (name, weight), letter in zip(axes, panels, "abcdef", strict=False):
        grid, search = grids[name], searches[name]
        rho = min(grid.rho, key=lambda value: abs(value - 60.0))
        shape = (len(grid.log2_c), len(grid.log2_gamma), len(grid.class_weight), len(grid.rho))
        cube = search.mean.reshape(shape)
        part = cube[:, :, grid.class_weight.index(weight), grid.rho.index(rho)].T
        title = f"({letter}) {name}: w = {weight:g}, ρ = {rho:g}"
        other = paper.BEST_PARAMETERS[:2]
        axes_values = grid.log2_c, grid.log2_gamma
        draw_impurity_surface(ax, *axes_values, part, limit=limit, other=other, title=title)
    return figure
