"""The map as the operator sees it, and what is drawn on it (Bokeh).

Everything that does not change while one draws is one glyph, so that a map of
thousands of nodes stays quick to pan and zoom.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.models import (
    ColumnDataSource,
    DataRange1d,
    LinearColorMapper,
    PanTool,
    ResetTool,
    SaveTool,
    WheelZoomTool,
)
from bokeh.plotting import figure
from numpy.typing import NDArray

from dataset.topomap import TopoMap
from roomseg.annotation.cut import Cut, CuttableMap
from roomseg.annotation.drawing import Drawing, Room
from roomseg.annotation.identity import room_of_nodes
from roomseg.browser.labels import draw_names
from roomseg.figures.style import (
    BORDER_BLACK,
    BORDER_EDGE_GREEN,
    INK,
    OBSTACLE_BLUE,
    room_colours,
)

__all__ = ["LAYERS", "MapPlot"]

Floats = NDArray[np.float64]

LAYERS = ("obstacles", "lanes", "kept edges", "all edges")
SHOWN_AT_FIRST = ("obstacles", "kept edges")
SUGGESTION_ORANGE = "#E69F00"
LEAK_RED = "#D7191C"
SELECTED_BLUE = "#1A6BFF"
PALETTE_SIZE = 27
NODE = 0.04
"""m; radius of a node's circle."""
CELL = 0.012
"""m; side of an obstacle point."""
LARGEST_PICTURE = 3000
"""px"""


class MapPlot:
    """The figure and its sources."""

    def __init__(self, canvas: CuttableMap, has_image: NDArray[np.bool_]) -> None:
        self._canvas = canvas
        self.figure: Any = figure(
            sizing_mode="stretch_both",
            min_height=480,
            min_width=480,
            tools=[],
            toolbar_location="above",
            x_axis_label="x (m)",
            y_axis_label="y (m)",
            min_border_left=64,
            match_aspect=True,
            name="map",
        )
        self.pan = PanTool(visible=False)
        zoom = WheelZoomTool(zoom_on_axis=False)
        self.figure.add_tools(self.pan, zoom, ResetTool(), SaveTool())
        self.figure.toolbar.active_scroll = zoom
        self.figure.toolbar.active_drag = None
        self.figure.toolbar.logo = None
        self.figure.grid.grid_line_color = None
        self.figure.background_fill_color = "#FBFBFA"
        self.layers = self._add_layers()
        self._add_nodes(has_image)
        self._add_drawn()
        for span in ("x_range", "y_range"):
            extent = DataRange1d(renderers=[self.node_glyphs], range_padding=0.08)
            setattr(self.figure, span, extent)

    def _add_layers(self) -> dict[str, Any]:
        topomap, position = self._canvas.topomap, self._canvas.position
        plot = self.figure
        layers = {
            "all edges": _lines(plot, position[self._canvas.edges], "#C9C4BE", 0.6),
            "kept edges": _lines(plot, position[self._canvas.graph.edges], "#B9B2A9", 1.0),
            "lanes": _lines(plot, _lane_steps(topomap), "#C0562F", 1.4),
            "obstacles": _picture(plot, topomap.obstacles.position),
        }
        for name, renderer in layers.items():
            renderer.visible = name in SHOWN_AT_FIRST
            renderer.level = "underlay"
        return layers

    def _add_nodes(self, has_image: NDArray[np.bool_]) -> None:
        position = self._canvas.position
        nodes = self._canvas.topomap.nodes
        self.nodes = ColumnDataSource(
            {
                "x": position[:, 0],
                "y": position[:, 1],
                "colour": np.zeros(len(position), np.int32),
                "image": has_image.astype(np.int32),
                "lane": nodes.lane,
                "part": nodes.part,
            },
            name="nodes",
        )
        colours = (room_colours(PALETTE_SIZE) * 255).round().astype(int)
        palette = [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in colours]
        self.palette = tuple(palette)
        mapper = LinearColorMapper(palette=palette, low=-0.5, high=PALETTE_SIZE - 0.5)
        self.node_glyphs = self.figure.circle(
            "x",
            "y",
            source=self.nodes,
            radius=NODE,
            fill_color={"field": "colour", "transform": mapper},
            line_color=None,
        )
        self.chosen = ColumnDataSource({"x": [], "y": []}, name="chosen")
        self.figure.circle(
            "x", "y", source=self.chosen, radius=NODE, fill_color=None, line_color=INK, line_width=2
        )
        # A click selects rooms in the list, not single nodes.
        self.node_glyphs.nonselection_glyph = None

    def _add_drawn(self) -> None:
        plot = self.figure
        names = ("crossed", "borders", "selected", "suggestions", "touched", "preview")
        self.segments = {
            name: ColumnDataSource({k: [] for k in ("x0", "y0", "x1", "y1")}, name=name)
            for name in names
        }
        looks: dict[str, dict[str, Any]] = {
            "crossed": {"color": BORDER_EDGE_GREEN, "line_width": 2.2},
            "touched": {"color": BORDER_EDGE_GREEN, "line_width": 3.0},
            "suggestions": {
                "color": SUGGESTION_ORANGE,
                "line_width": 5,
                "line_dash": [8, 5],
                "line_cap": "round",
            },
            "selected": {"color": SELECTED_BLUE, "line_width": 9, "alpha": 0.45},
            "borders": {"color": BORDER_BLACK, "line_width": 2.5},
            "preview": {"color": BORDER_BLACK, "line_width": 3.5, "line_dash": [8, 4]},
        }
        for name, look in looks.items():
            plot.segment("x0", "y0", "x1", "y1", source=self.segments[name], **look)
        self.handles = ColumnDataSource({"x": [], "y": []}, name="handles")
        plot.scatter(
            "x",
            "y",
            source=self.handles,
            size=8,
            fill_color="white",
            line_color=BORDER_BLACK,
            line_width=1.5,
        )
        self.leaks = ColumnDataSource({"xs": [], "ys": []}, name="leaks")
        plot.multi_line(
            "xs",
            "ys",
            source=self.leaks,
            color=LEAK_RED,
            line_width=5,
            alpha=0.75,
            line_cap="round",
            line_join="round",
        )

        self.titles = ColumnDataSource({"x": [], "y": [], "title": []}, name="titles")
        draw_names(plot, self.titles, "title")

    def metres_per_pixel(self) -> float:
        """How much of the map one pixel shows; a guess until the browser has told."""
        span, width = self.figure.x_range, self.figure.inner_width
        try:
            return abs(float(span.end) - float(span.start)) / float(width)
        except (TypeError, ValueError, ZeroDivisionError):
            return 0.01

    def show_rooms(self, drawing: Drawing) -> None:
        """Colour the nodes by the numbers of their rooms, and write the rooms' titles."""
        position = self._canvas.position
        number = room_of_nodes(drawing, len(position))
        titles: dict[str, list[Any]] = {"x": [], "y": [], "title": []}
        for room in drawing.active_rooms:
            # The node nearest to the median lies inside the room.
            own = position[room.indices()]
            nearest = np.linalg.norm(own - np.median(own, axis=0), axis=1).argmin()
            titles["x"].append(own[nearest, 0])
            titles["y"].append(own[nearest, 1])
            titles["title"].append(room.title)
        if titles != self.titles.data:
            self.titles.data = titles
        colour = ((number - 1) % PALETTE_SIZE).astype(np.int32)
        if not np.array_equal(colour, self.nodes.data["colour"]):
            self.nodes.patch({"colour": [(slice(len(colour)), colour)]})

    def show_selected_rooms(self, rooms: list[Room]) -> None:
        """Ring the nodes of rooms."""
        nodes = np.concatenate([np.zeros(0, np.int64), *(room.indices() for room in rooms)])
        x, y = self._canvas.position[nodes].T
        if len(x) or len(self.chosen.data["x"]):
            self.chosen.data = {"x": x, "y": y}

    def colour_of(self, room: int) -> str:
        """Colour of a room by its number."""
        return self.palette[(room - 1) % PALETTE_SIZE]

    def show_cut(self, drawing: Drawing, cut: Cut) -> None:
        """Draw the borders, the edges that they cross, and the leaks."""
        self.show("borders", drawing.segments)
        ends = drawing.segments.reshape(-1, 2)
        self.handles.data = {"x": ends[:, 0], "y": ends[:, 1]}
        self.show_edges("crossed", np.flatnonzero(cut.edge_is_border))
        ways = [self._canvas.position[leak.nodes] for leak in cut.leaks]
        self.leaks.data = {
            "xs": [way[:, 0].tolist() for way in ways],
            "ys": [way[:, 1].tolist() for way in ways],
        }

    def show(self, name: str, lines: Floats) -> None:
        """Show segments, shape (k, 2, 2)."""
        columns = np.asarray(lines, float).reshape(-1, 4).T
        names = ("x0", "y0", "x1", "y1")
        self.segments[name].data = dict(zip(names, columns.copy(), strict=True))

    def show_edges(self, name: str, edges: NDArray[np.int64]) -> None:
        """Show edges by their numbers."""
        self.show(name, self._canvas.position[self._canvas.edges[edges]])


