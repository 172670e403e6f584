"""What a report is made of: maps, plans, images and results, ready to be shown.

The command line assembles these; nothing here computes a result that the
experiments have not, except counts and sums for headings.
"""

from __future__ import annotations

from dataclasses import dataclass
from statistics import fmean, median
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dataset.camera import FisheyeCamera
from dataset.topomap import TopoMap
from roomseg.figures import Plan, RocCurve

__all__ = [
    "PAPER_CLASSIFIER",
    "PAPER_UNIFORM",
    "Comparison",
    "Fact",
    "LintelView",
    "MapResult",
    "Measure",
    "PassageView",
    "Place",
    "Report",
    "Snapshot",
    "Spread",
]

Ints = NDArray[Any]


@dataclass(frozen=True)
class Spread:
    """Mean and median of impurities, 0 to 1."""

    mean: float
    median: float

    @classmethod
    def of(cls, impurities: list[float]) -> Spread | None:
        """Mean and median of what there is; None of nothing."""
        return cls(fmean(impurities), median(impurities)) if impurities else None


PAPER_CLASSIFIER = Spread(0.0313, 0.0104)
"""All features, over the paper's 31 maps (Table 10)."""
PAPER_UNIFORM = Spread(0.1291, 0.1546)
"""Uniform edge weights, no classifier (Table 10)."""


@dataclass(frozen=True)
class Fact:
    """One number of a heading or a table of facts, already written out with its unit."""

    label: str
    value: str
    note: str = ""


@dataclass(frozen=True)
class Snapshot:
    """The camera image at a node (h, w) u1, and its unfolded panorama."""

    node: int
    image: NDArray[np.uint8]
    panorama: NDArray[np.uint8] | None = None


@dataclass(frozen=True)
class LintelView:
    """The lintel search at one node, for Fig. 8.

    pixels (p, 2) are (row, column) of the edge pixels and theta (p,) their
    gradient directions, rad; histogram (N_theta, N_s) is the one of the four
    with the highest bin; ``directions`` (rad) and ``offsets`` (px) are where its
    bins begin and end; offset_limit is s_max, px.
    """

    node: int
    image: NDArray[np.uint8]
    camera: FisheyeCamera
    pixels: Ints
    theta: NDArray[np.float64]
    histogram: Ints
    directions: tuple[float, float]
    offsets: tuple[float, float]
    offset_limit: float


@dataclass(frozen=True)
class PassageView:
    """The passageway width of one edge, for Fig. 7, in the robot's estimate.

    ends (2, 2) are its nodes, obstacles (k, 2) the points near it, closest
    (2, 2) the two whose distance is L, m; ``strip`` is where the search area
    begins and ends along the edge, from its middle, m.
    """

    ends: NDArray[np.float64]
    obstacles: NDArray[np.float64]
    closest: NDArray[np.float64]
    strip: tuple[float, float]
    width: float


@dataclass(frozen=True)
class MapResult:
    """One cleaning run and what the method made of it; whatever is absent is left out.

    Attributes
    ----------
    topomap : TopoMap
    kept : array, shape (e', 2)
        Edges after preprocessing, as node indices (Fig. 5).
    border : array of bool, shape (e',)
        Kept edges that the classifier calls border edges (Fig. 12).
    room, uniform_room : array, shape (n,)
        Rooms found with the classifier's weights and with uniform ones.
    impurity, uniform_impurity : float
        1 - psi of Eq. 18 for either, 0 to 1.
    facts : tuple of Fact
        Coverage, path length and whatever else is known of the run.
    """

    topomap: TopoMap
    kept: Ints | None = None
    border: NDArray[np.bool_] | None = None
    room: Ints | None = None
    uniform_room: Ints | None = None
    impurity: float | None = None
    uniform_impurity: float | None = None
    facts: tuple[Fact, ...] = ()

    @property
    def name(self) -> str:
        """Environment and run, as the tables name the map."""
        return f"{self.topomap.environment} · {self.topomap.run}"


@dataclass(frozen=True)
class Place:
    """An apartment with all its maps; plan geometry is m in the scene frame.

    The first map is shown in full, further ones by their rooms only.
    ``outlines`` are the obstacles, ``floor`` the rooms with their passages.
    """

    name: str
    maps: tuple[MapResult, ...]
    description: str = ""
    outlines: Plan | None = None
    floor: Plan | None = None
    base_station: tuple[float, float] | None = None
    snapshots: tuple[Snapshot, ...] = ()
    lintel: LintelView | None = None
    facts: tuple[Fact, ...] = ()


@dataclass(frozen=True)
class Measure:
    """One of our numbers, the paper's, and the range that we accept."""

    name: str
    value: float
    paper: float | None = None
    accepted: tuple[float, float] | None = None
    digits: int = 3

    @property
    def agrees(self) -> bool | None:
        """Whether the value lies in the accepted range; None without one."""
        if self.accepted is None:
            return None
        return bool(self.accepted[0] <= self.value <= self.accepted[1])


@dataclass(frozen=True)
class Comparison:
    """A table of measures beside the paper's, such as Table 1 or Table 3."""

    title: str
    measures: tuple[Measure, ...]
    note: str = ""


@dataclass(frozen=True)
class Report:
    """Everything on the page.

    ``roc_without_images`` and ``roc_with_images`` are the two panels of Fig. 11;
    ``impurity_by_variant`` names experiments and their mean impurities, 0 to 1,
    beside the paper's of the same name (Fig. 26).
    """

    title: str
    created: str
    software: str
    places: tuple[Place, ...]
    description: str = ""
    facts: tuple[Fact, ...] = ()
    comparisons: tuple[Comparison, ...] = ()
    roc_without_images: tuple[RocCurve, ...] = ()
    roc_with_images: tuple[RocCurve, ...] = ()
    impurity_by_variant: tuple[tuple[str, float, float | None], ...] = ()

    @property
    def maps(self) -> tuple[MapResult, ...]:
        """All maps, in the order of the places."""
        return tuple(result for place in self.places for result in place.maps)

    @property
    def classifier(self) -> Spread | None:
        """Impurity with the classifier over all maps."""
        return Spread.of([m.impurity for m in self.maps if m.impurity is not None])

    @property
    def uniform(self) -> Spread | None:
        """Impurity with uniform weights over all maps."""
        return Spread.of([m.uniform_impurity for m in self.maps if m.uniform_impurity is not None])
