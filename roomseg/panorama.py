"""Unfolded panoramas and their two rotation-invariant distances (§2.2.4).

The order of steps is that of Fig. 19 and §2.2.4: a 7 × 7 mean of the camera
image against aliasing, unfolding to 288 × 48 pixels (elevations 75° to 0°),
histogram equalisation. The equalisation stands only in the caption of Fig. 19.

* §2.2.4 says that a segment spans 75°/8 = 12.5°; it is 9.4°. Eight segments of
  six rows stand.
* "The first twelve Fourier coefficients" begin with the mean (coefficient 0)
  and are unnormalised sums over the 288 columns, as in Matlab's ``fft``.
* In discs of other sizes the mask of the mean scales to the nearest odd number.
* What an image cropped by the sensor does not show is continued from its edge; what
  lies outside a disc of less than 180° is black, the same in all images.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import fft

from dataset.camera import FisheyeCamera

__all__ = [
    "PanoramaParameters",
    "Unfolding",
    "compass_distances",
    "signature_distances",
    "signatures",
]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Pixels = NDArray[np.uint8]


@dataclass(frozen=True)
class PanoramaParameters:
    """Parameters of §2.2.4.

    Attributes
    ----------
    width, height : int
        Of the unfolded image, px.
    top_elevation : float
        Of its upper border, rad.
    mask : int
        Side of the mean's mask in the simulated camera (464 px for 190°), px.
    segments, coefficients : int
        Of the signature.
    """

    width: int = 288
    height: int = 48
    top_elevation: float = float(np.radians(75.0))
    mask: int = 7
    segments: int = 8
    coefficients: int = 12


@dataclass(frozen=True)
class Unfolding:
    """Camera image → unfolded panorama, for one camera.

    Attributes
    ----------
    map_x, map_y : arrays, shape (height, width), float32
        Where each panorama pixel lies in the image, for ``cv2.remap``.
    mask : int
        Side of the averaging mask, px, odd.
    """

    map_x: NDArray[np.float32]
    map_y: NDArray[np.float32]
    mask: int

    @classmethod
    def of(cls, camera: FisheyeCamera, parameters: PanoramaParameters) -> Unfolding:
        """Look up the panorama's pixels in the camera's image."""
        map_x, map_y = camera.panorama_map(
            parameters.width, parameters.height, parameters.top_elevation
        )
        return cls(map_x, map_y, camera.averaging_mask(parameters.mask))

    def __call__(self, image: Pixels) -> Pixels:
        """Mean, unfold, equalise.

        Parameters
        ----------
        image : array, shape (rows, columns), uint8

        Returns
        -------
        array, shape (height, width), uint8
            Columns are azimuths, the top row is the highest elevation.
        """
        smooth = cv2.blur(np.ascontiguousarray(image), (self.mask, self.mask))
        unfolded = cv2.remap(
            smooth, self.map_x, self.map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        equalised: Pixels = np.asarray(cv2.equalizeHist(unfolded), dtype=np.uint8)
        return equalised


def compass_distances(panoramas: Pixels, edges: Integers, batch: int = 32) -> Floats:
    """d_c: lowest Euclidean image distance over all rotations (Eqs. 9, 10).

    |I_k - I_l,δ|² = |I_k|² + |I_l|² - 2 c(δ), and the circular correlation c
    over all δ comes from one Fourier transform. Pixels are integers, so c is
    one too: rounding it makes the result exact.

    Parameters
    ----------
    panoramas : array, shape (n, height, width), uint8
    edges : array, shape (e', 2)
    batch : int
        Edges per step; bounds the memory.

    Returns
    -------
    array, shape (e',)
        Grey levels.
    """
    norm = np.einsum("nyx,nyx->n", panoramas, panoramas, dtype=np.float64, casting="unsafe")
    peak = np.empty(len(edges))
    for begin in range(0, len(edges), batch):
        chunk = edges[begin : begin + batch]
        nodes, at = np.unique(chunk, return_inverse=True)
        spectra = fft.rfft(panoramas[nodes].astype(np.float64), axis=2)[at.reshape(-1, 2)]
        product = np.einsum("eyf,eyf->ef", spectra[:, 0].conj(), spectra[:, 1])
        correlation = fft.irfft(product, n=panoramas.shape[2], axis=1)
        peak[begin : begin + batch] = np.rint(correlation.max(axis=1))
    distance: Floats = np.sqrt(norm[edges[:, 0]] + norm[edges[:, 1]] - 2.0 * peak)
    return distance


def signatures(panoramas: Pixels, parameters: PanoramaParameters | None = None) -> Floats:
    """s_afc: absolute Fourier coefficients of the averaged segments (§2.2.4).

    Returns
    -------
    array, shape (n, segments * coefficients)
    """
    parameters = parameters or PanoramaParameters()
    n, _, width = panoramas.shape
    rows = panoramas.reshape(n, parameters.segments, -1, width).mean(axis=2)
    coefficients: Floats = np.abs(fft.rfft(rows, axis=2)[:, :, : parameters.coefficients])
    return coefficients.reshape(n, -1)


def signature_distances(
    panoramas: Pixels, edges: Integers, parameters: PanoramaParameters | None = None
) -> Floats:
    """d_s: Euclidean distance of the image signatures (Eq. 11), shape (e',)."""
    signature = signatures(panoramas, parameters)
    distance: Floats = np.linalg.norm(signature[edges[:, 0]] - signature[edges[:, 1]], axis=1)
    return distance
