"""A real camera's flaws, on rendered light (§3.1: "similar to those captured by our robot").

The paper's renderer has none: its pixels are min(a i, 255). Its robot's camera does, and
the order in which they come is that of the light:

1. Vignetting and blur are the lens's. They act on the light i before the exposure, so
   a lamp outshines its surroundings by its true brightness, and the gain a makes up for
   what the rim loses.
2. The exposure control sets the exposure *time* (§3.1), so a grey level is the same number
   of electrons in bright rooms and in dark ones: i' / 255 of the full well. Their number is
   a Poisson variable: shot noise.
3. A full pixel stays full; reading it out adds normal noise; 8 bits are left.

Left out: an exposure time too long to wait for, dark current, fixed patterns, a black
level (negative values are cut off), defective pixels.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from dataset.camera import CameraFlaws, FisheyeCamera

__all__ = ["sensed", "through_lens"]

MOST_ELECTRONS = 1e12
"""More than any pixel holds, and few enough for a Poisson variable."""


def through_lens(light: NDArray[np.float32], camera: FisheyeCamera) -> NDArray[np.float32]:
    """Light (h, w) behind the lens: less towards the rim, and blurred."""
    flaws = camera.flaws
    if flaws.vignetting > 0.0:
        off_axis = np.minimum(camera.pixel_zenith() / (0.5 * camera.field_of_view), 1.0)
        light = light * (1.0 - flaws.vignetting * off_axis**2).astype(np.float32)
    if flaws.blur > 0.0:
        blurred = cv2.GaussianBlur(light, (0, 0), flaws.blur, borderType=cv2.BORDER_REPLICATE)
        light = np.asarray(blurred, dtype=np.float32)
    return light


def sensed(
    exposed: NDArray[np.float32], flaws: CameraFlaws, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """Grey levels of an exposed image with shot and read noise.

    Parameters
    ----------
    exposed : array, shape (h, w), float32
        a i, not negative; above 255 the pixel is full.
    flaws : CameraFlaws
        With a ``full_well``.
    rng : numpy.random.Generator

    Returns
    -------
    array, shape (h, w), uint8
    """
    level = flaws.full_well / 255.0
    expected = np.minimum(exposed.astype(np.float64) * level, MOST_ELECTRONS)
    electrons = np.minimum(rng.poisson(expected), flaws.full_well)
    read = electrons + rng.normal(0.0, flaws.read_noise, electrons.shape)
    grey: NDArray[np.uint8] = np.rint(np.clip(read / level, 0.0, 255.0)).astype(np.uint8)
    return grey
