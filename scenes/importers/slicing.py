"""Obstacles and free floor from the triangles of any 3D scene.

Meshes that people make are seldom watertight: walls are single planes, solids run
through each other, normals point anywhere. Hence no solids are built. Every triangle
is clipped to the slab between the floor clearance and the robot's height; what is left
of it, seen from above and made as thick as a coat of paint, is an obstacle. That alone
keeps the robot out of what is closed.

What an object encloses is its inside if rays up and down from there leave the object
through back faces; then it is filled, so that nobody starts a run in a column. What is
as wide as a room is never filled: a cube that is seen from within is a room.

Upright rays also say where the floor is, and how high the ceiling.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from scenes.solids import polygons

__all__ = [
    "Triangles",
    "floor_level",
    "free_floor",
    "height_of_ceiling",
    "lowest_above",
    "rays",
    "slab_obstacles",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

PAINT = 1e-3
"""Half the thickness that surfaces get, m; holes in walls up to twice this are closed."""
ROUNDING = 1e-4
"""What only touches the slab is not in it, m."""
ROOM_WIDTH = 2.0
"""What is nowhere that wide may be the inside of a solid, m."""
HEAD_ROOM = 1.8
"""A ceiling is at least this far above the floor, m."""
SUNK = 0.03
"""Floors may lie this much lower than the level that was chosen, m."""
LEAST_FLOOR = 1.0
"""Smallest floor of a scene, m²."""
FLOOR_GAP = 0.4
"""Missing floor up to this width (below a door) is floor, m."""
LEVEL_STEP = 0.02
"""Surfaces whose heights differ by less are one level, m."""
MOST_LEVELS = 12
"""So many levels, the largest ones, may be the floor."""
LARGE_SHARE = 0.2
"""A level is large if it has this share of the largest one's area."""
TOO_SMALL = 0.05
"""Floor without room for the robot, m²."""
SAMPLES = 24
"""Rays along either side of the bounding rectangle of a region."""


@dataclass(frozen=True)
class Triangles:
    """The surface of a scene.

    Attributes
    ----------
    corners : array, shape (t, 3, 3)
        m, z up.
    owner : array, shape (t,), int
        Number of the object that a triangle is of.
    """

    corners: Floats
    owner: Ints

    def __getitem__(self, which: NDArray[np.bool_] | Ints) -> Triangles:
        return Triangles(self.corners[which], self.owner[which])

    def __len__(self) -> int:
        return len(self.corners)

    @property
    def normals(self) -> Floats:
        """Normals (t, 3), as long as twice the area."""
        a, b, c = self.corners.transpose(1, 0, 2)
        normals: Floats = np.cross(b - a, c - a)
        return normals


# ---- rays -----------------------------------------------------------------------------------


def rays(triangles: Triangles, points: Floats) -> tuple[Ints, Floats, Ints]:
    """Where upright lines meet triangles.

    Parameters
    ----------
    triangles : Triangles
    points : array, shape (p, 2)
        m.

    Returns
    -------
    point : array, shape (h,), int
        Whose line it is.
    height : array, shape (h,)
        m.
    triangle : array, shape (h,), int
    """
    level = np.flatnonzero(np.abs(triangles.normals[:, 2]) > 1e-12)
    shapes = shapely.polygons(triangles.corners[level, :, :2])
    point, hit = shapely.STRtree(shapes).query(shapely.points(points), predicate="intersects")
    triangle = level[hit]
    normal, origin = triangles.normals[triangle], triangles.corners[triangle, 0]
    away = points[point] - origin[:, :2]
    drop = (normal[:, :2] * away).sum(axis=1) / normal[:, 2]
    return point, origin[:, 2] - drop, triangle


def lowest_above(triangles: Triangles, points: Floats, height: float) -> Floats:
    """Height of the first surface above ``height`` over each point, m; inf if none."""
    point, z, _ = rays(triangles, points)
    first = np.full(len(points), np.inf)
    above = z > height
    np.minimum.at(first, point[above], z[above])
    return first


def _spread(region: shapely.Geometry) -> Floats:
    """Points (p, 2) of a region on a regular grid, off the corners of regular meshes."""
    if region.is_empty:
        return np.zeros((0, 2))
    low_x, low_y, high_x, high_y = region.bounds
    shares = (np.arange(SAMPLES) + 0.47) / SAMPLES
    x, y = np.meshgrid(low_x + shares * (high_x - low_x), low_y + shares * (high_y - low_y))
    grid = np.column_stack([x.ravel(), y.ravel()])
    shapely.prepare(region)
    inside: Floats = grid[shapely.contains_xy(region, grid)]
    return inside


