"""Charts: nothing overlaps, nothing is torn, and what is hidden gathers no light."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import box

from render.charts import GUTTER, Atlas, lay_out
from render.contact import LIFT
from scenes import Apartment, load_apartment
from scenes.mesh import Mesh, apartment_mesh, prism_mesh
from scenes.solids import Prism, apartment_solids

TEXEL = 0.1


def mesh_of(*prisms: Prism) -> Mesh:
    """One mesh of some prisms, one material."""
    parts = [prism_mesh(prism) for prism in prisms]
    first = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    triangles = np.concatenate([t + n for (_, t), n in zip(parts, first, strict=False)])
    slots = np.zeros(len(triangles), dtype=np.int32)
    return Mesh(np.concatenate([v for v, _ in parts]), triangles, slots, ("any",))


def laid_out(*prisms: Prism) -> Atlas:
    mesh = mesh_of(*prisms)
    return lay_out(mesh, prisms, np.full(len(mesh.triangles), TEXEL))


def areas(corners: np.ndarray) -> np.ndarray:
    edges = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return 0.5 * np.linalg.norm(np.cross(*edges), axis=1)


def outward(corners: np.ndarray) -> np.ndarray:
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


@pytest.fixture(scope="module")
def home() -> tuple[Apartment, Atlas]:
    apartment = load_apartment("demo1")
    mesh = apartment_mesh(apartment)
    solids = apartment_solids(apartment)
    return apartment, lay_out(mesh, solids, np.full(len(mesh.triangles), TEXEL))


def test_a_lone_block_gathers_light_all_over() -> None:
    atlas = laid_out(Prism(box(0, 0, 2, 3), 0.0, 1.0, "any"))
    assert areas(atlas.receiver_corners).sum() == pytest.approx(2 * (2 * 3 + 2 * 1 + 3 * 1))
    assert len(atlas.boxes) == 6


def test_a_block_on_a_slab_hides_what_it_stands_on() -> None:
    slab, block = Prism(box(0, 0, 3, 3), -0.5, 0.0, "any"), Prism(box(1, 1, 2, 2), 0.0, 1.0, "any")
    atlas = laid_out(slab, block)
    free = (2 * 9 + 4 * 3 * 0.5) - 1 + (2 + 4) - 1
    # A lip of LIFT at the block's foot stays hidden: the slab's top, looked at from above it.
    assert areas(atlas.receiver_corners).sum() == pytest.approx(free, abs=10 * LIFT)


def test_a_sunken_block_shows_only_what_sticks_out() -> None:
    slab = Prism(box(0, 0, 3, 3), -0.5, 0.0, "any")
    block = Prism(box(1, 1, 2, 2), -0.3, 0.7, "any")
    atlas = laid_out(slab, block)
    upright = np.abs(outward(atlas.receiver_corners)[:, 2]) < 0.1
    block_sides = upright & (atlas.receiver_corners[..., :2].min(axis=(1, 2)) > 0.5)
    assert areas(atlas.receiver_corners[block_sides]).sum() == pytest.approx(4 * 0.7, abs=0.01)
    assert atlas.receiver_corners[block_sides][..., 2].min() == pytest.approx(0.0, abs=1e-9)


def test_a_wall_and_the_piece_over_its_doorway_are_one_chart() -> None:
    left, right = (Prism(box(x, 0, x + 1, 0.2), 0.0, 2.5, "any") for x in (0.0, 2.0))
    above = Prism(box(1, 0, 2, 0.2), 2.0, 2.5, "any")
    mesh = mesh_of(left, right, above)
    atlas = lay_out(mesh, (left, right, above), np.full(len(mesh.triangles), TEXEL))
    front = np.abs(mesh.vertices[mesh.triangles][..., 1]).max(axis=1) < 1e-9
    assert np.count_nonzero(front) == 6
    # Texels are one linear image of the plane, without a seam.
    at = mesh.vertices[mesh.triangles][front].reshape(-1, 3)
    system = np.column_stack([at[:, 0], at[:, 2], np.ones(len(at))])
    found, *_ = np.linalg.lstsq(system, atlas.uv[front].reshape(-1, 2), rcond=None)
    np.testing.assert_allclose(system @ found, atlas.uv[front].reshape(-1, 2), atol=1e-6)
    assert np.abs(found[:2]).max() == pytest.approx(1 / TEXEL, rel=0.05)


def test_charts_do_not_overlap_and_hold_their_triangles(home: tuple[Apartment, Atlas]) -> None:
    atlas = home[1]
    taken = np.zeros(atlas.shape, dtype=int)
    for row, column, rows, columns in atlas.boxes:
        taken[row : row + rows, column : column + columns] += 1
    assert taken.max() == 1
    inner = atlas.boxes + np.array([GUTTER, GUTTER, -2 * GUTTER, -2 * GUTTER])
    for uv in (atlas.uv, atlas.receiver_uv):
        low, high = uv.min(axis=1)[:, ::-1], uv.max(axis=1)[:, ::-1]
        tree = shapely.STRtree(
            shapely.box(
                *(inner[:, k] for k in (0, 1)), *(inner[:, k] + inner[:, k + 2] for k in (0, 1))
            )
        )
        bounds = shapely.box(*(low + 1e-6).T, *np.maximum(high - 1e-6, low + 1e-6).T)
        assert set(tree.query(bounds, predicate="within")[0]) == set(range(len(uv)))


def test_no_receiver_of_an_apartment_is_in_a_solid(home: tuple[Apartment, Atlas]) -> None:
    apartment, atlas = home
    weights = np.random.default_rng(0).dirichlet((1.0, 1.0, 1.0), len(atlas.receiver_corners))
    points = np.einsum("tc,tci->ti", weights, atlas.receiver_corners)
    for prism in apartment_solids(apartment):
        between = (points[:, 2] > prism.bottom + 1e-6) & (points[:, 2] < prism.top - 1e-6)
        inside = shapely.contains_xy(prism.footprint.buffer(-1e-6), points[between, :2])
        assert not inside.any()


def test_receivers_float_before_the_surface_that_they_serve() -> None:
    block = Prism(box(-1, -1, 1, 1), -1.0, 1.0, "any")
    atlas = laid_out(block)
    facing = outward(atlas.receiver_corners)
    distance = np.einsum("ti,ti->t", facing, atlas.receiver_corners[:, 0])
    np.testing.assert_allclose(distance, 1.0 + LIFT)
