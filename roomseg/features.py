"""The feature vector of every map edge (§2.2), and its subsets (§3.3)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from dataset.errors import FormatError
from dataset.topomap import TopoMap
from roomseg.panorama import (
    PanoramaParameters,
    Unfolding,
    compass_distances,
    signature_distances,
)
from roomseg.passage_width import WidthParameters, passageway_widths
from roomseg.passageway import (
    TABLE_2,
    LintelParameters,
    LintelSearch,
    orientation_maxima_of_all,
    passageway_feature,
)
from roomseg.preprocessing import MapGraph, preprocess

__all__ = [
    "FEATURES",
    "FROM_IMAGES",
    "SUBSETS",
    "EdgeFeatures",
    "FeatureParameters",
    "MapImages",
    "edge_features",
    "features_and_variants",
]

FEATURES = ("length", "passageway_width", "passageway", "d_c", "d_s")
"""Names of the five edge features, in the order of Table 3."""

SUBSETS = {
    "all": FEATURES,
    "no-camera": ("length", "passageway_width"),
    "no-pano": ("length", "passageway_width", "passageway"),
    "no-ceiling": ("length", "passageway_width", "d_c", "d_s"),
    "no-obst": ("length", "passageway", "d_c", "d_s"),
}
"""The feature vectors of §3.3 by the paper's names."""

FROM_IMAGES = frozenset({"passageway", "d_c", "d_s"})
"""The features that need an image of every node that has an edge."""

Floats = NDArray[np.float64]


class MapImages(Protocol):
    """What the features need of a map file (`dataset.MapFile` has it)."""

    @property
    def topomap(self) -> TopoMap:
        """Everything but the images."""

    @property
    def done(self) -> NDArray[np.bool_]:
        """Which nodes have an image, shape (n,)."""

    def image(self, index: int) -> NDArray[np.uint8]:
        """Read the image of a node, shape (rows, columns)."""


@dataclass(frozen=True)
class FeatureParameters:
    """Parameters of all features; the defaults are the paper's."""

    width: WidthParameters = field(default_factory=WidthParameters)
    lintel: LintelParameters = field(default_factory=LintelParameters)
    panorama: PanoramaParameters = field(default_factory=PanoramaParameters)


@dataclass(frozen=True)
class EdgeFeatures:
    """Feature vectors of the edges of a preprocessed map graph.

    Attributes
    ----------
    graph : MapGraph
    values : array, shape (e', f)
        One row per edge; m, m, pixels, grey levels, grey levels for `FEATURES`.
    names : tuple of f str
    """

    graph: MapGraph
    values: Floats
    names: tuple[str, ...] = FEATURES

    def __post_init__(self) -> None:
        expected = (len(self.graph), len(self.names))
        if self.values.shape != expected:
            raise FormatError(f"features: shape {self.values.shape}, expected {expected}")

    def subset(self, names: Sequence[str]) -> EdgeFeatures:
        """Take these features of the same edges, in this order.

        Raises
        ------
        FormatError
            If a feature is not there.
        """
        missing = [name for name in names if name not in self.names]
        if missing:
            raise FormatError(f"features: no {missing[0]!r}, expected {', '.join(self.names)}")
        columns = [self.names.index(name) for name in names]
        return EdgeFeatures(self.graph, self.values[:, columns], tuple(names))

    def column(self, name: str) -> Floats:
        """One feature of all edges, shape (e',)."""
        return self.subset([name]).values[:, 0]


