"""Baked light is made once, shared, and remade when its file is damaged."""

from __future__ import annotations

import time
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from probe import boxed_room

from dataset.errors import RoomsegError
from render.light_store import bake_path, stored_light
from render.presets import Bake

LIGHT = np.random.default_rng(0).uniform(0.0, 2.0, (4, 5, 3)).astype(np.float32)


class Oven:
    """Counts how often light is made."""

    def __init__(self, seconds: float = 0.0) -> None:
        self.count = 0
        self.seconds = seconds

    def __call__(self) -> np.ndarray:
        self.count += 1
        time.sleep(self.seconds)
        return LIGHT


def test_made_once_and_the_same_from_the_file(tmp_path: Path) -> None:
    path, oven = tmp_path / "bakes" / "box.npz", Oven()
    first = stored_light(path, (4, 5), oven)
    second = stored_light(path, (4, 5), oven)
    assert oven.count == 1
    np.testing.assert_array_equal(first, second)
    np.testing.assert_allclose(first, LIGHT, rtol=1e-3)
    assert [item.name for item in path.parent.iterdir()] == ["box.npz"]


@pytest.mark.parametrize("content", [b"", b"not an archive", None])
def test_a_damaged_or_other_file_is_made_again(tmp_path: Path, content: bytes | None) -> None:
    path, oven = tmp_path / "bakes" / "box.npz", Oven()
    stored_light(path, (4, 5), oven)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2] if content is None else content)
    stored_light(path, (4, 5), oven)
    assert oven.count == 2
    assert path.read_bytes() == whole


def test_what_a_killed_maker_left_goes(tmp_path: Path) -> None:
    path = tmp_path / "bakes" / "box.npz"
    path.parent.mkdir()
    (path.parent / ".box.npz.1.part").write_text("half")
    stored_light(path, (4, 5), Oven())
    assert [item.name for item in path.parent.iterdir()] == ["box.npz"]


def test_another_shape_is_made_again(tmp_path: Path) -> None:
    path, oven = tmp_path / "bakes" / "box.npz", Oven()
    path.parent.mkdir()
    np.savez(path, light=np.zeros((3, 3, 3), dtype=np.float16))
    stored_light(path, (4, 5), oven)
    assert oven.count == 1


def test_who_comes_second_waits(tmp_path: Path) -> None:
    path, oven = tmp_path / "bakes" / "box.npz", Oven(0.3)
    threads = [Thread(target=stored_light, args=(path, (4, 5), oven)) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert oven.count == 1


def test_light_that_is_infinitely_bright_is_stored(tmp_path: Path) -> None:
    found = stored_light(
        tmp_path / "bakes" / "box.npz", (1, 1), lambda: np.full((1, 1, 3), 1e9, dtype=np.float32)
    )
    assert np.isfinite(found).all()


def test_a_folder_that_cannot_be_made_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "bakes").write_text("in the way")
    with pytest.raises(RoomsegError, match=r"box\.npz"):
        stored_light(tmp_path / "bakes" / "box.npz", (4, 5), Oven())


def test_the_name_follows_what_the_light_depends_on(tmp_path: Path) -> None:
    room = boxed_room((0.0, 2.1))
    here = bake_path(room, Bake(), tmp_path, "5.0")
    assert here.parent == tmp_path / "bakes"
    assert here.name.startswith("box-")
    start = room.start.model_copy(update={"position": (0.5, 0.5)})
    assert bake_path(room.model_copy(update={"start": start}), Bake(), tmp_path, "5.0") == here
    others = [
        bake_path(boxed_room((0.5, 2.1)), Bake(), tmp_path, "5.0"),
        bake_path(boxed_room((0.0, 2.1), "interior"), Bake(), tmp_path, "5.0"),
        bake_path(room, Bake(samples=9), tmp_path, "5.0"),
        bake_path(room, Bake(), tmp_path, "5.1"),
    ]
    assert len({here, *others}) == 5
