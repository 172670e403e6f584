"""How long does a parameter search take? Beside the plain loop over scikit-learn's estimators.

Both judge the same combinations, a random subset of Table 4's full space, leaving the same
places out. The plain loop trains `StandardScaler` and `SVC` for every combination and place, and
segments every map with the best by Eq. 22 of a hundred runs of scikit-learn's `KMeans` on the
embedding. The search
shares what combinations have in common, so it is asked for all ρ of whole paths along C, for
which γ, w and the left-out place are drawn; the plain loop is measured for some combinations of
these paths. Times are CPU seconds of one process with one thread.

    python benchmarks/search.py features.h5
    python benchmarks/search.py features.h5 --full --jobs 2
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

# Some files here have the names of packages, which Python would find first.
sys.path[:] = [folder for folder in sys.path if Path(folder) != Path(__file__).resolve().parent]

import click
import numpy as np
from sklearn.cluster import KMeans
from threadpoolctl import threadpool_limits

from roomseg.classifier import ClassifierParameters
from roomseg.cli.output import write_table
from roomseg.evaluation import folds, map_rng, train_on
from roomseg.experiments import Cache
from roomseg.experiments.grids import FULL
from roomseg.feature_set import read_feature_set
from roomseg.labelled_map import LabelledMap
from roomseg.metrics import impurity
from roomseg.parameter_search import Part, judge_part, search_parameters
from roomseg.segmentation import affinity_of, edge_weights, segment
from roomseg.spectral import embedding

Maps = list[LabelledMap]
PLACES = 8
COMBINATIONS = len(FULL.combinations())


@dataclass
class Comparison:
    """What was measured; one entry for each combination that the plain loop did."""

    gamma: list[float] = field(default_factory=list)
    ours: list[float] = field(default_factory=list)
    """CPU seconds per combination and place."""
    theirs: list[float] = field(default_factory=list)
    unequal: list[float] = field(default_factory=list)
    """Share of the edges."""
    impurity: list[tuple[float, ...]] = field(default_factory=list)


def plain(item: LabelledMap, predicted: np.ndarray, rho: float) -> float:
    """Impurity by the best by Eq. 22 of a hundred runs of scikit-learn's k-means."""
    graph = item.features.graph
    affinity = affinity_of(graph, edge_weights(graph, predicted, rho))
    rows = embedding(affinity, item.room_count)[1]
    best, lowest = np.zeros(len(rows), np.int32), np.inf
    for seed in range(100):
        found = KMeans(item.room_count, n_init=1, max_iter=100, tol=0.0, random_state=seed).fit(
            rows
        )
        summed = np.linalg.norm(rows - found.cluster_centers_[found.labels_], axis=1).sum()
        if summed < lowest:
            best, lowest = found.labels_.astype(np.int32), summed
    return impurity(best, item.room)


def compare(part: Part, asked: list[int], found: Comparison) -> None:
    """Measure one part of a search, and the plain loop for some of its combinations."""
    begin = time.process_time()
    ours, predicted = judge_part(part, 0)
    spent = (time.process_time() - begin) / len(part.combinations)
    for index in asked:
        parameters = part.combinations[index]
        begin = time.process_time()
        model = train_on(part.training, parameters)
        theirs = [model.predict(item.features) for item in part.test]
        pairs = zip(part.test, theirs, strict=True)
        rooms = [plain(item, edges, parameters.rho) for item, edges in pairs]
        found.theirs.append(time.process_time() - begin)
        found.ours.append(spent)
        found.gamma.append(float(np.log2(parameters.gamma)))
        found.unequal.append(float((np.concatenate(theirs) != predicted[index]).mean()))
        same = [
            impurity(segment(each.features.graph, edges, each.room_count, map_rng(0, each),
                             parameters.rho), each.room)
            for each, edges in zip(part.test, theirs, strict=True)
        ]  # fmt: skip
        impurities = (float(np.mean(each)) for each in (ours[index], same, rooms))
        found.impurity.append(tuple(impurities))
        print(
            f"log2 C {np.log2(parameters.C):g}, log2 γ {found.gamma[-1]:g}: "
            f"{found.theirs[-1]:.1f} s and {spent:.3f} s, unequal {found.unequal[-1]:.5f}, "
            f"impurity {found.impurity[-1]}",
            flush=True,
        )


