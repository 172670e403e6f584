"""Does our world resemble the paper's? Table 1 and Table 3 beside the paper's figures.

Cleans the 31 maps of the reference set and prints what is known of their edges without
images, beside the paper's value, the accepted range, and the least and greatest value of a
single place.

With images: 31 maps have some 35,000, but an area under the ROC curve does not depend on
how many edges there are of either kind. So one map of each place is sampled: all its border
edges and as many others, drawn by a seed, as ``--within`` says; only the images at their
ends are rendered. Every edge counts as many times as there are edges of its kind in its
map, and maps of its place, for each that was drawn. The interval is the middle 95 % of
bootstrap samples of the edges, kind by kind and place by place; what other places would
give it does not say. Edge length and L of the same sample stand beside those of all edges,
so that one sees what the sampling does.

Finished maps and images are kept; stop and start at will.

    python benchmarks/fidelity.py -o out/fidelity               # an hour on two cores
    python benchmarks/fidelity.py -o out/fidelity --no-images   # minutes
"""

from __future__ import annotations

import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

# Some files here have the names of packages, which Python would find first.
sys.path[:] = [folder for folder in sys.path if Path(folder) != Path(__file__).resolve().parent]

import click
import numpy as np
from numpy.typing import NDArray

from dataset import MapFile, TopoMap, read_map
from render import preset_named, render_map
from roomseg.cli.features import labelled_maps
from roomseg.cli.output import follow, progress_bar, write_table
from roomseg.features import FEATURES, edge_features
from roomseg.ground_truth import known_truth
from roomseg.labelled_map import LabelledMap
from roomseg.metrics import feature_quality
from roomseg.report import Comparison
from roomseg.report.fidelity import edge_statistics, feature_statistics
from simulator import REFERENCE_RUNS

MAPS_OF = Counter(run.place for run in REFERENCE_RUNS)
Statistics = Callable[[Sequence[LabelledMap]], Comparison]


def by_place(maps: Sequence[LabelledMap]) -> list[list[LabelledMap]]:
    """The maps of each place."""
    return [[item for item in maps if item.environment == place] for place in MAPS_OF]


def show(comparison: Comparison, column: str, beside: Sequence[str]) -> None:
    """Print ours, the paper's and the accepted range, with a column of notes."""
    rows = []
    for measure, note in zip(comparison.measures, beside, strict=True):
        digits, accepted = measure.digits, measure.accepted
        rows.append(
            (
                measure.name,
                f"{measure.value:.{digits}f}",
                note,
                "" if measure.paper is None else f"{measure.paper:.{digits}f}",
                "" if accepted is None else f"{accepted[0]:.{digits}f}–{accepted[1]:.{digits}f}",
                {None: "", True: "yes", False: "NO"}[measure.agrees],
            )
        )
    write_table(comparison.title, ("", "ours", column, "paper", "accepted", "within"), rows)


def spread(statistics: Statistics, maps: Sequence[LabelledMap]) -> list[str]:
    """The least and the greatest value of a single place, for each measure."""
    tables = [statistics(group).measures for group in by_place(maps)]
    return [
        f"{min(m.value for m in same):.{same[0].digits}f}–"
        f"{max(m.value for m in same):.{same[0].digits}f}"
        for same in zip(*tables, strict=True)
    ]


def sampled(
    path: Path, item: LabelledMap, within: int, seed: int
) -> tuple[TopoMap, NDArray[np.float64]]:
    """A map with a sample of its edges, and how many edges of the set each stands for."""
    border = np.flatnonzero(item.is_border)
    others = np.flatnonzero(~item.is_border)
    drawn = np.random.default_rng(seed).permutation(others)[:within]
    chosen = np.sort(np.concatenate([border, drawn]))
    topomap, kept = read_map(path), item.features.graph.kept[chosen]
    truth = known_truth(topomap)
    topomap = replace(
        topomap,
        edges=topomap.edges[kept],
        ground_truth=replace(truth, edge_is_border=truth.edge_is_border[kept]),
    )
    weight = np.where(item.is_border[chosen], 1.0, len(others) / max(1, len(drawn)))
    return topomap, MAPS_OF[topomap.environment] * weight


