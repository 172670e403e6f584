"""``roomseg export map.h5 -o run.rrd``: gather what a recording shows, and write it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from dataset import MapFile
    from scenes import Apartment

__all__ = ["write_recording"]


def write_recording(source: Path, output: Path) -> None:
    """Write the run of a map as a Rerun recording, whole or not at all.

    Raises
    ------
    RoomsegError
        If the map cannot be read, the recording cannot be written, or Rerun is
        not installed.
    """
    from dataset import MapFile
    from dataset.atomic import replacing
    from roomseg.cli.panels import coverage_of
    from roomseg.recording import recording_bytes
    from scenes import apartment_from_json

    with MapFile(source) as file:
        topomap = file.topomap
        place = None
        if topomap.scene is not None:
            place = apartment_from_json(topomap.scene, origin=f"{source}: /scene")
        content = recording_bytes(
            topomap,
            None if place is None else _plans(place),
            coverage_of(topomap),
            _images(file),
        )
    with replacing(output) as part:
        part.write_bytes(content)


def _plans(place: Apartment) -> dict[str, Any]:
    """What stands near the floor: the building and the furniture apart."""
    from scenes import obstacles

    walls = obstacles(place.model_copy(update={"furniture": ()}))
    return {"walls": walls, "furniture": obstacles(place).difference(walls)}


def _images(file: MapFile) -> Iterator[tuple[int, NDArray[np.uint8]]]:
    for node in file.done.nonzero()[0]:
        yield int(node), file.image(int(node))
