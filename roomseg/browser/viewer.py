"""A map as one self-contained page: layers, rooms side by side, a run to be replayed.

Nothing is loaded from anywhere, and nothing is asked of a server: the page can be
mailed. Layers are switched in the legend; the few lines of JavaScript move the
robot along its path and choose what colours the edges.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from bokeh.embed import file_html
from bokeh.layouts import column, row
from bokeh.models import (
    ColorBar,
    ColumnDataSource,
    CustomJS,
    Div,
    HoverTool,
    LinearColorMapper,
    Select,
    Slider,
)
from bokeh.palettes import Viridis256
from bokeh.plotting import figure
from bokeh.resources import INLINE
from numpy.typing import NDArray

from dataset import MapFile, Path, TopoMap
from roomseg.figures import match_rooms
from roomseg.figures.plans import Frame, Plan, node_positions, plan_rings
from roomseg.figures.style import (
    BORDER_BLACK,
    BORDER_EDGE_GREEN,
    EDGE_RED,
    OBSTACLE_BLUE,
    TRAVEL_GREY,
    room_colours,
)
from roomseg.preprocessing import MapGraph, preprocess

__all__ = ["map_page"]

Floats = NDArray[np.float64]
MOST_POSES = 4000
"""Of the driven path, so that the page stays small."""
THUMBNAIL = 180
"""px; side of the images in the page."""
REPLAY = """
for (const path of paths) path.visible = true
const end = times.findLastIndex((time) => time <= slider.value) + 1
for (const [source, x, y] of tracks)
  source.data = {x: x.slice(0, end), y: y.slice(0, end)}
"""
COLOUR = """
for (const item of shown) item.visible = select.value != "none"
if (select.value == "none") return
const values = features[select.value]
const finite = values.filter(Number.isFinite).sort((a, b) => a - b)
mapper.setv({low: finite[0], high: finite[Math.floor(0.98 * (finite.length - 1))]})
edges.data = {...edges.data, value: values}
"""
SHOW = """
const node = cb_data.index.indices[0]
if (node !== undefined)
  div.text = `node ${node}<br>` + (images[node] ? `<img src="${images[node]}">` : "no image")