class Sample:
    """The images of a map file, with the edges of a sample."""

    def __init__(self, file: MapFile, topomap: TopoMap) -> None:
        # Rendering may have given the map another camera.
        self.topomap = replace(topomap, camera=file.topomap.camera)
        self.done = file.done
        self.image = file.image


def render_sample(path: Path, topomap: TopoMap, preset: str) -> LabelledMap:
    """Render what the sample lacks, and compute its features."""
    nodes = np.unique(topomap.edges).tolist()
    with progress_bar("images") as bar:
        show_images = follow(bar, path.name)
        render_map(path, preset=preset_named(preset), nodes=nodes, on_progress=show_images)
    with MapFile(path) as file:
        sample = Sample(file, topomap)
        return LabelledMap.of(sample.topomap, edge_features(sample))


def intervals(
    maps: Sequence[LabelledMap], weights: Sequence[NDArray[np.float64]], seed: int
) -> list[str]:
    """The middle 95 % of the bootstrap's areas under the curve, and of J, for each measure."""
    rng = np.random.default_rng(seed)
    strata, start = [], 0
    for item in maps:
        strata += [start + np.flatnonzero(item.is_border == kind) for kind in (False, True)]
        start += len(item.is_border)
    border = np.concatenate([item.is_border for item in maps])
    values = np.concatenate([item.features.values for item in maps])
    weight = np.concatenate(weights)
    found = []
    for _ in range(500):
        drawn = np.concatenate([rng.choice(group, len(group)) for group in strata])
        row = [
            feature_quality(values[drawn, column], border[drawn], weight[drawn])
            for column in range(len(FEATURES))
        ]
        found.append([figure for q in row for figure in (q.auc, q.youden)])
    low, high = np.percentile(found, (2.5, 97.5), axis=0)
    return [f"{a:.3f}–{b:.3f}" for a, b in zip(low, high, strict=True)]


@click.command()
@click.option("-o", "--output", type=click.Path(path_type=Path), default="out/fidelity")
@click.option("--preset", default="fast", show_default=True, help="Render settings.")
@click.option("--no-images", is_flag=True, help="Only what needs no images.")
@click.option("--within", default=150, show_default=True, help="Within-room edges per place.")
@click.option("--seed", default=0, show_default=True, help="Of the sample.")
@click.option("--jobs", type=click.IntRange(1), default=2, show_default=True)
def main(*, output: Path, preset: str, no_images: bool, within: int, seed: int, jobs: int) -> None:
    command = ["simulate", "--reference-set", "-o", str(output), "--jobs", str(jobs)]
    subprocess.run([sys.executable, "-m", "roomseg.cli", *command], check=True)
    maps = labelled_maps([output / run.file_name for run in REFERENCE_RUNS], "no-camera")
    places = "least–greatest place"
    show(edge_statistics(maps), places, spread(edge_statistics, maps))
    show(feature_statistics(maps), places, spread(feature_statistics, maps))
    if no_images:
        return
    first = [group[0] for group in by_place(maps)]
    samples = [
        sampled(output / f"{item.environment}-{item.run}.h5", item, within, seed) for item in first
    ]
    images = sum(len(np.unique(topomap.edges)) for topomap, _ in samples)
    click.echo(f"{images} images of {len(samples)} maps")
    rendered = [
        render_sample(output / f"{topomap.environment}-{topomap.run}.h5", topomap, preset)
        for topomap, _ in samples
    ]
    weights = [weight for _, weight in samples]
    comparison = feature_statistics(rendered, np.concatenate(weights))
    edges = sum(len(item.is_border) for item in rendered)
    title = f"{comparison.title}: a sample of {edges} edges, {images} images, {preset}"
    show(replace(comparison, title=title), "95 %", intervals(rendered, weights, seed))


if __name__ == "__main__":
    main()
