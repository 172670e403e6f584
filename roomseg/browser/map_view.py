"""A map in one or two figures with a segmentation each, zoomed together (Bokeh)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np
from bokeh.layouts import column, row
from bokeh.models import (
    ColorBar,
    ColumnDataSource,
    CustomJS,
    HoverTool,
    LinearColorMapper,
    Select,
)
from bokeh.palettes import Viridis256
from numpy.typing import NDArray

from dataset.topomap import TopoMap
from roomseg.browser.comparison import Segmentation, shown_beside
from roomseg.browser.labels import draw_names
from roomseg.browser.map_layers import MapLayers, line_columns
from roomseg.browser.replay import robot_sources
from roomseg.browser.shell import FEATURE_TITLES, PALETTE, layer_switch, plan_figure, text
from roomseg.figures.style import BORDER_BLACK, BORDER_EDGE_GREEN

__all__ = ["MapView"]

Floats = NDArray[np.float64]

NODE = 0.05
"""m; radius of a node's circle."""
WIDE = 1.4
"""Figures of maps that are so many times as wide as high stand one above the other."""
DIFFERING = "differing nodes"
ENDS = ("x0", "y0", "x1", "y1")
COLOUR = """
for (const item of shown) item.visible = select.value != "none"
if (select.value == "none") return
const values = features[select.value]
const finite = Array.from(values).filter(Number.isFinite).sort((a, b) => a - b)
mapper.setv({low: finite[0], high: finite[Math.floor(0.98 * (finite.length - 1))]})
for (const bar of bars) bar.title = titles[select.value]
edges.data = {...edges.data, value: values}
"""
COMPARE = """
const at = selects.map((select) => Number(select.value))
const pair = [shown[at[0]][at[0]], shown[at[0]][at[1]]]
const [left, right] = pair.map((one) => Array.from(one.colour))
const differs = left.map((value, node) => value == right[node] ? 0 : 1)
nodes.data = {...nodes.data, colour0: left, colour1: right, differs}
pair.forEach((one, index) => {
  names[index].data = {...one.rooms}
  titles[index].text = one.about
  crossed[index].data = {...crossing[at[index]]}
})
"""
SHOW = """
const node = cb_data.index.indices[0]
if (node === undefined || node === div.tags[0]) return
div.tags = [node]
const {lane, part, time} = nodes.data
const pictures = images[node].map((url) => `<img src="${url}">`).join("")
div.text = `<b>Node ${node}</b>, lane ${lane[node]} of part ${part[node]}, ` +
  `after ${Math.round(time[node])} s` + (pictures || "<br>no image")
"""


