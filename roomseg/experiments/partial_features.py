"""What each kind of feature is worth (§3.3, Tables 9 and 10, Figs. 26 and 27)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf

from matplotlib.figure import Figure

from roomseg.experiments import paper
from roomseg.experiments.grids import Grid
from roomseg.experiments.parameter_selection import parameter_cells, spaces_table
from roomseg.experiments.room_figures import Judged, Plans, room_drawing
from roomseg.experiments.searches import Search
from roomseg.experiments.tables import Cell, Drawing, Row, Table
from roomseg.figures import draw_impurity_bars, new_figure

__all__ = ["PartialFeatures"]


@dataclass(frozen=True)
class PartialFeatures:
    """A search for each subset of the features, and the segmentations of the best of all.

    ``searches`` and ``grids`` have the names of Table 10, ``default`` among them.
    """

    grids: Mapping[str, Grid]
    searches: Mapping[str, Search]
    maps: tuple[Judged, ...]

    @property
    def impurity(self) -> dict[str, tuple[float, float]]:
        """Mean and median impurity × 100 of each variant, in the order of Table 10."""
        found = {}
        uniform = [judged.uniform_impurity for judged in self.maps]
        for name in paper.VARIANTS:
            if name == "uniform":
                found[name] = _mean_median(uniform)
            elif name in self.searches:
                search = self.searches[name]
                index = int(search.order[0])
                found[name] = 100.0 * float(search.mean[index]), 100.0 * float(search.median[index])
        return found

    @property
    def tables(self) -> tuple[Table, ...]:
        """Tables 9 and 10."""
        rows = []
        for name, (mean, median) in self.impurity.items():
            theirs = paper.VARIANTS[name]
            search = self.searches.get(name)
            chosen = None if search is None else search.best
            accepted: tuple[tuple[float, float] | None, ...] = (None, None)
            if name == "default":
                accepted = tuple(band for _, band in paper.IMPURITY)
            elif name not in ("uniform", "no-camera"):
                accepted = (-inf, theirs[4]), (-inf, theirs[5])
            cells = (Cell(mean, theirs[4], accepted[0]), Cell(median, theirs[5], accepted[1]))
            rows.append(Row(name, (*parameter_cells(chosen, theirs[:4]), *cells)))
        columns = ("variant", "log₂ C", "log₂ γ", "w", "ρ", "mean v × 100", "median v × 100")
        ranking = Table(
            "table10",
            "Table 10: partial edge features, each with the best of its own search",
            columns,
            tuple(rows),
        )
        title = "Table 9: search spaces for partial edge features"
        return spaces_table("table9", title, self.grids), ranking

    @property
    def remarks(self) -> tuple[str, ...]:
        """Whether the order of the paper holds."""
        mean = {name: values[0] for name, values in self.impurity.items()}
        rest = [mean[name] for name in mean if name not in ("uniform", "no-camera")]
        remarks = []
        for name in ("uniform", "no-camera"):
            if name in mean and rest:
                worse = mean[name] > max(rest)
                remarks.append(
                    f"{name} is {'worse' if worse else 'not worse'} than every variant with "
                    f"camera features ({mean[name]:.2f}, the others at most {max(rest):.2f}), "
                    f"{'as' if worse else 'unlike'} in the paper."
                )
        base = mean["default"]
        for name in ("no-pano", "no-ceiling", "no-obst"):
            if name in mean:
                change = mean[name] - base
                theirs = paper.VARIANTS[name][4] - paper.VARIANTS["default"][4]
                remarks.append(
                    f"{name}: {_signed(change)} against all features, in the paper "
                    f"{_signed(theirs)}."
                )
        return tuple(remarks)

    def draw(self) -> Figure:
        """Fig. 26."""
        figure = new_figure(6.0, 3.4)
        ours = {name: values[0] for name, values in self.impurity.items()}
        theirs = {name: row[4] for name, row in paper.VARIANTS.items()}
        draw_impurity_bars(figure.subplots(), ours, theirs)
        return figure

    def drawings(self, plans: Plans) -> tuple[Drawing, ...]:
        """Figs. 26 and 27; the latter is the map to which the classifier matters most."""
        most = max(self.maps, key=lambda judged: judged.uniform_impurity - judged.impurity)
        bars = Drawing(
            "fig26",
            "Fig. 26: what each kind of feature is worth",
            "Mean impurity with all features, without a classifier, and with some features left "
            "out, each with parameters of its own search.",
            self.draw,
        )
        return bars, room_drawing("fig27", "Fig. 27", most, plans, beside="uniform")


def _mean_median(values: list[float]) -> tuple[float, float]:
    ordered = sorted(values)
    middle = len(ordered) // 2
    median = ordered[middle] if len(ordered) % 2 else (ordered[middle - 1] + ordered[middle]) / 2
    return sum(values) / len(values), median


def _signed(value: float) -> str:
    return f"{value:+.2f}".replace("-", "−")
