"""Commands that take a map or an apartment, a model or a folder: what a name means."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

__all__ = ["Kind", "is_apartment", "kind_of"]

Kind = Literal["map", "apartment", "model", "folder"]
MODEL = ".skops"


def is_apartment(source: Path) -> bool:
    """Whether that is the name of an apartment's file or of a reference place."""
    if source.suffix:
        return source.suffix == ".json"
    from scenes import reference_names

    return str(source) in reference_names() or not source.exists()


def kind_of(source: Path) -> Kind:
    """Tell by name what that is; a folder is one whatever its name."""
    if source.is_dir():
        return "folder"
    if source.suffix == MODEL:
        return "model"
    return "apartment" if is_apartment(source) else "map"
