"""Estimating the number of rooms (§2.4.1, Fig. 15, Table 7)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from roomseg.classifier import ClassifierParameters
from roomseg.evaluation import estimate_room_counts
from roomseg.experiments import paper
from roomseg.experiments.cache import Cache
from roomseg.experiments.maps import Maps
from roomseg.experiments.tables import Cell, Drawing, Row, Table
from roomseg.figures import draw_room_counts, new_figure
from roomseg.room_count import room_count_quality

__all__ = ["RoomCounts", "room_counts"]

Ints = tuple[int, ...]


@dataclass(frozen=True)
class RoomCounts:
    """True and estimated room count of each map, and what Fig. 15 shows."""

    environment: tuple[str, ...]
    nodes: Ints
    rooms: Ints
    by_nodes: Ints
    by_gap: Ints

    @property
    def table(self) -> Table:
        """Table 7; errors may be smaller than the paper's, hits more frequent."""
        rows = []
        for name, estimated in zip(paper.ROOM_COUNT, (self.by_nodes, self.by_gap), strict=True):
            quality = room_count_quality(estimated, self.rooms)
            error, exact, within = paper.ROOM_COUNT[name]
            cells = (
                Cell(quality.mean_absolute_error, error, (-np.inf, error)),
                Cell(quality.exact, exact, (exact, np.inf)),
                Cell(quality.within_one, within, (within, np.inf)),
            )
            rows.append(Row(name, cells))
        return Table(
            "table7",
            "Table 7: room count estimates",
            ("method", "mean |e|", "share with e = 0", "share with |e| ≤ 1"),
            tuple(rows),
        )

    @property
    def remarks(self) -> tuple[str, ...]:
        """Where the estimates go wrong."""
        remarks = []
        for name, estimated in zip(paper.ROOM_COUNT, (self.by_nodes, self.by_gap), strict=True):
            error = np.subtract(estimated, self.rooms)
            names = np.array(self.environment)
            bad = sorted(set(names[np.abs(error) > 1].tolist()))
            where = (
                f"off by more than one in {', '.join(bad)}" if bad else "never off by more than one"
            )
            remarks.append(
                f"{name}: {int((error > 0).sum())} maps with too many rooms, "
                f"{int((error < 0).sum())} with too few; {where}."
            )
        return tuple(remarks)

    def draw(self) -> Figure:
        """Fig. 15."""
        figure = new_figure(5.4, 3.4)
        draw_room_counts(figure.subplots(), self.environment, self.nodes, self.rooms)
        return figure

    @property
    def drawing(self) -> Drawing:
        """Fig. 15."""
        return Drawing(
            "fig15",
            "Fig. 15: nodes and rooms",
            "One mark for each map; a colour and sign for each environment.",
            self.draw,
        )


def room_counts(maps: Maps, parameters: ClassifierParameters, cache: Cache) -> RoomCounts:
    """Estimate the room count of each reference map, leaving its environment out."""

    def estimate() -> dict[str, NDArray[np.int64]]:
        by_nodes, by_gap = estimate_room_counts(maps.reference, parameters)
        return {"nodes": by_nodes, "gap": by_gap}

    found = cache.get("room-counts", ("room counts", maps.identity, parameters), estimate)
    return RoomCounts(
        tuple(item.environment for item in maps.reference),
        tuple(item.features.graph.node_count for item in maps.reference),
        tuple(item.room_count for item in maps.reference),
        tuple(found["nodes"].tolist()),
        tuple(found["gap"].tolist()),
    )
