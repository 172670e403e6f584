"""Maps of a feature set with made-up values that tell border edges more or less well."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from cleaned_flat import cleaned_flat

from roomseg.feature_set import MapFeatures
from roomseg.features import FEATURES, EdgeFeatures
from roomseg.labelled_map import LabelledMap
from roomseg.preprocessing import preprocess

SHARPNESS = np.linspace(1.0, 5.0, 42)
"""How well each combination of Table 2 tells borders; the last is the best."""


def map_features(environment: str, seed: int, run: str = "run1", scene: str | None = None):
    """Features of a cleaned flat of three rooms, as a feature set has them."""
    topomap = replace(cleaned_flat(environment, seed), run=run, scene=scene)
    graph = preprocess(topomap)
    border = topomap.ground_truth.edge_is_border[graph.kept]
    rng = np.random.default_rng(seed)
    noise = rng.normal(0.0, 1.0, (42, len(graph)))
    passageway = np.maximum(0, 40 + 10 * (noise + SHARPNESS[:, None] * border)).astype(np.uint16)
    width = np.where(rng.random(len(graph)) < 0.5, 5.0, rng.uniform(0.6, 3.0, len(graph)))
    distances = rng.normal(100.0, 10.0, (2, len(graph))) + 30.0 * border
    values = np.column_stack([graph.length, width, passageway[9], *distances])
    labelled = LabelledMap.of(topomap, EdgeFeatures(graph, values, FEATURES))
    return MapFeatures(labelled, passageway, f"{environment}{run}{seed}".ljust(32, "0"))
