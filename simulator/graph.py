"""The topo-metric map while it grows: nodes, edges, visits, shortest paths (§2.1)."""

from __future__ import annotations

import bisect
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from simulator.compiled import compiled

__all__ = ["MapGraph"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Nodes = NDArray[np.int64]

_TOLL = 5.0
"""A way through a place that barred the robot counts as so much longer, m."""


class MapGraph:
    """Growing arrays; node k is row k of everything."""

    def __init__(self) -> None:
        self._estimate = np.zeros((256, 3))
        self._true_pose = np.zeros((256, 5))
        self.part: list[int] = []
        self.lane: list[int] = []
        self._buckets = _Buckets(np.full(_BUCKETS, -1), np.zeros(256, np.int64))
        self._edges = np.zeros((256, 2), np.int32)
        self._edge_count = 0
        self._barred: list[int] = []
        self.visits: list[tuple[float, int]] = []
        self._near: set[int] = set()

    def __len__(self) -> int:
        return len(self.part)

    @property
    def edges(self) -> Ints:
        """Node pairs (e, 2), the smaller first, in order of creation."""
        return self._edges[: self._edge_count]

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
        return self._true_pose[: len(self), :3]

    @property
    def tilt(self) -> Floats:
        """True roll and pitch at all nodes, shape (n, 2), rad; for the record only."""
        return self._true_pose[: len(self), 3:]

    def add_node(
        self, estimate: Floats, true_pose: Floats, part: int, lane: int, time: float
    ) -> int:
        """Append a node, visited now; returns its index.

        ``estimate`` (3,) m, m, rad; ``true_pose`` (5,), with roll and pitch.
        """
        node = len(self)
        if node == len(self._estimate):
            self._estimate = np.concatenate([self._estimate, np.zeros_like(self._estimate)])
            self._true_pose = np.concatenate([self._true_pose, np.zeros_like(self._true_pose)])
            first, following = self._buckets
            following = np.concatenate([following, np.zeros_like(following)])
            self._buckets = _Buckets(first, following)
        self._estimate[node] = estimate
        _insert(self._estimate, self._buckets, node)
        self._true_pose[node] = true_pose
        self.part.append(part)
        self.lane.append(lane)
        self.visits.append((time, node))
        self._near.add(node)
        return node

    def add_edge(self, a: int, b: int) -> None:
        """Join two nodes."""
        if self._edge_count == len(self._edges):
            self._edges = np.concatenate([self._edges, np.zeros_like(self._edges)])
        self._edges[self._edge_count] = min(a, b), max(a, b)
        self._edge_count += 1

    def joins(self, first: int) -> bool:
        """Whether an edge joins the nodes from ``first`` on to older ones."""
        return bool(((self.edges[:, 0] < first) & (self.edges[:, 1] >= first)).any())

    def bar(self, point: Floats, radius: float) -> None:
        """Make ways along the edges within ``radius`` m of a point (2,), m, longer.

        They stay in the map: where there is no other way, it is tried again.
        """
        start = self.position[self.edges[:, 0]]
        along, offset = self.position[self.edges[:, 1]] - start, point - start
        share = (offset * along).sum(axis=1) / np.maximum((along * along).sum(axis=1), 1e-12)
        gap = offset - np.clip(share, 0.0, 1.0)[:, None] * along
        self._barred.extend(np.flatnonzero(np.hypot(*gap.T) < radius).tolist())

    def remove_from(self, first: int) -> None:
        """Forget the nodes from ``first`` on, and their edges: the last ones made."""
        for node in range(len(self) - 1, first - 1, -1):
            _remove(self._estimate, self._buckets, node)
        del self.part[first:]
        del self.lane[first:]
        kept = self.edges[self.edges[:, 1] < first]
        self._edge_count = len(kept)
        self._edges[: len(kept)] = kept
        self._barred = [edge for edge in self._barred if edge < len(kept)]
        self.visits = [visit for visit in self.visits if visit[1] < first]
        self._near = {node for node in self._near if node < first}

    def visit(self, estimate: Floats, time: float, radius: float) -> None:
        """Record a visit of every node whose neighbourhood the robot now enters."""
        found = _within(self._estimate, self._buckets, estimate[0], estimate[1], radius)
        near = set(found.tolist())
        if not near <= self._near:
            self.visits.extend((time, node) for node in sorted(near - self._near))
        self._near = near

    def distances(self, points: Floats, running_lane: int = -1) -> Floats:
        """Distance of points (m, 2) to the nearest node, m; ``inf`` where none is within 1 m.

        The nodes of ``running_lane`` are left out.
        """
        count = len(self)
        if running_lane >= 0 and self.lane and self.lane[-1] == running_lane:
            # Lanes are numbered in order, and only the running, last one is left out.
            count = bisect.bisect_left(self.lane, running_lane)
        return _distances(self._estimate, self._buckets, count, np.ascontiguousarray(points))

    def within(self, point: Floats, radius: float) -> NDArray[np.int64]:
        """Nodes at most ``radius`` m from ``point``, nearest first."""
        if np.isfinite(radius):
            near = _within(self._estimate, self._buckets, point[0], point[1], radius)
        else:
            near = np.arange(len(self))
        gap = self._estimate[near, :2] - point[:2]
        order = np.argsort((gap * gap).sum(axis=1), kind="stable")
        return np.asarray(near[order])

    def weights(self) -> csr_array:
        """Sparse matrix of edge lengths with tolls (`bar`), m, shape (n, n)."""
        n = len(self)
        if not self._edge_count:
            return csr_array((n, n))
        a, b = self.edges.T
        length = np.linalg.norm(self.position[a] - self.position[b], axis=1) + 1e-6
        np.add.at(length, self._barred, _TOLL)
        return csr_array((length, (a, b)), shape=(n, n))

    def routes(self, start: int) -> tuple[Floats, Ints]:
        """Dijkstra from ``start``: path length, m, to every node, and predecessors, (n,) each.

        A node without a path has the length ``inf``; it and ``start`` have a
        negative predecessor.
        """
        length, previous = dijkstra(
            self.weights(), directed=False, indices=start, return_predecessors=True
        )
        return np.asarray(length), np.asarray(previous)


_BUCKETS = 4096
"""Of a hash table of square cells."""
_SIDE = 0.4
"""Of the cells, m."""
_FAR = 1.0
"""The nearest node is not looked for beyond, m."""


class _Buckets(NamedTuple):
    """Nodes by the cell that they lie in, as linked lists of the newest first.

    ``first`` (_BUCKETS,): the newest node of a bucket, -1 for none; ``following`` (n,):
    the next older one. Cells far apart may share a bucket: distances are always checked.
    """

    first: NDArray[np.int64]
    following: NDArray[np.int64]


@compiled
def _bucket(i: int, j: int) -> int:
    return (i * 73856093 ^ j * 19349663) % _BUCKETS


@compiled
def _insert(nodes: Floats, buckets: _Buckets, node: int) -> None:
    """Put a new node in front of its bucket's list."""
    bucket = _bucket(math.floor(nodes[node, 0] / _SIDE), math.floor(nodes[node, 1] / _SIDE))
    buckets.following[node] = buckets.first[bucket]
    buckets.first[bucket] = node


@compiled
def _remove(nodes: Floats, buckets: _Buckets, node: int) -> None:
    """Take the newest node out again."""
    bucket = _bucket(math.floor(nodes[node, 0] / _SIDE), math.floor(nodes[node, 1] / _SIDE))
    buckets.first[bucket] = buckets.following[node]


@compiled
def _within(nodes: Floats, buckets: _Buckets, x: float, y: float, radius: float) -> Nodes:
    """Indices of the nodes that are at most ``radius`` m from a point, in order."""
    near = np.empty(len(nodes), np.int64)
    found = 0
    for i in range(math.floor((x - radius) / _SIDE), math.floor((x + radius) / _SIDE) + 1):
        for j in range(math.floor((y - radius) / _SIDE), math.floor((y + radius) / _SIDE) + 1):
            node = buckets.first[_bucket(i, j)]
            while node >= 0:
                u, v = nodes[node, 0], nodes[node, 1]
                here = math.floor(u / _SIDE) == i and math.floor(v / _SIDE) == j
                if here and (u - x) * (u - x) + (v - y) * (v - y) <= radius * radius:
                    near[found] = node
                    found += 1
                node = buckets.following[node]
    return np.sort(near[:found])


@compiled
def _distances(nodes: Floats, buckets: _Buckets, count: int, points: Floats) -> Floats:
    """Distance from points (m, 2) to the nearest of the first ``count`` nodes, m."""
    distance = np.full(len(points), np.inf)
    for k in range(len(points)):
        x, y = points[k, 0], points[k, 1]
        for i in range(math.floor((x - _FAR) / _SIDE), math.floor((x + _FAR) / _SIDE) + 1):
            for j in range(math.floor((y - _FAR) / _SIDE), math.floor((y + _FAR) / _SIDE) + 1):
                node = buckets.first[_bucket(i, j)]
                while node >= 0:
                    u, v = nodes[node, 0] - x, nodes[node, 1] - y
                    if node < count and u * u + v * v <= _FAR * _FAR:
                        distance[k] = min(distance[k], math.sqrt(u * u + v * v))
                    node = buckets.following[node]
    return distance