# ---- floor and ceiling ----------------------------------------------------------------------


def floor_level(triangles: Triangles) -> float | None:
    """Height of the lowest large floor, m; None if nothing is level.

    Floors look up. Those with a ceiling or roof over at least half of them come first:
    ground around a house, or the slab that closes it above, have none.
    """
    normals = triangles.normals
    length = np.linalg.norm(normals, axis=1)
    level = (np.abs(normals[:, 2]) > 0.99 * length) & (length > 0.0)
    upward = level & (normals[:, 2] > 0.0)
    chosen = upward if upward.any() else level
    if not chosen.any():
        return None
    floors, area = triangles[chosen], 0.5 * length[chosen]
    number = _levels(floors.corners[:, :, 2].mean(axis=1))
    areas = np.bincount(number, weights=area)
    largest = np.argsort(-areas, kind="stable")[:MOST_LEVELS]
    enough = [k for k in largest if areas[k] >= LEAST_FLOOR]
    roofed = [k for k in enough if _has_roof(triangles, floors[number == k])]
    candidates = roofed or enough or list(largest)
    large = [k for k in candidates if areas[k] >= LARGE_SHARE * areas[candidates[0]]]
    heights = floors.corners[:, :, 2].mean(axis=1)
    return min(_median(heights[number == k], area[number == k]) for k in large)


def _levels(heights: Floats) -> Ints:
    """Number of the level that each height belongs to, lowest first."""
    order = np.argsort(heights, kind="stable")
    step = np.diff(heights[order]) > LEVEL_STEP
    number = np.empty(len(heights), dtype=np.int64)
    number[order] = np.concatenate([[0], np.cumsum(step)])
    return number


def _has_roof(triangles: Triangles, floor: Triangles) -> bool:
    """Whether there is something over at least half of a floor."""
    region = shapely.union_all(shapely.polygons(floor.corners[:, :, :2]))
    above = lowest_above(triangles, _spread(region), float(floor.corners[0, 0, 2]) + HEAD_ROOM)
    return len(above) > 0 and bool(np.isfinite(above).mean() >= 0.5)


def _median(values: Floats, weights: Floats) -> float:
    """The value that half of the weight does not exceed: rugs do not lift the floor."""
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, 0.5 * total[-1])])


def height_of_ceiling(triangles: Triangles, region: shapely.Geometry) -> float | None:
    """Median height of the ceiling over a region, m; None if less than half has one."""
    above = lowest_above(triangles, _spread(region), HEAD_ROOM)
    if not len(above) or np.isfinite(above).mean() < 0.5:
        return None
    return round(float(np.median(above[np.isfinite(above)])), 3)


def free_floor(triangles: Triangles, low: float, high: float) -> shapely.Geometry:
    """Where there is floor, and nothing between two heights, m.

    Parameters
    ----------
    triangles : Triangles
        The floor at height 0.
    low, high : float
        Floor clearance and height of the robot, m.

    Returns
    -------
    Geometry
        Only what is under a ceiling, if there is a room under one.
    """
    free = _floor_extent(triangles, low).difference(slab_obstacles(triangles, low, high))
    parts = polygons(free, TOO_SMALL)
    roofed = [part for part in parts if height_of_ceiling(triangles, part) is not None]
    # The inside of a cupboard is no room: a scene without a ceiling has such, too.
    indoors = any(part.area >= LEAST_FLOOR for part in roofed)
    return shapely.MultiPolygon(roofed if indoors else parts)


def _floor_extent(triangles: Triangles, low: float) -> shapely.Geometry:
    """Surfaces about height 0, small gaps closed; the bounding rectangle if there are none."""
    z, up = triangles.corners[:, :, 2], triangles.normals[:, 2]
    near = (z > -SUNK).all(axis=1) & (z < low).all(axis=1)
    floor = _seen_from_above(triangles[near & (up > 1e-12)])
    if floor.area < LEAST_FLOOR:
        # Perhaps it looks down; but so do the feet of walls.
        x, y = triangles.corners[:, :, 0], triangles.corners[:, :, 1]
        whole = shapely.box(x.min(), y.min(), x.max(), y.max())
        floor = _seen_from_above(triangles[near & (np.abs(up) > 1e-12)])
        if floor.area < 0.3 * whole.area:
            return whole
    reach = FLOOR_GAP / 2
    closed = floor.buffer(reach, join_style="mitre").buffer(-reach, join_style="mitre")
    return closed.union(floor)


