"""The classifier is libsvm's C-SVM; its file holds trusted types only."""

from __future__ import annotations

import pickle
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
import skops.io
from sklearn.base import clone
from sklearn.model_selection import GridSearchCV, LeaveOneGroupOut
from sklearn.tree import DecisionTreeClassifier

from dataset.errors import FormatError
from roomseg.classifier import (
    BorderModel,
    ClassifierParameters,
    TrainingMap,
    border_pipeline,
    load_model,
    save_model,
    train,
)
from roomseg.features import EdgeFeatures
from roomseg.preprocessing import MapGraph

NAMES = ("length", "passageway", "d_c")


def edges_with_borders(count: int = 400, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    border = rng.random(count) < 0.05
    values = rng.normal(0, 1, (count, 3)) + 2.0 * border[:, None]
    return values * (0.1, 30.0, 500.0) + (0.2, 60.0, 2000.0), border


def features_of(values: np.ndarray, names: tuple[str, ...] = NAMES) -> EdgeFeatures:
    n = len(values)
    edges = np.stack([np.arange(n), np.arange(1, n + 1)], axis=1)
    return EdgeFeatures(MapGraph(n + 1, np.arange(n), edges, np.ones(n)), values, names)


@pytest.fixture
def model() -> BorderModel:
    return train(*edges_with_borders(), NAMES)


def test_defaults_are_those_of_table_6() -> None:
    svm = border_pipeline().named_steps["svm"]
    assert (svm.C, svm.gamma, svm.kernel) == (0.125, 0.125, "rbf")
    assert svm.class_weight == {0: 1.0, 1: 40.0}
    assert ClassifierParameters().rho == 60


@pytest.mark.parametrize("name", ["C", "gamma", "class_weight", "rho"])
def test_parameters_are_positive(name: str) -> None:
    with pytest.raises(FormatError, match=f"classifier {name}: -1, expected > 0"):
        ClassifierParameters(**{name: -1})


def test_decision_function_is_that_of_the_paper(model: BorderModel) -> None:
    """Standardisation of §2.3.1, kernel of Eq. 17 and sum of Eq. 16, by hand."""
    training, _ = edges_with_borders()
    mean, sigma = training.mean(axis=0), training.std(axis=0)
    svm = model.pipeline.named_steps["svm"]
    new = edges_with_borders(seed=1)[0]
    squared = ((((new - mean) / sigma)[:, None] - svm.support_vectors_[None]) ** 2).sum(axis=2)
    decision = np.exp(-0.125 * squared) @ svm.dual_coef_[0] + svm.intercept_[0]
    assert model.pipeline.decision_function(new) == pytest.approx(decision)
    assert (model.predict(features_of(new)) == (decision > 0)).all()


def test_dual_solution_is_feasible_and_optimal(model: BorderModel) -> None:
    """0 <= α <= C (w C for borders), Σ y α = 0, and margins as α says (Eqs. 12-14)."""
    training, border = edges_with_borders()
    svm = model.pipeline.named_steps["svm"]
    y, limit = np.where(border, 1, -1), np.where(border, 40 * 0.125, 0.125)
    alpha = np.zeros(len(y))
    alpha[svm.support_] = svm.dual_coef_[0] * y[svm.support_]
    assert (alpha >= -1e-12).all()
    assert (alpha <= limit + 1e-9).all()
    assert (alpha * y).sum() == pytest.approx(0, abs=1e-9)
    margin = y * model.pipeline.decision_function(training)
    tolerance = 2e-3  # libsvm stops at 1e-3
    assert (margin[alpha < 1e-9] >= 1 - tolerance).all()
    assert (margin[alpha > limit - 1e-9] <= 1 + tolerance).all()


def test_scikit_learn_searches_with_groups() -> None:
    values, border = edges_with_borders(600)
    groups = np.arange(600) % 3
    space = {"svm__C": [2.0**-9, 2.0**-3], "svm__gamma": [2.0**-3]}
    grid = GridSearchCV(border_pipeline(), space, cv=LeaveOneGroupOut(), scoring="f1")
    found = grid.fit(values, border.astype(int), groups=groups)
    assert found.best_params_["svm__C"] == 2.0**-3
    model = BorderModel(found.best_estimator_, NAMES, ClassifierParameters())
    assert model.predict(features_of(values))[border].mean() > 0.8
    assert clone(found.best_estimator_).get_params()["svm__C"] == 2.0**-3


def test_higher_class_weight_finds_more_borders() -> None:
    values, border = edges_with_borders()
    found = [
        train(values, border, NAMES, ClassifierParameters(class_weight=w))
        .predict(features_of(values))[border]
        .mean()
        for w in (1.0, 40.0)
    ]
    assert found[0] < found[1]


def test_columns_are_found_by_name(model: BorderModel) -> None:
    values = edges_with_borders(seed=2)[0]
    extended = np.column_stack([values[:, 2], np.zeros(len(values)), values[:, :2]])
    shuffled = features_of(extended, ("d_c", "d_s", "length", "passageway"))
    assert (model.predict(shuffled) == model.predict(features_of(values))).all()
    with pytest.raises(FormatError, match="features: no 'd_c'"):
        model.predict(features_of(values[:, :2], NAMES[:2]))


def test_map_without_edges(model: BorderModel) -> None:
    empty = EdgeFeatures(
        MapGraph(1, np.arange(0), np.empty((0, 2), int), np.empty(0)), np.empty((0, 3)), NAMES
    )
    assert model.predict(empty).shape == (0,)


@pytest.mark.parametrize("value", [True, False])
def test_one_kind_of_edge_only(value: bool) -> None:
    with pytest.raises(FormatError, match="expected some of both kinds"):
        train(np.random.default_rng(0).random((5, 3)), np.full(5, value), NAMES)


def test_saved_model_is_the_same_model(model: BorderModel, tmp_path: Path) -> None:
    save_model(model, tmp_path / "model.skops")
    loaded = load_model(tmp_path / "model.skops")
    values = edges_with_borders(seed=3)[0]
    same = loaded.pipeline.decision_function(values) == model.pipeline.decision_function(values)
    assert same.all()
    assert (loaded.names, loaded.parameters) == (model.names, model.parameters)
    assert [path.name for path in tmp_path.iterdir()] == ["model.skops"]


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="no such file"):
        load_model(tmp_path / "none.skops")


