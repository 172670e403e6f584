"""Fewer points give the same sums."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roomseg.reduced_set import reduced_set


def sums(
    rows: np.ndarray, points: np.ndarray, coefficients: np.ndarray, gamma: float
) -> np.ndarray:
    """The same in a line of NumPy."""
    return np.exp(-gamma * ((rows[:, None] - points[None]) ** 2).sum(axis=2)) @ coefficients


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 1000),
    count=st.integers(1, 300),
    features=st.integers(1, 5),
    gamma=st.sampled_from([2.0**-11, 2.0**-3, 2.0, 64.0]),
)
def test_no_sum_differs_by_more_than_the_tolerance(
    seed: int, count: int, features: int, gamma: float
) -> None:
    rng = np.random.default_rng(seed)
    points, coefficients = rng.normal(size=(count, features)), rng.choice([-1.0, 4.0], count)
    fewer, new = reduced_set(points, points, coefficients, gamma)
    assert len(fewer) == len(new) <= count
    difference = sums(points, fewer, new, gamma) - sums(points, points, coefficients, gamma)
    assert np.abs(difference).max() <= 1.001e-3


def test_of_no_rows_nothing_is_known() -> None:
    points = np.ones((3, 2))
    assert reduced_set(points[:0], points, np.ones(3), 1.0)[0] is points


def test_a_smooth_function_needs_few_points() -> None:
    rng = np.random.default_rng(0)
    points, coefficients = rng.normal(size=(3000, 2)), rng.normal(size=3000)
    fewer, _ = reduced_set(points, points, coefficients, 0.1)
    assert len(fewer) < 100


def test_a_rugged_one_keeps_all() -> None:
    points = np.arange(50.0)[:, None]
    fewer, coefficients = reduced_set(points, points, np.ones(50), 10.0)
    assert (fewer == points).all() and (coefficients == 1.0).all()


@pytest.mark.parametrize("coefficients", [np.zeros(4), np.full(4, 1e-9)])
def test_nearly_nothing_stays_as_it_is(coefficients: np.ndarray) -> None:
    points = np.arange(8.0).reshape(4, 2)
    assert reduced_set(points, points, coefficients, 1.0)[0] is points
