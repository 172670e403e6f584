"""The topo-metric map while it grows: nodes, edges, visits, shortest paths (§2.1)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from simulator.compiled import compiled

__all__ = ["MapGraph"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


class MapGraph:
    """Growing arrays; node k is row k of everything."""

    def __init__(self) -> None:
        self._estimate = np.zeros((256, 3))
        self._true_pose = np.zeros((256, 5))
        self.part: list[int] = []
        self.lane: list[int] = []
        self._edges = np.zeros((256, 2), np.int32)
        self._edge_count = 0
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
        self._estimate[node] = estimate
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

    def remove_from(self, first: int) -> None:
        """Forget the nodes from ``first`` on."""
        del self.part[first:]
        del self.lane[first:]
        kept = self.edges[self.edges[:, 1] < first]
        self._edge_count = len(kept)
        self._edges[: len(kept)] = kept
        self.visits = [visit for visit in self.visits if visit[1] < first]
        self._near = {node for node in self._near if node < first}

    def visit(self, estimate: Floats, time: float, radius: float) -> None:
        """Record a visit of every node whose neighbourhood the robot now enters."""
        near = set(_within(self._estimate, len(self), estimate[0], estimate[1], radius).tolist())
        if not near <= self._near:
            self.visits.extend((time, node) for node in sorted(near - self._near))
        self._near = near

    def distances(self, points: Floats, running_lane: int = -1) -> Floats:
        """Distance of points (m, 2) to the nearest node, m; without the running lane's if given."""
        count = len(self)
        if running_lane >= 0 and self.lane and self.lane[-1] == running_lane:
            # A lane's nodes are consecutive, and only the running lane is left out.
            count = self.lane.index(running_lane)
        return _distances(self._estimate, count, np.ascontiguousarray(points))

    def within(self, point: Floats, radius: float) -> NDArray[np.int64]:
        """Nodes at most ``radius`` m from ``point``, nearest first."""
        near = _within(self._estimate, len(self), point[0], point[1], radius)
        gap = self._estimate[near, :2] - point[:2]
        order = np.argsort((gap * gap).sum(axis=1), kind="stable")
        return np.asarray(near[order])

    def weights(self) -> csr_array:
        """Sparse matrix of edge lengths, m, shape (n, n)."""
        n = len(self)
        if not self._edge_count:
            return csr_array((n, n))
        a, b = self.edges.T
        length = np.linalg.norm(self.position[a] - self.position[b], axis=1) + 1e-6
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


@compiled
def _within(nodes: Floats, count: int, x: float, y: float, radius: float) -> NDArray[np.int64]:
    """Indices of the first ``count`` nodes that are at most ``radius`` m from a point."""
    near = np.empty(count, np.int64)
    found = 0
    for k in range(count):
        off_x, off_y = nodes[k, 0] - x, nodes[k, 1] - y
        if off_x * off_x + off_y * off_y <= radius * radius:
            near[found] = k
            found += 1
    return near[:found].copy()


@compiled
def _distances(nodes: Floats, count: int, points: Floats) -> Floats:
    """Distance from points (m, 2) to the nearest of the first ``count`` nodes, m."""
    distance = np.full(len(points), np.inf)
    for i in range(len(points)):
        for k in range(count):
            off_x, off_y = nodes[k, 0] - points[i, 0], nodes[k, 1] - points[i, 1]
            distance[i] = min(distance[i], off_x * off_x + off_y * off_y)
        distance[i] = math.sqrt(distance[i])
    return distance
