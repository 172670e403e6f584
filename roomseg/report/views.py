"""What the method sees in one image or around one edge, made ready to show (Figs. 7, 8, 21)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from dataset.camera import FisheyeCamera
from dataset.topomap import TopoMap
from roomseg.panorama import PanoramaParameters, Unfolding
from roomseg.passage_width import (
    LocalObstacles,
    WidthParameters,
    passageway_widths,
    search_strips,
)
from roomseg.passageway import LintelParameters, LintelSearch, edge_pixels, lintel_histograms
from roomseg.report.contents import LintelView, PassageView, Snapshot

__all__ = ["measure_passage", "search_lintel", "take_snapshot"]


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
    theta, s, index = edge_pixels(image, search, parameters.min_intensity)
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
        pixels=search.pixels[index],
        theta=theta,
        histogram=histograms[shift_theta, shift_s],
        directions=(start, start + np.pi),
        offsets=(left, left + histograms.shape[3] * delta_s),
        offset_limit=search.max_offset,
    )


def measure_passage(
    topomap: TopoMap,
    edges: NDArray[Any] | None = None,
    parameters: WidthParameters | None = None,
) -> PassageView | None:
    """Show the width at the border edge whose width is the median of all measured ones.

    Parameters
    ----------
    edges : array, shape (e', 2), optional
        Edges left after preprocessing; all of the map if absent.

    Returns
    -------
    PassageView or None
        None if no true border edge has enough obstacle data.
    """
    parameters = parameters or WidthParameters()
    if topomap.ground_truth is None:
        return None
    border = topomap.edges[topomap.ground_truth.edge_is_border]
    if edges is not None:
        border = border[(border[:, None] == np.asarray(edges)[None]).all(axis=2).any(axis=1)]
    width = passageway_widths(topomap, border.astype(np.int64), parameters)
    measured = np.flatnonzero(width < parameters.default)
    if not len(measured):
        return None
    typical = measured[np.argsort(width[measured])[len(measured) // 2]]
    edge = border[typical]
    points = LocalObstacles.of(topomap, parameters).near(*edge)
    begin, end, _ = search_strips(topomap.nodes, edge[None], topomap.robot_radius, parameters)[0]
    ends = topomap.nodes.position[edge]
    shown = max(1.2, float(width[typical]))
    strip = (float(begin), float(end))
    return PassageView(
        ends=ends,
        obstacles=points[np.linalg.norm(points - ends.mean(axis=0), axis=1) < shown],
        closest=_pair_at_distance(points, ends, strip, float(width[typical])),
        strip=strip,
        width=float(width[typical]),
    )


def _pair_at_distance(
    points: NDArray[np.float64],
    ends: NDArray[np.float64],
    strip: tuple[float, float],
    width: float,
) -> NDArray[np.float64]:
    """Find the points on either side of the edge whose distance is the width found."""
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    offset = points - ends.mean(axis=0)
    x, y = offset @ along, offset @ np.array([-along[1], along[0]])
    inside = (x >= strip[0]) & (x <= strip[1])
    left, right = points[inside & (y > 0)], points[inside & (y <= 0)]
    distance = np.linalg.norm(left[:, None] - right[None], axis=2)
    i, j = np.unravel_index(np.argmin(np.abs(distance - width)), distance.shape)
    return np.stack([left[i], right[j]])
