"""The parameter search ranks combinations by the mean impurity of the segmentations."""

from __future__ import annotations

import numpy as np
import pytest
from cleaned_flat import labelled_flat

from roomseg.classifier import ClassifierParameters
from roomseg.evaluation import leave_one_environment_out
from roomseg.labelled_map import LabelledMap
from roomseg.parameter_search import EXCERPT, search_parameters


@pytest.fixture(scope="module")
def maps() -> list[LabelledMap]:
    return [labelled_flat(name, seed) for seed, name in enumerate("abc")]


def test_best_combination_comes_first_and_is_what_evaluation_says(maps: list[LabelledMap]) -> None:
    good = ClassifierParameters()
    # A kernel so narrow that every edge it has not seen is within a room, and no lighter weight.
    useless = ClassifierParameters(gamma=2.0**15, rho=1.0)
    steps: list[tuple[int, int]] = []
    found = search_parameters(
        maps, [useless, good], progress=lambda done, total: steps.append((done, total))
    )
    assert [evaluation.parameters for evaluation in found] == [good, useless]
    alone = leave_one_environment_out(maps, good)
    np.testing.assert_array_equal(found[0].impurity, alone.impurity)
    assert found[0].mean_impurity < found[1].mean_impurity
    assert steps == [(1, 2), (2, 2)]


def test_excerpt_lies_in_the_full_search_space_of_table_4() -> None:
    assert EXCERPT[0] == ClassifierParameters()
    assert len(set(EXCERPT)) == 9
    for parameters in EXCERPT:
        assert np.log2(parameters.C) in range(-9, 10, 2)
        assert np.log2(parameters.gamma) in range(-15, 0, 2)
        assert parameters.class_weight in (20, 40, 60)
        assert parameters.rho in range(20, 121, 20)
