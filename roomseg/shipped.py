"""The model that comes with roomseg, for maps whose rooms nobody has drawn.

docs/method.md tells what it was trained on, and the command; so does
`roomseg view` of the file.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from dataset.storage import MapFile
from roomseg.classifier import BorderModel, load_model

__all__ = ["SHIPPED_MODEL", "fits_shipped_model", "shipped_model"]

SHIPPED_MODEL = Path(__file__).parent / "models" / "reference.skops"

DISC_DIAMETER = 464.0
"""Pixels of the images that it was trained on; features count pixels and grey levels."""
ALIKE = 1.2
"""Discs so many times larger or smaller will do."""


def fits_shipped_model(map_file: MapFile) -> bool:
    """Whether a map has all its images, and of about the size that the model knows."""
    ratio = map_file.topomap.camera.disc_diameter / DISC_DIAMETER
    complete = len(map_file.done) > 0 and bool(map_file.done.all())
    return complete and 1.0 / ALIKE <= ratio <= ALIKE


@cache
def shipped_model() -> BorderModel:
    """Load it; five features, so that a map needs its images."""
    return load_model(SHIPPED_MODEL)
