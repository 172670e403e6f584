"""Visual passageway detection: straight lintel edges above the robot (§2.2.3).

What the paper says: Scharr gradients of the camera image within a cone of
φ ≈ 38° around the zenith vote into a histogram over gradient orientation θ and
offset s from the image centre; three more histograms are shifted by half a bin;
the feature of a map edge is the smaller of its two nodes' highest bins, among
the bins whose lintel lies across the edge.

What it leaves open, and what we chose:

* Bold face is lost in Table 2. We take I_min = 200, the coarse bins (18, 17)
  and ε = 60°: a blurred step edge gives a band of gradients two to three
  pixels wide, which fills one bin of 2 · 23 / 17 = 2.7 px but straddles several
  of 1.4 px, and a gradient of 400 under a noise of three grey levels scatters
  by about 7°, within one bin of 10°. Everything in Table 2 is an option, to be
  searched on the maps at hand.
* Frames. Image columns run right (along the heading) and rows run down; the
  camera looks up, so an azimuth a, counter-clockwise from above, appears at
  the image angle atan2(row, column) = a (see `dataset.camera`). Hence θ plus
  the node's heading is the lintel normal in the map frame, the frame of β.
* Eq. 6 takes the absolute value before fmod π and so does not wrap. Orientations
  are axes: we wrap the difference to [0°, 90°], so that β = 170° and Θ = 5° are
  15° apart and ε = 90° admits every bin.
* Eqs. 3 and 4: where θ + Δθ/2 wraps at π, the gradient changes its sign, and
  with it s. To the letter, the pixels of one line with θ ≈ 0 fall into two bins
  with offsets s and -s in all four histograms. We flip s along with θ.
* Eq. 2 with an odd N_s gives bins of half width at both ends, Eq. 4 does not;
  both are kept as they are.
* Other discs. φ and s_max scale with the camera's pixels per radian (s_max is
  23 px at 464 px for 190°), and so do the bins of s. Scharr magnitudes and
  counts stay raw: in a disc of half the size a lintel is half as long, and its
  band of gradients, always two to three pixels wide, spreads over more of the
  narrower bins. Its highest bin then holds a half to a sixth of the pixels:
  train and test with discs of similar size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np
from numpy.typing import NDArray

from dataset.camera import SIMULATED_CAMERA, FisheyeCamera
from dataset.topomap import Nodes

__all__ = [
    "TABLE_2",
    "LintelParameters",
    "LintelSearch",
    "bin_orientations",
    "edge_pixels",
    "lintel_histograms",
    "orientation_maxima",
    "orientation_maxima_of_all",
    "passageway_feature",
]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class LintelParameters:
    """Parameters of §2.2.3; all of Table 2 may be chosen.

    Attributes
    ----------
    min_intensity : float
        I_min, in units of OpenCV's Scharr operator on 8-bit images.
    orientation_bins, offset_bins : int
        N_θ, N_s.
    tolerance : float
        ε of Eq. 6, rad.
    search_angle : float
        φ, opening angle of the search cone, rad.
    max_offset : float
        s_max, px, in the simulated camera (464 px for 190°).
    """

    min_intensity: float = 200.0
    orientation_bins: int = 18
    offset_bins: int = 17
    tolerance: float = float(np.radians(60.0))
    search_angle: float = float(2.0 * np.arctan(65.0 / 190.0))
    max_offset: float = 23.0

    @property
    def histogram(self) -> tuple[float, int, int]:
        """What the histograms depend on: I_min, N_θ, N_s."""
        return self.min_intensity, self.orientation_bins, self.offset_bins


TABLE_2 = tuple(
    LintelParameters(intensity, *bins, tolerance=float(np.radians(degrees)))
    for intensity, bins, degrees in product(
        (100.0, 200.0, 400.0), ((18, 17), (36, 33)), (50, 55, 60, 65, 70, 80, 90)
    )
)
"""The 42 combinations of Table 2, ε varying fastest."""


@dataclass(frozen=True)
class LintelSearch:
    """The part of a camera's image in which lintels are looked for (Fig. 8b, outer ring).

    Attributes
    ----------
    window : pair of slices
        Rows and columns that hold the search disc and a margin for the operator.
    inside : array of bool
        Pixels of the window that belong to the search disc, m of them.
    column, row : arrays, shape (m,)
        p - c of Fig. 10, px.
    max_offset : float
        s_max in this camera, px.
    """

    window: tuple[slice, slice]
    inside: NDArray[np.bool_]
    column: Floats
    row: Floats
    max_offset: float

    @classmethod
    def of(cls, camera: FisheyeCamera, parameters: LintelParameters) -> LintelSearch:
        """Find the pixels within φ / 2 of the optical axis, and s_max."""
        inside = camera.pixel_zenith() <= parameters.search_angle / 2
        rows, columns = np.nonzero(inside)
        window = tuple(
            slice(max(int(at.min()) - 1, 0), int(at.max()) + 2) for at in (rows, columns)
        )
        scale = camera.pixels_per_radian / SIMULATED_CAMERA.pixels_per_radian
        return cls(
            (window[0], window[1]),
            inside[window],
            columns + 0.5 - camera.disc_centre[1],
            rows + 0.5 - camera.disc_centre[0],
            parameters.max_offset * scale,
        )

    @property
    def pixels(self) -> Integers:
        """(row, column) in the image of the m pixels of the search disc, shape (m, 2)."""
        corner = [part.start for part in self.window]
        found: Integers = np.argwhere(self.inside) + corner
        return found


def edge_pixels(
    image: NDArray[np.uint8], search: LintelSearch, min_intensity: float
) -> tuple[Floats, Floats, Integers]:
    """Orientation and offset of the edge pixels in the search disc (Eq. 1, Fig. 10).

    Parameters
    ----------
    image : array, shape (rows, columns), uint8
    search : LintelSearch
    min_intensity : float
        Pixels with I = |v| below it are dropped.

    Returns
    -------
    theta : array, shape (p,)
        θ = atan2(v2, v1), rad, in [0, π).
    s : array, shape (p,)
        Offset v · (p - c) / |v|, px, in (-s_max, s_max).
    index : array, shape (p,)
        Which of the search disc's pixels these are, for ``search.pixels[index]``.
    """
    theta, s, intensity, index = _gradients(image, search)
    strong = intensity >= min_intensity
    return theta[strong], s[strong], index[strong]


def _gradients(
    image: NDArray[np.uint8], search: LintelSearch
) -> tuple[Floats, Floats, Floats, Integers]:
    """θ, s, I and index of all pixels of the search disc with a gradient, |s| < s_max."""
    window = np.ascontiguousarray(image[search.window])
    g_x = cv2.Scharr(window, cv2.CV_64F, 1, 0)[search.inside]
    g_y = cv2.Scharr(window, cv2.CV_64F, 0, 1)[search.inside]
    sign = np.where((g_y < 0) | ((g_y == 0) & (g_x < 0)), -1.0, 1.0)  # Eq. 1
    v_1, v_2 = sign * g_x, sign * g_y + 0.0  # + 0.0: atan2 of a negative zero would be -π
    intensity = np.hypot(v_1, v_2)
    # A pixel without a gradient has no offset: 0 / 1, and is dropped.
    s = (v_1 * search.column + v_2 * search.row) / np.where(intensity > 0, intensity, 1.0)
    index = np.flatnonzero((intensity > 0) & (np.abs(s) < search.max_offset))
    return np.arctan2(v_2[index], v_1[index]), s[index], intensity[index], index


def lintel_histograms(
    theta: Floats, s: Floats, max_offset: float, parameters: LintelParameters
) -> Integers:
    """Fill the four edge-pixel histograms (Eqs. 2-5).

    Returns
    -------
    array, shape (2, 2, N_θ, N_s + 2)
        Pixels per bin: [shifted in θ, shifted in s, i, j], where index j = 0
        stands for the offset bin -ceil(N_s / 2).
    """
    n_theta, n_s = parameters.orientation_bins, parameters.offset_bins
    delta_theta, delta_s = np.pi / n_theta, 2.0 * max_offset / n_s
    turned = theta + delta_theta / 2
    wraps = turned >= np.pi
    by_theta = ((theta, s), (turned - np.pi * wraps, np.where(wraps, -s, s)))
    histograms = np.empty((2, 2, n_theta, n_s + 2), dtype=np.int64)
    for shift, (angle, offset) in enumerate(by_theta):
        i = np.minimum((angle / delta_theta).astype(np.int64), n_theta - 1)
        for shift_s in range(2):
            j = np.floor(offset / delta_s + shift_s / 2).astype(np.int64) + (n_s + 1) // 2
            counts = np.bincount(i * (n_s + 2) + j, minlength=n_theta * (n_s + 2))
            histograms[shift, shift_s] = counts.reshape(n_theta, n_s + 2)
    return histograms


def bin_orientations(parameters: LintelParameters) -> Floats:
    """Θ_i, the orientation in the middle of each bin, rad, shape (2, N_θ): plain, shifted."""
    delta = np.pi / parameters.orientation_bins
    index = np.arange(parameters.orientation_bins)
    return np.stack([(index + 0.5) * delta, index * delta])


def orientation_maxima(
    image: NDArray[np.uint8], search: LintelSearch, parameters: LintelParameters
) -> Integers:
    """Highest bin of each orientation over all offsets, the max over j of Eq. 7.

    Returns
    -------
    array, shape (2, N_θ)
        Pixels; the rows are those of `bin_orientations`.
    """
    return orientation_maxima_of_all(image, search, [parameters])[0]


def orientation_maxima_of_all(
    image: NDArray[np.uint8], search: LintelSearch, variants: Sequence[LintelParameters]
) -> list[Integers]:
    """`orientation_maxima` for several parameters; the gradients are computed once."""
    theta, s, intensity, _ = _gradients(image, search)
    maxima = []
    for parameters in variants:
        strong = intensity >= parameters.min_intensity
        histograms = lintel_histograms(theta[strong], s[strong], search.max_offset, parameters)
        maxima.append(histograms.max(axis=(1, 3)))
    return maxima


def passageway_feature(
    maxima: Integers, nodes: Nodes, edges: Integers, parameters: LintelParameters
) -> Floats:
    """Passageway feature of each edge, Ẽ of Eq. 8.

    Parameters
    ----------
    maxima : array, shape (n, 2, N_θ)
        `orientation_maxima` of every node's image.
    nodes : Nodes
    edges : array, shape (e', 2)

    Returns
    -------
    array, shape (e',)
        Pixels in the weaker of both nodes' highest admitted bins.
    """
    step = nodes.position[edges[:, 1]] - nodes.position[edges[:, 0]]
    beta = np.arctan2(step[:, 1], step[:, 0])
    ends = [
        _admitted_maximum(maxima[node], beta - nodes.heading[node], parameters) for node in edges.T
    ]
    return np.minimum(ends[0], ends[1]).astype(np.float64)


def _admitted_maximum(maxima: Integers, beta: Floats, parameters: LintelParameters) -> Integers:
    """Ĥ of Eq. 7 for β in the robot's frame; 0 where no bin is admitted, shape (e',)."""
    difference = beta[:, None, None] - bin_orientations(parameters)
    # Eq. 6, but wrapped: the distance of two axes, 0 .. 90 degrees.
    axis_distance = np.abs((difference + np.pi / 2) % np.pi - np.pi / 2)
    admitted = axis_distance <= parameters.tolerance + 1e-9
    best: Integers = np.where(admitted, maxima, 0).max(axis=(1, 2))
    return best
