"""The score sheet's numbers are those of the segmentations; its intervals draw whole places."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cleaned_flat import labelled_flat
from sklearn.metrics import precision_score, recall_score

from roomseg.evaluation import leave_one_environment_out
from roomseg.labelled_map import LabelledMap
from roomseg.score_sheet import ANSWERS, MEASURES, Score, ScoreSheet, score, score_sheet


@pytest.fixture(scope="module")
def maps() -> list[LabelledMap]:
    names = [("a", 1, "run1"), ("a", 2, "run2"), ("b", 3, "run1"), ("c", 4, "run1")]
    return [labelled_flat(name, seed, run=run) for name, seed, run in names]


@pytest.fixture(scope="module")
def sheet(maps) -> ScoreSheet:
    return score_sheet(maps)


def test_segmentations_are_those_of_leave_one_out(maps, sheet):
    alone = leave_one_environment_out(maps)
    for ours, theirs in zip(sheet.evaluation.results, alone.results, strict=True):
        np.testing.assert_array_equal(ours.labels, theirs.labels)
        np.testing.assert_array_equal(ours.uniform_labels, theirs.uniform_labels)
    np.testing.assert_allclose(sheet.scores["method"][:, 0], alone.impurity)
    np.testing.assert_allclose(sheet.scores["uniform"][:, 0], alone.uniform_impurity)


def test_one_room_by_hand(maps, sheet):
    for item, row in zip(maps, sheet.scores["one room"], strict=True):
        largest = np.bincount(item.room).max() / len(item.room)
        expected = Score(1 - largest, 0.0, 0.0, largest / 3, 0.5 * (largest >= 0.5), 0.0, 0.0, 2.0)
        found = dict(zip(MEASURES, row, strict=True))
        assert found == pytest.approx(vars(expected))


def test_borders_are_where_found_rooms_end(maps):
    item = maps[0]
    labels = np.where(np.arange(len(item.room)) % 2, item.room, 0).astype(np.int32)
    cut = labels[item.features.graph.edges[:, 0]] != labels[item.features.graph.edges[:, 1]]
    found = score(labels, item, 5)
    assert found.border_precision == pytest.approx(precision_score(item.is_border, cut))
    assert found.border_recall == pytest.approx(recall_score(item.is_border, cut))
    assert found.room_count_error == 2.0


def test_the_truth_itself(maps):
    found = score(maps[0].room, maps[0], 3)
    assert (found.impurity, found.room_count_error) == (0.0, 0.0)
    assert found.adjusted_rand == found.v_measure == found.mean_iou == found.room_f1 == 1.0
    assert found.border_precision == 1.0
    assert found.border_recall < 1.0  # three lines in each doorway, of which rooms end at one


def test_places_are_means_of_their_maps(sheet):
    assert sheet.places == ("a", "b", "c")
    np.testing.assert_allclose(
        sheet.of_place("method", "a"), sheet.scores["method"][:2].mean(axis=0)
    )


def test_intervals_by_full_enumeration(sheet):
    """Three places of 2, 1 and 1 maps: 27 equally likely draws."""
    groups = [[0, 1], [2], [3]]
    values = np.array([0.1, 0.3, 0.6, 0.2])
    scores = {answer: np.tile(values[:, None], (1, len(MEASURES))) for answer in ANSWERS}
    low, high = replace(sheet, scores=scores).intervals("method", np.random.default_rng(0))
    means = sorted(
        float(values[groups[i] + groups[j] + groups[k]].mean())
        for i in range(3)
        for j in range(3)
        for k in range(3)
    )
    assert low[0] == pytest.approx(means[0])  # 1 of 27 is more than 2.5 %
    assert high[0] == pytest.approx(means[-1])
    assert (low <= values.mean()).all()


def test_equal_maps_have_no_interval(sheet):
    scores = {answer: np.full((4, len(MEASURES)), 0.25) for answer in ANSWERS}
    limits = replace(sheet, scores=scores).intervals("uniform", np.random.default_rng(1))
    np.testing.assert_allclose(limits, 0.25)
