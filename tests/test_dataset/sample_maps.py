"""A small map that is right in every respect, for tests to write, read and spoil."""

from __future__ import annotations

import json

import numpy as np

from dataset import (
    FisheyeCamera,
    GroundTruth,
    Nodes,
    Obstacles,
    Path,
    TopoMap,
    Visits,
)

CAMERA = FisheyeCamera().resized(16)


def two_rooms(camera: FisheyeCamera = CAMERA) -> TopoMap:
    """Two lanes of four nodes; a border at x = 1.5 m crosses both, two rooms of four nodes."""
    x, y = np.meshgrid(np.arange(4.0), np.arange(2.0))
    position = np.stack([x.ravel(), y.ravel()], axis=1)
    n = len(position)
    edges = np.array(
        [(0, 1), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (5, 6), (6, 7)]
    )
    time = np.arange(10.0)
    pose = np.column_stack([np.linspace(0.0, 3.0, 10), np.zeros(10), np.zeros(10)])
    return TopoMap(
        environment="flat",
        run="run1",
        seed=3,
        created="2026-01-02T03:04:05+00:00",
        software="roomseg 0.1.0",
        nodes=Nodes(
            position=position,
            heading=np.zeros(n),
            part=np.zeros(n),
            lane=np.repeat([0, 1], 4),
            true_pose=np.column_stack([position, np.zeros(n)]),
        ),
        edges=edges,
        visits=Visits(node=np.r_[np.arange(n), 0, 1], time=np.arange(10.0)),
        obstacles=Obstacles(np.array([[0.0, 2.0], [1.0, 2.0]]), np.array([1.0, 2.0]), [0, 7]),
        path=Path(time, pose, pose, np.zeros(10)),
        ground_truth=GroundTruth(
            borders=np.array([[[1.5, -1.0], [1.5, 2.0]]]),
            frame="scene",
            edge_is_border=(edges % 4 == [1, 2]).all(axis=1),
            room_count=2,
            room=np.tile([0, 0, 1, 1], 2),
        ),
        camera=camera,
        robot={"radius": 0.15, "lane_spacing": 1.0},
        scene=json.dumps({"name": "flat", "höhe": 2.5}, ensure_ascii=False),
    )


def images_of(topomap: TopoMap, seed: int = 0) -> np.ndarray:
    """Noise in place of camera images, another for each node."""
    shape = (len(topomap.nodes), *topomap.camera.image_size)
    return np.random.default_rng(seed).integers(0, 256, shape, dtype=np.uint8)


def assert_same(left: TopoMap, right: TopoMap) -> None:
    """Every array, text and number is equal, and of the same type."""
    _assert_same(left, right, "map")


def _assert_same(left: object, right: object, name: str) -> None:
    assert type(left) is type(right), name
    if isinstance(left, np.ndarray):
        assert isinstance(right, np.ndarray)
        assert left.dtype == right.dtype, name
        np.testing.assert_array_equal(left, right, err_msg=name)
    elif hasattr(left, "__dataclass_fields__"):
        for field in left.__dataclass_fields__:
            _assert_same(getattr(left, field), getattr(right, field), f"{name}.{field}")
    else:
        assert left == right, name
