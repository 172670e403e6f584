"""The parameter search finds what evaluating every combination alone finds, and goes on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cleaned_flat import labelled_flat

import roomseg.parameter_search as module
from dataset.errors import FormatError
from roomseg.classifier import ClassifierParameters
from roomseg.evaluation import leave_one_environment_out
from roomseg.experiments import Cache
from roomseg.labelled_map import LabelledMap
from roomseg.parameter_search import EXCERPT, search_parameters

SOME = tuple(
    ClassifierParameters(2.0**c, 2.0**gamma, w, rho)
    for c in (-3, 5)
    for gamma in (-1, -7)
    for w in (20.0, 40.0)
    for rho in (20.0, 60.0)
)


@pytest.fixture(scope="module")
def maps() -> list[LabelledMap]:
    return [labelled_flat(name, seed) for seed, name in enumerate("abc")]


def test_impurities_are_those_of_the_plain_loop(maps: list[LabelledMap]) -> None:
    found = search_parameters(maps, SOME)
    assert found.combinations == SOME
    for index in (0, 3, 6, 9, 12, 15):
        alone = leave_one_environment_out(maps, SOME[index])
        np.testing.assert_array_equal(found.impurity[index], alone.impurity)


def test_best_combination(maps: list[LabelledMap]) -> None:
    good = ClassifierParameters()
    useless = ClassifierParameters(class_weight=1e-3)  # never finds a border
    found = search_parameters(maps, [useless, good])
    assert found.best == good
    assert found.order.tolist() == [1, 0]
    assert found.lowest == found.mean[1] < found.mean[0]


def test_any_number_of_processes_finds_the_same(maps: list[LabelledMap]) -> None:
    alone, several = (search_parameters(maps, SOME[:4], jobs=jobs) for jobs in (1, 2))
    np.testing.assert_array_equal(alone.impurity, several.impurity)


def test_a_stopped_search_goes_on(
    maps: list[LabelledMap], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(done: int, total: int) -> None:
        assert total == 6
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        search_parameters(maps, SOME, cache=Cache(tmp_path), progress=stop)
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    assert len(kept) == 2
    found = search_parameters(maps, SOME, cache=Cache(tmp_path))
    assert len(list(tmp_path.iterdir())) == 6
    assert all(path.stat().st_mtime_ns == time for path, time in kept.items())
    monkeypatch.setattr(module, "judge_part", None)
    again = search_parameters(maps, SOME, cache=Cache(tmp_path))
    np.testing.assert_array_equal(again.impurity, found.impurity)
    with pytest.raises(TypeError):
        search_parameters(maps, SOME, cache=Cache(tmp_path), seed=1)


def test_equal_labellings_are_segmented_once(
    maps: list[LabelledMap], monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = []
    segment = module.segment
    monkeypatch.setattr(
        module, "segment", lambda *args: calls.append(args[1].tobytes()) or segment(*args)
    )
    useless = [ClassifierParameters(class_weight=1e-3, rho=rho) for rho in (10.0, 20.0, 30.0)]
    search_parameters(maps, useless)
    assert len(calls) == len(maps)


def test_too_few_places_and_edges_of_one_kind(maps: list[LabelledMap]) -> None:
    with pytest.raises(FormatError, match="1 environments"):
        search_parameters(maps[:1])
    plain = [
        LabelledMap(m.environment, m.run, m.features, m.is_border & False, m.room, m.room_count)
        for m in maps
    ]
    with pytest.raises(FormatError, match="expected some of both kinds"):
        search_parameters([maps[0], *plain[1:]])


def test_excerpt_lies_in_the_full_search_space_of_table_4() -> None:
    assert EXCERPT[0] == ClassifierParameters()
    assert len(set(EXCERPT)) == 9
    for parameters in EXCERPT:
        assert np.log2(parameters.C) in range(-9, 10, 2)
        assert np.log2(parameters.gamma) in range(-15, 0, 2)
        assert parameters.class_weight in (20, 40, 60)
        assert parameters.rho in range(20, 121, 20)
