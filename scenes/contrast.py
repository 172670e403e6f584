"""How much the passageways of an apartment stand out (Table 8).

The paper judges this by eye and says low, medium or high. Chosen here: what makes a
doorway visible to a camera is the frame, so its contrast is the difference between
the reflectances (Rec. 709 luminance) of the frame, its head included, and of the wall
around it, relative to the brighter of the two: 0 for a frame in the wall's colour, 0.9
for a nearly black one on white. A passage without a frame has the wall's own surface
and contrast 0. The apartment's contrast is the median over its open passages.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from scenes.apartment import Apartment, Material, Passage
from scenes.materials import mean_colour, resolve
from scenes.solids import passage_rooms

__all__ = ["Contrast", "contrast_level", "passage_contrast", "passageway_contrast", "reflectance"]

Contrast = Literal["low", "medium", "high"]

LOW = 0.15
"""Below this the frames hardly differ from the walls: white paint on white plaster."""
HIGH = 0.6
"""From here on frames are several times darker or brighter than the walls."""
WEIGHTS = np.array([0.2126, 0.7152, 0.0722])


def reflectance(material: Material) -> float:
    """Mean luminance of a surface, 0..1."""
    return float(WEIGHTS @ np.array(mean_colour(material)))


def passage_contrast(apartment: Apartment, passage: Passage) -> float:
    """Contrast of one passage's frame to the walls on its two sides, 0..1."""
    if passage.frame is None:
        return 0.0
    frame = reflectance(resolve(apartment, passage.frame.material))
    names = [apartment.rooms[i].walls for i in passage_rooms(apartment, passage) if i is not None]
    walls = [reflectance(resolve(apartment, name)) for name in names]
    differences = [abs(frame - wall) / max(frame, wall, 1e-6) for wall in walls]
    return float(np.mean(differences)) if differences else 0.0


def passageway_contrast(apartment: Apartment) -> float:
    """Contrast of the passageways of an apartment, 0..1; 0 without any.

    Raises
    ------
    SceneError
        If a material is unknown.
    """
    open_ones = [passage for passage in apartment.passages if not passage.closed]
    found = [passage_contrast(apartment, passage) for passage in open_ones]
    return float(np.median(found)) if found else 0.0


def contrast_level(contrast: float) -> Contrast:
    """What Table 8 would call a contrast."""
    if contrast < LOW:
        return "low"
    return "medium" if contrast < HIGH else "high"
