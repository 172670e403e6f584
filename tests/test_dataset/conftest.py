"""Fixtures: a right map, and its file with images."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sample_maps import images_of, two_rooms

from dataset import TopoMap, write_map, write_rooms


@pytest.fixture
def topomap() -> TopoMap:
    return two_rooms()


@pytest.fixture
def map_path(tmp_path: Path, topomap: TopoMap) -> Path:
    """A map without images."""
    path = tmp_path / "flat-run1.h5"
    write_map(path, topomap)
    return path


@pytest.fixture
def full_path(tmp_path: Path, topomap: TopoMap) -> Path:
    """A map with all images and a segmentation."""
    path = tmp_path / "full.h5"
    n = len(topomap.nodes)
    write_map(path, topomap, images_of(topomap), np.linspace(0.5, 2.0, n))
    write_rooms(path, np.tile([0, 0, 1, 1], 2), model="m", rooms=2)
    return path
