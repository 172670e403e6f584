"""``roomseg evaluate``: judge the method, leaving each environment out once."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from roomseg.cli.features import (
    chosen_parameters,
    classifier_options,
    labelled_maps,
    subset_option,
)
from roomseg.cli.options import json_option, maps_argument, seed_option
from roomseg.cli.output import follow, progress_bar, write_json, write_table

if TYPE_CHECKING:
    from roomseg.evaluation import Evaluation

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

    Impurity (Eq. 18) is the fraction of nodes outside the main room of their
    cluster; beside it stands that of uniform edge weights (§3.3). The maps
    must come from at least two environments.
    """
    from roomseg.evaluation import leave_one_environment_out

    _check_environments(maps)
    chosen = chosen_parameters(**parameters)
    labelled = labelled_maps(maps, subset)
    with progress_bar("maps") as bar:
        show = follow(bar, "leave one out")
        show(0, len(labelled))
        evaluation = leave_one_environment_out(labelled, chosen, seed=seed, progress=show)
    write_json(json_file, _figures(maps, subset, seed, evaluation))
    _print(evaluation)


def _check_environments(maps: tuple[Path, ...]) -> None:
    """Refuse maps of one place, before minutes are spent on their images."""
    from dataset import RoomsegError, read_map

    names = {read_map(path).environment for path in maps}
    if len(names) < 2:
        raise RoomsegError(
            f"maps: all of the environment {names.pop()!r}, expected at least 2 environments "
            "to leave one out"
        )


def _figures(
    maps: tuple[Path, ...], subset: str, seed: int, evaluation: Evaluation
) -> dict[str, Any]:
    results = [
        {
            "map": str(path),
            "environment": result.environment,
            "run": result.run,
            "segmentation": asdict(result.quality),
            "uniform": asdict(result.uniform_quality),
            "borders": asdict(result.borders),
        }
        for path, result in zip(maps, evaluation.results, strict=True)
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
    }


def _print(evaluation: Evaluation) -> None:
    columns = ("map", "impurity %", "uniform %", "adjusted Rand", "border precision", "recall")
    rows = [
        (
            f"{result.environment} {result.run}",
            f"{100 * result.quality.impurity:.2f}",
            f"{100 * result.uniform_quality.impurity:.2f}",
            f"{result.quality.adjusted_rand:.3f}",
            f"{result.borders.precision:.3f}",
            f"{result.borders.recall:.3f}",
        )
        for result in evaluation.results
    ]
    uniform = f"{100 * evaluation.uniform_impurity.mean():.2f}"
    rows.append(("mean", f"{100 * evaluation.mean_impurity:.2f}", uniform, "", "", ""))
    write_table("Each environment left out of training once", columns, rows)
