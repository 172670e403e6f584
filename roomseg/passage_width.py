"""Passageway width L from local obstacle points (§2.2.2, Fig. 7, Appendix A).

What the paper says: obstacle points seen near an edge's nodes (Eqs. A1, A2) are
freed of false measurements by DBSCAN; a strip runs orthogonally to the edge,
its width "equal to l + r_robot - 3 cm on either side"; L is the distance
between the points of the strip that are closest to the edge on each side, or
5 m if a side has none.

What it leaves open, and what we chose:

* *Of what* l + r_robot - 3 cm is the width. We take it for the whole width of
  the strip, the same on the left and on the right of the edge: 6 cm beyond
  either node, "somewhat wider than the length of the edge", as Fig. 7 has it.
  On simulated maps this also comes closest to the paper's figures (47 % of
  edges without L, an area of 0.78 under the ROC curve). ``reading="node"``
  measures it from each node towards the other and beyond, r_robot - 3 cm
  beyond either node, and ``reading="middle"`` from the edge's middle to both
  ends; these strips are wider, find L for more edges, and tell less.
* The extension "up to 5 cm" is as much of 5 cm as keeps the strip within the
  lane's first and last node; where the strip already ends there, nothing.
* "Closest to the edge" is the distance to the line segment, not to its line.
* A point that belongs to no cluster is noise in the sense of DBSCAN with three
  points (itself included) within 10 cm, among the points near this edge.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree
from sklearn.cluster import dbscan

from dataset.topomap import Nodes, TopoMap

__all__ = ["LocalObstacles", "WidthParameters", "passageway_widths", "search_strips"]

_BATCH = 64
"""Edges whose points are clustered in one call."""

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class WidthParameters:
    """Parameters of §2.2.2 and Appendix A; lengths in m, times in s.

    Attributes
    ----------
    node_distance : float
        ε_d of Eq. A1.
    time_distance : float
        ε_τ of Eq. A2, s.
    cluster_radius, cluster_points : float, int
        DBSCAN's neighbourhood and least number of points.
    inset : float
        Taken from the robot radius.
    short_length, extension : float
        In-lane edges shorter than the first get up to the second more.
    default : float
        L where there is not enough obstacle data.
    reading : {'whole', 'node', 'middle'}
        Of what l + r_robot - inset is the width, see the module's text.
    """

    node_distance: float = 0.50
    time_distance: float = 7.0
    cluster_radius: float = 0.10
    cluster_points: int = 3
    inset: float = 0.03
    short_length: float = 0.20
    extension: float = 0.05
    default: float = 5.0
    reading: Literal["whole", "node", "middle"] = "whole"


@dataclass(frozen=True)
class LocalObstacles:
    """Obstacle points by time, and the points seen near each node.

    Attributes
    ----------
    position : array, shape (k, 2)
        m, in order of time.
    start, stop : arrays, shape (v,)
        Per visit: its points are ``position[start:stop]`` (Eq. A2).
    visits : tuple of n arrays
        Per node: the visits whose times form T'_k (Eq. A1).
    """

    position: Floats
    start: Integers
    stop: Integers
    visits: tuple[Integers, ...]

    @classmethod
    def of(cls, topomap: TopoMap, parameters: WidthParameters) -> LocalObstacles:
        """Sort the points by time and find T'_k of every node."""
        order = np.argsort(topomap.obstacles.time, kind="stable")
        time = topomap.obstacles.time[order]
        reach = parameters.time_distance
        start = np.searchsorted(time, topomap.visits.time - reach, side="right")
        stop = np.searchsorted(time, topomap.visits.time + reach, side="left")
        visits = _nearby_visits(topomap, parameters.node_distance)
        return cls(topomap.obstacles.position[order], start, stop, visits)

    def near(self, *nodes: int) -> Floats:
        """O_k of Eq. A2, or the union O_k ∪ O_l for an edge: positions, shape (p, 2), m."""
        visits = np.concatenate([self.visits[node] for node in nodes])
        spans = _merged_spans(self.start[visits], self.stop[visits])
        pieces = [self.position[start:stop] for start, stop in spans]
        return np.concatenate(pieces) if pieces else np.empty((0, 2))


