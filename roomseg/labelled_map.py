"""A map as the experiments need it: edge features and the truth, without images."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dataset.errors import FormatError
from dataset.topomap import Nodes, TopoMap
from roomseg.features import EdgeFeatures
from roomseg.ground_truth import known_truth

__all__ = ["LabelledMap", "MapSketch"]


@dataclass(frozen=True)
class MapSketch:
    """What figures show of a map besides its graph and rooms.

    Attributes
    ----------
    nodes : Nodes
        Estimates and, for a simulated map, true poses.
    obstacles : array, shape (k, 2)
        Laser points in the estimate's frame, m.
    scene : str, optional
        The apartment's JSON text.
    """

    nodes: Nodes
    obstacles: NDArray[np.float64]
    scene: str | None = None

    @classmethod
    def of(cls, topomap: TopoMap) -> MapSketch:
        """Take it from a map."""
        return cls(topomap.nodes, topomap.obstacles.position, topomap.scene)


@dataclass(frozen=True)
class LabelledMap:
    """The features of a map's edges with its ground truth.

    Attributes
    ----------
    environment, run : str
        Names of the place and of the run.
    features : EdgeFeatures
        Of the kept edges, with the map graph.
    is_border : array of bool, shape (e',)
        True border edges among the kept ones.
    room : array, shape (n,)
        True room of each node.
    room_count : int
        Number of rooms that the operator gave.
    sketch : MapSketch, optional
        For figures; the method needs none.

    Raises
    ------
    FormatError
        If the arrays do not fit the map graph.
    """

    environment: str
    run: str
    features: EdgeFeatures
    is_border: NDArray[np.bool_]
    room: NDArray[np.int32]
    room_count: int
    sketch: MapSketch | None = None

    def __post_init__(self) -> None:
        graph = self.features.graph
        expected = {"is_border": len(graph), "room": graph.node_count}
        for name, count in expected.items():
            if getattr(self, name).shape != (count,):
                shape = getattr(self, name).shape
                raise FormatError(f"{self.name}: {name}: shape {shape}, expected ({count},)")
        if self.sketch is not None and len(self.sketch.nodes) != graph.node_count:
            raise FormatError(
                f"{self.name}: sketch: {len(self.sketch.nodes)} nodes, expected {graph.node_count}"
            )

    @classmethod
    def of(cls, topomap: TopoMap, features: EdgeFeatures) -> LabelledMap:
        """Take the truth from a map whose edges have these features.

        Raises
        ------
        FormatError
            If the map's nodes have no room labels.
        """
        truth = known_truth(topomap)
        if truth.room is None:
            raise FormatError(
                f"{topomap.environment}/{topomap.run}: no ground_truth/room, "
                "expected room labels; label the map first"
            )
        return cls(
            topomap.environment,
            topomap.run,
            features,
            truth.edge_is_border[features.graph.kept],
            truth.room,
            truth.room_count,
            MapSketch.of(topomap),
        )

    @property
    def name(self) -> str:
        """Environment and run, which tell a map from all others."""
        return f"{self.environment}/{self.run}"
