"""Exported scenes, read by Blender itself and, as glTF, by trimesh."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from scene_makers import read_contents

from dataset import RoomsegError
from render.scene_export import write_scene
from scenes import Apartment, SceneError, load_apartment
from scenes.apartment import SceneFile
from scenes.materials import mean_colour, resolve
from scenes.mesh import apartment_mesh
from scenes.solids import apartment_solids, solid_groups


@pytest.fixture(scope="module")
def place() -> Apartment:
    return load_apartment("sim3")


@pytest.fixture(scope="module")
def glb(place: Apartment, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("glb") / "sim3.glb"
    write_scene(place, path)
    return path


@pytest.fixture(scope="module")
def blend(place: Apartment, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What Blender finds in the exported file."""
    folder = tmp_path_factory.mktemp("blend")
    write_scene(place, folder / "sim3.blend")
    return read_contents(folder, folder / "sim3.blend")


def upright(scene: trimesh.Scene) -> trimesh.Trimesh:
    """One mesh with z up; glTF has y up."""
    mesh = scene.to_mesh()
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (1, 0, 0)))
    return mesh


def test_the_glb_has_the_surface_that_is_rendered(place: Apartment, glb: Path) -> None:
    found = upright(trimesh.load_scene(glb))
    ours = apartment_mesh(place)
    wanted = trimesh.Trimesh(ours.vertices, ours.triangles, process=False)
    np.testing.assert_allclose(found.bounds, wanted.bounds, atol=1e-5)
    assert found.area == pytest.approx(wanted.area, rel=1e-5)
    volume = sum(prism.volume for prism in apartment_solids(place))
    assert found.volume == pytest.approx(volume, rel=1e-4)


def test_the_glb_has_an_object_for_everything_by_its_name(place: Apartment, glb: Path) -> None:
    names = set(trimesh.load_scene(glb).graph.nodes)
    for group in solid_groups(place):
        assert group.name in names, group.name
    kinds = {piece.kind for piece in place.furniture}
    assert all(any(name.startswith(kind) for name in names) for kind in kinds)


def test_surfaces_in_the_glb_have_the_mean_colour_of_their_pattern(
    place: Apartment, glb: Path
) -> None:
    scene = trimesh.load_scene(glb)
    materials = {g.visual.material.name: g.visual.material for g in scene.geometry.values()}
    for name in (place.rooms[0].floor, place.rooms[0].walls):
        surface = resolve(place, name)
        found = np.asarray(materials[name].baseColorFactor)[:3]
        assert found == pytest.approx(255 * np.array(mean_colour(surface)), abs=1.0)
        assert (materials[name].roughnessFactor or 1.0) == pytest.approx(surface.roughness)


def test_equal_apartments_give_equal_glb_bytes(place: Apartment, glb: Path, tmp_path: Path) -> None:
    write_scene(place, tmp_path / "again.glb")
    assert (tmp_path / "again.glb").read_bytes() == glb.read_bytes()
    assert len(list(tmp_path.iterdir())) == 1


def test_the_blend_is_sorted_into_collections(place: Apartment, blend: dict[str, Any]) -> None:
    wanted: dict[str, list[str]] = {}
    for group in solid_groups(place):
        wanted.setdefault(group.collection, []).append(group.name)
    found = blend["collections"]
    assert len(found.pop("lights")) >= 1
    assert found == {name: sorted(items) for name, items in wanted.items()}
    assert {"walls", "floors", "ceilings", "passages", "furniture"} <= found.keys()


def test_furniture_in_the_blend_is_taken_hold_of_where_it_stands(
    place: Apartment, blend: dict[str, Any]
) -> None:
    for index, piece in enumerate(place.furniture):
        *origin, turn = blend["origins"][f"{piece.kind} {index}"]
        assert origin == pytest.approx([*piece.position, 0.0], abs=1e-5)
        assert np.cos(turn - np.radians(piece.rotation_deg)) == pytest.approx(1.0)


def test_the_blend_has_the_robots_camera_at_the_start(
    place: Apartment, blend: dict[str, Any]
) -> None:
    lens, x, y, z = blend["camera"]
    assert lens == "FISHEYE_EQUIDISTANT"
    assert (x, y) == pytest.approx(place.start.position)
    assert 0.0 < z < 0.2


def test_what_cannot_be_written_is_one_line(place: Apartment, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"sim3.fbx: unknown suffix; expected .blend or .glb"):
        write_scene(place, tmp_path / "sim3.fbx")
    own = place.model_copy(update={"scene_file": SceneFile(file="a.blend", sha256="0" * 64)})
    with pytest.raises(SceneError, match=r"is a.blend already"):
        write_scene(own, tmp_path / "sim3.glb")
    with pytest.raises(RoomsegError, match=r"nowhere/a.glb: cannot be written: No such file") as no:
        write_scene(place, tmp_path / "nowhere" / "a.glb")
    assert "\n" not in str(no.value)
    assert not list(tmp_path.iterdir())
