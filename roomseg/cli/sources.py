"""Commands that take a map or an apartment: which of the two a name means."""

from __future__ import annotations

from pathlib import Path

__all__ = ["is_apartment"]


def is_apartment(source: Path) -> bool:
    """Whether that is the name of an apartment's file or of a reference place."""
    if source.suffix:
        return source.suffix == ".json"
    from scenes import reference_names

    return str(source) in reference_names() or not source.exists()
