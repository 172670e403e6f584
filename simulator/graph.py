"""The topo-metric map while it grows: nodes, edges, visits, shortest paths (§2.1)."""

from __future__ import annotations

import bisect
import math
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import compiled
from simulator.routes import Ways, shortest

__all__ = ["MapGraph", "Table", "distance_at", "is_near", "nearest_first", "sort_by"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Nodes = NDArray[np.int64]
Array = TypeVar("Array", bound=NDArray[Any])

_TOLL = 5.0
"""A way through a place that barred the robot counts as so much longer, m."""


class MapGraph:
    """Growing arrays; node k is row k of everything."""

    def __init__(self) -> None:
        self._estimate = np.zeros((256, 3))
        self._true_pose = np.zeros((256, 3))
        self.part: list[int] = []
        self.lane: list[int] = []
        self._buckets = _bucketed(self._estimate, 0)
        self._ways = Ways(
            np.zeros((256, 2), np.int32),
            np.zeros(256),
            np.zeros(256, np.int64),
            np.zeros(512, np.int64),
        )
        self._edge_count = 0
        self.visits: list[tuple[float, int]] = []
        self._near: Nodes = np.zeros(0, np.int64)

    def __len__(self) -> int:
        return len(self.part)

    @property
    def edges(self) -> Ints:
        """Node pairs (e, 2), the smaller first, in order of creation."""
        return self._ways.edges[: self._edge_count]

    @property
    def estimate(self) -> Floats:
        """Pose estimates of all nodes, shape (n, 3), m, m, rad."""
        return self._estimate[: len(self)]

    @property
    def position(self) -> Floats:
        """Position estimates of all nodes, shape (n, 2), m."""
        return self._estimate[: len(self), :2]

    @property
    def true_pose(self) -> Floats:
        """True poses of all nodes, shape (n, 3); for the physics and the record only."""
        return self._true_pose[: len(self)]

    def add_node(
        self, estimate: Floats, true_pose: Floats, part: int, lane: int, time: float
    ) -> int:
        """Append a node, visited now; returns its index.

        ``estimate`` and ``true_pose`` (3,) m, m, rad.
        """
        node = len(self)
        if node == len(self._estimate):
            self._estimate, self._true_pose = _twice(self._estimate), _twice(self._true_pose)
            self._buckets = _bucketed(self._estimate, node)
            self._ways = self._ways._replace(newest=_twice(self._ways.newest))
        self._estimate[node] = estimate
        self._ways.newest[node] = -1
        _insert(self._estimate, self._buckets, node)
        self._true_pose[node] = true_pose
        self.part.append(part)
        self.lane.append(lane)
        self.visits.append((time, node))
        self._near = np.append(self._near, node)
        return node

    def add_edge(self, a: int, b: int) -> None:
        """Join two nodes."""
        edge = self._edge_count
        if edge == len(self._ways.edges):
            edges, length, newest, older = self._ways
            self._ways = Ways(_twice(edges), _twice(length), newest, _twice(older))
        edges, length, newest, older = self._ways
        edges[edge] = min(a, b), max(a, b)
        x, y = self._estimate[a, :2] - self._estimate[b, :2]
        length[edge] = math.sqrt(x * x + y * y) + 1e-6
        for entry, node in enumerate(edges[edge].tolist(), start=2 * edge):
            older[entry], newest[node] = newest[node], entry
        self._edge_count += 1

    def joins(self, first: int) -> bool:
        """Whether an edge joins the nodes from ``first`` on to older ones."""
        return bool((self.edges[self._edges_before(first) :, 0] < first).any())

    def bar(self, point: Floats, radius: float) -> None:
        """Make ways along the edges within ``radius`` m of a point (2,), m, longer.

        They stay in the map: where there is no other way, it is tried again.
        """
        start = self.position[self.edges[:, 0]]
        along, offset = self.position[self.edges[:, 1]] - start, point - start
        share = (offset * along).sum(axis=1) / np.maximum((along * along).sum(axis=1), 1e-12)
        gap = offset - np.clip(share, 0.0, 1.0)[:, None] * along
        self._ways.length[: self._edge_count][np.hypot(*gap.T) < radius] += _TOLL

    def remove_from(self, first: int) -> None:
        """Forget the nodes from ``first`` on, and their edges: the last ones made."""
        for node in range(len(self) - 1, first - 1, -1):
            _remove(self._estimate, self._buckets, node)
        del self.part[first:]
        del self.lane[first:]
        self._remove_edges(self._edges_before(first))
        self.visits = [visit for visit in self.visits if visit[1] < first]
        self._near = self._near[self._near < first]

    def _edges_before(self, first: int) -> int:
        """How many edges join nodes before ``first``: they are older than all others."""
        return bisect.bisect_left(self.edges[:, 1], first)

    def _remove_edges(self, first: int) -> None:
        """Forget the edges from ``first`` on."""
        for entry in range(2 * self._edge_count - 1, 2 * first - 1, -1):
            node = self._ways.edges[entry // 2, entry % 2]
            self._ways.newest[node] = self._ways.older[entry]
        self._edge_count = first

    def visit(self, places: Floats, times: Floats, radius: float) -> None:
        """Record a visit of every node whose neighbourhood the robot enters.

        Parameters
        ----------
        places : array, shape (t, 2 or more)
            Where the robot was in the last time steps, m.
        times : array, shape (t,)
            s.
        """
        steps, nodes, self._near = _entered(
            self.table(), np.ascontiguousarray(places), radius, self._near
        )
        self.visits.extend(zip(times[steps].tolist(), nodes.tolist(), strict=True))

    def distances(self, points: Floats, running_lane: int = -1) -> Floats:
        """Distance of points (m, 2) to the nearest node, m; ``inf`` where none is within 1 m.

        The nodes of ``running_lane`` are left out.
        """
        return _distances(self.table(running_lane), np.ascontiguousarray(points))

    def table(self, running_lane: int = -1) -> Table:
        """The nodes as the compiled loops take them, those of ``running_lane`` marked as new."""
        older = len(self)
        if running_lane >= 0 and self.lane and self.lane[-1] == running_lane:
            # Lanes are numbered in order, and only the running, last one is left out.
            older = bisect.bisect_left(self.lane, running_lane)
        return Table(self._estimate, self._true_pose, self._buckets, len(self), older)

    def within(self, point: Floats, radius: float) -> NDArray[np.int64]:
        """Nodes at most ``radius`` m from ``point``, nearest first."""
        if np.isfinite(radius):
            return nearest_first(self.table(), point[0], point[1], radius)
        gap = self.position - point[:2]
        return np.argsort((gap * gap).sum(axis=1), kind="stable")

    def routes(self, start: int, goal: int = -1) -> tuple[Floats, Nodes]:
        """Dijkstra from ``start``: path length, m, to every node, and predecessors, (n,) each.

        A node without a path has the length ``inf``; it and ``start`` have a
        negative predecessor. With a ``goal`` only the path to it is sought.
        """
        return shortest(self._ways, len(self), start, goal)


def _twice(rows: Array) -> Array:
    """The same rows, and as many of zeros."""
    return cast(Array, np.concatenate([rows, np.zeros_like(rows)]))


_SIDE = 0.4
"""Of the square cells that nodes are looked up by, m."""
_FAR = 1.0
"""The nearest node is not looked for beyond, m."""


class _Buckets(NamedTuple):
    """Nodes by the cell that they lie in, as linked lists of the newest first.

    ``first`` (n,): the newest node of a bucket, -1 for none; ``following`` (n,): the next
    older one. Cells far apart may share a bucket: distances are always checked.
    """

    first: NDArray[np.int64]
    following: NDArray[np.int64]


class Table(NamedTuple):
    """Nodes; the first ``total`` rows are in use.

    ``estimate``, ``true_pose`` (n, 3), see `MapGraph`; the first ``older`` nodes belong
    to other lanes than the running one.
    """

    estimate: Floats
    true_pose: Floats
    buckets: _Buckets
    total: int
    older: int


@compiled
def _bucketed(nodes: Floats, count: int) -> _Buckets:
    """The first ``count`` nodes, and room for the others."""
    buckets = _Buckets(np.full(len(nodes), -1), np.zeros(len(nodes), np.int64))
    for node in range(count):
        _insert(nodes, buckets, node)
    return buckets


@compiled
def _bucket(buckets: _Buckets, i: int, j: int) -> int:
    return (i * 73856093 ^ j * 19349663) % len(buckets.first)


@compiled
def _bucket_of(nodes: Floats, buckets: _Buckets, node: int) -> int:
    x, y = nodes[node, 0], nodes[node, 1]
    return _bucket(buckets, math.floor(x / _SIDE), math.floor(y / _SIDE))


@compiled
def _insert(nodes: Floats, buckets: _Buckets, node: int) -> None:
    """Put a new node in front of its bucket's list."""
    bucket = _bucket_of(nodes, buckets, node)
    buckets.following[node] = buckets.first[bucket]
    buckets.first[bucket] = node


@compiled
def _remove(nodes: Floats, buckets: _Buckets, node: int) -> None:
    """Take the newest node out again."""
    buckets.first[_bucket_of(nodes, buckets, node)] = buckets.following[node]


@compiled
def _within(table: Table, x: float, y: float, radius: float) -> Nodes:
    """Indices of the nodes that are at most ``radius`` m from a point, in any order."""
    nodes, buckets = table.estimate, table.buckets
    near = np.empty(table.total, np.int64)
    found = 0
    for i in range(math.floor((x - radius) / _SIDE), math.floor((x + radius) / _SIDE) + 1):
        for j in range(math.floor((y - radius) / _SIDE), math.floor((y + radius) / _SIDE) + 1):
            node = buckets.first[_bucket(buckets, i, j)]
            while node >= 0:
                u, v = nodes[node, 0], nodes[node, 1]
                here = math.floor(u / _SIDE) == i and math.floor(v / _SIDE) == j
                if here and (u - x) * (u - x) + (v - y) * (v - y) <= radius * radius:
                    near[found] = node
                    found += 1
                node = buckets.following[node]
    return near[:found]


@compiled
def is_near(table: Table, x: float, y: float, radius: float) -> bool:
    """Whether a node is at most ``radius`` m from a point."""
    nodes, buckets = table.estimate, table.buckets
    for i in range(math.floor((x - radius) / _SIDE), math.floor((x + radius) / _SIDE) + 1):
        for j in range(math.floor((y - radius) / _SIDE), math.floor((y + radius) / _SIDE) + 1):
            node = buckets.first[_bucket(buckets, i, j)]
            while node >= 0:
                u, v = nodes[node, 0] - x, nodes[node, 1] - y
                if u * u + v * v <= radius * radius:
                    return True
                node = buckets.following[node]
    return False


@compiled
def nearest_first(table: Table, x: float, y: float, radius: float) -> Nodes:
    """Indices of the nodes that are at most ``radius`` m from a point, nearest first."""
    near = _within(table, x, y, radius)
    squared = np.empty(len(near))
    for k in range(len(near)):
        u, v = table.estimate[near[k], 0] - x, table.estimate[near[k], 1] - y
        squared[k] = u * u + v * v
    sort_by(squared, near)
    return near


@compiled
def sort_by(keys: Floats, indices: Nodes) -> None:
    """Sort a few indices by their keys, equal keys by the index; both in place."""
    for k in range(1, len(keys)):
        key, index = keys[k], indices[k]
        place = k
        while place > 0 and (keys[place - 1], indices[place - 1]) > (key, index):
            keys[place], indices[place] = keys[place - 1], indices[place - 1]
            place -= 1
        keys[place], indices[place] = key, index


@compiled
def _entered(
    table: Table, places: Floats, radius: float, near: Nodes
) -> tuple[Nodes, Nodes, Nodes]:
    """Steps at which, and nodes that, the robot came within ``radius`` m of.

    ``near``: the nodes that it was near before; the third result: those at the end.
    """
    steps, nodes = [0 for _ in range(0)], [0 for _ in range(0)]
    for k in range(len(places)):
        now = _within(table, places[k, 0], places[k, 1], radius)
        for node in now:
            if not (near == node).any():
                steps.append(k)
                nodes.append(node)
        near = now
    return np.array(steps, np.int64), np.array(nodes, np.int64), near


@compiled
def _distances(table: Table, points: Floats) -> Floats:
    """Distance from points (m, 2) to the nearest node that is not new, m."""
    distance = np.full(len(points), np.inf)
    for k in range(len(points)):
        distance[k] = distance_at(table, points[k, 0], points[k, 1], _FAR)
    return distance


@compiled
def distance_at(table: Table, x: float, y: float, limit: float) -> float:
    """Distance from a point to the nearest node that is not new, m; ``inf`` beyond a limit."""
    nodes, buckets = table.estimate, table.buckets
    best = np.inf
    for i in range(math.floor((x - limit) / _SIDE), math.floor((x + limit) / _SIDE) + 1):
        for j in range(math.floor((y - limit) / _SIDE), math.floor((y + limit) / _SIDE) + 1):
            node = buckets.first[_bucket(buckets, i, j)]
            while node >= 0:
                u, v = nodes[node, 0] - x, nodes[node, 1] - y
                if node < table.older and u * u + v * v <= limit * limit:
                    best = min(best, math.sqrt(u * u + v * v))
                node = buckets.following[node]
    return best
