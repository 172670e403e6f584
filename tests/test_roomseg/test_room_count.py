"""Room count estimates on maps whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from dataset.errors import FormatError
from roomseg.room_count import EigenvalueGap, NodeCountRegression, room_count_quality

SPECTRA = [
    np.array([0, 0.001, 0.002, 0.030, 0.031]),  # three rooms
    np.array([0, 0.002, 0.040, 0.041, 0.043]),  # two
    np.array([0, 0.001, 0.003, 0.005, 0.036]),  # four
]


def test_regression_recovers_equation_23() -> None:
    nodes = np.array([400, 625, 900, 1600, 2500])
    rooms = 0.3 * np.sqrt(nodes) - 0.001 * nodes - 1.0
    model = NodeCountRegression.fit(nodes, rooms)
    assert (model.a, model.b, model.c) == pytest.approx((0.3, -0.001, -1.0))
    assert model.predict(900) == 7  # 9 - 0.9 - 1 = 7.1
    assert model.predict(1) == 1


def test_regression_without_maps() -> None:
    with pytest.raises(FormatError, match="0 training maps"):
        NodeCountRegression.fit([], [])


def test_gap_finds_the_rooms_of_its_training_maps() -> None:
    model = EigenvalueGap.fit(SPECTRA, [3, 2, 4])
    assert [model.predict(values) for values in SPECTRA] == [3, 2, 4]
    assert model.a > 0


def test_first_large_gap_wins() -> None:
    """Eq. 26: the smallest i, not the largest gap."""
    model = EigenvalueGap(1000.0, -20.0)  # gaps from 0.02
    assert model.predict(np.array([0, 0.001, 0.030, 0.090])) == 2


def test_without_a_large_gap_the_likeliest() -> None:
    model = EigenvalueGap(1000.0, -20.0)
    assert model.predict(np.array([0, 0.001, 0.002, 0.010, 0.011])) == 3


def test_overlapping_gaps_have_a_finite_optimum() -> None:
    """The gradient of the unregularised likelihood vanishes at (a, b)."""
    rng = np.random.default_rng(0)
    spectra = [np.cumsum(np.r_[0, rng.exponential(0.01, 4), 0.01, 0.01]) for _ in range(30)]
    rooms = rng.integers(2, 6, 30)
    model = EigenvalueGap.fit(spectra, rooms)
    gaps = np.concatenate([np.diff(s)[:m] for s, m in zip(spectra, rooms, strict=True)])
    last = np.concatenate([np.arange(1, m + 1) == m for m in rooms])
    residual = 1 / (1 + np.exp(-(model.a * gaps + model.b))) - last
    assert residual.sum() == pytest.approx(0, abs=0.02)
    assert (residual * gaps).sum() == pytest.approx(0, abs=1e-3)


def test_too_few_eigenvalues() -> None:
    with pytest.raises(FormatError, match="eigenvalues: 3, expected more than the 3 rooms"):
        EigenvalueGap.fit([np.zeros(3)], [3])


def test_quality_by_hand() -> None:
    quality = room_count_quality([3, 4, 7, 2], [3, 5, 5, 2])
    assert quality.mean_absolute_error == pytest.approx(0.75)
    assert quality.exact == 0.5
    assert quality.within_one == 0.75
