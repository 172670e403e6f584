"""The method in the hands of scikit-learn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cleaned_flat import cleaned_flat
from made_up_features import map_features
from sklearn.base import clone
from sklearn.exceptions import NotFittedError
from sklearn.model_selection import GridSearchCV, LeaveOneGroupOut, cross_val_score
from sklearn.pipeline import make_pipeline

from dataset import write_map
from dataset.errors import FormatError
from roomseg.classifier import ClassifierParameters
from roomseg.estimators import EdgeFeatureExtractor, RoomSegmenter
from roomseg.evaluation import leave_one_environment_out
from roomseg.features import SUBSETS
from roomseg.parameter_search import search_parameters


@pytest.fixture(scope="module")
def maps():
    """Two runs in each of three places."""
    return [map_features(place, i).labelled for i, place in enumerate("aabbcc")]


@pytest.fixture(scope="module")
def groups(maps):
    return [item.environment for item in maps]


def test_cross_validation_by_groups_is_the_papers(maps, groups):
    scores = cross_val_score(RoomSegmenter(), maps, groups=groups, cv=LeaveOneGroupOut())
    paper = leave_one_environment_out(maps).impurity.reshape(3, 2).mean(axis=1)
    assert np.array_equal(-scores, paper)


def test_a_grid_search_agrees_with_the_fast_one(maps, groups):
    grid = {"gamma": [2.0**-3, 2.0**-9], "rho": [2.0, 60.0]}
    slow = GridSearchCV(RoomSegmenter(), grid, cv=LeaveOneGroupOut()).fit(maps, groups=groups)
    combinations = [ClassifierParameters(**chosen) for chosen in slow.cv_results_["params"]]
    fast = search_parameters(maps, combinations)
    # Places have the same number of maps here, so that both means are the same.
    assert np.allclose(-slow.cv_results_["mean_test_score"], fast.mean, atol=1e-12)
    assert len(slow.predict(maps[:1])[0]) == len(maps[0].room)


def test_a_clone_has_the_parameters_and_not_what_was_learnt(maps):
    first = RoomSegmenter(C=2.0, features=SUBSETS["no-camera"]).fit(maps)
    second = clone(first)
    assert second.get_params() == first.get_params()
    assert first.model_.names == SUBSETS["no-camera"]
    with pytest.raises(NotFittedError):
        second.predict(maps)
    assert clone(EdgeFeatureExtractor()).get_params() == EdgeFeatureExtractor().get_params()


def test_a_pipeline_from_files_to_rooms(tmp_path):
    paths = [tmp_path / f"{place}.h5" for place in ("north", "south")]
    for seed, path in enumerate(paths):
        write_map(path, replace(cleaned_flat(path.stem, seed), path=None))
    blind = SUBSETS["no-camera"]
    whole = make_pipeline(EdgeFeatureExtractor(features=blind), RoomSegmenter(features=blind))
    labels = whole.fit(paths).predict(paths)
    assert [len(np.unique(found)) for found in labels] == [3, 3]
    assert whole.score(paths) <= 0.0


def test_what_is_out_of_range_is_refused_when_it_is_used(maps):
    with pytest.raises(FormatError, match="classifier rho: -1"):
        RoomSegmenter(rho=-1).fit(maps)
    with pytest.raises(FormatError, match="no 'colour'"):
        RoomSegmenter(features=("length", "colour")).fit(maps)
