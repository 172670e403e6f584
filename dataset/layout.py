"""Where each array of a map lies in the HDF5 file, and back.

The layout is `docs/format.md`; nothing else in the project knows the names of
the groups. Encoding takes no time stamps, so that equal maps give equal bytes.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from dataset.camera import CameraFlaws, FisheyeCamera
from dataset.errors import FormatError
from dataset.topomap import GroundTruth, Nodes, Obstacles, Path, Settings, TopoMap, Visits

__all__ = ["FORMAT", "FORMAT_VERSION", "VISIT", "decode_map", "encode_map"]

FORMAT = "roomseg-map"
FORMAT_VERSION = 1
VISIT = np.dtype([("node", "<i4"), ("time", "<f8")])
"""One row of ``/visits``."""

CAMERA_MODEL = "equidistant"
SETTINGS_UNITS = "SI units; angles rad, but degrees where a name ends in _deg"
CAMERA_UNITS = "field_of_view: rad; disc_centre, disc_diameter, image_size: px; height: m"
FLAWS_UNITS = "vignetting: share; blur: px; full_well, read_noise: electrons"


def encode_map(file: h5py.File, topomap: TopoMap) -> None:
    """Write everything but the images into an empty file."""
    _encode_root(file, topomap)
    _encode_nodes(file.create_group("nodes"), topomap.nodes)
    _put(file, "edges", topomap.edges, "<i4")
    visits = np.empty(len(topomap.visits.node), VISIT)
    visits["node"], visits["time"] = topomap.visits.node, topomap.visits.time
    _put(file, "visits", visits, VISIT, "time: s")
    obstacles = file.create_group("obstacles")
    _put(obstacles, "position", topomap.obstacles.position, "<f8", "m")
    _put(obstacles, "time", topomap.obstacles.time, "<f8", "s")
    _put(obstacles, "beam", topomap.obstacles.beam, "u1")
    encode_camera(file, topomap.camera)
    for name, settings in (("robot", topomap.robot), ("sensor", topomap.sensor)):
        if settings is not None:
            _encode_settings(file.create_group(name), settings)
    if topomap.path is not None:
        _encode_path(file.create_group("path"), topomap.path)
    if topomap.scene is not None:
        file.create_dataset("scene", data=topomap.scene, dtype=h5py.string_dtype())
    if topomap.ground_truth is not None:
        encode_ground_truth(file.create_group("ground_truth"), topomap.ground_truth)


def _put(group: h5py.Group, name: str, array: Any, dtype: Any, unit: str | None = None) -> None:
    """Write one array; long ones compressed, with its SI unit."""
    array = np.asarray(array, dtype)
    # Tiny arrays stay contiguous: a chunk index costs more than compression saves.
    options = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
    dataset = group.create_dataset(
        name, data=array, track_times=False, **(options if array.nbytes > 16384 else {})
    )
    if unit is not None:
        dataset.attrs["unit"] = unit


def _encode_root(file: h5py.File, topomap: TopoMap) -> None:
    file.attrs["format"] = FORMAT
    file.attrs["format_version"] = FORMAT_VERSION
    file.attrs["environment"] = topomap.environment
    file.attrs["run"] = topomap.run
    file.attrs["seed"] = topomap.seed
    file.attrs["created"] = topomap.created
    file.attrs["software"] = topomap.software
    file.attrs["robot_radius"] = float(topomap.robot_radius)
    file.attrs["unit"] = "robot_radius: m"


def _encode_nodes(group: h5py.Group, nodes: Nodes) -> None:
    _put(group, "position", nodes.position, "<f8", "m")
    _put(group, "heading", nodes.heading, "<f8", "rad")
    _put(group, "part", nodes.part, "<i4")
    _put(group, "lane", nodes.lane, "<i4")
    if nodes.true_pose is not None:
        _put(group, "true_pose", nodes.true_pose, "<f8", "m, m, rad")
    if nodes.tilt is not None:
        _put(group, "tilt", nodes.tilt, "<f8", "rad, rad")


def _encode_path(group: h5py.Group, path: Path) -> None:
    _put(group, "time", path.time, "<f8", "s")
    _put(group, "true_pose", path.true_pose, "<f8", "m, m, rad")
    _put(group, "estimate", path.estimate, "<f8", "m, m, rad")
    _put(group, "lane", path.lane, "<i4")


def encode_camera(file: h5py.File, camera: FisheyeCamera) -> None:
    """Write ``/camera``, in place of one that is there."""
    attributes = file.require_group("camera").attrs
    attributes["model"] = CAMERA_MODEL
    attributes["field_of_view"] = float(camera.field_of_view)
    attributes["disc_diameter"] = float(camera.disc_diameter)
    attributes["disc_centre"] = np.asarray(camera.disc_centre, "<f8")
    attributes["image_size"] = np.asarray(camera.image_size, "<i4")
    attributes["height"] = float(camera.height)
    attributes["unit"] = CAMERA_UNITS
    if camera.flaws != CameraFlaws():
        attributes["unit"] = f"{CAMERA_UNITS}; {FLAWS_UNITS}"
        for name, value in asdict(camera.flaws).items():
            attributes[name] = float(value)


def _encode_settings(group: h5py.Group, settings: Settings) -> None:
    for name, value in settings.items():
        group.attrs[name] = np.asarray(value, "<f8") if isinstance(value, tuple) else value
    group.attrs["unit"] = SETTINGS_UNITS


def encode_ground_truth(group: h5py.Group, truth: GroundTruth) -> None:
    """Write what a person says about the map into its empty group."""
    group.attrs["room_count"] = int(truth.room_count)
    if truth.room_names is not None:
        group.attrs["room_names"] = np.array(truth.room_names, dtype=h5py.string_dtype())
    _put(group, "borders", truth.borders, "<f8", "m")
    group["borders"].attrs["frame"] = truth.frame
    _put(group, "edge_is_border", truth.edge_is_border, "?")
    if truth.room is not None:
        _put(group, "room", truth.room, "<i4")


def decode_map(file: h5py.File) -> TopoMap:
    """Read everything but the images.

    Raises
    ------
    FormatError
        If the file is no map, of another version, or an array is missing or wrong.
    """
    check_format(file)
    return TopoMap(
        environment=text_attribute(file, "environment"),
        run=text_attribute(file, "run"),
        seed=int(number_attribute(file, "seed")),
        created=text_attribute(file, "created"),
        software=text_attribute(file, "software"),
        nodes=_decode_nodes(file),
        edges=read(file, "edges", "i"),
        visits=_decode_visits(file),
        obstacles=Obstacles(
            position=read(file, "obstacles/position", "f"),
            time=read(file, "obstacles/time", "f"),
            beam=read(file, "obstacles/beam", "u"),
        ),
        robot_radius=number_attribute(file, "robot_radius"),
        path=_decode_path(file) if "path" in file else None,
        ground_truth=_decode_ground_truth(file) if "ground_truth" in file else None,
        camera=decode_camera(file),
        scene=_decode_scene(file) if "scene" in file else None,
        robot=decode_settings(file, "robot"),
        sensor=decode_settings(file, "sensor"),
    )


def check_format(file: h5py.File) -> None:
    """Refuse files of another kind or version (FormatError)."""
    kind = file.attrs.get("format")
    kind = kind.decode("utf-8", "replace") if isinstance(kind, bytes) else kind
    if not isinstance(kind, str) or kind != FORMAT:
        raise FormatError(f"attribute format: {kind!r}, expected {FORMAT!r}: not a roomseg map")
    version = file.attrs.get("format_version")
    if np.ndim(version) or version != FORMAT_VERSION:
        raise FormatError(f"attribute format_version: {version}, expected {FORMAT_VERSION}")


def array_of(file: h5py.File, name: str) -> h5py.Dataset:
    """Find the HDF5 dataset of that name; FormatError if it is not there."""
    found = file.get(name)
    if not isinstance(found, h5py.Dataset):
        raise FormatError(f"/{name}: missing, expected an array (see docs/format.md)")
    return found


def read(file: h5py.File, name: str, kinds: str) -> NDArray[Any]:
    """Read an array whose NumPy kind is one of ``kinds``."""
    dataset = array_of(file, name)
    if dataset.dtype.kind not in kinds:
        raise FormatError(f"/{name}: type {dataset.dtype}, expected kind {' or '.join(kinds)}")
    if dataset.shape is None:
        raise FormatError(f"/{name}: empty, expected an array")
    return np.asarray(dataset[()])


def text_attribute(item: h5py.HLObject, name: str) -> str:
    """Read a text attribute; FormatError if it is missing or no text."""
    value = item.attrs.get(name)
    value = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
    if not isinstance(value, str):
        raise FormatError(f"attribute {name} of {item.name}: {value!r}, expected text")
    return value


def number_attribute(item: h5py.HLObject, name: str, count: int | None = None) -> Any:
    """Read a number, or a tuple of ``count`` numbers; FormatError otherwise."""
    value = np.asarray(item.attrs.get(name))
    shape = () if count is None else (count,)
    good = value.dtype.kind in "iuf" and value.shape == shape
    if not good or not np.isfinite(value).all():
        wanted = "a number" if count is None else f"{count} numbers"
        raise FormatError(f"attribute {name} of {item.name}: {value}, expected {wanted}")
    return value.tolist() if count is None else tuple(value.tolist())


def _decode_nodes(file: h5py.File) -> Nodes:
    return Nodes(
        position=read(file, "nodes/position", "f"),
        heading=read(file, "nodes/heading", "f"),
        part=read(file, "nodes/part", "i"),
        lane=read(file, "nodes/lane", "i"),
        true_pose=read(file, "nodes/true_pose", "f") if "nodes/true_pose" in file else None,
        tilt=read(file, "nodes/tilt", "f") if "nodes/tilt" in file else None,
    )


def _decode_visits(file: h5py.File) -> Visits:
    dataset = array_of(file, "visits")
    if dataset.dtype != VISIT or dataset.ndim != 1:
        raise FormatError(f"/visits: type {dataset.dtype}, expected rows of (node i4, time f8)")
    rows = dataset[()]
    return Visits(node=rows["node"], time=rows["time"])


def _decode_path(file: h5py.File) -> Path:
    return Path(
        time=read(file, "path/time", "f"),
        true_pose=read(file, "path/true_pose", "f"),
        estimate=read(file, "path/estimate", "f"),
        lane=read(file, "path/lane", "i"),
    )


def _decode_scene(file: h5py.File) -> str:
    dataset = array_of(file, "scene")
    text = dataset[()] if dataset.shape == () else None
    if not isinstance(text, bytes):
        raise FormatError("/scene: expected one JSON text")
    return text.decode("utf-8")


def decode_camera(file: h5py.File, name: str = "camera") -> FisheyeCamera:
    """Read ``/camera``; FormatError if it is missing or no camera."""
    group = file.get(name)
    if not isinstance(group, h5py.Group):
        raise FormatError(f"/{name}: missing, expected a group with the camera's attributes")
    model = text_attribute(group, "model")
    if model != CAMERA_MODEL:
        raise FormatError(f"attribute model of /{name}: {model!r}, expected {CAMERA_MODEL!r}")
    rows, columns = number_attribute(group, "image_size", 2)
    row, column = number_attribute(group, "disc_centre", 2)
    try:
        return FisheyeCamera(
            field_of_view=float(number_attribute(group, "field_of_view")),
            disc_diameter=float(number_attribute(group, "disc_diameter")),
            image_size=(int(rows), int(columns)),
            disc_centre=(float(row), float(column)),
            height=float(number_attribute(group, "height")),
            flaws=_decode_flaws(group),
        )
    except ValueError as error:
        raise FormatError(f"/{name}: {error}") from error


def _decode_flaws(group: h5py.Group) -> CameraFlaws:
    names = [name for name in asdict(CameraFlaws()) if name in group.attrs]
    return CameraFlaws(**{name: float(number_attribute(group, name)) for name in names})


def decode_settings(file: h5py.File, name: str) -> Settings | None:
    """Read ``/robot`` or ``/sensor``; None if the file does not have it.

    Raises
    ------
    FormatError
        If it is no group, or an attribute is neither text nor numbers.
    """
    if name not in file:
        return None
    group = file[name]
    if not isinstance(group, h5py.Group):
        raise FormatError(f"/{name}: no group, expected one with attributes")
    return {
        setting: _setting(group, setting) for setting in sorted(group.attrs) if setting != "unit"
    }


def _setting(group: h5py.Group, name: str) -> bool | int | float | str | tuple[float, ...]:
    value = group.attrs[name]
    if isinstance(value, str | bytes):
        return text_attribute(group, name)
    if np.asarray(value).dtype.kind == "b" and np.ndim(value) == 0:
        return bool(value)
    number: float | tuple[float, ...]
    number = number_attribute(group, name, len(value) if np.ndim(value) == 1 else None)
    return number


def _decode_ground_truth(file: h5py.File) -> GroundTruth:
    has_room = "ground_truth/room" in file
    return GroundTruth(
        borders=read(file, "ground_truth/borders", "f"),
        frame=text_attribute(array_of(file, "ground_truth/borders"), "frame"),
        edge_is_border=read(file, "ground_truth/edge_is_border", "b"),
        room_count=int(number_attribute(file["ground_truth"], "room_count")),
        room=read(file, "ground_truth/room", "i") if has_room else None,
        room_names=decode_names(file["ground_truth"]),
    )


def decode_names(group: h5py.Group) -> tuple[str, ...] | None:
    """Read the rooms' names, if they have any; FormatError if they are no texts."""
    names = group.attrs.get("room_names")
    if names is None:
        return None
    if np.ndim(names) != 1 or not all(isinstance(name, str) for name in names):
        raise FormatError(f"attribute room_names of {group.name}: {names!r}, expected texts")
    return tuple(names)
