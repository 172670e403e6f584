"""The 3D scene that belongs to an apartment: found beside it, checked, taken along.

Its name holds the first digits of its content's SHA-256, so that files of different
content do not meet under one name.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from scenes.apartment import Apartment
from scenes.errors import SceneError
from scenes.storage import save_bytes

__all__ = ["find_scene_file", "take_scene_file"]


def find_scene_file(apartment: Apartment, folder: str | Path) -> Path:
    """The scene file of an apartment in a folder, with the content that it should have.

    Raises
    ------
    SceneError
        If it is not there or another one.
    """
    assert apartment.scene_file is not None
    path = Path(folder) / apartment.scene_file.file
    try:
        with path.open("rb") as stream:
            found = hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError as error:
        raise SceneError(
            f"{path}: the 3D scene of {apartment.name!r}: {error.strerror or error}; expected it "
            f"in the folder of the apartment's or map's own file"
        ) from None
    if found != apartment.scene_file.sha256:
        raise SceneError(
            f"{path}: not the 3D scene that {apartment.name!r} was made from: SHA-256 "
            f"{found[:8]}…; expected {apartment.scene_file.sha256[:8]}…"
        )
    return path


def take_scene_file(apartment: Apartment, source: str | Path, target: str | Path) -> None:
    """Copy the scene file of an apartment to another folder, unless it is there.

    A copy, not a link: what is written into one later does not change the other.

    Parameters
    ----------
    apartment : Apartment
        Nothing happens if it has no scene file.
    source, target : path
        Folders.

    Raises
    ------
    SceneError
        If the file is missing, or a file of its name and other content is in the way.
    """
    if apartment.scene_file is None:
        return
    path, copy = find_scene_file(apartment, source), Path(target) / apartment.scene_file.file
    if copy.exists():
        find_scene_file(apartment, target)
        return
    save_bytes(path.read_bytes(), copy)
