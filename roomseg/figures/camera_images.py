"""Figures of camera images, panoramas and the lintel search (Figs. 8, 20, 21)."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.collections import PatchCollection
from matplotlib.colors import hsv_to_rgb
from matplotlib.patches import Circle, Rectangle
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike, NDArray

from dataset.camera import FisheyeCamera
from roomseg.figures.style import INK

__all__ = [
    "OFFSET_ANGLE",
    "SEARCH_ANGLE",
    "direction_colours",
    "draw_camera_image",
    "draw_edge_pixels",
    "draw_lintel_histogram",
    "draw_lintel_search",
    "draw_panorama",
]

SEARCH_ANGLE = float(2.0 * np.arctan2(0.65, 1.90))
"""Opening angle of the edge-search cone, about 38 degrees, rad (§2.2.3)."""
OFFSET_ANGLE = float(2.0 * np.arctan2(0.30, 1.90))
"""Opening angle of the edge-offset cone, about 18 degrees, rad (§2.2.3)."""

_CONE_COLOUR = "#FFD23F"


def draw_camera_image(ax: Any, image: ArrayLike, title: str | None = None) -> None:
    """Draw one exposed camera image, as the robot sees it looking up (Fig. 20).

    Axes are in px, with pixel (r, c) from (r, c) to (r + 1, c + 1), as in `dataset.camera`.
    """
    pixels = np.asarray(image)
    rows, columns = pixels.shape
    ax.imshow(
        pixels,
        cmap="gray",
        vmin=0,
        vmax=255,
        extent=(0, columns, rows, 0),
        interpolation="nearest",
        gid="camera-image",
    )
    ax.set_axis_off()
    if title:
        ax.set_title(title, fontsize=9, color=INK)


def draw_panorama(ax: Any, panorama: ArrayLike, title: str | None = None) -> None:
    """Draw one unfolded panorama: azimuth to the right, elevation 0 at the bottom (Fig. 21)."""
    ax.imshow(
        np.asarray(panorama),
        cmap="gray",
        vmin=0,
        vmax=255,
        extent=(0, 360, 0, 75),
        aspect="equal",
        interpolation="nearest",
        gid="panorama",
    )
    ax.set_xticks([0, 90, 180, 270, 360], ["0°", "90°", "180°", "270°", "360°"], fontsize=7)
    ax.set_yticks([0, 75], ["0°", "75°"], fontsize=7)
    ax.tick_params(length=2, width=0.5, colors=INK)
    for spine in ax.spines.values():
        spine.set_linewidth(0.5)
    if title:
        ax.set_title(title, fontsize=9, color=INK)


def _cone(camera: FisheyeCamera, angle: float, style: Any) -> Circle:
    """Rim of a cone around the optical axis with that opening angle, as seen in the image."""
    row, column = camera.disc_centre
    return Circle(
        (column, row),
        0.5 * angle * camera.pixels_per_radian,
        fill=False,
        edgecolor=_CONE_COLOUR,
        linestyle=style,
        linewidth=1.4,
        gid="cone",
    )


def _draw_cones(ax: Any, camera: FisheyeCamera) -> None:
    ax.add_patch(_cone(camera, SEARCH_ANGLE, "solid"))
    ax.add_patch(_cone(camera, OFFSET_ANGLE, (0, (3, 2))))


def _detail_box(camera: FisheyeCamera) -> tuple[float, float, float, float]:
    """Column and row bounds (left, right, top, bottom) of the detail in Fig. 8b, px."""
    half = 0.55 * SEARCH_ANGLE * camera.pixels_per_radian
    row, column = camera.disc_centre
    return column - half, column + half, row - half, row + half


def draw_lintel_search(
    ax: Any, image: ArrayLike, camera: FisheyeCamera, title: str | None = None
) -> None:
    """Draw the whole image with both cones and the rectangle of the detail (Fig. 8a)."""
    draw_camera_image(ax, image, title)
    _draw_cones(ax, camera)
    left, right, top, bottom = _detail_box(camera)
    box = Rectangle(
        (left, top),
        right - left,
        bottom - top,
        fill=False,
        edgecolor="white",
        linestyle=(0, (4, 3)),
        linewidth=0.9,
        gid="detail",
    )
    ax.add_patch(box)


def direction_colours(theta: ArrayLike) -> NDArray[np.float64]:
    """RGB of gradient directions, rad: the hue circle once per pi, shape (..., 3)."""
    hue = np.mod(np.asarray(theta, dtype=float), np.pi) / np.pi
    return hsv_to_rgb(np.stack([hue, np.full_like(hue, 0.85), np.full_like(hue, 1.0)], -1))


def draw_edge_pixels(
    ax: Any,
    image: ArrayLike,
    camera: FisheyeCamera,
    *,
    pixels: ArrayLike,
    theta: ArrayLike,
    title: str | None = None,
) -> None:
    """Draw the image above the robot, edge pixels in the hue of their direction (Fig. 8b).

    Parameters
    ----------
    pixels : array of int, shape (p, 2)
        (row, column) of each edge pixel, counted from 0.
    theta : array, shape (p,)
        Gradient direction of Eq. 1, rad in [0, pi).
    """
    draw_camera_image(ax, image, title)
    squares = [Rectangle((column, row), 1, 1) for row, column in np.asarray(pixels)]
    ax.add_collection(
        PatchCollection(
            squares,
            facecolors=direction_colours(theta),
            edgecolors="none",
            gid="edge-pixels",
        )
    )
    _draw_cones(ax, camera)
    left, right, top, bottom = _detail_box(camera)
    ax.set_xlim(left, right)
    ax.set_ylim(bottom, top)


def draw_lintel_histogram(
    ax: Any,
    histogram: ArrayLike,
    *,
    directions: tuple[float, float],
    offsets: tuple[float, float],
    offset_limit: float,
    title: str | None = None,
) -> None:
    """Draw the edge-pixel histogram with its maximum marked (Fig. 8c).

    Parameters
    ----------
    histogram : array, shape (N_theta, N_s)
        Pixels per bin of direction (rows) and offset (columns), Eq. 2.
    directions : tuple of float
        Where the first row begins and the last one ends, rad.
    offsets : tuple of float
        Where the first column begins and the last one ends, px.
    offset_limit : float
        s_max, px: the columns shown.
    """
    counts = np.asarray(histogram)
    top, bottom = np.degrees(directions)
    picture = ax.imshow(
        counts,
        cmap="cividis",
        vmin=0,
        extent=(*offsets, bottom, top),
        aspect="auto",
        interpolation="nearest",
        gid="histogram",
    )
    i, j = np.unravel_index(np.argmax(counts), counts.shape)
    centre = (
        offsets[0] + (j + 0.5) * (offsets[1] - offsets[0]) / counts.shape[1],
        top + (i + 0.5) * (bottom - top) / counts.shape[0],
    )
    _mark_maximum(ax, centre, int(counts[i, j]), offset_limit)
    ax.set_xlim(-offset_limit, offset_limit)
    ax.set_xlabel("edge offset s (px)", fontsize=8)
    ax.set_ylabel("edge direction θ (°)", fontsize=8)
    ax.set_yticks([0, 45, 90, 135, 180])
    ax.set_ylim(bottom, top)
    ax.tick_params(labelsize=7, length=2)
    bar = ax.figure.colorbar(picture, ax=ax, fraction=0.05, pad=0.02)
    bar.set_label("edge pixels", fontsize=8)
    bar.ax.tick_params(labelsize=7, length=2)
    if title:
        ax.set_title(title, fontsize=9, color=INK)


def _mark_maximum(ax: Any, centre: tuple[Any, Any], count: int, offset_limit: float) -> None:
    """Ring the highest bin and write its count on the side that has room."""
    side = -1 if centre[0] > 0.2 * offset_limit else 1
    below = -15 if centre[1] < 15.0 else 0
    ax.plot(*centre, "o", ms=13, mfc="none", mec="#E8562A", mew=1.8, gid="maximum")
    ax.annotate(
        rf"$\hat H$ = {count}",
        centre,
        xytext=(11 * side, below),
        textcoords="offset points",
        ha="left" if side > 0 else "right",
        va="center",
        color="white",
        fontsize=9,
        path_effects=[withStroke(linewidth=2.0, foreground="#00204C")],
    )
