"""The room-border classifier: a C-SVM on standardised features (§2.3).

C weighs the sum of slacks (Eq. 12), γ is that of Eq. 17, and the class weight multiplies C for
border edges (C⁺ = w C). The optimum is that of libsvm, found by `roomseg.svm`. The paper
standardises with the training set's mean and standard deviation (§2.3.1); ours divides by
N where Matlab divides by N - 1, which for tens of thousands of edges changes nothing.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import skops.io
from numpy.typing import NDArray
from sklearn.preprocessing import StandardScaler

from dataset.atomic import replacing
from dataset.errors import FormatError
from roomseg.features import EdgeFeatures
from roomseg.kernel import kernel_sum
from roomseg.model_bytes import check_plain, make_repeatable
from roomseg.reduced_set import reduced_set
from roomseg.svm import SvmPath

__all__ = [
    "BorderModel",
    "ClassifierParameters",
    "TrainingMap",
    "check_both_kinds",
    "load_model",
    "reduced",
    "save_model",
    "train",
]

MODEL_FORMAT = "roomseg-model"
MODEL_VERSION = 2
ARRAYS = ("mean", "spread", "points", "coefficients")

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ClassifierParameters:
    """(Ĉ, γ̂, ŵ, ρ̂) of Table 6.

    Attributes
    ----------
    C, gamma : float
    class_weight : float
        w: border edges count so many times (§2.3.2).
    rho : float
        ρ: the weight of predicted border edges is divided by it (§2.3.2).
    """

    C: float = 2.0**-3
    gamma: float = 2.0**-3
    class_weight: float = 40.0
    rho: float = 60.0

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if not (np.isfinite(value) and value > 0):
                raise FormatError(f"classifier {name}: {value}, expected > 0")


@dataclass(frozen=True)
class TrainingMap:
    """A map that a model was trained on, in figures; ``edges`` are those that were used."""

    environment: str
    run: str
    nodes: int
    rooms: int
    edges: int
    border_edges: int

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            is_name = name in ("environment", "run")
            if is_name and not isinstance(value, str):
                raise FormatError(f"training map {name}: {value!r}, expected a name")
            if not is_name and (type(value) is not int or value < 0):
                raise FormatError(f"training map {name}: {value!r}, expected a number >= 0")


@dataclass(frozen=True)
class BorderModel:
    """A trained classifier and what is needed to use it.

    Attributes
    ----------
    names : tuple of f str
        The features that it was trained with, in order.
    parameters : ClassifierParameters
    mean, spread : arrays, shape (f,)
        Of the training edges (§2.3.1).
    points : array, shape (k, f)
        Standardised: the support vectors, or those of `reduced`.
    coefficients : array, shape (k,)
        What Eq. 16 multiplies the kernel of each point with.
    bias : float
        b.
    trained_on : tuple of TrainingMap
        Empty if it is not known.
    """

    names: tuple[str, ...]
    parameters: ClassifierParameters
    mean: Floats
    spread: Floats
    points: Floats
    coefficients: Floats
    bias: float
    trained_on: tuple[TrainingMap, ...] = ()

    def __post_init__(self) -> None:
        f, k = len(self.names), len(np.atleast_1d(self.coefficients))
        if not f or len({name for name in self.names if isinstance(name, str)}) != f or not k:
            raise FormatError(f"model: {f} features {self.names!r}, expected names, each once")
        for name, shape in zip(ARRAYS, ((f,), (f,), (k, f), (k,)), strict=True):
            array = getattr(self, name)
            if array.shape != shape or array.dtype != np.float64 or not np.isfinite(array).all():
                raise FormatError(f"{name}: expected finite numbers (f8) of shape {shape}")
        if not (self.spread > 0).all():
            raise FormatError("spread: expected > 0")
        if not np.isfinite(self.bias):
            raise FormatError(f"bias: {self.bias}, expected a finite number")

    def decision_function(self, values: Floats) -> Floats:
        """Eq. 16 of edges, (t, f) features in the order of ``names``, shape (t,)."""
        rows = np.ascontiguousarray(((values - self.mean) / self.spread).T)
        decision = np.full(len(values), self.bias)
        kernel_sum(rows, self.points, self.coefficients, self.parameters.gamma, decision)
        return decision

    def predict(self, features: EdgeFeatures) -> NDArray[np.bool_]:
        """Whether each edge crosses a room border (Eq. 15), shape (e',)."""
        is_border: NDArray[np.bool_] = (
            self.decision_function(features.subset(self.names).values) > 0.0
        )
        return is_border


def train(
    features: Floats,
    is_border: NDArray[np.bool_],
    names: tuple[str, ...],
    parameters: ClassifierParameters | None = None,
) -> BorderModel:
    """Train on the edges of all training maps together (§2.3.2).

    Parameters
    ----------
    features : array, shape (t, f)
    is_border : array, shape (t,)
    names : tuple of f str
    parameters : ClassifierParameters, optional

    Raises
    ------
    FormatError
        If the edges are all of one class.
    """
    parameters = parameters or ClassifierParameters()
    check_both_kinds(is_border)
    features = np.asarray(features, np.float64)
    # A constant feature is told from rounding.
    scaler = StandardScaler().fit(features)
    mean, spread = scaler.mean_, scaler.scale_
    rows = (features - mean) / spread
    path = SvmPath(rows, is_border, rows[:0], parameters.gamma)
    solution = path.fit(parameters.C, parameters.class_weight)
    held = solution.alpha > 0.0
    coefficients = np.where(is_border, solution.alpha, -solution.alpha)[held]
    return BorderModel(
        tuple(names), parameters, mean, spread, rows[held], coefficients, solution.bias
    )


def reduced(model: BorderModel, features: Floats) -> BorderModel:
    """Make a model smaller and faster that says almost the same (`roomseg.reduced_set`).

    Parameters
    ----------
    model : BorderModel
    features : array, shape (t, f)
        Edges for which it says the same, those that it was trained on.
    """
    rows = (features - model.mean) / model.spread
    points, coefficients = reduced_set(
        rows, model.points, model.coefficients, model.parameters.gamma
    )
    return replace(model, points=points, coefficients=coefficients)


def check_both_kinds(is_border: NDArray[np.bool_]) -> None:
    """Refuse training edges that are all of one class (FormatError)."""
    borders = int(np.count_nonzero(is_border))
    if not 0 < borders < len(is_border):
        raise FormatError(
            f"ground_truth/edge_is_border: {borders} of {len(is_border)} training edges "
            "cross a border, expected some of both kinds"
        )


def save_model(model: BorderModel, path: str | Path) -> None:
    """Write a model as a skops file (no pickle); the old file stays until it is complete.

    Equal models give equal bytes.
    """
    content = {
        "format": MODEL_FORMAT,
        "version": MODEL_VERSION,
        "features": list(model.names),
        "parameters": asdict(model.parameters),
        "trained_on": [asdict(item) for item in model.trained_on],
        "bias": model.bias,
        **{name: getattr(model, name) for name in ARRAYS},
    }
    with replacing(path) as temporary:
        skops.io.dump(content, temporary)
        make_repeatable(temporary)


def load_model(path: str | Path) -> BorderModel:
    """Read a model file: numbers, texts and arrays; nothing else is ever made from it.

    Raises
    ------
    FormatError
        If the file is missing, is no model, or names any type.
    """
    content = _trusted_content(Path(path))
    kind = content.get("format") if isinstance(content, dict) else None
    if not isinstance(kind, str) or kind != MODEL_FORMAT:
        raise FormatError(f"{path}: not a model file, expected one written by roomseg train")
    found = content.get("version")
    if type(found) is not int or found != MODEL_VERSION:
        raise FormatError(f"{path}: version {found!r}, expected {MODEL_VERSION}; train again")
    try:
        return BorderModel(
            names=tuple(content["features"]),
            parameters=_parameters(content["parameters"]),
            bias=float(content["bias"]),
            trained_on=tuple(TrainingMap(**item) for item in content.get("trained_on", ())),
            **{name: np.asarray(content[name]) for name in ARRAYS},
        )
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from error
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise FormatError(f"{path}: incomplete model ({error}), train again") from error


def _parameters(content: dict[str, Any]) -> ClassifierParameters:
    return ClassifierParameters(**{name: float(value) for name, value in content.items()})


def _trusted_content(path: Path) -> Any:
    """Load a skops file of plain content."""
    try:
        check_plain(path)
        return skops.io.load(path, trusted=[])
    except FormatError:
        raise
    except FileNotFoundError as error:
        raise FormatError(f"{path}: no such file, expected a model file") from error
    except Exception as error:  # skops lets zip, JSON and numpy errors of bad files through
        text = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise FormatError(f"{path}: not a readable model file ({text})") from error
