"""Metrics on examples worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from roomseg.metrics import (
    BorderErrors,
    border_errors,
    border_quality,
    feature_quality,
    impurity,
    length_statistics,
    purity,
    room_overlap,
    segmentation_quality,
    width_statistics,
)

ROOMS = np.array([0, 0, 0, 0, 1, 1, 1, 2, 2, 2])


def test_purity_by_hand() -> None:
    labels = np.array([1, 1, 1, 0, 0, 0, 0, 2, 2, 1])
    # Cluster 1 holds three of room 0 and one of 2, cluster 0 one of 0 and three of 1.
    assert purity(labels, ROOMS) == pytest.approx((3 + 3 + 2) / 10)
    assert impurity(labels, ROOMS) == pytest.approx(0.2)


def test_names_of_labels_do_not_matter() -> None:
    assert purity(np.array([5, 5, 5, 5, 0, 0, 0, 9, 9, 9]), ROOMS) == 1.0


def test_merged_and_split_rooms() -> None:
    assert purity(np.zeros(10, int), ROOMS) == pytest.approx(0.4)
    assert purity(np.arange(10), ROOMS) == 1.0  # splitting alone costs nothing


def test_purity_is_the_double_loop_of_equation_18() -> None:
    rng = np.random.default_rng(0)
    labels, rooms = rng.integers(0, 5, 200), rng.integers(0, 4, 200)
    largest = [max(((labels == i) & (rooms == j)).sum() for j in range(4)) for i in range(5)]
    assert purity(labels, rooms) == pytest.approx(sum(largest) / 200)


def test_perfect_segmentation() -> None:
    quality = segmentation_quality(ROOMS + 3, ROOMS)
    assert (quality.impurity, quality.adjusted_rand, quality.v_measure) == (0, 1, 1)


def test_border_quality_by_hand() -> None:
    predicted = np.array([True, True, True, False, False])
    actual = np.array([True, False, False, True, False])
    quality = border_quality(predicted, actual)
    assert quality.precision == pytest.approx(1 / 3)
    assert quality.recall == pytest.approx(1 / 2)
    assert border_quality(np.zeros(3, bool), np.ones(3, bool)).precision == 0


def test_roc_by_hand() -> None:
    values = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    border = np.array([False, False, True, False, True])
    quality = feature_quality(values, border)
    # Of six pairs (border, within-room) five are in order; J = 1 - 1/3 at the threshold 3.
    assert quality.auc == pytest.approx(5 / 6)
    assert quality.youden == pytest.approx(2 / 3)
    assert quality.threshold == 3.0
    assert quality.higher_is_border


def test_a_low_value_may_mean_border() -> None:
    values = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    border = np.array([False, False, True, False, True])
    quality = feature_quality(-values, border)
    assert quality.auc == pytest.approx(5 / 6)
    assert quality.youden == pytest.approx(2 / 3)
    assert quality.threshold == -3.0
    assert not quality.higher_is_border


def test_area_is_the_share_of_ordered_pairs() -> None:
    rng = np.random.default_rng(1)
    border = rng.random(300) < 0.2
    values = np.round(rng.normal(0, 1, 300) + border, 1)  # with ties
    pairs = values[border][:, None] - values[~border][None]
    expected = ((pairs > 0) + 0.5 * (pairs == 0)).mean()
    quality = feature_quality(values, border)
    assert quality.auc == pytest.approx(expected)
    scores = [(values[border] >= t).mean() - (values[~border] >= t).mean() for t in values]
    assert quality.youden == pytest.approx(max(scores))


def test_a_weight_stands_for_so_many_edges() -> None:
    rng = np.random.default_rng(2)
    border = rng.random(80) < 0.3
    values = np.round(rng.normal(0, 1, 80) + border, 1)
    times = rng.integers(1, 5, 80)
    whole = feature_quality(np.repeat(values, times), np.repeat(border, times))
    weighted = feature_quality(values, border, times.astype(float))
    assert weighted.auc == pytest.approx(whole.auc)
    assert weighted.youden == pytest.approx(whole.youden)


def test_one_kind_of_edge_only() -> None:
    with pytest.raises(ValueError, match="expected both"):
        feature_quality(np.arange(3.0), np.ones(3, bool))


def test_table_1_by_hand() -> None:
    length = np.array([0.1, 0.1, 0.19, 0.2, 0.3])
    border = np.array([False, True, False, True, True])
    table = length_statistics(length, border)
    assert table.short == pytest.approx(3 / 5)
    assert table.border == pytest.approx(3 / 5)
    assert table.border_given_short == pytest.approx(1 / 3)
    assert table.border_given_long == 1
    assert table.class_ratio == pytest.approx(2 / 3)


def test_width_statistics_by_hand() -> None:
    width = np.array([0.4, 0.45, 0.8, 4.0, 5.0, 5.0])
    border = np.array([True, False, True, False, False, False])
    statistics = width_statistics(width, border)
    assert statistics.missing == pytest.approx(1 / 3)
    assert statistics.largest == 4.0
    assert statistics.border_given_narrow == 0.5
    nothing = width_statistics(np.full(3, 5.0), np.zeros(3, bool))
    assert np.isnan(nothing.largest)
    assert np.isnan(nothing.border_given_narrow)


def test_room_overlap_by_hand() -> None:
    rooms = np.array([0, 0, 0, 0, 1, 1, 1, 1, 2, 2])
    labels = np.array([5, 5, 5, 7, 7, 7, 7, 7, 7, 9])
    # 5 and 0 share 3 of 4 nodes, 7 and 1 share 4 of 6, 9 and 2 share 1 of 2.
    iou, f1 = room_overlap(labels, rooms)
    assert iou == pytest.approx((3 / 4 + 4 / 6 + 1 / 2) / 3)
    assert f1 == 1.0
    # With a stricter threshold only the first pair counts: 2 · 1 / (3 + 3).
    assert room_overlap(labels, rooms, 0.7)[1] == pytest.approx(1 / 3)


def test_one_room_overlaps_the_largest_only() -> None:
    rooms = np.array([0, 0, 0, 1, 1, 2])
    iou, f1 = room_overlap(np.zeros(6, int), rooms)
    assert iou == pytest.approx((3 / 6) / 3)
    assert f1 == pytest.approx(2 * 1 / (1 + 3))


def test_pairs_are_chosen_together_not_one_by_one() -> None:
    # Cluster 0 overlaps room 0 best (3/6), but room 1 would then be left with nothing.
    rooms = np.array([0, 0, 0, 1, 1, 1, 0])
    labels = np.array([0, 0, 0, 0, 0, 1, 1])
    table = {(0, 0): 3 / 6, (0, 1): 2 / 6, (1, 0): 1 / 5, (1, 1): 1 / 4}
    best = max(table[0, 0] + table[1, 1], table[0, 1] + table[1, 0])
    assert room_overlap(labels, rooms)[0] == pytest.approx(best / 2)


# Three rooms in a row of twelve nodes: 0 0 0 0 | 1 1 1 1 1 1 | 2 2
ROW = np.array([0] * 4 + [1] * 6 + [2] * 2)
CHAIN = np.stack([np.arange(11), np.arange(1, 12)], axis=1)


@pytest.mark.parametrize(
    ("found", "missed", "false"),
    [
        ([0] * 4 + [1] * 6 + [2] * 2, 0, 0),
        ([0] * 5 + [1] * 5 + [2] * 2, 0, 0),  # merely shifted
        ([0] * 4 + [1] * 3 + [2] * 5, 0, 1),  # 2 is no room of its own: 1 goes either way
        ([0] * 2 + [1] * 2 + [2] * 8, 1, 1),  # the small room is lost, the first is split
        ([0] * 12, 2, 0),
        (list(range(12)), 0, 3 + 5 + 1),
    ],
)
def test_border_errors_by_hand(found: list[int], missed: int, false: int) -> None:
    errors = border_errors(np.array(found), ROW, CHAIN)
    assert errors == BorderErrors(missed, false)


def test_rooms_that_are_no_neighbours_have_no_border_to_miss() -> None:
    # Rooms 0 and 2 lie in one cluster, but no edge joins them.
    assert border_errors(np.where(ROW == 1, 1, 0), ROW, CHAIN) == BorderErrors(0, 0)
