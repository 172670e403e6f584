"""The plan of a home as architects draw it, at a true scale.

Rooms with name and area, walls solid, doorways with frame and lintel, windows,
furniture by group, and a legend of what there is. A plan arrives as shapely
geometries and names, so that nothing here knows what an apartment is.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from roomseg.figures.labels import place_label
from roomseg.figures.style import (
    BORDER_EDGE_GREEN,
    INK,
    room_colours,
    scale_bar,
    scale_bar_length,
)

__all__ = [
    "FRAME",
    "GAP",
    "GROUPS",
    "LEAF",
    "SOLID",
    "START",
    "HomePlan",
    "PlanDoor",
    "PlanRoom",
    "PlanWindow",
    "Symbol",
    "draw_home_plan",
    "home_plan_figure",
    "plan_scale",
    "tint",
]

Floats = NDArray[np.float64]

GROUPS = {
    "seating": "#0072B2",
    "tables": "#B5651D",
    "storage": "#8A7A2B",
    "beds": "#882255",
    "kitchen": "#C44E1A",
    "bathroom": "#2A93B8",
    "heating": "#777777",
    "lamps": "#D9A400",
    "decoration": "#2E8B57",
    "fixtures": "#3B4A5A",
    "clutter": "#4D4D4D",
    "other": "#999999",
}
"""Colour of each group of furniture, in the legend's order."""

HUNG = (0, (3, 2))
OVERHEAD = (0, (4, 2))
BORDER: dict[str, Any] = {
    "colors": BORDER_EDGE_GREEN,
    "linewidths": 1.4,
    "linestyles": (0, (5, 1.5, 1, 1.5)),
}
GAP, FRAME, LEAF, SOLID, START = "#F4F1EA", "#B9AE9A", "#8C5A2B", "#777777", "#F0C419"

SCALES = (20, 50, 100, 200, 500, 1000)
INCH = 0.0254
LONGEST = 0.34
"""Longest side of a drawing on paper, m: an A4 sheet's and a bit."""
MARGIN = 0.03
"""Around the plan, in its lengths."""


@dataclass(frozen=True)
class PlanRoom:
    """A room: its name, floor and floor area, m²."""

    name: str
    floor: Any
    area: float


@dataclass(frozen=True)
class PlanDoor:
    """A gap in the wall; ``frame``, ``leaf``, ``threshold`` are shapes, ``None`` if it has none.

    ``opening`` is its footprint, ``faces`` (2, 2, 2), m, the gap's ends on both wall
    faces; ``lintel`` tells whether it has one.
    """

    opening: Any
    faces: Floats
    lintel: bool
    frame: Any = None
    leaf: Any = None
    threshold: Any = None


@dataclass(frozen=True)
class PlanWindow:
    """A window: its footprint and its pane (2, 2), m."""

    opening: Any
    pane: Floats


@dataclass(frozen=True)
class Symbol:
    """A part of a piece of furniture from above, and the piece's group of `GROUPS`.

    ``hung`` ones are above the plan's section and drawn dashed; ``name`` is the piece's.
    """

    group: str
    shape: Any
    hung: bool = False
    name: str = ""


@dataclass(frozen=True)
class HomePlan:
    """All that a plan shows; shapes in m.

    ``walls`` solid walls without openings; ``solids`` what else stands there as part
    of the building, ``overhead`` what hangs from the ceiling; ``symbols`` in the order
    of drawing, the lowest first; ``borders`` (b, 2, 2) room borders without a wall;
    ``lamps`` (l, 3) x, y, radius; ``start`` x, y, heading (rad).
    """

    name: str
    rooms: tuple[PlanRoom, ...]
    walls: Any
    doors: tuple[PlanDoor, ...]
    windows: tuple[PlanWindow, ...]
    solids: tuple[Any, ...]
    overhead: tuple[Any, ...]
    borders: Floats
    symbols: tuple[Symbol, ...]
    lamps: Floats
    start: tuple[float, float, float]


def plan_scale(extent: float) -> int:
    """The n of 1:n at which ``extent`` m fit on a sheet."""
    return next((scale for scale in SCALES if extent / scale <= LONGEST), SCALES[-1])


