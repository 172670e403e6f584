"""The file of a 3D scene goes where the maps go, and is never another one."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from scenes import Apartment, SceneError
from scenes.scene_file import find_scene_file, take_scene_file
from test_scenes.places import two_rooms

CONTENT = b"a scene"


@pytest.fixture
def place(tmp_path: Path) -> Apartment:
    """A place whose scene file is in the folder ``home``; ``maps`` is empty."""
    digest = hashlib.sha256(CONTENT).hexdigest()
    (tmp_path / "home").mkdir()
    (tmp_path / "maps").mkdir()
    (tmp_path / "home" / "two-1.blend").write_bytes(CONTENT)
    return two_rooms(scene_file={"file": "two-1.blend", "sha256": digest})


def test_a_scene_file_is_taken_along(place: Apartment, tmp_path: Path) -> None:
    for _ in range(2):
        take_scene_file(place, tmp_path / "home", tmp_path / "maps")
    assert [item.name for item in (tmp_path / "maps").iterdir()] == ["two-1.blend"]
    assert find_scene_file(place, tmp_path / "maps").read_bytes() == CONTENT
    assert not (tmp_path / "maps" / "two-1.blend").samefile(tmp_path / "home" / "two-1.blend")
    take_scene_file(place, tmp_path / "home", tmp_path / "home")
    take_scene_file(two_rooms(), tmp_path / "nowhere", tmp_path / "maps")


def test_a_missing_or_changed_scene_file_is_one_line(place: Apartment, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"maps/two-1.blend: the 3D scene of 'two': No such file"):
        find_scene_file(place, tmp_path / "maps")
    other = tmp_path / "maps" / "two-1.blend"
    other.write_bytes(b"another scene")
    with pytest.raises(SceneError, match=r"maps/two-1.blend: not the 3D scene") as caught:
        take_scene_file(place, tmp_path / "home", tmp_path / "maps")
    assert "\n" not in str(caught.value)
    assert other.read_bytes() == b"another scene"
    with pytest.raises(SceneError, match=r"nowhere/two-1.blend: cannot be written: No such file"):
        take_scene_file(place, tmp_path / "home", tmp_path / "nowhere")


@pytest.mark.parametrize("name", ["../two.blend", "/etc/passwd", ".hidden", "a/b.blend"])
def test_a_scene_file_is_in_the_same_folder(name: str) -> None:
    with pytest.raises(ValueError, match="pattern"):
        two_rooms(scene_file={"file": name, "sha256": "0" * 64})
