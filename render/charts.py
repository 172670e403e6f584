"""Flat pieces of a mesh laid out in one picture, and what gathers light for it.

A chart is all triangles that lie in one plane, look the same way and touch: a wall with
the piece over its doorway, a ceiling, a table top. Its texels are rectangles of the
plane, so that light which varies smoothly over a wall does so in the picture, too, and
no seam runs where two solids continue one another.

Texels under a cupboard or within a wall would be black, and would darken their
neighbours. Light is therefore gathered by *receivers*: the parts of the mesh that stand
free (`render.contact`), floating a little in front of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from render.contact import LIFT, free_parts
from render.planes import Planes, planes_of
from scenes.mesh import Mesh
from scenes.solids import Prism

__all__ = ["Atlas", "Charts", "Sheet", "arrange", "contacts", "lay_out"]

LEAST = 40
"""How many texels a chart has at least, about: light varies over small things, too."""
GUTTER = 2
"""Texels around a chart that repeat its border."""
Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True)
class Sheet:
    """Charts in one picture, and what gathers light for them.

    Texel (r, c) has its centre at column c + 0.5, row r + 0.5.

    Attributes
    ----------
    shape : tuple of int
        (rows, columns) of the picture.
    boxes : array, shape (c, 4)
        First row, first column, rows and columns of every chart, gutter included.
    normals : array, shape (c, 3)
        Where every chart looks.
    receiver_corners : array, shape (k, 3, 3)
        m; counter-clockwise about the normal.
    receiver_uv : array, shape (k, 3, 2)
        (column, row), texels.
    receiver_normals : array, shape (k, 3, 3), optional
        Where their corners look by their shading, if that is not their plane's normal.
    """

    shape: tuple[int, int]
    boxes: Ints
    normals: Floats
    receiver_corners: Floats
    receiver_uv: Floats
    receiver_normals: Floats | None = field(default=None, kw_only=True)

    @property
    def scaled_receiver_uv(self) -> Floats:
        """``receiver_uv`` in units of the picture: 0 to 1."""
        return self.receiver_uv / self.shape[::-1]


@dataclass(frozen=True)
class Atlas(Sheet):
    """A mesh's charts in one picture.

    Attributes
    ----------
    uv : array, shape (t, 3, 2)
        (column, row) of the corners of every triangle of the mesh, texels.
    """

    uv: Floats

    @property
    def scaled_uv(self) -> Floats:
        """``uv`` in units of the picture: 0 to 1."""
        return self.uv / self.shape[::-1]


@dataclass(frozen=True)
class Charts:
    """How plane coordinates become texels, for every chart.

    ``low`` where its texels begin (c, 2), m; ``pitch`` how large they are (c, 2), m;
    ``counts`` how many there are, and ``origin`` where they go in the picture (c, 2).
    """

    low: Floats
    pitch: Floats
    counts: Ints
    origin: Ints

    @property
    def boxes(self) -> Ints:
        """First row, first column, rows and columns of each, gutter included, (c, 4)."""
        sizes = self.counts[:, ::-1] + 2 * GUTTER
        return np.column_stack([self.origin[:, ::-1], sizes]).astype(np.int32)

    def place(self, points: Floats, chart: Ints) -> Floats:
        """(column, row) of points (k, 3, 2) in plane coordinates of charts (k,)."""
        texels = (points - self.low[chart][:, None]) / self.pitch[chart][:, None]
        placed: Floats = self.origin[chart][:, None] + GUTTER + texels
        return placed


def lay_out(mesh: Mesh, prisms: Sequence[Prism], texel: Floats) -> Atlas:
    """Charts of ``mesh`` and its receivers.

    Parameters
    ----------
    mesh : Mesh
    prisms : sequence of Prism
        The solids that hide what is in them.
    texel : array, shape (t,)
        Side of a texel that each triangle needs, m; a chart gets as many texels as its
        triangles need together, and no fewer than `LEAST`.
    """
    corners = mesh.vertices[mesh.triangles]
    planes = planes_of(corners)
    flat = planes.flat(corners)
    chart = _touching(planes, flat)
    shape, charts = _arranged(flat, chart, texel)
    points, owner = free_parts(corners, planes, prisms)
    return Atlas(
        shape,
        charts.boxes,
        planes.normal[np.unique(chart, return_index=True)[1]],
        planes.solid(points, owner, LIFT),
        charts.place(points, chart[owner]),
        charts.place(flat, chart),
    )


def _touching(planes: Planes, flat: Floats) -> Ints:
    """Number of the chart of every triangle: same plane, in touch."""
    one, other = contacts(planes, flat)
    links = coo_array((np.ones(len(one), dtype=bool), (one, other)), shape=(len(flat),) * 2)
    chart: Ints = connected_components(links, directed=False)[1].astype(np.int32)
    return chart


def contacts(planes: Planes, flat: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs of triangles (t, 3, 2) that lie in one plane, look the same way, and touch."""
    key = np.column_stack([np.round(planes.normal, 4), np.round(planes.distance / LIFT)])
    plane = np.unique(key + 0.0, axis=0, return_inverse=True)[1].ravel()
    # One tree for all planes: they are moved apart.
    moved = flat.copy()
    moved[..., 0] += (plane * (1.0 + np.ptp(flat[..., 0])))[:, None]
    shapes = shapely.polygons(moved)
    one, other = shapely.STRtree(shapes).query(shapes, predicate="dwithin", distance=2 * LIFT)
    return one, other


def _arranged(flat: Floats, chart: Ints, texel: Floats) -> tuple[tuple[int, int], Charts]:
    """Shape of the picture, and the charts in it."""
    count = int(chart.max()) + 1
    one, two = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    area = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]) + 1e-12
    needed = np.bincount(chart, area / texel**2, count)
    whole = np.bincount(chart, area, count)
    return arrange(flat, chart, np.sqrt(np.minimum(whole / needed, 0.5 * whole / LEAST)))


def arrange(flat: Floats, chart: Ints, side: Floats) -> tuple[tuple[int, int], Charts]:
    """Shape of a picture of charts, and the charts in it.

    Parameters
    ----------
    flat : array, shape (t, 3, 2)
        Corners of triangles in plane coordinates, m.
    chart : array, shape (t,)
    side : array, shape (c,)
        Of a chart's texels, m.
    """
    count = len(side)
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, chart, flat.min(axis=1))
    np.maximum.at(high, chart, flat.max(axis=1))
    counts = np.maximum(np.ceil((high - low) / side[:, None] - 1e-6), 1).astype(np.int32)
    shape, origin = _pack(counts + 2 * GUTTER)
    return shape, Charts(low, np.maximum(high - low, 1e-9) / counts, counts, origin)


def _pack(sizes: Ints) -> tuple[tuple[int, int], Ints]:
    """Shape of a picture that holds rectangles (columns, rows), and where: (column, row).

    Shelves: highest first, from left to right.
    """
    area = float(np.prod(sizes.astype(float), axis=1).sum())
    width = int(max(np.ceil(np.sqrt(1.1 * area)), sizes[:, 0].max()))
    origin = np.zeros_like(sizes)
    column = row = shelf = 0
    for index in np.argsort(-sizes[:, 1], kind="stable").tolist():
        columns, rows = sizes[index].tolist()
        if column + columns > width:
            row, column, shelf = row + shelf, 0, 0
        origin[index] = (column, row)
        column, shelf = column + columns, max(shelf, rows)
    return (row + shelf, width), origin
