"""Some images of a map next to their panoramas, as in Figs. 20 and 21."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from roomseg.figures.camera_images import draw_camera_image, draw_panorama
from roomseg.figures.style import INK, new_figure

__all__ = ["contact_sheet_figure"]

COLUMNS = 3
WIDTH = 3.0
"""Of an image, inches."""

Pixels = NDArray[np.uint8]


def contact_sheet_figure(title: str, views: Sequence[tuple[str, Pixels, Pixels]]) -> Figure:
    """Draw images with their panoramas below, row by row.

    Parameters
    ----------
    title : str
    views : sequence of (str, array, array)
        Caption, image (rows, columns) and panorama (48, 288), of one camera; at least one.
    """
    columns = min(COLUMNS, len(views))
    rows = -(-len(views) // columns)
    height, width = views[0][1].shape
    heights = (WIDTH * height / width + 0.25, WIDTH * 75 / 360 + 0.3)
    figure = new_figure(columns * (WIDTH + 0.25), rows * sum(heights) + 0.4)
    figure.suptitle(title, fontsize=11, color=INK)
    axes = figure.subplots(2 * rows, columns, squeeze=False, height_ratios=heights * rows)
    for ax in axes.flat:
        ax.set_axis_off()
    for index, (caption, image, panorama) in enumerate(views):
        row, column = divmod(index, columns)
        draw_camera_image(axes[2 * row, column], image, caption)
        below = axes[2 * row + 1, column]
        below.set_axis_on()
        draw_panorama(below, panorama)
    return figure
