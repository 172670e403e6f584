"""Leave-one-environment-out on flats with made-up features."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cleaned_flat import cleaned_flat, labelled_flat

from dataset.errors import FormatError
from roomseg.classifier import ClassifierParameters
from roomseg.evaluation import (
    Evaluation,
    evaluate_room_count,
    leave_one_environment_out,
    map_rng,
    segment_map,
    train_on,
)
from roomseg.labelled_map import LabelledMap
from roomseg.metrics import impurity
from roomseg.segmentation import segment


@pytest.fixture(scope="module")
def maps() -> list[LabelledMap]:
    names = [("a", 1, "run1"), ("a", 2, "run2"), ("b", 3, "run1"), ("c", 4, "run1")]
    return [labelled_flat(name, seed, run=run) for name, seed, run in names]


@pytest.fixture(scope="module")
def evaluation(maps: list[LabelledMap]) -> Evaluation:
    return leave_one_environment_out(maps)


def test_good_features_give_good_rooms(evaluation: Evaluation) -> None:
    assert evaluation.mean_impurity < 0.02
    assert all(result.borders.recall > 0.8 for result in evaluation.results)


def test_results_come_in_the_order_of_the_maps(evaluation: Evaluation) -> None:
    order = [(result.environment, result.run) for result in evaluation.results]
    assert order == [("a", "run1"), ("a", "run2"), ("b", "run1"), ("c", "run1")]


def test_order_of_maps_does_not_matter(maps: list[LabelledMap], evaluation: Evaluation) -> None:
    turned = leave_one_environment_out(maps[::-1])
    assert (turned.impurity[::-1] == evaluation.impurity).all()
    assert (turned.uniform_impurity[::-1] == evaluation.uniform_impurity).all()
    for one, other in zip(turned.results[::-1], evaluation.results, strict=True):
        assert (one.labels == other.labels).all()


def test_mean_median_and_impurity(maps: list[LabelledMap], evaluation: Evaluation) -> None:
    expected = [
        impurity(result.labels, item.room)
        for result, item in zip(evaluation.results, maps, strict=True)
    ]
    assert evaluation.impurity.tolist() == expected
    assert evaluation.mean_impurity == pytest.approx(sum(expected) / 4)
    assert evaluation.median_impurity == pytest.approx(np.median(expected))


def test_uniform_variant_uses_no_classifier(
    maps: list[LabelledMap], evaluation: Evaluation
) -> None:
    for result, item in zip(evaluation.results, maps, strict=True):
        assert (result.uniform_labels == segment_map(item, None)).all()


def test_no_training_on_the_tested_environment() -> None:
    """Features that mislead in 'a' only: 'a' is judged by 'b', and so goes wrong."""
    good, bad = labelled_flat("b", 3), labelled_flat("a", 1)
    misleading = replace(bad, features=replace(bad.features, values=-bad.features.values))
    result = leave_one_environment_out([misleading, good]).results
    assert result[0].borders.recall < 0.1
    assert result[1].borders.recall < 0.1
    both = train_on([misleading])
    assert both.predict(misleading.features)[misleading.is_border].mean() > 0.9


def test_progress_counts_all_maps(maps: list[LabelledMap]) -> None:
    reports: list[tuple[int, int]] = []
    leave_one_environment_out(maps, progress=lambda done, total: reports.append((done, total)))
    assert reports == [(1, 4), (2, 4), (3, 4), (4, 4)]


def test_rho_of_one_gives_no_weight_to_the_classifier(maps: list[LabelledMap]) -> None:
    plain = leave_one_environment_out(maps, ClassifierParameters(rho=1.0))
    for result, item in zip(plain.results, maps, strict=True):
        graph = item.features.graph
        nothing = np.zeros(len(graph), dtype=bool)
        rng = map_rng(0, item)
        assert (result.labels == segment(graph, nothing, item.room_count, rng)).all()


def test_one_environment_only(maps: list[LabelledMap]) -> None:
    with pytest.raises(FormatError, match=r"maps: 1 environments \(a\), expected at least 2"):
        leave_one_environment_out(maps[:2])


def test_nothing_to_train_on() -> None:
    with pytest.raises(FormatError, match="maps: none to train on"):
        train_on([])


def test_maps_with_other_features(maps: list[LabelledMap]) -> None:
    other = replace(maps[3], features=maps[3].features.subset(["length"]))
    with pytest.raises(FormatError, match="features: no 'passageway'"):
        train_on([maps[0], other])


def test_unlabelled_map_is_refused(maps: list[LabelledMap]) -> None:
    topomap = cleaned_flat("a", 1)
    bare = topomap.with_ground_truth(replace(topomap.ground_truth, room=None))
    with pytest.raises(FormatError, match="a/run1: no ground_truth/room"):
        LabelledMap.of(bare, maps[0].features)


def test_generator_is_the_maps_own(maps: list[LabelledMap]) -> None:
    draws = [map_rng(seed, item).random() for seed in (0, 1) for item in maps]
    assert len(set(draws)) == len(draws)
    assert map_rng(0, maps[0]).random() == draws[0]


def test_room_count_of_equal_flats_is_learnt(maps: list[LabelledMap]) -> None:
    by_nodes, by_gap = evaluate_room_count(maps)
    assert by_nodes.exact == 1.0
    assert by_gap.mean_absolute_error <= 1.0


def test_arrays_that_do_not_fit_the_graph_are_refused(maps: list[LabelledMap]) -> None:
    with pytest.raises(FormatError, match=r"a/run1: is_border: shape \(3,\), expected"):
        replace(maps[0], is_border=maps[0].is_border[:3])
    with pytest.raises(FormatError, match=r"a/run1: room: shape \(3,\), expected"):
        replace(maps[0], room=maps[0].room[:3])
