"""``roomseg train``: train the room-border classifier."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import click

from roomseg.cli.features import chosen_parameters, classifier_options, labelled_maps, subset_option
from roomseg.cli.options import json_option, maps_argument, output_option
from roomseg.cli.output import write_json

EXAMPLE = """\b
Example:
  roomseg train maps/sim*.h5 -o model.skops
  roomseg train maps/*.h5 --features no-camera --C 1 --gamma 0.25 -o plain.skops
"""


@click.command("train", epilog=EXAMPLE)
@maps_argument
@output_option("The model.", default="model.skops")
@subset_option
@classifier_options
@json_option
def command(
    *,
    maps: tuple[Path, ...],
    output: Path,
    subset: str,
    json_file: Path | None,
    **parameters: float,
) -> None:
    """Train the room-border classifier on the edges of all maps together (§2.3).

    The parameters default to the best of the paper's search (Table 6).
    """
    import numpy as np

    from roomseg.classifier import save_model
    from roomseg.evaluation import train_on

    chosen = chosen_parameters(**parameters)
    labelled = labelled_maps(maps, subset)
    model = train_on(labelled, chosen)
    save_model(model, output)
    is_border = np.concatenate([item.is_border for item in labelled])
    predicted = np.concatenate([model.predict(item.features) for item in labelled])
    edges, borders, found = len(is_border), int(is_border.sum()), int((predicted & is_border).sum())
    figures = {
        "maps": [str(path) for path in maps],
        "features": list(model.names),
        "parameters": asdict(chosen),
        "edges": edges,
        "border_edges": borders,
        "border_edges_found": found,
        "false_border_edges": int((predicted & ~is_border).sum()),
    }
    write_json(json_file, figures)
    click.echo(
        f"{output}: trained on {edges} edges of {len(maps)} maps, "
        f"finds {found} of their {borders} border edges, "
        f"and {figures['false_border_edges']} that are none"
    )