def _nearby_visits(topomap: TopoMap, node_distance: float) -> tuple[Integers, ...]:
    """T'_k of Eq. A1 as indices of visits: of the node and of near nodes of its part."""
    nodes, n = topomap.nodes, len(topomap.nodes)
    pairs = KDTree(nodes.position).query_pairs(node_distance, output_type="ndarray")
    gap = np.linalg.norm(nodes.position[pairs[:, 0]] - nodes.position[pairs[:, 1]], axis=1)
    same_part = nodes.part[pairs[:, 0]] == nodes.part[pairs[:, 1]]
    pairs = pairs[same_part & (gap < node_distance)]
    own = np.arange(n)
    source = np.concatenate([own, pairs[:, 0], pairs[:, 1]])
    near = np.concatenate([own, pairs[:, 1], pairs[:, 0]])
    order = np.argsort(source, kind="stable")
    neighbours = np.split(near[order], np.cumsum(np.bincount(source, minlength=n))[:-1])
    by_node = np.argsort(topomap.visits.node, kind="stable")
    counts = np.bincount(topomap.visits.node, minlength=n)
    visits = np.split(by_node, np.cumsum(counts)[:-1])
    return tuple(np.concatenate([visits[node] for node in group]) for group in neighbours)


def _merged_spans(start: Integers, stop: Integers) -> Integers:
    """Disjoint, ascending spans with the same union, shape (m, 2)."""
    some = stop > start
    order = np.argsort(start[some], kind="stable")
    start, stop = start[some][order], np.maximum.accumulate(stop[some][order])
    if not len(start):
        return np.empty((0, 2), dtype=np.int64)
    fresh = start[1:] > stop[:-1]
    first, last = np.r_[True, fresh], np.r_[fresh, True]
    return np.stack([start[first], stop[last]], axis=1)


def passageway_widths(
    topomap: TopoMap, edges: Integers, parameters: WidthParameters | None = None
) -> Floats:
    """Passageway width L of each edge (§2.2.2).

    Parameters
    ----------
    topomap : TopoMap
    edges : array, shape (e', 2)
        Edges that are left after preprocessing.
    parameters : WidthParameters, optional

    Returns
    -------
    array, shape (e',)
        m; ``parameters.default`` where a side of the edge has no obstacle.
    """
    parameters = parameters or WidthParameters()
    obstacles = LocalObstacles.of(topomap, parameters)
    strips = search_strips(topomap.nodes, edges, topomap.robot_radius, parameters)
    position = topomap.nodes.position
    width = np.full(len(edges), parameters.default)
    measurable = np.flatnonzero((position[edges[:, 0]] != position[edges[:, 1]]).any(axis=1))
    for begin in range(0, len(measurable), _BATCH):
        batch = measurable[begin : begin + _BATCH]
        points = [
            _strip_points(obstacles, position, edge, strip, parameters)
            for edge, strip in zip(edges[batch], strips[batch], strict=True)
        ]
        clustered = _without_noise(points, parameters)
        for index, kept in zip(batch, clustered, strict=True):
            width[index] = _width_between(kept, strips[index], parameters.default)
    return width


def search_strips(
    nodes: Nodes, edges: Integers, robot_radius: float, parameters: WidthParameters
) -> Floats:
    """Where the search strip of each edge begins and ends along the edge (§2.2.2, Fig. 7).

    Returns
    -------
    array, shape (e', 3)
        m along the edge, zero in its middle: begin, end, and l / 2.
    """
    vector = nodes.position[edges[:, 1]] - nodes.position[edges[:, 0]]
    length = np.linalg.norm(vector, axis=1)
    width = length + robot_radius - parameters.inset
    reach = {"whole": width / 2, "node": width - length / 2, "middle": width}[parameters.reading]
    strips = np.stack([-reach, reach, length / 2], axis=1)
    lanes = _lane_members(nodes)
    for index in np.flatnonzero(length < parameters.short_length):
        k, l = edges[index]  # noqa: E741
        lane = lanes[(nodes.part[k], nodes.lane[k])]
        if length[index] > 0 and _subsequent(lane, k, l):
            along = _edge_frame(nodes.position[lane], nodes.position[k], nodes.position[l])[:, 0]
            back = np.clip(-reach[index] - along.min(), 0, parameters.extension)
            ahead = np.clip(along.max() - reach[index], 0, parameters.extension)
            strips[index, :2] += (-back, ahead)
    return np.asarray(strips, dtype=np.float64)


