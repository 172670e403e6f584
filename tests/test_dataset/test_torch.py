"""`dataset.torch` with PyTorch if it is there, else with the little of it that is used."""

from __future__ import annotations

import pickle
import subprocess
import sys
import types

import numpy as np
import pytest
from sample_maps import images_of, two_rooms

from dataset import write_map


@pytest.fixture
def loader(monkeypatch):
    """The module; without PyTorch on arrays in place of tensors."""
    try:
        import torch  # noqa: F401
    except ImportError:
        stand_in = types.ModuleType("torch")
        stand_in.from_numpy = lambda array: array
        stand_in.utils = types.SimpleNamespace(data=types.SimpleNamespace(Dataset=object))
        monkeypatch.setitem(sys.modules, "torch", stand_in)
    monkeypatch.delitem(sys.modules, "dataset.torch", raising=False)
    import dataset.torch

    yield dataset.torch
    sys.modules.pop("dataset.torch", None)


@pytest.fixture
def two_maps(tmp_path):
    """All images of the first map, those of nodes 2 and 5 of the second."""
    topomap = two_rooms()
    images = [images_of(topomap, 1), images_of(topomap, 2)]
    paths = [tmp_path / "a.h5", tmp_path / "b.h5"]
    write_map(paths[0], topomap, images[0])
    write_map(paths[1], topomap, [images[1][k] if k in (2, 5) else None for k in range(8)])
    return paths, images


def test_images_come_with_their_rooms(loader, two_maps):
    paths, images = two_maps
    data = loader.ImageSet(paths)
    assert len(data) == 10
    expected = [(0, k) for k in range(8)] + [(1, 2), (1, 5)]
    for index, (number, node) in enumerate(expected):
        image, room = data[index]
        assert tuple(image.shape) == (1, 16, 16)
        assert np.allclose(np.asarray(image)[0] * 255, images[number][node], atol=1e-4)
        assert room == [0, 0, 1, 1][node % 4]
        assert data.where(index) == (paths[number], node)
    with pytest.raises(IndexError):
        data[10]


def test_panoramas_come_between(loader, two_maps):
    paths, images = two_maps
    data = loader.ImageSet(paths, panorama=lambda camera: lambda image: image[: camera.height > 0])
    _, panorama, room = data[8]
    assert tuple(panorama.shape) == (1, 1, 16) and room == 1
    assert np.allclose(np.asarray(panorama)[0, 0] * 255, images[1][2][0], atol=1e-4)


def test_a_data_set_can_be_sent_to_another_process(loader, two_maps):
    data = loader.ImageSet(two_maps[0])
    image, _ = data[3]  # its file is open now
    again = pickle.loads(pickle.dumps(data))
    assert np.array_equal(np.asarray(again[3][0]), np.asarray(image))


def test_graphs_are_the_maps(loader, two_maps):
    data = loader.GraphSet(two_maps[0])
    assert len(data) == 2
    topomap, graph = two_rooms(), data[0]
    assert np.array_equal(np.asarray(graph.edge_index), topomap.edges.T)
    assert np.allclose(np.asarray(graph.edge_attr)[:, 0], topomap.edge_lengths())
    assert np.asarray(graph.y).tolist() == [0, 0, 1, 1] * 2
    assert np.array_equal(np.asarray(graph.border), topomap.ground_truth.edge_is_border)
    x = np.asarray(graph.x)
    assert x.shape == (8, 4) and np.allclose(x[:, :2].mean(axis=0), 0, atol=1e-6)
    assert np.allclose(x[:, 2:], [1, 0])


def test_unknown_rooms_are_what_losses_ignore(loader, tmp_path):
    from dataclasses import replace

    write_map(tmp_path / "a.h5", replace(two_rooms(), ground_truth=None))
    graph = loader.GraphSet([tmp_path / "a.h5"])[0]
    assert set(np.asarray(graph.y).tolist()) == {-100}
    assert np.isnan(np.asarray(graph.border)).all()


def test_without_pytorch_the_error_is_one_line():
    code = "import sys; sys.modules['torch'] = None; import dataset.torch"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    assert last.startswith("ImportError: dataset.torch needs the package torch")
    assert last.endswith("pip install 'roomseg[torch]'")


def test_import_dataset_loads_little():
    code = (
        "import sys, dataset\n"
        "heavy = ('scipy', 'shapely', 'pandas', 'torch', 'networkx', 'cv2', 'sklearn')\n"
        "print([name for name in heavy if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
