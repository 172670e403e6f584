"""The apartment as triangles for the renderer.

Every prism is a closed shell of its own: side quads, bottom and top from a
constrained Delaunay triangulation, normals outward. Faces of `WALL` prisms take
the ``walls`` material of the room that they look into; in the reveal of an
opening that is the nearest room, and on the outside of the building the façade.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from scenes.apartment import Apartment
from scenes.rooms import room_shapes
from scenes.solids import WALL, Prism, apartment_solids, building_region

__all__ = ["Mesh", "apartment_mesh", "prism_mesh", "solids_mesh", "wall_materials"]

FACADE = "facade"
Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True)
class Mesh:
    """Triangles with outward normals.

    vertices (v, 3) f8, m; triangles (t, 3) i4; material_index (t,) i4 into
    ``materials``, names for `scenes.materials.resolve`.
    """

    vertices: Floats
    triangles: Ints
    material_index: Ints
    materials: tuple[str, ...]


@dataclass(frozen=True)
class _Shell:
    """One prism's closed surface, and for every triangle the point it looks at."""

    vertices: Floats
    triangles: Ints
    outlook: Floats


def apartment_mesh(apartment: Apartment) -> Mesh:
    """Triangles of all solids of an apartment.

    Raises
    ------
    KeyError, ValueError
        As `scenes.solids.apartment_solids`.
    """
    return solids_mesh(apartment, apartment_solids(apartment))


def solids_mesh(apartment: Apartment, prisms: Sequence[Prism]) -> Mesh:
    """Triangles of some solids of an apartment, such as those below a cut."""
    corners = shapely.points([xy for room in apartment.rooms for xy in room.polygon])
    shells = [
        _shell(
            _split(prism.footprint, corners) if prism.material == WALL else prism.footprint, prism
        )
        for prism in prisms
    ]
    names = _face_names(apartment, prisms, shells)
    materials, index = np.unique(names, return_inverse=True)
    sizes = [len(shell.vertices) for shell in shells]
    offsets = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.int32)
    triangles = [s.triangles + offset for s, offset in zip(shells, offsets, strict=True)]
    return Mesh(
        np.concatenate([shell.vertices for shell in shells]),
        np.concatenate(triangles).astype(np.int32),
        index.astype(np.int32).ravel(),
        tuple(str(name) for name in materials),
    )


def prism_mesh(prism: Prism) -> tuple[Floats, Ints]:
    """Vertices (v, 3) and outward triangles (t, 3) of one prism."""
    shell = _shell(prism.footprint, prism)
    return shell.vertices, shell.triangles


def _shell(footprint: Polygon, prism: Prism) -> _Shell:
    """Closed surface of a prism; bottom ring vertices first, then the same at the top."""
    polygon = shapely.geometry.polygon.orient(footprint)
    rings = [np.asarray(ring.coords)[:-1] for ring in (polygon.exterior, *polygon.interiors)]
    plan = np.concatenate(rings)
    n = len(plan)
    vertices = np.concatenate(
        [np.column_stack([plan, np.full(n, z)]) for z in (prism.bottom, prism.top)]
    )
    # Exteriors run counter-clockwise and holes clockwise: the solid is always on the left.
    starts = np.cumsum([0, *(len(ring) for ring in rings)])
    follow = np.concatenate([np.roll(np.arange(a, b), -1) for a, b in itertools.pairwise(starts)])
    here = np.arange(n)
    sides = np.stack(
        [
            np.column_stack([here, follow, follow + n]),
            np.column_stack([here, follow + n, here + n]),
        ],
        axis=1,
    ).reshape(-1, 3)
    cap = _triangulate(polygon, plan)
    step = plan[follow] - plan
    outward = np.column_stack([step[:, 1], -step[:, 0]])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    side_outlook = np.repeat((plan + plan[follow]) / 2 + 0.01 * outward, 2, axis=0)
    cap_outlook = plan[cap].mean(axis=1)
    return _Shell(
        vertices,
        np.concatenate([sides, cap[:, ::-1], cap + n]).astype(np.int32),
        np.concatenate([side_outlook, cap_outlook, cap_outlook]),
    )


def _triangulate(polygon: Polygon, plan: Floats) -> Ints:
    """Counter-clockwise triangles (t, 3) over the ring vertices ``plan`` (n, 2)."""
    if len(plan) == 3:
        return np.array([[0, 1, 2]], dtype=np.int32)
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    number = {(x, y): i for i, (x, y) in enumerate(plan.tolist())}
    triangles = np.array([[number[x, y] for x, y in t] for t in corners.tolist()], dtype=np.int32)
    a, b, c = (plan[triangles[:, k]] for k in range(3))
    cross = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    triangles[cross < 0] = triangles[cross < 0][:, ::-1]
    return triangles


def _split(polygon: Polygon, corners: NDArray[np.object_]) -> Polygon:
    """The polygon with vertices added where room corners lie on its sides.

    A side that passes several rooms (beside an opening in a corner) becomes
    one face for each of them.
    """
    near = corners[shapely.distance(corners, polygon.boundary) < 1e-3]

    def split_ring(ring: shapely.LinearRing) -> Floats:
        coords = np.asarray(ring.coords)
        on_ring = near[shapely.distance(near, ring) < 1e-3]
        places = shapely.line_locate_point(ring, on_ring)
        known = shapely.line_locate_point(ring, shapely.points(coords[:-1]))
        far = np.abs(places[:, None] - known[None, :]).min(axis=1, initial=np.inf) > 2e-3
        far &= places < ring.length - 2e-3
        places = np.unique(places[far].round(4))
        extra = shapely.get_coordinates(shapely.line_interpolate_point(ring, places))
        order = np.argsort(np.concatenate([known, places]), kind="stable")
        both: Floats = np.concatenate([coords[:-1], extra])
        return both[order]

    return Polygon(split_ring(polygon.exterior), [split_ring(r) for r in polygon.interiors])


def _face_names(
    apartment: Apartment, prisms: Sequence[Prism], shells: Sequence[_Shell]
) -> NDArray[np.str_]:
    """Material name of every triangle, `WALL` resolved."""
    counts = [len(shell.triangles) for shell in shells]
    names = np.repeat(np.array([prism.material for prism in prisms], dtype="U80"), counts)
    is_wall = names == WALL
    if is_wall.any():
        outlook = np.concatenate([shell.outlook for shell in shells])
        names[is_wall] = wall_materials(apartment, outlook[is_wall])
    return names


def wall_materials(apartment: Apartment, outlook: Floats) -> NDArray[np.str_]:
    """``walls`` material of the room nearest to each point (k, 2), m; façade outside."""
    shapes = room_shapes(apartment)
    tree = shapely.STRtree(shapes)
    points = shapely.points(outlook)
    materials = np.array([room.walls for room in apartment.rooms] + [FACADE])
    nearest = tree.nearest(points)
    building = building_region(apartment)
    shapely.prepare(building)
    inside = shapely.intersects(building, points)
    names: NDArray[np.str_] = materials[np.where(inside, nearest, len(shapes))]
    return names
