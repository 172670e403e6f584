"""``roomseg evaluate``: judge the method, leaving each environment out once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from roomseg.cli.features import (
    chosen_parameters,
    classifier_options,
    labelled_maps,
    origins,
    subset_option,
)
from roomseg.cli.options import json_option, maps_argument, seed_option
from roomseg.cli.output import follow, progress_bar, write_json, write_table

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from roomseg.score_sheet import ScoreSheet

EXAMPLE = """\b
Example:
  roomseg evaluate maps/*.h5 --json figures.json
  roomseg evaluate maps/*.h5 --features no-camera
"""


@click.command("evaluate", epilog=EXAMPLE)
@maps_argument
@subset_option
@classifier_options
@seed_option
@json_option
def command(
    *,
    maps: tuple[Path, ...],
    subset: str,
    seed: int,
    json_file: Path | None,
    **parameters: float,
) -> None:
    """Segment every map with a classifier that has not seen its environment (§2.3.3).

    The score sheet has eight measures of the method, of uniform edge weights
    (§3.3) and of the answer that all is one room: by map, by place, and over
    all maps with 95 % intervals (bootstrap over places). Border edges are
    those between found rooms; the room count is the eigenvalue gap's
    estimate. The maps must come from at least two environments.
    """
    from roomseg.score_sheet import score_sheet

    chosen = chosen_parameters(**parameters)
    labelled = labelled_maps(maps, subset, several_places=True)
    with progress_bar("maps") as bar:
        show = follow(bar, "leave one out")
        show(0, len(labelled))
        sheet = score_sheet(labelled, chosen, seed=seed, progress=show)
    write_json(json_file, _figures(origins(maps), subset, seed, sheet))
    _print(sheet, seed)


def _figures(maps: Sequence[Path], subset: str, seed: int, sheet: ScoreSheet) -> dict[str, Any]:
    evaluation = sheet.evaluation
    results = [
        {
            "map": str(path),
            "environment": result.environment,
            "run": result.run,
            "segmentation": asdict(result.quality),
            "uniform": asdict(result.uniform_quality),
            "borders": asdict(result.borders),
            "scores": {answer: _named(rows[index]) for answer, rows in sheet.scores.items()},
        }
        for index, (path, result) in enumerate(zip(maps, evaluation.results, strict=True))
    ]
    uniform = evaluation.uniform_impurity
    return {
        "features": subset,
        "names": list(evaluation.names),
        "parameters": asdict(evaluation.parameters),
        "seed": seed,
        "mean_impurity": evaluation.mean_impurity,
        "median_impurity": evaluation.median_impurity,
        "uniform_mean_impurity": float(uniform.mean()),
        "maps": results,
        "places": {
            place: {answer: _named(sheet.of_place(answer, place)) for answer in sheet.scores}
            for place in sheet.places
        },
        "overall": {answer: _overall(sheet, answer, seed) for answer in sheet.scores},
    }


def _named(row: NDArray[np.float64]) -> dict[str, float]:
    """Values by the names of the measures."""
    from roomseg.score_sheet import MEASURES

    return dict(zip(MEASURES, row.tolist(), strict=True))


def _overall(sheet: ScoreSheet, answer: str, seed: int) -> dict[str, Any]:
    """Means over all maps and their intervals."""
    import numpy as np

    low, high = sheet.intervals(answer, np.random.default_rng(seed))
    mean = _named(sheet.scores[answer].mean(axis=0))
    limits = zip(_named(low).items(), _named(high).values(), strict=True)
    return {
        name: {"mean": mean[name], "interval": [least, greatest]}
        for (name, least), greatest in limits
    }


HEADS = (
    "impurity %",
    "adjusted Rand",
    "V-measure",
    "mean IoU",
    "room F1",
    "border precision",
    "recall",
    "room count error",
)


def _print(sheet: ScoreSheet, seed: int) -> None:
    title = "Each environment left out of training once: the method"
    results = sheet.evaluation.results
    rows = [
        (f"{result.environment} {result.run}", *_written(row))
        for result, row in zip(results, sheet.scores["method"], strict=True)
    ]
    write_table(title, ("map", *HEADS), rows)
    rows = [
        (f"{place}, {answer}", *_written(sheet.of_place(answer, place)))
        for place in sheet.places
        for answer in sheet.scores
    ]
    write_table("By place", ("place", *HEADS), rows)
    rows = []
    for answer in sheet.scores:
        figures = _overall(sheet, answer, seed)
        rows.append((answer, *(_with_interval(name, of) for name, of in figures.items())))
    write_table("All maps: mean, and 95 % interval over places", ("answer", *HEADS), rows)


def _written(row: NDArray[np.float64]) -> list[str]:
    return [_one(name, value) for name, value in _named(row).items()]


def _one(name: str, value: float) -> str:
    if name == "impurity":
        return f"{100 * value:.2f}"
    return f"{value:.2f}" if name == "room_count_error" else f"{value:.3f}"


def _with_interval(name: str, figures: dict[str, Any]) -> str:
    low, high = (_one(name, limit) for limit in figures["interval"])
    return f"{_one(name, figures['mean'])} ({low}–{high})"
