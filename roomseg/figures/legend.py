"""One legend for all panels of a map: of what is drawn in them, and nothing else."""

from __future__ import annotations

from typing import Any

from matplotlib.collections import Collection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from roomseg.figures.graphs import WRONG_RING
from roomseg.figures.style import (
    BORDER_BLACK,
    BORDER_EDGE_GREEN,
    EDGE_RED,
    FLOOR_GREY,
    INK,
    OBSTACLE_BLUE,
    TRAVEL_GREY,
)

__all__ = ["add_map_legend"]


def _line(colour: str, width: float = 1.2, **style: Any) -> Line2D:
    return Line2D([], [], color=colour, linewidth=width, **style)


def _mark(marker: str, colour: str, size: float = 6.0, **style: Any) -> Line2D:
    return Line2D([], [], color=colour, marker=marker, markersize=size, linestyle="", **style)


def _signs() -> dict[str, tuple[str, Line2D]]:
    """Text and sign of each kind of artist, by its name in the figure."""
    return {
        "lanes": ("lane", _line(EDGE_RED, marker="o", markersize=4.0, markevery=2)),
        "travels": ("way between lanes", _line(TRAVEL_GREY, 0.8)),
        "base-station": ("base station", _mark("s", "#F0C419", markeredgecolor=INK)),
        "obstacle-outlines": ("obstacles", _line(OBSTACLE_BLUE)),
        "obstacle-points": ("obstacle point", _mark("o", INK, 4.0, markerfacecolor="none")),
        "floor": ("free floor", _mark("s", FLOOR_GREY, 8.0, markeredgecolor=INK)),
        "edges": ("edge", _line(EDGE_RED, 0.8)),
        "border-edges": ("border edge", _line(BORDER_EDGE_GREEN, 1.6, linestyle=(0, (1.6, 0.7)))),
        "borders": ("room border", _line(BORDER_BLACK, 1.6, linestyle=(0, (3, 1)))),
        "edge": ("edge of length l", _line(OBSTACLE_BLUE, 2.0, marker="o")),
        "points": ("obstacle point", _mark("o", INK, 4.0, markerfacecolor="none")),
        "closest": (
            "closest on each side",
            _mark("o", EDGE_RED, markerfacecolor="none", markeredgewidth=1.8),
        ),
        "width": ("passageway width L", _line(EDGE_RED, 1.6)),
        "search-area": ("search area", _line(TRAVEL_GREY, 1.0, linestyle=(0, (4, 3)))),
        "room": ("node in the colour of its room", _mark("o", "#AA4499")),
        "wrong": ("node in a wrong room", _mark("o", "#DDCC77", markeredgecolor="black")),
    }


def add_map_legend(figure: Figure) -> None:
    """Put a legend below the panels of a map's figure."""
    drawn: list[Any] = [
        found for found in figure.findobj() if found.get_gid() and not _is_empty(found)
    ]
    names = {str(found.get_gid()) for found in drawn}
    rooms = [found for found in drawn if str(found.get_gid()).startswith("room-")]
    names |= {"room"} if rooms else set()
    names |= {"wrong"} if any(max(room.get_linewidths()) == WRONG_RING for room in rooms) else set()
    # Points in the robot's map and beside a passage are two kinds of artist with one sign.
    entries = dict(sign for name, sign in _signs().items() if name in names)
    if entries:
        width = figure.get_size_inches()[0]
        figure.legend(
            list(entries.values()),
            list(entries),
            loc="outside lower left",
            ncol=max(1, min(len(entries), int(width / 1.9))),
            frameon=False,
            fontsize=8,
        )


def _is_empty(artist: Any) -> bool:
    return isinstance(artist, Collection) and not len(artist.get_paths())