class MapView:
    """The figures of a map's page.

    Parameters
    ----------
    layers : MapLayers
    topomap : TopoMap
    segmentations : sequence of Segmentation
        If there are several, any two of them can be chosen.
    """

    def __init__(
        self, layers: MapLayers, topomap: TopoMap, segmentations: Sequence[Segmentation]
    ) -> None:
        self.layers = layers
        self._segmentations = segmentations
        self._shown = shown_beside(segmentations, layers.position)
        self.nodes = ColumnDataSource(self._node_columns(topomap), name="nodes")
        self.robots = robot_sources(layers)
        self._values = ColumnDataSource({k: [] for k in (*ENDS, "value")}, name="edge values")
        self._value_colours = LinearColorMapper(palette=Viridis256, low=0.0, high=1.0)
        self._value_lines: list[Any] = []
        self._names: list[ColumnDataSource] = []
        self._crossed: list[ColumnDataSource] = []
        self._hovered: list[Any] = []
        count = min(2, max(1, len(segmentations)))
        self.figures = [self._figure(index) for index in range(count)]
        for other in self.figures[1:]:
            other.x_range, other.y_range = self.figures[0].x_range, self.figures[0].y_range
            other.match_aspect = False  # The first sees to it; two would fit the ranges in turn.
        self.switch = layer_switch(layers.renderers, layers.shown, coloured=True)

    def _node_columns(self, topomap: TopoMap) -> dict[str, Any]:
        n, position = len(topomap.nodes), self.layers.position
        columns = {
            "x": position[:, 0],
            "y": position[:, 1],
            "lane": topomap.nodes.lane,
            "part": topomap.nodes.part,
            "time": self.layers.visited,
            "made": np.ones(n),
            "colour0": np.zeros(n, np.uint8),
            "differs": np.zeros(n, np.uint8),
        }
        if self._shown:
            last = min(1, len(self._shown) - 1)
            left, right = self._shown[0][0].colour, self._shown[0][last].colour
            columns |= {"colour0": left, "colour1": right}
            columns["differs"] = (left != right).astype(np.uint8)
        return columns

    def _figure(self, index: int) -> Any:
        """One figure with all layers; the segmentation colours the nodes."""
        plot = plan_figure()
        self.layers.draw_ground(plot)
        self._draw_values(plot)
        self._draw_crossed(plot, index)
        self.layers.draw_run(plot)
        self._draw_nodes(plot, index)
        self.layers.draw_truth(plot)
        if self._shown:
            self._draw_names(plot, index)
        self.layers.draw_robots(plot, self.robots)
        return plot

    def _draw_values(self, plot: Any) -> None:
        """Edges in the colour of a feature, below the nodes."""
        line = plot.segment(
            *ENDS,
            source=self._values,
            line_width=2.5,
            color={"field": "value", "transform": self._value_colours},
            visible=False,
        )
        self._value_lines.append(line)

    def _draw_crossed(self, plot: Any, index: int) -> None:
        """Edges that the segmentation takes for border edges."""
        columns = self._crossing()[index] if self._segmentations else line_columns(np.zeros(0))
        source = ColumnDataSource(columns, name=f"crossed{index}")
        self._crossed.append(source)
        if any(item.crossing is not None for item in self._segmentations):
            line = plot.line("x", "y", source=source, color=BORDER_EDGE_GREEN, line_width=1.8)
            self.layers.add("border edges", line)

    def _crossing(self) -> list[dict[str, Floats]]:
        return [
            line_columns(self.layers.position[[] if s.crossing is None else s.crossing])
            for s in self._segmentations
        ]

    def _draw_nodes(self, plot: Any, index: int) -> None:
        mapper = LinearColorMapper(palette=PALETTE, low=-0.5, high=len(PALETTE) - 0.5)
        nodes = plot.circle(
            "x",
            "y",
            source=self.nodes,
            radius=NODE,
            fill_color={"field": f"colour{index}", "transform": mapper},
            fill_alpha="made",
            line_color=None,
        )
        self._hovered.append((plot, nodes))
        self.layers.add("nodes", nodes, shown=True)
        if len(self._segmentations) > 1:
            # Metres, not pixels: else rings hide the colours of a large map. Seen on the right
            # only, but there in both, so that the figures fit the same ranges.
            ring = plot.annulus(
                "x",
                "y",
                source=self.nodes,
                inner_radius=1.1 * NODE,
                outer_radius=1.5 * NODE,
                fill_color=BORDER_BLACK,
                fill_alpha="differs" if index else 0.0,
                line_color=None,
            )
            self.layers.add(DIFFERING, ring, shown=True)

    def _draw_names(self, plot: Any, index: int) -> None:
        source = ColumnDataSource(self._shown[0][index].rooms, name=f"names{index}")
        self._names.append(source)
        names = draw_names(plot, source, "name")
        self.layers.add("room names", names, shown=True)

    def layout(self) -> Any:
        """The figures side by side, each with a menu of what it shows if there are two."""
        if not self._shown:
            return self.figures[0]
        if len(self.figures) == 1:
            about = f"{self._segmentations[0].name}: {self._shown[0][0].about}"
            return column(text(escape(about)), self.figures[0], sizing_mode="stretch_both")
        options = [(str(i), item.name) for i, item in enumerate(self._segmentations)]
        selects = [
            Select(options=options, value=str(index), name=f"rooms{index}", width=216)
            for index in range(2)
        ]
        abouts = [
            text(escape(self._shown[0][index].about), f"about{index}", width=212)
            for index in range(2)
        ]
        arguments = {
            "selects": selects,
            "shown": [
                [{"about": escape(s.about), "colour": s.colour, "rooms": s.rooms} for s in line]
                for line in self._shown
            ],
            "nodes": self.nodes,
            "names": self._names,
            "titles": abouts,
            "crossed": self._crossed,
            "crossing": self._crossing(),
        }
        for select in selects:
            select.js_on_change("value", CustomJS(args=arguments, code=COMPARE))
        columns = [
            column(row(select, about, height=44), plot, sizing_mode="stretch_both")
            for select, about, plot in zip(selects, abouts, self.figures, strict=True)
        ]
        arranged = column if self._is_wide() else row
        return arranged(*columns, sizing_mode="stretch_both")

    def _is_wide(self) -> bool:
        """Whether the figures are larger one above the other."""
        width, height = np.ptp(self.layers.position, axis=0)
        return bool(width > WIDE * height)

    def feature_choice(self, edges: NDArray[Any], features: Mapping[str, Floats]) -> list[Any]:
        """A menu of what colours the edges, shape (e', 2), by their values, shape (e',)."""
        if not features or not len(edges):
            return []
        ends = self.layers.position[edges]
        columns = dict(zip(ENDS, ends.reshape(-1, 4).T.copy(), strict=True))
        self._values.data = columns | {"value": np.zeros(len(ends))}
        mapper, bars = self._value_colours, []
        for plot in self.figures:
            bars.append(ColorBar(color_mapper=mapper, height=10, title=" ", visible=False))
            plot.add_layout(bars[-1], "below")
        select = Select(title="Edges coloured by", options=["none", *features], value="none")
        arguments = {
            "select": select,
            "features": dict(features),
            "titles": {name: FEATURE_TITLES.get(name, name) for name in features},
            "mapper": mapper,
            "edges": self._values,
            "bars": bars,
            "shown": [*self._value_lines, *bars],
        }
        select.js_on_change("value", CustomJS(args=arguments, code=COLOUR))
        return [select]

    def show_images(self, div: Any, images: Sequence[Sequence[str]]) -> None:
        """Pointing at a node shows its images, data URLs."""
        arguments = {"div": div, "images": images, "nodes": self.nodes}
        for plot, nodes in self._hovered:
            plot.add_tools(
                HoverTool(
                    renderers=[nodes],
                    tooltips=None,
                    visible=False,
                    callback=CustomJS(args=arguments, code=SHOW),
                )
            )