def home_plan_figure(plan: HomePlan) -> Figure:
    """Draw a plan at a true scale: printed as it is, 1 m measures 1 m / `plan_scale`."""
    shapes = [plan.walls, *(room.floor for room in plan.rooms)]
    x0, y0, x1, y1 = shapely.total_bounds(shapes)
    extent = max(x1 - x0, y1 - y0)
    margin, strip = MARGIN * extent, 0.06 * extent
    scale = plan_scale(extent)
    width, height = x1 - x0 + 2.0 * margin, y1 - y0 + 2.0 * margin + strip
    figure = Figure(
        figsize=(width / scale / INCH, height / scale / INCH),
        facecolor="white",
    )
    FigureCanvasAgg(figure)
    ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    ax.set_axis_off()
    ax.set_xlim(x0 - margin, x1 + margin)
    ax.set_ylim(y0 - margin - strip, y1 + margin)
    draw_home_plan(ax, plan)
    _draw_lamps(ax, plan.lamps)
    _draw_start(ax, plan.start)
    _label_rooms(ax, plan, 1.0 / scale / INCH)
    _draw_scale(ax, (x0, y0 - margin - 0.6 * strip), extent, scale)
    _draw_legend(ax, plan)
    ax.set_title(plan.name, fontsize=11, color=INK)
    return figure


def draw_home_plan(ax: Any, plan: HomePlan) -> None:
    """Draw rooms, furniture and building into axes whose unit is 1 m, without words."""
    _draw_rooms(ax, plan)
    _draw_furniture(ax, plan.symbols)
    _draw_building(ax, plan)


def _area(ax: Any, region: Any, gid: str, **style: Any) -> None:
    """Add a shapely area, holes left out."""
    rings = shapely.get_rings(shapely.get_parts(region))
    if len(rings):
        paths = [Path(shapely.get_coordinates(ring), closed=True) for ring in rings]
        look = {"edgecolor": INK, "linewidth": 0.4, **style}
        ax.add_patch(PathPatch(Path.make_compound_path(*paths), gid=gid, **look))


def _lines(ax: Any, segments: Floats, gid: str, **style: Any) -> None:
    """Add segments (s, 2, 2), if there are any."""
    if len(segments):
        look = {"colors": INK, "linewidths": 0.6, "zorder": 5, **style}
        ax.add_collection(LineCollection(list(segments), gid=gid, **look))


def tint(colour: Any, share: float) -> tuple[float, float, float]:
    """A colour mixed with white; ``share`` of it remains."""
    red, green, blue = 1.0 - share * (1.0 - np.array(to_rgb(colour)))
    return float(red), float(green), float(blue)


def _draw_rooms(ax: Any, plan: HomePlan) -> None:
    for room, colour in zip(plan.rooms, room_colours(len(plan.rooms)), strict=True):
        _area(ax, room.floor, "room", facecolor=tint(colour, 0.16), edgecolor="none")


def _draw_furniture(ax: Any, symbols: Iterable[Symbol]) -> None:
    """Seen from above: what is higher covers what is lower; of hung pieces the outline."""
    for symbol in symbols:
        colour = GROUPS[symbol.group]
        style: dict[str, Any] = {"facecolor": tint(colour, 0.32), "zorder": 2}
        if symbol.hung:
            style = {"facecolor": "none", "linewidth": 0.6, "linestyle": HUNG, "zorder": 3}
        _area(ax, symbol.shape, "furniture", edgecolor=colour, **style)


def _draw_building(ax: Any, plan: HomePlan) -> None:
    """Walls, columns, doors, windows; dashed what is overhead, and borders without a wall."""
    _area(ax, plan.walls, "walls", facecolor=INK, zorder=4)
    for solid in plan.solids:
        _area(ax, solid, "solid", facecolor=SOLID, zorder=4)
    for shape in plan.overhead:
        style = {"facecolor": "none", "linewidth": 0.7, "linestyle": OVERHEAD, "zorder": 5}
        _area(ax, shape, "overhead", **style)
    for door in plan.doors:
        _draw_door(ax, door)
    for window in plan.windows:
        _area(ax, window.opening, "window", facecolor="white", linewidth=0.6, zorder=4)
        _lines(ax, window.pane[None], "pane")
    _lines(ax, plan.borders, "borders", **BORDER)


def _draw_door(ax: Any, door: PlanDoor) -> None:
    """A light gap; threshold and frame; dashed lines for a lintel; the leaf of a closed one."""
    _area(ax, door.opening, "door", facecolor=GAP, edgecolor="none", zorder=4)
    if door.lintel:
        _lines(ax, door.faces, "lintel", linewidths=0.5, linestyles=OVERHEAD)
    if door.threshold is not None:
        _area(ax, door.threshold, "threshold", facecolor=FRAME, edgecolor="none", zorder=4)
    if door.frame is not None:
        _area(ax, door.frame, "door-frame", facecolor=FRAME, zorder=5)
    if door.leaf is not None:
        _area(ax, door.leaf, "door-leaf", facecolor=LEAF, zorder=5)


