"""Everything that can be wrong with a map file, found by small checks.

Each check yields the problems it finds, one line each, so that all faults of a
file are told at once. Shapes come first; what the arrays *say* is only checked
where the arrays themselves are sound.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from dataset.errors import FormatError
from dataset.image_checks import image_problems, radiance_problems
from dataset.layout import (
    VISIT,
    decode_camera,
    decode_names,
    decode_settings,
    number_attribute,
    text_attribute,
)
from dataset.reading import opened

__all__ = ["problems"]


@dataclass(frozen=True)
class _Field:
    """One array of `docs/format.md`: letters in ``shape`` are lengths that must agree."""

    name: str
    kind: str
    shape: tuple[str | int, ...]
    group: str = ""
    """The array may be absent if this group is; itself for an optional array."""


FIELDS = (
    _Field("nodes/position", "f", ("n", 2)),
    _Field("nodes/heading", "f", ("n",)),
    _Field("nodes/part", "i", ("n",)),
    _Field("nodes/lane", "i", ("n",)),
    _Field("nodes/true_pose", "f", ("n", 3), "nodes/true_pose"),
    _Field("nodes/tilt", "f", ("n", 2), "nodes/tilt"),
    _Field("visits", "V", ("v",)),
    _Field("edges", "i", ("e", 2)),
    _Field("obstacles/position", "f", ("k", 2)),
    _Field("obstacles/time", "f", ("k",)),
    _Field("obstacles/beam", "u", ("k",)),
    _Field("path/time", "f", ("t",), "path"),
    _Field("path/true_pose", "f", ("t", 3), "path"),
    _Field("path/estimate", "f", ("t", 3), "path"),
    _Field("path/lane", "i", ("t",), "path"),
    _Field("images/pixels", "u", ("n", "rows", "columns"), "images"),
    _Field("images/gain", "f", ("n",), "images"),
    _Field("images/done", "b", ("n",), "images"),
    _Field("ground_truth/borders", "f", ("b", 2, 2), "ground_truth"),
    _Field("ground_truth/edge_is_border", "b", ("e",), "ground_truth"),
    _Field("ground_truth/room", "i", ("n",), "ground_truth/room"),
    _Field("rooms/label", "i", ("n",), "rooms"),
)
KINDS = {"f": "float", "i": "int", "u": "uint", "b": "bool", "V": "(node, time) rows"}

Sound = dict[str, h5py.Dataset]
"""The arrays that are there, of the right type and shape, and finite."""


def problems(path: str | Path) -> Iterator[str]:
    """Yield every problem of a map file.

    Parameters
    ----------
    path : path
        Any file at all; nothing is raised for a bad one.

    Yields
    ------
    str
        One line: the field, the value, and what would be right. A file that
        cannot be opened yields the one line of the error.
    """
    try:
        with opened(path) as file:
            yield from _problems(file)
    except FormatError as error:
        yield str(error)


def _problems(file: h5py.File) -> Iterator[str]:
    sound: Sound = {}
    yield from _check_root(file)
    yield from _check_arrays(file, sound)
    checks: tuple[Callable[[h5py.File, Sound], Iterator[str]], ...] = (
        _check_lanes,
        _check_edges,
        _check_connected,
        _check_visits,
        _check_camera,
        _check_settings,
        _check_images,
        _check_ground_truth,
        _check_borders,
        _check_rooms,
        _check_scene,
    )
    for check in checks:
        yield from check(file, sound)


def _check_root(file: h5py.File) -> Iterator[str]:
    for name in ("environment", "run", "created", "software"):
        yield from _refusal(partial(text_attribute, file, name))
    for name in ("environment", "run"):
        if file.attrs.get(name) == "":
            yield f"attribute {name} of /: empty, expected a name"
    for name in ("seed", "robot_radius"):
        yield from _refusal(partial(number_attribute, file, name))
    radius = file.attrs.get("robot_radius", 1.0)
    if isinstance(radius, float | np.integer) and radius <= 0.0:
        yield f"attribute robot_radius of /: {radius}, expected > 0 m"


def _refusal(read: Callable[[], Any]) -> Iterator[str]:
    """Run a reader and yield the one line with which it refuses."""
    try:
        read()
    except FormatError as error:
        yield str(error)


def _check_arrays(file: h5py.File, sound: Sound) -> Iterator[str]:
    lengths: dict[str, int] = {}
    for field in FIELDS:
        if field.group and field.group not in file:
            continue
        found = file.get(field.name)
        if not isinstance(found, h5py.Dataset):
            yield f"/{field.name}: missing"
            continue
        faults = list(_check_array(field, found, lengths))
        yield from faults
        if not faults:
            sound[field.name] = found


def _check_array(field: _Field, found: h5py.Dataset, lengths: dict[str, int]) -> Iterator[str]:
    if found.dtype.kind != field.kind or (field.kind == "V" and found.dtype != VISIT):
        yield f"/{field.name}: type {found.dtype}, expected {KINDS[field.kind]}"
        return
    shape = found.shape or ()
    if len(shape) == len(field.shape):
        for letter, length in zip(field.shape, shape, strict=True):
            # The first array with a letter says how long it is.
            if isinstance(letter, str):
                lengths.setdefault(letter, length)
    expected = tuple(lengths.get(x, x) if isinstance(x, str) else x for x in field.shape)
    if shape != expected:
        yield f"/{field.name}: shape {shape}, expected {expected}"
    elif field.kind == "f" and not np.isfinite(values := found[()]).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(values))[0])
        yield f"/{field.name}: {values[where]} at {where}, expected finite numbers"


def _check_lanes(file: h5py.File, sound: Sound) -> Iterator[str]:
    for name in ("nodes/part", "nodes/lane"):
        index = sound[name][()] if name in sound else np.empty(0, np.int32)
        if (index < 0).any():
            node = int((index < 0).argmax())
            yield f"/{name}: node {node} has {index[node]}, expected >= 0"


def _check_edges(file: h5py.File, sound: Sound) -> Iterator[str]:
    if "edges" not in sound or "nodes/position" not in sound:
        return
    edges, n = sound["edges"][()], len(sound["nodes/position"])
    outside = ((edges < 0) | (edges >= n)).any(axis=1)
    if outside.any():
        row = int(outside.argmax())
        yield f"/edges: row {row} is {edges[row].tolist()}, expected nodes 0..{n - 1}"
    swapped = edges[:, 0] >= edges[:, 1]
    if swapped.any():
        row = int(swapped.argmax())
        yield f"/edges: row {row} is {edges[row].tolist()}, expected the smaller node first"
    keys = edges[:, 0].astype(np.int64) * (n + 1) + edges[:, 1]
    if (np.diff(keys) < 0).any():
        yield f"/edges: row {int((np.diff(keys) < 0).argmax()) + 1} is out of order"
    if len(np.unique(keys)) < len(keys):
        first = np.unique(keys, return_index=True)[1]
        row = int(np.setdiff1d(np.arange(len(keys)), first)[0])
        yield f"/edges: row {row} repeats the edge {edges[row].tolist()}"


def _check_connected(file: h5py.File, sound: Sound) -> Iterator[str]:
    if "edges" not in sound or "nodes/position" not in sound:
        return
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    edges, n = sound["edges"][()], len(sound["nodes/position"])
    if not n:
        yield "/nodes/position: no nodes"
        return
    edges = edges[((edges >= 0) & (edges < n)).all(axis=1)]
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(n, n))
    count, labels = connected_components(graph, directed=False)
    if count > 1:
        apart = int((labels != labels[0]).argmax())
        yield f"/edges: the graph has {count} pieces, expected 1: node {apart} is apart from node 0"


def _check_visits(file: h5py.File, sound: Sound) -> Iterator[str]:
    if "visits" not in sound or "nodes/position" not in sound:
        return
    rows, n = sound["visits"][()], len(sound["nodes/position"])
    node, time = rows["node"], rows["time"]
    if not np.isfinite(time).all():
        yield f"/visits: row {int((~np.isfinite(time)).argmax())} has no finite time"
        return
    outside = (node < 0) | (node >= n)
    if outside.any():
        row = int(outside.argmax())
        yield f"/visits: row {row} names node {node[row]}, expected 0..{n - 1}"
    if (np.diff(time) < 0).any():
        yield f"/visits: row {int((np.diff(time) < 0).argmax()) + 1} is earlier than the one before"
    never = np.setdiff1d(np.arange(n), node)
    if len(never):
        yield f"/visits: node {never[0]} has none, expected its creation"


def _check_camera(file: h5py.File, sound: Sound) -> Iterator[str]:
    try:
        camera = decode_camera(file)
    except FormatError as error:
        yield str(error)
        return
    centre, size = np.asarray(camera.disc_centre), np.asarray(camera.image_size)
    radius = camera.disc_diameter / 2
    # A sensor smaller than the disc is no fault, but rows taken for columns are.
    leaves = (centre - radius < -0.5) | (centre + radius > size + 0.5)
    if (leaves & (2 * radius <= size)).any():
        yield (
            f"/camera: a disc of {camera.disc_diameter:g} px around {camera.disc_centre} "
            f"leaves an image of {camera.image_size} px, in which there is room for it"
        )
    pixels = sound.get("images/pixels")
    if pixels is not None and pixels.shape[1:] != tuple(camera.image_size):
        yield f"/images/pixels: images of {pixels.shape[1:]} px, expected {camera.image_size}"


def _check_settings(file: h5py.File, sound: Sound) -> Iterator[str]:
    faults = [
        fault
        for name in ("robot", "sensor")
        for fault in _refusal(partial(decode_settings, file, name))
    ]
    yield from faults
    robot = {} if faults else decode_settings(file, "robot") or {}
    radius = file.attrs.get("robot_radius")
    if "radius" in robot and not np.array_equal(robot["radius"], radius):
        yield f"attribute radius of /robot: {robot['radius']}, expected robot_radius of /, {radius}"


def _check_images(file: h5py.File, sound: Sound) -> Iterator[str]:
    if not {"images/pixels", "images/gain", "images/done"} <= sound.keys():
        return
    pixels, gain = sound["images/pixels"], sound["images/gain"][()]
    if pixels.dtype != np.uint8:
        yield f"/images/pixels: type {pixels.dtype}, expected uint8"
    done = np.flatnonzero(sound["images/done"][()])
    dark = done[gain[done] <= 0.0]
    if len(dark):
        yield f"/images/gain: {gain[dark[0]]} of node {dark[0]}, expected > 0"
    for index in done:
        yield from image_problems(pixels, int(index))
    if "images/radiance" in file:
        yield from radiance_problems(file, pixels.shape, done)


def _check_ground_truth(file: h5py.File, sound: Sound) -> Iterator[str]:
    truth = file.get("ground_truth")
    if truth is None:
        return
    faults = list(_refusal(partial(number_attribute, truth, "room_count")))
    if "ground_truth/borders" in sound:
        frame = sound["ground_truth/borders"].attrs.get("frame")
        if frame not in ("scene", "map"):
            yield f"attribute frame of /ground_truth/borders: {frame!r}, expected scene or map"
    yield from faults
    yield from _refusal(partial(_check_names, truth))
    room = sound.get("ground_truth/room")
    if not faults:
        count = int(number_attribute(truth, "room_count"))
        labels = None if room is None else room[()]
        yield from _check_labels("ground_truth/room", labels, count, "room_count")


def _check_names(truth: h5py.Group) -> None:
    names, count = decode_names(truth), truth.attrs.get("room_count")
    if names is not None and len(names) != count:
        raise FormatError(f"attribute room_names of /ground_truth: {len(names)}, expected {count}")


def _check_labels(
    name: str, labels: NDArray[np.int32] | None, count: int, attribute: str
) -> Iterator[str]:
    if count < 1:
        yield f"attribute {attribute} of /{name.split('/', maxsplit=1)[0]}: {count}, expected >= 1"
        return
    if labels is None:
        return
    outside = (labels < 0) | (labels >= count)
    if outside.any():
        node = int(outside.argmax())
        yield f"/{name}: node {node} has {labels[node]}, expected 0..{count - 1}"
    elif len(np.unique(labels)) != count:
        yield f"/{name}: {len(np.unique(labels))} rooms, expected {attribute} = {count}"


def _check_borders(file: h5py.File, sound: Sound) -> Iterator[str]:
    """Edges marked as borders are those that the border segments cross (§3.1.1)."""
    if "ground_truth/borders" not in sound or "ground_truth/edge_is_border" not in sound:
        return
    import shapely

    frame = sound["ground_truth/borders"].attrs.get("frame")
    if frame == "scene" and "nodes/true_pose" not in file:
        yield "/ground_truth/borders: frame is scene, but /nodes/true_pose is missing"
    pose = sound.get("nodes/true_pose" if frame == "scene" else "nodes/position")
    edges = sound["edges"][()] if "edges" in sound else np.empty((0, 2), np.int32)
    if pose is None or not len(edges) or edges.min() < 0 or edges.max() >= len(pose):
        return
    segments = shapely.linestrings(pose[:, :2][edges])
    borders = shapely.multilinestrings(
        shapely.linestrings(sound["ground_truth/borders"][()].reshape(-1, 2, 2))
    )
    marked = sound["ground_truth/edge_is_border"][()]
    # An edge that only touches the end of a border may be judged either way.
    for wrong, text in (
        (marked & ~shapely.intersects(segments, borders), "is marked, but crosses no border"),
        (~marked & shapely.crosses(segments, borders), "crosses a border, but is not marked"),
    ):
        if wrong.any():
            yield f"/ground_truth/edge_is_border: edge {int(wrong.argmax())} {text}"


def _check_rooms(file: h5py.File, sound: Sound) -> Iterator[str]:
    rooms = file.get("rooms")
    if rooms is None:
        return
    yield from _refusal(partial(text_attribute, rooms, "model"))
    faults = list(_refusal(partial(number_attribute, rooms, "rooms")))
    yield from faults
    if not faults and "rooms/label" in sound:
        count = int(number_attribute(rooms, "rooms"))
        yield from _check_labels("rooms/label", sound["rooms/label"][()], count, "rooms")


def _check_scene(file: h5py.File, sound: Sound) -> Iterator[str]:
    if "scene" not in file:
        return
    scene = file["scene"]
    text = scene[()] if isinstance(scene, h5py.Dataset) and scene.shape == () else None
    if not isinstance(text, bytes):
        yield "/scene: expected one JSON text"
        return
    try:
        json.loads(text)
    except ValueError as error:
        yield f"/scene: no JSON ({error})"
