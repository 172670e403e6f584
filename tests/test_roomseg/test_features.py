"""Feature vectors of a small flat whose nodes see made-up images."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
from cleaned_flat import cleaned_flat, fisheye_image

from dataset.camera import SIMULATED_CAMERA
from dataset.errors import FormatError
from dataset.storage import MapFile, write_map
from dataset.topomap import Nodes, TopoMap, Visits
from roomseg.features import FEATURES, SUBSETS, EdgeFeatures, edge_features
from roomseg.panorama import PanoramaParameters, Unfolding, compass_distances, signature_distances
from roomseg.passage_width import passageway_widths
from roomseg.passageway import (
    LintelParameters,
    LintelSearch,
    orientation_maxima,
    passageway_feature,
)
from roomseg.preprocessing import preprocess

CAMERA = SIMULATED_CAMERA.resized(116)


@dataclass
class Images:
    """A map and an image per node, as a map file gives them."""

    topomap: TopoMap
    pixels: np.ndarray
    done: np.ndarray
    read: list[int] = field(default_factory=list)

    def image(self, index: int) -> np.ndarray:
        self.read.append(index)
        return self.pixels[index]


NODES = 60


@pytest.fixture(scope="module")
def corner() -> TopoMap:
    """The first nodes of the flat."""
    flat = cleaned_flat()
    nodes, visits = flat.nodes, flat.visits
    columns = ("position", "heading", "part", "lane", "true_pose")
    return replace(
        flat,
        nodes=Nodes(*(getattr(nodes, name)[:NODES] for name in columns)),
        edges=flat.edges[(flat.edges < NODES).all(axis=1)],
        visits=Visits(visits.node[:NODES], visits.time[:NODES]),
        ground_truth=None,
        path=None,
        camera=CAMERA,
    )


@pytest.fixture(scope="module")
def pixels() -> np.ndarray:
    return np.stack([fisheye_image(CAMERA, seed) for seed in range(NODES)])


@pytest.fixture
def images(corner: TopoMap, pixels: np.ndarray) -> Images:
    return Images(corner, pixels, np.ones(NODES, dtype=bool))


def test_columns_are_the_five_features(images: Images) -> None:
    features = edge_features(images)
    graph, nodes = preprocess(images.topomap), images.topomap.nodes
    assert features.names == FEATURES
    assert (features.graph.kept == graph.kept).all()
    lintel = LintelParameters()
    search = LintelSearch.of(CAMERA, lintel)
    unfold = Unfolding.of(CAMERA, PanoramaParameters())
    maxima = np.stack([orientation_maxima(image, search, lintel) for image in images.pixels])
    panoramas = np.stack([unfold(image) for image in images.pixels])
    expected = [
        images.topomap.edge_lengths()[graph.kept],
        passageway_widths(images.topomap, graph.edges),
        passageway_feature(maxima, nodes, graph.edges, lintel),
        compass_distances(panoramas, graph.edges),
        signature_distances(panoramas, graph.edges),
    ]
    assert (features.values == np.stack(expected, axis=1)).all()
    assert np.isfinite(features.values).all()


def test_every_image_is_read_once_and_reported(images: Images) -> None:
    reports: list[tuple[int, int]] = []
    edge_features(images, progress=lambda done, total: reports.append((done, total)))
    n = len(images.topomap.nodes)
    assert images.read == list(range(n))
    assert reports == [(k + 1, n) for k in range(n)]


def test_a_sample_of_edges_needs_its_own_images_only(images: Images) -> None:
    whole = edge_features(images)
    kept = whole.graph.kept[::7]
    images.topomap = replace(images.topomap, edges=images.topomap.edges[kept])
    images.done[:] = False
    images.done[images.topomap.edges] = True
    images.read.clear()
    sample = edge_features(images)
    assert (sample.values == whole.values[::7]).all()
    assert images.read == np.flatnonzero(images.done).tolist()


@pytest.mark.parametrize("name", ["no-pano", "no-ceiling", "no-obst"])
def test_subset_is_computed_like_the_whole(images: Images, name: str) -> None:
    whole = edge_features(images).subset(SUBSETS[name])
    part = edge_features(images, SUBSETS[name])
    assert part.names == SUBSETS[name]
    assert (part.values == whole.values).all()


def test_without_camera_no_image_is_needed(images: Images) -> None:
    images.done[:] = False
    features = edge_features(images, SUBSETS["no-camera"])
    assert features.values.shape[1] == 2
    assert images.read == []


def test_missing_images(images: Images) -> None:
    images.done[3] = False
    n = len(images.topomap.nodes)
    with pytest.raises(FormatError, match=rf"images/done: {n - 1} of {n} nodes have an image"):
        edge_features(images)


def test_image_of_another_size(images: Images) -> None:
    images.pixels = images.pixels[:, :-1]
    with pytest.raises(FormatError, match=r"images/pixels: \(115, 116\) px for node 0, expected"):
        edge_features(images)


def test_unknown_feature(images: Images) -> None:
    with pytest.raises(FormatError, match="'smell', expected one of length, passageway_width"):
        edge_features(images, ("length", "smell"))
    with pytest.raises(FormatError, match="no 'd_c', expected length, passageway_width"):
        edge_features(images, SUBSETS["no-camera"]).column("d_c")


def test_shape_is_checked() -> None:
    graph = preprocess(cleaned_flat())
    with pytest.raises(FormatError, match="features: shape"):
        EdgeFeatures(graph, np.zeros((3, 5)))


def test_a_map_file_will_do(images: Images, tmp_path: Path) -> None:
    path = tmp_path / "map.h5"
    write_map(path, images.topomap, images.pixels)
    with MapFile(path) as map_file:
        stored = edge_features(map_file)
    assert (stored.values == edge_features(images).values).all()
    write_map(path, images.topomap)
    with MapFile(path) as map_file, pytest.raises(FormatError, match=f"{path}: .*images"):
        edge_features(map_file)