def edge_features(
    map_file: MapImages,
    names: Sequence[str] = FEATURES,
    *,
    parameters: FeatureParameters | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> EdgeFeatures:
    """Compute the feature vector of every edge that preprocessing keeps (§2.2).

    Parameters
    ----------
    map_file : MapImages
        A `dataset.MapFile`, or anything with its topomap, done and image(i).
    names : sequence of str
        Features to compute, of `FEATURES`; without camera features no image
        is read.
    parameters : FeatureParameters, optional
    progress : callable, optional
        Called with (images read, images in all) after each image.

    Returns
    -------
    EdgeFeatures

    Raises
    ------
    FormatError
        If a name is unknown, or a camera feature is asked for and an image is
        missing or has another size than the camera.
    """
    unknown = [name for name in names if name not in FEATURES]
    if unknown:
        raise FormatError(f"features: {unknown[0]!r}, expected one of {', '.join(FEATURES)}")
    parameters = parameters or FeatureParameters()
    return _computed(map_file, names, parameters, (), progress)[0]


def features_and_variants(
    map_file: MapImages,
    variants: Sequence[LintelParameters] = TABLE_2,
    *,
    parameters: FeatureParameters | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[EdgeFeatures, NDArray[np.uint16]]:
    """Compute all five features, and the passageway feature for other parameters as well.

    Each image is read once and its gradients are computed once (§2.2.3, Table 2).

    Parameters
    ----------
    map_file : MapImages
    variants : sequence of v LintelParameters
        With the search cone and s_max of ``parameters``.
    parameters : FeatureParameters, optional
    progress : callable, optional
        Called with (images read, images in all) after each image.

    Returns
    -------
    EdgeFeatures
        `FEATURES`.
    array, shape (v, e'), uint16
        Ẽ of Eq. 8 for each of the variants, pixels.

    Raises
    ------
    FormatError
        If an image is missing or has another size than the camera.
    """
    parameters = parameters or FeatureParameters()
    return _computed(map_file, FEATURES, parameters, tuple(variants), progress)


def _computed(
    map_file: MapImages,
    names: Sequence[str],
    parameters: FeatureParameters,
    variants: Sequence[LintelParameters],
    progress: Callable[[int, int], None] | None,
) -> tuple[EdgeFeatures, NDArray[np.uint16]]:
    """Compute the named features, and the passageway feature of the variants."""
    topomap = map_file.topomap
    graph = preprocess(topomap)
    columns = {"length": graph.length}
    others = np.zeros((0, len(graph)), np.uint16)
    if "passageway_width" in names:
        columns["passageway_width"] = passageway_widths(topomap, graph.edges, parameters.width)
    if FROM_IMAGES & set(names):
        lintels = (parameters.lintel, *variants)
        views = _node_views(map_file, np.unique(graph.edges), parameters, lintels, progress)
        maxima, panoramas = views
        found = [
            passageway_feature(maxima[lintel.histogram], topomap.nodes, graph.edges, lintel)
            for lintel in lintels
        ]
        columns["passageway"], others = found[0], np.array(found[1:], np.uint16)
        if "d_c" in names:
            columns["d_c"] = compass_distances(panoramas, graph.edges)
        columns["d_s"] = signature_distances(panoramas, graph.edges, parameters.panorama)
    values = np.stack([columns[name] for name in names], axis=1)
    return EdgeFeatures(graph, values, tuple(names)), others


def _node_views(
    map_file: MapImages,
    used: NDArray[np.int64],
    parameters: FeatureParameters,
    lintels: Sequence[LintelParameters],
    progress: Callable[[int, int], None] | None,
) -> tuple[dict[tuple[float, int, int], NDArray[np.int64]], NDArray[np.uint8]]:
    """Lintel maxima (n, 2, N_θ) by histogram and panoramas (n, height, width).

    Each image is read once. Zero for nodes that are not ``used``.
    """
    camera, n = map_file.topomap.camera, len(map_file.topomap.nodes)
    _check_images_done(map_file, used)
    search = LintelSearch.of(camera, parameters.lintel)
    unfold = Unfolding.of(camera, parameters.panorama)
    # ε plays no role in the histograms.
    kinds = {lintel.histogram: lintel for lintel in lintels}
    maxima = {key: np.zeros((n, 2, key[1]), dtype=np.int64) for key in kinds}
    panoramas = np.zeros((n, parameters.panorama.height, parameters.panorama.width), np.uint8)
    for count, node in enumerate(used.tolist(), 1):
        image = map_file.image(node)
        if image.shape != camera.image_size:
            raise FormatError(
                f"{_where(map_file)}images/pixels: {image.shape} px for node {node}, "
                f"expected {camera.image_size} as in /camera"
            )
        found = orientation_maxima_of_all(image, search, list(kinds.values()))
        for key, of_node in zip(kinds, found, strict=True):
            maxima[key][node] = of_node
        panoramas[node] = unfold(image)
        if progress is not None:
            progress(count, len(used))
    return maxima, panoramas


def _check_images_done(map_file: MapImages, used: NDArray[np.int64]) -> None:
    """Refuse a map of which some node that has an edge has no image."""
    done = int(np.count_nonzero(map_file.done[used]))
    if done < len(used):
        raise FormatError(
            f"{_where(map_file)}images/done: {done} of {len(used)} nodes have an image, "
            "expected all of them; render the map first"
        )


def _where(map_file: Any) -> str:
    """Begin a message with the file's name, if it has one."""
    path = getattr(map_file, "path", None)
    return f"{path}: " if path is not None else ""
