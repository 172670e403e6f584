"""``roomseg train``: train the room-border classifier."""

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
from roomseg.cli.options import jobs_option, json_option, maps_argument, output_option
from roomseg.cli.output import counted, follow, progress_bar, write_json

if TYPE_CHECKING:
    from roomseg.classifier import ClassifierParameters
    from roomseg.labelled_map import LabelledMap

# Names of `roomseg.experiments.grids`, which is only imported when it is needed.
SPACES = ("coarse", "basic", "full", "fine", "extrafine", "no-camera", "no-ceiling")
CHOSEN = {"c": "--C", "gamma": "--gamma", "class_weight": "--w", "rho": "--rho"}

EXAMPLE = """\b
Example:
  roomseg train maps/sim*.h5 -o model.skops
  roomseg train maps/*.h5 --features no-camera --C 1 --gamma 0.25 -o plain.skops
  roomseg train features.h5 --search full --jobs 2 -o best.skops
"""


@click.command("train", epilog=EXAMPLE)
@maps_argument
@output_option("The model.", default="model.skops")
@subset_option
@classifier_options
@click.option(
    "--search",
    "space",
    type=click.Choice(SPACES),
    help="Choose C, γ, w and ρ in this space (Tables 4 and 9), leaving each environment out once.",
)
@jobs_option
@json_option
@click.pass_context
def command(
    ctx: click.Context,
    /,
    *,
    maps: tuple[Path, ...],
    output: Path,
    subset: str,
    space: str | None,
    jobs: int,
    json_file: Path | None,
    **parameters: float,
) -> None:
    """Train the room-border classifier on the edges of all maps together (§2.3).

    Maps with their images, or a feature set by `roomseg features`.

    The parameters default to the best of the paper's search (Table 6). A search for better ones
    keeps what is done in OUTPUT.search: call a stopped command again.
    """
    import numpy as np

    from roomseg.classifier import reduced, save_model
    from roomseg.evaluation import train_on

    _refuse_both(ctx, space)
    chosen = chosen_parameters(**parameters)
    labelled = labelled_maps(maps, subset, several_places=space is not None)
    figures: dict[str, Any] = {"maps": [str(path) for path in origins(maps)]}
    if space is not None:
        chosen, figures["search"] = _searched(labelled, space, jobs, output)
    values = np.concatenate([item.features.values for item in labelled])
    model = reduced(train_on(labelled, chosen), values)
    save_model(model, output)
    is_border = np.concatenate([item.is_border for item in labelled])
    predicted = np.concatenate([model.predict(item.features) for item in labelled])
    edges, borders, found = len(is_border), int(is_border.sum()), int((predicted & is_border).sum())
    figures |= {
        "features": list(model.names),
        "parameters": asdict(chosen),
        "edges": edges,
        "border_edges": borders,
        "border_edges_found": found,
        "false_border_edges": int((predicted & ~is_border).sum()),
    }
    write_json(json_file, figures)
    click.echo(
        f"{output}: trained on {edges} edges of {counted(len(labelled), 'map')}, "
        f"finds {found} of their {borders} border edges, "
        f"and {figures['false_border_edges']} that are none"
    )


def _refuse_both(ctx: click.Context, space: str | None) -> None:
    """A search chooses what these options would give (RoomsegError)."""
    from dataset import RoomsegError

    default = click.core.ParameterSource.DEFAULT
    given = [CHOSEN[name] for name in CHOSEN if ctx.get_parameter_source(name) is not default]
    if space is not None and given:
        raise RoomsegError(f"{given[0]}: given, expected none where --search chooses it")


def _searched(
    labelled: Sequence[LabelledMap], space: str, jobs: int, output: Path
) -> tuple[ClassifierParameters, dict[str, Any]]:
    """Search; the best parameters, and what to tell of it."""
    from roomseg.experiments import Cache, grids
    from roomseg.parameter_search import search_parameters

    combinations = getattr(grids, space.replace("-", "_").upper()).combinations()
    with progress_bar("parts") as bar:
        found = search_parameters(
            labelled,
            combinations,
            jobs=jobs,
            cache=Cache(output.with_suffix(".search")),
            progress=follow(bar, f"search {space}"),
        )
    best = found.best
    click.echo(
        f"best of {len(combinations)}: C = {best.C:g}, γ = {best.gamma:g}, "
        f"w = {best.class_weight:g}, ρ = {best.rho:g}, "
        f"mean impurity {100 * found.lowest:.2f} % of the maps that chose it"
    )
    return best, {"space": space, "mean_impurity": found.lowest}
