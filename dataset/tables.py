"""A map's arrays as named columns: for NumPy, for pandas, for graphs and tables of others."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dataset.errors import RoomsegError
from dataset.topomap import TopoMap

__all__ = ["Columns", "data_frame", "edge_columns", "node_columns", "obstacle_columns"]

Columns = dict[str, NDArray[Any]]
"""Arrays of one length by the names of what they hold; SI units, rad."""


def node_columns(topomap: TopoMap, found_room: NDArray[np.int32] | None = None) -> Columns:
    """What the map knows of each node.

    Parameters
    ----------
    topomap : TopoMap
    found_room : array, shape (n,), optional
        A segmentation's labels.

    Returns
    -------
    dict of arrays, shape (n,)
        ``x``, ``y`` m, ``heading`` rad, ``part``, ``lane``, ``created`` s (NaN without a
        visit), ``visits``; and what is there of ``true_x``, ``true_y``,
        ``true_heading``, ``roll``, ``pitch``, ``room`` (ground truth), ``found_room``.
    """
    nodes, truth = topomap.nodes, topomap.ground_truth
    created = np.full(len(nodes), np.inf)
    np.minimum.at(created, topomap.visits.node, topomap.visits.time)
    columns: Columns = {
        "x": nodes.position[:, 0],
        "y": nodes.position[:, 1],
        "heading": nodes.heading,
        "part": nodes.part,
        "lane": nodes.lane,
        "created": np.where(np.isfinite(created), created, np.nan),
        "visits": np.bincount(topomap.visits.node, minlength=len(nodes)),
    }
    if nodes.true_pose is not None:
        columns |= dict(zip(("true_x", "true_y", "true_heading"), nodes.true_pose.T, strict=True))
    if nodes.tilt is not None:
        columns |= dict(zip(("roll", "pitch"), nodes.tilt.T, strict=True))
    if truth is not None and truth.room is not None:
        columns["room"] = truth.room
    if found_room is not None:
        columns["found_room"] = found_room
    return columns


def edge_columns(topomap: TopoMap) -> Columns:
    """Both nodes of each edge, its ``length`` in m, and whether it crosses a ``border``.

    Returns
    -------
    dict of arrays, shape (e,)
        ``border`` only where there is a ground truth.
    """
    first, second = topomap.edges.T
    columns: Columns = {"first": first, "second": second, "length": topomap.edge_lengths()}
    if topomap.ground_truth is not None:
        columns["border"] = topomap.ground_truth.edge_is_border
    return columns


def obstacle_columns(topomap: TopoMap) -> Columns:
    """Place ``x``, ``y`` in m, ``time`` in s and ``beam`` of each obstacle point."""
    points = topomap.obstacles
    x, y = points.position.T
    return {"x": x, "y": y, "time": points.time, "beam": points.beam}


def data_frame(columns: Columns, index: str) -> Any:
    """A `pandas.DataFrame` of columns, its index called ``index``.

    Raises
    ------
    RoomsegError
        If pandas is not installed.
    """
    try:
        pandas = importlib.import_module("pandas")
    except ImportError as error:
        raise RoomsegError(
            f"a table needs the package pandas ({error}): pip install 'roomseg[pandas]'"
        ) from error
    frame = pandas.DataFrame(columns)
    frame.index.name = index
    return frame