"""


def map_page(
    file: MapFile,
    outlines: Plan | None = None,
    features: Mapping[str, Floats] | None = None,
    most_images: int = 1000,
) -> str:
    """Make the page of a map.

    Parameters
    ----------
    file : MapFile
    outlines : Plan, optional
        Obstacles of the apartment, scene frame.
    features : mapping of name to array, shape (e',), optional
        Features of the edges that Algorithm 1 keeps.
    most_images : int
        Of more nodes none are shown, so that the page stays small.
    """
    topomap = file.topomap
    graph = preprocess(topomap)
    panels = _segmentations(file)
    drawn = _Drawn(topomap, graph, outlines)
    figures = [_panel(drawn, name, room) for name, room in panels]
    for other in figures[1:]:
        other.x_range, other.y_range = figures[0].x_range, figures[0].y_range
    images = _thumbnails(file, most_images)
    picture = Div(text="Point at a node.", width=THUMBNAIL + 10)
    for plot in figures:
        plot.select_one(HoverTool).callback = CustomJS(
            args={"div": picture, "images": images}, code=SHOW
        )
    controls = [*_feature_choice(figures[0], drawn, features), *_slider(drawn)]
    title = f"{topomap.environment}, {topomap.run}"
    page = column(
        row(*controls),
        row(*figures, picture, sizing_mode="stretch_both"),
        sizing_mode="stretch_both",
    )
    return str(file_html(page, INLINE, title))


@dataclass(frozen=True)
class _Drawn:
    """What all panels show, and the paths that the slider moves."""

    topomap: TopoMap
    graph: MapGraph
    outlines: Plan | None
    paths: list[_Track] = field(default_factory=list)

    @property
    def frame(self) -> Frame:
        """The plan's, if there is one."""
        known = self.outlines is not None and self.topomap.nodes.true_pose is not None
        return "scene" if known else "map"

    @property
    def position(self) -> Floats:
        """Where the nodes are drawn."""
        return node_positions(self.topomap.nodes, self.frame)


@dataclass(frozen=True)
class _Track:
    line: Any
    x: Floats
    y: Floats


def _segmentations(file: MapFile) -> list[tuple[str, NDArray[Any] | None]]:
    """What colours the nodes: true rooms beside those found, the same colours for both."""
    truth, found = file.topomap.ground_truth, file.rooms
    true_room = None if truth is None else truth.room
    panels: list[tuple[str, NDArray[Any] | None]] = []
    if true_room is not None:
        panels.append(("true rooms", true_room))
    if found is not None:
        label = found.label if true_room is None else match_rooms(found.label, true_room)
        panels.append((f"rooms by {found.model}", label))
    return panels or [("map", None)]


def _panel(drawn: _Drawn, title: str, room: NDArray[Any] | None) -> Any:
    """One figure with everything in layers; ``room`` colours the nodes."""
    plot = figure(
        title=title,
        match_aspect=True,
        sizing_mode="stretch_both",
        min_height=420,
        tools="pan,wheel_zoom,reset,save",
        active_scroll="wheel_zoom",
    )
    plot.grid.grid_line_color = None
    plot.toolbar.logo = None
    _surroundings(plot, drawn)
    _run(plot, drawn)
    _nodes(plot, drawn, room)
    plot.legend.click_policy = "hide"
    plot.legend.label_text_font_size = "11px"
    plot.add_layout(plot.legend[0], "below")
    plot.legend.ncols = 4
    return plot


def _surroundings(plot: Any, drawn: _Drawn) -> None:
    topomap, position, frame = drawn.topomap, drawn.position, drawn.frame
    if frame == "scene" and drawn.outlines is not None:
        rings = plan_rings(drawn.outlines)
        plot.multi_line(
            xs=[ring[:, 0] for ring in rings],
            ys=[ring[:, 1] for ring in rings],
            color=OBSTACLE_BLUE,
            legend_label="plan",
        )
    points = topomap.obstacles.position
    shown = plot.scatter(
        points[:, 0], points[:, 1], size=2, color=OBSTACLE_BLUE, legend_label="obstacle points"
    )
    shown.visible = frame == "map"
    _lines(plot, position[topomap.edges], EDGE_RED, "all edges").visible = False
    _lines(plot, position[drawn.graph.edges], TRAVEL_GREY, "kept edges")
    _borders(plot, drawn)


def _nodes(plot: Any, drawn: _Drawn, room: NDArray[Any] | None) -> None:
    position = drawn.position
    colours = (room_colours(int(room.max()) + 1 if room is not None else 1) * 255).astype(int)
    hues = np.array([f"#{r:02x}{g:02x}{b:02x}" for r, g, b in colours])
    nodes = plot.scatter(
        position[:, 0],
        position[:, 1],
        size=6,
        color=hues[np.zeros(len(position), int) if room is None else room].tolist(),
        legend_label="nodes",
    )
    if drawn.frame == "scene":
        estimate = drawn.topomap.nodes.position
        plot.scatter(
            estimate[:, 0], estimate[:, 1], size=3, color="black", legend_label="estimated nodes"
        ).visible = False
    plot.add_tools(HoverTool(renderers=[nodes], tooltips=None))


def _lines(plot: Any, segments: Floats, colour: str, name: str, width: float = 0.8) -> Any:
    gap = np.full((len(segments), 1), np.nan)
    x, y = (np.hstack([segments[:, :, axis], gap]).ravel() for axis in (0, 1))
    return plot.line(x, y, color=colour, line_width=width, legend_label=name)


def _borders(plot: Any, drawn: _Drawn) -> None:
    truth = drawn.topomap.ground_truth
    if truth is None:
        return
    crossed = drawn.position[drawn.topomap.edges[truth.edge_is_border]]
    _lines(plot, crossed, BORDER_EDGE_GREEN, "border edges", 1.6).visible = False
    if truth.frame == drawn.frame:
        _lines(plot, truth.borders, BORDER_BLACK, "borders", 2.0)


def _run(plot: Any, drawn: _Drawn) -> None:
    """The driven path, true and as the robot takes it to be, up to the slider's time."""
    path = drawn.topomap.path
    if path is None or not len(path.time):
        return
    poses = [("estimated path", path.estimate, "#7B3294")]
    if drawn.frame == "scene":
        poses.append(("true path", path.true_pose, "#E66101"))
    for name, pose, colour in poses:
        x, y = pose[:: _step(path), 0], pose[:: _step(path), 1]
        line = plot.line(x, y, color=colour, line_width=2, legend_label=name, name="path")
        line.visible = False
        drawn.paths.append(_Track(line, x, y))


def _step(path: Path) -> int:
    """Of so many poses one is drawn."""
    return max(1, len(path.time) // MOST_POSES)


def _slider(drawn: _Drawn) -> list[Any]:
    path = drawn.topomap.path
    if path is None or not drawn.paths:
        return []
    times = path.time[:: _step(path)]
    end = float(np.ceil(times[-1]))
    slider = Slider(start=0.0, end=end, step=1.0, value=end, title="replay the run, s")
    arguments = {
        "slider": slider,
        "times": times.tolist(),
        "paths": [track.line for track in drawn.paths],
        "tracks": [[t.line.data_source, t.x.tolist(), t.y.tolist()] for t in drawn.paths],
    }
    slider.js_on_change("value", CustomJS(args=arguments, code=REPLAY))
    return [slider]


def _feature_choice(plot: Any, drawn: _Drawn, features: Mapping[str, Floats] | None) -> list[Any]:
    """A menu of what colours the edges."""
    if not features:
        return []
    ends = drawn.position[drawn.graph.edges]
    mapper = LinearColorMapper(palette=Viridis256, low=0.0, high=1.0)
    columns = {f"{a}{i}": ends[:, i, k] for i in (0, 1) for k, a in enumerate("xy")}
    source = ColumnDataSource(columns | {"value": np.zeros(len(ends))})
    shown = plot.segment(
        "x0",
        "y0",
        "x1",
        "y1",
        source=source,
        line_width=2.5,
        color={"field": "value", "transform": mapper},
    )
    shown.visible = False
    bar = ColorBar(color_mapper=mapper, width=10, visible=False)
    plot.add_layout(bar, "right")
    select = Select(title="edge feature as colour", options=["none", *features], value="none")
    arguments = {
        "select": select,
        "features": {name: values.tolist() for name, values in features.items()},
        "mapper": mapper,
        "edges": source,
        "shown": [shown, bar],
    }
    select.js_on_change("value", CustomJS(args=arguments, code=COLOUR))
    return [select]


def _thumbnails(file: MapFile, most: int) -> list[str]:
    """Small JPEG images of the nodes as data URLs; empty where there is none."""
    if len(file.done) > most:
        return [""] * len(file.done)
    return [_data_url(file.image(node)) if done else "" for node, done in enumerate(file.done)]


def _data_url(image: NDArray[np.uint8]) -> str:
    scale = THUMBNAIL / max(image.shape)
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    packed = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, 70])[1]
    return "data:image/jpeg;base64," + base64.b64encode(packed.tobytes()).decode()
