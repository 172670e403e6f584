"""Slices of triangle soups, against trimesh's sections and shapes known beforehand."""

from __future__ import annotations

import functools
import time

import numpy as np
import pytest
import shapely
import trimesh
from shapely import Polygon

from scenes.importers.slicing import (
    PAINT,
    Triangles,
    floor_level,
    free_floor,
    height_of_ceiling,
    rays,
    slab_obstacles,
)
from scenes.mesh import prism_mesh
from scenes.solids import Prism

LOW, HIGH = 0.01, 0.10


def soup(*meshes: trimesh.Trimesh) -> Triangles:
    """Triangles of several objects."""
    corners = [np.asarray(mesh.triangles, dtype=float) for mesh in meshes]
    owner = np.repeat(np.arange(len(meshes)), [len(c) for c in corners])
    return Triangles(np.concatenate(corners), owner)


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> trimesh.Trimesh:
    return trimesh.creation.box(bounds=[low, high])


def sheet(*corners: tuple[float, float, float]) -> trimesh.Trimesh:
    """A plane with four corners, seen from one side only."""
    return trimesh.Trimesh(corners, [(0, 1, 2), (0, 2, 3)], process=False)


def is_near(found: shapely.Geometry, wanted: shapely.Geometry, reach: float = 1.5 * PAINT) -> bool:
    """Whether no outline is farther than ``reach`` from the other one."""
    return wanted.buffer(reach).covers(found) and found.buffer(reach).covers(wanted)


def section(mesh: trimesh.Trimesh, height: float) -> shapely.Geometry:
    """What trimesh cuts a closed mesh into; of nested outlines, the outer minus the inner."""
    lines = trimesh.intersections.mesh_plane(mesh, (0.0, 0.0, 1.0), (0.0, 0.0, height))
    noded = shapely.union_all(shapely.linestrings(lines[:, :, :2]), grid_size=1e-7)
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(noded)))
    shells = [Polygon(face.exterior) for face in faces]
    return functools.reduce(shapely.symmetric_difference, shells)


def turned(mesh: trimesh.Trimesh, degrees: float, x: float, y: float) -> trimesh.Trimesh:
    matrix = trimesh.transformations.rotation_matrix(np.radians(degrees), (0, 0, 1))
    matrix[:2, 3] = x, y
    mesh.apply_transform(matrix)
    return mesh


@pytest.mark.parametrize("degrees", [0.0, 31.0, 45.0])
def test_a_box_gives_its_footprint(degrees: float) -> None:
    mesh = turned(box((-0.5, -0.3, 0.0), (0.5, 0.3, 2.0)), degrees, 3.0, -1.0)
    wanted = shapely.convex_hull(shapely.multipoints(mesh.vertices[:, :2]))
    assert is_near(slab_obstacles(soup(mesh), LOW, HIGH), wanted)


def test_a_slab_of_a_ball_is_the_widest_section_in_it() -> None:
    ball = trimesh.creation.icosphere(4, 0.5)
    ball.apply_translation((1.0, 2.0, 0.45))
    assert is_near(slab_obstacles(soup(ball), LOW, HIGH), section(ball, HIGH), 3e-3)


@pytest.mark.parametrize("height", [0.02, 0.05, 0.09])
def test_sections_lie_in_the_slab(height: float) -> None:
    rng = np.random.default_rng(3)
    points = rng.normal((0.0, 0.0, 0.1), 0.3, (40, 3))
    meshes = [trimesh.convex.convex_hull(points), turned(trimesh.creation.torus(0.5, 0.1), 0, 2, 0)]
    found = slab_obstacles(soup(*meshes), LOW, HIGH)
    for mesh in meshes:
        cut = section(mesh, height)
        assert cut.area > 0.01
        assert found.buffer(1e-4).covers(cut)


@pytest.mark.parametrize(("bottom", "top"), [(-0.2, LOW), (HIGH, 0.5), (-0.2, 0.0)])
def test_what_only_touches_the_slab_is_no_obstacle(bottom: float, top: float) -> None:
    assert slab_obstacles(soup(box((0, 0, bottom), (1, 1, top))), LOW, HIGH).is_empty


