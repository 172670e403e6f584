"""Feature sets: the edge features and the truth of many maps in one small file.

Searches, tables and figures can be made again from it without maps and images. The layout is
`docs/format.md`; lengths are rounded as a figure or a classifier may notice them at most: nodes
to millimetres, obstacle points to centimetres, features to single precision.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from dataset.atomic import locked, remove_leftovers, replacing
from dataset.errors import FormatError
from dataset.layout import number_attribute, read, text_attribute
from dataset.reading import begins_as_hdf5
from dataset.storage import MapFile
from dataset.topomap import Nodes
from roomseg.features import FEATURES, EdgeFeatures, FeatureParameters, features_and_variants
from roomseg.labelled_map import LabelledMap, MapSketch
from roomseg.passageway import TABLE_2
from roomseg.preprocessing import MapGraph

__all__ = [
    "MapFeatures",
    "add_to_feature_set",
    "compute_features",
    "content_key",
    "is_feature_set",
    "keys_in",
    "read_feature_set",
]

FORMAT = "roomseg-features"
FORMAT_VERSION = 1
COMPUTATION = 1
"""Counted up when the same map gives other features."""
STORED = tuple(name for name in FEATURES if name != "passageway")
DEFAULT = TABLE_2.index(FeatureParameters().lintel)
MILLIMETRES, CENTIMETRES = 1000.0, 100.0


@dataclass(frozen=True)
class MapFeatures:
    """One map of a feature set.

    Attributes
    ----------
    labelled : LabelledMap
        With all five features, the passageway feature for the default parameters.
    passageway : array, shape (42, e'), uint16
        It for each combination of `roomseg.passageway.TABLE_2`.
    key : str
        Of the map's content and of how its features are computed (`content_key`).
    """

    labelled: LabelledMap
    passageway: NDArray[np.uint16]
    key: str

    def __post_init__(self) -> None:
        expected = (len(TABLE_2), len(self.labelled.features.graph))
        if self.passageway.shape != expected:
            raise FormatError(f"passageway: shape {self.passageway.shape}, expected {expected}")

    def with_passageway(self, combination: int) -> LabelledMap:
        """The map with the passageway feature of that combination of Table 2."""
        features = self.labelled.features
        values = features.values.copy()
        values[:, features.names.index("passageway")] = self.passageway[combination]
        return replace(self.labelled, features=replace(features, values=values))


def content_key(map_file: MapFile) -> str:
    """Hash of a map, its images and the parameters of the features, 32 digits."""
    how = f"{COMPUTATION} {FeatureParameters()!r} {TABLE_2!r}"
    return hashlib.sha256(f"{map_file.digest()} {how}".encode()).hexdigest()[:32]


def compute_features(
    map_file: MapFile, progress: Callable[[int, int], None] | None = None
) -> MapFeatures:
    """Compute what a feature set holds of a map with images and room labels.

    Parameters
    ----------
    map_file : MapFile
    progress : callable, optional
        Called with (images read, images in all).

    Raises
    ------
    FormatError
        If an image or the room labels are missing.
    """
    features, passageway = features_and_variants(map_file, progress=progress)
    return MapFeatures(
        LabelledMap.of(map_file.topomap, features), passageway, content_key(map_file)
    )


def is_feature_set(path: str | Path) -> bool:
    """Whether a file is a feature set; False for what is none, or damaged."""
    if not Path(path).is_file() or not begins_as_hdf5(Path(path)):
        return False
    try:
        with h5py.File(path, "r") as file:
            kind = file.attrs.get("format")
            return isinstance(kind, str) and kind == FORMAT
    except (OSError, KeyError, RuntimeError, ValueError, TypeError):
        return False


def keys_in(path: str | Path) -> frozenset[str]:
    """Keys of the maps in a feature set; none if there is no file."""
    if not Path(path).exists():
        return frozenset()
    with _opened(path) as file:
        return frozenset(file["maps"])


def read_feature_set(path: str | Path) -> tuple[MapFeatures, ...]:
    """Read all maps, sorted by environment and run.

    Raises
    ------
    FormatError
        One line: the file, the field, the value, and what would be right.
    """
    with _opened(path) as file:
        maps = []
        for key in file["maps"]:
            try:
                maps.append(_decode(file, key))
            except FormatError as error:
                raise FormatError(f"/maps/{key}: {error}") from error
    return tuple(sorted(maps, key=_order))


def add_to_feature_set(path: str | Path, maps: Iterable[MapFeatures]) -> None:
    """Put maps into a feature set, made if it is missing; same runs replace earlier ones.

    The file is replaced as a whole, so that the old one or the new one is there.
    """
    path = Path(path)
    with locked(path):
        remove_leftovers(path)
        there = {_name(item): item for item in (read_feature_set(path) if path.exists() else ())}
        there |= {_name(item): item for item in maps}
        with replacing(path) as part, h5py.File(part, "w") as file:
            file.attrs["format"], file.attrs["format_version"] = FORMAT, FORMAT_VERSION
            _put(file, "passageway_parameters", _table_2(), "<f8")
            file.create_group("maps")
            for item in sorted(there.values(), key=_order):
                _encode(file, item)


def _name(item: MapFeatures) -> str:
    return item.labelled.name


def _order(item: MapFeatures) -> tuple[str, str]:
    return item.labelled.environment, item.labelled.run


def _table_2() -> NDArray[np.float64]:
    """I_min, N_θ, N_s and ε in degrees of each combination, shape (42, 4)."""
    return np.array([(*p.histogram, round(np.degrees(p.tolerance), 6)) for p in TABLE_2])


@contextmanager
def _opened(path: str | Path) -> Iterator[h5py.File]:
    """Open a feature set for reading; every error names it."""
    path = Path(path)
    try:
        if not path.is_file():
            raise FormatError("no such file, expected a feature set (.h5)")
        if not begins_as_hdf5(path):
            raise FormatError("not an HDF5 file, expected a feature set (.h5)")
        with h5py.File(path, "r") as file:
            _check_format(file)
            yield file
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from error
    except (OSError, KeyError, RuntimeError, ValueError, TypeError, MemoryError) as error:
        reason = " ".join(str(error).split())
        raise FormatError(f"{path}: damaged feature set ({reason})") from error


def _check_format(file: h5py.File) -> None:
    kind, version = file.attrs.get("format"), file.attrs.get("format_version")
    if not isinstance(kind, str) or kind != FORMAT:
        raise FormatError(f"attribute format: {kind!r}, expected {FORMAT!r}: no feature set")
    if np.ndim(version) or version != FORMAT_VERSION:
        raise FormatError(f"attribute format_version: {version}, expected {FORMAT_VERSION}")
    if not isinstance(file.get("maps"), h5py.Group):
        raise FormatError("/maps: missing, expected a group (see docs/format.md)")
    if not np.array_equal(read(file, "passageway_parameters", "f"), _table_2()):
        raise FormatError("/passageway_parameters: others than the 42 combinations of Table 2")


def _put(group: h5py.Group, name: str, array: Any, dtype: str, unit: str | None = None) -> None:
    values = np.asarray(array, dtype)
    options = (
        {"compression": "gzip", "compression_opts": 9, "shuffle": True, "chunks": values.shape}
        if values.size > 64
        else {}
    )
    dataset = group.create_dataset(name, data=values, **options)
    if unit is not None:
        dataset.attrs["unit"] = unit


def _encode(file: h5py.File, item: MapFeatures) -> None:
    """Write one map as the group of its key."""
    labelled, graph = item.labelled, item.labelled.features.graph
    group = file["maps"].create_group(item.key)
    group.attrs["environment"], group.attrs["run"] = labelled.environment, labelled.run
    group.attrs["room_count"] = labelled.room_count
    _put(group, "edges", graph.edges, "<i4")
    _put(group, "kept", graph.kept, "<i4")
    values = labelled.features.subset(STORED).values
    _put(group, "features", values, "<f4", "m, m, grey levels, grey levels")
    _put(group, "passageway", item.passageway, "<u2", "px")
    _put(group, "is_border", labelled.is_border, "?")
    _put(group, "room", labelled.room, "<i4")
    if labelled.sketch is not None:
        _encode_sketch(file, group, labelled.sketch)


def _encode_sketch(file: h5py.File, group: h5py.Group, sketch: MapSketch) -> None:
    """Write what figures need, in whole mm, mrad and cm; equal scenes once."""
    nodes, unit = sketch.nodes, "mm, mm, mrad"
    estimate = np.column_stack([nodes.position, nodes.heading])
    _put(group, "estimate", np.rint(estimate * MILLIMETRES), "<i4", unit)
    _put(group, "part_lane", np.column_stack([nodes.part, nodes.lane]), "<i4")
    if nodes.true_pose is not None:
        _put(group, "true_pose", np.rint(nodes.true_pose * MILLIMETRES), "<i4", unit)
    points = np.rint(sketch.obstacles * CENTIMETRES).astype(np.int64)
    _put(group, "obstacles", np.unique(points, axis=0).reshape(-1, 2), "<i4", "cm")
    if sketch.scene is not None:
        text = np.frombuffer(sketch.scene.encode(), np.uint8)
        name = hashlib.sha256(text.tobytes()).hexdigest()[:32]
        scenes = file.require_group("scenes")
        if name not in scenes:
            _put(scenes, name, text, "u1")
        group.attrs["scene"] = name


def _decode(file: h5py.File, key: str) -> MapFeatures:
    """Read one map, and check what its arrays must agree on."""
    group = file["maps"][key]
    if not isinstance(group, h5py.Group):
        raise FormatError("no group")
    room = read(group, "room", "i").astype(np.int32)
    count = int(number_attribute(group, "room_count"))
    _check_range("room", room, count)
    graph, values = _decode_edges(group, len(room))
    passageway = read(group, "passageway", "u").astype(np.uint16)
    if passageway.shape != (len(TABLE_2), len(graph)):
        raise FormatError(
            f"passageway: shape {passageway.shape}, expected {(len(TABLE_2), len(graph))}"
        )
    columns = dict(zip(STORED, values.T, strict=True)) | {"passageway": passageway[DEFAULT]}
    features = EdgeFeatures(graph, np.column_stack([columns[name] for name in FEATURES]))
    labelled = LabelledMap(
        text_attribute(group, "environment"),
        text_attribute(group, "run"),
        features,
        read(group, "is_border", "b"),
        room,
        count,
        _decode_sketch(file, group) if "estimate" in group else None,
    )
    return MapFeatures(labelled, passageway, key)


def _decode_edges(group: h5py.Group, n: int) -> tuple[MapGraph, NDArray[np.float64]]:
    """Read the graph of n nodes and the four stored features of its edges."""
    edges = read(group, "edges", "i").astype(np.int64)
    kept = read(group, "kept", "i").astype(np.int64)
    values = read(group, "features", "f").astype(np.float64)
    e = len(edges)
    for name, array, shape in (
        ("edges", edges, (e, 2)),
        ("kept", kept, (e,)),
        ("features", values, (e, len(STORED))),
    ):
        if array.shape != shape:
            raise FormatError(f"{name}: shape {array.shape}, expected {shape}")
    _check_range("edges", edges, n)
    if not np.isfinite(values).all():
        raise FormatError("features: has values that are not finite")
    return MapGraph(n, kept, edges, values[:, 0].copy()), values


def _check_range(name: str, array: NDArray[Any], count: int) -> None:
    if array.ndim < 1 or not len(array) or array.min() < 0 or array.max() >= count:
        raise FormatError(f"{name}: expected numbers in 0..{count - 1}")


def _decode_sketch(file: h5py.File, group: h5py.Group) -> MapSketch:
    estimate = read(group, "estimate", "i") / MILLIMETRES
    part_lane = read(group, "part_lane", "i")
    shapes = {"estimate": (estimate, 3), "part_lane": (part_lane, 2)}
    for name, (array, width) in shapes.items():
        if array.ndim != 2 or array.shape[1] != width:
            raise FormatError(f"{name}: shape {array.shape}, expected (n, {width})")
    true_pose = read(group, "true_pose", "i") / MILLIMETRES if "true_pose" in group else None
    part, lane = part_lane.T
    nodes = Nodes(estimate[:, :2], estimate[:, 2], part, lane, true_pose)
    obstacles = read(group, "obstacles", "i") / CENTIMETRES
    if obstacles.ndim != 2 or obstacles.shape[1] != 2:
        raise FormatError(f"obstacles: shape {obstacles.shape}, expected (k, 2)")
    if "scene" not in group.attrs:
        return MapSketch(nodes, obstacles)
    text = read(file, f"scenes/{text_attribute(group, 'scene')}", "u")
    return MapSketch(nodes, obstacles, text.astype(np.uint8).tobytes().decode())