def _draw_lamps(ax: Any, lamps: Floats) -> None:
    """The sign for a light outlet: a circle with a cross."""
    colour = GROUPS["lamps"]
    for x, y, radius in lamps:
        disc = shapely.Point(x, y).buffer(radius)
        _area(ax, disc, "lamp", facecolor="#FFF6D0", edgecolor=colour, linewidth=0.7, zorder=5)
        a = radius * math.sqrt(0.5)
        cross = [[(x - a, y - a), (x + a, y + a)], [(x - a, y + a), (x + a, y - a)]]
        _lines(ax, np.array(cross), "lamp-cross", colors=colour)


def _draw_start(ax: Any, start: tuple[float, float, float], size: float = 0.16) -> None:
    """The base station, and an arrow where the robot leaves it."""
    x, y, heading = start
    along = np.array([math.cos(heading), math.sin(heading)])
    across = np.array([-along[1], along[0]])

    def shape(*corners: tuple[float, float]) -> Any:
        points = [np.array([x, y]) + size * (a * along + c * across) for a, c in corners]
        return shapely.Polygon(points)

    square = shape((1, 1), (-1, 1), (-1, -1), (1, -1))
    _area(ax, square, "start", facecolor=START, linewidth=0.8, zorder=6)
    _area(ax, shape((2.4, 0), (1.3, 0.7), (1.3, -0.7)), "start-arrow", facecolor=INK, zorder=6)


def _label_rooms(ax: Any, plan: HomePlan, inches: float) -> None:
    """Name and area of each room; ``inches`` is what 1 m measures on paper."""
    pieces = [symbol.shape for symbol in plan.symbols if not symbol.hung]
    signs = [
        shapely.Point(x, y).buffer(size) for x, y, size in (*plan.lamps, (*plan.start[:2], 0.4))
    ]
    taken = shapely.union_all([*pieces, *signs])
    for room in plan.rooms:
        lines = [room.name, f"{room.area:.1f} m²"]
        label = place_label(room.floor, taken, lines, inches)
        ax.text(
            label.x,
            label.y,
            "\n".join(lines),
            fontsize=label.size,
            rotation=label.rotation,
            ha="center",
            va="center",
            color=INK,
            path_effects=[withStroke(linewidth=2.2, foreground="white")],
            gid="room-label",
            zorder=7,
        )


def _draw_scale(ax: Any, corner: tuple[float, float], extent: float, scale: int) -> None:
    """The scale bar, with the scale at which the drawing is its own size."""
    length = scale_bar_length(extent)
    scale_bar(ax, corner, length, 0.01 * extent)
    x, y = corner[0] + 1.04 * length, corner[1] + 0.01 * extent
    ax.annotate(
        f"1:{scale}",
        (x, y),
        xytext=(30, 0),
        textcoords="offset points",
        va="center",
        fontsize=8,
        color=INK,
        gid="scale",
    )


def _draw_legend(ax: Any, plan: HomePlan) -> None:
    """Below the plan: what there is, and nothing else."""
    entries = list(_legend_entries(plan))
    width = ax.figure.get_size_inches()[0]
    left = MARGIN / (1.0 + 2.0 * MARGIN)
    ax.legend(
        handles=entries,
        loc="upper left",
        bbox_to_anchor=(left, 0.0),
        ncol=max(2, min(len(entries), int(width / 1.25))),
        frameon=False,
        fontsize=7.5,
        handlelength=1.6,
        columnspacing=1.2,
        borderaxespad=0.0,
    )


def _legend_entries(plan: HomePlan) -> Iterator[Any]:
    present = {symbol.group for symbol in plan.symbols} | ({"lamps"} if len(plan.lamps) else set())
    for group in [group for group in GROUPS if group in present]:
        yield _box(group, tint(GROUPS[group], 0.32), GROUPS[group])
    border = {"color": BORDER["colors"], "linestyle": BORDER["linestyles"], "linewidth": 1.4}
    lintels = any(door.lintel for door in plan.doors)
    signs = (
        (
            any(symbol.hung for symbol in plan.symbols),
            _line("hung", color="#777777", linestyle=HUNG),
        ),
        (any(door.leaf is None for door in plan.doors), _box("doorway", GAP)),
        (any(door.leaf is not None for door in plan.doors), _box("closed door", LEAF)),
        (bool(plan.windows), _box("window", "white")),
        (bool(plan.solids), _box("column, block", SOLID)),
        (lintels or bool(plan.overhead), _line("overhead", linestyle=OVERHEAD)),
        (len(plan.borders) > 0, _line("room border", **border)),
    )
    yield from (entry for there, entry in signs if there)
    yield _box("base station", START)


def _box(label: str, fill: Any, edge: str = INK) -> Patch:
    return Patch(facecolor=fill, edgecolor=edge, linewidth=0.6, label=label)


def _line(label: str, **style: Any) -> Line2D:
    return Line2D([], [], label=label, **{"color": INK, "linewidth": 0.8, **style})