def test_a_table_stands_on_its_legs() -> None:
    legs = [box((x, y, 0.0), (x + 0.05, y + 0.05, 0.7)) for x in (0, 1) for y in (0, 0.6)]
    top = box((0, 0, 0.7), (1.05, 0.65, 0.75))
    table = trimesh.util.concatenate([*legs, top])
    wanted = shapely.union_all([shapely.box(*leg.bounds[:, :2].ravel()) for leg in legs])
    assert is_near(slab_obstacles(soup(table), LOW, HIGH), wanted)


def test_a_wall_of_one_plane_is_as_thick_as_paint() -> None:
    wall = sheet((0, 0, 0), (3, 0, 0), (3, 0, 2.5), (0, 0, 2.5))
    found = slab_obstacles(soup(wall), LOW, HIGH)
    assert found.bounds == pytest.approx((-PAINT, -PAINT, 3 + PAINT, PAINT), abs=1e-9)


def test_a_solid_is_filled_though_it_leaks_and_runs_through_another() -> None:
    box_a, box_b = box((0, 0, 0), (1, 1, 2)), box((0.6, 0.6, -0.1), (1.5, 1.5, 2))
    # The bottom and a corner's worth of one side are missing.
    leaky = trimesh.Trimesh(box_a.vertices, box_a.faces[box_a.face_normals[:, 2] > -0.5])
    leaky.vertices[leaky.vertices[:, 0] > 0.5, 0] -= 5e-4
    merged = trimesh.util.concatenate([leaky, box_b])
    wanted = shapely.box(0, 0, 1, 1).union(shapely.box(0.6, 0.6, 1.5, 1.5))
    assert is_near(slab_obstacles(soup(merged), LOW, HIGH), wanted)


def test_a_ring_keeps_its_hole_and_a_tube_is_filled() -> None:
    ring = trimesh.creation.annulus(0.4, 0.5, 1.0)
    ring.apply_translation((0, 0, 0.5))
    found = slab_obstacles(soup(ring), LOW, HIGH)
    assert found.contains(shapely.Point(0.45, 0.0))
    assert not found.intersects(shapely.Point(0.0, 0.0))


def test_thick_walls_around_rooms_are_solid_and_the_rooms_are_not() -> None:
    plan = shapely.box(0, 0, 5, 3.2).difference(
        shapely.union_all([shapely.box(0.2, 0.2, 1.2, 3.0), shapely.box(1.4, 0.2, 4.8, 3.0)])
    )
    walls = trimesh.Trimesh(*prism_mesh(Prism(plan, 0.0, 2.5, "plain")))
    assert is_near(slab_obstacles(soup(walls), LOW, HIGH), plan)


@pytest.mark.parametrize("outward", [True, False])
def test_a_cube_seen_from_within_is_a_room(outward: bool) -> None:
    room = box((0, 0, 0), (4, 3, 2.5))
    if not outward:
        room.invert()
    free = free_floor(soup(room, box((1, 1, 0), (1.5, 1.5, 0.8))), LOW, HIGH)
    wanted = shapely.box(0, 0, 4, 3).difference(shapely.box(1, 1, 1.5, 1.5))
    assert is_near(free, wanted, 3 * PAINT)
    assert height_of_ceiling(soup(room), free) == 2.5


def test_floor_with_a_gap_in_the_doorway_is_one_floor() -> None:
    left = sheet((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0))
    right = sheet((2.3, 0, 0), (4, 0, 0), (4, 2, 0), (2.3, 2, 0))
    walls = [box((2, 0, 0), (2.3, 0.6, 2)), box((2, 1.4, 0), (2.3, 2, 2))]
    free = free_floor(soup(left, right, *walls), LOW, HIGH)
    assert shapely.get_num_geometries(free) == 1
    assert free.covers(shapely.box(1.9, 0.61, 2.4, 1.39))


def test_without_a_floor_it_is_the_bounding_rectangle() -> None:
    wall = box((0, 0, 0.0), (0.1, 3, 2.5))
    free = free_floor(soup(wall, box((3.9, 0, 0.0), (4, 3, 2.5))), LOW, HIGH)
    assert is_near(free, shapely.box(0.1, 0, 3.9, 3))