def _picture(plot: Any, points: Floats) -> Any:
    """Obstacle points as one picture: there are too many to draw each anew at every edit."""
    low = points.min(axis=0) if len(points) else np.zeros(2)
    extent = np.ptp(points, axis=0) if len(points) else np.zeros(2)
    cell = max(CELL, float(extent.max()) / LARGEST_PICTURE)
    column, row = np.floor((points - low) / cell).astype(int).T
    shape = np.floor(extent[::-1] / cell).astype(int) + 1
    pixels = np.zeros((*shape, 4), np.uint8)
    pixels[row, column] = [int(OBSTACLE_BLUE[at : at + 2], 16) for at in (1, 3, 5)] + [255]
    width, height = shape[::-1] * cell
    return plot.image_rgba(
        image=[pixels.view(np.uint32)[:, :, 0]], x=low[0], y=low[1], dw=width, dh=height
    )


def _lines(plot: Any, segments: Floats, colour: str, width: float) -> Any:
    """Many segments, shape (k, 2, 2), as one line with gaps."""
    gap = np.full((len(segments), 1), np.nan)
    x, y = (np.hstack([segments[:, :, axis], gap]).ravel() for axis in (0, 1))
    return plot.line(x=x, y=y, color=colour, line_width=width)


def _lane_steps(topomap: TopoMap) -> Floats:
    """Steps from node to node within a lane, shape (k, 2, 2)."""
    nodes = topomap.nodes
    same = (np.diff(nodes.part) == 0) & (np.diff(nodes.lane) == 0)
    return np.stack([nodes.position[:-1][same], nodes.position[1:][same]], axis=1)
