"""Both sides of a scene's matte surfaces in one picture (`render.scene_surfaces`)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from render.charts import GUTTER, LEAST, Charts, Sheet, arrange
from render.contact import LIFT
from render.presets import Bake
from render.scene_surfaces import Surfaces

__all__ = ["SceneAtlas", "lay_out_scene"]

EYE_LEVEL = 0.3
"""No robot's camera is higher, m: what looks up above it is hardly seen."""
UNSEEN = 5.0
"""Texels of that, in texels of uprights."""
PER_RAY = 400.0
"""Texels for each ray that met a chart, at most (`render.scene_survey`)."""
UNMET = 0.05
"""Rays that a chart counts as met besides: a small one may be seen all the same."""
MOST_TEXELS = 1_500_000
LOOSE = 4.0
"""Texels of the rectangle about a chart, for each that the chart needs, at most."""
LONGEST = 2048
"""Texels of a chart in a row or column, at most."""
COVER = np.array([(-1.4, -0.9), (1.4, -0.9), (0.0, 1.8)])
"""A triangle about a texel's centre that covers it."""
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Numbers = NDArray[np.int32]


@dataclass(frozen=True)
class SceneAtlas(Sheet):
    """The charts of a scene: of each piece its front (even) and its back (odd).

    Attributes
    ----------
    uv : array, shape (2, n, 2)
        (column, row) of every corner's front and back, texels; 0 where nothing is matte.
    middles : array, shape (c, 3)
        The middle of every chart's corners, m.
    """

    uv: Floats
    middles: Floats

    @property
    def scaled_uv(self) -> Floats:
        """``uv`` in units of the picture: 0 to 1."""
        return self.uv / self.shape[::-1]


def lay_out_scene(surfaces: Surfaces, met: Floats, settings: Bake) -> SceneAtlas:
    """Charts for both sides of all pieces, and what gathers light for them.

    Parameters
    ----------
    surfaces : Surfaces
    met : array, shape (pieces, 2)
        See `render.scene_survey.survey`.
    settings : Bake
        Sizes of texels; larger ones are taken where few rays came, and for a scene that
        would need more than `MOST_TEXELS`.
    """
    triangles = np.concatenate([surfaces.triangles, surfaces.triangles[:, ::-1]])
    count = len(surfaces.triangles)
    side = np.arange(2).repeat(count)
    chart = (2 * surfaces.piece[triangles[:, 0]] + side).astype(np.int32)
    flat = surfaces.flat[triangles]
    whole, needed = _needs(surfaces, triangles, chart, settings)
    shape, charts = _fitted(flat, chart, whole, needed, met.ravel())
    uv = np.zeros((2, len(surfaces.points), 2))
    matte = surfaces.piece >= 0
    for back in (0, 1):
        number = (2 * surfaces.piece[matte] + back).astype(np.int32)
        uv[back, matte] = charts.place(surfaces.flat[matte][:, None], number)[:, 0]
    normals = np.stack([surfaces.facing, -surfaces.facing], axis=1).reshape(-1, 3)
    corners = surfaces.points[triangles]
    across = _unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    shading = surfaces.normals[triangles] * (1.0 - 2.0 * side)[:, None, None]
    received = charts.place(flat, chart)
    _cover_single_texels(received, charts, chart, flat)
    return SceneAtlas(
        shape,
        charts.boxes,
        normals,
        corners + LIFT * across[:, None],
        received,
        uv,
        _middles(corners, chart, len(normals)),
        receiver_normals=shading,
    )


def _middles(corners: Floats, chart: Numbers, count: int) -> Floats:
    """Mean of the charts' corners (t, 3, 3)."""
    middle = corners.mean(axis=1)
    total = np.stack([np.bincount(chart, middle[:, k], count) for k in range(3)], axis=1)
    return total / np.bincount(chart, minlength=count)[:, None]


def _needs(
    surfaces: Surfaces, triangles: Ints, chart: Numbers, settings: Bake
) -> tuple[Floats, Floats]:
    """Area of every chart, m², and the texels that it should have for its size."""
    count = 2 * len(surfaces.facing)
    texel = np.full(count, settings.upright)
    up = np.stack([surfaces.facing[:, 2], -surfaces.facing[:, 2]], axis=1).ravel()
    low = np.full(count, np.inf)
    np.minimum.at(low, chart, surfaces.points[triangles][..., 2].min(axis=1))
    texel[up < -0.5] = settings.overhead
    texel[up > 0.5] = settings.floor
    texel[(up > 0.5) & (low > EYE_LEVEL)] = UNSEEN * settings.upright
    flat = surfaces.flat[triangles]
    one, two = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    area = 0.5 * np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
    whole = np.bincount(chart, area, count) + 1e-12
    return whole, np.maximum(whole / texel**2, LEAST)


def _fitted(
    flat: Floats, chart: Numbers, whole: Floats, needed: Floats, met: Floats
) -> tuple[tuple[int, int], Charts]:
    """Charts with as many texels as they need, or fewer where few rays came, so that all fit."""
    low, high = np.full((len(whole), 2), np.inf), np.full((len(whole), 2), -np.inf)
    np.minimum.at(low, chart, flat.min(axis=1))
    np.maximum.at(high, chart, flat.max(axis=1))
    extent = high - low
    per_ray = PER_RAY
    while True:
        wanted = np.minimum(needed, per_ray * (met + UNMET))
        loosest = np.sqrt(extent.prod(axis=1) / (LOOSE * np.maximum(wanted, 1.0)))
        size = np.max([np.sqrt(whole / wanted), loosest, extent.max(axis=1) / LONGEST], axis=0)
        shape, charts = arrange(flat, chart, size)
        total = int(charts.counts.prod(axis=1, dtype=np.int64).sum())
        if total <= max(MOST_TEXELS, 4 * len(size)):
            return shape, charts
        per_ray *= 0.7


def _cover_single_texels(uv: Floats, charts: Charts, chart: Numbers, flat: Floats) -> None:
    """Let the largest triangle of a chart of one texel cover it, wherever it lies."""
    one, two = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    area = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
    single = (charts.counts == 1).all(axis=1)
    order = np.lexsort([-area, chart])
    largest = order[np.unique(chart[order], return_index=True)[1]]
    chosen = largest[single[chart[largest]]]
    uv[chosen] = (charts.origin[chart[chosen]] + GUTTER + 0.5)[:, None] + COVER


def _unit(vectors: Floats) -> Floats:
    found: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-15)
    return found