def _seen_from_above(triangles: Triangles) -> shapely.Geometry:
    shapes = shapely.polygons(triangles.corners[:, :, :2])
    return shapely.union_all(shapely.make_valid(shapes), grid_size=1e-5)


# ---- obstacles ------------------------------------------------------------------------------


def slab_obstacles(triangles: Triangles, low: float, high: float) -> shapely.Geometry:
    """What lies between two heights (m), seen from above, insides filled.

    Parameters
    ----------
    triangles : Triangles
    low, high : float
        m above the floor.

    Returns
    -------
    Geometry
        Every outline lies `PAINT` outside of the surfaces.
    """
    bottom, top = low + ROUNDING, high - ROUNDING
    z = triangles.corners[:, :, 2]
    inside = triangles[(z.max(axis=1) > bottom) & (z.min(axis=1) < top)]
    if not len(inside):
        return shapely.MultiPolygon()
    pieces = _painted(_clipped(inside.corners, bottom, top))
    order = np.argsort(inside.owner, kind="stable")
    starts = np.flatnonzero(np.diff(inside.owner[order], prepend=-1))
    outlines = [shapely.union_all(pieces[group]) for group in np.split(order, starts[1:])]
    owners = inside.owner[order[starts]]
    grouped = triangles[np.argsort(triangles.owner, kind="stable")]
    filled = [
        hole
        for owner, outline in zip(owners, outlines, strict=True)
        for hole in _insides(grouped, int(owner), outline, (low + high) / 2)
    ]
    return shapely.union_all([*outlines, *filled])


def _clipped(corners: Floats, bottom: float, top: float) -> NDArray[np.object_]:
    """What a slab leaves of every triangle, seen from above: polygon, line or point.

    It is convex, so the corners within the slab and the points where sides enter or
    leave it say all.
    """
    follow = np.roll(corners, -1, axis=1)
    z, dz = corners[:, :, 2], follow[:, :, 2] - corners[:, :, 2]
    points, valid = [corners[:, :, :2]], [(z >= bottom) & (z <= top)]
    for height in (bottom, top):
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (height - z) / dz
        crosses = (share >= 0.0) & (share <= 1.0)
        share = np.where(crosses, share, 0.0)[..., None]
        points.append(corners[:, :, :2] + share * (follow - corners)[:, :, :2])
        valid.append(crosses)
    point, use = np.concatenate(points, axis=1), np.concatenate(valid, axis=1)
    # A point that does not count becomes the first that does, which changes no hull.
    first = np.take_along_axis(point, use.argmax(axis=1)[:, None, None], axis=1)
    hulls: NDArray[np.object_] = shapely.convex_hull(
        shapely.linestrings(np.where(use[..., None], point, first))
    )
    return hulls


def _painted(pieces: NDArray[np.object_]) -> NDArray[np.object_]:
    """Pieces with a coat of paint: lines and points get an area."""
    made: NDArray[np.object_] = shapely.buffer(
        pieces, PAINT, cap_style="square", join_style="mitre", mitre_limit=2.0
    )
    return made


def _insides(
    triangles: Triangles, owner: int, outline: shapely.Geometry, height: float
) -> Iterator[Polygon]:
    """What an object's outline encloses and is its inside; ``triangles`` are in order of owner."""
    shells = [Polygon(part.exterior) for part in polygons(outline)]
    holes = polygons(shapely.union_all(shells).difference(outline))
    holes = [hole for hole in holes if hole.buffer(-ROOM_WIDTH / 2).is_empty]
    if not holes:
        return
    own = triangles[np.arange(*np.searchsorted(triangles.owner, [owner, owner + 1]))]
    spots = shapely.get_coordinates(shapely.point_on_surface(holes))
    point, z, triangle = rays(own, spots)
    outward = np.sign(own.normals[triangle, 2]) * np.sign(z - height)
    above = np.bincount(point[z > height], outward[z > height], len(holes))
    below = np.bincount(point[z < height], outward[z < height], len(holes))
    hit = np.bincount(point, minlength=len(holes)) > 0
    for index in np.flatnonzero(hit & (above >= 0.0) & (below >= 0.0) & (above + below > 0.0)):
        yield holes[index]
