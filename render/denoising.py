"""Quietening a bake: OpenImageDenoise over the atlas, and texels that nobody lit.

What guides the denoiser is each chart's normal and a colour of its own, so that light
does not run from one chart into its neighbour.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from render.charts import Sheet
from render.open_image_denoise import Denoiser

__all__ = ["continued", "denoise"]

SCATTER = 4
"""How far from the nearest texel another one is taken for it."""
TRIES = 8
DARKEST = 1e-6
"""Charts are not brightened from below that, W/m²/sr."""
Picture = NDArray[np.float32]


def continued(
    picture: Picture,
    covered: NDArray[np.bool_],
    boxes: NDArray[np.int32],
    generator: np.random.Generator | None = None,
) -> Picture:
    """The picture with every chart's uncovered texels set to the nearest covered one.

    Parameters
    ----------
    picture : array, shape (rows, columns, 3)
    covered : array, shape (rows, columns)
    boxes : array, shape (c, 4)
        First row, first column, rows, columns of every chart; a chart without a
        covered texel becomes black.
    generator : numpy.random.Generator, optional
        Take any texel near the nearest one: noise goes on as noise. Streaks would
        look like something that is there, and the denoiser would keep them.
    """
    made = np.zeros_like(picture)
    for row, column, rows, columns in boxes.tolist():
        window = np.s_[row : row + rows, column : column + columns]
        inside = covered[window]
        if inside.all():
            made[window] = picture[window]
        elif inside.any():
            near = ndimage.distance_transform_edt(
                ~inside, return_distances=False, return_indices=True
            )
            if generator is not None:
                near = _scattered(near, inside, generator)
            made[window] = picture[window][tuple(near)]
    return made


def _scattered(
    near: NDArray[np.int32], inside: NDArray[np.bool_], generator: np.random.Generator
) -> NDArray[np.int32]:
    """Texels (2, rows, columns) about those in ``near``, where they are inside, too."""
    found = near.copy()
    limit = np.array(inside.shape)[:, None, None] - 1
    for _ in range(TRIES):
        steps = generator.integers(-SCATTER, SCATTER + 1, near.shape)
        other = np.clip(near + steps, 0, limit)
        better = ~inside & inside[tuple(other)]
        found[:, better] = other[:, better]
    return found


def denoise(denoiser: Denoiser, picture: Picture, atlas: Sheet) -> Picture:
    """The picture (rows, columns, 3), denoised.

    Every chart is brought to the same mean brightness for it: a window's reveal would
    otherwise shine into the charts beside it, which are a thousandth as bright.
    """
    level = _levels(picture, atlas)
    albedo, normal = _guides(atlas)
    return denoiser(picture / level, {"albedo": albedo, "normal": normal}) * level


def _levels(picture: Picture, atlas: Sheet) -> Picture:
    """Mean of the chart of every texel, (rows, columns, 1); never 0."""
    level = np.full((*atlas.shape, 1), max(float(picture.mean()), DARKEST), dtype=np.float32)
    for row, column, rows, columns in atlas.boxes.tolist():
        window = np.s_[row : row + rows, column : column + columns]
        level[window] = max(float(picture[window].mean()), DARKEST)
    return level


def _guides(atlas: Sheet) -> tuple[Picture, Picture]:
    """A colour for every chart, all over its box, and its normal (rows, columns, 3)."""
    colours = np.random.default_rng(0).uniform(0.1, 1.0, (len(atlas.boxes), 3))
    colour = np.zeros((*atlas.shape, 3), dtype=np.float32)
    normal = np.zeros_like(colour)
    for chart, (row, column, rows, columns) in enumerate(atlas.boxes.tolist()):
        window = np.s_[row : row + rows, column : column + columns]
        colour[window], normal[window] = colours[chart], atlas.normals[chart]
    return colour, normal