class Planted:
    def __reduce__(self) -> tuple[object, tuple[str]]:
        return Path.touch, (Path("planted"),)


@pytest.mark.parametrize("content", [b"", b"hello", pickle.dumps({"format": "roomseg-model"})])
def test_other_files_are_refused(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "model.skops").write_bytes(content)
    with pytest.raises(FormatError, match="not a readable model file") as caught:
        load_model(tmp_path / "model.skops")
    assert "\n" not in str(caught.value)


def test_pickle_is_never_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("model.skops").write_bytes(pickle.dumps(Planted()))
    with pytest.raises(FormatError):
        load_model("model.skops")
    assert not Path("planted").exists()


def test_unknown_types_are_refused(model: BorderModel, tmp_path: Path) -> None:
    tree = DecisionTreeClassifier().fit([[0.0], [1.0]], [0, 1])
    path = tmp_path / "model.skops"
    for foreign in (tree, Planted):
        skops.io.dump({"format": "roomseg-model", "version": 1, "pipeline": foreign}, path)
        with pytest.raises(FormatError, match=r"names the type .*expected only sklearn"):
            load_model(path)


def test_wrong_content_is_refused(model: BorderModel, tmp_path: Path) -> None:
    path = tmp_path / "model.skops"
    skops.io.dump(["something", "else"], path)
    with pytest.raises(FormatError, match="not a model file"):
        load_model(path)
    skops.io.dump({"format": "roomseg-model", "version": 7}, path)
    with pytest.raises(FormatError, match="version 7, expected 1"):
        load_model(path)
    skops.io.dump({"format": "roomseg-model", "version": 1, "features": []}, path)
    with pytest.raises(FormatError, match="incomplete model"):
        load_model(path)


def test_a_model_knows_its_maps(model: BorderModel, tmp_path: Path) -> None:
    path = tmp_path / "model.skops"
    maps = (TrainingMap("home", "run1", nodes=400, rooms=3, edges=900, border_edges=12),)
    save_model(replace(model, trained_on=maps), path)
    assert load_model(path).trained_on == maps
    save_model(model, path)
    assert load_model(path).trained_on == ()


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"trained_on": [{"environment": "x"}]}, "incomplete model"),
        ({"trained_on": 5}, "incomplete model"),
        ({"trained_on": [["x", "y", 1, 1, 1, 1]]}, "incomplete model"),
        ({"pipeline": "hello"}, "expected a scaler and an SVC"),
        ({"pipeline": border_pipeline()}, "not trained with its 3 features"),
        ({"features": ["length"]}, "not trained with its 1 features"),
    ],
)
def test_what_a_model_tells_is_checked(
    model: BorderModel, tmp_path: Path, change: dict[str, object], line: str
) -> None:
    path = tmp_path / "model.skops"
    content = {
        "format": "roomseg-model",
        "version": 1,
        "features": list(NAMES),
        "parameters": asdict(ClassifierParameters()),
        "pipeline": model.pipeline,
    }
    skops.io.dump(content, path)
    assert load_model(path).names == NAMES
    skops.io.dump(content | change, path)
    with pytest.raises(FormatError, match=line) as error:
        load_model(path)
    assert str(error.value).startswith(str(path))


def test_figures_of_a_training_map_are_numbers() -> None:
    with pytest.raises(FormatError, match="training map rooms: '<b>', expected a number"):
        TrainingMap("home", "run1", nodes=4, rooms="<b>", edges=9, border_edges=1)
    with pytest.raises(FormatError, match="training map run: 3, expected a name"):
        TrainingMap("home", 3, nodes=4, rooms=1, edges=9, border_edges=1)
