"""The classifier is libsvm's C-SVM; its file holds trusted types only."""

from __future__ import annotations

import pickle
import zipfile
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
import skops.io
from sklearn.base import clone
from sklearn.model_selection import GridSearchCV, LeaveOneGroupOut
from sklearn.preprocessing import StandardScaler
from sklearn.svm import SVC
from sklearn.tree import DecisionTreeClassifier

from dataset.errors import FormatError
from roomseg.classifier import (
    ARRAYS,
    BorderModel,
    ClassifierParameters,
    TrainingMap,
    load_model,
    reduced,
    save_model,
    train,
)
from roomseg.estimators import border_pipeline
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
    parameters = ClassifierParameters()
    assert (parameters.C, parameters.gamma) == (0.125, 0.125)
    assert (parameters.class_weight, parameters.rho) == (40, 60)
    svm = border_pipeline().named_steps["svm"]
    assert (svm.C, svm.gamma, svm.kernel) == (0.125, 0.125, "rbf")
    assert svm.class_weight == {0: 1.0, 1: 40.0}


@pytest.mark.parametrize("name", ["C", "gamma", "class_weight", "rho"])
def test_parameters_are_positive(name: str) -> None:
    with pytest.raises(FormatError, match=f"classifier {name}: -1, expected > 0"):
        ClassifierParameters(**{name: -1})


def test_decision_function_is_that_of_the_paper(model: BorderModel) -> None:
    """Standardisation of §2.3.1, kernel of Eq. 17 and sum of Eq. 16, by hand."""
    training, _ = edges_with_borders()
    mean, sigma = training.mean(axis=0), training.std(axis=0)
    new = edges_with_borders(seed=1)[0]
    squared = ((((new - mean) / sigma)[:, None] - model.points[None]) ** 2).sum(axis=2)
    decision = np.exp(-0.125 * squared) @ model.coefficients + model.bias
    assert model.decision_function(new) == pytest.approx(decision)
    assert (model.predict(features_of(new)) == (decision > 0)).all()


def test_dual_solution_is_feasible_and_optimal(model: BorderModel) -> None:
    """0 <= α <= C (w C for borders), Σ y α = 0, and margins as α says (Eqs. 12-14)."""
    training, border = edges_with_borders()
    rows = (training - model.mean) / model.spread
    # Its points are the support vectors, in the order of the edges.
    support = (rows[:, None] == model.points[None]).all(axis=2).any(axis=1)
    np.testing.assert_array_equal(rows[support], model.points)
    y, limit = np.where(border, 1, -1), np.where(border, 40 * 0.125, 0.125)
    alpha = np.zeros(len(y))
    alpha[support] = model.coefficients * y[support]
    assert (alpha >= -1e-12).all()
    assert (alpha <= limit + 1e-9).all()
    assert (alpha * y).sum() == pytest.approx(0, abs=1e-9)
    margin = y * model.decision_function(training)
    tolerance = 2e-3  # libsvm stops at 1e-3
    assert (margin[alpha < 1e-9] >= 1 - tolerance).all()
    assert (margin[alpha > limit - 1e-9] <= 1 + tolerance).all()


@pytest.mark.parametrize("parameters", [{}, {"C": 8.0, "gamma": 0.5}, {"gamma": 2.0**-9}])
def test_decisions_are_libsvms(parameters: dict[str, float]) -> None:
    chosen = ClassifierParameters(**parameters)
    values, border = edges_with_borders(4000)
    exact = train(values, border, NAMES, chosen)
    libsvm = border_pipeline(chosen).fit(values, border.astype(int))
    new = edges_with_borders(4000, seed=1)[0]
    theirs = libsvm.decision_function(new)
    small = reduced(exact, values)
    for model in (exact, small):
        decision = model.decision_function(new)
        assert decision == pytest.approx(theirs, abs=0.02)
        assert ((decision > 0) == (theirs > 0)).mean() >= 0.999
    # A rugged function keeps its support vectors.
    assert (len(small.points) < 0.5 * len(exact.points)) == (chosen.gamma < 0.5)


