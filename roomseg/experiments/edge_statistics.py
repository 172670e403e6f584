"""How many edges are short, how many are borders, and how wide passageways are (Table 1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from roomseg.experiments import paper
from roomseg.experiments.tables import Cell, Drawing, Row, Table
from roomseg.figures import draw_border_share, new_figure
from roomseg.labelled_map import LabelledMap
from roomseg.metrics import (
    LengthStatistics,
    WidthStatistics,
    length_statistics,
    width_statistics,
)

__all__ = ["EdgeStatistics", "edge_statistics", "environments_table", "pooled"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class EdgeStatistics:
    """Table 1, the class ratio of §2.3.2 and the figures of L in §2.2.2, all edges together."""

    lengths: LengthStatistics
    widths: WidthStatistics
    length: Floats
    width: Floats
    is_border: Flags

    @property
    def table(self) -> Table:
        """Ours and the paper's."""
        length, width = self.lengths, self.widths
        ours = {
            "P(short)": length.short,
            "P(border)": length.border,
            "P(border | short)": length.border_given_short,
            "P(border | long)": length.border_given_long,
        }
        rows = [Row(name, (Cell(ours[name], *paper.TABLE_1[name], digits=3),)) for name in ours]
        rows.append(
            Row(
                "within-room edges per border edge",
                (Cell(length.class_ratio, *paper.CLASS_RATIO, digits=1),),
            )
        )
        for label, key, value, digits in (
            ("share of edges without L", "missing", width.missing, 3),
            ("largest L, m", "largest", width.largest, 2),
            ("P(border | L < 0.5 m)", "border_given_narrow", width.border_given_narrow, 3),
        ):
            rows.append(Row(label, (Cell(value, *paper.WIDTH[key], digits=digits),)))
        return Table(
            "table1",
            "Table 1, §2.2.2 and §2.3.2: edges of the map graphs",
            ("statistic", "value"),
            tuple(rows),
            "Short: l < 0.2 m. The accepted ranges are for whole homes; "
            "a tiny flat has more door per floor.",
        )

    def draw(self) -> Figure:
        """Border share by edge length and by passageway width."""
        figure = new_figure(8.0, 3.2)
        left, right = figure.subplots(1, 2)
        bins = np.linspace(0.05, max(0.45, float(self.length.max())), 17)
        draw_border_share(
            left, self.length, self.is_border, bins, name="edge length l, m", mark=0.2
        )
        measured = self.width < 5.0
        bins = np.arange(0.0, 4.76, 0.25)
        width, border = self.width[measured], self.is_border[measured]
        draw_border_share(right, width, border, bins, name="passageway width L, m", mark=0.5)
        return figure

    @property
    def drawing(self) -> Drawing:
        """Where borders are."""
        return Drawing(
            "edges",
            "Where the border edges are",
            "How many edges there are of each length and passageway width (grey, edges without L "
            "left out), and what share of them crosses a room border (orange). Dotted: 0.2 m, "
            "where long edges begin, and 0.5 m, below which a passage is hardly ever a border.",
            self.draw,
        )


def edge_statistics(maps: Sequence[LabelledMap]) -> EdgeStatistics:
    """Count the edges of all maps together."""
    length, width = pooled(maps, "length"), pooled(maps, "passageway_width")
    is_border = np.concatenate([item.is_border for item in maps])
    return EdgeStatistics(
        length_statistics(length, is_border),
        width_statistics(width, is_border),
        length,
        width,
        is_border,
    )


def pooled(maps: Sequence[LabelledMap], name: str) -> Floats:
    """One feature of the edges of all maps."""
    return np.concatenate([item.features.column(name) for item in maps])


def environments_table(maps: Sequence[LabelledMap]) -> Table:
    """Table 8 as far as maps tell it: how many, mean nodes, rooms."""
    rows = []
    for name in dict.fromkeys(item.environment for item in maps):
        of_place = [item for item in maps if item.environment == name]
        count, nodes, rooms = paper.ENVIRONMENTS.get(name, (None, None, None))
        mean = float(np.mean([item.features.graph.node_count for item in of_place]))
        accepted = None if nodes is None else (0.75 * nodes, 1.25 * nodes)
        cells = (
            Cell(len(of_place), count, digits=0),
            Cell(mean, nodes, accepted, digits=0),
            Cell(of_place[0].room_count, rooms, digits=0),
        )
        rows.append(Row(name, cells))
    return Table(
        "table8",
        "Table 8: the environments",
        ("environment", "maps", "map nodes", "rooms"),
        tuple(rows),
        "real1 to real3 are stand-ins of like size, rooms, contrast and light: "
        "nobody can simulate the paper's own.",
    )
