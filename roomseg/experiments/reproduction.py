"""All experiments, one after the other, each result kept (`reproduce`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from roomseg.classifier import ClassifierParameters
from roomseg.experiments import grids
from roomseg.experiments.additional_tests import AdditionalTests
from roomseg.experiments.cache import Cache
from roomseg.experiments.edge_statistics import edge_statistics, environments_table
from roomseg.experiments.grids import Grid
from roomseg.experiments.maps import Maps, judged, part_of
from roomseg.experiments.parameter_selection import ParameterSelection
from roomseg.experiments.partial_features import PartialFeatures
from roomseg.experiments.passageway_parameters import passageway_parameters
from roomseg.experiments.room_counts import room_counts
from roomseg.experiments.room_figures import Judged, Plans
from roomseg.experiments.searches import Search, search
from roomseg.experiments.segmentations import Segmentations
from roomseg.experiments.single_features import single_features
from roomseg.experiments.tables import Drawing, Table
from roomseg.feature_set import MapFeatures
from roomseg.labelled_map import LabelledMap

__all__ = ["FULL_SETTINGS", "QUICK_SETTINGS", "Reproduction", "Section", "Settings", "reproduce"]

Progress = Callable[[str, int, int], None]
"""Told what is being done, how much of it is done, and how much there is."""


@dataclass(frozen=True)
class Settings:
    """The search spaces by their names in Tables 4 and 9.

    ``selection`` goes from coarse to fine; a variant may have several spaces.
    """

    selection: Mapping[str, Grid]
    variants: Mapping[str, Mapping[str, Grid]]


_BASIC = {"basic": grids.BASIC}
FULL_SETTINGS = Settings(
    {"full": grids.FULL, "fine": grids.FINE, "extrafine": grids.EXTRAFINE},
    {
        "no-camera": {**_BASIC, "no-camera": grids.NO_CAMERA},
        "no-pano": _BASIC,
        "no-ceiling": {"no-ceiling": grids.NO_CEILING},
        "no-obst": _BASIC,
    },
)
"""The paper's."""

_COARSE = {"coarse": grids.COARSE}
QUICK_SETTINGS = Settings(
    _COARSE, dict.fromkeys(("no-camera", "no-pano", "no-ceiling", "no-obst"), _COARSE)
)
"""Eight combinations for each, to try everything out."""


@dataclass(frozen=True)
class Section:
    """What the report shows of one experiment."""

    title: str
    tables: tuple[Table, ...] = ()
    drawings: tuple[Drawing, ...] = ()
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True)
class Reproduction:
    """All results.

    Attributes
    ----------
    sections : tuple of Section
    parameters : ClassifierParameters
        (Ĉ, γ̂, ŵ, ρ̂) that were chosen.
    segmentations : Segmentations
        Of the reference maps with them.
    passageway : int
        The combination of Table 2 that was chosen.
    """

    sections: tuple[Section, ...]
    parameters: ClassifierParameters
    segmentations: Segmentations
    passageway: int


@dataclass(frozen=True)
class _Work:
    """What all experiments share."""

    maps: Maps
    settings: Settings
    cache: Cache
    seed: int
    jobs: int
    tell: Progress = field(compare=False)

    def search(self, grid: Grid, name: str, variant: str = "all") -> Search:
        title = f"search {name}" if variant == "all" else f"search {variant}, {name}"
        return search(
            self.maps if variant == "all" else self.maps.with_features(variant),
            grid,
            f"search-{variant}",
            self.cache,
            seed=self.seed,
            jobs=self.jobs,
            progress=partial(self.tell, title),
        )

    def judged(
        self, tests: Sequence[LabelledMap], parameters: ClassifierParameters, title: str
    ) -> tuple[Judged, ...]:
        show = partial(self.tell, title)
        results = judged(self.maps, tests, parameters, self.cache, seed=self.seed, progress=show)
        return tuple(Judged(*pair) for pair in zip(tests, results, strict=True))


def reproduce(
    features: Sequence[MapFeatures],
    plans: Plans,
    settings: Settings = FULL_SETTINGS,
    cache: Cache | None = None,
    *,
    seed: int = 0,
    jobs: int = 1,
    tell: Progress | None = None,
) -> Reproduction:
    """Run all experiments.

    Parameters
    ----------
    features : sequence of MapFeatures
        Of `roomseg.feature_set.read_feature_set`.
    plans : mapping
        Floor plans by environment, for figures.
    settings : Settings
    cache : Cache, optional
        Where results are kept; a stopped reproduction goes on from there.
    seed : int
        For the starts of k-means.
    jobs : int
        Processes for the searches.
    tell : callable, optional
        Called with (what, done, total).

    Raises
    ------
    FormatError
        If there are fewer than two environments.
    """
    lintels = passageway_parameters(
        [item for item in features if part_of(item.labelled) == "reference"]
    )
    maps = Maps.of(features, lintels.best)
    work = _Work(maps, settings, cache or Cache(), seed, jobs, tell or (lambda *_: None))
    edges, single = edge_statistics(maps.reference), single_features(maps.reference)
    selection = _selection(work)
    best = selection.best
    found = Segmentations(work.judged(maps.reference, best, "segmentations"))
    partial_features = _partial_features(work, selection, found)
    tests = AdditionalTests(
        work.judged(maps.new, best, "new runs"),
        work.judged(maps.novel, best, "additional place"),
        found,
    )
    counts = room_counts(maps, best, work.cache)
    sections = (
        Section("The maps", (environments_table(maps.reference),)),
        Section("Edges", (edges.table,), (edges.drawing,)),
        Section("Passageway parameters", (lintels.table,), (lintels.drawing,)),
        Section("Single features", (single.table,), (single.drawing,)),
        Section("Parameter selection", selection.tables, selection.drawings, selection.remarks),
        Section("Room counts", (counts.table,), (counts.drawing,), counts.remarks),
        Section("Segmentations", found.tables, found.drawings(plans), found.remarks),
        Section(
            "Partial features",
            partial_features.tables,
            partial_features.drawings(plans),
            partial_features.remarks,
        ),
        Section("Additional tests", tests.tables, tests.drawings(plans), tests.remarks),
    )
    return Reproduction(sections, best, found, lintels.best)


def _selection(work: _Work) -> ParameterSelection:
    spaces = work.settings.selection
    return ParameterSelection(
        spaces, {name: work.search(grid, name) for name, grid in spaces.items()}
    )


def _partial_features(
    work: _Work, selection: ParameterSelection, found: Segmentations
) -> PartialFeatures:
    """Search for each variant in all its spaces."""
    searches = {"default": selection.all}
    spaces: dict[str, Grid] = {}
    for variant, of_variant in work.settings.variants.items():
        first, *others = (work.search(grid, name, variant) for name, grid in of_variant.items())
        for other in others:
            first = first.joined(other)
        searches[variant] = first
        spaces |= of_variant
    return PartialFeatures(spaces, searches, found.maps)
