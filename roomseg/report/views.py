"""What the method sees in one image, made ready to be shown (Figs. 8 and 21)."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from dataset.camera import FisheyeCamera
from roomseg.panorama import PanoramaParameters, Unfolding
from roomseg.passageway import LintelParameters, LintelSearch, edge_pixels, lintel_histograms
from roomseg.report.contents import LintelView, Snapshot

__all__ = ["search_lintel", "take_snapshot"]


def take_snapshot(node: int, image: NDArray[np.uint8], camera: FisheyeCamera) -> Snapshot:
    """Unfold the image of a node as the method does (§2.2.4)."""
    return Snapshot(node, image, Unfolding.of(camera, PanoramaParameters())(image))


def search_lintel(
    node: int,
    image: NDArray[np.uint8],
    camera: FisheyeCamera,
    parameters: LintelParameters | None = None,
) -> LintelView:
    """Search one image for a lintel and keep what Fig. 8 shows.

    Of the four histograms, the one with the highest bin is kept (§2.2.3).
    """
    parameters = parameters or LintelParameters()
    search = LintelSearch.of(camera, parameters)
    theta, s = edge_pixels(image, search, parameters.min_intensity)
    histograms = lintel_histograms(theta, s, search.max_offset, parameters)
    highest = np.unravel_index(np.argmax(histograms), histograms.shape)
    shift_theta, shift_s = int(highest[0]), int(highest[1])
    delta_theta = np.pi / parameters.orientation_bins
    delta_s = 2.0 * search.max_offset / parameters.offset_bins
    left = -((parameters.offset_bins + 1) // 2 + 0.5 * shift_s) * delta_s
    start = -0.5 * shift_theta * delta_theta
    return LintelView(
        node=node,
        image=image,
        camera=camera,
        pixels=_edge_pixel_positions(image, search, parameters.min_intensity),
        theta=theta,
        histogram=histograms[shift_theta, shift_s],
        directions=(start, start + np.pi),
        offsets=(left, left + histograms.shape[3] * delta_s),
        offset_limit=search.max_offset,
    )


def _edge_pixel_positions(
    image: NDArray[np.uint8], search: LintelSearch, min_intensity: float
) -> NDArray[np.int64]:
    """Find (row, column) of the pixels that `edge_pixels` speaks of, in its order.

    The method needs only their direction and offset; where they are is for looking.
    """
    window = np.ascontiguousarray(image[search.window])
    g_x = cv2.Scharr(window, cv2.CV_64F, 1, 0)[search.inside]
    g_y = cv2.Scharr(window, cv2.CV_64F, 0, 1)[search.inside]
    intensity = np.hypot(g_x, g_y)
    along = np.abs(g_x * search.column + g_y * search.row)
    shown = (intensity >= min_intensity) & (along < search.max_offset * intensity)
    corner = [part.start for part in search.window]
    found: NDArray[np.int64] = (np.argwhere(search.inside) + corner)[shown]
    return found