def drawn_part(
    maps: Maps, log2_gamma: float, costs: tuple[float, ...], rng: np.random.Generator
) -> Part:
    """One place left out, w drawn, all ρ, along C."""
    training, test = folds(maps)[rng.integers(len(folds(maps)))]
    weight = float(rng.choice(FULL.class_weight))
    combinations = tuple(
        ClassifierParameters(2.0**c, 2.0**log2_gamma, weight, rho)
        for c in costs
        for rho in FULL.rho
    )
    rows = np.arange(len(combinations))
    known, new = (tuple(maps[i] for i in indices) for indices in (training, test))
    return Part(known, new, combinations, rows, np.array(test))


def report(found: Comparison) -> None:
    """Print means; γ counts alike, whatever was measured of it."""
    gammas = sorted(set(found.gamma))
    of = [np.array(found.gamma) == gamma for gamma in gammas]
    ours, theirs = (
        np.array([np.array(values)[at].mean() for at in of])
        for values in (found.ours, found.theirs)
    )
    judged = 100.0 * np.array(found.impurity)
    table = [
        (f"{g:g}", f"{a:.3f}", f"{b:.1f}", f"{b / a:.0f}")
        for g, a, b in zip(gammas, ours, theirs, strict=True)
    ]
    write_table(
        "CPU seconds per combination and place", ("log2 γ", "search", "loop", "ratio"), table
    )
    minutes = ours.mean() * PLACES * COMBINATIONS / 60.0
    rows = (
        ("combinations per CPU minute: search", f"{60.0 / (ours.mean() * PLACES):.1f}"),
        ("the plain loop", f"{60.0 / (theirs.mean() * PLACES):.2f}"),
        ("ratio of CPU times", f"{theirs.mean() / ours.mean():.0f}"),
        ("equal decisions, least share of edges", f"{1.0 - max(found.unequal):.5f}"),
        ("mean", f"{1.0 - np.mean(found.unequal):.5f}"),
        ("mean impurity × 100: search", f"{judged[:, 0].mean():.3f}"),
        ("libsvm's decisions, our k-means", f"{judged[:, 1].mean():.3f}"),
        ("the plain loop", f"{judged[:, 2].mean():.3f}"),
        ("Table 4's full space, CPU minutes, extrapolated", f"{minutes:.0f}"),
        ("on two quiet cores, minutes", f"{minutes / 2.0:.0f}"),
    )
    write_table("Parameter search", ("", "measured"), rows)


@click.command()
@click.argument("features", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--gammas", default="-15,-11,-7,-3,-1", show_default=True, help="log2 γ, compared.")
@click.option("--costs", default="-9,-7,-5,-3,-1,1,3,5,7,9", show_default=True, help="log2 C.")
@click.option("--each", default=1, show_default=True, help="Combinations of the loop for each γ.")
@click.option("--seed", default=0, show_default=True)
@click.option("--full", is_flag=True, help="Search Table 4's full space, and say how long it took.")
@click.option("--jobs", default=2, show_default=True, help="Processes for --full.")
@click.option("--cache", type=click.Path(path_type=Path), help="Folder in which --full goes on.")
def main(
    features: Path,
    gammas: str,
    costs: str,
    each: int,
    seed: int,
    full: bool,
    jobs: int,
    cache: Path | None,
) -> None:
    maps = [item.labelled for item in read_feature_set(features)]
    print(f"{len(maps)} maps, {sum(len(item.is_border) for item in maps)} edges")
    if full:
        begin = time.monotonic()
        found = search_parameters(maps, FULL.combinations(), jobs=jobs, cache=Cache(cache))
        print(f"full space: {(time.monotonic() - begin) / 60.0:.1f} min on {jobs} processes")
        print(f"best: {found.best}, mean impurity × 100 {100.0 * found.lowest:.2f}")
        return
    rng, measured = np.random.default_rng(seed), Comparison()
    along = tuple(float(value) for value in costs.split(","))
    with threadpool_limits(1):
        small = drawn_part(maps[:1] + maps[-1:], -7.0, (-3.0,), rng)
        judge_part(small, 0)  # compiles, or loads what is compiled
        for gamma in (float(value) for value in gammas.split(",")):
            part = drawn_part(maps, gamma, along, rng)
            asked = rng.choice(len(part.combinations), each, replace=False).tolist()
            compare(part, asked, measured)
    report(measured)


if __name__ == "__main__":
    main()
