"""Figures of the map graph and of its rooms (Figs. 4 to 6, 12, 22 to 25, 27, 29)."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import linear_sum_assignment

from dataset.topomap import Nodes, TopoMap
from roomseg.figures.plans import (
    Frame,
    Plan,
    draw_circles,
    draw_obstacle_points,
    draw_outlines,
    node_positions,
)
from roomseg.figures.style import (
    BORDER_BLACK,
    BORDER_EDGE_GREEN,
    EDGE_RED,
    INK,
    finish_plan,
    room_colours,
)

__all__ = ["draw_borders", "draw_graph", "draw_rooms", "match_rooms", "wrong_nodes"]

Ints = NDArray[np.int64]

_NODE_DIAMETER = 0.13
"""Of the circle drawn for a node, m; less than half the lane spacing."""
WRONG_RING, RING_SHARE = 0.9, 0.25
"""Width of the black ring around a node in a wrong room, pt, at most; of the node's diameter."""
ALIKE = 0.1
"""Least intersection over union of two rooms that have the same name."""
_RING, _RIM = (0.0, 0.0, 0.0, 1.0), (1.0, 1.0, 1.0, 0.7)


def match_rooms(predicted: ArrayLike, truth: ArrayLike) -> Ints:
    """Rename predicted rooms so that they share as many nodes as possible with true ones.

    What the authors of Fig. 22 did by hand: the one-to-one assignment of labels
    that maximises the number of agreeing nodes. Predicted rooms left over, and those that
    share next to nothing with their partner (intersection over union below `ALIKE`), are
    named by the integers above every true label.

    Parameters
    ----------
    predicted, truth : array, shape (n,)
        Room labels, any integers.

    Returns
    -------
    array, shape (n,)
        ``predicted``, renamed.

    Raises
    ------
    ValueError
        If the two differ in length.
    """
    guess, real = np.asarray(predicted), np.asarray(truth)
    if guess.shape != real.shape or guess.ndim != 1:
        raise ValueError(f"predicted: shape {guess.shape}, expected {real.shape}, one per node")
    if not len(guess):
        return guess.astype(np.int64)
    guess_labels, guess_index = np.unique(guess, return_inverse=True)
    real_labels, real_index = np.unique(real, return_inverse=True)
    overlap = np.zeros((len(guess_labels), len(real_labels)), dtype=np.int64)
    np.add.at(overlap, (guess_index, real_index), 1)
    rows, columns = linear_sum_assignment(overlap, maximize=True)
    union = overlap.sum(1)[rows] + overlap.sum(0)[columns] - overlap[rows, columns]
    alike = overlap[rows, columns] >= ALIKE * union
    rows, columns = rows[alike], columns[alike]
    names = np.full(len(guess_labels), -1, dtype=np.int64)
    names[rows] = real_labels[columns]
    spare = np.setdiff1d(np.arange(len(guess_labels)), rows)
    names[spare] = int(real_labels.max()) + 1 + np.arange(len(spare))
    return names[guess_index]


def wrong_nodes(predicted: ArrayLike, truth: ArrayLike) -> NDArray[np.bool_]:
    """Nodes whose matched predicted room is not their true one, shape (n,)."""
    return np.not_equal(match_rooms(predicted, truth), np.asarray(truth))


def draw_borders(ax: Any, borders: NDArray[np.float64]) -> None:
    """Draw room borders as black dashed lines (Fig. 5); ``borders`` (b, 2, 2), m."""
    lines = LineCollection(
        list(borders),
        colors=BORDER_BLACK,
        linewidths=0.9,
        linestyles=(0, (4.0, 1.6)),
        gid="borders",
        zorder=4,
    )
    ax.add_collection(lines)
    ax.autoscale_view()


def _graph_frame(topomap: TopoMap) -> Frame:
    """Choose the frame in which the borders lie, so that they cross the edges drawn."""
    if topomap.nodes.true_pose is None:
        return "map"
    truth = topomap.ground_truth
    return "map" if truth is not None and truth.frame == "map" else "scene"


