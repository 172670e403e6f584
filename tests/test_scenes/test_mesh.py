"""Meshes against volumes, counted edges and rays traced here."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes import Prism, apartment_mesh, apartment_solids
from scenes.mesh import prism_mesh
from test_scenes.places import framed, two_rooms


def signed_volume(vertices, triangles):
    """Volume by the divergence theorem; positive if normals point outward."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


def assert_closed(triangles):
    """Every directed edge is matched by its opposite exactly once."""
    edges = Counter((int(t[k]), int(t[(k + 1) % 3])) for t in triangles for k in range(3))
    assert all(edges[b, a] == count == 1 for (a, b), count in edges.items())


def nearest_hit(mesh, origin, directions):
    """Distance along each ray to the first triangle (Möller and Trumbore), and its number."""
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    best, which = np.full(len(directions), np.inf), np.full(len(directions), -1)
    for k, d in enumerate(directions):
        p = np.cross(d, c - a)
        det = np.einsum("ij,ij->i", b - a, p)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = np.einsum("ij,ij->i", origin - a, p) / det
            q = np.cross(origin - a, b - a)
            v = (q @ d) / det
            t = np.einsum("ij,ij->i", c - a, q) / det
            hit = (np.abs(det) > 1e-12) & (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9)
        t = np.where(hit & (t > 1e-9), t, np.inf)
        best[k], which[k] = t.min(), t.argmin()
    return best, which


FURNISHED = [
    {"kind": kind, "position": [0.9 + 1.1 * k, 2.0], "rotation_deg": 20 * k}
    for k, kind in enumerate(["bath", "chair", "basin", "armchair", "plant", "toilet"])
]


def test_every_prism_is_closed_and_has_its_volume():
    place = two_rooms(
        passages=framed(), windows=[{"position": [2, 3.1]}], furniture=FURNISHED,
        lamps=[{"position": [1, 1]}],
    )  # fmt: skip
    for prism in apartment_solids(place):
        vertices, triangles = prism_mesh(prism)
        assert_closed(triangles)
        expected = prism.footprint.area * (prism.top - prism.bottom)
        assert signed_volume(vertices, triangles) == pytest.approx(expected)


@settings(max_examples=50, deadline=None)
@given(
    radii=st.lists(st.floats(0.5, 2.0), min_size=5, max_size=12),
    hole=st.floats(0.05, 0.3),
    height=st.floats(0.01, 3.0),
)
def test_star_shaped_prism_with_a_hole(radii, hole, height):
    angle = np.linspace(0, 2 * np.pi, len(radii), endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle)]) * np.array(radii)[:, None]
    inner = shapely.Point(0, 0).buffer(hole / 2, quad_segs=2)
    footprint = shapely.Polygon(ring).difference(inner)
    vertices, triangles = prism_mesh(Prism(footprint, 0.5, 0.5 + height, "wood"))
    assert_closed(triangles)
    x, y = ring.T
    area = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) - inner.area
    assert signed_volume(vertices, triangles) == pytest.approx(area * height)


def test_apartment_mesh_is_the_sum_of_its_solids():
    place = two_rooms(furniture=FURNISHED)
    mesh = apartment_mesh(place)
    volume = sum(prism.volume for prism in apartment_solids(place))
    assert signed_volume(mesh.vertices, mesh.triangles) == pytest.approx(volume)
    assert mesh.triangles.dtype == np.int32 and mesh.material_index.dtype == np.int32
    assert len(mesh.material_index) == len(mesh.triangles)
    assert sorted(set(mesh.material_index)) == list(range(len(mesh.materials)))


def test_faces_of_walls_take_the_material_of_the_room_they_look_into():
    mesh = apartment_mesh(two_rooms(passages=framed()))

    def seen(origin, direction):
        (_,), (k,) = nearest_hit(mesh, np.array(origin), np.array([direction], dtype=float))
        return mesh.materials[mesh.material_index[k]]

    assert seen((2, 0.5, 1), (1, 0, 0)) == "red_plaster"
    assert seen((5, 0.5, 1), (-1, 0, 0)) == "blue_plaster"
    assert seen((5, 1.5, 2.3), (-1, 0, 0)) == "blue_plaster"  # the lintel
    assert seen((5, 1.5, 1), (-1, 0, 0)) == "red_plaster"  # through the passage
    assert seen((2, 1.95, 1), (1, 0, 0)) == "frame_paint"
    assert seen((2, 10, 1), (0, -1, 0)) == "facade"
    assert seen((2, 1, 1), (0, 0, -1)) == "parquet"
    assert seen((5, 1, 1), (0, 0, -1)) == "tiles_white"
    assert seen((4.05, 1.5, 1), (0, 0, 1)) == "frame_paint"
    assert seen((2, 1, 1), (0, 0, 1)) == "white_paint"


def test_wall_that_passes_two_rooms_beside_an_opening_is_split():
    """The wall y = 0 runs on through a passage in the corner without a step."""
    passage = [{"position": [4.05, 0.4], "width": 0.8}]
    mesh = apartment_mesh(two_rooms(passages=passage))
    down = np.array([[0.0, -1.0, 0.0]])
    for x, material in ((3.9, "red_plaster"), (4.2, "blue_plaster"), (6.9, "blue_plaster")):
        _, (k,) = nearest_hit(mesh, np.array([x, 0.4, 1.1]), down)
        assert mesh.materials[mesh.material_index[k]] == material


def test_no_ray_leaves_a_place_without_windows():
    rooms = two_rooms().model_dump(mode="json")["rooms"]
    rooms[1]["ceiling_height"] = 2.2
    place = two_rooms(rooms=rooms, passages=[{"position": [4.05, 1.5], "lintel_height": None}])
    mesh = apartment_mesh(place)
    rng = np.random.default_rng(3)
    directions = rng.normal(size=(1500, 3))
    # And straight into the seams of walls, floor and ceilings, where leaks would be.
    corners = np.array([[x, y, z] for x in (0, 4, 4.1, 7.1) for y in (0, 3) for z in (0, 2.2, 2.5)])
    origin = np.array([3.0, 1.4, 0.1])
    directions = np.concatenate([directions, corners - origin])
    distance, _ = nearest_hit(
        mesh, origin, directions / np.linalg.norm(directions, axis=1)[:, None]
    )
    assert distance.max() < 7.8


def test_light_comes_in_through_the_window():
    mesh = apartment_mesh(two_rooms(windows=[{"position": [2, 3.1]}]))
    origin = np.array([2.0, 1.0, 0.1])
    through, sill = np.array([1.75, 3.1, 1.5]) - origin, np.array([1.75, 3.1, 0.85]) - origin
    distance, _ = nearest_hit(mesh, origin, np.array([through, sill]))
    assert np.isinf(distance[0]) and distance[1] < 1.0


def test_same_apartment_gives_the_same_bytes():
    first, second = apartment_mesh(two_rooms()), apartment_mesh(two_rooms())
    assert first.vertices.tobytes() == second.vertices.tobytes()
    assert first.triangles.tobytes() == second.triangles.tobytes()
    assert first.materials == second.materials
