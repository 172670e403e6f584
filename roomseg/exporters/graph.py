"""The map graph for `networkx`, and as GraphML and node-link JSON."""

from __future__ import annotations

import json
import math
import re

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from dataset.tables import Columns, edge_columns, node_columns
from dataset.topomap import TopoMap

__all__ = ["graph_of", "graphml", "node_link_json"]

NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML cannot hold."""


def graph_of(topomap: TopoMap, found_room: NDArray[np.int32] | None = None) -> nx.Graph:
    """The map graph with all edges (Fig. 4), as Python's own numbers.

    Parameters
    ----------
    topomap : TopoMap
    found_room : array, shape (n,), optional
        A segmentation's labels.

    Returns
    -------
    networkx.Graph
        Nodes 0 .. n - 1 and edges with the columns of `dataset.tables`; the map's name,
        run, seed, date and robot radius (m) as attributes of the graph.
    """
    graph = nx.Graph(
        environment=topomap.environment,
        run=topomap.run,
        seed=int(topomap.seed),
        created=topomap.created,
        software=topomap.software,
        robot_radius=float(topomap.robot_radius),
    )
    if topomap.ground_truth is not None:
        graph.graph["room_count"] = int(topomap.ground_truth.room_count)
    graph.add_nodes_from(enumerate(_rows(node_columns(topomap, found_room))))
    columns = edge_columns(topomap)
    ends = zip(columns.pop("first").tolist(), columns.pop("second").tolist(), strict=True)
    graph.add_edges_from((a, b, row) for (a, b), row in zip(ends, _rows(columns), strict=True))
    return graph


def _rows(columns: Columns) -> list[dict[str, object]]:
    """One dict of Python's own numbers for each row; what is NaN is left out."""
    names = list(columns)
    values = zip(*(column.tolist() for column in columns.values()), strict=True)
    return [
        {name: value for name, value in zip(names, row, strict=True) if not math.isnan(value)}
        for row in values
    ]


def graphml(graph: nx.Graph) -> str:
    """GraphML text; characters that XML cannot hold become U+FFFD."""
    plain = nx.Graph(graph)
    for name, value in plain.graph.items():
        if isinstance(value, str):
            plain.graph[name] = NOT_XML.sub("\ufffd", value)
    return "\n".join(nx.generate_graphml(plain)) + "\n"


def node_link_json(graph: nx.Graph) -> str:
    """Node-link JSON as `networkx.node_link_graph` reads it; one node or edge a line."""
    data = nx.node_link_data(graph, edges="edges")
    head = {key: value for key, value in data.items() if key not in ("nodes", "edges")}
    parts = [json.dumps(head, ensure_ascii=False)[:-1]]
    for key in ("nodes", "edges"):
        lines = ",\n".join(json.dumps(item) for item in data[key])
        parts.append(f'"{key}": [\n{lines}\n]')
    return ", ".join(parts) + "}\n"
