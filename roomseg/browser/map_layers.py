"""The layers of a map, each drawn from one source into every figure of its page (Bokeh).

What was there at a time of the run is told by `Track`: its rows are in the order of
time, so that the page shows the first of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from bokeh.models import ColumnDataSource
from numpy.typing import NDArray

from dataset.topomap import TopoMap
from roomseg.browser.shell import areas
from roomseg.figures.plans import Frame, node_positions
from roomseg.figures.style import BORDER_BLACK, EDGE_RED, OBSTACLE_BLUE, TRAVEL_GREY
from roomseg.preprocessing import MapGraph

__all__ = ["MapLayers", "Track", "line_columns"]

Floats = NDArray[np.float64]

MOST_POSES = 4000
"""Of the driven path, so that the page stays small."""
TRUE, ESTIMATE, LANE = "#E66101", "#7B3294", "#C0562F"


@dataclass(frozen=True)
class Track:
    """A source whose first rows are shown during the replay: the times of its rows, s."""

    source: ColumnDataSource
    time: Floats


class MapLayers:
    """Sources of all layers, and what draws them.

    Parameters
    ----------
    topomap : TopoMap
    graph : MapGraph
        What Algorithm 1 keeps.
    outlines : shapely geometry, optional
        Obstacles of the apartment, scene frame.

    Attributes
    ----------
    frame : {'scene', 'map'}
        The plan's, if there is one and the true poses are known.
    position : array, shape (n, 2)
        Where the nodes are drawn, m.
    visited : array, shape (n,)
        When each node was made, s.
    renderers : dict
        What shows a layer, of all figures.
    shown : list of str
        Layers that are switched on at first.
    """

    def __init__(self, topomap: TopoMap, graph: MapGraph, outlines: Any = None) -> None:
        self._topomap, self._graph, self._outlines = topomap, graph, outlines
        known = outlines is not None and topomap.nodes.true_pose is not None
        self.frame: Frame = "scene" if known else "map"
        self.position = node_positions(topomap.nodes, self.frame)
        self.visited = _first_visits(topomap)
        self.renderers: dict[str, list[Any]] = {}
        self.shown = ["kept edges", "plan" if known else "obstacle points"]
        self.tracks: dict[str, Track] = {}
        self.poses = self._poses()
        self._sources: dict[str, ColumnDataSource] = {}
        self._make_sources()

    def add(self, name: str, renderer: Any, *, shown: bool = False) -> None:
        """Count something drawn to a layer."""
        self.renderers.setdefault(name, []).append(renderer)
        if shown and name not in self.shown:
            self.shown.append(name)

    def draw_ground(self, plot: Any) -> None:
        """What lies below the nodes, the lowest first."""
        if self.frame == "scene":
            look = {"fill_color": "#DCE9F2", "line_color": OBSTACLE_BLUE, "line_width": 0.8}
            self.add("plan", plot.multi_polygons("xs", "ys", source=self._sources["plan"], **look))
        points = plot.scatter(
            "x", "y", source=self._sources["obstacle points"], size=2, color=OBSTACLE_BLUE
        )
        self.add("obstacle points", points)
        for name, colour, width in (
            ("all edges", EDGE_RED, 0.6),
            ("kept edges", TRAVEL_GREY, 0.8),
            ("lanes", LANE, 1.6),
        ):
            self.add(name, self._line(plot, name, color=colour, line_width=width))

    def draw_run(self, plot: Any) -> None:
        """Where the robot was, and where it took itself to be."""
        for name, colour in (("true path", TRUE), ("estimated path", ESTIMATE)):
            if name in self._sources:
                line = self._line(plot, name, color=colour, line_width=1.6, alpha=0.8)
                self.add(name, line)

    def draw_truth(self, plot: Any) -> None:
        """Borders, and where the robot takes the nodes to be."""
        if "borders" in self._sources:
            line = self._line(plot, "borders", color=BORDER_BLACK, line_width=2.0)
            self.add("borders", line, shown=True)
        if self.frame == "scene":
            name = "estimated poses"
            self.add(name, self._line(plot, name, color=ESTIMATE, line_width=0.8))
            source = self._sources["estimated nodes"]
            self.add(name, plot.scatter("x", "y", source=source, size=3, color=ESTIMATE))

    def draw_robots(self, plot: Any, robots: Mapping[str, ColumnDataSource]) -> None:
        """The robot, a disc with a mouth where it looks."""
        for name, source in robots.items():
            colour = TRUE if name == "true path" else ESTIMATE
            plot.wedge(
                "x",
                "y",
                radius=self._topomap.robot_radius,
                start_angle="start",
                end_angle="end",
                source=source,
                fill_color=colour,
                fill_alpha=0.55,
                line_color="white",
            )

    def _line(self, plot: Any, name: str, **look: Any) -> Any:
        return plot.line("x", "y", source=self._sources[name], **look)

    def _source(self, name: str, columns: Mapping[str, Any]) -> ColumnDataSource:
        """Make the source of a layer, one for all figures."""
        self._sources[name] = ColumnDataSource(dict(columns), name=name)
        return self._sources[name]

    def _make_sources(self) -> None:
        topomap = self._topomap
        points = topomap.obstacles
        self._follow(
            "obstacle points",
            {"x": points.position[:, 0], "y": points.position[:, 1]},
            points.time,
        )
        self._follow_pairs("all edges", topomap.edges)
        self._follow_pairs("kept edges", self._graph.edges)
        self._follow_pairs("lanes", _lane_steps(topomap))
        for name, pose in self.poses.items():
            self._follow(name, {"x": pose[:, 0], "y": pose[:, 1]}, self.pose_times)
        truth = topomap.ground_truth
        if truth is not None and truth.frame == self.frame and len(truth.borders):
            self._source("borders", line_columns(truth.borders))
        if self.frame == "scene":
            self._source("plan", areas(*shapely.get_parts(self._outlines)))
            estimate = topomap.nodes.position
            drift = np.stack([self.position, estimate], axis=1)
            self._source("estimated poses", line_columns(drift))
            self._source("estimated nodes", {"x": estimate[:, 0], "y": estimate[:, 1]})

    def _follow(self, name: str, columns: Mapping[str, Any], time: Floats) -> None:
        """A source that the replay shows the beginning of."""
        order = np.argsort(time, kind="stable")
        source = self._source(name, {key: value[order] for key, value in columns.items()})
        self.tracks[name] = Track(source, time[order])

    def _follow_pairs(self, name: str, pairs: NDArray[Any]) -> None:
        """Lines from node to node; they are there when both nodes are."""
        time = self.visited[pairs].max(axis=1) if len(pairs) else np.zeros(0)
        order = np.argsort(time, kind="stable")
        columns = line_columns(self.position[pairs[order]])
        self.tracks[name] = Track(self._source(name, columns), np.repeat(time[order], 3))

    @property
    def pose_times(self) -> Floats:
        """When the robot was where `poses` say, s."""
        path = self._topomap.path
        return np.zeros(0) if path is None else path.time[:: self._step]

    @property
    def _step(self) -> int:
        path = self._topomap.path
        return 1 if path is None else max(1, len(path.time) // MOST_POSES)

    def _poses(self) -> dict[str, Floats]:
        """Poses of the driven path, shape (t, 3), by layer."""
        path = self._topomap.path
        if path is None or not len(path.time):
            return {}
        poses = {"estimated path": path.estimate[:: self._step]}
        if self.frame == "scene":
            poses["true path"] = path.true_pose[:: self._step]
        return poses


def line_columns(segments: Floats) -> dict[str, Floats]:
    """Many segments, shape (k, 2, 2), as one line with gaps."""
    segments = np.asarray(segments, float).reshape(-1, 2, 2)
    gap = np.full((len(segments), 1), np.nan)
    x, y = (np.hstack([segments[:, :, axis], gap]).ravel() for axis in (0, 1))
    return {"x": x, "y": y}


def _first_visits(topomap: TopoMap) -> Floats:
    """When each node was made, s; 0 if the map does not tell."""
    first = np.full(len(topomap.nodes), np.inf)
    np.minimum.at(first, topomap.visits.node, topomap.visits.time)
    return np.where(np.isfinite(first), first, 0.0)


def _lane_steps(topomap: TopoMap) -> NDArray[np.int64]:
    """Nodes that follow each other in a lane, shape (k, 2)."""
    nodes = topomap.nodes
    same = (np.diff(nodes.part) == 0) & (np.diff(nodes.lane) == 0)
    first = np.flatnonzero(same)
    return np.stack([first, first + 1], axis=1)
