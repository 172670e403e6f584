"""A feature set gives back what it was given, and refuses what is wrong."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from cleaned_flat import cleaned_flat, fisheye_image

from dataset import FisheyeCamera, FormatError, MapFile, write_map, write_rooms
from roomseg.feature_set import (
    MapFeatures,
    add_to_feature_set,
    compute_features,
    content_key,
    keys_in,
    read_feature_set,
)
from roomseg.features import edge_features
from roomseg.passageway import TABLE_2

CAMERA = FisheyeCamera().resized(116)


@pytest.fixture(scope="module")
def map_path(tmp_path_factory) -> Path:
    topomap = replace(cleaned_flat("flat", 3), camera=CAMERA, scene='{"name": "Flät"}')
    images = [fisheye_image(CAMERA, node % 7) for node in range(len(topomap.nodes))]
    path = tmp_path_factory.mktemp("maps") / "flat.h5"
    write_map(path, topomap, images)
    return path


@pytest.fixture(scope="module")
def computed(map_path) -> MapFeatures:
    with MapFile(map_path) as file:
        return compute_features(file)


@pytest.fixture
def stored(tmp_path, computed) -> Path:
    add_to_feature_set(tmp_path / "set.h5", [computed])
    return tmp_path / "set.h5"


def test_table_2_has_all_42_combinations_once():
    assert len(set(TABLE_2)) == 42
    assert {p.min_intensity for p in TABLE_2} == {100, 200, 400}
    assert {p.histogram[1:] for p in TABLE_2} == {(18, 17), (36, 33)}
    degrees = {round(np.degrees(p.tolerance)) for p in TABLE_2}
    assert degrees == {50, 55, 60, 65, 70, 80, 90}


def test_every_combination_is_what_it_is_alone(map_path, computed):
    for combination in (0, 9, 41):
        with MapFile(map_path) as file:
            from roomseg.features import FeatureParameters

            parameters = FeatureParameters(lintel=TABLE_2[combination])
            alone = edge_features(file, parameters=parameters)
        own = computed.with_passageway(combination).features
        np.testing.assert_array_equal(own.values, alone.values)


def test_what_was_stored_comes_back(stored, computed):
    (found,) = read_feature_set(stored)
    before, after = computed.labelled, found.labelled
    assert (after.environment, after.run, after.room_count) == ("flat", "run1", 3)
    np.testing.assert_array_equal(after.room, before.room)
    np.testing.assert_array_equal(after.is_border, before.is_border)
    np.testing.assert_array_equal(after.features.graph.edges, before.features.graph.edges)
    np.testing.assert_array_equal(after.features.graph.kept, before.features.graph.kept)
    np.testing.assert_array_equal(found.passageway, computed.passageway)
    np.testing.assert_allclose(after.features.values, before.features.values, rtol=1e-7)
    np.testing.assert_array_equal(after.features.graph.length, after.features.column("length"))
    assert after.features.names == before.features.names


def test_figures_lose_no_more_than_half_a_unit(stored, computed):
    (found,) = read_feature_set(stored)
    before, after = computed.labelled.sketch, found.labelled.sketch
    assert after.scene == before.scene == '{"name": "Flät"}'
    assert np.abs(after.nodes.position - before.nodes.position).max() <= 0.0005001
    assert np.abs(after.nodes.heading - before.nodes.heading).max() <= 0.0005001
    assert np.abs(after.nodes.true_pose - before.nodes.true_pose).max() <= 0.0005001
    np.testing.assert_array_equal(after.nodes.lane, before.nodes.lane)
    rounded = {tuple(row) for row in np.rint(before.obstacles * 100).astype(int).tolist()}
    assert {tuple(row) for row in np.rint(after.obstacles * 100).astype(int).tolist()} == rounded


def test_storing_again_changes_no_byte_and_keeps_others(stored, computed):
    first = stored.read_bytes()
    add_to_feature_set(stored, [])
    assert stored.read_bytes() == first
    other = replace(computed, labelled=replace(computed.labelled, run="run2"), key="b" * 32)
    add_to_feature_set(stored, [other])
    assert [item.labelled.run for item in read_feature_set(stored)] == ["run1", "run2"]
    assert keys_in(stored) == {computed.key, "b" * 32}


def test_a_run_that_changed_replaces_the_earlier_one(stored, computed):
    changed = replace(computed, key="c" * 32)
    add_to_feature_set(stored, [changed])
    assert keys_in(stored) == {"c" * 32}


def test_a_real_robots_map_needs_neither_scene_nor_sketch(tmp_path, computed):
    bare = replace(computed, labelled=replace(computed.labelled, sketch=None))
    add_to_feature_set(tmp_path / "bare.h5", [bare])
    assert read_feature_set(tmp_path / "bare.h5")[0].labelled.sketch is None
    sketch = computed.labelled.sketch
    real = replace(sketch, nodes=replace(sketch.nodes, true_pose=None), scene=None)
    mine = replace(computed, labelled=replace(computed.labelled, sketch=real))
    add_to_feature_set(tmp_path / "real.h5", [mine])
    found = read_feature_set(tmp_path / "real.h5")[0].labelled.sketch
    assert found.nodes.true_pose is None
    assert found.scene is None


def test_the_key_follows_the_content(map_path, tmp_path):
    copy = tmp_path / "copy.h5"
    copy.write_bytes(map_path.read_bytes())

    def key() -> str:
        with MapFile(copy) as file:
            return content_key(file)

    first = key()
    write_rooms(copy, np.zeros(len(cleaned_flat().nodes), int), model="any", rooms=1)
    assert key() == first
    with h5py.File(copy, "r+") as file:
        file["images/pixels"][5, 50, 50] ^= 1
    assert key() != first
    with h5py.File(copy, "r+") as file:
        file["images/pixels"][5, 50, 50] ^= 1
    assert key() == first
    with h5py.File(copy, "r+") as file:
        file["ground_truth/room"][0] += 1
    assert key() != first


def damage(path: Path, name: str, value) -> None:
    with h5py.File(path, "r+") as file:
        (key,) = file["maps"]
        del file[f"maps/{key}/{name}"]
        if value is not None:
            file[f"maps/{key}/{name}"] = value


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("room", np.array([0, 7, 1], "i4"), "room: expected numbers in 0..2"),
        ("edges", np.array([[0, 99999]], "i4"), "kept: shape"),
        ("features", np.full((2, 4), 1.0, "f4"), r"features: shape \(2, 4\), expected"),
        ("passageway", np.zeros((42, 3), "u2"), "passageway: shape"),
        ("is_border", np.zeros(3, bool), "is_border: shape"),
        ("is_border", np.zeros(3, "i4"), "type int32"),
        ("estimate", np.zeros((3, 3), "i4"), "nodes/"),
        ("obstacles", np.zeros(3, "i4"), "obstacles: shape"),
        ("kept", None, "kept: missing"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(stored, name, value, words):
    damage(stored, name, value)
    with pytest.raises(FormatError, match=words) as caught:
        read_feature_set(stored)
    assert str(caught.value).startswith(f"{stored}: /maps/")
    assert "\n" not in str(caught.value)


def test_values_that_are_not_finite_are_refused(stored, computed):
    damage(stored, "features", np.full((len(computed.labelled.features.graph), 4), np.nan, "f4"))
    with pytest.raises(FormatError, match="features: has values that are not finite"):
        read_feature_set(stored)


def test_other_files_are_refused(tmp_path, map_path, stored):
    with pytest.raises(FormatError, match="no such file, expected a feature set"):
        read_feature_set(tmp_path / "none.h5")
    with pytest.raises(FormatError, match="'roomseg-map', expected 'roomseg-features'"):
        read_feature_set(map_path)
    (tmp_path / "text.h5").write_text("hello")
    with pytest.raises(FormatError, match="not an HDF5 file"):
        read_feature_set(tmp_path / "text.h5")
    cut = tmp_path / "cut.h5"
    cut.write_bytes(stored.read_bytes()[:5000])
    with pytest.raises(FormatError, match=r"cut.h5: damaged feature set"):
        read_feature_set(cut)
    with h5py.File(stored, "r+") as file:
        file["passageway_parameters"][0, 0] = 17
    with pytest.raises(FormatError, match="others than the 42 combinations"):
        read_feature_set(stored)