def _lane_members(nodes: Nodes) -> dict[tuple[int, int], Integers]:
    """Nodes of every (part, lane) in order of creation."""
    keys = np.stack([nodes.part, nodes.lane], axis=1)
    unique, inverse = np.unique(keys, axis=0, return_inverse=True)
    order = np.argsort(inverse.reshape(-1), kind="stable")
    members = np.split(order, np.cumsum(np.bincount(inverse.reshape(-1)))[:-1])
    return {(int(p), int(q)): group for (p, q), group in zip(unique, members, strict=True)}


def _subsequent(lane: Integers, k: int, l: int) -> bool:  # noqa: E741
    """Whether l follows k, or k follows l, in this lane."""
    at = np.searchsorted(lane, [k, l])
    return bool(
        at.max() < len(lane) and (lane[at] == (k, l)).all() and abs(int(at[1]) - int(at[0])) == 1
    )


def _edge_frame(points: Floats, first: Floats, second: Floats) -> Floats:
    """Points along and left of the edge, origin in its middle, shape (p, 2), m."""
    ahead = (second - first) / np.linalg.norm(second - first)
    axes = np.array([ahead, [-ahead[1], ahead[0]]])
    framed: Floats = (points - (first + second) / 2) @ axes.T
    return framed


def _strip_points(
    obstacles: LocalObstacles,
    position: Floats,
    edge: Integers,
    strip: Floats,
    parameters: WidthParameters,
) -> Floats:
    """Points near an edge that decide on its L, in the edge's frame, shape (p, 2), m.

    Whether a point of the strip is noise depends on points within two cluster
    radii of it only.
    """
    points = _edge_frame(obstacles.near(*edge), position[edge[0]], position[edge[1]])
    margin = 2.001 * parameters.cluster_radius
    inside = (points[:, 0] >= strip[0] - margin) & (points[:, 0] <= strip[1] + margin)
    near: Floats = points[inside]
    return near


def _without_noise(points: list[Floats], parameters: WidthParameters) -> list[Floats]:
    """Drop the points that DBSCAN puts into no cluster, for several edges at once.

    The edge's number is a third coordinate, so that points of different edges
    are never neighbours; one call for many edges saves its overhead.
    """
    counts = [len(group) for group in points]
    if not sum(counts):
        return points
    apart = 2.0 * parameters.cluster_radius * np.repeat(np.arange(len(points)), counts)
    stacked = np.column_stack([np.concatenate(points), apart])
    _, label = dbscan(stacked, eps=parameters.cluster_radius, min_samples=parameters.cluster_points)
    groups = np.split(np.asarray(label) >= 0, np.cumsum(counts)[:-1])
    clustered: list[Floats] = [group[kept] for group, kept in zip(points, groups, strict=True)]
    return clustered


def _width_between(points: Floats, strip: Floats, default: float) -> float:
    """L: distance of the two points of the strip closest to the edge on either side, m."""
    begin, end, half_length = strip
    points = points[(points[:, 0] >= begin) & (points[:, 0] <= end)]
    beyond = np.maximum(np.abs(points[:, 0]) - half_length, 0.0)
    distance = np.hypot(beyond, points[:, 1])
    left = points[:, 1] > 0
    if left.all() or not left.any():
        return default
    sides = [points[side][np.argmin(distance[side])] for side in (left, ~left)]
    return float(np.linalg.norm(sides[0] - sides[1]))
