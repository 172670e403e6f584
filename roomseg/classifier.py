"""The room-border classifier: a C-SVM on standardised features (§2.3).

scikit-learn's ``SVC`` is libsvm: C weighs the sum of slacks (Eq. 12), γ is that
of Eq. 17, and the class weight multiplies C for border edges (C⁺ = w C). The
paper standardises with the training set's mean and standard deviation
(§2.3.1); ``StandardScaler`` divides by N where Matlab divides by N - 1, which
for tens of thousands of edges changes nothing.

The iteration limit is libsvm's own for up to 100 000 edges; scikit-learn has
none by default.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import skops.io
from numpy.typing import NDArray
from sklearn.pipeline import Pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.svm import SVC

from dataset.atomic import replacing
from dataset.errors import FormatError
from roomseg.features import EdgeFeatures
from roomseg.model_bytes import make_repeatable

__all__ = [
    "BorderModel",
    "ClassifierParameters",
    "TrainingMap",
    "border_pipeline",
    "check_both_kinds",
    "load_model",
    "save_model",
    "train",
]

MODEL_FORMAT = "roomseg-model"
MODEL_VERSION = 1
ITERATION_LIMIT = 10_000_000
TRUSTED_TYPES = (
    "sklearn.pipeline.Pipeline",
    "sklearn.preprocessing._data.StandardScaler",
    "sklearn.svm._classes.SVC",
)
"""The only classes, besides plain numbers, texts and arrays, that a model file may name."""


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
    pipeline : sklearn.pipeline.Pipeline
        StandardScaler and SVC, fitted.
    names : tuple of str
        The features that it was trained with, in order.
    parameters : ClassifierParameters
    trained_on : tuple of TrainingMap
        Empty if it is not known.
    """

    pipeline: Any
    names: tuple[str, ...]
    parameters: ClassifierParameters
    trained_on: tuple[TrainingMap, ...] = ()

    def predict(self, features: EdgeFeatures) -> NDArray[np.bool_]:
        """Whether each edge crosses a room border (Eq. 15), shape (e',)."""
        values = features.subset(self.names).values
        if not len(values):
            return np.zeros(0, dtype=bool)
        return np.asarray(self.pipeline.predict(values), dtype=bool)


def border_pipeline(parameters: ClassifierParameters | None = None) -> Any:
    """Unfitted scikit-learn pipeline: standardisation (§2.3.1), then C-SVM (Eqs. 12-17)."""
    parameters = parameters or ClassifierParameters()
    svm = SVC(
        C=parameters.C,
        kernel="rbf",
        gamma=parameters.gamma,
        class_weight={0: 1.0, 1: parameters.class_weight},
        max_iter=ITERATION_LIMIT,
    )
    return Pipeline([("standardise", StandardScaler()), ("svm", svm)])


def train(
    features: NDArray[np.float64],
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
    pipeline = border_pipeline(parameters).fit(features, is_border.astype(np.int64))
    return BorderModel(pipeline, tuple(names), parameters)


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
        "pipeline": model.pipeline,
    }
    with replacing(path) as temporary:
        skops.io.dump(content, temporary)
        make_repeatable(temporary)


def load_model(path: str | Path) -> BorderModel:
    """Read a model file; nothing but `TRUSTED_TYPES` is ever made from it.

    Raises
    ------
    FormatError
        If the file is missing, is no model, or names other types.
    """
    content = _trusted_content(Path(path))
    if not isinstance(content, dict) or content.get("format") != MODEL_FORMAT:
        raise FormatError(f"{path}: not a model file, expected one written by roomseg train")
    if content.get("version") != MODEL_VERSION:
        raise FormatError(
            f"{path}: version {content.get('version')!r}, expected {MODEL_VERSION}; train again"
        )
    try:
        parameters = ClassifierParameters(**content["parameters"])
        trained_on = tuple(TrainingMap(**item) for item in content.get("trained_on", ()))
        names, pipeline = tuple(content["features"]), content["pipeline"]
        _check_trained(pipeline, names)
        return BorderModel(pipeline, names, parameters, trained_on)
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from error
    except (KeyError, TypeError) as error:
        raise FormatError(f"{path}: incomplete model ({error}), train again") from error


def _check_trained(pipeline: Any, names: tuple[str, ...]) -> None:
    """Refuse what is no trained classifier of these features (FormatError)."""
    steps = list(pipeline) if isinstance(pipeline, Pipeline) else []
    if [type(step) for step in steps] != [StandardScaler, SVC]:
        raise FormatError("incomplete model, expected a scaler and an SVC; train again")
    trained_with = [
        np.shape(getattr(step, name, ()))[-1:]
        for step, name in zip(steps, ("mean_", "support_vectors_"), strict=True)
    ]
    if trained_with != [(len(names),)] * 2:
        raise FormatError(f"incomplete model, not trained with its {len(names)} features")


def _trusted_content(path: Path) -> Any:
    """Load a skops file that names trusted types only."""
    try:
        unknown = set(skops.io.get_untrusted_types(file=path)) - set(TRUSTED_TYPES)
        if unknown:
            raise FormatError(
                f"{path}: names the type {min(unknown)}, expected only {', '.join(TRUSTED_TYPES)}"
            )
        return skops.io.load(path, trusted=list(TRUSTED_TYPES))
    except FormatError:
        raise
    except FileNotFoundError as error:
        raise FormatError(f"{path}: no such file, expected a model file") from error
    except Exception as error:  # skops lets zip, JSON and numpy errors of bad files through
        text = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise FormatError(f"{path}: not a readable model file ({text})") from error
