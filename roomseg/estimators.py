"""The method with the habits of scikit-learn, for its searches, pipelines and cross-validation.

A sample is a map, and its group is its environment: maps of one place are never in both the
training and the test set (§2.3.3). So the paper's experiment is

    groups = [item.environment for item in maps]
    cross_val_score(RoomSegmenter(), maps, groups=groups, cv=LeaveOneGroupOut())

A score is the mean of a fold, so that the mean of all scores weighs places alike where the
paper weighs maps alike. `roomseg.parameter_search` gives the paper's means, and does at once
what a grid search does again and again.

Edges alone are classified by `border_pipeline`, all of scikit-learn: ``SVC`` is libsvm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.pipeline import Pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.svm import SVC
from sklearn.utils.validation import check_is_fitted

from dataset.storage import MapFile
from roomseg.classifier import BorderModel, ClassifierParameters
from roomseg.evaluation import segment_map, train_on
from roomseg.features import FEATURES, FeatureParameters, edge_features
from roomseg.labelled_map import LabelledMap
from roomseg.metrics import impurity
from roomseg.panorama import PanoramaParameters
from roomseg.passage_width import WidthParameters
from roomseg.passageway import LintelParameters

__all__ = ["EdgeFeatureExtractor", "RoomSegmenter", "border_pipeline"]

ITERATION_LIMIT = 10_000_000
"""libsvm's own for up to 100,000 edges; scikit-learn has none by default."""


def border_pipeline(parameters: ClassifierParameters | None = None) -> Pipeline:
    """Unfitted: standardisation (§2.3.1), then C-SVM (Eqs. 12-17)."""
    parameters = parameters or ClassifierParameters()
    svm = SVC(
        C=parameters.C,
        kernel="rbf",
        gamma=parameters.gamma,
        class_weight={0: 1.0, 1: parameters.class_weight},
        max_iter=ITERATION_LIMIT,
    )
    return Pipeline([("standardise", StandardScaler()), ("svm", svm)])


class RoomSegmenter(BaseEstimator):  # type: ignore[misc]
    """Train on maps whose rooms are known, and find the rooms of others (§2.3, §2.4).

    Parameters
    ----------
    C, gamma, class_weight, rho : float
        As in `roomseg.classifier.ClassifierParameters`.
    features : sequence of str
        Names of edge features; `roomseg.features.SUBSETS` has those of §3.3.
    seed : int
        For the starts of k-means.

    Attributes
    ----------
    model_ : BorderModel
        Of the last `fit`; `roomseg.classifier.save_model` keeps it.
    """

    model_: BorderModel

    def __init__(
        self,
        *,
        C: float = ClassifierParameters.C,
        gamma: float = ClassifierParameters.gamma,
        class_weight: float = ClassifierParameters.class_weight,
        rho: float = ClassifierParameters.rho,
        features: Sequence[str] = FEATURES,
        seed: int = 0,
    ) -> None:
        self.C, self.gamma, self.class_weight, self.rho = C, gamma, class_weight, rho
        self.features = features
        self.seed = seed

    def fit(self, maps: Sequence[LabelledMap], y: object = None) -> Self:
        """Train one classifier on the edges of all maps; ``y`` is not used.

        Raises
        ------
        FormatError
            If a parameter is out of range, a feature is missing, or all edges are of one kind.
        """
        parameters = ClassifierParameters(self.C, self.gamma, self.class_weight, self.rho)
        names = tuple(self.features)
        chosen = [replace(item, features=item.features.subset(names)) for item in maps]
        self.model_ = train_on(chosen, parameters)
        return self

    def predict(self, maps: Sequence[LabelledMap]) -> list[NDArray[np.int32]]:
        """Room of each node, one array (n,) for each map, with as many rooms as there are."""
        check_is_fitted(self, "model_")
        return [segment_map(item, self.model_, self.seed) for item in maps]

    def score(self, maps: Sequence[LabelledMap], y: object = None) -> float:
        """Return minus the mean impurity (Eq. 18), so that more is better; ``y`` is not used."""
        found = zip(self.predict(maps), maps, strict=True)
        return -float(np.mean([impurity(labels, item.room) for labels, item in found]))


class EdgeFeatureExtractor(TransformerMixin, BaseEstimator):  # type: ignore[misc]
    """From paths of map files to maps with their edge features (§2.2), for pipelines.

    Parameters
    ----------
    width : WidthParameters, optional
    lintel : LintelParameters, optional
    panorama : PanoramaParameters, optional
        The paper's if absent.
    features : sequence of str
        Which ones; without those of the camera no image is read.
    """

    def __init__(
        self,
        *,
        width: WidthParameters | None = None,
        lintel: LintelParameters | None = None,
        panorama: PanoramaParameters | None = None,
        features: Sequence[str] = FEATURES,
    ) -> None:
        self.width, self.lintel, self.panorama = width, lintel, panorama
        self.features = features

    def fit(self, paths: Sequence[str | Path], y: object = None) -> Self:
        """Nothing is learnt from the maps."""
        return self

    def transform(self, paths: Sequence[str | Path]) -> list[LabelledMap]:
        """Compute the features of every map.

        Raises
        ------
        FormatError
            If a map cannot be read, or lacks room labels or images.
        """
        return [self._labelled(path) for path in paths]

    def _labelled(self, path: str | Path) -> LabelledMap:
        parameters = FeatureParameters(
            self.width or WidthParameters(),
            self.lintel or LintelParameters(),
            self.panorama or PanoramaParameters(),
        )
        with MapFile(path) as map_file:
            found = edge_features(map_file, tuple(self.features), parameters=parameters)
            return LabelledMap.of(map_file.topomap, found)

    def __sklearn_is_fitted__(self) -> bool:
        """It always is: nothing is learnt."""
        return True