def draw_graph(
    ax: Any,
    topomap: TopoMap,
    *,
    edges: ArrayLike | None = None,
    is_border: ArrayLike | None = None,
    outlines: Plan | None = None,
    title: str | None = None,
    bar: float | None = None,
) -> None:
    """Draw the map graph: edges red, those classified as border green, true borders black.

    Fig. 4 with all edges, Fig. 5 with ``edges`` after preprocessing, Fig. 12
    with ``is_border`` from the classifier as well.

    Parameters
    ----------
    edges : array, shape (e', 2), optional
        Node indices; all edges of the map if absent.
    is_border : array of bool, shape (e',), optional
        Edges to draw as border edges.
    outlines : Plan, optional
        Drawn faintly, in the scene frame only.
    """
    pairs = topomap.edges if edges is None else np.asarray(edges)
    marked = np.zeros(len(pairs), bool) if is_border is None else np.asarray(is_border, bool)
    if marked.shape != (len(pairs),):
        raise ValueError(f"is_border: shape {marked.shape}, expected ({len(pairs)},)")
    frame = _graph_frame(topomap)
    if outlines is not None and frame == "scene":
        draw_outlines(ax, outlines, linewidth=0.5, alpha=0.45)
    segments = node_positions(topomap.nodes, frame)[pairs]
    ax.add_collection(
        LineCollection(
            list(segments[~marked]), colors=EDGE_RED, linewidths=0.45, gid="edges", zorder=3
        )
    )
    if marked.any():
        _draw_border_edges(ax, segments[marked])
    if topomap.ground_truth is not None:
        draw_borders(ax, topomap.ground_truth.borders)
    ax.autoscale_view()
    finish_plan(ax, title, bar)


def _draw_border_edges(ax: Any, segments: NDArray[np.float64]) -> None:
    lines = LineCollection(
        list(segments),
        colors=BORDER_EDGE_GREEN,
        linewidths=1.6,
        linestyles=(0, (1.6, 0.7)),
        gid="border-edges",
        zorder=5,
    )
    ax.add_collection(lines)


def draw_rooms(
    ax: Any,
    nodes: Nodes,
    room: ArrayLike,
    *,
    truth: ArrayLike | None = None,
    points: NDArray[np.float64] | None = None,
    outlines: Plan | None = None,
    title: str | None = None,
    bar: float | None = None,
) -> None:
    """Draw nodes as circles coloured by room, obstacles as blue lines (Fig. 22).

    True positions if there are any; else the estimates with the obstacle
    points as rings (Fig. 25).

    Parameters
    ----------
    nodes : Nodes
    room : array, shape (n,)
        Room label of each node.
    truth : array, shape (n,), optional
        True rooms. ``room`` takes their colours by `match_rooms`, and nodes in
        a wrong room get a black ring.
    points : array, shape (k, 2), optional
        Obstacle points in the estimate's frame, m.
    outlines : Plan, optional
        Of obstacles, in the scene frame.
    """
    labels = np.asarray(room)
    if labels.shape != (len(nodes),):
        raise ValueError(f"room: shape {labels.shape}, expected ({len(nodes)},)")
    wrong = np.zeros(len(labels), dtype=bool)
    if truth is not None:
        real = np.asarray(truth)
        labels, wrong = match_rooms(labels, real), wrong_nodes(labels, real)
    if nodes.true_pose is None:
        if points is not None:
            draw_obstacle_points(ax, points)
    elif outlines is not None:
        draw_outlines(ax, outlines)
    reference = labels if truth is None else np.concatenate([np.asarray(truth), labels])
    _scatter_rooms(ax, node_positions(nodes), labels, np.unique(reference), wrong)
    finish_plan(ax, title, bar)


def _scatter_rooms(
    ax: Any,
    position: NDArray[np.float64],
    labels: Ints,
    names: Ints,
    wrong: NDArray[np.bool_],
) -> None:
    """One collection per room, so that artists and rooms correspond, and its number on top."""
    colours = room_colours(len(names))
    ring = min(WRONG_RING, RING_SHARE * _NODE_DIAMETER * _points_per_metre(ax, position))
    for index, name in enumerate(names):
        inside = labels == name
        if not inside.any():
            continue
        circles = draw_circles(ax, position[inside], _NODE_DIAMETER)
        circles.set(facecolor=colours[index], gid=f"room-{name}", zorder=3)
        circles.set_edgecolor(np.where(wrong[inside, None], _RING, _RIM))
        circles.set_linewidth(np.where(wrong[inside], ring, min(0.35, 0.4 * ring)))
        _number_room(ax, position[inside], index + 1)


def _points_per_metre(ax: Any, position: NDArray[np.float64]) -> float:
    """About how large a metre will be drawn when these positions fill the axes."""
    box = ax.get_window_extent()
    size = np.array([box.width, box.height]) * 72.0 / ax.figure.dpi
    return float((size / np.maximum(np.ptp(position, axis=0), 1.0)).min())


def _number_room(ax: Any, position: NDArray[np.float64], number: int) -> None:
    """Write the number at the node nearest to the room's median, which lies inside it."""
    middle = np.median(position, axis=0)
    nearest = position[np.argmin(np.linalg.norm(position - middle, axis=1))]
    ax.text(
        *nearest,
        str(number),
        ha="center",
        va="center",
        fontsize=10,
        fontweight="bold",
        color=INK,
        path_effects=[withStroke(linewidth=2.5, foreground="white")],
        zorder=6,
    )
