"""One look for every figure: colours, floor-plan axes, the checkered scale bar.

The paper draws obstacles blue, graph edges and lanes red, border edges green
and dashed. The hues here are those of Okabe and Ito and, for rooms, Tol's
muted set, which people with the common colour blindnesses can tell apart;
what matters most is coded twice (dashes, numbers, rings), never by hue alone.

Only the object-oriented interface of Matplotlib is used: a `Figure` is made,
drawn into and written, and no list of open figures exists anywhere.
"""

from __future__ import annotations

import colorsys
import io
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

__all__ = [
    "BORDER_BLACK",
    "BORDER_EDGE_GREEN",
    "EDGE_RED",
    "FLOOR_GREY",
    "OBSTACLE_BLUE",
    "TRAVEL_GREY",
    "figure_bytes",
    "finish_plan",
    "new_figure",
    "png_bytes",
    "room_colours",
    "scale_bar",
    "scale_bar_length",
]

OBSTACLE_BLUE = "#0072B2"
EDGE_RED = "#D5481E"
BORDER_EDGE_GREEN = "#008F68"
BORDER_BLACK = "#111111"
TRAVEL_GREY = "#9A9A9A"
FLOOR_GREY = "#D9DEE3"
INK = "#222222"

CIRCLE = 0.08
"""Radius of the largest circle that stands for a node or a lane's end, m, and a bit."""

_ROOM_HUES = (
    "#332288",
    "#DDCC77",
    "#117733",
    "#88CCEE",
    "#CC6677",
    "#44AA99",
    "#882255",
    "#999933",
    "#AA4499",
)


def room_colours(count: int) -> NDArray[np.float64]:
    """RGB colours of ``count`` rooms, shape (count, 3), in [0, 1].

    The nine muted colours first; further rounds are lighter, so that no two of
    the first 27 rooms are the same.
    """
    colours = []
    for index in range(count):
        turn, hue = divmod(index, len(_ROOM_HUES))
        h, lightness, saturation = colorsys.rgb_to_hls(*to_rgb(_ROOM_HUES[hue]))
        lighter = 1.0 - (1.0 - lightness) * 0.62 ** (turn % 3)
        colours.append(colorsys.hls_to_rgb(h, lighter, saturation))
    return np.array(colours, dtype=float).reshape(count, 3)


def new_figure(width: float = 6.0, height: float = 4.5) -> Figure:
    """Make an empty white figure of that size, inches, with tight automatic layout."""
    figure = Figure(figsize=(width, height), layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def figure_bytes(figure: Figure, suffix: str, dpi: int = 160) -> bytes:
    """Write the figure as a file; the same figure gives the same bytes (no date inside).

    Parameters
    ----------
    figure : Figure
    suffix : {'.png', '.svg', '.pdf'}
    dpi : int
        Pixels per inch of what is made of pixels.
    """
    undated: dict[str, dict[str, None]] = {
        ".png": {"Software": None},
        ".svg": {"Date": None},
        ".pdf": {"CreationDate": None},
    }
    buffer = io.BytesIO()
    # Without a salt the names inside an SVG are drawn anew each time.
    with rc_context({"svg.hashsalt": "roomseg"}):
        figure.savefig(
            buffer,
            format=suffix.removeprefix("."),
            dpi=dpi,
            bbox_inches="tight",
            pad_inches=0.04,
            metadata=undated[suffix],
        )
    return buffer.getvalue()


def png_bytes(figure: Figure, dpi: int = 160) -> bytes:
    """Write the figure as PNG; see `figure_bytes`."""
    return figure_bytes(figure, ".png", dpi)


def scale_bar_length(extent: float) -> float:
    """5 m as in Figs. 16 and 17, but 1 m where the plan is narrower than 7 m."""
    return 5.0 if extent >= 7.0 else 1.0


def scale_bar(ax: Any, corner: tuple[float, float], length: float, height: float) -> None:
    """Draw a checkered bar of ``length`` m, two rows high, with its lower left at ``corner``."""
    cell = length / 5.0
    for row in range(2):
        for column in range(5):
            dark = (row + column) % 2 == 0
            ax.add_patch(
                Rectangle(
                    (corner[0] + column * cell, corner[1] + row * height),
                    cell,
                    height,
                    facecolor=INK if dark else "white",
                    edgecolor=INK,
                    linewidth=0.5,
                    gid="scale-bar",
                )
            )
    ax.text(
        corner[0] + 1.04 * length,
        corner[1] + height,
        f"{length:g} m",
        va="center",
        ha="left",
        fontsize=8,
        color=INK,
    )


def finish_plan(ax: Any, title: str | None = None, bar: float | None = None) -> None:
    """Make the axes a floor plan: equal aspect, no frame, scale bar below the drawing.

    Call it after everything is drawn, since the bar goes below what is there.

    Parameters
    ----------
    bar : float, optional
        Length of the scale bar, m; chosen from the extent if absent.
    """
    ax.set_aspect("equal")
    ax.set_axis_off()
    box = ax.dataLim
    if np.isfinite(box.get_points()).all():
        extent = max(box.width, box.height, 0.5)
        length = scale_bar_length(box.width) if bar is None else bar
        # What is drawn as a circle counts by its middle only; of a tiny plan it shows.
        margin = max(0.02 * extent, CIRCLE)
        height = 0.01 * extent
        bottom = box.y0 - 2.0 * margin - 2.0 * height
        left, top = box.x0, box.y1
        right = max(box.x1, left + 1.04 * length)
        scale_bar(ax, (left, bottom), length, height)
        ax.set_xlim(left - margin, right + margin)
        ax.set_ylim(bottom - margin, top + margin)
    if title:
        ax.set_title(title, fontsize=9.5, color=INK)
