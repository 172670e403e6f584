"""Bring maps, plans, images and results together for a report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from importlib.metadata import version
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from dataset import MapFile, read_map
from roomseg.classifier import ClassifierParameters
from roomseg.evaluation import Evaluation
from roomseg.evaluation import MapResult as Judged
from roomseg.labelled_map import LabelledMap
from roomseg.parameter_search import Search
from roomseg.report import (
    Comparison,
    Fact,
    LintelView,
    MapResult,
    Measure,
    Place,
    Report,
    search_lintel,
    take_snapshot,
)
from roomseg.report.contents import PAPER_CLASSIFIER
from roomseg.report.fidelity import edge_statistics, feature_statistics, roc_curves
from scenes import apartment_from_json, floor_area, floor_region, obstacles

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from dataset import TopoMap
    from scenes import Apartment

__all__ = ["assemble"]

SNAPSHOTS = 4
"""Example images per place."""


def assemble(
    paths: Sequence[Path],
    labelled: Sequence[LabelledMap],
    evaluation: Evaluation,
    searched: Search,
) -> Report:
    """Make the report of a parameter search and of its best evaluation.

    Parameters
    ----------
    paths : sequence of Path
        Map files with images and scenes; maps of a place follow each other.
    labelled : sequence of LabelledMap
        The same maps, in the same order.
    evaluation : Evaluation
        Of these maps, with the best parameters.
    searched : Search
        What else was tried.

    Returns
    -------
    Report
    """
    rows = zip(paths, labelled, evaluation.results, strict=True)
    places = []
    for _, members in groupby(rows, key=lambda row: row[2].environment):
        of_place = list(members)
        results = tuple(_result(*row) for row in of_place)
        places.append(_place(of_place[0][0], results))
    curves = roc_curves(labelled)
    return Report(
        title="Room segmentation",
        created=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        software=f"roomseg {version('roomseg')}",
        places=tuple(places),
        description=(
            "Each place was segmented by a classifier trained on the maps of the other places "
            "(leave one environment out), with the parameters that gave the lowest mean impurity."
        ),
        comparisons=(
            edge_statistics(labelled),
            _search_table(searched),
            feature_statistics(labelled),
        ),
        roc_without_images=curves[:2],
        roc_with_images=curves[2:],
    )


def _search_table(searched: Search) -> Comparison:
    """Mean impurity of every combination, best first (Table 5)."""
    paper = ClassifierParameters()
    measures = tuple(
        Measure(
            f"C = 2^{np.log2(tried.C):g}, γ = 2^{np.log2(tried.gamma):g}",
            100.0 * float(searched.mean[index]),
            100.0 * PAPER_CLASSIFIER.mean if tried == paper else None,
            digits=2,
        )
        for index, tried in ((index, searched.combinations[index]) for index in searched.order)
    )
    note = (
        "The paper's figure is for its 31 maps. The same maps chose the best row here, and "
        "neighbouring rows differ much: with so few maps it is an optimistic figure."
    )
    return Comparison("Parameter search: mean impurity × 100 (Table 5)", measures, note)


def _result(path: Path, item: LabelledMap, judged: Judged) -> MapResult:
    """What is shown of one map."""
    topomap = read_map(path)
    return MapResult(
        topomap=topomap,
        kept=item.features.graph.edges,
        border=judged.predicted,
        room=judged.labels,
        uniform_room=judged.uniform_labels,
        impurity=judged.quality.impurity,
        uniform_impurity=judged.uniform_quality.impurity,
        facts=_run_facts(topomap),
    )


def _run_facts(topomap: TopoMap) -> tuple[Fact, ...]:
    """Coverage and effort of a simulated run; nothing for a real robot's."""
    from simulator import coverage_report

    if topomap.scene is None:
        return ()
    report = coverage_report(topomap, apartment_from_json(topomap.scene))
    return (
        Fact("coverage", f"{100 * report.coverage:.1f} %", "within 20 cm of the path"),
        Fact("path", f"{report.path_length:.0f} m"),
    )


def _place(path: Path, results: tuple[MapResult, ...]) -> Place:
    """A place as its first map shows it."""
    with MapFile(path) as file:
        nodes = _spread(file.done)
        camera = file.topomap.camera
        snapshots = tuple(take_snapshot(node, file.image(node), camera) for node in nodes)
        lintel = _clearest_lintel(file)
        scene = file.topomap.scene
        name = file.topomap.environment
    place = Place(name=name, maps=results, snapshots=snapshots, lintel=lintel)
    return place if scene is None else _with_plan(place, apartment_from_json(scene))


def _with_plan(place: Place, apartment: Apartment) -> Place:
    return replace(
        place,
        description=apartment.description,
        outlines=obstacles(apartment),
        floor=floor_region(apartment),
        base_station=apartment.start.position,
        facts=(
            Fact("floor area", f"{floor_area(apartment):.1f} m²"),
            Fact("lighting", apartment.lighting.source),
            Fact("passageway contrast", apartment.passageway_contrast),
        ),
    )


def _spread(done: NDArray[np.bool_]) -> list[int]:
    """Nodes with images, spread evenly over the run."""
    nodes = np.flatnonzero(done)
    middle = (np.arange(SNAPSHOTS) + 0.5) / SNAPSHOTS
    return [int(node) for node in nodes[(middle * len(nodes)).astype(int)]]


def _clearest_lintel(file: MapFile) -> LintelView | None:
    """The lintel search with the highest histogram bin among the ends of true border edges."""
    truth = file.topomap.ground_truth
    if truth is None:
        return None
    nodes = np.unique(file.topomap.edges[truth.edge_is_border])
    views = [search_lintel(int(node), file.image(int(node)), file.topomap.camera) for node in nodes]
    return max(views, key=lambda view: view.histogram.max(), default=None)
