"""Does our world resemble the paper's? Table 1 and Table 3 beside the paper's figures.

Simulates one run in each reference place, renders every image at full size
(464-pixel disc; by default 2 samples per pixel, denoised), computes the edge features, and
prints the statistics over all maps together beside the paper's value and the
accepted range. Finished maps and images are kept; stop and start at will.

    python benchmarks/fidelity.py -o out/fidelity               # about 45 minutes on two cores
    python benchmarks/fidelity.py -o out/fidelity --no-images   # Table 1 only, in a minute
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

# Some files here have the names of packages, which Python would find first.
sys.path[:] = [folder for folder in sys.path if Path(folder) != Path(__file__).resolve().parent]

import click

from roomseg.cli.features import labelled_maps
from roomseg.cli.output import write_table
from roomseg.report import Comparison
from roomseg.report.fidelity import edge_statistics, feature_statistics

PLACES = ("sim3", "sim4", "real3")


def roomseg(*arguments: str) -> None:
    subprocess.run([sys.executable, "-m", "roomseg.cli", *arguments], check=True)


def show(comparison: Comparison) -> None:
    rows = []
    for measure in comparison.measures:
        digits = measure.digits
        accepted = measure.accepted
        rows.append(
            (
                measure.name,
                f"{measure.value:.{digits}f}",
                "" if measure.paper is None else f"{measure.paper:.{digits}f}",
                "" if accepted is None else f"{accepted[0]:.{digits}f}–{accepted[1]:.{digits}f}",
                {None: "", True: "yes", False: "NO"}[measure.agrees],
            )
        )
    write_table(comparison.title, ("", "ours", "paper", "accepted", "within"), rows)


@click.command()
@click.option("-o", "--output", type=click.Path(path_type=Path), default="out/fidelity")
@click.option("--preset", default="quick", show_default=True, help="Render settings.")
@click.option("--no-images", is_flag=True, help="Only what needs no images.")
@click.option("--seed", default=0, show_default=True)
def main(output: Path, preset: str, no_images: bool, seed: int) -> None:
    maps = [output / f"{place}-run1.h5" for place in PLACES]
    for place in PLACES:
        roomseg("simulate", place, "--seed", str(seed), "-o", str(output))
    if not no_images:
        roomseg("render", *map(str, maps), "--preset", preset)
    labelled = labelled_maps(maps, "no-camera" if no_images else "all")
    show(edge_statistics(labelled))
    show(feature_statistics(labelled))


if __name__ == "__main__":
    main()
