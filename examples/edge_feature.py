"""Add an edge feature of your own to those of the paper, and see what it is good for.

The feature here: how many obstacle points lie within 0.5 m of an edge's middle. Change
`obstacle_count`; a feature is one number for each edge of the preprocessed graph.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

import dataset
from dataset import TopoMap
from roomseg.evaluation import judge, train_on
from roomseg.features import SUBSETS, EdgeFeatures, edge_features
from roomseg.labelled_map import LabelledMap
from roomseg.metrics import feature_quality
from roomseg.preprocessing import MapGraph


def obstacle_count(topomap: TopoMap, graph: MapGraph) -> np.ndarray:
    """Obstacle points within 0.5 m of the middle of each edge, shape (e',)."""
    middles = topomap.nodes.position[graph.edges].mean(axis=1)
    points = KDTree(topomap.obstacles.position)
    return points.query_ball_point(middles, 0.5, return_length=True).astype(float)


def with_my_feature(features: EdgeFeatures, topomap: TopoMap) -> EdgeFeatures:
    column = obstacle_count(topomap, features.graph)
    values = np.column_stack([features.values, column])
    return EdgeFeatures(features.graph, values, (*features.names, "obstacle_count"))


def labelled(path: Path, *, mine: bool) -> LabelledMap:
    with dataset.open(path) as m:
        features = edge_features(m, SUBSETS["no-camera"])
        return LabelledMap.of(m.topomap, with_my_feature(features, m.topomap) if mine else features)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("maps", nargs="+", type=Path, help="the last one is the test")
    arguments = parser.parse_args()
    for mine in (False, True):
        *training, test = [labelled(path, mine=mine) for path in arguments.maps]
        result = judge(test, train_on(training))
        names = ", ".join(test.features.names)
        print(f"{names}: impurity {100 * result.quality.impurity:.2f} %")
    quality = feature_quality(test.features.values[:, -1], test.is_border)
    print(f"obstacle_count alone: {quality}")


if __name__ == "__main__":
    main()
