"""From a node's light to the frame that is kept: rounded, exposed, packed.

Done where a frame is rendered, so that only what is stored travels to the map's writer.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dataset.camera import FisheyeCamera
from dataset.frames import Frame, Radiance, pack_image, pack_radiance
from render.exposure import expose

__all__ = ["develop", "noise_of"]

NOISE = 0x5E45
"""Tells the noise of the images from whatever else is drawn from the run's seed."""


def develop(
    node: int,
    light: NDArray[np.float32],
    camera: FisheyeCamera,
    seed: int,
    *,
    keep_radiance: bool,
) -> Frame:
    """The frame of a node.

    Parameters
    ----------
    node : int
    light : array, shape ``camera.image_size``
        Linear. It is rounded to float16 before it is exposed, kept or not: `expose_map`
        then makes of what was kept the very images that rendering made.
    camera : FisheyeCamera
    seed : int
        Of the run.
    keep_radiance : bool
    """
    radiance = Radiance.of(light)
    image, gain = expose(radiance.light, camera, noise_of(seed, node))
    size = camera.image_size
    if not keep_radiance:
        return Frame(node, pack_image(image, size), gain)
    kept = pack_radiance(radiance, size)
    return Frame(node, pack_image(image, size), gain, kept, radiance.exponent)


def noise_of(seed: int, node: int) -> np.random.Generator:
    """The generator of a node's noise, whoever renders it and when."""
    return np.random.default_rng(np.random.SeedSequence([seed % 2**64, node, NOISE]))