def test_scikit_learn_searches_with_groups() -> None:
    values, border = edges_with_borders(600)
    groups = np.arange(600) % 3
    space = {"svm__C": [2.0**-9, 2.0**-3], "svm__gamma": [2.0**-3]}
    grid = GridSearchCV(border_pipeline(), space, cv=LeaveOneGroupOut(), scoring="f1")
    found = grid.fit(values, border.astype(int), groups=groups)
    assert found.best_params_["svm__C"] == 2.0**-3
    assert found.best_estimator_.predict(values)[border].mean() > 0.8
    assert clone(found.best_estimator_).get_params()["svm__C"] == 2.0**-3


def test_constant_features_and_single_precision_do_no_harm() -> None:
    values, border = edges_with_borders()
    constant = np.column_stack([values[:, :2], np.full(len(values), 0.1)])
    model = train(constant, border, NAMES)
    moved = constant + np.array([0.0, 0.0, 1e-12])
    assert model.decision_function(moved) == pytest.approx(model.decision_function(constant))
    single = train(values.astype(np.float32), border, NAMES)
    assert single.mean.dtype == np.float64


def test_a_file_that_fills_the_memory_is_refused(model: BorderModel, tmp_path: Path) -> None:
    path = tmp_path / "model.skops"
    save_model(model, path)
    with (
        zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive,
        archive.open("99.npy", "w", force_zip64=True) as member,
    ):
        for _ in range(27):
            member.write(bytes(10_000_000))
    with pytest.raises(FormatError, match="bytes unpacked, expected at most"):
        load_model(path)


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
    assert (loaded.decision_function(values) == model.decision_function(values)).all()
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
    # The last four are trusted by skops itself.
    for foreign in (tree, Planted, StandardScaler(), SVC(), np.add, np.float64):
        skops.io.dump({"format": "roomseg-model", "version": 2, "other": foreign}, path)
        with pytest.raises(FormatError, match=r"names .*expected numbers only"):
            load_model(path)


def test_wrong_content_is_refused(model: BorderModel, tmp_path: Path) -> None:
    path = tmp_path / "model.skops"
    skops.io.dump(["something", "else"], path)
    with pytest.raises(FormatError, match="not a model file"):
        load_model(path)
    skops.io.dump({"format": "roomseg-model", "version": 7}, path)
    with pytest.raises(FormatError, match="version 7, expected 2"):
        load_model(path)
    skops.io.dump({"format": "roomseg-model", "version": 2, "features": []}, path)
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
        ({"points": "hello"}, "points: expected finite numbers .f8. of shape"),
        ({"mean": np.full(3, np.nan)}, "mean: expected finite numbers .f8. of shape"),
        ({"spread": np.zeros(3)}, "spread: expected > 0"),
        ({"bias": "hello"}, "incomplete model"),
        ({"bias": 10**400}, "incomplete model"),
        ({"points": np.ones((0, 3)), "coefficients": np.ones(0)}, "model: 3 features"),
        ({"features": [["a"], ["b"], ["c"]]}, "model: 3 features"),
        ({"features": ["length", "length", "d_c"]}, "model: 3 features"),
        ({"version": np.ones(2)}, "expected 2; train again"),
        ({"format": np.ones(2)}, "not a model file"),
        ({"bias": float("nan")}, "bias: nan, expected a finite number"),
        ({"features": ["length"]}, r"mean: expected finite numbers .f8. of shape \(1,\)"),
    ],
)
def test_what_a_model_tells_is_checked(
    model: BorderModel, tmp_path: Path, change: dict[str, object], line: str
) -> None:
    path = tmp_path / "model.skops"
    content = {
        "format": "roomseg-model",
        "version": 2,
        "features": list(NAMES),
        "parameters": asdict(ClassifierParameters()),
        "bias": model.bias,
        **{name: getattr(model, name) for name in ARRAYS},
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
