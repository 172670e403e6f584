"""Exposing again from the radiance that was kept gives what rendering gave."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_job import TINY, N, images, make_map

import render.job
from dataset import CameraFlaws, FisheyeCamera, FormatError, MapFile, problems, read_map
from render import expose_map, render_map
from render.process import Job

PLAIN = FisheyeCamera().resized(32)
FLAWS = CameraFlaws(vignetting=0.4, blur=0.7, full_well=5000.0, read_noise=20.0)
FLAWED = replace(PLAIN, flaws=FLAWS)


class _Light:
    """Stands in for the child process: light that is its node's own."""

    device = "CPU"

    def __init__(self, job: Job, on_bake: object = None) -> None:
        self.size = job.camera.image_size

    def __enter__(self) -> _Light:
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def frames(self, indices: list[int], poses: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
        for index in indices:
            rng = np.random.default_rng(index)
            light = 50.0 ** (index - 6) * rng.lognormal(0.0, 2.0, self.size)
            yield index, light.astype(np.float32)


@pytest.fixture(autouse=True)
def _no_blender(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(render.job, "RenderProcess", _Light)


@pytest.mark.parametrize("camera", [PLAIN, FLAWED], ids=["ideal", "flawed"])
def test_the_same_images_with_and_without_radiance_and_exposed_again(
    tmp_path: Path, camera: FisheyeCamera
) -> None:
    plain = make_map(tmp_path / "plain.h5", camera=camera)
    rich = make_map(tmp_path / "rich.h5", camera=camera)
    render_map(plain, preset=TINY)
    render_map(rich, preset=TINY, hdr=True)
    assert images(plain) == images(rich)
    before = rich.read_bytes()
    seen: list[tuple[int, int]] = []
    assert expose_map(rich, on_progress=lambda *a: seen.append(a)) == N
    assert seen == [(i + 1, N) for i in range(N)]
    assert rich.read_bytes() == before
    assert not [problem for problem in problems(rich) if "/images" in problem]


def test_noise_is_the_nodes_own_whatever_the_order(tmp_path: Path) -> None:
    whole = make_map(tmp_path / "whole.h5", camera=FLAWED)
    pieces = make_map(tmp_path / "pieces.h5", camera=FLAWED)
    render_map(whole, preset=TINY, hdr=True)
    for nodes in ([2], [0, 3], range(N)):
        render_map(pieces, preset=TINY, nodes=nodes, hdr=True)
    assert pieces.read_bytes() == whole.read_bytes()
    assert len({data for data, _ in images(whole)}) == N


def test_other_flaws_are_those_of_a_map_rendered_with_them_and_can_be_undone(
    tmp_path: Path,
) -> None:
    first, second = make_map(tmp_path / "a.h5"), make_map(tmp_path / "b.h5", camera=FLAWED)
    for path in (first, second):
        render_map(path, preset=TINY, hdr=True)
    before = images(first)
    assert before != images(second)
    expose_map(first, FLAWS)
    assert read_map(first).camera == FLAWED
    assert images(first) == images(second)
    with MapFile(first) as file:
        assert file.own_camera == PLAIN
    expose_map(first, CameraFlaws())
    assert images(first) == before


def test_a_stopped_exposure_changes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = make_map(tmp_path / "map.h5")
    render_map(path, preset=TINY, hdr=True)
    before = path.read_bytes()

    def stop(done: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        expose_map(path, FLAWS, on_progress=stop)
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["map.h5"]


def test_a_map_without_radiance_is_refused(tmp_path: Path) -> None:
    path = make_map(tmp_path / "map.h5")
    with pytest.raises(FormatError, match=r"map.h5: /images/radiance: missing.*render --hdr"):
        expose_map(path)
    render_map(path, preset=TINY, limit=1)
    with pytest.raises(FormatError, match=r"/images/radiance: missing"):
        expose_map(path)
    with pytest.raises(FormatError, match="without radiance"):
        render_map(path, preset=TINY, hdr=True)