def house(level: float) -> list[trimesh.Trimesh]:
    """Ground around a house with a floor slab, a rug, a table and a ceiling slab."""
    ground = sheet((-20, -20, 0), (20, -20, 0), (20, 20, 0), (-20, 20, 0))
    floor = box((0, 0, level - 0.1), (12, 12, level))
    rug = box((3, 3, level), (6, 6, level + 0.008))
    return [ground, floor, rug, box((0, 0, level + 2.4), (12, 12, level + 2.6))]


@pytest.mark.parametrize("level", [0.3, 1.2])
def test_the_floor_is_the_lowest_large_surface_with_a_ceiling(level: float) -> None:
    assert floor_level(soup(*house(level))) == pytest.approx(level)


def test_the_floor_without_any_ceiling_is_the_lowest_large_surface() -> None:
    low, high = box((0, 0, -0.2), (4, 4, 0.1)), box((4, 0, -0.2), (8, 4, 0.5))
    speck = box((0, 0, -3), (1, 0.5, -2))
    assert floor_level(soup(high, low, speck)) == pytest.approx(0.1)
    wall = sheet((0, 0, 0), (3, 0, 0), (3, 0, 2.5), (0, 0, 2.5))
    assert floor_level(soup(wall)) is None


def test_only_what_has_a_ceiling_counts_if_anything_has_one() -> None:
    meshes = house(0.0)[1:]
    terrace = sheet((12, 0, 0), (40, 0, 0), (40, 12, 0), (12, 12, 0))
    wall = box((11.9, 0, 0), (12, 12, 2.4))
    free = free_floor(soup(*meshes, terrace, wall), LOW, HIGH)
    assert is_near(free, shapely.box(0, 0, 11.9, 12))


def test_the_inside_of_a_cupboard_is_no_room() -> None:
    floor = sheet((0, 0, 0), (5, 0, 0), (5, 4, 0), (0, 4, 0))
    sides = [box((0, 0, 0), (0.02, 0.6, 2)), box((0.98, 0, 0), (1, 0.6, 2))]
    sides += [box((0, 0, 0), (1, 0.02, 2)), box((0, 0.58, 0), (1, 0.6, 2))]
    free = free_floor(soup(floor, *sides, box((0, 0, 2), (1, 0.6, 2.02))), LOW, HIGH)
    assert free.contains(shapely.box(1.1, 0.7, 4.9, 3.9))


def test_rays_meet_a_convex_solid_where_its_planes_say() -> None:
    rng = np.random.default_rng(5)
    mesh = trimesh.convex.convex_hull(rng.normal(0.0, 1.0, (60, 3)))
    points = rng.uniform(-1.5, 1.5, (80, 2))
    point, height, _ = rays(soup(mesh), points)
    normals, origins = mesh.face_normals, mesh.triangles[:, 0]
    for k, (x, y) in enumerate(points):
        away = (origins - (x, y, 0.0)) * normals
        z = away.sum(axis=1) / normals[:, 2]
        low, high = z[normals[:, 2] < 0].max(), z[normals[:, 2] > 0].min()
        wanted = [low, high] if low < high else []
        np.testing.assert_allclose(np.sort(height[point == k]), wanted, atol=1e-9)


def test_a_large_scene_takes_seconds() -> None:
    meshes = [box((0, 0, -0.1), (20, 20, 0.0)), box((0, 0, 2.5), (20, 20, 2.6))]
    for k in range(25):
        ball = trimesh.creation.icosphere(4, 0.4)
        ball.apply_translation((2 + 3.5 * (k % 5), 2 + 3.5 * (k // 5), 0.3))
        meshes.append(ball)
    scene = soup(*meshes)
    assert len(scene) > 100_000
    begin = time.monotonic()
    free = free_floor(scene, LOW, HIGH)
    assert time.monotonic() - begin < 30.0
    assert shapely.get_num_interior_rings(shapely.get_parts(free)[0]) == 25
