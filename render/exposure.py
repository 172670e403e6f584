"""The simulated exposure control of §3.1.

The paper: a camera of linear response and limited range gives
i' = min(a i, i_max) with i_max = 255; the gain a starts at 1 and is updated by
a <- a/2 (i_max / mean i') until the mean of the *unfolded* image is about i_max / 2.

Left open there, chosen here:

- "the unfolded image" is the panorama of §2.2.4, so the 7 x 7 mean comes before
  unfolding and the histogram equalisation of Fig. 19 does not come at all. On a
  disc that is not 464 px the mask is scaled with it (and stays odd). Directions that
  the camera does not see do not count.
- "about" is within half a grey level.
- Convergence. f(a) = mean i' is concave and increasing with f(0) = 0, hence the
  update maps any a towards the solution without passing it; its error shrinks by
  the factor 1 - a f'(a) / f(a), the share of the brightness that saturated pixels
  contribute. Without saturation one step is exact; with much of it, convergence is
  geometric and slow. If more than half of the panorama is black there is no
  solution: the mean stands still once all that shines is saturated, and the loop
  ends there. An image without any light keeps a = 1.
- A camera's flaws (`render.flaws`): vignetting and blur belong to the light i; noise
  comes after the gain, which is found without it.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from dataset.camera import FisheyeCamera
from render.flaws import sensed, through_lens

__all__ = ["I_MAX", "expose", "unfolded_mean"]

I_MAX = 255.0
TOLERANCE = 0.5
MAX_ITERATIONS = 200
STANDSTILL = 1e-5


def unfolded_mean(image: NDArray[np.float32], camera: FisheyeCamera) -> float:
    """Mean of the blurred, unfolded panorama (§2.2.4) of ``image`` (h, w)."""
    width = camera.averaging_mask()
    blurred = cv2.blur(image, (width, width))
    map_x, map_y = camera.panorama_map()
    unfolded = cv2.remap(blurred, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    shown = camera.shows(map_x, map_y)
    return float(unfolded.mean(dtype=np.float64, where=shown)) if shown.any() else 0.0


def expose(
    radiance: NDArray[np.float32],
    camera: FisheyeCamera,
    rng: np.random.Generator | None = None,
    *,
    tolerance: float = TOLERANCE,
    max_iterations: int = MAX_ITERATIONS,
) -> tuple[NDArray[np.uint8], float]:
    """The 8-bit image of a linear one, and the gain that made it (§3.1).

    Parameters
    ----------
    radiance : array, shape ``camera.image_size``, float32
        Linear intensity i; negative values count as 0.
    camera : FisheyeCamera
        With its flaws.
    rng : numpy.random.Generator, optional
        Of the noise; without it an image of a camera that has noise is refused.
    tolerance : float
        Accepted distance of the panorama's mean from 127.5, grey levels.
    max_iterations : int
        Updates of the gain at most.

    Returns
    -------
    image : array, shape (h, w), uint8
        min(a i, 255), rounded; with noise, if the camera has it.
    gain : float
        a; 1 for an image without light.

    Raises
    ------
    ValueError
        If ``radiance`` has another shape or is not finite, or ``rng`` is missing.
    """
    light = np.asarray(radiance, dtype=np.float32)
    if light.shape != camera.image_size:
        raise ValueError(f"radiance: shape {light.shape}, expected {camera.image_size}")
    if not np.isfinite(light).all():
        raise ValueError("radiance: has values that are not finite")
    light = through_lens(np.maximum(light, 0.0), camera)
    gain = _converged_gain(light, camera, tolerance, max_iterations)
    if camera.flaws.full_well == 0.0:
        return np.rint(np.minimum(gain * light, I_MAX)).astype(np.uint8), gain
    if rng is None:
        raise ValueError("rng: missing, expected a generator for the camera's noise")
    return sensed(gain * light, camera.flaws, rng), gain


def _converged_gain(
    light: NDArray[np.float32], camera: FisheyeCamera, tolerance: float, max_iterations: int
) -> float:
    """Repeat a <- a/2 (i_max / mean) until the mean is i_max / 2 or stands still."""
    gain, previous = 1.0, -1.0
    for _ in range(max_iterations):
        mean = unfolded_mean(np.minimum(np.float32(gain) * light, np.float32(I_MAX)), camera)
        if mean <= 0.0:
            return gain
        # Too bright a mean stands still, too, as long as all is saturated.
        standstill = mean < I_MAX / 2.0 and abs(mean - previous) <= STANDSTILL * mean
        if abs(mean - I_MAX / 2.0) <= tolerance or standstill:
            return gain
        gain, previous = 0.5 * gain * (I_MAX / mean), mean
    return gain
