"""Solutions and decisions are libsvm's."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize
from sklearn.svm import SVC

import roomseg.svm as module
from roomseg.kernel import kernel_column, kernel_sum
from roomseg.svm import SvmPath

Arrays = tuple[np.ndarray, np.ndarray]


def edges(count: int, seed: int) -> Arrays:
    """Five features as the reference set's: skew, overlapping, one border edge in thirty."""
    rng = np.random.default_rng(seed)
    border = rng.random(count) < 0.03
    rows = rng.normal(size=(count, 5)) + border[:, None] * (0.8, -0.9, 1.4, 0.6, 0.3)
    rows[:, 1] = np.where(rng.random(count) < 0.5, 1.1, rows[:, 1])
    rows[:, 2] = np.exp(0.7 * rows[:, 2])
    return (rows - rows.mean(axis=0)) / rows.std(axis=0), border


def dense_kernel(one: np.ndarray, other: np.ndarray, gamma: float) -> np.ndarray:
    return np.exp(-gamma * ((one[:, None] - other[None]) ** 2).sum(axis=2))


def oracle(
    known: Arrays, asked: np.ndarray, parameters: tuple[float, float, float], folder: Path
) -> np.ndarray:
    """Classes by Debian's libsvm-tools, or by scikit-learn's libsvm where they are missing."""
    (rows, border), (C, gamma, weight) = known, parameters
    if shutil.which("svm-train") is None:
        svm = SVC(C=C, gamma=gamma, class_weight={False: 1.0, True: weight}, tol=1e-5)
        return svm.fit(rows, border).predict(asked)

    def write(name: str, labels: np.ndarray, values: np.ndarray) -> None:
        lines = (
            f"{label} " + " ".join(f"{k}:{v!r}" for k, v in enumerate(row.tolist(), 1))
            for label, row in zip(np.where(labels, 1, -1), values, strict=True)
        )
        (folder / name).write_text("\n".join(lines) + "\n")

    write("known", border, rows)
    write("asked", np.zeros(len(asked), bool), asked)
    options = ["-t", "2", "-c", repr(C), "-g", repr(gamma), "-w1", repr(weight), "-w-1", "1"]
    train = ["svm-train", "-q", "-e", "1e-5", *options, "known", "model"]
    subprocess.run(train, cwd=folder, check=True)
    predict = ["svm-predict", "-q", "asked", "model", "found"]
    subprocess.run(predict, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return np.loadtxt(folder / "found") > 0


@pytest.mark.parametrize("log2_gamma", [-1, -5, -11])
def test_decisions_are_those_of_svm_train(log2_gamma: int, tmp_path: Path) -> None:
    known, asked = edges(1500, 0), edges(3000, 1)[0]
    path = SvmPath(*known, asked, 2.0**log2_gamma)
    for log2_c in (-7, -3, 1, 5):
        for weight in (20.0, 60.0):
            found = path.fit(2.0**log2_c, weight)
            theirs = oracle(known, asked, (2.0**log2_c, 2.0**log2_gamma, weight), tmp_path)
            assert ((found.decision > 0) == theirs).mean() >= 0.999
            assert found.gap <= 1e-3


@pytest.mark.parametrize("least", [20, 500])
def test_multipliers_are_feasible_and_optimal(least: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Eqs. 12-14 with the whole kernel matrix, and Eq. 16; also if few rows move at a time."""
    monkeypatch.setattr(module, "LEAST_ROWS", least)
    monkeypatch.setattr(module, "MOST_ROWS", least)
    (rows, border), asked = edges(900, 2), edges(50, 3)[0]
    path = SvmPath(rows, border, asked, 0.5)
    path.fit(0.5, 40.0)
    found = path.fit(8.0, 40.0)
    y, cost = np.where(border, 1.0, -1.0), 8.0 * np.where(border, 40.0, 1.0)
    margin = y * (dense_kernel(rows, rows, 0.5) @ (y * found.alpha) + found.bias)
    assert (found.alpha >= 0).all()
    assert (found.alpha <= cost).all()
    assert (margin[found.alpha > 0] < 1.0 + 1e-3).all()
    assert (margin[found.alpha < cost] > 1.0 - 1e-3).all()
    assert abs(y @ found.alpha) < 1e-9 * found.alpha.sum()
    decision = dense_kernel(asked, rows, 0.5) @ (y * found.alpha) + found.bias
    np.testing.assert_allclose(found.decision, decision, atol=1e-5)


def test_three_rows_by_hand() -> None:
    """Two points of one class and one between: a general solver of the dual agrees."""
    rows, border = np.array([[0.0], [1.0], [2.0]]), np.array([False, True, False])
    found = SvmPath(rows, border, rows, 1.0).fit(10.0, 1.0)
    y = np.array([-1.0, 1.0, -1.0])
    q = dense_kernel(rows, rows, 1.0) * y[:, None] * y
    best = minimize(
        lambda a: 0.5 * a @ q @ a - a.sum(),
        np.ones(3),
        bounds=[(0, 10)] * 3,
        constraints={"type": "eq", "fun": lambda a: a @ y},
    )
    np.testing.assert_allclose(found.alpha, best.x, atol=1e-3)
    np.testing.assert_allclose(found.decision, y, atol=1e-3)


def test_order_of_a_path_does_not_matter() -> None:
    known, asked = edges(1000, 6), edges(500, 7)[0]
    up, down = (SvmPath(*known, asked, 0.125) for _ in range(2))
    first = {C: up.fit(C, 40.0).decision for C in (0.125, 2.0, 32.0)}
    for C in (32.0, 2.0, 0.125):
        np.testing.assert_allclose(down.fit(C, 40.0).decision, first[C], atol=0.02)


def test_multipliers_are_libsvms() -> None:
    rows, border = edges(700, 8)
    found = SvmPath(rows, border, rows[:1], 0.5, tolerance=1e-5).fit(1.0, 40.0)
    theirs = SVC(C=1.0, gamma=0.5, class_weight={False: 1.0, True: 40.0}, tol=1e-5)
    theirs.fit(rows, border)
    alpha = np.zeros(700)
    alpha[theirs.support_] = np.abs(theirs.dual_coef_[0])
    np.testing.assert_allclose(found.alpha, alpha, atol=1e-3)
    assert found.bias == pytest.approx(float(theirs.intercept_[0]), abs=1e-4)


def test_kernel_is_that_of_eq_17() -> None:
    rows = edges(600, 9)[0]
    points, columns = rows[:40], np.ascontiguousarray(rows.T)
    expected = dense_kernel(points, rows, 0.3)
    column = np.empty(600, np.float32)
    kernel_column(columns, 7, 0.3, column)
    np.testing.assert_allclose(column, expected[7], rtol=1e-6, atol=1e-37)
    total = np.ones(600)
    kernel_sum(columns, points, np.arange(40.0), 0.3, total)
    np.testing.assert_allclose(total, 1.0 + np.arange(40.0) @ expected, rtol=1e-8)
